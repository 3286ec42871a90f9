"""Requirements of runs in the dataset: by margins that follow from a formula, on every way that runs take."""

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from typer.testing import CliRunner

import lienumba
from lienumba import ScenarioError, analysis
from lienumba.scenario.base.toml import dumps
from tests.facade import app

BALL = {"name": "ball", "mass": 1.0, "inertia": [1.0, 1.0, 1.0], "position": [0, 0, 0], "velocity": [0, 0, 0]}
SOON = {"name": "soon", "value": "event_time.impact", "below": "sqrt(1*2/9.81)", "probability": 0.4}
LATE = {"name": "not too soon", "value": "event_time.impact", "above": 0.3, "probability": 0.9, "confidence": 0.8}
NEAR = {"name": "near", "value": "last_position.ball.z", "between": [-1.2, "-1/2"], "probability": 0.5}
FALL: dict[str, Any] = {
    "title": "Falls",
    "model": {"bodies": [BALL]},
    "parameters": {"depth": 1.0},
    "quantities": [{"name": "at", "type": "point", "body": "ball"}],
    "events": [{"name": "impact", "when": "at.z < -depth", "action": "stop"}],
    "requirements": [SOON, LATE, NEAR],
    "integrator": {"step": 0.01, "end_time": 0.5},
    "sweep": {"runs": 60, "vary": {"parameters.depth": {"distribution": "uniform", "low": 0.2, "high": 2.0}}},
}


def changed(**requirement: Any) -> dict[str, Any]:
    """The scenario with one requirement."""
    return FALL | {"requirements": [SOON | requirement]}


def refusal(data: dict[str, Any], **more: Any) -> str:
    with pytest.raises(ScenarioError) as refused:
        lienumba.run(data, **more)
    return str(refused.value)


@pytest.fixture(scope="module")
def memory() -> xr.Dataset:
    return lienumba.run(FALL)


def test_margins_are_those_of_a_fall(memory: xr.Dataset) -> None:
    """An event that never happens is later than any limit."""
    depth = memory["parameters.depth"].values
    time = np.sqrt(2 * depth / 9.81)
    never = time > 0.5
    assert 5 < never.sum() < 55
    last = np.where(never, -9.81 / 8, -depth)
    expected = [
        np.where(never, -np.inf, np.sqrt(2 / 9.81) - time),
        np.where(never, np.inf, time - 0.3),
        np.minimum(last + 1.2, -0.5 - last),
    ]
    np.testing.assert_allclose(memory.requirement_margin.values, np.transpose(expected), atol=1e-10)
    np.testing.assert_array_equal(memory.requirement_met.values, np.transpose(expected) > 0)
    assert memory.requirement.values.tolist() == ["soon", "not too soon", "near"]
    assert memory.requirement_units.values.tolist() == ["s", "s", "m"]


def test_attributes_say_what_the_analysis_says(memory: xr.Dataset) -> None:
    said, found = json.loads(memory.attrs["verdicts"]), analysis.verdicts(memory)
    for one, name in zip(said, found.requirement.values, strict=True):
        of = found.sel(requirement=name)
        assert (one["requirement"], one["verdict"], one["runs"]) == (name, of.verdict, of.runs)
        assert one["passed"] == int(memory.requirement_met.sel(requirement=name).sum())
        assert (one["at_least"], one["at_most"]) == (of.at_least, of.at_most)
    assert memory.attrs["verdict"].split("\n") == found.sentence.values.tolist()
    few = analysis.verdicts(memory.isel(run=range(5)))
    assert few.runs.values.tolist() == [5, 5, 5]


@pytest.mark.parametrize("mode", ["full", "summary"])
def test_disk_parts_and_resumed_sweeps_have_the_same(memory: xr.Dataset, mode: str, tmp_path: Path) -> None:
    data = FALL | {"output": {"mode": mode}}
    lienumba.run(data, output=tmp_path / "whole.nc").close()
    for k in (1, 2):
        lienumba.run(data, part=(k, 2), output=tmp_path / f"part{k}.nc").close()
    merged = lienumba.merge([tmp_path / "part2.nc", tmp_path / "part1.nc"], tmp_path / "merged.nc")
    lienumba.run(data, overrides={"sweep.runs": 20}, output=tmp_path / "grown.nc").close()
    grown = lienumba.run(data, output=tmp_path / "grown.nc", resume=True)
    whole = xr.open_dataset(tmp_path / "whole.nc")
    for ds in (merged, grown, whole):
        for name in ("requirement_margin", "requirement_met"):
            np.testing.assert_array_equal(ds[name].values, memory[name].values)
        assert ds.attrs["verdict"] == memory.attrs["verdict"]
        assert ds.attrs["verdicts"] == memory.attrs["verdicts"]
        ds.close()
    again = lienumba.replay(tmp_path / "whole.nc", 7)
    np.testing.assert_array_equal(again.requirement_margin.values[0], memory.requirement_margin.values[7])


