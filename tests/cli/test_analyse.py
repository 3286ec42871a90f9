"""The command `lienumba analyse`: what it prints and writes, and what it refuses."""

import csv
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from scipy.stats import norm
from typer.testing import CliRunner

from lienumba.analysis import sensitivity
from lienumba.store.study_layout import Coordinate
from lienumba.store.study_layout import dataset as study
from tests.analysis.sweep_example import named, saltelli, sweep
from tests.facade import app
from tests.rigs.places import ROOT


def analyse(path, *options):
    return CliRunner().invoke(app, ["analyse", str(path), *map(str, options)])


@pytest.fixture(scope="module")
def out(tmp_path_factory):
    """64 rows of a saltelli sweep, of which two hold a failed run: y = 2 a + b in time."""
    x = saltelli(64, [norm.ppf] * 3)
    y = (2 * x[:, 0] + x[:, 1])[:, None] * np.array([0.0, 1.0, 10.0])
    status = np.isin(np.arange(len(x)), [3, 101]).astype(int)
    path = tmp_path_factory.mktemp("sweep") / "out.nc"
    sweep(named(x), status, vary="saltelli", y=y, z=x[:, 2]).to_netcdf(path)
    return path


def rows_below(text, heading):
    """The cells of the table with this title, by their first."""
    lines = text[text.index(heading) :].splitlines()[4:]
    return {
        line.split()[0]: line.split()[1:] for line in lines[: next(k for k, x in enumerate(lines) if not x.strip())]
    }


def test_what_is_printed(out):
    result = analyse(out, "y")
    assert result.exit_code == 0, result.output
    text, found = result.stdout, sensitivity(xr.open_dataset(out), "y").sel(output="y")
    assert text.startswith("Made up: 318 of 320 runs good, 2 failed\n")
    assert "y (m) at t = 1 s, 127 runs: mean " in text
    table = rows_below(text, "y (m) at t = 1 s")
    assert list(table) == sorted("abc", key=lambda name: -abs(float(found["rank_correlation"].sel(input=name))))
    for name, cells in table.items():
        one = {str(key): float(x) for key, x in found.sel(input=name).data_vars.items()}
        assert cells[0] == "(kg)"
        spread = 0.5 * (one["rank_correlation_high"] - one["rank_correlation_low"])
        assert " ".join(cells[1:4]) == f"{one['rank_correlation']:.2f} ± {spread:.2f}"
        assert cells[4:8] == [f"{one[key]:.4g}" for key in ("input_low", "input_high", "low", "high")]
        half = 0.5 * (one["change_high"] - one["change_low"])
        assert " ".join(cells[8:]) == f"{one['change']:.3g} ± {half:.2g}"
    assert f"Sobol' indices of y, 62 of 64 rows; the first add up to {float(found['first_order'].sum()):.2f}\n" in text
    table = rows_below(text, "Sobol' indices of y")
    assert list(table) == ["a", "b", "c"]
    for name, cells in table.items():
        one = {str(key): float(x) for key, x in found.sel(input=name).data_vars.items()}
        ends = [[one[f"{kind}{end}"] for end in ("_low", "", "_high")] for kind in ("first_order", "total_order")]
        kinds = [(x, max(x - low, high - x)) for low, x, high in ends]  # the farther end
        assert " ".join(cells) == " ".join(f"{index:.3f} ± {half:.2g}" for index, half in kinds)
    assert text.splitlines()[-1].startswith("rank correlations and changes are of samples A and B alone")


def test_all_outputs_at_another_time(out):
    text = analyse(out).stdout
    assert text.endswith("these outputs were chosen; ask for others by name, such as position or tip.z\n")
    for title in ("\nz (m), ", "\ny (m) at t = 1 s, ", "\nfailed, 128 runs: mean "):
        assert title in text
    assert "y (m) at t = 0.5 s, " in analyse(out, "--time", 0.5).stdout


