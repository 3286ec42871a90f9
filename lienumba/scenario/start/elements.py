"""Joints, drivers, forces and quantities: from their keys, with the numbers of the runs, to those of the model."""

from collections.abc import Sequence

from lienumba.keys.conversions import rotation_of, timed, vec3
from lienumba.keys.types import Section
from lienumba.mechanics.elements.forces import FORCE_TYPES
from lienumba.mechanics.elements.names import Names
from lienumba.mechanics.mechanism import model as m
from lienumba.mechanics.mechanism.model import GROUND, JointStart
from lienumba.numerics.number import Number
from lienumba.scenario.base.code import PYTHON
from lienumba.scenario.schema.forces import Driver, Force, JointDriver, PointDriver, PythonForce
from lienumba.scenario.schema.joints import AtPoints, Between, Coupler, Distance, Gear, PythonJoint, Screw
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


# ---------------------------------------------------------------- joints
def joint(keys: Section, names: Names) -> m.Joint:
    """A joint of the model."""
    if isinstance(keys, PythonJoint):
        return _own_joint(keys, names)
    if isinstance(keys, Gear | Coupler):
        first, second = (names.coordinate(*x) for x in zip(keys.joints, keys.coordinates or (None, None), strict=True))
        ends = dict.fromkeys(i for name in keys.joints for i in names.ends(name))
        return m.Joint(
            keys.name, keys.type, tuple(ends), coordinates=(first, second), ratio=keys.ratio, offset=keys.offset
        )
    assert isinstance(keys, Between)
    return m.Joint(
        keys.name,
        type_of(keys),
        tuple(names.bodies[name] for name in keys.bodies),
        _pair(keys.points if isinstance(keys, AtPoints) else None),
        length=keys.length if isinstance(keys, Distance) else None,
        pitch=keys.pitch if isinstance(keys, Screw) else None,
    )


def type_of(keys: Section) -> str:
    """The name of an element's class."""
    return str(getattr(keys, "type"))  # noqa: B009


def _own_joint(keys: PythonJoint, names: Names) -> m.Joint:
    letters = {"m": "m", "rad": "r"}
    rows = "".join(letters[row] for row in keys.rows or [])
    place = f"model.joints.{keys.name}"
    code = names.code(place, keys.function, keys.bodies, keys.parameters, returns=rows, level=keys.level)
    ends = tuple(names.bodies[name] for name in keys.bodies)
    return m.Joint(keys.name, keys.type, ends, numbers={**keys.parameters}, code=code)


def joint_start(keys: Section) -> JointStart:
    """How a joint is placed, and what is known of it at the start."""
    given = dict(keys)
    axes, axis = given.get("axes"), given.get("axis")
    if axes is not None and len(axes) == 1:
        axes = [axes[0], [0.0, 0.0, 1.0]]  # of the first body alone
    if axis is not None:
        axis = tuple(map(vec3, axis)) if isinstance(axis[0], list) else (vec3(axis),)
    return JointStart(
        axes=_pair(axes),
        references=_pair(given.get("references")),
        at=optional(given.get("at")),
        axis=axis,
        **{name: given.get(name) for name in ("angle", "rate", "displacement", "speed")},
    )


# ---------------------------------------------------------------- drivers and forces
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


def force(keys: Force, names: Names) -> m.Force:
    """A force of the model."""
    if isinstance(keys, PythonForce):
        return _own_force(keys, names)
    kind, given = FORCE_TYPES[keys.type], dict(keys)
    points = given.get("points") or ([given["point"]] if "point" in given else [])
    numbers = {name: given[name] for name in kind.numbers if given[name] is not None}
    of_joint = kind.ends == "joint"
    ends = given.get("bodies") or ([] if of_joint else [given["body"]])
    return m.Force(
        name=keys.name,
        type=keys.type,
        bodies=names.ends(given["joint"]) if of_joint else tuple(names.bodies[name] for name in ends),
        points=tuple(map(vec3, points)),
        coordinate=names.coordinate(given["joint"], given["coordinate"]) if of_joint else None,
        frame=given.get("frame", "global"),
        numbers={name: timed3(x) if isinstance(x, list) else timed(x) for name, x in numbers.items()},
    )


def _own_force(keys: PythonForce, names: Names) -> m.Force:
    code = names.code(
        f"model.forces.{keys.name}",
        keys.function,
        [*keys.bodies, *keys.joints],
        keys.parameters,
        returns=keys.returns,
        joints=tuple(names.joints[name] for name in keys.joints),
        states=list(keys.states),
        every=keys.every,
    )
    numbers = {name: timed(x) for name, x in keys.parameters.items()}
    ends = tuple(names.bodies[name] for name in keys.bodies)
    return m.Force(keys.name, PYTHON, ends, numbers=numbers, code=code, initial={**keys.states})


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
def timed3(values: Sequence[object]) -> tuple[m.Timed, m.Timed, m.Timed]:
    """Three numbers, or functions of time."""
    return timed(values[0]), timed(values[1]), timed(values[2])


def optional(values: Sequence[Number] | None) -> m.Vec3 | None:
    """A vector, or none."""
    return None if values is None else vec3(values)


def _pair(values: Sequence[Sequence[Number]] | None) -> tuple[m.Vec3, m.Vec3] | None:
    return None if values is None else (vec3(values[0]), vec3(values[1]))
