"""Recorded inputs: single columns and whole files, CSV, netCDF and datasets; and what is wrong with them."""

from pathlib import Path
from typing import Any

import netCDF4
import numpy as np
import pytest

import lienumba
from lienumba import ScenarioError, System
from tests.facade import resolve
from tests.rigs.inputs import at_hinge

CSV = "t,a,b\n0,0,1\n1,2,1\n2,0,3\n"


def scenario(folder: Path, inputs: str, torque: str = "inputs.a + inputs.b") -> Path:
    (folder / "c.csv").write_text(CSV)
    file = folder / "s.toml"
    file.write_text(at_hinge(torque).to_toml() + "\n" + inputs)
    return file


def inputs_of(file: Path) -> dict[str, Any]:
    found: dict[str, Any] = resolve(file).to_dict()["inputs"]
    return found


def test_one_column_or_all_of_them_give_the_same(tmp_path: Path) -> None:
    single = '[inputs]\na = { file = "c.csv", time = "t", value = "a" }\nb = { file = "c.csv", value = "b" }\n'
    whole = '[inputs.recording]\nfile = "c.csv"\n'
    written = "[inputs]\na = { times = [0, 1, 2], values = [0, 2, 0] }\nb = { times = [0, 1, 2], values = [1, 1, 3] }\n"
    first, *others = (inputs_of(scenario(tmp_path, x)) for x in (single, whole, written))
    assert all(other == first for other in others)


def test_columns_are_chosen_renamed_and_read_as_told(tmp_path: Path) -> None:
    text = """
        [[inputs.recording]]
        file = "c.csv"
        values = { a = "b" }
        interpolation = "hold"
        delay = 0.25
        [[inputs.recording]]
        file = "c.csv"
        values = ["b"]
        prefix = "second_"
        filter = 0.1
        [inputs]
        b = 1.0
    """
    found = inputs_of(scenario(tmp_path, text))
    assert list(found) == ["b", "a", "second_b"]
    assert found["a"]["values"] == found["second_b"]["values"] == [1, 1, 3]
    assert (found["a"]["interpolation"], found["a"]["delay"], found["second_b"]["filter"]) == ("hold", 0.25, 0.1)


def test_a_dataset_is_a_recording_of_one_of_its_runs(tmp_path: Path) -> None:
    system = at_hinge("inputs.a + inputs.b").input("a", 1.0).input("b", "2*t").sweep(runs=3)
    ds = lienumba.run(system.vary("inputs.a", distribution="uniform", low=1, high=2))
    ds.to_netcdf(tmp_path / "r.nc")
    text = '[inputs]\na = 0\nb = { file = "r.nc", value = "hinge_at.angle", run = 2 }\n'
    found = inputs_of(scenario(tmp_path, text))["b"]
    np.testing.assert_array_equal(found["values"], ds["hinge_at.angle"][2])
    np.testing.assert_array_equal(found["times"], ds.time)


def test_a_variable_with_names_gives_an_input_for_each(tmp_path: Path) -> None:
    with netCDF4.Dataset(tmp_path / "r.nc", "w") as file:
        for name, size in (("run", 2), ("time", 3), ("coordinate", 2)):
            file.createDimension(name, size)
        file.createVariable("run", "i8", ("run",))[:] = [4, 7]
        file.createVariable("time", "f8", ("time",))[:] = [0.0, 1.0, 2.0]
        file.createVariable("coordinate", str, ("coordinate",))[:] = np.array(["a", "b"], object)
        numbers = np.arange(12.0).reshape(2, 3, 2)
        file.createVariable("tau", "f8", ("run", "time", "coordinate"))[:] = numbers
    found = inputs_of(scenario(tmp_path, '[inputs.recording]\nfile = "r.nc"\nvalues = "tau"\nrun = 7\n'))
    assert {name: x["values"] for name, x in found.items()} == {"a": [6, 8, 10], "b": [7, 9, 11]}
    one = '[inputs]\na = 0\nb = { file = "r.nc", value = "tau[a]", run = 4 }\n'
    assert inputs_of(scenario(tmp_path, one))["b"]["values"] == [0, 2, 4]


