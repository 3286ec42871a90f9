"""Where a mechanism rests, or turns uniformly: Q - M a = C^T mu, Phi = 0, s' = 0, for all runs at once.

By pseudo-transient continuation (Kelley, Keyes 1998, SIAM J. Numer. Anal. 35(2):508-523): implicit steps of a motion
that is damped so strongly that velocities follow forces, sigma dq = Q - M a - C^T mu. While forces are large steps are
short and lead downhill, away from unstable equilibria; sigma falls with the forces, and the last steps are Newton's,
on the group of all joints with its constraints. A step is halved where it leads to what is not finite.

At rest v = a = 0. Relative to a uniform rotation v and a are those of bodies that turn with it (`uniform_rotation`),
and what drivers ask for beside that; both follow the places, and so do the derivatives of the forces.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from lienumba.compiler.dense.decompositions import Rows, product, solved, symmetric_values, turned, unit_rows
from lienumba.integrators.codes import FOUND, NONE_FOUND, NOT_ISOLATED, UNSTABLE
from lienumba.integrators.tracing.linear.equations import STATE, UNKNOWN, Equations, Linear
from lienumba.integrators.tracing.linear.freedoms import GluedTracer
from lienumba.integrators.tracing.linear.stability import Near, stability
from lienumba.integrators.tracing.linear.standing import REDUNDANT, Standing
from lienumba.integrators.tracing.linear.unbalanced import PLACES, analytic, unbalanced
from lienumba.integrators.tracing.linear.uniform_rotation import Carried, carried
from lienumba.integrators.tracing.template import split
from lienumba.integrators.tracing.tracer import Posture
from lienumba.mechanics.mechanism.massless import with_lent_masses
from lienumba.mechanics.mechanism.model import Model
from lienumba.mechanics.mechanism.model_numbers import map_numbers
from lienumba.mechanics.mechanism.tables import RunNumbers
from lienumba.mechanics.system import constraints
from lienumba.mechanics.mechanism.kinematics import OFF
from lienumba.mechanics.system.switches import CONTACT, LIMIT
from lienumba.numerics.operations import sqrt

Array = npt.NDArray[Any]
STILL = (0.0, 0.0, 0.0)
LONGEST = 0.2  # rad, and of the size of the mechanism: the most that a step moves
FARTHER = 2.0  # times that, from step to step, while no force changes and something may close
STEPS = 400
AWAY = 60  # steps in a row, each with a larger force: no joint turns so far, something flies away
TO_AND_FRO = 20  # steps in a row, each with the force of the last but one: it will not come to rest
HALVINGS = 12
TURNS = 0.5  # of what forces do in a step: what they may take back at its end
AT_REST = 1e-12  # of what the terms of the rate of a law's state can be: what may be left
GROWS = 4.0  # times the largest rate there was, a step may make of such a rate
DONE = 1e-13  # rad, and of the size: a step of Newton's that is shorter changes nothing
ROUNDING = 1e-9  # of the largest force there was: what may be left where nothing falls any more
QUIET = 1e-12  # rad, and of the size: how far forces may push in a step of Newton's where they are rounding
FAINT = 2e-15  # of the largest force that a constraint carries: what is rounding, of others and of stiffness
SLOW = 0.5  # of the sigma with which forces move as far as a step may be, if K does not hold them
DOWNHILL = 1.5  # times what a step takes that leads downhill
CLOSED = 1e-9  # rad, and of the size: by how much joints may miss each other
SMALL = 1e-12  # of the largest pivot: what counts as 0
TURNING = 2  # eigenvalues that are 0 because nothing says how far, and how fast, all turns
AT_ONCE = 2048  # runs whose stability is judged together
STEADY = 1e-6  # of the largest force there was, and of the speed: what a steady motion may change in a radian
EXACT = 1e-10  # of the terms of a sum that is 0 but for rounding


@dataclass(frozen=True)
class Resting:
    """rows: of the states; status (runs,): FOUND or what else; left (runs,): the largest force along a freedom; growth
    (runs,): of the mode that grows most (1/s)."""

    rows: list[Array]
    status: Array
    left: Array
    growth: Array

    @property
    def found(self) -> Array:
        """Whether each run rests where its rows are (runs,)."""
        return self.status != NONE_FOUND


@dataclass(frozen=True)
class _Held:
    """Phi and Phi' of the rows in use, and Phi of what may close."""

    gaps: Sequence[int]
    inputs = 0

    def model(self, model: Model, t: Any, inputs: Sequence[Any]) -> Model:
        return model

    def outputs(self, model: Model, posture: Posture, mask: list[Any], used: Sequence[int]) -> dict[str, list[Any]]:
        residual, rates = constraints.residual(model, posture.now), constraints.rates(model, posture.now)
        return {
            "positions": [mask[row] * residual[row] for row in used],
            "rates": [mask[row] * rates[row] for row in used],
            "gaps": [residual[row] for row in self.gaps],
        }


