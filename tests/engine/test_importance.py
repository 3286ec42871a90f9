"""Sweeps by importance sampling: weights in the dataset, respected by what is said of it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from scipy import stats

import lienumba
from lienumba import analysis
from lienumba.scenario.start.samples_file import sample
from lienumba.store.outputs import Output
from tests.facade import ScenarioError, resolve

FALL: dict[str, Any] = {
    "parameters": {"push": 1.0},
    "model": {
        "bodies": [
            {"name": "ball", "mass": 1.0, "inertia": [1, 1, 1], "velocity": ["push", 0, 0], "position": [0, 0, 0]}
        ]
    },
    "integrator": {"step": 0.05, "end_time": 0.1},
    "output": {"mode": "summary"},
    "requirements": [{"name": "slow", "value": "last_velocity.ball.x", "below": 1.35, "probability": 0.999}],
    "sweep": {
        "runs": 2000,
        "sampler": "importance",
        "vary": {"parameters.push": {"distribution": "normal", "std": 0.1}},
        "proposal": {"parameters.push": {"shift": 3.5}},
    },
}
RARE = stats.norm.sf(3.5)


@pytest.fixture(scope="module")
def ds() -> xr.Dataset:
    return lienumba.run(FALL)


def test_a_verdict_finds_what_is_rare(ds: xr.Dataset) -> None:
    found = analysis.verdicts(ds).sel(requirement="slow")
    assert float(found.at_least) < 1 - RARE < float(found.at_most)
    assert float(found.at_most - found.at_least) < 0.35 * RARE
    assert str(found.verdict.values) == "met"
    assert 100 < float(found.effective) < 500
    assert float(found.margin) > 0.0
    assert f"{float(found.effective):,.0f} runs without" in found.attrs.get("notes", analysis.verdicts(ds).notes)


def test_statistics_are_those_of_the_inputs(ds: xr.Dataset) -> None:
    push = ds["last_velocity"].sel(body="ball", axis="x")
    assert float(push.mean()) > 1.2
    mean = analysis.mean_interval(push, weights=ds.weight, confidence=0.999)
    assert mean.low < 1.0 < mean.high
    quantile = analysis.quantile_interval(push, [0.1, 0.9], weights=ds.weight, confidence=0.999)
    np.testing.assert_array_less(quantile.low, 1 + 0.1 * stats.norm.ppf([0.1, 0.9]))
    np.testing.assert_array_less(1 + 0.1 * stats.norm.ppf([0.1, 0.9]), quantile.high)
    part = analysis.proportion_interval(push > 1.35, weights=ds.weight)
    assert part.low < RARE < part.high
    summary = analysis.summarise(ds)
    row = next(x for x in summary.final if x.quantity == "velocity" and x.axis == "x")
    assert row.median == pytest.approx(1.0, abs=0.05)
    assert "have weights" in summary.weights


def test_what_takes_no_weights_is_of_a_sample_of_the_runs(ds: xr.Dataset) -> None:
    few = analysis.as_drawn(ds)
    assert "weight" not in few
    assert 100 < few.sizes["run"] < 400
    assert stats.kstest(few["parameters.push"], stats.norm(1.0, 0.1).cdf).pvalue > 0.01
    found = analysis.sensitivity(ds, "last_velocity.ball.x")
    assert int(found.runs[0]) == few.sizes["run"]
    assert f"{few.sizes['run']:,} of the 2,000 weighted runs" in found.notes
    assert few.attrs["weights"] in found.notes
    apart = analysis.separation(ds, "slow")
    assert float(apart.distance[0]) == 1.0
    assert apart.attrs["not_met"] > 100


def test_the_same_bits_however_it_is_run(ds: xr.Dataset, tmp_path: Path) -> None:
    some = lienumba.run(FALL, runs=range(100, 130))
    own = ds.sel(run=some.run)
    np.testing.assert_array_equal(some.weight, own.weight)
    np.testing.assert_array_equal(some["parameters.push"], own["parameters.push"])
    plain = lienumba.run(FALL, overrides={"sweep.sampler": "random", "sweep.proposal": {}}, runs=range(300))
    same = plain["parameters.push"].values == ds["parameters.push"].values[:300]
    assert 10 < same.sum() < 60  # the defensive part of the mixture
    file = tmp_path / "drawn.nc"
    lienumba.run(FALL, runs=range(-1, 40), output=file, overrides={"sweep.nominal": True})
    given = {**FALL, "sweep": {"sampler": "table", "table": {"file": str(file)}}}
    again = lienumba.run(given)
    for name in ("weight", "parameters.push", "requirement_margin"):
        np.testing.assert_array_equal(again[name], ds[name][:40])
    assert again.verdict == analysis.verdicts(ds.isel(run=slice(40))).sentence.item()
    table = resolve(given)
    shown = sample(table, table.labels, Output(tmp_path / "again.csv"))[0]
    assert shown.mean == pytest.approx(np.average(ds["parameters.push"][:40], weights=ds.weight[:40]))
    assert (tmp_path / "again.csv").read_text().splitlines()[0] == "run,parameters.push,weight"


def test_pairs_have_their_weights(ds: xr.Dataset) -> None:
    faster = lienumba.run(
        FALL, overrides={"model.bodies": [{**FALL["model"]["bodies"][0], "velocity": ["1.1*push", 0, 0]}]}
    )
    found = analysis.compare(ds, faster, ["last_velocity.ball.x", "requirement_met.slow"])
    first, second = found.isel(output=0), found.isel(output=1)
    assert first.difference_low < 0.1 < first.difference_high
    more = stats.norm.sf((1.35 / 1.1 - 1) / 0.1) - RARE
    assert second.difference_low < -more < second.difference_high
    other = ds.assign(weight=2.0 * ds.weight)
    with pytest.raises(ScenarioError, match="other weights in both datasets"):
        analysis.compare(ds, other)


def test_a_sweep_with_weights_ends_where_its_interval_is_narrow(ds: xr.Dataset, tmp_path: Path) -> None:
    narrow = {"variable": "last_velocity.ball.x", "statistic": "mean", "width": 0.04, "every": 50}
    mean = lienumba.run(FALL, overrides={"sweep.stop": narrow})
    ends = analysis.mean_interval(mean["last_velocity"].sel(body="ball", axis="x"), weights=mean.weight)
    assert 0.03 < float(ends.high - ends.low) < 0.04
    assert f"from {float(ends.low):.6g} to {float(ends.high):.6g}" in mean.stopped
    assert "a number of runs that was fixed before" in analysis.verdicts(mean).notes
    ds.to_netcdf(tmp_path / "drawn.nc")
    table = {"runs": 2000, "sampler": "table", "table": {"file": str(tmp_path / "drawn.nc")}, "stop": narrow}
    assert lienumba.run({**FALL, "sweep": table}).stopped == mean.stopped


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"sweep.proposal": {}}, 'sweep.proposal is missing; give { "path" = { shift = 2.0 } }'),
        ({"sweep.sampler": "random"}, 'sweep.sampler = "random": takes no proposals; give sampler = "importance"'),
        ({"sweep.proposal": {"parameters.pus": {"shift": 1.0}}}, "parameters.push"),
        ({"sweep.proposal": {"parameters.push": {"shift": 9.0}}}, "at most 6; give how far the input is shifted"),
    ],
)
def test_what_is_refused(change: dict[str, Any], said: str) -> None:
    with pytest.raises(ScenarioError) as refused:
        lienumba.run(FALL, overrides=change)
    assert said in str(refused.value)


def test_weights_are_those_of_the_same_runs(ds: xr.Dataset) -> None:
    with pytest.raises(ScenarioError, match="have not the same runs as the variable"):
        analysis.mean_interval(ds.end_time, weights=ds.weight.isel(run=slice(10)))
