"""Functions that jump at whole numbers: steps of each run land on their jumps, wherever these lie."""

import numpy as np
import pytest

import lienumba
from tests.rigs.inputs import INERTIA, at_hinge


@pytest.mark.parametrize(
    "integrator",
    [
        {"method": "rk4", "step": 0.05},
        {"method": "dop853", "tolerance": 1e-10},
        {"method": "taylor", "tolerance": 1e-10},
    ],
    ids=lambda keys: keys["method"],
)
def test_steps_land_on_jumps(integrator: dict[str, object]) -> None:
    """A wheel under a saw tooth and a staircase, whose periods differ from run to run."""
    system = at_hinge("0.1*mod(t, period) + 0.1*floor(3*t - shift)")
    system.parameter("period", 0.3).parameter("shift", 0.2).vary("parameters.period", "uniform", low=0.21, high=0.4)
    ds = lienumba.run(system, overrides={"sweep.runs": 5, "integrator": {"end_time": 2.0, **integrator}})
    t = ds.time.values
    for run, period in enumerate(ds["parameters.period"].values):
        full = np.floor(t / period)
        saw = full * period**2 / 2 + (t - full * period) ** 2 / 2
        x = 3 * t - 0.2
        stairs = (np.floor(x) * (np.floor(x) - 1) / 2 + np.floor(x) * (x - np.floor(x)) - (1 - 0.8)) / 3
        np.testing.assert_allclose(ds["hinge_at.rate"][run], 0.1 * (saw + stairs) / INERTIA, rtol=0, atol=1e-11)


def test_more_jumps_than_can_be_landed_on_are_passed() -> None:
    ds = lienumba.run(at_hinge("1 + 0*mod(t, 1e-9)"))
    np.testing.assert_allclose(ds["hinge_at.rate"][0, -1], 2.0 / INERTIA, rtol=1e-12)


def test_quantities_and_parameters_may_be_called_as_functions_are() -> None:
    system = at_hinge("floor + mod").parameter("mod", 0.25)
    ds = lienumba.run(system.quantity("floor", "expression", value="floor(t)"))
    np.testing.assert_allclose(ds["hinge_at.rate"][0, -1], (1.0 + 2 * 0.25) / INERTIA, rtol=1e-11)
