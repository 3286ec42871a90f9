"""`lienumba modes`: its table, its files, and what it refuses."""

from pathlib import Path

import pandas
import pytest
import xarray as xr
from scipy.stats import spearmanr

import lienumba as library
from lienumba.analysis.sensitivities.sensitivity import sensitivity
from lienumba.figures import figure
from lienumba.scene import mode_scene
from tests.cli.test_commands import lienumba
from tests.facade import ScenarioError
from tests.rigs.places import SCENARIOS


def test_a_table_a_dataset_and_a_figure(tmp_path: Path) -> None:
    data, drawn = tmp_path / "top.nc", tmp_path / "top.png"
    source = str(SCENARIOS / "top_over_spin.toml")
    done = lienumba("modes", source, "--set", "sweep.runs=9", "--plot", str(drawn), "-o", str(data))
    assert done.exit_code == 0, done.output
    assert "t = 0 s: 9 runs" in done.stdout
    assert "unstable: " in done.stdout
    assert "crossed" in xr.open_dataset(data)
    assert drawn.read_bytes().startswith(b"\x89PNG")
    again = lienumba("modes", source, "-o", str(data))
    assert again.exit_code == 2
    assert "exists" in again.stderr


def test_a_dataset_of_modes_is_answered_by_every_command(tmp_path: Path) -> None:
    data, drawn = tmp_path / "top.nc", tmp_path / "top.svg"
    found = library.modes(SCENARIOS / "top_over_spin.toml", at=[0, 0.01], overrides={"sweep.runs": 5})
    found.to_netcdf(data)
    told = lienumba("info", str(data)).stdout
    assert "runs:        5 (labels 0 to 4)" in told
    assert "t = 0.01 s:  5 runs, simulated up to there\n             mode  moves most  Hz" in told
    assert lienumba("plot", str(data), "-o", str(drawn)).exit_code == 0
    assert drawn.read_text().count("t = 0") == 2
    named = lienumba("plot", str(data), "frequency", "-o", str(drawn)).stderr
    assert named == (
        'error: "frequency": a dataset of modes has one figure, of eigenvalues and frequencies; leave it out, or draw '
        "what is in it in Python\n"
    )
    for command in (["replay", "--run", "0"], ["compare", str(data)], ["modes"]):
        refused = lienumba(command[0], str(data), *command[1:])
        assert refused.exit_code == 2
        assert refused.stderr == (
            f"error: {data}: is of vibration modes, not of runs over time; lienumba info, plot, report, "
            "animate, analyse and table show it, or give what lienumba run wrote\n"
        )
    listed = lienumba("list", str(tmp_path)).stdout
    assert " modes " in listed
    assert " 5 " in listed
    lienumba(
        "equilibrium",
        str(SCENARIOS / "machine_on_mounts.toml"),
        "--set",
        "sweep.runs=3",
        "-o",
        str(data),
        "--overwrite",
    )
    assert "is of equilibria, not of runs over time" in lienumba("info", str(data)).stderr


def test_modes_of_scenarios_and_datasets_as_pictures_and_pages(tmp_path: Path) -> None:
    data, drawn, page = tmp_path / "mounts.nc", tmp_path / "mode.png", tmp_path / "mounts.html"
    mounts, film = str(SCENARIOS / "machine_on_mounts.toml"), ("-o", str(drawn))
    told = lienumba("animate", mounts, "--mode", "3", *film).stdout
    assert f"written to {drawn}: mode 3: 16.86 Hz, damping 0.0212; nominal run at t = 0 s, moving by at most " in told
    library.modes(mounts, overrides={"sweep.runs": 3}).to_netcdf(data)
    assert "mode 2: " in lienumba("animate", str(data), "--mode", "2", "--run", "1", *film).stdout
    several = lienumba("animate", str(data), "--run", "0,1", *film).stderr
    assert several == "error: --run 0,1: a mode is that of one run; give one label with --run N\n"
    assert drawn.read_bytes().startswith(b"\x89PNG")
    assert lienumba("report", str(data), "-o", str(page)).exit_code == 0
    assert "Modes at t = 0 s" in page.read_text(encoding="utf-8")


