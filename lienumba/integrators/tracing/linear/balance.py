"""The equations of all runs at once at rest or in a uniform rotation, at any state.

At rest v = a = 0. Relative to a uniform rotation v and a are those of bodies that turn with it (`uniform_rotation`),
and what drivers ask for beside that; both follow the places, and so do the derivatives of the forces.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np

from lienumba.compiler.memo import Memo
from lienumba.integrators.tracing.law_states import LawStates
from lienumba.integrators.tracing.linear.algebra import Array, NullSpace, applied
from lienumba.integrators.tracing.linear.equations import Equations, Linear, RunsNumbers
from lienumba.integrators.tracing.linear.freedoms import GluedTracer
from lienumba.integrators.tracing.linear.outputs import LinearOutputs
from lienumba.integrators.tracing.linear.supports import LOOP_RTOL, Supports
from lienumba.integrators.tracing.linear.systems import Recorded, size_of
from lienumba.integrators.tracing.linear.uniform_rotation import Carried, carried
from lienumba.integrators.tracing.template import split
from lienumba.integrators.tracing.tracer import Posture
from lienumba.mechanics.elements.inputs.state import halted
from lienumba.mechanics.mechanism.kinematics import OFF
from lienumba.mechanics.mechanism.model import Model
from lienumba.mechanics.mechanism.model_numbers import map_numbers
from lienumba.mechanics.mechanism.tables import RunNumbers
from lienumba.mechanics.system import constraints
from lienumba.mechanics.system.switches import switches_of

MEMO = 4  # sets of runs that a search asks for again and again, until the next of them is done


@dataclass(frozen=True)
class _Outputs(LinearOutputs):
    """Outputs of a search: the gaps of contacts and stops, and which states of laws are at a limit."""

    law_states: LawStates = field(default_factory=lambda: LawStates({}))

    def outputs(self, model: Model, posture: Posture, mask: list[Any], used: Sequence[int]) -> dict[str, list[Any]]:
        residual, first = constraints.residual(model, posture.now), constraints.permanent_rows(model)
        gaps = [residual[first + x.first] for x in switches_of(model) if x.unilateral]
        return {
            **super().outputs(model, posture, mask, used),
            "gaps": gaps,
            "halted": self.law_states.together(halted(model, posture.now)),
        }


@dataclass(frozen=True)
class Motion:
    """The motion of a uniform rotation: accelerations (runs, n), and how velocities and accelerations change with the
    places; carried: the rotation without what drivers add."""

    a: Array
    rates_by: Array
    accelerations_by: Array
    carried: Carried


class Balance:
    """The equations of runs at rest, or in a uniform rotation.

    state (rows, runs): with all at rest; mu (runs, m): multipliers of the rows in use; other_rank, max_rank (runs,):
    the ranks of C without and with the rows of stops and contacts; sizes (runs, n): 1 rad, or the size of the mechanism
    (m), by which coordinates are scaled; swing (runs,): see `Recorded`; forces, gaps, masses, constraints,
    constraint_slopes: parts of `equations` that cost far less; supports: the contacts and stops that hold the runs.
    """

    def __init__(
        self, tracer: GluedTracer, model: Model, rows: Sequence[Any], runs: int, rotation: Sequence[Any]
    ) -> None:
        self.tracer, self.model, self.runs = tracer, model, runs
        self.rotation = np.array([np.broadcast_to(np.asarray(x, float), (runs,)) for x in rotation])
        self.turns = (self.rotation != 0.0).any(axis=0)
        self.linear = Recorded.of(tracer, _Outputs((), (), tracer.law_states), model)
        self.equations = self.linear.equations
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
        self._models, self._numbers = Memo[Model](MEMO), Memo[RunsNumbers](MEMO)
        self.n, self.m = tracer.velocities, len(self.equations.used)
        self.mu = np.zeros((runs, self.m))
        self.sizes, self.swing = self._sizes(), np.broadcast_to(self.linear.swing, (runs,))
        self.max_rank = np.full(runs, min(self.m, self.n))
        every = np.arange(runs)  # where it starts the mechanism is closed, and its redundant rows are
        at = self.at(self.state, np.zeros((runs, self.n)), self.mu, every, self.constraints)
        self.other_rank = self.null_space(at, every).rank
        self.max_rank = self.other_rank.copy()
        self.supports = Supports.of(tracer, model, rows, self.equations.used, self.turns)
        self.support(every[(self.supports.on != OFF).any(axis=0)])

    def _sizes(self) -> Array:
        """What a coordinate is small against (runs, n): 1 rad, or how large the mechanism is (m)."""
        sizes, size = np.ones((self.runs, self.n)), size_of(self.model)
        for link in self.tree.links:
            shifts = link.move.freedoms == 2 * 3
            for n, rate in enumerate(link.rates):
                if (shifts and n < 3) or not link.move.turns:
                    sizes[:, rate] = size
        return sizes

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

    def evaluated(self, state: Array, which: Array, equations: Equations) -> tuple[Array, Linear, Motion | None]:
        """The equations at states with the velocities of the rotation."""
        state, motion = self.moving(state, which)
        a = np.zeros((len(which), self.n)) if motion is None else motion.a
        return state, self.at(state, a, self.mu[which], which, equations), motion

    def null_space(self, at: Linear, which: Array) -> NullSpace:
        """The null space of C in scaled coordinates."""
        return NullSpace.of(self.scaled_rows(at, which), LOOP_RTOL, self.max_rank[which])

    def scaled_rows(self, at: Linear, which: Array) -> Array:
        """C in scaled coordinates (runs, m, n)."""
        C: Array = -at.dense("rows", "a", len(which)) * self.sizes[which][:, None, :]
        return C

    def support(self, which: Array) -> None:
        """Take over which contacts and stops hold these runs, after that has changed."""
        if not len(which):
            return
        self.supports.write(self.state, which)
        at = self.at(self.state[:, which], np.zeros((len(which), self.n)), self.mu[which], which, self.constraints)
        space, own = self.supports.apart(self.scaled_rows(at, which), self.other_rank[which])
        self.max_rank[which] = space.rank + NullSpace.of(own, LOOP_RTOL).rank

    def with_rates(self, state: Array, rates: Array) -> Array:
        """States with these velocities (runs, n)."""
        changed = state.copy()
        changed[self.rates] = rates.T
        return changed

    def asked(self, state: Array, which: Array) -> Array:
        """The least change of velocities (runs, n) that fulfils the constraints."""
        runs = len(which)
        at = self.at(state, np.zeros((runs, self.n)), np.zeros((runs, self.m)), which, self.constraints)
        return -applied(self.null_space(at, which).inverse, at.vector("rates", runs)) * self.sizes[which]

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
        inverse = sizes[:, :, None] * self.null_space(at, which).inverse

        def least(b: Array) -> Array:
            return np.where(turns[:, None, None], inverse @ b, 0.0)

        a = own.accelerations + least(at.vector("rows", runs)[:, :, None])[:, :, 0]
        changes = at.dense("rates", "q", runs) + at.dense("rates", "v", runs) @ own.rates_by
        rates_by = own.rates_by - least(changes)
        changes = at.dense("rows", "q", runs) + at.dense("rows", "v", runs) @ rates_by
        changes += at.dense("rows", "a", runs) @ own.accelerations_by
        return state, Motion(a, rates_by, own.accelerations_by + least(changes), own)

    # ---------------------------------------------------------------- elsewhere
    def moved(self, state: Array, dq: Array, ds: Array, which: Array) -> Array:
        """The states moved by these coordinates (runs, n), and states of laws."""
        runs, chart, elements = len(which), self.tracer.chart_of(self.of(which)), self.tree.state + self.tracer.laws
        u = [*dq.T, *np.zeros((self.n, runs)), *ds.T]
        u += [np.zeros(runs)] * (chart.size - len(u))
        with np.errstate(all="ignore"):
            moved = chart.settled(chart.moved(tuple(state[:elements]), tuple(u)))
        return np.array([*(np.broadcast_to(np.asarray(x), (runs,)) for x in moved), *state[elements:]])

    def counted(self, state: Array, which: Array) -> Array:
        """The states with the turns of joints counted on."""
        augmented = self.tracer.augmented
        if not augmented.angles:
            return state
        model, first = self.of(which), len(state) - augmented.rows
        posture = self.tracer.posture(model, [tuple(state[:first])], tuple(state[first:]), 0.0)
        for n, angle in enumerate(augmented.counted(model, posture.now)):
            state[first + n] = np.asarray(angle)
        return state


def by_places(at: Linear, of: str, motion: Motion | None, runs: int) -> Array:
    """The derivative of some outputs by the places (runs, rows, n), with what moves with them."""
    slopes = at.dense(of, "q", runs)
    if motion is not None:
        slopes = slopes + at.dense(of, "v", runs) @ motion.rates_by + at.dense(of, "a", runs) @ motion.accelerations_by
    return slopes


def _part(x: Any, which: Array, runs: int) -> Any:
    """A number of the model, of some of all runs."""
    if type(x) is float or len(which) == runs:
        return x
    if isinstance(x, np.ndarray):
        return x[which] if x.shape == (runs,) else x
    return x.part(which) if isinstance(x, RunNumbers) else x
