"""What a run carries from step to step beside its bodies: rows behind its elements of S.

angles: of joints whose turns are counted, as they were after the last step; work: done on the system since the start;
accelerations: of the last stage, 6 per body, and their rates, in closed loops; history: what a method has of the step
before; masks: which of the rows of C
that may be exchanged are in use, and behind them the largest margin that this selection has had; of switched
constraints the masks of their rows, how each is on, and what they keep.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from lienumba.integrators.tracing.row_selection import RowSelection
from lienumba.mechanics.elements import joints, quantities
from lienumba.mechanics.elements.drivers import POSITION, type_of
from lienumba.mechanics.mechanism import kinematics
from lienumba.mechanics.mechanism.kinematics import Instant, Modes
from lienumba.mechanics.mechanism.model import Counted, Model, coordinate_of
from lienumba.mechanics.system import applied_forces
from lienumba.mechanics.system.switches import Switch, modes_of
from lienumba.numerics.number import Number, Vector


@dataclass(frozen=True)
class AugmentedState:
    """angles: those that are counted; work: whether there is any; accelerations: their number; masks: rows of C; fixed:
    the masks of rows of C that are compiled in, whatever a run has; switches: see `switches_of`; permanent: how many
    rows of C are none of these; history: rows that the method carries on."""

    angles: tuple[Counted, ...]
    work: bool
    accelerations: int
    masks: tuple[int, ...]
    fixed: Mapping[int, float]
    switches: tuple[Switch, ...] = ()
    permanent: int = 0
    history: int = 0

    @property
    def rows(self) -> int:
        return self.first_mode + self.switched + len(self.switches) + self.memory

    @property
    def first_mode(self) -> int:
        return self.first_mask + (len(self.masks) + 1 if self.masks else 0)

    @property
    def switched(self) -> int:
        """Rows of C that are switched on and off."""
        return sum(switch.rows for switch in self.switches)

    @property
    def memory(self) -> int:
        """Numbers that switches keep."""
        return sum(switch.memories for switch in self.switches)

    @property
    def first_mask(self) -> int:
        return self.first_history + self.history

    @property
    def first_history(self) -> int:
        return len(self.angles) + self.work + self.accelerations

    def start(
        self,
        angles: Mapping[Counted, float | np.ndarray],
        selection: RowSelection,
        runs: int,
        accelerations: Sequence[np.ndarray] = (),
    ) -> np.ndarray:
        """(runs, rows) at the start; angles: by joint; accelerations and rates: 0 if omitted."""
        rows = np.zeros((runs, self.rows))
        for place, which in enumerate(self.angles):
            rows[:, place] = angles[which]
        for place, a in enumerate(accelerations[: self.accelerations]):
            rows[:, len(self.angles) + self.work + place] = a
        if self.masks:
            rows[:, self.first_mask : self.first_mode - 1] = selection.masks
            rows[:, self.first_mode - 1] = selection.margin
        for n, switch in enumerate(self.switches):
            first = self.first_mode + switch.first
            rows[:, first : first + switch.rows] = float(switch.on != 0)
            rows[:, self.first_mode + self.switched + n] = switch.on
        return rows

    def mask(self, augmented: Vector, rows: int) -> list[Number]:
        """1 or 0 for each row of C."""
        mask: list[Number] = [1.0] * rows
        for row, x in zip(self.masks, augmented[self.first_mask :], strict=False):
            mask[row] = x
        for row, used in self.fixed.items():
            mask[row] = used
        mask[self.permanent : self.permanent + self.switched] = augmented[self.first_mode :][: self.switched]
        return mask

    def modes(self, model: Model, augmented: Vector) -> Modes:
        """How each switch is on, and what it keeps."""
        on, memory = self.first_mode + self.switched, self.rows - self.memory
        return modes_of(model, augmented[on:memory], augmented[memory:]) if self.switches else {}

    def expected(self, augmented: Vector, later: Number = 0.0) -> list[Number] | None:
        """The accelerations so much later (s), if they change as they did; None if they are not carried on."""
        first, number = len(self.angles) + self.work, self.accelerations // 2
        last, change = augmented[first : first + number], augmented[first + number : self.first_history]
        return [a + later * da for a, da in zip(last, change, strict=True)] or None

    def after(self, augmented: Vector, accelerations: list[Number], h: Number) -> list[Number]:
        """Accelerations after a step of h, and behind them their rates."""
        last, rate = self.expected(augmented) or [], 1.0 / h
        return accelerations + [(new - old) * rate for new, old in zip(accelerations, last, strict=True)]

    def counted(self, model: Model, now: Instant) -> list[Number]:
        """The angles, each counted near where `now` has it."""
        everything = kinematics.still(now, tuple(range(len(model.bodies))))
        return [joints.coordinate(model, coordinate_of(which), everything) for which in self.angles]


def counted_angles(model: Model, now: Instant, every: bool = False) -> tuple[Counted, ...]:
    """The angles of joints that count turns: joints, drivers, forces and quantities read them; every: all that are
    coordinates of the mechanism, too. now: any state."""
    found: set[Counted] = {
        driver.coordinate.counted
        for driver in model.drivers
        if driver.coordinate is not None
        and driver.coordinate.kind == "angle"
        and type_of(driver).level(driver) == POSITION
    }
    found |= joints.counted_angles(model, now) | applied_forces.angle_joints(model) | quantities.counted_angles(model)
    stopped = (limit.coordinate for limit in model.limits)
    found |= {which.counted for which in stopped if joints.freedom(model, which).counts}
    if every:
        found |= {which.counted for which in joints.coordinates(model) if joints.freedom(model, which).counts}
    return tuple(sorted(found, key=lambda which: (coordinate_of(which).joint, coordinate_of(which).kind)))
