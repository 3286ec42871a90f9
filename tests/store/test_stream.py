"""What is written run by run, raw, is the file that netCDF4 would have written, whatever the parts."""

import sys
from itertools import pairwise
from pathlib import Path
from typing import Any

import h5py
import netCDF4
import numpy as np
import pytest
import xarray as xr

from lienumba.store import deflate
from lienumba.store.finished import Finished, OpenFiles
from lienumba.store.outputs import Output, write
from lienumba.store.stream import SourceSlice, Stream, slices
from tests.facade import ScenarioError
from tests.store.store_example import INPUTS, example

SHAPE: dict[str, Any] = {"bodies": ("top", "Kreisel µ"), "joints": ("pivot",), "efforts": ("motor",)}
BODIES, TIMES = 2, 101
PARTS = {  # 9 runs make a chunk of rotations
    "one run": [0, 1],
    "a chunk": [0, 9],
    "one more": [0, 9, 10],
    "uneven": [0, 4, 4, 9, 10, 11, 25],
    "one by one": [*range(20)],
    "at once": [0, 25],
}


class Columns:
    """A dataset in memory as a source."""

    def __init__(self, ds: Any) -> None:
        self.columns = {name: x.values for name, x in ds.data_vars.items() if x.dims[0] == "run"}
        self.labels = ds["run"].values

    def read(self, part: slice) -> dict[str, np.ndarray]:
        return {name: x[part] for name, x in self.columns.items()}

    def column(self, name: str) -> np.ndarray:
        return self.columns[name]


class Labels:
    """A source of which only the labels are asked for."""

    def __init__(self, *labels: int) -> None:
        self.labels = np.array(labels)


def test_runs_come_from_the_first_source_that_has_them() -> None:
    """Sources that overlap, one whose runs are not in order, and one that is of no use."""
    sources: list[Any] = [Labels(4, 3), Labels(), Labels(-1, 3, 5, 6), Labels(0, 1, 2, 3, 4)]
    found = slices(np.array([-1, 0, 1, 3, 4, 6]), sources)
    assert [(sources.index(x.source), x.part.start, x.part.stop) for x in found] == [
        (2, 0, 1), (3, 0, 2), (0, 1, 2), (0, 0, 1), (2, 3, 4)
    ]  # fmt: skip
    with pytest.raises(ValueError, match="no source has run 7"):
        slices(np.array([6, 7]), sources)


def streamed(ds: Any, path: Path, bounds: list[int]) -> Path:
    stream = Stream(example(runs=0, total=ds.sizes["run"], **SHAPE), Output(path), 2)
    told: list[int] = []
    for first, last in pairwise(bounds):
        stream.put("run", [SourceSlice(Columns(ds), slice(first, last))], told.append, first)
    stream.finish({name: ds[name].values for name in ("run", *INPUTS)}, {"stopped": "enough, µ"})
    assert told[-1] == bounds[-1]
    return path


def described(path: Path) -> dict[str, Any]:
    """All that the file says of each variable, beside its values."""
    with netCDF4.Dataset(path) as file:
        file.set_auto_maskandscale(False)
        return {
            name: (x.dimensions, x.dtype, x.shape, x.filters(), x.endian(),
                   {key: repr(x.getncattr(key)) for key in x.ncattrs()})
            for name, x in file.variables.items()
        }  # fmt: skip


@pytest.mark.parametrize("parts", PARTS)
def test_it_is_the_file_that_netcdf4_writes(parts: str, tmp_path: Path) -> None:
    runs = PARTS[parts][-1]
    ds = example(runs=runs, **SHAPE)
    ds["position_iterations"][0, 0] = np.nan  # of a run that failed: there is no count
    path = streamed(ds, tmp_path / "out.nc", PARTS[parts])
    write(ds.assign_attrs(stopped="enough, µ"), tmp_path / "whole.nc")
    assert described(path) == described(tmp_path / "whole.nc")
    with xr.open_dataset(path) as found:
        xr.testing.assert_identical(found.load(), ds.assign_attrs(stopped="enough, µ"))
    assert sorted(x.name for x in tmp_path.iterdir()) == ["out.nc", "whole.nc"]


def test_other_readers_read_it(tmp_path: Path) -> None:
    pytest.importorskip("h5netcdf")
    ds = example(runs=25, **SHAPE)
    path = streamed(ds, tmp_path / "out.nc", [0, 25])
    with xr.open_dataset(path, engine="h5netcdf") as found:
        xr.testing.assert_identical(found.load().drop_attrs(deep=False), ds.drop_attrs(deep=False))
        assert found.attrs["stopped"] == "enough, µ"
    with h5py.File(path) as file:  # no filter that a reader would have to bring
        assert {x.compression for x in file.values()} <= {None, "gzip"}
        scales = [dim.label for dim in file["rotation"].dims]
        assert len(scales) == 5
        assert file["run"].is_scale
        assert file["position"].maxshape[0] is None


def test_without_isal_the_values_are_the_same(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "isal", None)
    monkeypatch.setattr(deflate, "_library", deflate._library.__wrapped__)
    ds = example(runs=25, **SHAPE)
    with xr.open_dataset(streamed(ds, tmp_path / "out.nc", [0, 7, 25])) as found:
        xr.testing.assert_identical(found.drop_attrs(deep=False).load(), ds.drop_attrs(deep=False))


def test_every_byte_of_a_chunk_is_guarded(tmp_path: Path) -> None:
    """Noise, which is stored as it is, too."""
    path = streamed(example(runs=25, **SHAPE), tmp_path / "out.nc", [0, 25])
    with h5py.File(path) as file:
        chunk = file["rotation"].id.get_chunk_info_by_coord((9, 0, 0, 0, 0))
        assert chunk.filter_mask == 0
    sound = path.read_bytes()
    for place in (3, chunk.size // 2, chunk.size - 2):
        content = bytearray(sound)
        content[chunk.byte_offset + place] ^= 4
        path.write_bytes(content)
        opened = OpenFiles()
        finished = Finished(path, opened)
        assert len(finished.tables["run"].column("energy")) == 25
        with pytest.raises(ScenarioError, match="is damaged, rotation cannot be read"):
            finished.tables["run"].column("rotation")
        opened.close()


def test_what_fails_on_the_way_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def no_memory(*_: object) -> bytes:
        raise MemoryError

    monkeypatch.setattr("lienumba.store.columns.deflated", no_memory)
    stream = Stream(example(runs=0, total=25, **SHAPE), Output(tmp_path / "out.nc"), 2)

    def written() -> None:
        stream.put("run", [SourceSlice(Columns(example(runs=25, **SHAPE)), slice(0, 25))], lambda runs: None)
        stream.finish({}, {})

    with pytest.raises(MemoryError):
        written()
    stream.discard()
    assert list(tmp_path.iterdir()) == []