def rest(
    tracer: GluedTracer, model: Model, rows: Sequence[Any], runs: int, rotation: Sequence[Any] = STILL,
    driven: bool = False,
) -> Resting:  # fmt: skip
    """The equilibria that runs (of a model with arrays) come to from these states, at t = 0, relative to axes that turn
    with this angular velocity (rad/s, global, floats or arrays) about one through the origin; with the velocities of
    it. driven: what rests gets the least velocities of joints that drivers ask for, too."""
    return _Search(tracer, model, rows, runs, rotation).found(driven)


@dataclass(frozen=True)
class _Motion:
    """Of states: accelerations (runs, n), and how velocities and accelerations change with the places; carried: those
    of the rotation alone."""

    a: Array
    rates_by: Array
    accelerations_by: Array
    carried: Carried


class _Search:
    """state: with all at rest; mu: multipliers of the rows in use (runs, m); held: 1 for those of places, else 0; most
    (runs,): how many rows say something; forces, constraints, constraint_slopes: parts of `equations` that a step needs
    at several places, and which cost far less; fastest (runs, s): the largest rates of laws' states there were."""

    def __init__(
        self, tracer: GluedTracer, model: Model, rows: Sequence[Any], runs: int, rotation: Sequence[Any]
    ) -> None:
        self.tracer, self.model, self.runs = tracer, model, runs
        self.rotation = np.array([np.broadcast_to(np.asarray(x, float), (runs,)) for x in rotation])
        self.turns = (self.rotation != 0.0).any(axis=0)
        first = tracer.augmented.permanent
        gaps = [first + x.first for x in tracer.augmented.switches if x.what in (LIMIT, CONTACT)]
        self.equations = Equations.of(tracer, _Held(gaps))
        self.forces = self.equations.only((), ("along", "laws"))
        self.gaps = self.equations.only((), ("gaps",))
        self.constraints = self.equations.only(("a",), ("rows", "rates"))
        self.constraint_slopes = self.equations.only(("q", "v", "a"), ("rows", "rates"))
        self.tree = tracer.tree(tracer.graph()[1])
        self.rates = tracer.velocity_rows(tracer.graph()[1])
        self.state = np.array([np.broadcast_to(np.asarray(x, float), (runs,)) for x in rows])
        self.state[self.rates] = 0.0
        self.numbers = split(model)[1]
        self.n, self.m = tracer.velocities, len(self.equations.used)
        self.mu, self.fastest = np.zeros((runs, self.m)), np.zeros((runs, len(self.equations.outputs["laws"])))
        every_row = [c for c in constraints.constraints_of(tracer.graph()[1]) for _ in c.kinds]
        sticks = [c.switch is not None and c.switch.what == CONTACT for c in every_row]  # rests where it is
        levels = [c.level != "velocity" or stuck for c, stuck in zip(every_row, sticks, strict=True)]
        self.held = np.array([levels[row] for row in self.equations.used], float)
        self.sizes, self.longest = self._sizes(), np.full(runs, LONGEST)
        self.others, self.most = np.full((2, runs), min(self.m, self.n))
        every = np.arange(runs)  # where it starts the mechanism is closed, and redundant rows say the same
        at = self._at(self.state, np.zeros((runs, self.n)), self.mu, every, self.constraints)
        self.others = self.most = self._rows(at, every)[0].rank
        self.standing = Standing.of(tracer, model, rows, self.equations.used, self.turns)
        self.stands = np.ones(runs, bool)
        self._stand(every[(self.standing.on != OFF).any(axis=0)])

    def _sizes(self) -> Array:
        """What a coordinate is small against (runs, n): 1 rad, or how large the mechanism is (m)."""
        found = np.ones((self.runs, self.n))
        lent = with_lent_masses(self.model).bodies
        own = [sqrt(sum(body.inertia[:3]) / body.mass) for body in lent]
        points = [p for element in (*self.model.joints, *self.model.contacts) for p in element.points or ()]
        reach = [abs(np.asarray(x)) for p in points for x in p]
        reach += [x for contact in self.model.contacts for x in contact.numbers.values()]
        every = [np.broadcast_to(np.asarray(x, float), (self.runs,)) for x in (*own, *reach)]
        size = np.max(every, axis=0)
        for link in self.tree.links:
            shifts = link.move.freedoms == 2 * 3
            for n, rate in enumerate(link.rates):
                if (shifts and n < 3) or not link.move.turns:
                    found[:, rate] = size
        return found

    # ---------------------------------------------------------------- the equations of some runs
    def _of(self, which: Array) -> Model:
        """The model of these runs."""
        part = partial(_part, which=which, runs=self.runs)
        return map_numbers(self.model, lambda x, _: part(x), part)

    def _at(self, state: Array, a: Array, mu: Array, which: Array, equations: Equations) -> Linear:
        numbers = [_part(x, which, self.runs) for x in self.numbers]
        given = [list(state), list(a.T), list(mu.T), numbers]
        if len(which) == 1:  # the same operations on floats take a fraction of the time
            given = [[x.item() if isinstance(x, np.ndarray) else x for x in own] for own in given]
        rows, accelerations, multipliers, numbers = given
        with np.errstate(all="ignore"):
            return equations.at(rows, 0.0, accelerations, multipliers, numbers.__getitem__)

    def _rows(self, at: Linear, which: Array, held: Array | None = None) -> tuple[Rows, Array]:
        """C by the sizes of the coordinates, its rows of length 1; and how long they were (runs, m). held: 1 for each
        row that counts, else 0; by default all do."""
        C = self._sized(at, which)
        C, lengths = unit_rows(C if held is None else C * held[:, None])
        return Rows.of(C, REDUNDANT, self.most[which]), lengths

    def _stand(self, which: Array) -> None:
        """What holds these runs has changed."""
        if not len(which):
            return
        self.standing.write(self.state, which)
        at = self._at(self.state[:, which], np.zeros((len(which), self.n)), self.mu[which], which, self.constraints)
        rows, own = self.standing.free(self._sized(at, which), self.others[which])
        self.most[which] = rows.rank + Rows.of(unit_rows(own)[0], REDUNDANT).rank
        self.longest[which] = LONGEST

    def _sized(self, at: Linear, which: Array) -> Array:
        """C by the sizes of the coordinates."""
        found: Array = -at.dense("rows", "a", len(which)) * self.sizes[which][:, None, :]
        return found

    def with_rates(self, state: Array, rates: Array) -> Array:
        found = state.copy()
        found[self.rates] = rates.T
        return found

    def asked(self, state: Array, which: Array) -> Array:
        """The least change of velocities (runs, n) that fulfils the constraints."""
        runs = len(which)
        at = self._at(state, np.zeros((runs, self.n)), np.zeros((runs, self.m)), which, self.constraints)
        rows, lengths = self._rows(at, which)
        return -rows.least(at.vector("rates", runs) / lengths) * self.sizes[which]

    def _moving(self, state: Array, which: Array) -> tuple[Array, _Motion | None]:
        """The states with the velocities of the rotation, and the motion; None at rest."""
        turns = self.turns[which]
        if not turns.any():
            return state, None
        runs, sizes, model = len(which), self.sizes[which], self._of(which)
        with np.errstate(all="ignore"):
            own = carried(self.tracer.tree(model), list(state[: self.tree.state]), self.rotation[:, which])
        state = self.with_rates(state, own.rates)
        state = self.with_rates(state, np.where(turns[:, None], own.rates + self.asked(state, which), 0.0))
        at = self._at(state, own.accelerations, np.zeros((runs, self.m)), which, self.constraint_slopes)
        rows, lengths = self._rows(at, which)

        def least(b: Array) -> Array:
            found = rows.least(b / lengths[:, :, None]) * sizes[:, :, None]
            return np.where(turns[:, None, None], found, 0.0)

        a = own.accelerations + least(at.vector("rows", runs)[:, :, None])[:, :, 0]
        changes = at.dense("rates", "q", runs) + product(at.dense("rates", "v", runs), own.rates_by)
        rates_by = own.rates_by - least(changes)
        changes = at.dense("rows", "q", runs) + product(at.dense("rows", "v", runs), rates_by)
        changes += product(at.dense("rows", "a", runs), own.accelerations_by)
        return state, _Motion(a, rates_by, own.accelerations_by + least(changes), own)

    def _looked(self, state: Array, which: Array, equations: Equations) -> tuple[Array, Linear, _Motion | None]:
        """The equations where the state moves as it should."""
        state, motion = self._moving(state, which)
        a = np.zeros((len(which), self.n)) if motion is None else motion.a
        return state, self._at(state, a, self.mu[which], which, equations), motion

    # ---------------------------------------------------------------- the search
    def found(self, driven: bool) -> Resting:
        """All runs together, none of which sees another; those that rest take no further part, nor do those that never
        will."""
        every, worst = np.arange(self.runs), self._unbalanced()
        (done, still), left, never = np.zeros((2, self.runs), bool), np.where(worst > 0.0, worst, np.nan), worst > 0.0
        last, before = np.full((2, self.runs), np.inf), np.full((2, self.runs), np.nan)
        repeated, grown = np.zeros((2, self.runs))
        for _ in range(STEPS):
            which = every[~done & ~never & np.isfinite(self.state).all(axis=0)]
            if not len(which):
                break
            step = self._step(which)
            left[which], still[which] = step.force, step.still
            worst[which] = np.maximum(worst[which], step.force)
            moved, met = self._moved(which, step)
            self.mu[which] += step.dmu * moved[:, None]
            size = moved * np.abs(step.dq / self.sizes[which]).max(axis=1, initial=0.0)
            falls = np.array([step.force, step.restless]) < last[:, which]
            last[:, which] = step.force, step.restless
            settled = (size < DONE) | (~falls[0] & (size < np.sqrt(DONE)))
            rests = (step.restless < AT_REST) | (~falls[1] & (step.restless < np.sqrt(DONE)))
            done[which] = settled & rests & (step.newton | (step.force <= ROUNDING * worst[which])) & ~met
            as_before = np.abs(before[:, which] - step.force) <= ROUNDING * step.force
            repeated[which] = np.where(~as_before[0] & as_before[1], repeated[which] + 1, 0)
            grown[which] = np.where(step.force > before[0, which], grown[which] + 1, 0)
            never[which] = (repeated[which] >= TO_AND_FRO) | (grown[which] >= AWAY)
            before[:, which] = step.force, before[0, which]
            same = as_before[0] & self.standing.may_close(which).any(axis=1)
            self.longest[which] = np.where(same, FARTHER * self.longest[which], LONGEST)
            slips = self._slips(which[done[which]])
            changed = np.concatenate([which[met], slips])
            done[slips], repeated[changed], grown[changed] = False, 0, 0
            last[:, changed], before[:, changed] = np.inf, np.nan
            self._stand(changed)
        good = done & self.stands & (still | (left <= np.maximum(ROUNDING * worst, 1e-12)))
        status, growth = np.full(self.runs, NONE_FOUND), np.full(self.runs, np.nan)
        for first in range(0, self.runs, AT_ONCE):
            which = every[first : first + AT_ONCE][good[first : first + AT_ONCE]]
            if len(which):
                status[which], growth[which] = self._judged(which, worst[which])
        which = every[good & ~self.turns]
        if driven and self.model.drivers and len(which):
            self.state[:, which] = self.with_rates(self.state[:, which], self.asked(self.state[:, which], which))
        return Resting(list(self.state), status, left, growth)

    def _slips(self, which: Array) -> Array:
        """Of runs that rest those that what they stand on cannot hold; it gives way from then on. Those that nothing
        can hold rest no more."""
        self.stands[which] = True
        which = which[(self.standing.on[:, which] != OFF).any(axis=0)]
        if not len(which):
            return which
        runs, D, equations = len(which), self.sizes[which], self.equations.only(("a",), ("along", "rows"))
        state, motion = self._moving(self.state[:, which], which)
        a = np.zeros((runs, self.n)) if motion is None else motion.a
        at = self._at(state, a, np.zeros((runs, self.m)), which, equations)
        M = -at.dense("along", "a", runs) * D[:, :, None] * D[:, None, :]
        f, C = at.vector("along", runs) * D, self._sized(at, which)
        holds, changes = self.standing.stays(C, M, f, self.others[which], which)
        self.stands[which] = holds
        return which[changes]

    def _unbalanced(self) -> Array:
        """The largest force of each run that nothing can balance, wherever it is at rest; else 0 (runs,)."""
        first = self.tree.state + self.tracer.laws
        angles = range(first, first + len(self.tracer.augmented.angles))
        rates = set(self.rates)
        first_mode = first + self.tracer.augmented.first_mode
        modes = set(range(first_mode, len(self.state) - self.tracer.augmented.memory))
        stands = {row for masks, on in self.standing.places for row in (*masks, on)}

        def known(array: str, row: int) -> float | None:
            if array == STATE:  # how everything starts to be on is a matter of the mechanism, not of a run
                return 0.0 if row in rates else float(self.state[row, 0]) if row in modes - stands else None
            moves = array == "parameters" or (array == UNKNOWN and row >= self.n)
            return None if moves else 0.0

        free = {(STATE, row) for row in (*range(self.tree.state, first), *angles, *stands)}
        free |= {(UNKNOWN, self.n + row) for row in range(self.m)}
        rows = analytic(self.equations.values[: self.n], known, free)
        if not rows.any():
            return np.zeros(self.runs)
        every, draw = np.arange(self.runs), np.random.default_rng(0).uniform
        forces = []
        for _ in range(PLACES):
            dq = draw(-1.0, 1.0, self.n) * self.sizes
            state = self._elsewhere(self.state, dq, np.zeros((self.runs, self.tracer.laws)), every)
            at = self._at(state, np.zeros((self.runs, self.n)), self.mu, every, self.forces)
            forces.append((at.vector("along", self.runs) * self.sizes)[:, rows])
        return np.where(self.turns, 0.0, unbalanced(np.array(forces)))

    def _judged(self, which: Array, worst: Array) -> tuple[Array, Array]:
        """Of runs whose forces are balanced the status and the growth; their states move as they should from now on."""
        state, at, motion = self._looked(self.state[:, which], which, self.equations)
        self.state[:, which] = state
        rows, lengths = self._rows(at, which)
        lasts = self._lasts(state, at, motion, rows, lengths, which, worst)
        gamma = np.zeros((len(which), self.n, self.n)) if motion is None else motion.carried.rates_by
        lambda_ = np.zeros_like(gamma) if motion is None else motion.carried.shifts_by
        near = Near(at, rows, self._rows(at, which, self.held)[0], lengths, self.sizes[which], gamma, lambda_)
        found = stability(near)
        drifts = found.zeros > np.where(self.turns[which], TURNING, 0)
        status = np.where(found.grows, UNSTABLE, np.where(drifts, NOT_ISOLATED, FOUND))
        closed = np.abs(at.vector("positions", len(which)) / lengths).max(axis=1, initial=0.0) <= CLOSED
        return np.where(lasts & closed & ~np.isnan(found.growth), status, NONE_FOUND), found.growth

    def _step(self, which: Array) -> "_Step":
        """Along the reflected coordinates of `Rows`, the first of which the constraints decide."""
        runs, n, s, D = len(which), self.n, len(self.equations.columns["laws"]), self.sizes[which]
        _, at, motion = self._looked(self.state[:, which], which, self.equations)
        rows, lengths = self._rows(at, which)
        Q, Qt, rank = rows.Q, turned(rows.Q), rows.rank
        along = product(Qt, at.vector("along", runs) * D)
        carried = np.maximum(
            np.abs(along).max(axis=1, initial=0.0), np.abs(self.mu[which] * lengths).max(axis=1, initial=0.0)
        )
        noise = FAINT * carried[:, None]
        along = np.where((np.abs(along) <= noise) & (np.arange(n) >= rank[:, None]), 0.0, along)
        K = product(Qt, product(-_by_places(at, "along", motion, runs) * D[:, None, :] * D[:, :, None], Q))
        K = np.where(np.abs(K) <= noise[:, :, None], 0.0, K)
        S = product(Qt, at.dense("along", "laws", runs) * D[:, :, None])
        L, P = product(_by_places(at, "laws", motion, runs) * D[:, None, :], Q), at.dense("laws", "laws", runs)
        rates = at.vector("laws", runs)
        force = np.abs(product(Q, _free(along, rank))).max(axis=1, initial=0.0)
        values = np.nan_to_num(symmetric_values(0.5 * (K + turned(K)), rank))
        through = solved(-P, L, np.zeros(runs, np.int64), SMALL)  # states of laws as they follow places at once
        largest = np.abs(values).max(axis=1, initial=0.0)
        largest = np.maximum(largest, np.abs(np.nan_to_num(product(S, through))).max(axis=(1, 2), initial=0.0))
        falling = np.maximum(-values.min(axis=1, initial=0.0) - 1e-9 * largest, 0.0)
        still = force <= QUIET * largest  # what is left is rounding
        sigma = np.where(still, 0.0, np.maximum(SLOW * force / self.longest[which], DOWNHILL * falling))
        scale = np.maximum(np.maximum(np.abs(K).max(axis=(1, 2), initial=0.0), largest) + sigma, 1e-300)
        K = K + sigma[:, None, None] * np.eye(n)
        total = np.zeros((runs, n + s, n + s))
        total[:, :n, :n], total[:, :n, n:] = K / scale[:, None, None], -S / scale[:, None, None]
        total[:, n:, :n] = -L
        total[:, n:, n:] = np.sqrt(sigma / scale)[:, None, None] * np.eye(s) - P
        held = rows.within(-at.vector("positions", runs) / lengths)
        right = [(along - product(K, held)) / scale[:, None], rates + product(L, held)]
        x = solved(total, np.concatenate(right, axis=1), rank, SMALL)
        moved, ds = held + x[:, :n], x[:, n:]
        self.mu[which] += rows.multipliers(along) / lengths
        dmu = rows.multipliers(product(S, ds) - product(K, moved)) / lengths
        dq = product(Q, moved)
        size = np.abs(dq).max(axis=1, initial=0.0)
        short = np.minimum(1.0, self.longest[which] / np.maximum(size, 1e-300))
        states = np.abs(self.state[self.tree.state : self.tree.state + s, which]).T
        terms = np.abs(L).sum(axis=2) + product(np.abs(P), states)
        restless = (np.abs(rates) / np.maximum(terms, 1e-300)).max(axis=1, initial=0.0)
        self.fastest[which] = np.maximum(self.fastest[which], np.abs(rates))
        push = (_free(along + product(S, ds), rank) * moved).sum(axis=1)
        return _Step(dq * D, dmu, ds, force, push, restless, short, still, (sigma <= 1e-3 * largest) | still)

    def _moved(self, which: Array, step: "_Step") -> tuple[Array, Array]:
        """Move the states by as much of the step as leads to finite forces, and to nothing that closes; how much that
        is, and whether anything does (runs,)."""
        runs, part, old, a = len(which), step.short.copy(), self.state[:, which], np.zeros((len(which), self.n))
        for _ in range(HALVINGS):
            new = self._elsewhere(old, part[:, None] * step.dq, part[:, None] * step.ds, which)
            _, at, _ = self._looked(new, which, self.forces)
            bad = ~np.isfinite(new).all(axis=0) | ~np.isfinite(at.vector("along", runs)).all(axis=1)
            rates = np.abs(at.vector("laws", runs))
            bad |= (~(rates <= GROWS * self.fastest[which]) & (self.fastest[which] > 0.0)).any(axis=1)
            back = (at.vector("along", runs) * step.dq).sum(axis=1) < -TURNS * step.push
            bad |= back & ~step.newton  # far beyond where forces vanish, as of a servo at its limit on either side
            if not bad.any():
                break
            part[bad] *= 0.5
        met = np.zeros(runs, bool)
        if self.standing.switches:
            gaps = [self._at(x, a, self.mu[which], which, self.gaps).vector("gaps", runs) for x in (old, new)]
            to, closes = self.standing.meets(*gaps, which)
            met = closes.any(axis=1)
            part *= to
            self.standing.close(closes, which)
            new = self._elsewhere(old, part[:, None] * step.dq, part[:, None] * step.ds, which)
        self.state[:, which] = self._counted(new, which)
        return part, met

    def _elsewhere(self, state: Array, dq: Array, ds: Array, which: Array) -> Array:
        """The states moved by these coordinates (runs, n), and states of laws."""
        runs, chart, elements = len(which), self.tracer.chart_of(self._of(which)), self.tree.state + self.tracer.laws
        u = [*dq.T, *np.zeros((self.n, runs)), *ds.T]
        u += [np.zeros(runs)] * (chart.size - len(u))
        with np.errstate(all="ignore"):
            moved = chart.settled(chart.moved(tuple(state[:elements]), tuple(u)))
        return np.array([*(np.broadcast_to(np.asarray(x), (runs,)) for x in moved), *state[elements:]])

    def _counted(self, state: Array, which: Array) -> Array:
        """With the turns of joints counted on."""
        augmented = self.tracer.augmented
        if not augmented.angles:
            return state
        model, first = self._of(which), len(state) - augmented.rows
        posture = self.tracer.posture(model, [tuple(state[:first])], tuple(state[first:]), 0.0)
        for n, angle in enumerate(augmented.counted(model, posture.now)):
            state[first + n] = angle
        return state

    def _lasts(
        self, state: Array, at: Linear, motion: _Motion | None, rows: Rows, lengths: Array, which: Array, worst: Array
    ) -> Array:
        """Whether what shall turn turns, and goes on: its velocities fulfil the constraints, and its forces and the
        rates of its laws do not change while it turns (runs,). worst (runs,): the largest force there was."""
        if motion is None:
            return np.ones(len(which), bool)
        runs, D = len(which), self.sizes[which]
        speed = np.abs(self.rotation[:, which]).max(axis=0)
        ways = {"q": state[self.rates].T, "v": motion.a, "a": motion.carried.jerks}
        unmet = np.abs(at.vector("rates", runs) / lengths).max(axis=1, initial=0.0)
        good = motion.carried.turns & (unmet <= STEADY * speed)
        for of, sizes in (("along", D), ("laws", np.ones((runs, len(self.equations.outputs["laws"]))))):
            slopes = {by: at.dense(of, by, runs) * sizes[:, :, None] for by in ways}
            change = sum((product(slopes[by], x) for by, x in ways.items()), np.zeros(sizes.shape))
            if of == "along":
                change = product(rows.Q, _free(product(turned(rows.Q), change), rows.rank))
            terms = [np.abs(slopes[by]).max(axis=(1, 2), initial=0.0) * np.abs(x).max(axis=1) for by, x in ways.items()]
            most = STEADY * speed * worst + EXACT * np.max(terms, axis=0)
            good &= np.abs(change).max(axis=1, initial=0.0) <= most
        return good | ~self.turns[which]


