"""Coordinates and rates of a mechanism at its nominal start, by their names."""

from lienumba.mechanics.elements import joints
from lienumba.mechanics.mechanism.kinematics import still
from lienumba.mechanics.system.joint_coordinates import units
from lienumba.scenario.start.prepare import Nominal


def values(start: Nominal) -> tuple[dict[str, float], dict[str, float]]:
    model, view = start.model, still(start.now, tuple(range(len(start.model.bodies))))
    found = [
        (float(joints.coordinate(model, x, view)), float(joints.rate(model, x, view)))
        for x in joints.coordinates(model)
    ]
    q, qd = zip(*found, strict=True)
    return dict(zip(units(model), q, strict=True)), dict(zip(units(model), qd, strict=True))
