"""From the forms in which keys give numbers to those of the model: inertias, rotations, formulas.

A number is a float, or an array (runs,) where the sweep varies it; every conversion here works on both.
"""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

from lienumba.errors import Problem
from lienumba.groups import so3
from lienumba.keys.types import AxisAngle, Euler, Inertia, Rotation, RotationVector
from lienumba.numerics.expressions import Formula
from lienumba.numerics.number import Matrix, Number
from lienumba.numerics.operations import cos, divide, sin, sqrt

if TYPE_CHECKING:
    from typing_extensions import TypeIs

Vec3 = tuple[Number, Number, Number]


def vec3(values: Sequence[Number]) -> Vec3:
    """A vector."""
    return values[0], values[1], values[2]


def norm(values: Sequence[float]) -> float:
    """Of a vector or a quaternion, without overflow."""
    scale = max(abs(value) for value in values)
    return float(scale * sum((value / scale) ** 2 for value in values) ** 0.5) if scale else 0.0


def has_direction(v: Sequence[float]) -> bool:
    """Whether a vector is neither 0 nor endless."""
    return 1e-100 < norm(v) < 1e100


def undirected(key: str, v: Sequence[float] | None) -> Iterator[Problem]:
    """The problem of a vector that is given, and has no direction."""
    if v is not None and not has_direction(v):
        yield Problem(key, "has no direction", "give 3 numbers that are not all 0", v)


def timed(value: object) -> Any:
    """A number, or the function of time that a text describes; a text without t is a number too."""
    if not isinstance(value, str):
        return value
    formula = Formula(value)
    return formula if formula.constant is None else formula.constant


def timed3(values: Sequence[Any]) -> tuple[Any, Any, Any]:
    """Three of them."""
    return timed(values[0]), timed(values[1]), timed(values[2])


def tensor_of(inertia: Inertia) -> list[list[float]]:
    """The 3x3 matrix of an inertia in any of its three forms."""
    if has_rows(inertia):
        return inertia
    xx, yy, zz, xy, xz, yz = inertia if len(inertia) == 6 else [*inertia, 0.0, 0.0, 0.0]
    return [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]


def inertia_of(inertia: Inertia) -> tuple[Number, ...]:
    """The elements xx yy zz xy xz yz of an inertia in any of its three forms."""
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = tensor_of(inertia)
    return xx, yy, zz, _mean(xy, yx), _mean(xz, zx), _mean(yz, zy)


def _mean(a: Number, b: Number) -> Number:
    """Of two nearly equal numbers; of one and the same, that number itself."""
    return a if a is b else 0.5 * (a + b)


def rotation_of(rotation: Rotation) -> Matrix:
    """The matrix, row major, of a rotation in any of its five forms."""
    if isinstance(rotation, AxisAngle):
        x, y, z = rotation.axis
        length = sqrt(x * x + y * y + z * z)
        return so3.exp(so3.scale(divide(rotation.angle, length), (x, y, z)))
    if isinstance(rotation, RotationVector):
        return so3.exp(vec3(rotation.rotation_vector))
    if isinstance(rotation, Euler):
        matrix: Matrix = so3.IDENTITY
        for axis, angle in zip(rotation.euler, rotation.angles, strict=True):
            matrix = so3.multiply(matrix, elementary("XYZ".index(axis), angle))
        return matrix
    if has_rows(rotation):
        return _orthonormal(rotation)
    w, x, y, z = rotation
    return so3.from_quaternion((w, x, y, z))


def has_rows(value: object) -> "TypeIs[list[list[float]]]":
    """Whether a rotation or an inertia is written as a matrix."""
    return isinstance(value, list) and isinstance(value[0], list)


def elementary(axis: int, angle: Number) -> Matrix:
    """The rotation about a coordinate axis (0, 1, 2) by an angle in rad."""
    c, s = cos(angle), sin(angle)
    if axis == 0:
        return (1.0, 0.0, 0.0, 0.0, c, -s, 0.0, s, c)
    if axis == 1:
        return (c, 0.0, s, 0.0, 1.0, 0.0, -s, 0.0, c)
    return (c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0)


def _orthonormal(rows: list[list[float]]) -> Matrix:
    """The rotation nearest to a matrix that is orthogonal within 1e-6 (two steps R <- R (3 I - R^T R)/2).

    Unlike a singular value decomposition, exact zeros that the structure of R implies stay exact.
    """
    matrix = tuple(element for row in rows for element in row)
    for _ in range(2):
        gram = so3.multiply(so3.transpose(matrix), matrix)
        correction = tuple(1.5 * one - 0.5 * element for one, element in zip(so3.IDENTITY, gram, strict=True))
        matrix = so3.multiply(matrix, correction)
    return matrix
