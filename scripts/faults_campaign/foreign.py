"""Files that lienumba never wrote: of other tools, of no tool, and no files at all."""

import contextlib
import gzip
import os
import shutil
import socket
import threading
from collections.abc import Callable
from pathlib import Path

import h5py
import netCDF4
import numpy as np

Maker = Callable[[Path, Path], object]  # of a sound dataset and a path makes what stands there


def _h5(target: Path, fill: Callable[[h5py.File], object]) -> None:
    with h5py.File(target, "w") as file:
        fill(file)


def _netcdf(target: Path, fill: Callable[[netCDF4.Dataset], object], form: str = "NETCDF4") -> None:
    with netCDF4.Dataset(target, "w", format=form) as file:
        fill(file)


def _of_ours(source: Path, target: Path, change: Callable[[h5py.File], object]) -> None:
    shutil.copy(source, target)
    with h5py.File(target, "a") as file:
        change(file)


def _titled(source: Path, target: Path, title: str) -> None:
    shutil.copy(source, target)
    with netCDF4.Dataset(target, "a") as file:
        file.title = title


def _linked(source: Path, target: Path) -> None:
    own = target.with_name("linked.nc")
    shutil.copy(source, own)
    target.symlink_to(own)


def _text(target: Path, content: bytes) -> None:
    target.write_bytes(content)


def _socket(target: Path) -> None:
    with socket.socket(socket.AF_UNIX) as own:
        own.bind(target.name)  # in the folder of now: a path of 108 characters at most


def _pipe(target: Path) -> None:
    """To which somebody writes, again and again; one without a writer blocks whoever opens it, as it should."""

    def write() -> None:
        with contextlib.suppress(OSError):  # its folder is gone, or closed
            while True:
                with contextlib.suppress(BrokenPipeError), target.open("wb") as file:
                    file.write(b"x")

    os.mkfifo(target)
    threading.Thread(target=write, daemon=True).start()


def _cyclic(file: h5py.File) -> None:
    file["loop"] = h5py.SoftLink("/")
    file["elsewhere"] = h5py.ExternalLink("/etc/passwd", "/")
    file.create_group("within")["up"] = file["/"]


def _many(file: netCDF4.Dataset) -> None:
    for n in range(2000):
        file.createVariable(f"v{n}", "f8")
        file.setncattr(f"a{n}", "x")


def _huge(file: netCDF4.Dataset, runs: int) -> None:
    """Of which nothing is stored."""
    file.scenario_sha256 = "0" * 64
    file.createDimension("run", runs)
    for name, kind in (("run", "i8"), ("status", "i1"), ("end_time", "f8")):
        file.createVariable(name, kind, ("run",), chunksizes=(1000,))


def _types(file: netCDF4.Dataset) -> None:
    file.scenario_sha256 = "0" * 64
    file.createDimension("run", 3)
    file.createVariable("status", file.createEnumType(np.int8, "kinds", {"good": 0, "bad": 1}), ("run",))
    file.createVariable("run", file.createVLType(np.int64, "many"), ("run",))
    file.createVariable("end_time", file.createCompoundType(np.dtype([("a", "f8"), ("b", "i4")]), "pair"), ("run",))


def _classic(file: netCDF4.Dataset) -> None:
    file.scenario_sha256 = "0" * 64
    file.createDimension("run", 3)
    file.createDimension("letters", 5)
    file.createVariable("status", "i1", ("run",))[:] = 0
    file.createVariable("body", "S1", ("run", "letters"))


def _climate(file: netCDF4.Dataset) -> None:
    file.Conventions = "CF-1.8"
    for name, count in (("time", None), ("lat", 4), ("lon", 5)):
        file.createDimension(name, count)
        file.createVariable(name, "f8", (name,))
    file["time"].units = "days since 0000-01-01"
    file["time"][:] = [0, 1e300]
    file.createVariable("t2m", "f4", ("time", "lat", "lon"), fill_value=-9999.0)[:] = 280.0


FOREIGN: dict[str, Maker] = {
    "nothing": lambda sound, path: None,
    "an empty file": lambda sound, path: path.touch(),
    "text": lambda sound, path: _text(path, b"run,status\n0,0\n"),
    "a scenario": lambda sound, path: _text(path, b"[model]\nbodies = []\n"),
    "a picture": lambda sound, path: _text(path, b"\x89PNG\r\n\x1a\n" + bytes(64)),
    "the magic alone": lambda sound, path: _text(path, b"\x89HDF\r\n\x1a\n"),
    "the magic of netCDF-3": lambda sound, path: _text(path, b"CDF\x01\xff\xff\xff\xff\x00\x00\x00\x0a\x7f\xff"),
    "a packed dataset": lambda sound, path: _text(path, gzip.compress(sound.read_bytes())),
    "a dataset behind other bytes": lambda sound, path: _text(path, bytes(512) + sound.read_bytes()),
    "a folder": lambda sound, path: path.mkdir(),
    "a pipe": lambda sound, path: _pipe(path),
    "a socket": lambda sound, path: _socket(path),
    "a device": lambda sound, path: path.symlink_to("/dev/zero"),
    "a link to itself": lambda sound, path: path.symlink_to(path),
    "a link to nothing": lambda sound, path: path.symlink_to("nowhere.nc"),
    "a link to a dataset": lambda sound, path: _linked(sound, path),
    "HDF5 of a matrix": lambda sound, path: _h5(path, lambda file: file.create_dataset("x", data=np.eye(3))),
    "HDF5 of references": lambda sound, path: _h5(path, lambda f: f.create_dataset("x", (3,), h5py.ref_dtype)),
    "links in a circle": lambda sound, path: _of_ours(sound, path, _cyclic),
    "a trillion runs": lambda sound, path: _netcdf(path, lambda file: _huge(file, 10**12)),
    "100 million runs": lambda sound, path: _netcdf(path, lambda file: _huge(file, 10**8)),
    "types of its own": lambda sound, path: _netcdf(path, _types),
    "groups": lambda sound, path: _netcdf(path, lambda file: file.createGroup("a/b/c").createDimension("run", 3)),
    "netCDF-3": lambda sound, path: _netcdf(path, _classic, "NETCDF3_64BIT_OFFSET"),
    "a climate": lambda sound, path: _netcdf(path, _climate),
    "2,000 variables": lambda sound, path: _netcdf(path, _many),
    "a long title": lambda sound, path: _titled(sound, path, "\x1b[2J" * 5_000_000),
    "a title that is no UTF-8": lambda sound, path: _of_ours(
        sound, path, lambda f: f.attrs.modify("title", np.bytes_(b"\xff\xfe\x80"))
    ),
    "a variable that is a group": lambda sound, path: _of_ours(
        sound, path, lambda f: (f.pop("status"), f.create_group("status"))
    ),
}  # fmt: skip
