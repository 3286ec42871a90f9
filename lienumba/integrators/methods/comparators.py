"""Charts to compare with: rotations in coordinates of a vector space, as is common outside Lie groups.

The coordinates q(R) of a rotation are integrated as q' = E(q) w, beside r, v and w themselves. Each step begins with
those of the R that the last one left, so a chart that covers one turn only jumps from its end to its beginning, and
one that has singular attitudes meets them where the body does.
"""

from collections.abc import Callable
from dataclasses import dataclass

from lienumba.groups import so3
from lienumba.groups.state import State
from lienumba.integrators.methods.charts import Chart, Coordinates, Field
from lienumba.keys.registry import Registry
from lienumba.numerics.number import Matrix, Number, Vector
from lienumba.numerics.operations import atan2, cos, divide, sin, sqrt

Q = Vector  # coordinates of a rotation


@dataclass(frozen=True)
class Parametrised(Chart):
    """words: what a citation calls them; numbers: of q; of: R -> q; matrix: q -> R; rates: (q, w) -> q'; bound: no turn
    by up to a quarter of a full one has a square (rad^2) above this times that of the change of q; note: what the key's
    description says behind the name."""

    name: str
    words: str
    numbers: int
    of: Callable[[Matrix], Q]
    matrix: Callable[[Q], Matrix]
    rates: Callable[[Q, Vector], Q]
    bound: float
    plain: bool = True
    note: str = ""
    orthogonal: bool = True

    @property
    def size(self) -> int:
        return 9 + self.numbers

    def _at(self, x: State, u: Coordinates) -> Q:
        return _sum(self.of(x[3:12]), u[3:-6])

    def moved(self, x: State, u: Coordinates) -> State:
        return so3.add(x[0:3], u[0:3]) + self.matrix(self._at(x, u)) + _sum(x[12:18], u[-6:])

    def slope(self, x: State, u: Coordinates, at: State, f: Field) -> Coordinates:
        return f[0:3] + self.rates(self._at(x, u), f[3:6]) + f[6:12]

    def composed(self, u: Coordinates, w: Coordinates) -> Coordinates:
        return _sum(u, w)

    def rotation(self, u: Coordinates) -> Number:
        square: Number = 0.0
        for c in u[3:-6]:
            square = square + c * c
        return self.bound * square


def _sum(a: Vector, b: Vector) -> Vector:
    return tuple(x + y for x, y in zip(a, b, strict=True))


# ---------------------------------------------------------------- the nine elements of R
def _same(R: Matrix) -> Matrix:
    return R


def _matrix_rates(R: Matrix, w: Vector) -> Q:
    """R' = R hat(w), of any matrix R: nothing keeps it orthogonal."""
    return so3.multiply(R, so3.hat(w))


# ---------------------------------------------------------------- Tait-Bryan angles, 3-2-1
def tait_bryan(R: Matrix) -> Q:
    """(phi, theta, psi) (rad) with R = R_z(psi) R_y(theta) R_x(phi) and |theta| <= pi/2."""
    return (atan2(R[7], R[8]), atan2(-R[6], sqrt(R[0] * R[0] + R[3] * R[3])), atan2(R[3], R[0]))


def _of_tait_bryan(q: Q) -> Matrix:
    turns = [so3.exp(u) for u in ((0.0, 0.0, q[2]), (0.0, q[1], 0.0), (q[0], 0.0, 0.0))]
    return so3.multiply(turns[0], so3.multiply(turns[1], turns[2]))


def _tait_bryan_rates(q: Q, w: Vector) -> Q:
    """Infinite at theta = +-pi/2, the gimbal lock."""
    s, c = sin(q[0]), cos(q[0])
    across = divide(w[1] * s + w[2] * c, cos(q[1]))
    return (w[0] + across * sin(q[1]), w[1] * c - w[2] * s, across)


# ---------------------------------------------------------------- the rotation vector, |q| <= pi at the start of a step
def _rotation_vector_rates(q: Q, w: Vector) -> Q:
    """Infinite at |q| = 2 pi."""
    return so3.dexpinv((-q[0], -q[1], -q[2]), w)


# ---------------------------------------------------------------- the quaternion, a unit one at the start of a step
def _quaternion_rates(q: Q, w: Vector) -> Q:
    """q (0, w) / 2; R is that of q whatever its length."""
    v = so3.add(so3.scale(q[0], w), so3.cross(q[1:4], w))
    return (-0.5 * so3.dot(q[1:4], w), 0.5 * v[0], 0.5 * v[1], 0.5 * v[2])


COORDINATES: Registry[Parametrised] = Registry("coordinates", lambda chart: chart.name)
for chart in (
    Parametrised(
        "matrix",
        "the nine elements of their matrices",
        9,
        _same,
        _same,
        _matrix_rates,
        0.62,
        note="its nine elements",
        orthogonal=False,
    ),
    Parametrised(
        "tait_bryan", "Tait-Bryan angles", 3, tait_bryan, _of_tait_bryan, _tait_bryan_rates, 2.0, note="angles"
    ),
    Parametrised("rotation_vector", "rotation vectors", 3, so3.log, so3.exp, _rotation_vector_rates, 1.0),
    Parametrised("quaternion", "quaternions", 4, so3.to_quaternion, so3.from_quaternion, _quaternion_rates, 4.22),
):
    COORDINATES.add(chart)
