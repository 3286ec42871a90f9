"""A mechanism by the freedoms of its joints, on arrays of all runs."""

from collections.abc import Mapping, Sequence
from typing import Any, Self

import numpy as np

from lienumba.groups.state import ELEMENT
from lienumba.integrators.methods.charts import JOINT
from lienumba.integrators.tracing.joint.tracer import JointTracer
from lienumba.integrators.tracing.method import Method
from lienumba.integrators.tracing.row_selection import UNIQUE, RowSelection
from lienumba.integrators.tracing.template import split
from lienumba.mechanics.elements.inputs.state import held_at
from lienumba.mechanics.mechanism import kinematics
from lienumba.mechanics.mechanism.kinematics import Instant
from lienumba.mechanics.mechanism.model import Counted, Model
from lienumba.mechanics.system import kkt
from lienumba.mechanics.system.switched.laws import keeps
from lienumba.mechanics.system.switches import LOCK, permanent
from lienumba.mechanics.tree.motion import read_state
from lienumba.mechanics.tree.spanning import joints_of, ties_of


class FreedomTracer(JointTracer):
    """By the freedoms of the joints, where locks hold by rows of C like others."""

    def _structure(self, model: Model, selection: RowSelection, fixed: bool) -> kkt.Structure:
        tied = joints_of(ties_of(model))
        self.closing = kkt.Structure.closing(permanent(model), tied)
        return kkt.Structure.closing(model, tied)

    @classmethod
    def of(cls, model: Model) -> Self:
        """The tracer of a mechanism, whatever its numbers are."""
        method = Method("rk4", "none", "none", coordinates=JOINT)
        return cls(split(model)[0], method, UNIQUE, False)

    def instant(self, model: Model, rows: Sequence[Any], t: float) -> Instant:
        """The mechanism where the rows of its state put it, on arrays of all runs."""
        first = len(rows) - self.augmented.rows
        with np.errstate(all="ignore"):
            return self.posture(model, [tuple(rows[:first])], tuple(rows[first:]), t).now

    def rows(
        self, model: Model, bodies: np.ndarray, laws: Mapping[str, Sequence[Any]], augmented: Sequence[Any]
    ) -> list[Any]:
        """The rows of a state: bodies (runs, 18 k), states of laws by their names, and what is augmented."""
        placed = [tuple(x.T) for x in np.moveaxis(bodies.reshape(len(bodies), -1, ELEMENT), 1, 0)]
        with np.errstate(all="ignore"):
            moves = read_state(model, self.tree(model), placed)
        return [*moves, *self.law_states.together(laws), *augmented]

    def rows_at_start(self, model: Model, bodies: np.ndarray, angles: Mapping[Counted, np.ndarray]) -> list[Any]:
        """The rows of states at the start: bodies (runs, 18 k), and the counted angles of joints (runs,). Locks
        hold where the motion begins."""
        augmented = self.augmented.start(angles, UNIQUE, len(bodies)).T
        rows = self.rows(model, bodies, self.law_states.initial(model), list(augmented))
        locked = [switch for switch in self.augmented.switches if switch.what == LOCK and switch.on]
        if locked:
            view = kinematics.still(self.instant(model, rows, 0.0), tuple(range(len(model.bodies))))
            first = len(rows) - self.augmented.memory
            for switch in locked:
                rows[first + switch.memory : first + switch.memory + switch.memories] = keeps(model, switch, view, ())
        return rows

    def at_limits(self, model: Model, rows: Sequence[Any], t: float) -> list[Any]:
        """The rows of a state, with the states of inputs held at the limits that they have reached."""
        new = list(rows)
        if model.held:
            first = self.tree(model).state + self.law_states.held().start
            view = kinematics.still(self.instant(model, rows, t), tuple(range(len(model.bodies))))
            names = list(model.held)
            with np.errstate(all="ignore"):
                for name, at in held_at(model, view).items():
                    new[first + names.index(name)] = at
        return new


class GluedTracer(FreedomTracer):
    """A mechanism by its freedoms, whose sticking contacts hold as other rows do, and whose sliding ones have no
    friction."""

    glued = True
