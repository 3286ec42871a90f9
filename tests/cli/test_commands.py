"""The commands, their exit codes, and how fast the light ones answer."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
import xarray as xr
from typer.testing import CliRunner, Result

from lienumba import __version__
from lienumba.engine import runner
from lienumba.store.outputs import WriteError
from tests.facade import app
from tests.rigs.places import ROOT, SCENARIOS

SHORT = ("--set", "integrator.end_time=0.02")
HEAVY = ("numba", "llvmlite", "xarray", "pandas", "netCDF4", "scipy", "matplotlib")


def lienumba(*arguments: Any) -> Result:
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


def test_run_writes_a_dataset_and_says_so(tmp_path: Path) -> None:
    target = tmp_path / "top.nc"
    result = lienumba("run", SCENARIOS / "heavy_top.toml", "-o", target, *SHORT)
    assert result.exit_code == 0, result.output
    assert "Heavy top: 1 of 1 runs good, 0 failed" in result.stdout
    assert f"written to {target}" in result.stdout.replace("\n", "")
    assert "simulating" in result.stderr
    with xr.open_dataset(target) as dataset:
        assert dataset.sizes["run"] == 1
        assert dataset["position"].sel(time=0.02).shape == (1, 1, 3)


def test_default_output_is_the_stem_in_the_current_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert lienumba("run", SCENARIOS / "heavy_top.toml", "--quiet", *SHORT).exit_code == 0
    assert [item.name for item in tmp_path.iterdir()] == ["heavy_top.nc"]


def test_quiet_is_silent(tmp_path: Path) -> None:
    result = lienumba("run", SCENARIOS / "heavy_top.toml", "-o", tmp_path / "top.nc", "-q", *SHORT)
    assert (result.exit_code, result.output) == (0, "")


def test_overwrite_replaces(tmp_path: Path) -> None:
    target = tmp_path / "top.nc"
    target.write_bytes(b"\x89HDF old")
    options = ("-o", target, "-q", "--overwrite", *SHORT)
    assert lienumba("run", SCENARIOS / "heavy_top.toml", *options).exit_code == 0
    assert target.stat().st_size > 1000


def test_runs_seed_and_settings_reach_the_dataset(tmp_path: Path) -> None:
    target = tmp_path / "top.nc"
    options = (
        "-o",
        target,
        "-q",
        "-j",
        1,
        "--seed",
        7,
        "--runs",
        "3,17,-1",
        "--set",
        "sweep.runs=20",
        *SHORT,
    )
    assert lienumba("run", SCENARIOS / "heavy_top_monte_carlo.toml", *options).exit_code == 0
    with xr.open_dataset(target) as dataset:
        assert dataset["run"].values.tolist() == [-1, 3, 17]
        assert dataset.attrs["seed"] == 7
        assert dataset["bodies.top.mass"].attrs["role"] == "input"
        assert float(dataset["bodies.top.mass"].sel(run=-1)) == 15.0


def test_failed_runs_are_told_and_give_1(tmp_path: Path) -> None:
    target = tmp_path / "top.nc"
    options = (
        "-o", target, "--set", "sweep.runs=16", "--set", "sweep.vary.bodies.top.mass.std=2", *SHORT
    )  # fmt: skip
    result = lienumba("run", SCENARIOS / "heavy_top_monte_carlo.toml", *options)
    assert result.exit_code == 1, result.output
    assert "will draw a value of 0 or below and fail" in result.stderr
    assert "invalid_sample" in result.stdout
    with xr.open_dataset(target) as dataset:
        failed = dataset["status"] != 0
        assert 0 < int(failed.sum()) < 16
        assert dataset["position"].sel(run=failed).isnull().all()
        assert dataset["position"].sel(run=~failed).notnull().all()
    told = lienumba("info", target)
    assert "success" in told.stdout
    assert "invalid_sample (runs " in told.stdout


@pytest.mark.parametrize(
    ("error", "code", "message"),
    [
        (KeyboardInterrupt(), 130, "interrupted: no dataset was written"),
        (WriteError("output = x.nc: could not be written"), 1, "error: output = x.nc: could not be written"),
    ],
)
def test_other_ends(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, error: BaseException, code: int, message: str
) -> None:
    def fail(*_: Any, **__: Any) -> None:
        raise error

    monkeypatch.setattr(runner, "run", fail)
    result = lienumba("run", SCENARIOS / "heavy_top.toml", "-o", tmp_path / "x.nc")
    assert result.exit_code == code
    assert result.stderr.splitlines() == [message]


@pytest.mark.parametrize("file", sorted(SCENARIOS.glob("*.toml")), ids=lambda file: file.stem)
def test_validate(file: Path) -> None:
    result = lienumba("validate", file)
    assert result.exit_code == 0, result.output
    assert result.stdout.startswith(f"{file} is valid: ")
    assert result.stderr == "" or file.stem.startswith("satellite")


def test_validate_warns() -> None:
    result = lienumba("validate", SCENARIOS / "heavy_top.toml", "--set", "bodies.top.inertia=[1, 1, 3]")
    assert result.exit_code == 0
    assert result.stderr.startswith("warning: model.bodies.top.inertia = [1.0, 1.0, 3.0]: no rigid body")


def test_schema_is_json_and_describes_every_section() -> None:
    result = lienumba("schema")
    assert result.exit_code == 0
    schema = json.loads(result.stdout)
    assert set(schema["properties"]) == {
        "title",
        "extends",
        "parameters",
        "quantities",
        "noise",
        "events",
        "measures",
        "requirements",
        "inputs",
        "start",
        "tables",
        "files",
        "model",
        "integrator",
        "projection",
        "output",
        "sweep",
        "study",
        "sensitivities",
    }
    assert schema["additionalProperties"] is False


def test_info_of_a_dataset(tmp_path: Path) -> None:
    target = tmp_path / "top.nc"
    options = ("-o", target, "-q", "--set", "sweep.runs=8", *SHORT)
    assert lienumba("run", SCENARIOS / "heavy_top_monte_carlo.toml", *options).exit_code == 0
    result = lienumba("info", target)
    assert result.exit_code == 0, result.output
    for text in ("8 (labels 0 to 7)", "bodies.top.mass", "8 success", "seed 2015", "numba", "0 to 0.02 s"):
        assert text in result.stdout


def test_info_of_a_scenario_with_quantities() -> None:
    result = lienumba("info", SCENARIOS / "arm_pd.toml")
    assert result.exit_code == 0, result.output
    assert "tip (point), shoulder_angle (joint), elbow_angle (joint)" in " ".join(result.stdout.split())


def test_info_of_a_scenario() -> None:
    result = lienumba("info", SCENARIOS / "pendulum_chain.toml")
    assert result.exit_code == 0, result.output
    assert "24 rows of rank 24 at the start, 24 degrees of freedom" in result.stdout
    assert "flops" not in result.stdout
    more = lienumba("info", SCENARIOS / "pendulum_chain.toml", "--verbose")
    assert re.search(r"\nflops: +.*[\d,]+, .*[\d,]+ \(per run and call\)\n", more.stdout)


def test_info_tells_what_is_redundant() -> None:
    told = lienumba("info", SCENARIOS / "four_bar.toml").stdout
    assert "crank_bearing (revolute, 5)" in told
    assert "20 rows of rank 17 at the start, 1 degree of freedom" in told
    assert "3 of rocker_bearing (rows that follow from those before them)" in told
    assert "not unique for crank_bearing, crank_end, rocker_end, rocker_bearing; those of least norm" in told


def test_info_names_drivers_and_forces() -> None:
    told = lienumba("info", SCENARIOS / "template.toml").stdout
    assert "shaker (value, 1)" in told
    assert "spring (spring_damper), air (drag), bearing (friction)" in told


def test_info_of_another_netcdf_file(tmp_path: Path) -> None:
    xr.Dataset({"x": 1}).to_netcdf(tmp_path / "other.nc", engine="netcdf4")
    result = lienumba("info", tmp_path / "other.nc")
    assert result.exit_code == 2
    assert "is a netCDF file but not of lienumba; give one that lienumba run wrote" in result.stderr


def test_a_scenario_in_the_place_of_a_dataset(tmp_path: Path) -> None:
    (tmp_path / "top.toml").write_text("[model]\n")
    for command in ("analyse", "replay"):
        result = lienumba(command, tmp_path / "top.toml")
        assert result.exit_code == 2
        assert "top.toml is a scenario, not a dataset; run it first: lienumba run" in result.stderr


def test_info_of_a_torn_netcdf_file(tmp_path: Path) -> None:
    (tmp_path / "torn.nc").write_bytes(b"\x89HDF\r\n\x1a\n" + bytes(100))
    result = lienumba("info", tmp_path / "torn.nc")
    assert result.exit_code == 2
    assert "cannot be opened as netCDF" in result.stderr


def test_info_of_nothing(tmp_path: Path) -> None:
    result = lienumba("info", tmp_path / "none.nc")
    assert result.exit_code == 2
    assert "does not exist" in result.stderr


def test_doctor() -> None:
    result = lienumba("doctor")
    assert result.exit_code == 0, result.output
    for word in ("lienumba:", "numba", "cpu:", "cache:", "passed"):
        assert word in result.stdout


def test_version() -> None:
    assert lienumba("--version").stdout == f"lienumba {__version__}\n"


@pytest.mark.parametrize(
    "arguments", [["--help"], ["run", "--help"], ["validate", str(SCENARIOS / "heavy_top_monte_carlo.toml")]]
)
def test_light_commands_import_nothing_heavy(arguments: list[str]) -> None:
    """What they would import takes longer than all that they do."""
    code = f"import sys; sys.argv = {['lienumba', *arguments]!r}\n" + (
        "from lienumba.cli import main\ntry:\n    main()\nexcept SystemExit as end:\n    assert not "
        "end.code\n"
        f"loaded = [name for name in {HEAVY!r} if name in sys.modules]\nassert not loaded, loaded"
    )
    process = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT)
    assert process.returncode == 0, process.stderr


def test_importing_the_package_is_light() -> None:
    code = f"import sys, lienumba; assert not {set(HEAVY) | {'numpy', 'pydantic'}!r} & set(sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True, cwd=ROOT, env={**os.environ})


def test_python_dash_m(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "lienumba", "validate", str(tmp_path / "none.toml")]
    process = subprocess.run(command, capture_output=True, text=True, cwd=ROOT)
    assert process.returncode == 2
    assert process.stderr.startswith("error: ")
