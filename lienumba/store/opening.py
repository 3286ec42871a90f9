"""Opening of netCDF files, where HDF5 may go round and round in itself for ever: it does where a heap, which holds
texts and what belongs to which dimension, has been filled with zeros.

So it reads all of these on a thread, of which it lets the others run, and whoever asked is told where that one does not
come back. It ends with the process only, and until then no other file may be opened beside it.
"""

from __future__ import annotations

import contextvars
import ctypes
import math
import os
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from lienumba.errors import ScenarioError

if TYPE_CHECKING:
    import netCDF4

Found = TypeVar("Found")

# HDF5 is not thread-safe, not even on different files: whoever calls, one thread at a time uses it.
NETCDF = threading.RLock()
PATIENCE = 60.0  # s on the clock, and of computing: a sound file takes milliseconds, a slow disk computes nothing
DENSEST = 1100  # bytes that a byte may be packed from: deflate's limit is 1,032
_away: list[tuple[threading.Thread, str]] = []  # what has not come back yet, and from which file


def opened(path: Path, open_it: Callable[[], Found]) -> Found:
    """What a function opens of a file, and the errors that it raises; a ScenarioError where it does not come back.

    The function must not ask for `NETCDF`, which is held.
    """
    with NETCDF:
        check_at_hand(str(path))
        came: list[Found] = []
        failed: list[BaseException] = []
        run = contextvars.copy_context().run

        def work() -> None:
            try:
                came.append(run(open_it))
            except BaseException as error:
                failed.append(error)

        thread, before = threading.Thread(target=work, daemon=True, name=f"opens {path}"), time.process_time()
        _away.append((thread, str(path)))
        thread.start()
        thread.join(PATIENCE)
        while thread.is_alive() and time.process_time() - before < PATIENCE:
            thread.join(1.0)
        if failed:
            raise failed[0]
        if not came:
            _end_without_hdf5()
            raise ScenarioError(
                f"{path}: cannot be opened, HDF5 has been at it for {PATIENCE:g} s of computing, as where a file is "
                "damaged; make it again, or give it as it was"
            )
        return came[0]


def busy() -> str:
    """The file from which HDF5 has not come back, if there is one."""
    _away[:] = [(thread, path) for thread, path in _away if thread.is_alive()]
    return _away[0][1] if _away else ""


def check_at_hand(what: str) -> None:
    """Refuse what needs HDF5 while it has not come back from another file."""
    if path := busy():
        raise ScenarioError(
            f"{what}: HDF5 is still at work on {path}, which is probably damaged; leave that file out, in a new process"
        )


def netcdf_file(path: str | os.PathLike[str]) -> netCDF4.Dataset:
    """A netCDF file to read from, of which nothing lies in a heap that has not been read."""
    import netCDF4

    def whole() -> netCDF4.Dataset:
        file = netCDF4.Dataset(path)
        read_heaps(file, os.path.getsize(path))
        return file

    return opened(Path(path), whole)


def read_heaps(file: netCDF4.Dataset, size: int) -> None:
    """Read attributes and texts of an open file of so many bytes, of which more texts are not read than it can hold."""
    holders: list[Any] = [file, *file.variables.values()]
    for holder in holders:
        for name in holder.ncattrs():
            with suppress(Exception):  # whoever asks for it tells that it cannot be read
                holder.getncattr(name)
    for variable in file.variables.values():
        if variable.dtype is str and math.prod(variable.shape) <= DENSEST * size:
            with suppress(Exception):
                variable[...]


def _end_without_hdf5() -> None:
    """Let the process end as it will, but without what HDF5 does then: beside what has not come back, it crashes.

    Elsewhere than in glibc nothing tells with which exit code a process ends, so that it has to try.
    """
    if os.name == "posix" and hasattr(libc := ctypes.CDLL(None), "on_exit"):
        libc.on_exit(ctypes.cast(libc._exit, ctypes.c_void_p), None)
