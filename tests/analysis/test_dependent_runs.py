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


def swept(sweep: dict[str, Any], varied: dict[str, Any], **outputs: str) -> xr.Dataset:
    return lienumba.run({
        "parameters": dict.fromkeys(LETTERS, 0.1), "model": {"gravity": [0, 0, 0], "bodies": [BODY]},
        "quantities": [{"name": f"q_{y}", "type": "expression", "value": value} for y, value in outputs.items()],
        "measures": [{"name": y, "value": f"final(q_{y})"} for y in outputs],
        "integrator": {"step": 0.1, "end_time": 0.1}, "output": {"mode": "summary"},
        "sweep": sweep | {"vary": {f"parameters.{letter}": kind for letter, kind in varied.items()}},
    }, progress=False)  # fmt: skip


NORMAL = {letter: {"distribution": "normal", "mean": 0.0, "std": 1.0} for letter in LETTERS}


@pytest.mark.parametrize(("sampler", "runs", "counting"), [("morris", 9 * 35, 35), ("saltelli", 10 * 16, 32)])
def test_differences_count_one_run_of_each_row(sampler: str, runs: int, counting: int) -> None:
    """All runs of a row move one input after another: taken for independent, 12 of 30 intervals missed the truth."""
    held = 0
    for seed in range(3):  # of eight outputs each, whose inputs are independent
        sweep = {"runs": runs, "sampler": sampler, "seed": seed}
        one = swept(sweep, NORMAL, **{f"y_{x}": x for x in LETTERS})
        other = swept(sweep, NORMAL, **{f"y_{x}": f"1.5*{x} + 0.1" for x in LETTERS})
        found = analysis.compare(one, other, [f"y_{x}" for x in LETTERS])
        held += int(((found.difference_low <= 0.1) & (found.difference_high >= 0.1)).sum())
    np.testing.assert_array_equal(found.pairs, [counting] * len(LETTERS))
    assert f"{counting} of the runs count, since the others of each row repeat their numbers" in found.attrs["notes"]
    assert held >= 20  # of 24, of which 1.2 are expected to miss


def test_a_sweep_is_not_ended_by_runs_that_repeat_their_numbers() -> None:
    """The mean of 100 rows of nine is not known as well as that of 900 runs."""
    stop = {"variable": "y", "width": 0.5, "every": 90}
    by_rows = swept({"runs": 1800, "sampler": "morris", "seed": 3, "stop": stop}, NORMAL, y="a + b")
    by_chance = swept({"runs": 1800, "seed": 3, "stop": stop}, NORMAL, y="a + b")
    rows = by_rows.sizes["run"] // 9
    assert 0.5 * by_chance.sizes["run"] < rows + 10 < 2.0 * by_chance.sizes["run"]


@pytest.mark.parametrize("sampler", ["sobol", "halton"])
def test_first_indices_of_runs_that_are_spread_evenly(sampler: str) -> None:
    """The noise of groups is less than by chance: taken off as a whole, 20 of 20 intervals lay below 0."""
    circle = {"distribution": "uniform", "low": -np.pi, "high": np.pi}
    truth = [0.313905, 0.442411, 0.0]
    for seed in range(8):
        sweep = {"runs": 1024, "sampler": sampler, "seed": seed}
        ds = swept(sweep, dict.fromkeys("abc", circle), y="sin(a) + 7*sin(b)**2 + 0.1*c**4*sin(a)")
        found = analysis.sensitivity(ds, output="y").sel(output="y")
        assert (found.first_order_low.values <= truth).all()
        assert (found.first_order_high.values >= truth).all()
        assert found.first_order.values == pytest.approx(truth, abs=0.05)
