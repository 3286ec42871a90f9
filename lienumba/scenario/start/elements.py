"""Drivers: from their keys, with the numbers of the runs, to those of the model."""

from collections.abc import Sequence

from lienumba.keys.conversions import timed, timed3, vec3
from lienumba.mechanics.elements.names import Names
from lienumba.mechanics.mechanism import model as m
from lienumba.numerics.number import Number
from lienumba.scenario.schema.forces import Driver, JointDriver, PointDriver


# ---------------------------------------------------------------- drivers
def driver(keys: Driver, names: Names) -> m.Driver:
    """A driver of the model."""
    if isinstance(keys, JointDriver):
        motion, value = ("rate", keys.rate) if keys.value is None else ("value", keys.value)
        which = names.coordinate(keys.joint, keys.coordinate)
        return m.Driver(keys.name, motion, names.ends(keys.joint), (timed(value),), which)
    return m.Driver(
        keys.name,
        keys.motion,
        (names.bodies[keys.body],),
        timed3(keys.value),
        point=vec3(keys.point) if isinstance(keys, PointDriver) else None,
        frame=getattr(keys, "frame", "global"),
    )


# ---------------------------------------------------------------- vectors
def optional(values: Sequence[Number] | None) -> m.Vec3 | None:
    """A vector, or none."""
    return None if values is None else vec3(values)
