"""What the command line says of a study, and its exit codes."""

import subprocess
import sys
from pathlib import Path

import pytest
import xarray as xr
from typer.testing import CliRunner

from lienumba.present.terminal.study import print_study
from lienumba.scenario.base import toml
from tests.facade import app
from tests.rigs.made_studies import METHOD, study
from tests.rigs.places import ROOT
from tests.rigs.studies import BALL, ball


def run(folder, data, *options):
    scenario = folder / "case.toml"
    scenario.write_text(toml.dumps(data), encoding="utf-8")
    return CliRunner().invoke(app, ["run", str(scenario), "-o", str(folder / "out.nc"), *options])


def test_orders_and_work_against_precision_are_printed(tmp_path):
    data = ball({"integrator.method": ["heun", "rk4"], "integrator.step": [0.02, 0.01, 0.005]}, title="Ball")
    result = run(tmp_path, data)
    assert result.exit_code == 0, result.output
    lines = [line.split() for line in result.stdout.splitlines()]
    assert result.stdout.startswith("Ball: 6 points, each with 1 run, 0 of 6 failed\n")
    assert "observed orders, 95 % confidence" in result.stdout
    heun, rk4 = (next(line for line in lines if line[:1] == [method]) for method in ("heun", "rk4"))
    assert heun[2] == "±"
    assert float(heun[1]) == pytest.approx(2.0, abs=0.2)
    assert float(rk4[1]) == pytest.approx(4.0, abs=0.2)
    assert "work and precision: largest errors" in result.stdout
    with xr.open_dataset(tmp_path / "out.nc") as ds:
        for method in ("heun", "rk4"):
            for step in (0.02, 0.01, 0.005):
                (row,) = (line for line in lines if line[:2] == [method, f"{step:g}"])
                point = ds.sel({"method": method, "step": step}).isel(run=0)
                assert row[2] == f"{float(point.position_error):.1e}"
                assert row[6:8] == [f"{int(point.steps):,}", f"{int(point.evaluations):,}"]
                assert row[-1] in ("µs", "ns", "ms")
    assert f"written to {tmp_path / 'out.nc'}" in result.stdout
    told = CliRunner().invoke(app, ["info", str(tmp_path / "out.nc")]).stdout
    assert "study:       6 points: method (heun, rk4), step (0.02, 0.01, 0.005)\n" in told
    assert "6 success" in told
    told = CliRunner().invoke(app, ["validate", str(tmp_path / "case.toml")]).stdout
    assert told.endswith("1 run, study of 6 points\n")
    told = CliRunner().invoke(app, ["info", str(tmp_path / "case.toml")]).stdout
    assert "study:       6 points: integrator.method, integrator.step\n" in told


def test_failed_points_give_1_and_are_told(tmp_path):
    data = ball({"integrator.step": [0.4, 0.01]}, output={}, parameters={**BALL["parameters"], "spin": 12.0})
    result = run(tmp_path, data)
    assert result.exit_code == 1, result.output
    assert "2 points, each with 1 run, 1 of 2 failed" in result.stdout
    assert "  1 rotation_too_large: a body turned too far in one step" in result.stdout
    assert "; at step = 0.4\n" in result.stdout
    told = CliRunner().invoke(app, ["info", str(tmp_path / "out.nc")]).stdout
    assert "1 success, 1 rotation_too_large (runs 0)" in told


def test_a_doubtful_reference_is_a_warning(tmp_path):
    data = ball({"integrator.step": [0.02, 0.01]}, reference={"method": "rk4", "step": 0.01})
    result = run(tmp_path, data)
    assert result.exit_code == 0, result.output
    assert "warning: study.reference: the smallest position_error of the grid, 0 m at step = 0.01, " in result.stderr
    assert run(tmp_path, data, "--overwrite", "--quiet").output == ""


def test_settings_of_a_study_can_be_set(tmp_path):
    data = ball({"integrator.step": [0.02, 0.01]})
    options = ("--set", 'study.grid[0]."integrator.step"=[0.05]', "--set", "integrator.method=heun", "-q")
    result = run(tmp_path, data, *options)
    assert result.exit_code == 0, result.output
    with xr.open_dataset(tmp_path / "out.nc") as ds:
        assert ds["step"].values.tolist() == [0.05]
        assert ds["evaluations"].values.tolist() == [[16]]


def test_a_long_table_is_cut(capsys):
    from lienumba.store.study_layout import Coordinate

    values = [1.0 + n for n in range(40)]
    many = Coordinate("mass", "mass", values, "kg", "bodies.top.mass")
    print_study(study([[values, values]], (METHOD, many), 0.1), Path("x.nc"))
    said = capsys.readouterr().out
    assert "largest errors, the first 60 of 80 points" in said
    assert "observed orders" not in said


def test_validate_reads_no_heavy_module_for_a_study(tmp_path):
    (tmp_path / "case.toml").write_text(toml.dumps(ball({"integrator.step": [0.02, 0.01]})), encoding="utf-8")
    code = (
        f"import sys; sys.argv = ['lienumba', 'validate', {str(tmp_path / 'case.toml')!r}]\n"
        "from lienumba.cli import main\ntry:\n    main()\nexcept SystemExit as end:\n    assert not end.code\n"
        "assert not {'numba', 'xarray', 'netCDF4', 'scipy', 'matplotlib'} & set(sys.modules)"
    )
    process = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT, check=False)
    assert process.returncode == 0, process.stderr
