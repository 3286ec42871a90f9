"""Datasets that somebody or something has changed: every command ends with success or a sentence."""

import contextlib
import os
import random
from pathlib import Path

import netCDF4
import pytest
import xarray as xr
from typer.testing import CliRunner

from tests.facade import app
from tests.rigs.places import scripts_on_path

with scripts_on_path():
    from faults_campaign import attack, commands, datasets, foreign, subjects

RAW = {  # of the whole, or of a variable: what an attribute becomes
    "no TOML": (None, "scenario", "a ="),
    "no text": (None, "scenario", 5),
    "no scenario": (None, "scenario", "[sweep]\nruns = 'x'"),
    "deep": (None, "scenario", "a = " + "[" * 5000),
    "a title of numbers": (None, "title", [1.0, 2.0]),
    "another version": (None, "lienumba_version", 5),
    "other statuses": ("status", "flag_meanings", "fine"),
    "codes that are words": ("status", "flag_values", "0 1 2"),
    "units that are numbers": ("position", "units", 5),
    "a scale that is a word": ("position", "scale_factor", "x"),
    "a role of another": ("position", "role", "input"),
    "no path": ("bodies.bob.mass", "role", "grid"),
    "a role of numbers": ("bodies.bob.mass", "role", [1.0, 2.0]),
}
COMMANDS = (
    ["info"],
    ["table", "-o", "made.csv"],
    ["info", "--cite"],
    ["analyse"],
    ["plot"],
    ["replay", "--run", "1"],
    ["report"],
)


