"""The nominal numbers of what a sweep varies."""

from typing import cast

from lienumba.groups import so3
from lienumba.keys.conversions import has_rows, inertia_of, rotation_of, timed
from lienumba.keys.types import Inertia, Rotation, Section
from lienumba.numerics.number import Vector
from lienumba.sweep.distributions.base import INERTIA, NUMBER, ROTATION


def nominal_numbers(value: object, shape: str) -> float | Vector:
    """The number of a varied path, or those that the design table has of it: a quaternion w x y z for a rotation, the
    elements xx yy zz xy xz yz of an inertia, the components of a vector. value: checked."""
    if shape == NUMBER:
        return cast(float, timed(value))
    if shape == INERTIA:
        return inertia_of(cast(Inertia, value))
    if shape == ROTATION and (isinstance(value, Section) or has_rows(value)):
        return so3.to_quaternion(rotation_of(cast(Rotation, value)))
    assert isinstance(value, list)
    return tuple(map(timed, value))
