"""Joints and drivers: from their keys, with the numbers of the runs, to those of the model."""

from collections.abc import Sequence

from lienumba.keys.conversions import timed, vec3
from lienumba.keys.types import Section
from lienumba.mechanics.elements.names import Names
from lienumba.mechanics.mechanism import model as m
from lienumba.mechanics.mechanism.model import JointStart
from lienumba.numerics.number import Number
from lienumba.scenario.schema.forces import Driver, JointDriver, PointDriver
from lienumba.scenario.schema.joints import AtPoints, Between, Coupler, Distance, Gear, PythonJoint, Screw


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
def timed3(values: Sequence[object]) -> tuple[m.Timed, m.Timed, m.Timed]:
    """Three numbers, or functions of time."""
    return timed(values[0]), timed(values[1]), timed(values[2])


def optional(values: Sequence[Number] | None) -> m.Vec3 | None:
    """A vector, or none."""
    return None if values is None else vec3(values)


def _pair(values: Sequence[Sequence[Number]] | None) -> tuple[m.Vec3, m.Vec3] | None:
    return None if values is None else (vec3(values[0]), vec3(values[1]))
