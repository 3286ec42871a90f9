"""Formulas of whole runs that jump wherever what moves reaches a whole number, many times in a step."""

from typing import Any

import numpy as np
import pytest
import xarray as xr

import lienumba

END, BEGIN = 2.0, -1.0
STEPS = [
    {"tolerance": 1e-9},
    {"tolerance": 1e-10, "method": "taylor"},
    {"tolerance": 1e-8, "method": "radau5"},
    {"step": 0.05},
    {"step": 0.25, "method": "radau5"},
]
MEASURES = {
    "spike": "integral(exp(0 - (k*(p.x - x0))**2))",  # which is no polynomial in any panel, far away from its place
    "floor": "integral(floor(k*(p.x - x0)))",
    "ceil": "integral(ceil(k*(p.x - x0)))",
    "mod": "integral(mod(p.x - x0, 6/k))",
    "highest": "max(mod(k*(p.x - x0), 1))",
    "odd": "time_when(mod(floor(k*(p.x - x0)), 2) > 0.5)",
    "count": "count(mod(k*(p.x - x0), 2) > 1)",
}


def flown(integrator: dict[str, Any], names: list[str]) -> xr.Dataset:
    """A body flies past at 1 m/s."""
    body = {"name": "b", "mass": 1.0, "inertia": [0.1] * 3, "position": [BEGIN, 0, 0], "velocity": [1, 0, 0]}
    vary = {"parameters.k": {"distribution": "uniform", "low": 5, "high": 100}}
    vary |= {"parameters.x0": {"distribution": "uniform", "low": -1, "high": 1}}
    scenario = {
        "parameters": {"k": 30.0, "x0": 0.0}, "model": {"gravity": [0, 0, 0], "bodies": [body]},
        "quantities": [{"name": "p", "type": "point", "body": "b"}],
        "measures": [{"name": name, "value": MEASURES[name]} for name in names],
        "integrator": integrator | {"end_time": END}, "output": {"every": END},
        "sweep": {"runs": 32, "seed": 1, "vary": vary},
    }  # fmt: skip
    return lienumba.run(scenario, progress=False)


def floors(z: Any) -> Any:
    """The integral of floor from 0 on."""
    n = np.floor(z)
    return n * (z - n) + 0.5 * n * (n - 1)


@pytest.mark.usefixtures("vectors")
@pytest.mark.parametrize("integrator", STEPS, ids=str)
def test_every_jump_is_where_it_is(integrator: dict[str, Any]) -> None:
    """Of 400 runs 390 were wrong by up to a half."""
    ds = flown(integrator, list(MEASURES))
    k, x0 = ds["parameters.k"].values, ds["parameters.x0"].values
    a, b = k * (BEGIN - x0), k * (BEGIN + END - x0)
    whole = (floors(b) - floors(a)) / k
    np.testing.assert_allclose(ds["floor"], whole, rtol=0, atol=2e-6)
    np.testing.assert_allclose(ds["ceil"], whole + END, rtol=0, atol=2e-6)

    def mods(z: Any) -> Any:
        n = np.floor(z / 6)
        return 18 * n + 0.5 * (z - 6 * n) ** 2

    np.testing.assert_allclose(ds["mod"], (mods(b) - mods(a)) / k**2, rtol=0, atol=1e-8)
    np.testing.assert_allclose(ds["highest"], 1.0, rtol=0, atol=1e-6)

    def odds(z: Any) -> Any:
        return np.floor(z / 2) + np.maximum(z % 2 - 1, 0)

    np.testing.assert_allclose(ds["odd"], (odds(b) - odds(a)) / k, rtol=0, atol=1e-6)
    begun = np.floor((b - 1) / 2) - np.floor((a - 1) / 2) + (a % 2 > 1)
    np.testing.assert_array_equal(ds["count"], begun)


@pytest.mark.usefixtures("vectors")
@pytest.mark.parametrize("integrator", STEPS[:2], ids=str)
def test_no_measure_feels_that_another_one_is_noise(integrator: dict[str, Any]) -> None:
    alone, beside = flown(integrator, ["floor"]), flown(integrator, ["spike", "floor"])
    np.testing.assert_allclose(beside["floor"], alone["floor"], rtol=0, atol=2e-6)
