"""Random inertias that a body can have: it is stretched, with all its mass."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field

from lienumba.errors import ScenarioError
from lienumba.groups import so3
from lienumba.sweep.distributions.base import INERTIA, Distribution, Finite

SQRT_HALF = 0.7071067811865476
HALVINGS, TERMS = 7, 9  # exp(S) = exp(S/2^7)^(2^7); entries of S stay below 10
ROUNDING = 1e-12  # how far the nominal inertia may miss the triangle inequality, relative to its trace


class Inertia(Distribution):
    """The nominal body, stretched by A = exp(S): with the matrix P of its second moments, the inertia of A P A^T.

    S is a symmetric matrix of independent normal numbers, whose distribution looks the same in all axes: std/2 on the
    diagonal, std/sqrt(8) beside it. nominal: xx yy zz xy xz yz about the mass centre, in the body frame.
    """

    dimensions: ClassVar[int] = 6
    leads_to: ClassVar[str] = INERTIA

    distribution: Literal["inertia"]
    std: Annotated[Finite, Field(ge=0.0, le=1.0)] = Field(
        description="the relative standard deviation of the second moments, from 0 to 1"
    )

    def draw(self, u: Sequence[np.ndarray], nominal: Any) -> Sequence[np.ndarray | float]:
        from lienumba.sweep.normal import inverse

        P = second_moments(nominal)
        z = [0.5 * self.std * inverse(x) for x in u]
        xx, yy, zz, xy, xz, yz = *z[:3], *(SQRT_HALF * x for x in z[3:])
        A = _exponential((xx, xy, xz, xy, yy, yz, xz, yz, zz))
        P = so3.multiply(so3.multiply(A, P), A)  # A is symmetric
        return P[4] + P[8], P[0] + P[8], P[0] + P[4], -P[1], -P[2], -P[5]


def second_moments(inertia: Any) -> so3.Matrix3:
    """P = tr(J)/2 I - J, the integrals of r r^T dm; a ScenarioError where no body has this inertia."""
    xx, yy, zz, xy, xz, yz = inertia
    half = 0.5 * (xx + yy + zz)
    a, b, c, room = half - xx, half - yy, half - zz, ROUNDING * half
    minors = (a * b - xy * xy, a * c - xz * xz, b * c - yz * yz)
    determinant = a * minors[2] - xy * (xy * c + xz * yz) - xz * (xy * yz + xz * b)
    if min(a, b, c) < -room or min(minors) < -room * half or determinant < -room * half * half:
        raise ScenarioError.at(
            "distribution",
            (
                f"no body has the nominal inertia {[float(x) for x in inertia]}, of whose principal moments one "
                "is larger than the sum of the others (the triangle inequality)"
            ),
            "correct it, or vary its elements one by one",
        )
    return (a, -xy, -xz, -xy, b, -yz, -xz, -yz, c)


def _exponential(S: so3.Matrix3) -> so3.Matrix3:
    """exp of a matrix by its series, after halving, squared again."""
    S = tuple(x / 2.0**HALVINGS for x in S)
    A = so3.IDENTITY
    for k in range(TERMS, 0, -1):
        A = tuple(one + x / k for one, x in zip(so3.IDENTITY, so3.multiply(S, A), strict=True))
    for _ in range(HALVINGS):
        A = so3.multiply(A, A)
    return A
