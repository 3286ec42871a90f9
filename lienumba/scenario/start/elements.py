"""Drivers and quantities: from their keys, with the numbers of the runs, to those of the model."""

from collections.abc import Sequence

from lienumba.keys.conversions import rotation_of, timed, timed3, vec3
from lienumba.mechanics.elements.names import Names
from lienumba.mechanics.mechanism import model as m
from lienumba.mechanics.mechanism.model import GROUND
from lienumba.numerics.number import Number
from lienumba.scenario.schema.forces import Driver, JointDriver, PointDriver
from lienumba.scenario.schema.quantities import (
    AngularVelocity,
    AnyQuantity,
    DriverEffort,
    Expression,
    JointQuantity,
    Momentum,
    PointQuantity,
    Reaction,
    RotationError,
)


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


# ---------------------------------------------------------------- quantities
def quantity(keys: AnyQuantity, names: Names) -> m.Quantity:
    """A quantity of the model."""
    match keys:
        case PointQuantity() | RotationError() | AngularVelocity():
            return _seen(keys, names)
        case Momentum():
            every = [name for name, index in names.bodies.items() if index != GROUND]
            counted = tuple(names.bodies[name] for name in (every if keys.bodies is None else keys.bodies))
            about = None if isinstance(keys.about, str) else vec3(keys.about)
            return m.Quantity(keys.name, keys.type, counted, about=about)
        case JointQuantity() | Reaction():
            ends = names.ends(keys.joint)
            frames = {"first": ends[0], "second": ends[-1], "global": GROUND}
            frame = frames[keys.frame if isinstance(keys, Reaction) else "global"]
            return m.Quantity(keys.name, keys.type, joint=names.joints[keys.joint], frame=frame)
        case DriverEffort():
            return m.Quantity(keys.name, keys.type, driver=names.drivers[keys.driver])
        case Expression():
            return m.Quantity(keys.name, keys.type, value=timed(keys.value), units=keys.units)


def _seen(keys: PointQuantity | RotationError | AngularVelocity, names: Names) -> m.Quantity:
    """What is seen of a body from another one."""
    body, base = names.bodies[keys.body], names.bodies[keys.relative_to]
    frames = {**names.bodies, "body": body, "global": GROUND}
    named = None if isinstance(keys, RotationError) else keys.frame
    frame = base if named is None else frames[named]
    return m.Quantity(
        keys.name,
        keys.type,
        (body,),
        point=vec3(keys.point) if isinstance(keys, PointQuantity) else (0.0, 0.0, 0.0),
        derivative=keys.derivative if isinstance(keys, PointQuantity) else 0,
        relative_to=base,
        frame=frame,
        target=rotation_of(keys.target) if isinstance(keys, RotationError) else None,
    )


# ---------------------------------------------------------------- vectors
def optional(values: Sequence[Number] | None) -> m.Vec3 | None:
    """A vector, or none."""
    return None if values is None else vec3(values)
