"""What a run carries from step to step beside its bodies: rows behind the 18 k rows of the state.

angles: of joints whose turns are counted, as they were after the last step; work: done on the system since the start;
accelerations: of the last stage, 6 per body, and their rates, in closed loops; masks: which of the rows of C
that may be exchanged are in use, and behind them the largest margin that this choice has had.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from lienumba.integrators.tracing.row_selection import Choice
from lienumba.mechanics.elements import joints, quantities
from lienumba.mechanics.mechanism import kinematics
from lienumba.mechanics.mechanism.kinematics import Instant
from lienumba.mechanics.mechanism.model import Model
from lienumba.mechanics.system import applied_forces


@dataclass(frozen=True)
class Held:
    """angles: joints; work: whether there is any; accelerations: their number; masks: rows of C; fixed: the masks of
    rows of C that are compiled in, whatever a run holds."""

    angles: tuple[int, ...]
    work: bool
    accelerations: int
    masks: tuple[int, ...]
    fixed: Mapping[int, float]

    @property
    def rows(self) -> int:
        return self.first_mask + (len(self.masks) + 1 if self.masks else 0)

    @property
    def first_mask(self) -> int:
        return len(self.angles) + self.work + self.accelerations

    def start(
        self, angles: Mapping[int, Any], choice: Choice, runs: int, accelerations: Sequence[Any] = ()
    ) -> np.ndarray:
        """(runs, rows) at the start; angles: by joint; accelerations and rates: 0 if omitted."""
        rows = np.zeros((runs, self.rows))
        for place, joint in enumerate(self.angles):
            rows[:, place] = angles[joint]
        for place, a in enumerate(accelerations[: self.accelerations]):
            rows[:, len(self.angles) + self.work + place] = a
        if self.masks:
            rows[:, self.first_mask : -1] = choice.masks
            rows[:, -1] = choice.margin
        return rows

    def mask(self, held: tuple[Any, ...], rows: int) -> list[Any]:
        """1 or 0 for each row of C."""
        mask: list[Any] = [1.0] * rows
        for row, x in zip(self.masks, held[self.first_mask :], strict=False):
            mask[row] = x
        for row, used in self.fixed.items():
            mask[row] = used
        return mask

    def expected(self, held: tuple[Any, ...], later: Any = 0.0) -> list[Any] | None:
        """The accelerations so much later (s), if they change as they did; None if they are not held."""
        first, number = len(self.angles) + self.work, self.accelerations // 2
        last, change = held[first : first + number], held[first + number : self.first_mask]
        return [a + later * da for a, da in zip(last, change, strict=True)] or None

    def after(self, held: tuple[Any, ...], accelerations: list[Any], h: Any) -> list[Any]:
        """What is held of accelerations after a step of h: themselves, and their rates."""
        last, rate = self.expected(held) or [], 1.0 / h
        return accelerations + [(new - old) * rate for new, old in zip(accelerations, last, strict=True)]

    def counted(self, model: Model, now: Instant) -> list[Any]:
        """The angles, each counted near where `now` has it."""
        every = [(model.joints[j], now.angles[j]) for j in self.angles]
        return [joints.angle(joint, kinematics.still(now, joint.bodies), near) for joint, near in every]


def counted_angles(model: Model) -> tuple[int, ...]:
    """The joints whose turns are counted: couplings, drivers, forces and quantities read their angle."""
    driven = {
        driver.coordinate.joint
        for driver in model.drivers
        if driver.coordinate is not None and driver.coordinate.kind == "angle" and driver.motion == "value"
    }
    seen = quantities.angle_joints(model)
    return tuple(sorted(driven | joints.counted_angles(model) | applied_forces.angle_joints(model) | seen))
