"""What a dataset says of its origin, and that netCDF takes it."""

import datetime
import platform

import netCDF4
import numba
import numpy as np
import pytest
import xarray as xr

import lienumba
from lienumba.store.outputs import write
from lienumba.store.provenance import attributes
from tests.store.store_example import example

TOML = 'title = "Kreisel µ"\n[sweep]\nruns = 3\n'


def test_what_is_said():
    said = attributes("Kreisel µ", TOML, "ab12", 2015, "lienumba run top.toml")
    assert said["Conventions"].startswith("CF-1.")
    assert said["title"] == "Kreisel µ"
    assert said["scenario"] == TOML
    assert said["scenario_sha256"] == "ab12"
    assert said["seed"] == 2015
    assert said["source"] == f"lienumba {lienumba.__version__}"
    assert said["python_version"] == platform.python_version()
    assert said["numba_version"] == numba.__version__
    assert said["numpy_version"] == np.__version__
    assert said["xarray_version"] == xr.__version__
    assert said["netcdf4_version"] == netCDF4.__version__
    assert {"llvmlite_version", "scipy_version", "lienumba_version", "cpu", "references"} <= set(said)
    stamp, command = said["history"].split(" ", 1)
    assert command == "lienumba run top.toml"
    age = datetime.datetime.now(datetime.UTC) - datetime.datetime.fromisoformat(stamp)
    assert abs(age) < datetime.timedelta(seconds=10)


@pytest.mark.parametrize("seed", [0, 2**63 - 1, 2**63, 2**127])
def test_netcdf_gives_back_every_attribute(tmp_path, seed):
    long = TOML + "# every default written out\n" * 20_000  # far beyond the 64 KiB of an old HDF5 attribute
    said = attributes("", long, "ab12", seed, "lienumba run 'my file.toml'")
    write(example().assign_attrs(said), tmp_path / "out.nc")
    with xr.open_dataset(tmp_path / "out.nc") as opened:
        for name, value in said.items():
            assert opened.attrs[name] == value, name
        assert int(opened.attrs["seed"]) == seed


def test_the_cpu_is_the_one_that_numba_compiles_for(monkeypatch):
    monkeypatch.setattr(numba.config, "CPU_NAME", "haswell")
    assert attributes("", TOML, "", 0, "")["cpu"] == "haswell"
