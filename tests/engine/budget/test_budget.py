"""`lienumba.budget`: shares, deviations and means where they are known, and what runs say of them."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from typer.testing import CliRunner

import lienumba
from lienumba.scenario.base import toml
from tests.facade import ScenarioError, app
from tests.rigs.flights import VELOCITY, fall, flight, height

X, Y, Z = (f"bodies.b.velocity[{n}]" for n in range(3))
NORMAL = {X: {"distribution": "normal", "std": 0.1}, Y: {"distribution": "normal", "std": 0.2}}
UNIFORM = {"distribution": "uniform", "low": 7.0, "high": 8.5}
END = 2.0


def test_shares_of_a_linear_output() -> None:
    found = lienumba.budget(flight(**NORMAL, **{Z: UNIFORM}), of=["far", "last_position", "event_time"])
    assert found["output"].values.tolist() == [
        "far", "last_position.b.x", "last_position.b.y", "last_position.b.z", "event_time.fallen"
    ]  # fmt: skip
    assert found["output_units"].values.tolist() == ["m", "m", "m", "m", "s"]
    parts = np.array([0.1**2, 4.0 * 0.2**2, 0.0])
    far = found.sel(output="far")
    np.testing.assert_allclose(far["share"], parts / parts.sum(), rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(far["deviation"], END * np.sqrt(parts.sum()), rtol=1e-9)
    np.testing.assert_allclose(found["input_deviation"], [0.1, 0.2, 1.5 / np.sqrt(12.0)], rtol=1e-9)
    np.testing.assert_allclose(found.sel(output="last_position.b.z", input=Z)["derivative"], END, rtol=1e-9)
    z = found.sel(output="last_position.b.z")
    np.testing.assert_allclose([z["nominal"], z["predicted_mean"]], [height(END), height(END, 7.75)], rtol=1e-9)
    np.testing.assert_allclose(found.sel(output="event_time.fallen")["nominal"], fall(), rtol=1e-9)
    assert "counted" not in found


def test_correlated_inputs_share_what_they_have_together() -> None:
    data = flight(**NORMAL).to_dict()
    data["sweep"]["correlate"] = [{"paths": [X, Y], "matrix": [[1.0, -0.5], [-0.5, 1.0]]}]
    found = lienumba.budget(data, of="far")
    slopes, std = np.array([1.0, 2.0]), np.array([0.1, 0.2])
    covariance = np.array([[1.0, -0.5], [-0.5, 1.0]]) * np.outer(std, std)
    parts = slopes * (covariance @ slopes)
    np.testing.assert_allclose(found["share"][0], parts / parts.sum(), rtol=2e-3, atol=2e-3)
    np.testing.assert_allclose(found["deviation"], [END * np.sqrt(parts.sum())], rtol=1e-3)


def test_runs_check_it_and_the_prediction_narrows_their_mean() -> None:
    with pytest.warns(lienumba.errors.ResultWarning, match="bent is not nearly linear"):
        found = lienumba.budget(
            flight(**(NORMAL | {X: {"distribution": "uniform", "low": -2.0, "high": 4.0}})),
            of=["far", "bent"], runs=100, seed=3,
        )  # fmt: skip
    far, bent = found.sel(output="far"), found.sel(output="bent")
    assert far["counted"] == 100
    np.testing.assert_allclose(far["correlation"], 1.0, rtol=1e-12)
    assert float(far["controlled_mean_error"]) < 1e-7 * float(far["mean_error"])
    np.testing.assert_allclose(far["controlled_mean"], 2.0 * (VELOCITY[0] + 2.0 * VELOCITY[1]), rtol=1e-9)
    assert abs(far["mean"] - far["controlled_mean"]) < 4.0 * far["mean_error"]
    np.testing.assert_allclose(far["sampled_deviation"], far["deviation"], rtol=0.3)
    mean = 4.0 * (1.0 + 3.0) - 2.0 * VELOCITY[1]  # of (2 v)^2 with v about 1, of a variance of 3, less y
    assert abs(bent["controlled_mean"] - mean) < 4.0 * bent["controlled_mean_error"]
    assert bent["correlation"] < 0.95
    assert "trust the runs, not the shares" in found.attrs["notes"]


def test_a_sweep_that_is_there_checks_it(tmp_path: Path) -> None:
    data = flight(**NORMAL).to_dict()
    data["sweep"] |= {"runs": 20, "nominal": True}
    file = tmp_path / "sweep.nc"
    ds = lienumba.run(data, output=file)
    found = lienumba.budget(data, of="far", sweep=file)
    assert found["counted"] == 20
    np.testing.assert_allclose(found["mean"], ds["far"].isel(time=-1, run=slice(1, None)).mean(), rtol=1e-12)
    ds.close()
    with pytest.raises(ScenarioError, match="of another scenario, or of other numbers"):
        lienumba.budget(data, overrides={"bodies.b.mass": 2.0}, of="far", sweep=file)


def test_by_default_measures_and_times_of_events_count() -> None:
    with pytest.warns(lienumba.errors.ResultWarning, match="late is left out: it is not made of"):
        found = lienumba.budget(flight(**{Z: UNIFORM}).measure("late", "mean(p.z)"))
    assert found["output"].values.tolist() == ["top", "event_time.fallen"]
    asked = {"sensitivities": {"of": ["p.x"]}}
    with pytest.warns(lienumba.errors.ResultWarning, match="p.x does not change with any input"):
        assert lienumba.budget(flight(**{Z: UNIFORM}), overrides=asked)["output"].values.tolist() == ["p.x"]


@pytest.mark.parametrize(
    ("vary", "given", "told"),
    [
        ({}, {}, "sweep.vary: is empty"),
        (NORMAL, {"runs": 5}, "runs = 5: must be a whole number, at least 10"),
        (NORMAL, {"runs": 20, "sweep": "x.nc"}, "leave one of the two out"),
        (NORMAL, {"of": "mean_p"}, "mean_p"),
        (NORMAL, {"overrides": {"integrator.method": "generalized_alpha"}}, "has no derivatives of its steps"),
    ],
)
def test_what_is_refused(vary: dict[str, Any], given: dict[str, Any], told: str) -> None:
    with pytest.raises(ScenarioError, match=told):
        lienumba.budget(flight(**vary), **given)


def test_the_command_prints_tables_and_writes_a_dataset(tmp_path: Path) -> None:
    file, written = tmp_path / "flight.toml", tmp_path / "budget.nc"
    file.write_text(toml.dumps(flight(**NORMAL, **{Z: UNIFORM}).to_dict()), encoding="utf-8")
    result = CliRunner().invoke(app, ["budget", str(file), "far", "top", "--runs", "20", "-o", str(written)])
    assert result.exit_code == 0, result.output
    rows = [line.split() for line in result.output.splitlines()]
    assert [X, "m", "s-1", "0.1", "5.9", "%", "0.0", "%"] in rows
    assert [Z, "m", "s-1", "0.433", "0.0", "%", "100.0", "%"] in rows
    assert any(row[:4] == ["far", "m", "10", "0.82462"] and row[4] == "20" for row in rows)
    with xr.open_dataset(written) as ds:
        assert ds["share"].dims == ("output", "input")
    result = CliRunner().invoke(app, ["budget", str(file), "--runs", "5"])
    assert result.exit_code == 2
    assert "at least 10" in result.output
