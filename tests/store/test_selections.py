"""Files that hold only a part of what was written."""

import re

import pytest

import lienumba
from lienumba import ScenarioError
from lienumba.scene import scene
from lienumba.store import files
from tests.rigs.sweeps import top

ONE = "has only one {0}, without its dimension; select with a list, such as ds.sel({0}=[{1}])"
WITHOUT = "does not say {0} of each run; select runs and variables of what lienumba run wrote, and keep {1}"


@pytest.mark.parametrize(
    ("select", "said"),
    [
        (lambda ds: ds.isel(run=1), ONE.format("run", 1)),
        (lambda ds: ds.sel(body="top"), ONE.format("body", "'top'")),
        (lambda ds: ds.isel(time=0), ONE.format("time", 0.0)),
        (lambda ds: ds.assign(status=ds.status.max()), WITHOUT.format("status", "status")),
        (lambda ds: ds.isel(run=[]), "has no run; select at least one"),
    ],
)
def test_selections_that_have_lost_too_much_are_refused(tmp_path, select, said):
    path = tmp_path / "some.nc"
    select(lienumba.run(top(runs=2))).to_netcdf(path)
    with pytest.raises(ScenarioError, match=re.escape(f"{path}: {said}")):
        files.read(path)
    with pytest.raises(ScenarioError, match="is a folder; give the dataset in it"):
        files.read(tmp_path)


def test_other_selections_are_read(tmp_path):
    path = tmp_path / "some.nc"
    lienumba.run(top(runs=4))[["position", "status", "end_time"]].isel(run=[3, 1], time=[2]).to_netcdf(path)
    with files.read(path) as ds:
        assert ds["run"].values.tolist() == [3, 1]


def test_what_moves_needs_the_ends_of_runs():
    with pytest.raises(ScenarioError, match=WITHOUT.format("end_time", "status and end_time")):
        scene(lienumba.run(top(runs=2)).drop_vars("end_time"))
