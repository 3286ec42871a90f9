"""Joints: one class for each type, with its keys and its mathematics. `JOINTS` knows them by name."""

from lienumba.mechanics.elements.joints import couplings, pairs, python
from lienumba.mechanics.elements.joints.base import (
    JOINTS,
    JointType,
    Own,
    coordinate,
    coordinate_kinds,
    coordinates,
    counted_angles,
    freedom,
    gain,
    in_motion,
    named,
    rate,
)
from lienumba.mechanics.elements.joints.freedoms import Freedom
from lienumba.mechanics.elements.joints.parts import X, Y, Z, direction, rate_of_turning
from lienumba.mechanics.elements.joints.placement import placement

__all__ = [
    "JOINTS", "Freedom", "JointType", "Own", "X", "Y", "Z", "coordinate", "coordinate_kinds", "coordinates",
    "counted_angles", "couplings", "direction", "freedom", "gain", "in_motion", "named", "pairs", "placement", "python",
    "rate", "rate_of_turning",
]  # fmt: skip
