"""Balls beside each other: where they might touch, their tangents have a pole along the z axis of one of them."""

from typing import Any

import numpy as np
import pytest

import lienumba
from tests.rigs import parts

STEPS: list[dict[str, Any]] = [
    {"tolerance": 1e-9}, {"tolerance": 1e-9, "coordinates": "joint"}, {"tolerance": 1e-9, "method": "taylor"},
    {"method": "rk4", "step": 1e-3},
]  # fmt: skip
R, M = 0.1, 0.2


def table(gap: float, turn: dict[str, Any] | None = None) -> dict[str, Any]:
    """Two balls on a floor, the second at rest, the first sliding towards it; turn: of the second one's own axes."""
    spin = 0.4 * M * R * R
    first = parts.body("a", M, spin, position=[0, 0, R], velocity=[0.5, 0, 0])
    second = parts.body("b", M, spin, position=[2 * R + gap, 0, R]) | ({"rotation": turn} if turn else {})
    floors = [parts.sphere(f"floor_{n}", n, R, normal=[0, 0, 1], friction=0.2) for n in "ab"]
    click = parts.foot("click", "a", to="b", type="sphere_sphere", radii=[R, R], friction=0.3, restitution=0.9)
    return {
        "model": {"gravity": [0, 0, -9.81], "bodies": [first, second], "contacts": [*floors, click]},
        "output": {"every": 1.0},
    }


@pytest.mark.parametrize("steps", STEPS, ids=str)
@pytest.mark.parametrize("gap", [2e-4, 0.15, 5.0])
def test_balls_of_one_height(gap: float, steps: dict[str, Any]) -> None:
    """Their normal has no z at all, whatever the axes of the second ball are; far apart the first one rolls in the end
    with 5/7 of its speed."""
    integrator = {"integrator": steps | {"end_time": 1.0}}
    found, other = (lienumba.run(table(gap, turn) | integrator) for turn in (None, {"axis": [1, 2, 3], "angle": 0.7}))
    assert found.status.item() == other.status.item() == 0
    for name in ("position", "velocity", "angular_velocity"):
        loose = 1e-8 if "tolerance" in steps else 1e-4
        if name != "angular_velocity":  # which is told along the axes of the body
            np.testing.assert_allclose(found[name].values, other[name].values, atol=loose)
    if gap == 5.0:
        np.testing.assert_allclose(found.velocity.values[0, -1, 0], [0.5 * 5 / 7, 0, 0], atol=1e-4)


@pytest.mark.parametrize("steps", STEPS[:3], ids=str)
def test_a_ball_that_comes_down_beside_another_one(steps: dict[str, Any]) -> None:
    """A pendulum that passes the height of a ball on the floor before it hits it: as if it hung a little otherwise."""
    ball = parts.body("q", 0.6, 0.0024, position=[0.25, 0.06, R])

    def ended(lift: float) -> np.ndarray:
        bob = parts.body("p", 1, 0.002, position=[-0.8, 0, 0.9 + lift])
        hinge = parts.hinge("A", "p", [0, 0, 0.9 + lift])
        hit = parts.foot("c", "p", to="q", type="sphere_sphere", radii=[R, R], restitution=0.6, friction=0.2)
        floor = parts.sphere("f", "q", R, normal=[0, 0, 1], restitution=0.3, friction=0.4)
        model = {"gravity": [0, 0, -9.81], "bodies": [bob, ball], "joints": [hinge], "contacts": [hit, floor]}
        found = lienumba.run({"model": model, "integrator": steps | {"end_time": 1.0}, "output": {"every": 1.0}})
        assert found.status.item() == 0
        values: np.ndarray = found.last_position.values[0]
        return values

    np.testing.assert_allclose(ended(0.0), 0.5 * (ended(1e-5) + ended(-1e-5)), atol=1e-6)
