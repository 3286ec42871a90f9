"""Courses that each run has in a file."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import lienumba
from lienumba import analysis
from lienumba.scene import scene
from tests.facade import ScenarioError, resolve
from tests.rigs.disturbed import assert_same_data

TIMES = np.linspace(0.0, 1.0, 11)
COURSES = np.random.default_rng(0).standard_normal((40, 11))


def written(folder: Path, values: np.ndarray = COURSES, times: np.ndarray = TIMES, **more: Any) -> Path:
    path = folder / "gusts.nc"
    coordinates = {"time": times, **more}
    xr.Dataset({"gust": (("run", "time"), values, {"units": "N"})}, coordinates).to_netcdf(path)
    return path


def scenario(path: Path, **sweep: Any) -> dict[str, Any]:
    return {
        "model": {
            "bodies": [{"name": "ball", "mass": 2.0, "inertia": [1, 1, 1], "position": [0, 0, 0]}],
            "gravity": [0, 0, 0],
            "forces": [{"name": "wind", "type": "force", "body": "ball", "value": ["gust", 0, 0]}],
        },
        "noise": [{"name": "gust", "type": "table", "table": str(path), "value": "gust"}],
        "integrator": {"step": 0.02, "end_time": 1.0},
        "output": {"every": 0.1},
        "sweep": {"runs": 30} | sweep,
    }


def test_each_run_has_its_course(tmp_path: Path) -> None:
    """RK4 is exact for lines, on whose ends steps land."""
    given = scenario(written(tmp_path), nominal=True)
    ds = lienumba.run(given)
    drawn = ds.sel(run=range(30))
    exact = np.trapezoid(COURSES[:30], TIMES, axis=1) / 2.0
    np.testing.assert_allclose(drawn.velocity.sel(body="ball", axis="x").isel(time=-1), exact, atol=1e-14)
    np.testing.assert_allclose(drawn.gust, COURSES[:30], atol=1e-14)
    assert ds.gust.units == "N"
    assert float(abs(ds.gust.sel(run=-1)).max()) == 0.0
    few = lienumba.run(given, runs=[17, 3], workers=1)
    np.testing.assert_array_equal(few.position, ds.position.sel(run=few.run))
    lienumba.run(given, output=tmp_path / "out.nc", runs=range(10))
    lienumba.run(given, output=tmp_path / "out.nc", resume=True)
    with xr.open_dataset(tmp_path / "out.nc") as resumed:
        np.testing.assert_array_equal(resumed.position, ds.position)
    with pytest.raises(ScenarioError, match=r"noise\.gust\.table: has courses of 40 runs, and sweep\.runs is 50"):
        lienumba.run(given, overrides={"sweep.runs": 50})
    with pytest.raises(ScenarioError, match=r"noise\.gust\.table: ends at 1 s, and the run at 1\.5 s; give longer"):
        lienumba.run(given, overrides={"integrator.end_time": 1.5})


def weighted(path: Path) -> dict[str, Any]:
    """The same with runs that have weights, and a requirement about each as a whole."""
    masses = {"vary": {"bodies.ball.mass": {"distribution": "normal", "std": 0.1}}, "sampler": "importance"}
    return scenario(path, **masses, proposal={"bodies.ball.mass": {"shift": -1.5}}) | {
        "quantities": [{"name": "place", "type": "point", "body": "ball"}],
        "measures": [{"name": "way", "value": "max(place.x) - min(place.x)"}],
        "requirements": [{"name": "near", "value": "way", "below": 0.4, "probability": 0.9}],
    }


def test_weights_and_courses_in_parts_resumed_and_replayed(tmp_path: Path) -> None:
    """Whoever computes which runs: all bits of the whole, weights and courses of a file among them."""
    given = weighted(written(tmp_path))
    whole = lienumba.run(given)
    for k in (1, 2):
        lienumba.run(given, output=tmp_path / f"{k}.nc", part=(k, 2), workers=1).close()
    lienumba.merge([tmp_path / "2.nc", tmp_path / "1.nc"], tmp_path / "merged.nc")
    lienumba.run(given, output=tmp_path / "resumed.nc", runs=[3, 17, 5]).close()
    lienumba.run(given, output=tmp_path / "resumed.nc", resume=True).close()
    for name in ("merged", "resumed"):
        with xr.open_dataset(tmp_path / f"{name}.nc") as found:
            assert_same_data(found.load(), whole)
            assert found.attrs["verdict"] == whole.attrs["verdict"]
    assert float(whole.weight.max()) > float(whole.weight.min()) + 1.0
    again = lienumba.replay(tmp_path / "merged.nc", 17)
    for name in ("weight", "gust", "way", "requirement_margin", "position"):
        x = again[name].sel(time=whole.time) if "time" in again[name].dims else again[name]
        np.testing.assert_array_equal(x, whole[name].sel(run=[17]))


def test_a_scenario_knows_its_file(tmp_path: Path) -> None:
    path = written(tmp_path)
    first = resolve(scenario(path))
    known = first.to_toml()
    again = tmp_path / "again.toml"
    again.write_text(known)
    assert resolve(again).to_toml() == known
    written(tmp_path, 2.0 * COURSES)
    with pytest.raises(ScenarioError, match="is not the file with which this was written; give that file, whose SHA"):
        lienumba.run(again)
    again.write_text(known.replace(str(path), f"{path.parent}/{'a' * 300}.nc"))  # longer than names of files may be
    with pytest.raises(ScenarioError, match="there is no such file; put the file there"):
        lienumba.run(again)
    assert resolve(scenario(path)).sha256() != first.sha256()
    other = path.rename(tmp_path / "other.nc")
    written(tmp_path)
    changed = resolve(scenario(path), overrides={"noise.gust.table": f'"{other}"'})
    assert changed.sha256() == resolve(scenario(other)).sha256()


def test_a_sweep_goes_on_wherever_its_files_are(tmp_path: Path) -> None:
    """Parts of two folders are of one sweep, and a dataset is replayed with the file beside it; what needs no courses
    needs no file."""
    folders = [tmp_path / "a", tmp_path / "b"]
    for n, folder in enumerate(folders):
        folder.mkdir()
        lienumba.run(scenario(written(folder)), output=folder / "out.nc", part=(n + 1, 2))
    lienumba.merge([folder / "out.nc" for folder in folders], tmp_path / "whole.nc")
    for folder in folders:
        (folder / "gusts.nc").rename(folder / "moved.nc")
    with xr.open_dataset(tmp_path / "whole.nc") as whole, xr.open_dataset(tmp_path / "b" / "out.nc") as half:
        assert whole.sizes["run"] == 30
        assert analysis.compare(whole, half).attrs["changes"] == ""
        assert scene(whole).runs
    with pytest.raises(ScenarioError, match=r"gust\.table = .*: there is no such file; .* or gusts\.nc beside"):
        lienumba.replay(tmp_path / "whole.nc", 20)
    (tmp_path / "a" / "moved.nc").rename(tmp_path / "gusts.nc")
    found = lienumba.replay(tmp_path / "whole.nc", 20)
    np.testing.assert_allclose(found.gust.sel(run=20)[::5], COURSES[20], atol=1e-14)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"times": TIMES + 0.1}, "its times do not begin at 0 or are not at equal intervals; resample the courses"),
        ({"times": TIMES**2}, "its times do not begin at 0 or are not at equal intervals; resample the courses"),
        ({"values": np.where(np.arange(40)[:, None] == 7, np.nan, COURSES)}, "run 7 of gust has a value that is not"),
        ({"run": np.arange(40)[::-1]}, "its runs are not 0, 1, 2 and so on; sort them, or leave run out"),
    ],
)
def test_files_that_are_refused(tmp_path: Path, change: dict[str, Any], said: str) -> None:
    path = written(tmp_path, **change)
    with pytest.raises(ScenarioError) as refused:
        resolve(scenario(path))
    assert str(refused.value).startswith("noise.gust.table")
    assert said in str(refused.value)


def test_what_is_no_such_file(tmp_path: Path) -> None:
    path = written(tmp_path)
    given = scenario(path)
    given["noise"][0]["value"] = "gusts"
    with pytest.raises(ScenarioError, match='has no variable "gusts"; the nearest known name is "gust"'):
        resolve(given)
    path.write_text("run,time")
    with pytest.raises(ScenarioError, match="is no netCDF-4 file; save it as such"):
        resolve(scenario(path))
    path.unlink()
    with pytest.raises(ScenarioError, match="there is no such file; check the path"):
        resolve(scenario(path))
