"""The file keeps the CF conventions that it names: what of them can be said here, and a checker where there is one.

The checker wants standard_name = "time" for any coordinate of that name, and then an epoch, which the time of a
simulation has none of: that rule is its own, not that of CF. Paths of inputs have brackets, which it does not like in
`coordinates`; they are how inputs are named.
"""

import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import netCDF4
import pytest

import lienumba
from tests.rigs.sweeps import top

TYPES = {"i1", "i2", "i4", "i8", "u1", "u2", "u4", "u8", "f4", "f8"}  # CF 1.9 and later, 2.2
OPEN = (
    r"\* Coordinate variable 'time' should have standard_name='time', found: 'None'",
    r"\* The 'coordinates' attribute of variable '[\w.]+' contains invalid characters: [^,;]*",  # brackets of paths
)


@pytest.fixture(scope="module", params=["full", "summary"])
def file(request: Any, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("cf") / "out.nc"
    more = {"summary": {"mode": "summary", "full_runs": "0:2", "summary": {"position": ["max"]}}}
    lienumba.run(top(runs=3, output={"every": 0.01, **more.get(request.param, {})}), output=path).close()
    return path


def test_types_units_and_labels(file: Path) -> None:
    with netCDF4.Dataset(file) as ds:
        assert ds.Conventions == "CF-1.11"
        for name, x in ds.variables.items():
            assert x.dtype is str or x.dtype.str[1:] in TYPES, name
            assert isinstance(x.units, str), name
            assert isinstance(x.long_name, str), name
            assert x.dtype is str or "_FillValue" not in x.ncattrs() or x.dimensions != (name,), name
            if "flag_values" in x.ncattrs():
                assert x.flag_values.dtype == x.dtype, name
                assert len(x.flag_values) == len(x.flag_meanings.split()), name
            if x.dimensions == (name,) and x.dtype is not str and len(x) > 1:
                assert (x[1:] > x[:-1]).all(), name


@pytest.mark.skipif(shutil.which("compliance-checker") is None, reason="needs compliance-checker")
def test_a_checker_finds_nothing_else(file: Path) -> None:
    command = ["compliance-checker", "--test=cf:1.11", file.name]
    done = subprocess.run(command, cwd=file.parent, capture_output=True, text=True, check=False)
    (errors,) = re.findall(r" Errors *\n(.*?) Warnings *\n", done.stdout, re.DOTALL)
    found = [line for line in errors.splitlines() if line.startswith("*")]
    assert [line for line in found if not any(re.fullmatch(rule, line) for rule in OPEN)] == []
