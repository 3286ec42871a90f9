"""What may be taken for the same wherever it is: nothing that could be something else where nobody looked."""

from typing import Any

import numpy as np
import pytest

from lienumba.compiler.symbols import Graph
from lienumba.integrators.tracing.linear.unbalanced import analytic, unbalanced
from lienumba.numerics.operations import cos, exp, sin, sqrt, where

G = Graph(analytic=True)
X, Y, ANGLE = G.inputs("state", 3)
MASS, SPEED = G.input("parameters", 0), G.input("unknown", 0)


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        (3.0, True), (MASS, True), (X * Y - 2.0 * X, True), (sin(X) * cos(X) / MASS, True), (X * exp(MASS), True),
        (SPEED * exp(X), True), (1.0 / X, False), (exp(-X * X), False), (where(X < Y, 1.0, 0.0), False),
        (sqrt(X * X), False), (ANGLE + X, False),
    ],
)  # fmt: skip
def test_analytic(value: Any, expected: bool) -> None:
    """Velocities are 0; counted angles move in ways of their own."""
    found = analytic([value], lambda array, row: 0.0 if array == "unknown" else None, {("state", 2)})
    assert found.tolist() == [expected]


def test_the_largest_force_that_never_changes() -> None:
    """Of three runs: one that falls, one whose forces change, one on which nothing acts but rounding."""
    forces = np.array([[[2.0, -3.0], [1.0, 2.0], [0.0, 0.0]], [[2.0, -3.0], [1.5, 2.5], [0.0, 0.0]]])
    assert unbalanced(forces).tolist() == [3.0, 0.0, 0.0]
    forces[1, 0, 1] += 1e-15
    forces[:, 2] = [[1e-16, 1.0], [1e-16, 2.0]]
    assert unbalanced(forces).tolist() == [3.0, 0.0, 0.0]
