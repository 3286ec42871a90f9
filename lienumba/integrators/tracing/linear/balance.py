"""The equations of all runs at once where they rest or turn uniformly, wherever a search has them.

At rest v = a = 0. Relative to a uniform rotation v and a are those of bodies that turn with it (`uniform_rotation`),
and what drivers ask for beside that; both follow the places, and so do the derivatives of the forces.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from lienumba.compiler.dense.decompositions import Rows, product, unit_rows
from lienumba.compiler.memo import Memo
from lienumba.integrators.tracing.law_states import LawStates
from lienumba.integrators.tracing.linear.equations import Equations, Held, Linear, RunsNumbers
from lienumba.integrators.tracing.linear.freedoms import GluedTracer
from lienumba.integrators.tracing.linear.recorded import recorded
from lienumba.integrators.tracing.linear.standing import REDUNDANT, Standing
from lienumba.integrators.tracing.linear.uniform_rotation import Carried, carried
from lienumba.integrators.tracing.template import split
from lienumba.integrators.tracing.tracer import Posture
from lienumba.mechanics.elements.inputs.state import halted
from lienumba.mechanics.mechanism.kinematics import OFF
from lienumba.mechanics.mechanism.massless import with_lent_masses
from lienumba.mechanics.mechanism.model import Model
from lienumba.mechanics.mechanism.model_numbers import map_numbers
from lienumba.mechanics.mechanism.tables import RunNumbers
from lienumba.mechanics.system import constraints
from lienumba.mechanics.system.switches import CONTACT, switches_of
from lienumba.numerics.operations import sqrt

Array = npt.NDArray[Any]
ASKED = 4  # sets of runs that a search asks for again and again, until the next of them is done


@dataclass(frozen=True)
class _Held(Held):
    """And Phi of what may close; which states of laws are at a limit of theirs."""

    laws: LawStates = field(default_factory=lambda: LawStates({}))

    def outputs(self, model: Model, posture: Posture, mask: list[Any], used: Sequence[int]) -> dict[str, list[Any]]:
        residual, first = constraints.residual(model, posture.now), constraints.permanent_rows(model)
        gaps = [residual[first + x.first] for x in switches_of(model) if x.unilateral]
        return {
            **super().outputs(model, posture, mask, used),
            "gaps": gaps,
            "halted": self.laws.together(halted(model, posture.now)),
        }


@dataclass(frozen=True)
class Motion:
    """Of states: accelerations (runs, n), and how velocities and accelerations change with the places; carried: those
    of the rotation alone."""

    a: Array
    rates_by: Array
    accelerations_by: Array
    carried: Carried

    def part(self, which: Array) -> "Motion":
        return Motion(self.a[which], self.rates_by[which], self.accelerations_by[which], self.carried.part(which))


class Balance:
    """state: with all at rest; mu: multipliers of the rows in use (runs, m); held: 1 for those of places, else 0; most,
    others (runs,): how many rows say something, with and without those of stops and contacts; sizes (runs, n); forces,
    gaps, masses, constraints, constraint_slopes: parts of `equations` that are looked at alone, and which cost far
    less; standing: what holds the runs."""

    def __init__(
        self, tracer: GluedTracer, model: Model, rows: Sequence[Any], runs: int, rotation: Sequence[Any]
    ) -> None:
        self.tracer, self.model, self.runs = tracer, model, runs
        self.rotation = np.array([np.broadcast_to(np.asarray(x, float), (runs,)) for x in rotation])
        self.turns = (self.rotation != 0.0).any(axis=0)
        self.equations = recorded(tracer, _Held(laws=tracer.law_states))
        self.forces = self.equations.only((), ("along", "laws"))
        self.gaps = self.equations.only((), ("gaps",))
        self.masses = self.equations.only(("a",), ("along", "rows"))
        self.constraints = self.equations.only(("a",), ("rows", "rates"))
        self.constraint_slopes = self.equations.only(("q", "v", "a"), ("rows", "rates"))
        self.tree = tracer.tree(tracer.graph()[1])
        self.rates = tracer.velocity_rows(tracer.graph()[1])
        self.state = np.array([np.broadcast_to(np.asarray(x, float), (runs,)) for x in rows])
        self.state[self.rates] = 0.0
        self.numbers = split(model)[1]
        self._models, self._numbers = Memo[Model](ASKED), Memo[RunsNumbers](ASKED)
        self.n, self.m = tracer.velocities, len(self.equations.used)
        self.mu = np.zeros((runs, self.m))
        every_row = [c for c in constraints.constraints_of(tracer.graph()[1]) for _ in c.kinds]
        sticks = [c.switch is not None and c.switch.what == CONTACT for c in every_row]  # rests where it is
        levels = [c.level != "velocity" or stuck for c, stuck in zip(every_row, sticks, strict=True)]
        self.held = np.array([levels[row] for row in self.equations.used], float)
        self.sizes = self._sizes()
        self.most = np.full(runs, min(self.m, self.n))
        every = np.arange(runs)  # where it starts the mechanism is closed, and redundant rows say the same
        at = self.at(self.state, np.zeros((runs, self.n)), self.mu, every, self.constraints)
        self.others = self.rows_of(at, every)[0].rank
        self.most = self.others.copy()
        self.standing = Standing.of(tracer, model, rows, self.equations.used, self.turns)
        self.stand(every[(self.standing.on != OFF).any(axis=0)])

    def _sizes(self) -> Array:
        """What a coordinate is small against (runs, n): 1 rad, or how large the mechanism is (m)."""
        found = np.ones((self.runs, self.n))
        lent = with_lent_masses(self.model).bodies
        own = [sqrt(sum(body.inertia[:3]) / body.mass) for body in lent]
        points = [p for joint in self.model.joints for p in joint.points or ()]
        points += [p for contact in self.model.contacts for p in contact.points]
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
    def of(self, which: Array) -> Model:
        """The model of these runs."""
        part = partial(_part, which=which, runs=self.runs)
        return self._models.get(which.tobytes(), lambda: map_numbers(self.model, lambda x, _: part(x), part))

    def at(self, state: Array, a: Array, mu: Array, which: Array, equations: Equations) -> Linear:
        def numbers() -> RunsNumbers:
            return RunsNumbers([_part(x, which, self.runs) for x in self.numbers], len(which))

        with np.errstate(all="ignore"):
            return equations.of_runs(state, 0.0, a.T, mu.T, self._numbers.get(which.tobytes(), numbers))

    def rows_of(self, at: Linear, which: Array, held: Array | None = None) -> tuple[Rows, Array]:
        """C by the sizes of the coordinates, its rows of length 1; and how long they were (runs, m). held: 1 for each
        row that counts, else 0; by default all do."""
        C = self.sized(at, which)
        C, lengths = unit_rows(C if held is None else C * held[:, None])
        return Rows.of(C, REDUNDANT, self.most[which]), lengths

    def stand(self, which: Array) -> None:
        """What holds these runs has changed."""
        if not len(which):
            return
        self.standing.write(self.state, which)
        at = self.at(self.state[:, which], np.zeros((len(which), self.n)), self.mu[which], which, self.constraints)
        rows, own = self.standing.free(self.sized(at, which), self.others[which])
        self.most[which] = rows.rank + Rows.of(unit_rows(own)[0], REDUNDANT).rank

    def sized(self, at: Linear, which: Array) -> Array:
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
        at = self.at(state, np.zeros((runs, self.n)), np.zeros((runs, self.m)), which, self.constraints)
        rows, lengths = self.rows_of(at, which)
        return -rows.least(at.vector("rates", runs) / lengths) * self.sizes[which]

    def moving(self, state: Array, which: Array) -> tuple[Array, Motion | None]:
        """The states with the velocities of the rotation, and the motion; None at rest."""
        turns = self.turns[which]
        if not turns.any():
            return state, None
        runs, sizes, model = len(which), self.sizes[which], self.of(which)
        with np.errstate(all="ignore"):
            own = carried(self.tracer.tree(model), list(state[: self.tree.state]), self.rotation[:, which])
        state = self.with_rates(state, own.rates)
        state = self.with_rates(state, np.where(turns[:, None], own.rates + self.asked(state, which), 0.0))
        at = self.at(state, own.accelerations, np.zeros((runs, self.m)), which, self.constraint_slopes)
        rows, lengths = self.rows_of(at, which)

        def least(b: Array) -> Array:
            found = rows.least(b / lengths[:, :, None]) * sizes[:, :, None]
            return np.where(turns[:, None, None], found, 0.0)

        a = own.accelerations + least(at.vector("rows", runs)[:, :, None])[:, :, 0]
        changes = at.dense("rates", "q", runs) + product(at.dense("rates", "v", runs), own.rates_by)
        rates_by = own.rates_by - least(changes)
        changes = at.dense("rows", "q", runs) + product(at.dense("rows", "v", runs), rates_by)
        changes += product(at.dense("rows", "a", runs), own.accelerations_by)
        return state, Motion(a, rates_by, own.accelerations_by + least(changes), own)

    def looked(self, state: Array, which: Array, equations: Equations) -> tuple[Array, Linear, Motion | None]:
        """The equations where the state moves as it should."""
        state, motion = self.moving(state, which)
        a = np.zeros((len(which), self.n)) if motion is None else motion.a
        return state, self.at(state, a, self.mu[which], which, equations), motion

    @property
    def terms(self) -> Equations:
        """How large what forces and their derivatives are sums of is."""
        return self.equations.only(("q", "v", "a"), ("along",)).terms

    @property
    def terms_of_forces(self) -> Equations:
        return self.equations.only((), ("along",)).terms

    def summed(self, state: Array, motion: Motion | None, which: Array, terms: Equations) -> Linear:
        """`terms` where a state moves as it should."""
        a = np.zeros((len(which), self.n)) if motion is None else motion.a
        return self.at(state, a, self.mu[which], which, terms)

    def sums(self, at: Linear, state: Array, motion: Motion | None, which: Array) -> Array:
        """How large what forces are sums of is (runs, n); what turns with the rotation is rounded as a whole."""
        runs, sizes = len(which), self.sizes[which]
        force = self.summed(state, motion, which, self.terms_of_forces).vector("along", runs)
        if motion is not None:
            for by, x in (("v", state[self.rates].T), ("a", motion.a)):
                force += product(np.abs(at.dense("along", by, runs)), self._most(x, which) * sizes)
        return force

    def sums_of_slopes(self, state: Array, motion: Motion | None, which: Array) -> Array:
        """The same of how forces change with the places (runs, n, n)."""
        runs, at = len(which), self.summed(state, motion, which, self.terms)
        slopes = by_places(at, "along", motion, runs)[1]
        if motion is not None:
            for by, x in (("v", state[self.rates].T), ("a", motion.a)):
                slopes += at.dense("along", by, runs) * self._most(x, which)[:, :, None]
        return slopes

    def _most(self, x: Array, which: Array) -> Array:
        found: Array = np.abs(x / self.sizes[which]).max(axis=1, initial=0.0)[:, None]
        return found

    # ---------------------------------------------------------------- elsewhere
    def elsewhere(self, state: Array, dq: Array, ds: Array, which: Array) -> Array:
        """The states moved by these coordinates (runs, n), and states of laws."""
        runs, chart, elements = len(which), self.tracer.chart_of(self.of(which)), self.tree.state + self.tracer.laws
        u = [*dq.T, *np.zeros((self.n, runs)), *ds.T]
        u += [np.zeros(runs)] * (chart.size - len(u))
        with np.errstate(all="ignore"):
            moved = chart.settled(chart.moved(tuple(state[:elements]), tuple(u)))
        return np.array([*(np.broadcast_to(np.asarray(x), (runs,)) for x in moved), *state[elements:]])

    def counted(self, state: Array, which: Array) -> Array:
        """With the turns of joints counted on."""
        augmented = self.tracer.augmented
        if not augmented.angles:
            return state
        model, first = self.of(which), len(state) - augmented.rows
        posture = self.tracer.posture(model, [tuple(state[:first])], tuple(state[first:]), 0.0)
        for n, angle in enumerate(augmented.counted(model, posture.now)):
            state[first + n] = angle
        return state


def by_places(at: Linear, of: str, motion: Motion | None, runs: int) -> tuple[Array, Array]:
    """The derivative by the places, of what moves with them; and how large what it is a sum of is."""
    found = at.dense(of, "q", runs)
    terms = np.abs(found)
    if motion is None:
        return found, terms
    for by, changes in (("v", motion.rates_by), ("a", motion.accelerations_by)):
        own = at.dense(of, by, runs)
        found, terms = found + product(own, changes), terms + product(np.abs(own), np.abs(changes))
    return found, terms


def _part(x: Any, which: Array, runs: int) -> Any:
    """A number of the model, of some of all runs."""
    if type(x) is float or len(which) == runs:
        return x
    if isinstance(x, np.ndarray):
        return x[which] if x.shape == (runs,) else x
    return x.part(which) if isinstance(x, RunNumbers) else x
