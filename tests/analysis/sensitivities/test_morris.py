"""Elementary effects, against closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from lienumba.analysis import sensitivity
from lienumba.analysis.sensitivities.sensitivity_rows import sensitivity_rows
from lienumba.sweep.samplers import SAMPLERS
from tests.analysis.sweep_example import sweep

UNIFORM = {"distribution": "uniform", "low": 0.0, "high": 1.0}


def samples(sampler: str, runs: int, inputs: str = "abc", seed: int = 5) -> dict[str, np.ndarray]:
    return SAMPLERS[sampler].draw({x: [x] for x in inputs}, np.arange(runs), seed, runs)


def table(sampler: str, inputs: str = "abc", seed: int = 5) -> dict[str, object]:
    return {"sampler": sampler, "seed": seed, "vary": dict.fromkeys(inputs, UNIFORM)}


def test_effects_of_straight_crooked_and_no_inputs() -> None:
    x = samples("morris", 4 * 200)
    ds = sweep(x, vary=table("morris"), y=3 * x["a"] - 2 * x["b"] * x["a"])
    found = sensitivity(ds, "y").isel(output=0)
    a, b, c = (found.sel(input=name) for name in "abc")
    assert a.mu_low < 2.0 < a.mu_high
    assert a.mu_star == pytest.approx(float(a.mu))
    assert a.sigma_low < (1 / 3) ** 0.5 < a.sigma_high
    assert b.mu_low < -1.0 < b.mu_high
    assert b.mu_star_low < 1.0 < b.mu_star_high
    assert (float(c.mu_star), float(c.sigma)) == (0.0, 0.0)
    assert int(found.runs) == 200
    assert "first run of each row" in sensitivity(ds, "y").notes
    headline, shown = sensitivity_rows(sensitivity(ds, "y")).outputs[0].effects(9)
    assert headline == "elementary effects on y, 200 rows"
    assert shown.rows[0][0] == "a"


def test_each_run_moves_one_more_input_by_a_quarter_at_least() -> None:
    x = samples("morris", 4 * 500)
    rows = np.stack(list(x.values())).reshape(3, 500, 4)
    steps = np.diff(rows, axis=2)
    assert ((steps != 0.0).sum(axis=0) == 1).all()
    assert ((steps != 0.0).sum(axis=2) == 1).all()
    assert abs(steps[steps != 0.0]).min() > 0.25 - 1e-12
    assert abs(steps).max() < 0.75 + 1e-12
    np.testing.assert_array_equal(samples("morris", 40)["b"], x["b"][:40])


def test_effects_need_both_ends_of_a_step() -> None:
    x = samples("morris", 4 * 60)
    status = np.zeros(240, np.int8)
    status[::40] = 1
    whole = sweep(x, vary=table("morris"), y=x["a"], status=status)
    found = sensitivity(whole, "y").isel(output=0).sel(input="a")
    assert found.mu_star == pytest.approx(1.0)
    few = sensitivity(whole.isel(run=slice(3, None)), "y").isel(output=0).sel(input="a")
    assert few.mu_star == pytest.approx(1.0)
