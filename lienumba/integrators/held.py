"""What a run carries from step to step beside its bodies: rows behind the 18 k rows of the state.

angles: of joints whose turns are counted, as they were after the last step; work: done on the system since the start;
accelerations: of the last stage, 6 per body, in closed loops; masks: which of the rows of C that may be exchanged are
in use, and behind them the largest margin that this choice has had.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from lienumba.mechanics import forces, joints, motion
from lienumba.mechanics.model import Model
from lienumba.mechanics.motion import Instant


@dataclass(frozen=True)
class Held:
    """angles: joints; work: whether there is any; accelerations: their number; masks: rows of C."""

    angles: tuple[int, ...]
    work: bool
    accelerations: int
    masks: tuple[int, ...]

    @property
    def rows(self) -> int:
        return self.first_mask + (len(self.masks) + 1 if self.masks else 0)

    @property
    def first_mask(self) -> int:
        return len(self.angles) + self.work + self.accelerations

    def start(
        self, angles: Mapping[int, Any], masks: np.ndarray, margin: float, runs: int, accelerations: Sequence[Any] = ()
    ) -> np.ndarray:
        """(runs, rows) at the start; angles: by joint; masks, margin: see `exchange.first_choice`; accelerations: 0 if
        omitted."""
        rows = np.zeros((runs, self.rows))
        for place, joint in enumerate(self.angles):
            rows[:, place] = angles[joint]
        for place, a in enumerate(accelerations[: self.accelerations]):
            rows[:, len(self.angles) + self.work + place] = a
        if self.masks:
            rows[:, self.first_mask : -1] = masks
            rows[:, -1] = margin
        return rows

    def instant(self, bodies: tuple[Any, ...], held: tuple[Any, ...], t: Any) -> Instant:
        return Instant(bodies, t, dict(zip(self.angles, held, strict=False)))

    def mask(self, held: tuple[Any, ...], rows: int) -> list[Any]:
        """1 or 0 for each row of C."""
        mask: list[Any] = [1.0] * rows
        for row, x in zip(self.masks, held[self.first_mask :], strict=False):
            mask[row] = x
        return mask

    def expected(self, held: tuple[Any, ...]) -> list[Any] | None:
        """The accelerations; None if they are not held."""
        first = len(self.angles) + self.work
        return list(held[first : self.first_mask]) or None

    def counted(self, model: Model, now: Instant) -> list[Any]:
        """The angles, each counted near where `now` has it."""
        every = [(model.joints[j], now.angles[j]) for j in self.angles]
        return [joints.angle(joint, motion.still(now, joint.bodies), near) for joint, near in every]


def counted_angles(model: Model) -> tuple[int, ...]:
    """The joints whose turns are counted: couplings, drivers and forces read their angle."""
    driven = {
        driver.coordinate.joint
        for driver in model.drivers
        if driver.coordinate is not None and driver.coordinate.kind == "angle" and driver.motion == "value"
    }
    return tuple(sorted(driven | joints.counted_angles(model) | forces.angle_joints(model)))