def test_frequencies_by_run_and_what_they_depend_on(tmp_path: Path) -> None:
    data, rows = tmp_path / "mounts.nc", tmp_path / "mounts.csv"
    found = library.modes(SCENARIOS / "machine_on_mounts.toml", at=[0, 0.01], overrides={"sweep.runs": 40})
    found.to_netcdf(data)
    assert lienumba("table", str(data), "-o", str(rows), "--time", "0").exit_code == 0
    table = pandas.read_csv(rows, index_col="run")
    assert table["frequency.3"].to_numpy() == pytest.approx(found.frequency.sel(mode=3).isel(time=0), rel=1e-12)
    assert table["damping_ratio.6"].to_numpy() == pytest.approx(found.damping_ratio.sel(mode=6).isel(time=0), rel=1e-12)
    told = lienumba("analyse", str(data), "frequency.1", "frequency.4").stdout
    assert "frequency.1" in told
    ranks = sensitivity(found, "frequency.1")
    own = found.frequency.sel(mode=1).isel(time=-1)
    for path in ranks["input"].values:
        expected = spearmanr(found[path], own).statistic
        assert float(ranks["rank_correlation"].sel(input=path).item()) == pytest.approx(expected, abs=1e-12)


def test_a_selection_of_modes_says_what_it_has_lost() -> None:
    found = library.modes(SCENARIOS / "top_over_spin.toml", overrides={"sweep.runs": 3})
    assert figure(found.sel(mode=[1])).axes
    with pytest.raises(ScenarioError, match=r"has only one time, without its dimension; .* ds.sel\(time=\[0.0\]\)"):
        figure(found.isel(time=0))
    with pytest.raises(ScenarioError, match="is not as lienumba wrote it, growth is not run by time by mode"):
        figure(found.drop_vars("growth"))
    with pytest.raises(ScenarioError, match="is not as lienumba wrote it, body has no labels"):
        figure(found.drop_vars("body"))
    with pytest.raises(ScenarioError, match="has not every axis in its order; select runs, times and modes only"):
        figure(found.isel(axis=[0, 2]))
    with pytest.raises(ScenarioError, match="mode 2 of run 1 has a shape that is not finite; choose another"):
        mode_scene(found.assign(turn=found.turn * float("nan")), modes=2, run=1)


def test_a_time_that_is_asked_for_twice_is_there_once() -> None:
    done = lienumba("modes", str(SCENARIOS / "top_over_spin.toml"), "--at", "0,end,0.5,0.0", "--set", "sweep.runs=2")
    assert done.exit_code == 0, done.stderr
    assert library.modes(SCENARIOS / "top_over_spin.toml", at=[0, "end", 0.5], runs=[0]).time.values.tolist() == [
        0,
        0.5,
    ]


def test_times_outside_the_runs_are_refused() -> None:
    done = lienumba("modes", str(SCENARIOS / "top_over_spin.toml"), "--at", "0,9")
    assert done.exit_code == 2
    assert done.stderr.strip() == ('error: at = "9": must lie from 0 to integrator.end_time = 0.5 s; give such times')


def test_an_equilibrium_and_one_that_there_is_not(tmp_path: Path) -> None:
    data = tmp_path / "rest.nc"
    mounts = str(SCENARIOS / "machine_on_mounts.toml")
    done = lienumba("equilibrium", mounts, "--set", "sweep.runs=3", "-o", str(data))
    assert done.exit_code == 0, done.output
    assert "equilibrium of 3 runs: 3 found" in done.stdout
    assert (xr.open_dataset(data).status == 0).all()
    falling = lienumba("equilibrium", str(SCENARIOS / "dzhanibekov.toml"), "--set", "model.gravity=[0,0,-9.81]")
    assert falling.exit_code == 1
    assert "1 none found" in falling.stdout


def test_an_equilibrium_that_turns_and_a_start_in_one() -> None:
    governor, suspension = str(SCENARIOS / "flyball_governor.toml"), str(SCENARIOS / "suspension.toml")
    assert "equilibrium of 1 run: 1 found" in lienumba("equilibrium", governor, "--rotation", "0,0,8").stdout
    refused = lienumba("equilibrium", governor, "--rotation", "0,8")
    assert refused.exit_code == 2
    assert "must be three numbers in rad/s; give them, such as 0,0,5" in refused.stderr
    assert "it starts in its equilibrium\n" in lienumba("validate", suspension).stdout
    across = lienumba("validate", suspension, "--set", "start.rotation=[0,5,0]")
    assert "no equilibrium was found in which the nominal run could start" in across.stdout