def test_failed_runs_count_unless_they_are_to_be_left_out() -> None:
    """The root of what is left above the ground is no number below it."""
    deep = {"name": "left", "type": "expression", "value": "sqrt(1 + at.z)"}
    fall = {**FALL, "quantities": [*FALL["quantities"], deep], "events": []}
    fall["integrator"] = {"step": 0.01, "end_time": 0.6}
    fall["sweep"] = {"runs": 6, "vary": {"bodies.ball.velocity[2]": {"distribution": "uniform", "low": 0, "high": 3}}}
    fall["parameters"] = {}
    asked = {"name": "stays", "value": "max_energy_drift", "below": 1.0, "probability": 0.5}
    found = {}
    for failed in ("count", "ignore"):
        found[failed] = lienumba.run(fall | {"requirements": [asked | {"failed": failed}]})
    bad = ~found["count"].status.isin([0, 9]).values
    assert 0 < bad.sum() < 6
    np.testing.assert_array_equal(found["count"].requirement_met.values[:, 0], ~bad)
    np.testing.assert_array_equal(np.isnan(found["ignore"].requirement_met.values[:, 0]), bad)
    assert (found["ignore"].requirement_met.values[~bad, 0] == 1).all()
    assert json.loads(found["ignore"].attrs["verdicts"])[0]["runs"] == 6 - bad.sum()
    notes = analysis.verdicts(found["count"]).notes
    assert notes == f'{bad.sum()} runs failed or had no value for "stays", and did not meet it' or bad.sum() == 1


def test_nothing_of_requirements_decides_a_run(memory: xr.Dataset) -> None:
    plain = lienumba.run({key: x for key, x in FALL.items() if key != "requirements"})
    assert plain.attrs["scenario_sha256"] == memory.attrs["scenario_sha256"]
    assert "verdict" not in plain.attrs
    assert "requirement" not in plain.coords
    np.testing.assert_array_equal(plain.last_position.values, memory.last_position.values)
    with pytest.raises(ScenarioError, match="the dataset has no requirements; write some as"):
        analysis.verdicts(plain)


LIMITS = "give below, above or between"


@pytest.mark.parametrize(
    ("keys", "sentence"),
    [
        ({"below": None}, f".soon: has no limit; {LIMITS}"),
        ({"above": 1.0}, f".soon.above = 1.0: stands beside below; {LIMITS} = [low, high]"),
        (
            {"below": None, "between": [2, 1]},
            ".soon.between = [2.0, 1.0]: has no smaller number first; give the least value first, and a larger one",
        ),
        (
            {"probability": 1.0},
            ".soon.probability = 1.0: must be below 1; give the part of all runs that shall meet it",
        ),
        ({"probability": None}, ".soon.probability is missing; give the part of all runs that shall meet it"),
        ({"value": None}, ".soon.value is missing; give a formula of the whole run"),
        ({"below": "2*depth"}, '.soon.below = "2*depth": depends on parameters.depth, which the sweep varies'),
        ({"failed": "drop"}, '.soon.failed = "drop": must be "count" or "ignore"'),
        ({"name": "a.b"}, '.a.b.name = "a.b": is no valid name; give words without ".", "[", "]", "/" and quotes'),
        (
            {"value": "parameters.depth"},
            '.soon.value = "parameters.depth": is an input, not what a run comes to; give a measure, a summary',
        ),
        (
            {"value": "soon"},
            '.soon.value = "soon": is not a number that the dataset has for each run; it has courses such as '
            '"position.ball.x", events such as "event_time.impact"',
        ),
        ({"value": "event_time.impct"}, '.soon.value = "event_time.impct": is not a number that the dataset has for'),
    ],
)
def test_what_is_wrong_with_a_requirement_is_said(keys: dict[str, Any], sentence: str) -> None:
    data = changed(**keys)
    data["requirements"] = [{key: x for key, x in data["requirements"][0].items() if x is not None}]
    said = refusal(data)
    assert said.startswith(f"requirements{sentence}")
    assert "\n" not in said


def test_what_is_wrong_around_requirements_is_said() -> None:
    twice = refusal(FALL | {"requirements": [SOON, SOON]})
    assert twice == 'requirements[1].name = "soon": is also the name of requirements[0]; give each its own name'
    study = {"reference": {"step": 1e-3}, "grid": [{"integrator.step": [0.01]}]}
    assert "requirements: a study compares settings and judges no runs" in refusal(FALL | {"study": study})


def test_exit_codes_tell_the_verdict(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("a.toml").write_text(dumps(FALL | {"requirements": [SOON | {"probability": 0.1}]}))
    Path("b.toml").write_text(dumps(FALL))
    Path("c.toml").write_text(dumps({key: x for key, x in FALL.items() if key != "requirements"}))

    def lienumba_(*words: str) -> Any:
        return CliRunner().invoke(app, [*words])

    met = lienumba_("run", "a.toml", "--verdict")
    assert met.exit_code == 0
    assert re.search(r"soon +met +event_time.impact below sqrt\(1\*2/9.81\) +10 % +\d+ of 60", met.stdout)
    assert lienumba_("run", "b.toml").exit_code == 0
    assert lienumba_("run", "b.toml", "--overwrite", "--verdict").exit_code == 4
    quiet = lienumba_("run", "b.toml", "--overwrite", "--verdict", "-q")
    assert quiet.exit_code == 4
    assert 'error: "near" is not met: at most' in quiet.stderr
    assert [lienumba_("analyse", f"{x}.nc", "--verdict").exit_code for x in "ab"] == [0, 4]
    assert re.search("near +not met", lienumba_("analyse", "b.nc").stdout)
    with xr.open_dataset("b.nc") as ds:
        ds.assign(status=xr.full_like(ds.status, 1)).to_netcdf("failed.nc")
    nothing = lienumba_("analyse", "failed.nc")  # no run tells what anything depends on, but the verdict stands
    assert (nothing.exit_code, nothing.stderr.count("0 good runs have a value")) == (2, 1)
    assert re.search("near +not met", nothing.stdout)
    refused = lienumba_("run", "c.toml", "--verdict")
    assert refused.exit_code == 2
    assert refused.stderr == "error: --verdict: the scenario has no requirements; write some as [[requirements]]\n"
    assert not Path("c.nc").exists()
