"""What touches and comes apart more slowly than it would have to in order to part: it stays, and never chatters."""

from typing import Any

import numpy as np
import pytest

import lienumba
from lienumba.integrators.drivers.events import tolerances
from lienumba.mechanics.system.switched import turning
from tests.oracles.changing import scenarios
from tests.rigs import parts

DEEP, G, END = 4e-11, scenarios.G, 0.1  # m: far less than a billionth of the size of what touches
RATES = [0.0, 1e-7, 1e-6, 1e-5, 2e-5, 2.5e-5]  # m/s, upwards: gravity ends them within DEEP
INTEGRATORS = {
    "dop853": {"method": "dop853", "tolerance": 1e-9},
    "rk4": {"method": "rk4", "step": 1e-3},
    "taylor": {"method": "taylor", "tolerance": 1e-9},
    "radau5": {"method": "radau5", "tolerance": 1e-9},
}


def resting(data: dict[str, Any], path: str, method: str) -> Any:
    """Runs with these rates at a path: all come to rest where they touch, by one change at most."""
    assert max(RATES) ** 2 / (2.0 * G) < DEEP
    data["integrator"] = INTEGRATORS[method] | {"end_time": END}
    ds = lienumba.run(data | {"sweep": scenarios.table({path: RATES})}, progress=False)
    assert (ds.status == 0).all()
    assert (ds.changes <= 1).all()
    assert (ds.steps <= END / 1e-3 + 1).all()
    np.testing.assert_allclose(ds.velocity.isel(time=-1), 0.0, atol=1e-12)
    assert abs(ds.energy_residual).max() < 2.0 * G * DEEP  # what is lifted where it closes
    return ds


def test_kernels_and_drivers_agree_on_what_touches() -> None:
    assert tolerances.SEPARATING_GAP_RTOL == turning.LEAVES


@pytest.mark.parametrize("method", INTEGRATORS)
def test_a_ball_on_its_way_out_of_a_floor_stays(method: str) -> None:
    data = scenarios.ball(0.1, 0.004, END)
    data["model"]["bodies"][0]["position"] = [0, 0, 0.1 - DEEP]
    ds = resting(data, "bodies.ball.velocity[2]", method)
    np.testing.assert_allclose(ds.position.isel(time=-1, body=0, axis=2), 0.1, atol=1e-10)


@pytest.mark.parametrize("method", ["dop853", "rk4"])
def test_a_slider_on_its_way_out_of_a_stop_stays(method: str) -> None:
    slide = parts.slide("slide", "slider", parts.Z, displacement=-DEEP, speed=0.0)
    model = {"gravity": [0, 0, -G], "bodies": [parts.body("slider")], "joints": [slide]}
    model["limits"] = [{"joint": "slide", "low": 0.0, "restitution": 0.3}]
    ds = resting({"title": "A stop", "model": model, "output": {"times": [0, END]}}, "joints.slide.speed", method)
    np.testing.assert_allclose(ds.position.isel(time=-1, body=0, axis=2), 0.0, atol=1e-10)
