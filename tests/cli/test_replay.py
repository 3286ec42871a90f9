"""The command `replay`: which run, what is said, what is refused."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from typer.testing import CliRunner, Result

import lienumba
from lienumba import __version__
from lienumba.engine.select_run import worst
from lienumba.scenario.base import code
from lienumba.store import windows
from lienumba.store.layout import Variable, dataset
from tests.facade import app
from tests.rigs.sweeps import edit_samples, top

SPIN = "bodies.top.angular_velocity[1]"
LAW = """
from pathlib import Path
from lienumba.laws import sqrt

Path("executed").touch()

def push(top, late):
    return top.torque((0.0, 0.0, 1e-3 * sqrt(late)))
"""


def command(*arguments: Any) -> Result:
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def failed(folder: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A sweep of which runs 3 and 7 failed."""
    with monkeypatch.context() as patch:
        edit_samples(patch, {3: {SPIN: 1e9}, 7: {"bodies.top.mass": -1.0}})
        lienumba.run(top(runs=11), workers=1, output="sweep.nc").close()
    return folder / "sweep.nc"


def test_a_failed_run(failed: Path, folder: Path) -> None:
    done = command("replay", failed, "--run", 3)
    assert done.exit_code == 0, done.output
    lines = done.stdout.splitlines()
    assert lines[0].startswith("run 3: rotation_too_large at 0 s: a body turned too far in one step: ")
    assert lines[1] == f"the same bits as run 3 of {failed} at 6 common times"
    assert lines[2] == "written to sweep.run3.nc, with 51 stored times"
    with xr.open_dataset("sweep.run3.nc") as ds:
        assert ds["run"].values.tolist() == [3]
        assert ds[SPIN].item() == 1e9
    refused = command("replay", failed, "--run", 3)
    assert refused.exit_code == 2
    assert refused.stderr == (
        "error: output = sweep.run3.nc: exists already; choose another name, or replace it with --overwrite\n"
    )
    again = command("replay", failed, "--run", 3, "--overwrite", "-q", "--every", 0.01)
    assert (again.exit_code, again.output) == (0, "")
    again = command("replay", folder / "sweep.run3.nc", "--run", 3, "-o", "more.nc")
    assert "the same bits" in again.stdout


def test_which_run(failed: Path) -> None:
    for options, said in (
        ((), f"{failed}: which run? Give --run N, or --worst NAME, such as --worst max_energy_drift; 2 of 11 failed, "
             "the first is --run 3"),
        (("--run", 1, "--worst", "energy"), "--run N names a run, and --worst NAME chooses one; give one of them"),
        (("--run", 11), f"{failed}: has no run 11, but 11 with labels from 0 to 10; give one of them"),
        (("--worst", "enrgy"), '--worst enrgy: the dataset has no such variable; the nearest known name is "energy"'),
        (("--worst", "status"),
         "--worst status: says how a run ended, not how large something is; choose with --run N"),
    ):  # fmt: skip
        refused = command("replay", failed, *options)
        assert (refused.exit_code, refused.stderr) == (2, f"error: {said}\n")


def test_the_worst_run(failed: Path) -> None:
    done = command("replay", failed, "--worst", "velocity", "-o", "out.nc")
    with xr.open_dataset(failed) as ds:
        sizes = abs(ds["velocity"]).max(["time", "body", "axis"]).fillna(-1.0)
        label = int(ds["run"][int(np.argmax(sizes.values))])
    assert done.stdout.startswith(
        f"run {label} has the largest |velocity| of 11 runs: {float(sizes.max()):.6g} m s-1 (top, "
    )
    assert f"the same bits as run {label} of " in done.stdout


def test_code_is_refused_unless_it_is_allowed(folder: Path) -> None:
    """Nothing of it runs before."""
    Path("arm.py").write_text(LAW)
    data = top(runs=4)
    data["parameters"] = {"late": 1.0}
    data["model"]["forces"] = [{"name": "own", "type": "python", "function": "arm.py:push", "bodies": ["top"],
                                "parameters": {"late": "late"}}]  # fmt: skip
    lienumba.run(data, workers=1, output="sweep.nc").close()
    Path("arm.py").unlink()
    Path("executed").unlink()
    code._namespace.cache_clear()
    refused = command("replay", "sweep.nc", "--run", 1)
    assert refused.exit_code == 2
    assert refused.stderr == (
        "error: sweep.nc: brings Python code, which a replay runs: arm.py; read it in the attribute `scenario`, and if "
        "you trust it, give --allow-code\n"
    )
    assert not Path("executed").exists()
    assert not Path("sweep.run1.nc").exists()
    allowed = command("replay", "sweep.nc", "--run", 1, "--allow-code")
    assert Path("executed").exists()
    assert "the same bits as run 1 of sweep.nc at 6 common times" in allowed.stdout, allowed.output
    with pytest.raises(lienumba.ScenarioError, match="brings Python code"):
        lienumba.replay("sweep.nc", 1)
    assert lienumba.replay("sweep.nc", run=1, allow_code=True, output="own.nc")["status"].item() == 0
    assert Path("own.nc").is_file()


