"""Joints: one class for each type, with its keys and its mathematics. `JOINTS` knows them by name."""

from lienumba.mechanics.elements.joints import couplings, pairs, python
from lienumba.mechanics.elements.joints.base import JOINTS, JointType, Own, coordinate_kinds, counted_angles
from lienumba.mechanics.elements.joints.parts import X, Y, Z, angle, coordinate, direction

__all__ = [
    "JOINTS", "JointType", "Own", "X", "Y", "Z", "angle", "coordinate", "coordinate_kinds", "counted_angles",
    "couplings", "direction", "pairs", "python",
]  # fmt: skip