def test_tables_of_many_inputs_are_cut(tmp_path):
    x = np.random.default_rng(0).random((50, 20))
    sweep({f"p{k}": column for k, column in enumerate(x.T)}, y=x[:, 7]).to_netcdf(tmp_path / "out.nc")
    text = analyse(tmp_path / "out.nc").stdout
    assert "(the first 12 of 20 inputs)" in text
    assert len(rows_below(text, "y (m)")) == 12


def test_what_is_written(out, tmp_path):
    found = sensitivity(xr.open_dataset(out))
    result = analyse(out, "-o", tmp_path / "found.nc")
    assert result.stdout.endswith(f"written to {tmp_path / 'found.nc'}\n")
    with xr.open_dataset(tmp_path / "found.nc") as written:
        assert written.attrs == found.attrs
        xr.testing.assert_equal(written, found)
    assert analyse(out, "-o", tmp_path / "found.csv").exit_code == 0
    assert analyse(out, "-o", tmp_path / "found.csv", "--overwrite").exit_code == 0
    with (tmp_path / "found.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == found.sizes["output"] * found.sizes["input"]
    for row in rows:
        one = found.sel(output=row["output"], input=row["input"])
        for name in ("rank_correlation", "change_low", "total_order_high", "runs", "output_time"):
            assert float(row[name] or "nan") == pytest.approx(float(one[name]), rel=1e-12, nan_ok=True)
        assert (row["output_units"], row["input_units"]) == (one["output_units"], one["input_units"])


def test_refused(out, tmp_path):
    (tmp_path / "there.csv").write_text("mine")
    (tmp_path / "no.nc").write_text("no")
    xr.Dataset({"x": 1}).to_netcdf(tmp_path / "other.nc")
    grid = Coordinate("step", "step", (0.1, 0.2), "s", "integrator.step")
    counts = {name: np.ones((1, 2)) for name in ("status", "end_time", "steps", "evaluations")}
    arrays = {**counts, "time_per_run": np.ones(2), "time_per_run_spread": np.zeros(2)}
    study(arrays, [0], [grid], {}, {}, {"scenario_sha256": "ab12"}).to_netcdf(tmp_path / "study.nc")
    own = Path(tmp_path)
    for arguments, sentence in {
        (own / "none.nc",): f"{own / 'none.nc'} does not exist; the nearest file there is {own / 'no.nc'}",
        (own / "other.nc",): f"{own / 'other.nc'} is a netCDF file but not of lienumba; give one that lienumba run "
        "wrote",
        (own / "study.nc",): "the dataset is that of a study, which compares settings; give one of a sweep alone",
        (out, "x"): 'the dataset has no output "x"; it has courses such as "y", numbers of the whole run such as "z" '
        'and inputs such as "a"',
        (out, "y", "--time", 2): "time = 2: lies outside the stored times; give one from 0 to 1 s",
        (out, "-o", own / "t.txt"): f"output = {own / 't.txt'}: is no table; give a name that ends in .csv or .nc",
        (out, "-o", own / "there.csv"): f"output = {own / 'there.csv'}: exists already; choose another name, or "
        "replace it with --overwrite",
        (out, "-o", own / "there.csv", "--overwrite"): f"output = {own / 'there.csv'}: is a file of another kind, no "
        "table to be replaced; choose another name",
        (out, "-o", out, "--overwrite"): f"output = {out}: is what is to be read; choose another name",
        (out, "-o", own / "no" / "t.csv"): f"output = {own / 'no' / 't.csv'}: its folder {own / 'no'} does not exist; "
        "create it or choose another",
    }.items():  # fmt: skip
        result = analyse(*arguments)
        assert (result.exit_code, result.stderr) == (2, f"error: {sentence}\n")
    assert analyse(own / "no.nc").stderr.startswith(f"error: {own / 'no.nc'} cannot be opened as netCDF")
    assert sorted(x.name for x in own.iterdir()) == ["no.nc", "other.nc", "study.nc", "there.csv"]


def test_help_loads_nothing_heavy():
    code = (
        "import sys; from lienumba.cli import app\ntry: app(['analyse', '--help'])\nexcept SystemExit: pass\n"
        "assert not {'numpy', 'scipy', 'xarray'} & set(sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code], check=True, cwd=ROOT, capture_output=True)
