"""Contacts that touch and carry nothing have no friction, however rough: what is beside a wall falls freely."""

from typing import Any

import numpy as np
import pytest

import lienumba
from tests.rigs import parts

G, MU = 9.81, 0.5
RADIUS, INERTIA = 0.1, 0.004
INTEGRATORS: tuple[dict[str, Any], ...] = ({"method": "dop853", "tolerance": 1e-9}, {"method": "rk4", "step": 1e-3})
CORNERS = ((0.1, 0.1), (-0.1, 0.1), (0.1, -0.1), (-0.1, -0.1))


FRICTION = {"static": 0.6, "kinetic": MU}


def body(x: float, **more: Any) -> dict[str, Any]:
    return parts.body("body", 1, INERTIA, position=[x, 0, 1], **more)


def wall(name: str, point: tuple[float, float, float], **more: Any) -> dict[str, Any]:
    return parts.foot(name, "body", point, normal=[-1, 0, 0], friction=FRICTION, **more)


def ball(**more: Any) -> dict[str, Any]:
    contact = wall("wall", (0, 0, 0), type="sphere_plane", radius=RADIUS)
    return {"gravity": [0, 0, -G], "bodies": [body(-RADIUS, **more)], "contacts": [contact]}


def box() -> dict[str, Any]:
    contacts = [wall(f"w{n}", (0.1, *corner)) for n, corner in enumerate(CORNERS)]
    return {"gravity": [0, 0, -G], "bodies": [body(-0.1)], "contacts": contacts}


def rod(height: float) -> dict[str, Any]:
    """Askew, so that friction would turn it into the wall, or away from it."""
    return {"gravity": [0, 0, -G], "bodies": [body(-0.5)], "contacts": [wall("wall", (0.5, 0, height))]}


@pytest.mark.parametrize("integrator", INTEGRATORS, ids=["dop853", "rk4"])
@pytest.mark.parametrize(
    ("model", "rises"),
    [(ball(), 0.0), (ball(velocity=[0, 0, 2.0]), 2.0), (box(), 0.0), (rod(-0.8), 0.0), (rod(0.8), 0.0)],
    ids=["ball", "thrown up", "box", "rod leaning on it", "rod hanging from it"],
)
def test_what_nothing_presses_falls_freely(model: dict[str, Any], rises: float, integrator: dict[str, Any]) -> None:
    ds = lienumba.run({"model": model, "integrator": integrator | {"end_time": 0.5}, "output": {"every": 0.1}})
    assert ds.status.values.tolist() == [0]
    t, start = ds.time.values, model["bodies"][0]["position"]
    np.testing.assert_allclose(ds.position.values[0, :, 0, 2], start[2] + rises * t - G * t**2 / 2, atol=1e-10)
    np.testing.assert_allclose(ds.position.values[0, :, 0, :2], np.tile(start[:2], (len(t), 1)), atol=1e-10)
    np.testing.assert_allclose(ds.angular_velocity.values, 0.0, atol=1e-9)


@pytest.mark.parametrize("integrator", INTEGRATORS, ids=["dop853", "rk4"])
@pytest.mark.parametrize("grows", [10.0, -10.0], ids=["pressed", "drawn"])
def test_a_load_that_grows_from_nothing(grows: float, integrator: dict[str, Any]) -> None:
    """Pressed against the wall by 10 t it slides until friction has spun it to rolling, drawn away it leaves."""
    model = ball() | {"forces": [{"type": "force", "body": "body", "value": ["push*t", 0, 0]}]}
    ds = lienumba.run(
        {"parameters": {"push": grows}, "model": model, "integrator": integrator | {"end_time": 1.0},
         "output": {"every": 0.1}},
    )  # fmt: skip
    assert ds.status.values.tolist() == [0]
    t, friction = ds.time.values, MU * max(grows, 0.0)
    slip = -G + friction * (1.0 + RADIUS**2 / INERTIA) / 2 * t[-1]
    assert slip < 0.0  # still slides
    np.testing.assert_allclose(ds.position.values[0, :, 0, 2], 1.0 - G * t**2 / 2 + friction * t**3 / 6, atol=1e-9)
    np.testing.assert_allclose(ds.position.values[0, :, 0, 0], -RADIUS + min(grows, 0.0) * t**3 / 6, atol=1e-9)
    np.testing.assert_allclose(
        abs(ds.angular_velocity.values[0, :, 0, 1]), RADIUS * friction * t**2 / 2 / INERTIA, atol=1e-8
    )
