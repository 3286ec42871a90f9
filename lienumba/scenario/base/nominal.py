"""The nominal numbers of what a sweep varies."""

from typing import Any

from lienumba.groups import so3
from lienumba.keys.conversions import inertia_of, rotation_of, timed
from lienumba.sweep.distributions.base import INERTIA, NUMBER, ROTATION


def nominal_numbers(value: Any, shape: str) -> Any:
    """The number of a varied path, or those that the design table has of it: a quaternion w x y z for a rotation, the
    elements xx yy zz xy xz yz of an inertia, the components of a vector."""
    if shape == NUMBER:
        return timed(value)
    if shape == INERTIA:
        return inertia_of(value)
    if shape == ROTATION and (isinstance(value, dict) or isinstance(value[0], list)):
        return so3.to_quaternion(rotation_of(value))
    return tuple(map(timed, value))