@pytest.fixture(scope="module")
def sound(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    return subjects.prepared(tmp_path_factory.mktemp("sound"))


def refused(path: Path) -> None:
    """By every command, in one sentence."""
    for command in COMMANDS:
        with contextlib.chdir(path.parent):
            done = CliRunner().invoke(app, [command[0], str(path), *command[1:]])
        assert isinstance(done.exception, SystemExit), (command, done.exception)
        assert done.exit_code == 2, command
        (line,) = done.stderr.splitlines()
        assert line.startswith(f"error: {path}"), command


@pytest.mark.parametrize("name", RAW)
def test_attributes_of_other_kinds(name: str, sound: dict[str, Path], tmp_path: Path) -> None:
    where, key, value = RAW[name]
    path = tmp_path / "x.nc"
    path.write_bytes(sound["full"].read_bytes())
    with netCDF4.Dataset(path, "a") as file:
        place = file if where is None else file.variables[where]
        place.setncattr(key, value)
    refused(path)


@pytest.mark.parametrize(("name", "value"), [("change_what", 99), ("change_kind", 77), ("change_time", float("nan"))])
def test_changes_that_are_none(name: str, value: float, sound: dict[str, Path], tmp_path: Path) -> None:
    path = tmp_path / "x.nc"
    path.write_bytes(sound["changes"].read_bytes())
    with netCDF4.Dataset(path, "a") as file:
        file.variables[name][1, 0] = value
    refused(path)


@pytest.mark.parametrize(
    ("kind", "name"),
    [
        *[("study", name) for name in ("steps", "end_time", "evaluations", "time_per_run", "time_per_run_spread")],
        *[("changes", f"change_{name}") for name in ("time", "kind", "what", "impulse", "energy")],
        *[("changes", name) for name in ("changes", "energy_lost", "requirement_margin")],
    ],
)
def test_what_is_of_no_use_without_another(kind: str, name: str, sound: dict[str, Path], tmp_path: Path) -> None:
    path = tmp_path / "x.nc"
    with xr.open_dataset(sound[kind]) as ds:
        ds.drop_vars(name).to_netcdf(path)
    for command in (["report", "-o", "x.html"], ["analyse"]):
        with contextlib.chdir(tmp_path):
            done = CliRunner().invoke(app, [command[0], str(path), *command[1:]])
        assert done.exit_code == 2
        assert done.stderr.startswith(f"error: {path}: is not as lienumba wrote it, it has lost {name};")


def test_a_selection_without_the_table_of_changes(sound: dict[str, Path], tmp_path: Path) -> None:
    """Its sums alone, and margins alone, are enough for what they say."""
    path = tmp_path / "x.nc"
    with xr.open_dataset(sound["changes"]) as ds:
        table = [str(name) for name in ds.data_vars if str(name).startswith("change_")]
        ds.drop_vars([*table, "requirement_met"]).to_netcdf(path)
    for command in (["report", "-o", "x.html"], ["analyse"], ["info"]):
        with contextlib.chdir(tmp_path):
            done = CliRunner().invoke(app, [command[0], str(path), *command[1:]])
        assert done.exit_code == 0, done.output


def test_a_dataset_without_a_scenario_cites_nothing(sound: dict[str, Path], tmp_path: Path) -> None:
    path = tmp_path / "x.nc"
    path.write_bytes(sound["full"].read_bytes())
    with netCDF4.Dataset(path, "a") as file:
        file.setncattr("scenario", "")
    done = CliRunner().invoke(app, ["info", str(path), "--cite"])
    assert done.exit_code == 2
    assert done.stderr == "error: the dataset brings no scenario, which would say what is to be cited\n"


def test_a_title_is_text_on_a_terminal(sound: dict[str, Path], tmp_path: Path) -> None:
    path = tmp_path / "x.nc"
    path.write_bytes(sound["full"].read_bytes())
    with netCDF4.Dataset(path, "a") as file:
        file.title = "red \x1b[31m\x1b]0;own\x07 \u202e"
    for command in (["info"], ["analyse", "tip"]):
        done = CliRunner().invoke(app, [command[0], str(path), *command[1:]])
        assert done.exit_code == 0
        assert not {"\x1b", "\x07", "\u202e"} & {*done.output}
    assert "red \\x1b[31m" in CliRunner().invoke(app, ["info", str(path)]).output


def test_chunks_that_are_damaged(sound: dict[str, Path], tmp_path: Path) -> None:
    """What netCDF says in the middle of the work."""
    content = bytearray(sound["full"].read_bytes())
    path = tmp_path / "x.nc"
    told = set()
    for first in range(8000, len(content), 16_000):
        changed = content.copy()
        changed[first : first + 64] = b"\xff" * 64
        path.unlink(missing_ok=True)
        path.write_bytes(changed)
        done = CliRunner().invoke(app, ["analyse", str(path)])
        assert done.exception is None or isinstance(done.exception, SystemExit), done.exception
        told.add(done.exit_code)
    assert told <= {0, 2}


def test_some_of_the_attack(sound: dict[str, Path], tmp_path: Path) -> None:
    """scripts/faults has more of it."""
    with contextlib.chdir(os.getcwd()):
        found = attack.attack(tmp_path, seed=3, count=6, sources=sound)
    assert not found.faults, found.faults[0]
    assert found.codes[2] > 2
    assert found.codes[0] > 2


@pytest.mark.parametrize("name", foreign.FOREIGN)
def test_files_of_others(name: str, sound: dict[str, Path], tmp_path: Path) -> None:
    path = tmp_path / "x.nc"
    with contextlib.chdir(tmp_path):
        foreign.FOREIGN[name](sound["full"], path)
        end = commands.tried(["table", str(path), "-o", "made.csv"])
    assert not end.fault
    if name in ("a link to a dataset", "a dataset behind other bytes", "a title that is no UTF-8"):
        assert end.code == 0
    else:
        assert end.code == 2
        assert end.told.startswith(f"error: {path}")


@pytest.mark.parametrize("kind", ["rare", "worst"])
def test_searches_for_failures_are_no_sweeps(kind: str, tmp_path: Path) -> None:
    import lienumba

    path = tmp_path / "x.nc"
    more = {"method": "form"} if kind == "rare" else {"runs": 40}
    getattr(lienumba, kind)(subjects.scenario("rare"), workers=1, **more).to_netcdf(path)
    for command in COMMANDS:
        with contextlib.chdir(tmp_path):
            done = CliRunner().invoke(app, [command[0], str(path), *command[1:]])
        assert done.exit_code == 2, command
        assert f"is of the search for a {kind} {'failure' if kind == 'rare' else 'case'}, not of runs" in done.stderr


def test_the_attack_is_the_same_every_time(sound: dict[str, Path], tmp_path: Path) -> None:
    told = [datasets.changed(sound["full"], tmp_path / f"{n}.nc", random.Random(5)) for n in range(2)]
    assert told[0] == told[1]
