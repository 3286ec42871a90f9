"""The file keeps the CF conventions that it names: what of them can be said here, and a checker where there is one.

One of the checkers wants standard_name = "time" for any dimension of that name, and then an epoch, which the time of a
simulation has none of: that rule is its own, not that of CF.
"""

import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import netCDF4
import pytest
import xarray as xr

import lienumba
from lienumba.store.layout import COORDINATES
from lienumba.store.linear_layout import OWN
from lienumba.store.outputs import write
from tests.engine.rare.test_rare import SPREAD, away, flight
from tests.rigs.changing import CHANGING
from tests.rigs.studies import SAMPLED, ball
from tests.rigs.sweeps import top

TYPES = {"i1", "i2", "i4", "f4", "f8", "S1"}  # CF 1.8, 2.2; texts as characters, which all readers know
METHODS = ["midpoint", "rk4"]
OPEN = "* Coordinate variable 'time' should have standard_name='time', found: 'None'"


MIXED = {"force", "A", "B", "C", "D"}  # entries are of several units


def of_kind(kind: str) -> xr.Dataset:
    if kind in ("rare", "worst"):
        scenario = flight(away(SPREAD))
        return lienumba.rare(scenario, method="form") if kind == "rare" else lienumba.worst(scenario, runs=40)
    seen = [{"name": "tip", "type": "point", "body": "top", "point": [0, 0, 1]}]
    scenario = top(runs=3)
    scenario["model"]["quantities"] = seen
    found: xr.Dataset = getattr(lienumba, kind)(scenario)
    return found


@pytest.fixture(
    scope="module",
    params=["full", "summary", "study", "changes", "modes", "equilibrium", "linearise", "rare", "worst"],
)
def file(request: Any, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("cf") / "out.nc"
    if request.param == "study":
        lienumba.run(ball({"integrator.method": METHODS}, sweep=SAMPLED), output=path).close()
    elif request.param == "changes":
        lienumba.run(CHANGING, output=path).close()
    elif hasattr(lienumba, request.param):
        write(of_kind(request.param), path)
    else:
        more = {"summary": {"mode": "summary", "full_runs": "0:2", "summary": {"position": ["max"]}}}
        lienumba.run(top(runs=3, output={"every": 0.01, **more.get(request.param, {})}), output=path).close()
    return path


def test_types_units_and_labels(file: Path) -> None:
    with netCDF4.Dataset(file) as ds:
        assert ds.Conventions == "CF-1.8"
        for name, x in ds.variables.items():
            assert x.dtype is not str, name
            assert x.dtype.str[1:] in TYPES, name
            assert name in MIXED or isinstance(x.units, str), name
            assert isinstance(x.long_name, str), name
            assert "_FillValue" not in x.ncattrs() or x.dimensions != (name,), name
            assert "coordinates" not in x.ncattrs(), name  # paths have dots and brackets, which it must not have
            if "flag_values" in x.ncattrs():
                assert x.flag_values.dtype == x.dtype, name
                assert len(x.flag_values) == len(x.flag_meanings.split()), name
            if x.dimensions == (name,) and len(x) > 1:
                assert (x[1:] > x[:-1]).all(), name


def test_all_coordinates_are_there_when_it_is_opened(file: Path) -> None:
    with netCDF4.Dataset(file) as raw, xr.open_dataset(file) as ds:
        assert set(ds.coords) == {
            name
            for name, x in raw.variables.items()
            if name in COORDINATES or "role" in x.ncattrs() or (name in OWN and x.dimensions[0] == name)
        }
        known = {
            "axis": ["x", "y", "z"],
            "method": METHODS,
            "output": ["tip.x", "tip.y", "tip.z"],
            "requirement": ["near"],
        }
        name = next(name for name in known if name in ds.coords)
        assert ds[name].values.tolist() == known[name]


@pytest.mark.skipif(shutil.which("compliance-checker") is None, reason="needs compliance-checker")
@pytest.mark.parametrize("version", ["1.8", "1.11"])
def test_a_checker_finds_nothing_else(file: Path, version: str) -> None:
    command = ["compliance-checker", f"--test=cf:{version}", file.name]
    done = subprocess.run(command, cwd=file.parent, capture_output=True, text=True, check=False)
    errors = "".join(re.findall(r" Errors *\n(.*?) Warnings *\n", done.stdout, re.DOTALL))
    found = [line for line in errors.splitlines() if line.startswith("*")]
    assert [line for line in found if line != OPEN] == []


@pytest.mark.skipif(shutil.which("cfchecks") is None, reason="needs cfchecker, and its tables")
def test_another_checker_finds_nothing_at_all(file: Path) -> None:
    command = ["cfchecks", "--version=1.8", file.name]
    done = subprocess.run(command, cwd=file.parent, capture_output=True, text=True, check=False)
    assert "ERRORS detected: 0" in done.stdout, done.stdout