@dataclass(frozen=True)
class _Step:
    """dmu: what multipliers change by in it; push: what the forces at its start do in it, once laws are where it leads; restless: by how much states of laws do not rest, of what their
    rates can be; still: whether what is left of forces is rounding; newton: whether the pseudo-transient part no longer
    counts; short: how much of it is not too long."""

    dq: Array
    dmu: Array
    ds: Array
    force: Array
    push: Array
    restless: Array
    short: Array
    still: Array
    newton: Array


def _by_places(at: Linear, of: str, motion: _Motion | None, runs: int) -> Array:
    """The derivative by the places, of what moves with them."""
    found = at.dense(of, "q", runs)
    if motion is None:
        return found
    found = found + product(at.dense(of, "v", runs), motion.rates_by)
    return found + product(at.dense(of, "a", runs), motion.accelerations_by)


def _free(x: Array, rank: Array) -> Array:
    """Of reflected coordinates, those that constraints leave free; 0 of the others."""
    return np.where(np.arange(x.shape[1]) >= rank[:, None], x, 0.0)


def _part(x: Any, which: Array, runs: int) -> Any:
    """A number of the model, of some of all runs."""
    if type(x) is float or len(which) == runs:
        return x
    if isinstance(x, np.ndarray):
        return x[which] if x.shape == (runs,) else x
    return x.part(which) if isinstance(x, RunNumbers) else x
