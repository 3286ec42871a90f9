"""Random rotations and directions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Discriminator, Field, Tag, model_validator

from lienumba.errors import BadValueError, ScenarioError
from lienumba.groups import so3
from lienumba.numerics.operations import cos, sin, sqrt
from lienumba.sweep.copula import MatrixError, cholesky
from lienumba.sweep.distributions.base import ROTATION, VECTOR, Distribution, Finite, Spread
from lienumba.words import Written

if TYPE_CHECKING:
    Arrays = Sequence[np.ndarray]

TWO_PI = 6.283185307179586
PI = 3.141592653589793
LARGEST = 10.0  # standard deviation in rad; any rotation is likely then
Angle = Annotated[Spread, Field(le=LARGEST)]
Three = Annotated[list[Angle], Field(min_length=3, max_length=3)]
Row = Annotated[list[Annotated[Finite, Field(ge=-(LARGEST**2), le=LARGEST**2)]], Field(min_length=3, max_length=3)]


class RotationNormal(Distribution):
    """R = R0 exp(phi) (body axes) or exp(phi) R0 (global axes), phi normal with mean 0.

    Its streams are those of the components of phi; nominal: a quaternion w x y z of R0, of any length.
    """

    dimensions: ClassVar[int] = 3
    leads_to: ClassVar[str] = ROTATION

    distribution: Literal["rotation_normal"]
    std: (
        Annotated[
            Annotated[Angle, Tag("number")] | Annotated[Three, Tag("three")],
            Discriminator(lambda value: "three" if isinstance(value, list | tuple) else "number"),
        ]
        | None
    ) = Field(
        default=None,
        description="the standard deviation of the rotation vector in rad, from 0 to 10: one number, or [x, y, z]",
    )
    covariance: Annotated[list[Row], Field(min_length=3, max_length=3)] | None = Field(
        default=None, description="the covariance of the rotation vector in rad^2: a 3x3 matrix"
    )
    frame: Literal["body", "global"] = Field(
        default="body", description='the axes of the rotation vector: "body" or "global"'
    )

    @model_validator(mode="after")
    def _one_of_both(self) -> RotationNormal:
        if (self.std is None) == (self.covariance is None):
            both = "has both std and covariance" if self.std is not None else "has neither std nor covariance"
            raise BadValueError(both, "give one of them")
        if self.covariance is not None:
            try:
                cholesky(self.covariance)
            except MatrixError as error:
                wrong = error.problem
                raise BadValueError(wrong.rule, wrong.remedy, "covariance", Written(self.covariance)) from None
        return self

    def factor(self) -> list[list[float]]:
        """L with phi = L z, z standard normal."""
        if self.covariance is not None:
            return cholesky(self.covariance)
        std = self.std if isinstance(self.std, list) else [self.std or 0.0] * 3
        return [[std[i] if i == j else 0.0 for j in range(3)] for i in range(3)]

    def draw(self, u: Arrays, nominal: Any) -> Sequence[np.ndarray | float]:
        from lienumba.sweep.normal import inverse

        z, L = [inverse(x) for x in u], self.factor()
        phi = (L[0][0] * z[0], L[1][0] * z[0] + L[1][1] * z[1], L[2][0] * z[0] + L[2][1] * z[1] + L[2][2] * z[2])
        c, s = so3.half_angle(so3.dot(phi, phi))
        turn, start = (c, *so3.scale(0.5 * s, phi)), _unit(nominal)
        return _product(start, turn) if self.frame == "body" else _product(turn, start)


class RotationUniform(Distribution):
    """Every rotation alike. K. Shoemake, Uniform random rotations, Graphics Gems III (1992)."""

    dimensions: ClassVar[int] = 3
    leads_to: ClassVar[str] = ROTATION

    distribution: Literal["rotation_uniform"]

    @classmethod
    def follows(cls, given: Mapping[str, object]) -> bool:
        return False

    def draw(self, u: Arrays, nominal: Any) -> Sequence[np.ndarray | float]:
        low, high = sqrt(1.0 - u[0]), sqrt(u[0])
        a, b = TWO_PI * u[1], TWO_PI * u[2]
        return high * cos(b), low * sin(a), low * cos(a), high * sin(b)


class Direction(Distribution):
    """A vector of the nominal length, in every direction alike, or in those within an angle of the nominal one."""

    dimensions: ClassVar[int] = 2
    leads_to: ClassVar[str] = VECTOR

    distribution: Literal["direction"]
    angle: Annotated[Finite, Field(gt=0.0, le=PI)] = Field(
        default=PI, description="the largest angle to the nominal direction in rad, above 0 (or omit it: pi)"
    )

    def draw(self, u: Arrays, nominal: Any) -> Sequence[np.ndarray | float]:
        length = sqrt(so3.dot(nominal, nominal))
        if not length > 0.0:
            raise ScenarioError.at(
                "distribution", f"the nominal vector {list(nominal)} has no direction", "give one other than 0"
            )
        half = sin(0.5 * self.angle)
        depth = 2.0 * (half * half) * u[0]  # 1 - cos of the angle to the nominal direction
        sine = sqrt(depth * (2.0 - depth))
        first, second, n = _frame(so3.scale(1.0 / length, nominal))
        a = TWO_PI * u[1]
        local = (sine * cos(a), sine * sin(a), 1.0 - depth)
        return [length * (local[0] * first[i] + local[1] * second[i] + local[2] * n[i]) for i in range(3)]


def _unit(q: Any) -> tuple[Any, ...]:
    length = sqrt(sum(x * x for x in q))
    return tuple(x / length for x in q)


def _product(p: Any, q: Any) -> tuple[Any, ...]:
    """Of quaternions w x y z: first q, then p."""
    a, b = (p[1], p[2], p[3]), (q[1], q[2], q[3])
    vector = so3.add(so3.cross(a, b), so3.add(so3.scale(p[0], b), so3.scale(q[0], a)))
    return (p[0] * q[0] - so3.dot(a, b), *vector)


def _frame(n: so3.Vec3) -> tuple[so3.Vec3, so3.Vec3, so3.Vec3]:
    """Three orthogonal directions, the last of which is n."""
    smallest = min(range(3), key=lambda i: abs(n[i]))
    across = so3.cross(n, tuple(1.0 if i == smallest else 0.0 for i in range(3)))
    first = so3.scale(1.0 / sqrt(so3.dot(across, across)), across)
    return first, so3.cross(n, first), n
