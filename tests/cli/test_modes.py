"""`lienumba modes`: its table, its files, and what it refuses."""

from pathlib import Path

import xarray as xr

from tests.cli.test_commands import lienumba
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
