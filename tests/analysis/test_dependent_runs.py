"""Runs that are no independent draws: rows that repeat their numbers, and points that are spread evenly."""

from typing import Any

import numpy as np
import pytest
import xarray as xr

import lienumba
from lienumba import analysis

pytestmark = pytest.mark.filterwarnings("ignore:.*nothing uses it")
LETTERS = "abcdefgh"
BODY = {"name": "b", "mass": 1.0, "inertia": [1, 1, 1], "position": [0, 0, 0], "rotation": [1, 0, 0, 0]}


def swept(value: str, sweep: dict[str, Any], varied: dict[str, Any]) -> xr.Dataset:
    return lienumba.run({
        "parameters": dict.fromkeys(LETTERS, 0.1), "model": {"gravity": [0, 0, 0], "bodies": [BODY]},
        "quantities": [{"name": "q", "type": "expression", "value": value}],
        "measures": [{"name": "y", "value": "final(q)"}],
        "integrator": {"step": 0.1, "end_time": 0.1}, "output": {"mode": "summary"},
        "sweep": sweep | {"vary": {f"parameters.{letter}": kind for letter, kind in varied.items()}},
    }, progress=False)  # fmt: skip


NORMAL = {letter: {"distribution": "normal", "mean": 0.0, "std": 1.0} for letter in LETTERS}


@pytest.mark.parametrize(("sampler", "runs", "counting"), [("morris", 9 * 35, 35), ("saltelli_second", 18 * 16, 32)])
def test_differences_count_one_run_of_each_row(sampler: str, runs: int, counting: int) -> None:
    """All runs of a row move one input after another: taken for independent, 12 of 30 intervals missed the truth."""
    missed, trials = 0, 40
    for seed in range(trials):
        sweep = {"runs": runs, "sampler": sampler, "seed": seed}
        one, other = (swept(value, sweep, NORMAL) for value in ("a", "1.5*a + 0.1"))
        found = analysis.compare(one, other, "y")
        missed += not found.difference_low.item() <= 0.1 <= found.difference_high.item()
    assert found.pairs.item() == counting
    assert f"{counting} of the runs count, since the others of each row repeat their numbers" in found.attrs["notes"]
    assert missed <= 6  # of 2 that are expected


def test_a_sweep_is_not_ended_by_runs_that_repeat_their_numbers() -> None:
    """The mean of 100 rows of nine is not known as well as that of 900 runs."""
    stop = {"variable": "y", "width": 0.5, "every": 90}
    by_rows = swept("a + b", {"runs": 1800, "sampler": "morris", "seed": 3, "stop": stop}, NORMAL)
    by_chance = swept("a + b", {"runs": 1800, "seed": 3, "stop": stop}, NORMAL)
    rows = by_rows.sizes["run"] // 9
    assert 0.5 * by_chance.sizes["run"] < rows + 10 < 2.0 * by_chance.sizes["run"]


@pytest.mark.parametrize("sampler", ["sobol", "halton"])
def test_first_indices_of_runs_that_are_spread_evenly(sampler: str) -> None:
    """The noise of groups is less than by chance: taken off as a whole, 20 of 20 intervals lay below 0."""
    circle = {"distribution": "uniform", "low": -np.pi, "high": np.pi}
    truth = [0.313905, 0.442411, 0.0]
    for seed in range(8):
        ds = swept("sin(a) + 7*sin(b)**2 + 0.1*c**4*sin(a)", {"runs": 1024, "sampler": sampler, "seed": seed},
                   dict.fromkeys("abc", circle))  # fmt: skip
        found = analysis.sensitivity(ds, output="y").sel(output="y")
        assert (found.first_order_low.values <= truth).all()
        assert (found.first_order_high.values >= truth).all()
        assert found.first_order.values == pytest.approx(truth, abs=0.05)
