"""One row for each run: what stands in it, and what other programs read."""

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from scipy.io import loadmat
from typer.testing import CliRunner

from lienumba import ScenarioError
from lienumba.analysis import run_table
from tests.analysis.sweep_example import sweep
from tests.facade import app

RNG = np.random.default_rng(3)
RUNS = 7
SAMPLES = {"bodies.a.mass": RNG.standard_normal(RUNS), "bodies.a.inertia[0]": RNG.standard_normal(RUNS)}
STEPS = np.arange(RUNS) * 10
TIP = RNG.standard_normal((RUNS, 3, 3))
TIP[2, 1:] = np.nan


def made():
    status = np.where(np.arange(RUNS) == 2, 1, 0)
    times = np.where(np.arange(RUNS) > 3, 0.25, np.nan)[:, None]
    return sweep(SAMPLES, status, labels=np.arange(-1, RUNS - 1), steps=STEPS, event_time=times, tip=TIP)


def test_every_run_has_a_row_of_what_it_has_once():
    table = run_table(made())
    assert list(table) == ["status", *SAMPLES, "steps", "event_time.far"]
    assert list(table.index) == list(range(-1, RUNS - 1))
    assert table.index.name == "run"
    assert (table["status"] == "success").sum() == RUNS - 1
    assert table["status"].iloc[2] != "success"
    assert table["steps"].tolist() == STEPS.tolist()
    assert (table["bodies.a.mass"] == SAMPLES["bodies.a.mass"]).all()
    assert table["event_time.far"].isna().sum() == 4
    assert table.attrs["units"]["event_time.far"] == "s"
    assert table.attrs["units"]["bodies.a.mass"] == "kg"


@pytest.mark.parametrize(("time", "index"), [(None, -1), (0.5, 1)])
def test_series_stand_at_a_time_in_runs_that_failed_too(time, index):
    table = run_table(made(), ["tip.y", "tip.x"], time)
    assert list(table)[-2:] == ["tip.y", "tip.x"]
    assert np.array_equal(table["tip.y"].to_numpy(), TIP[:, index, 1], equal_nan=True)
    assert np.isnan(table["tip.x"].iloc[2])


def test_what_is_not_there_is_told():
    with pytest.raises(ScenarioError, match=r'no output "tipp"; the nearest known name is "tip"'):
        run_table(made(), "tipp")
    with pytest.raises(ScenarioError, match=r"time = 0.3: is not stored"):
        run_table(made(), "tip", 0.3)


@pytest.fixture
def file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    made().to_netcdf("out.nc")
    return tmp_path / "out.nc"


def command(*words):
    return CliRunner().invoke(app, ["table", *map(str, words)])


def test_a_spreadsheet_reads_every_bit(file):
    result = command("out.nc")
    assert result.output == "written to out.csv: 7 runs, 5 columns\n"
    read, table = pd.read_csv("out.csv", index_col="run"), run_table(xr.open_dataset(file))
    assert list(read) == list(table)
    assert np.array_equal(read["bodies.a.mass"], SAMPLES["bodies.a.mass"])
    assert read["steps"].dtype.kind == "i"
    again = command("out.nc")
    assert again.exit_code == 2
    assert "output = out.csv: exists already; choose another name, or replace it with --overwrite" in again.stderr
    assert command("out.nc", "-o", "out.txt").stderr.startswith("error: output = out.txt: is no table of runs; give a")


def test_what_there_is_is_replaced_if_it_is_a_table(file):
    for name in ("out.csv", "out.mat"):
        assert command("out.nc", "-o", name).exit_code == 0
        before = (file.parent / name).read_bytes()
        assert command("none.nc", "-o", name, "--overwrite").exit_code == 2
        assert (file.parent / name).read_bytes() == before
        assert command("out.nc", "tip", "-o", name, "--overwrite").exit_code == 0
        assert (file.parent / name).read_bytes() != before
    assert "tip.x" in pd.read_csv("out.csv")
    (file.parent / "notes.csv").write_text("what I saw\n")
    refused = command("out.nc", "-o", "notes.csv", "--overwrite")
    assert refused.stderr == (
        "error: output = notes.csv: is a file of another kind, no table of runs to be replaced; choose another name\n"
    )
    assert (file.parent / "notes.csv").read_text() == "what I saw\n"


def test_matlab_reads_names_that_it_takes(file):
    assert command("out.nc", "tip", "--time", "0.5", "-o", "out.mat").exit_code == 0
    read = loadmat("out.mat", simplify_cells=True)
    assert list(read["runs"]) == [
        "run", "status", "bodies_a_mass", "bodies_a_inertia_0", "tip_x", "tip_y", "tip_z",
    ]  # fmt: skip
    assert list(read["names"]) == ["run", "status", *SAMPLES, "tip.x", "tip.y", "tip.z"]
    assert list(read["units"])[-1] == "m"
    assert np.array_equal(read["runs"]["tip_z"], TIP[:, 1, 2], equal_nan=True)
    assert read["runs"]["status"][0] == "success"


def test_names_that_would_be_one_in_matlab_are_kept_apart(tmp_path, monkeypatch):
    from lienumba.analysis.by_run import _short

    names = ["a.b", "a[b", "a_b", "9", "x" * 80, "x" * 81, "[]"]
    found = _short(names)
    assert len(set(found)) == len(names)
    assert all(len(name) <= 63 and name.isidentifier() and not name.startswith("_") for name in found)


def test_parquet_or_what_is_missing_for_it(file):
    result = command("out.nc", "-o", "out.parquet")
    try:
        import pyarrow.parquet  # noqa: F401
    except ImportError:
        assert result.exit_code == 2
        assert "Parquet takes the package pyarrow (pip install pyarrow)" in result.stderr
        assert not (file.parent / "out.parquet").exists()
    else:
        assert pd.read_parquet("out.parquet").equals(run_table(xr.open_dataset(file)))