def test_a_dataset_of_another_version_and_one_that_was_changed(failed: Path) -> None:
    with xr.open_dataset(failed) as opened:
        ds = opened.load()
    ds.attrs["lienumba_version"] = "0.0.7"
    ds.to_netcdf("old.nc")
    done = command("replay", "old.nc", "--run", 1)
    assert done.exit_code == 0
    assert f"warning: old.nc: was written by lienumba 0.0.7, and this is {__version__}, whose re" in done.stderr
    ds["energy"][1, 4] += 1.0
    ds.to_netcdf("other.nc")
    done = command("replay", "other.nc", "--run", 1, "-o", "out.nc")
    assert done.exit_code == 1
    assert "warning: not the same as run 1 of other.nc: energy at t = 0.04 s is " in done.stderr
    assert "the same bits" not in done.stdout
    assert Path("out.nc").is_file()


def test_what_failed_and_why_is_in_the_dataset(failed: Path) -> None:
    told = command("info", failed).stdout
    assert "9 success, 1 rotation_too_large (runs 3), 1 invalid_sample (runs 7)\n" in told
    assert "\n             invalid_sample: a sampled mass, inertia, length or speed of friction is not positive" in told
    with xr.open_dataset(failed) as ds:
        status, reasons = ds["status"], ds["status"].attrs["comment"].splitlines()
        for code, line in zip(status.attrs["flag_values"], reasons, strict=True):
            assert line.startswith(status.attrs["flag_meanings"].split()[list(status.attrs["flag_values"]).index(code)])
        assert ds["end_time"].sel(run=[3, 7]).values.tolist() == [0.0, 0.0]
        np.testing.assert_array_equal(ds["last_position"].sel(run=3), ds["position"].sel(run=3, time=0.0))
        assert np.isnan(ds["last_position"].sel(run=7)).all()


def test_info_of_summaries(folder: Path) -> None:
    output: dict[str, Any] = {"every": 0.01, "mode": "summary"}
    lienumba.run(top(runs=3, output=output), workers=1, output="none.nc").close()
    output |= {"summary": {"position": ["max"]}, "full_runs": "0:2", "variables": ["energy"]}
    lienumba.run(top(runs=3, output=output), workers=1, output="some.nc").close()
    none, some = (command("info", name).stdout for name in ("none.nc", "some.nc"))
    assert "\ntimes:       none: of each run a summary\nbodies:      top\ninputs: " in none
    assert "\nvariables:   position_max\nfull runs:   2 (labels 0, 1), with energy\n" in some
    assert "\ntimes:       6 from 0 to 0.05 s\n" in some


def made(**more: Any) -> xr.Dataset:
    """Twelve runs, labels from 100 on."""
    energy = np.zeros((12, 3))
    energy[5, 1], energy[7, 2], energy[8] = -7.0, 6.0, np.nan
    own = {
        "tip_max": (Variable(("run", "axis"), "m", "tip"), np.arange(36.0).reshape(12, 3)),
        "tip_time_of_max": (Variable(("run", "axis"), "s", "tip"), np.full((12, 3), 0.25)),
        "tip_min": (Variable(("run", "axis"), "m", "tip"), np.zeros((12, 3)) - 34.5),
        "tip": (Variable(("full_run", "time"), "m", "tip"), np.full((2, 3), 99.0)),
        "load": (Variable(("full_run", "time"), "N", "load"), np.array([[1.0, -3.0, 2.0], [2.0, 2.5, np.nan]])),
    }  # fmt: skip
    return dataset(
        variables={"energy": energy, "status": np.zeros(12), **{name: x for name, (_, x) in own.items()}},
        own={name: spec for name, (spec, _) in own.items()},
        times=[0.0, 0.5, 1.0], runs=range(100, 112), full_runs=[103, 104], bodies=[], joints=[], constraints=[],
        inputs={"gravity[0]": np.linspace(-3.0, 1.0, 12)}, input_units={"gravity[0]": "m s-2"}, attributes={},
    )  # fmt: skip


@pytest.mark.parametrize("size", [1, 10**6])
def test_what_is_worst(size: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of courses, of summaries, of a course that some runs have, of inputs; some runs at a time, or all."""
    monkeypatch.setattr(windows, "WINDOW_BYTES", size)
    ds = made()
    for name, said in (
        ("energy", "run 105 has the largest |energy| of 12 runs: 7 J, at t = 0.5 s"),
        ("tip", "run 111 has the largest |tip| of 12 runs: 35 m (z), at t = 0.25 s"),
        ("tip_min", "run 100 has the largest |tip_min| of 12 runs: 34.5 m (x)"),
        ("load", "run 103 has the largest |load| of 2 runs whose course is stored: 3 N, at t = 0.5 s"),
        ("gravity[0]", "run 100 has the largest |gravity[0]| of 12 runs: 3 m s-2"),
    ):
        found = worst(ds, name)
        assert found.sentence == said
        assert f"run {found.run} has" in said
    ds["energy"][:] = np.nan
    with pytest.raises(lienumba.ScenarioError, match='worst="energy": no run has a value of it; choose another'):
        worst(ds, "energy")
