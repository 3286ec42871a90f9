"""Where a mechanism rests, or turns uniformly: Q - M a = C^T mu, Phi = 0, s' = 0, for all runs at once.

By pseudo-transient continuation (Kelley, Keyes 1998, SIAM J. Numer. Anal. 35(2):508-523): implicit steps of a motion
that is damped so strongly that velocities follow forces, sigma dq = Q - M a - C^T mu. While forces are large steps are
short and lead downhill, away from unstable equilibria; sigma falls with the forces, and the last steps are Newton's,
on the group of all joints with its constraints. A step is halved where it leads to what is not finite, and ends where
a stop or a contact closes; what they cannot hold opens or slides once all rests (`standing`).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from lienumba.compiler.dense.decompositions import Rows, product, solved, turned
from lienumba.compiler.terms import ROUNDED
from lienumba.integrators.codes import NONE_FOUND
from lienumba.integrators.tracing.linear.balance import Motion, by_places
from lienumba.integrators.tracing.linear.equations import STATE, UNKNOWN, Linear
from lienumba.integrators.tracing.linear.freedoms import GluedTracer
from lienumba.integrators.tracing.linear.judged import EXACT, Judged
from lienumba.integrators.tracing.linear.unbalanced import PLACES, analytic, unbalanced
from lienumba.integrators.tracing.linear.ways import Ways
from lienumba.mechanics.mechanism.kinematics import OFF
from lienumba.mechanics.mechanism.model import Model

Array = npt.NDArray[Any]
STILL = (0.0, 0.0, 0.0)
LONGEST = 0.2  # rad, and of the size of the mechanism: the most that a step moves
FARTHER = 2.0  # times that, from step to step, while no force changes and something may close
STEPS = 400
AWAY = 60  # steps in a row, each with a larger force: no joint turns so far, something flies away
TO_AND_FRO = 20  # steps in a row, each with the force of the last but one: it will not come to rest
HALVINGS = 12
POLE = 4.0  # times the forces at the ends of a step: as much on the way says that there is none
ON_THE_WAY = 0.38, 0.72  # of a step
TURNS = 0.5  # of what forces do in a step: what they may take back at its end
AT_REST = 1e-12  # of what the terms of the rate of a law's state can be: what may be left
GROWS = 4.0  # times the largest rate there was, a step may make of such a rate
EARLY, LARGE = 8, 1e-3  # steps; of their forces, or of what these were sums of: more than that is left on a pole
DONE = 1e-13  # rad, and of the size: a step of Newton's that is shorter changes nothing
ROUNDING = 1e-9  # of the largest force there was: what may be left where nothing falls any more
SLOW = 0.5  # of the sigma with which forces move as far as a step may be, if K does not hold them
DOWNHILL = 1.5  # times what a step takes that leads downhill
SMALL = 1e-12  # of the largest pivot: what counts as 0
TINY = 1e-16  # of the largest stiffness: what is rounding of others
LEAST = 1e-14  # of it where rows and columns are of one size
DOUBTFUL = 1e-12  # of the largest force and stiffness: what may be rounding
AT_ONCE = 2048  # runs whose stability is judged together


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


def rest(
    tracer: GluedTracer, model: Model, rows: Sequence[Any], runs: int, rotation: Sequence[Any] = STILL,
    driven: bool = False,
) -> Resting:  # fmt: skip
    """The equilibria that runs (of a model with arrays) come to from these states, at t = 0, relative to axes that turn
    with this angular velocity (rad/s, global, floats or arrays) about one through the origin; with the velocities of
    it. driven: what rests gets the least velocities of joints that drivers ask for, too."""
    return _Search(tracer, model, rows, runs, rotation).found(driven)


class _Search(Judged):
    """fastest (runs, s): the largest rates of laws' states there were; longest (runs,): what a step may move; stands
    (runs,): whether forces were found to be such that they hold what rests; summed_up (runs,): the largest that a force
    was a sum of, when that was last asked, infinite before."""

    def __init__(
        self, tracer: GluedTracer, model: Model, rows: Sequence[Any], runs: int, rotation: Sequence[Any]
    ) -> None:
        super().__init__(tracer, model, rows, runs, rotation)
        self.fastest = np.zeros((runs, len(self.equations.outputs["laws"])))
        self.longest, self.stands = np.full(runs, LONGEST), np.ones(runs, bool)
        self.summed_up = np.full(runs, np.inf)

    def found(self, driven: bool) -> Resting:
        """All runs together, none of which sees another; those that rest take no further part, nor do those that never
        will."""
        every, worst = np.arange(self.runs), self._unbalanced()
        (done, still), left, never = np.zeros((2, self.runs), bool), np.where(worst > 0.0, worst, np.nan), worst > 0.0
        last, before = np.full((2, self.runs), np.inf), np.full((2, self.runs), np.nan)
        repeated, grown = np.zeros((2, self.runs))
        begin, early = self.state.copy(), np.zeros(self.runs)
        for n in range(STEPS):
            which = every[~done & ~never & np.isfinite(self.state).all(axis=0)]
            if not len(which):
                break
            step = self._step(which)
            left[which], still[which] = step.force, step.still
            worst[which] = np.maximum(worst[which], step.force)
            early[which] = np.maximum(early[which], step.force if n < EARLY else 0.0)
            moved, met = self._moved(which, step)
            self.mu[which] += step.dmu * moved[:, None]
            size = moved * np.abs(step.dq / self.sizes[which]).max(axis=1, initial=0.0)
            falls = np.array([step.excess, step.restless]) < last[:, which]
            last[:, which] = step.excess, step.restless
            little = step.still | (step.force <= np.maximum(ROUNDING * worst[which], 1e-12))
            settled = (size < DONE) | (~falls[0] & (size < np.sqrt(DONE)) & ~step.downhill & little)
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
            self.longest[changed] = LONGEST
            self.stand(changed)
        good = done & self.stands & (still | (left <= np.maximum(ROUNDING * worst, 1e-12)))
        more = every[good & (left > LARGE * early)]
        good[more] &= left[more] <= np.maximum(LARGE * self._sums_at(begin[:, more], more), 1e-12)
        status, growth = np.full(self.runs, NONE_FOUND), np.full(self.runs, np.nan)
        for first in range(0, self.runs, AT_ONCE):
            which = every[first : first + AT_ONCE][good[first : first + AT_ONCE]]
            if len(which):
                status[which], growth[which], left[which] = self.judged(which, worst[which])
        which = every[good & ~self.turns]
        if driven and self.model.drivers and len(which):
            self.state[:, which] = self.with_rates(self.state[:, which], self.asked(self.state[:, which], which))
        return Resting(list(self.state), status, left, growth)

    def _sums_at(self, state: Array, which: Array) -> Array:
        """The largest that a force is a sum of at a state (runs,)."""
        state, at, motion = self.looked(state, which, self.equations)
        sums = _known(self.sums(at, state, motion, which))
        return np.asarray((sums * self.sizes[which]).max(axis=1, initial=0.0))

    def _slips(self, which: Array) -> Array:
        """Of runs that rest those that what they stand on cannot hold; it gives way from then on. Those that nothing
        can hold rest no more."""
        self.stands[which] = True
        which = which[(self.standing.on[:, which] != OFF).any(axis=0)]
        if not len(which):
            return which
        runs, D = len(which), self.sizes[which]
        state, motion = self.moving(self.state[:, which], which)
        a = np.zeros((runs, self.n)) if motion is None else motion.a
        at = self.at(state, a, np.zeros((runs, self.m)), which, self.masses)
        M = -at.dense("along", "a", runs) * D[:, :, None] * D[:, None, :]
        f, C = at.vector("along", runs) * D, self.sized(at, which)
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
        forces, none = [], np.zeros((self.runs, self.n))
        for _ in range(PLACES):
            dq = draw(-1.0, 1.0, self.n) * self.sizes
            state = self.elsewhere(self.state, dq, np.zeros((self.runs, self.tracer.laws)), every)
            own, sums = (
                self.at(state, none, self.mu, every, x).vector("along", self.runs)
                for x in (self.forces, self.terms_of_forces)
            )
            own = np.where(np.abs(own) <= ROUNDED * sums, 0.0, own)
            forces.append((own * self.sizes)[:, rows])
        return np.where(self.turns, 0.0, unbalanced(np.array(forces)))

    def _step(self, which: Array) -> "_Step":
        """Along the reflected coordinates of `Rows`, the first of which the constraints decide."""
        runs, n, s, D = len(which), self.n, len(self.equations.columns["laws"]), self.sizes[which]
        state, at, motion = self.looked(self.state[:, which], which, self.equations)
        rows, lengths = self.rows_of(at, which)
        Q, Qt, rank = rows.Q, turned(rows.Q), rows.rank
        along = product(Qt, at.vector("along", runs) * D)
        K, seen = (x * D[:, None, :] * D[:, :, None] for x in by_places(at, "along", motion, runs))
        if motion is not None:  # weights that turn, as much of them as there is where they cancel
            speeds = (self.rotation[:, which] ** 2).sum(axis=0)[:, None, None]
            seen += np.abs(at.dense("along", "a", runs)) * speeds * D[:, None, :] * D[:, :, None]
        K = product(Qt, product(-K, Q))
        S = product(Qt, at.dense("along", "laws", runs) * D[:, :, None])
        L, P = product(by_places(at, "laws", motion, runs)[0] * D[:, None, :], Q), at.dense("laws", "laws", runs)
        rates = at.vector("laws", runs)
        states = np.abs(self.state[self.tree.state : self.tree.state + s, which]).T
        terms = np.abs(L).sum(axis=2) + product(np.abs(P), states)
        terms += product(np.abs(at.dense("laws", "v", runs)), np.abs(state[self.rates].T))
        restless = np.abs(rates) / np.maximum(terms, 1e-300)
        self.fastest[which] = np.maximum(self.fastest[which], np.maximum(np.abs(rates), AT_REST * terms))
        force = np.abs(product(Q, rows.free(along))).max(axis=1, initial=0.0)
        through = solved(-P, L, np.zeros(runs, np.int64), SMALL)  # states of laws as they follow places at once
        by_laws = np.abs(np.nan_to_num(product(S, through)))
        noise = self._noise(at, state, motion, rows, force, which)
        rounded = ROUNDED * product(np.abs(Qt), product(seen, np.abs(Q)))
        ways = Ways.of(K, rounded, noise, rows.free(along), force, by_laws, rank)
        doubtful = np.flatnonzero(ways.least <= DOUBTFUL * np.maximum(self.summed_up[which], ways.largest))
        if len(doubtful):
            rounded[doubtful] = self._rounded(state, motion, rows, which, doubtful)
            ways = Ways.of(K, rounded, noise, rows.free(along), force, by_laws, rank)
        K = np.where(np.abs(K) <= rounded, 0.0, K)
        largest, still, lies = ways.largest, ways.excess == 0.0, ways.unheld & ~ways.felt(S, L)
        along = along - product(ways.onto(ways.unheld), along)
        falling = ways.falling(lies)
        sigma = np.where(still, 0.0, np.maximum(SLOW * force / self.longest[which], DOWNHILL * falling))
        scale = np.maximum(np.abs(K).max(axis=(1, 2), initial=0.0), largest) + sigma
        scale = np.where(scale > 0.0, scale, np.maximum(np.abs(S).max(axis=(1, 2), initial=0.0), 1e-300))
        stands = (np.abs(np.concatenate([L, P], axis=2)) <= EXACT * terms[:, :, None]).all(axis=2)
        stands &= restless < AT_REST
        given = ways.balanced(K, rounded, S, L, stands, EXACT * terms)
        K = K + scale[:, None, None] * ways.onto(lies) + sigma[:, None, None] * (np.eye(n) - ways.onto(given))
        K = np.where(np.abs(K) <= TINY * scale[:, None, None], 0.0, K)
        total = np.zeros((runs, n + s, n + s))
        total[:, :n, :n], total[:, :n, n:] = K / scale[:, None, None], -S / scale[:, None, None]
        total[:, n:, :n] = -np.where(stands[:, :, None], 0.0, L)
        total[:, n:, n:] = np.sqrt(sigma / scale)[:, None, None] * np.eye(s) - P
        total[:, n:, n:] *= ~stands[:, :, None]
        closing = rows.within(-at.vector("positions", runs) / lengths)
        right = [(along - product(K, closing)) / scale[:, None], rates + product(L, closing)]
        x = _evenly_solved(total, np.concatenate(right, axis=1), rank)
        moved, ds = closing + x[:, :n], x[:, n:]
        self.mu[which] += rows.multipliers(along) / lengths
        dmu = rows.multipliers(product(S, ds) - product(K, moved)) / lengths
        dq = product(Q, moved)
        size = np.abs(dq).max(axis=1, initial=0.0)
        short = np.minimum(1.0, self.longest[which] / np.maximum(size, 1e-300))
        push = (rows.free(along + product(S, ds)) * moved).sum(axis=1)
        newton = (sigma <= 1e-3 * largest) | still
        unrest = restless.max(axis=1, initial=0.0)
        return _Step(dq * D, dmu, ds, force, ways.excess, push, unrest, short, newton, falling > 0.0)

    def _leaps(self, old: Array, part: Array, step: "_Step", force: Array, which: Array) -> Array:
        """Whether steps lead over a pole: on the way there is much more force along them than at their ends (runs,)."""
        leaps = np.zeros(len(which), bool)
        some = np.flatnonzero(~step.newton & (step.ds == 0.0).all(axis=1))  # forces of states are not those of places
        most = POLE * np.maximum(np.abs(force[some]), np.abs(step.push[some]))
        for along in ON_THE_WAY if len(some) else ():
            dq, ds, own = step.dq[some], step.ds[some], which[some]
            to = along * part[some, None]
            _, at, _ = self.looked(self.elsewhere(old[:, some], to * dq, to * ds, own), own, self.forces)
            leaps[some] |= ~(np.abs((at.vector("along", len(some)) * dq).sum(axis=1)) <= most)
        return leaps

    def _noise(self, at: Linear, state: Array, motion: Motion | None, rows: Rows, force: Array, which: Array) -> Array:
        """What may be rounding of forces along the coordinates of rows (runs, n); 0 where it would not be seen."""
        seen = force <= DOUBTFUL * self.summed_up[which]
        if not seen.any():
            return np.zeros((len(which), self.n))
        sums = _known(self.sums(at, state, motion, which)) * self.sizes[which]
        self.summed_up[which] = np.where(seen, sums.max(axis=1, initial=0.0), self.summed_up[which])
        return np.where(seen[:, None], ROUNDED * product(turned(np.abs(rows.Q)), sums), 0.0)

    def _rounded(self, state: Array, motion: Motion | None, rows: Rows, which: Array, some: Array) -> Array:
        """What may be rounding of the stiffness along the coordinates of rows, of some of these runs (some, n, n)."""
        own, Q = which[some], np.abs(rows.Q[some])
        sums = _known(self.sums_of_slopes(state[:, some], motion and motion.part(some), own))
        sums = sums * self.sizes[own][:, None, :] * self.sizes[own][:, :, None]
        return ROUNDED * product(turned(Q), product(sums, Q))

    def _moved(self, which: Array, step: "_Step") -> tuple[Array, Array]:
        """Move the states by as much of the step as leads to finite forces, and to nothing that closes; how much that
        is, and whether anything does (runs,)."""
        runs, part, old, a = len(which), step.short.copy(), self.state[:, which], np.zeros((len(which), self.n))
        for _ in range(HALVINGS):
            new = self.elsewhere(old, part[:, None] * step.dq, part[:, None] * step.ds, which)
            _, at, _ = self.looked(new, which, self.forces)
            bad = ~np.isfinite(new).all(axis=0) | ~np.isfinite(at.vector("along", runs)).all(axis=1)
            rates = np.abs(at.vector("laws", runs))
            bad |= (~(rates <= GROWS * self.fastest[which]) & (self.fastest[which] > 0.0)).any(axis=1)
            force = (at.vector("along", runs) * step.dq).sum(axis=1)
            bad |= (force < -TURNS * step.push) & ~step.newton  # far beyond where forces vanish, as of a limited servo
            bad |= self._leaps(old, part, step, force, which)
            if not bad.any():
                break
            part[bad] *= 0.5
        met: Array = np.zeros(runs, bool)
        if self.standing.switches:
            before, after = (self.at(x, a, self.mu[which], which, self.gaps).vector("gaps", runs) for x in (old, new))
            to, closes = self.standing.meets(before, after, which)
            met = np.asarray(closes.any(axis=1))
            if met.any():
                part *= to
                self.standing.close(closes, which)
                new = self.elsewhere(old, part[:, None] * step.dq, part[:, None] * step.ds, which)
        self.state[:, which] = self.counted(new, which)
        return part, met


def _known(sums: Array) -> Array:
    """0 where they are too large to say anything."""
    return np.where(np.isfinite(sums), sums, 0.0)


def _evenly_solved(A: Array, b: Array, first: Array) -> Array:
    """x with A x = b from `first` on, whatever the units of rows and columns: soft springs beside stiff ones."""
    free = np.arange(A.shape[1]) >= first[:, None]
    A = np.where(free[:, :, None] & free[:, None, :], A, 0.0)
    rows = np.abs(A).max(axis=2)
    rows = np.where(rows > 0.0, rows, 1.0)
    A = A / rows[:, :, None]
    columns = np.abs(A).max(axis=1)
    columns = np.where(columns > 0.0, columns, 1.0)
    return solved(A / columns[:, None, :], b / rows, first, LEAST) / columns


@dataclass(frozen=True)
class _Step:
    """dmu: what multipliers change by in it; excess: the largest force that is no rounding; push: what the forces at
    its start do in it, once laws are where it leads; restless: by how much states of laws do not rest, of what their
    rates can be; short: how much of it is not too long; newton: whether the pseudo-transient part no longer counts;
    downhill: whether it leaves a place that does not hold."""

    dq: Array
    dmu: Array
    ds: Array
    force: Array
    excess: Array
    push: Array
    restless: Array
    short: Array
    newton: Array
    downhill: Array

    @property
    def still(self) -> Array:
        """Whether what is left of forces is rounding."""
        return self.excess == 0.0