def test_what_extends_changes_keys_of_a_table_or_replaces_it(tmp_path: Path) -> None:
    scenario(
        tmp_path,
        '[inputs]\na = { joint = "hinge", kp = 3, target = 1, limit = 2 }\nb = { file = "c.csv", value = "b" }\n',
    )
    over = tmp_path / "over.toml"
    over.write_text(
        'extends = "s.toml"\n[inputs]\na = { kp = 4, limits = [-1, 2] }\nb = { value = "sin(t)", limit = 1 }\n'
    )
    found = inputs_of(over)
    assert (found["a"]["kp"], found["a"]["limits"], found["a"]["target"]) == (4, [-1, 2], 1)
    assert "limit" not in found["a"]
    assert (found["b"]["value"], found["b"]["limit"]) == ("sin(t)", 1)


def test_a_system_replaces_what_a_file_recorded(tmp_path: Path) -> None:
    system = System.from_toml(scenario(tmp_path, '[inputs.recording]\nfile = "c.csv"\n')).input("a", 3.0)
    assert resolve(system).to_dict()["inputs"]["a"] == 3.0
    assert resolve(system).to_dict()["inputs"]["b"]["values"] == [1, 1, 3]


def test_outside_of_its_points_a_recording_is_what_is_said() -> None:
    """A recording of 2 and 3, from 0.5 s on until 1 s."""
    system = at_hinge("inputs.a").input("a", times=[0.5, 1], values=[2, 3], interpolation="hold", outside=0)
    ds = lienumba.run(system).isel(run=0)
    np.testing.assert_array_equal(ds["inputs.a"], np.where((ds.time > 0.49) & (ds.time < 0.99), 2, 0))


REFUSED = {
    "no such column": (
        '[inputs.recording]\nfile = "c.csv"\nvalues = ["a", "c"]',
        'inputs.recording.file = "c.csv": has no column "c"; known here are "t", "a", "b"',
    ),
    "no such column of one": (
        '[inputs]\nb = 1\na = { file = "c.csv", value = "torque" }',
        'inputs.a.file = "c.csv": has no column "torque"; known here are "t", "a", "b"',
    ),
    "no such times": (
        '[inputs.recording]\nfile = "c.csv"\ntime = "clock"',
        'inputs.recording.file = "c.csv": has no column "clock"; known here are "t", "a", "b"',
    ),
    "no file": (
        '[inputs]\nb = 1\na = { file = "elsewhere.csv", value = "a" }',
        'inputs.a.file = "elsewhere.csv": there is no such file; check the path',
    ),
    "an input twice": (
        '[inputs]\na = 1\n[inputs.recording]\nfile = "c.csv"',
        'inputs.recording.file = "c.csv": its column "a" gives inputs.a, which is there already; say with values which '
        "columns to take, or give a prefix",
    ),
    "no table": (
        "[inputs]\nrecording = 3",
        'inputs.recording = 3: is the name of whole recordings; write [inputs.recording] with file = "commands.csv"',
    ),
    "an unknown key": (
        '[inputs]\nb = 1\na = { file = "c.csv", value = "a", interpol = "hold" }',
        'inputs.a.interpol is not a known key; the nearest known name is "interpolation"',
    ),
}


@pytest.mark.parametrize(("text", "said"), REFUSED.values(), ids=REFUSED.keys())
def test_what_is_wrong_is_said_in_one_sentence(tmp_path: Path, text: str, said: str) -> None:
    with pytest.raises(ScenarioError) as caught:
        resolve(scenario(tmp_path, text + "\n"))
    assert str(caught.value) == said


RUNS = {
    "0 alone": [0], "0 to 3": [0, 1, 2, 3], "2 and 7": [2, 7], "0, 2, 4, 6, 8, 10, ... and 18": list(range(0, 20, 2)),
}  # fmt: skip


@pytest.mark.parametrize(("told", "runs"), RUNS.items(), ids=RUNS.keys())
def test_a_run_that_is_not_there(tmp_path: Path, told: str, runs: list[int]) -> None:
    system = (
        at_hinge("inputs.a").input("a", "t").sweep(runs=20).vary("model.gravity[2]", "uniform", low=-9.9, high=-9.7)
    )
    lienumba.run(system, runs=runs).to_netcdf(tmp_path / "r.nc")
    with pytest.raises(ScenarioError) as caught:
        resolve(scenario(tmp_path, '[inputs]\nb = 1\na = { file = "r.nc", value = "inputs.a", run = 5 }\n'))
    assert str(caught.value) == f'inputs.a.file = "r.nc": has no run 5; its runs are {told}'
