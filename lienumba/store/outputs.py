"""Files that are written: owned by one process from the first moment to the last, and there whole or not at all."""

from __future__ import annotations

import errno
import os
import re
import secrets
import shutil
import stat
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING

from lienumba.errors import ScenarioError
from lienumba.store.opening import NETCDF

if TYPE_CHECKING:
    import xarray as xr

AnyPath = str | os.PathLike[str]
Stamp = tuple[int, int, int, int]  # by which it is seen that a file is another one, or has been changed
SHARED = 0o666  # what the user's mask leaves of it
FULL = (errno.ENOSPC, errno.EDQUOT)  # reasons that go away with more room
PROBES, PROBE_BYTES = 256, 4096  # by which a full disk is seen: more than a library leaves of it
LINKLESS = getattr(os, "O_NOFOLLOW", 0)


class WriteError(OSError):
    """The finished message of a file that could not be written."""

    def __str__(self) -> str:
        return str(self.args[0])


class TakenError(WriteError):
    """What was made is whole and safe, but has another name than was asked for."""


class LostError(WriteError):
    """Something of what is to be written was there, and is no more."""


class Output:
    """A file that only this process writes.

    path: as it was named; target: what that means, whatever becomes of links and of the working folder; folder: of the
    runs of its sweep, while that is not finished.
    """

    def __init__(self, path: AnyPath) -> None:
        self.path, self.target = Path(path), Path(path).resolve()
        self.folder = Path(os.path.abspath(folder_of(self.path)))
        self._before = stamp_of(self.target)

    def partial(self) -> Path:
        """A name for the file while it is not whole."""
        return self.target.with_name(f"{self.target.name}.{secrets.token_hex(4)}.partial")

    def settle(self, partial: Path) -> None:
        """Give a file its name when all of it is on the disk; a TakenError if that would cost somebody another file."""
        to_disk(partial)
        now = stamp_of(self.target)
        if now is not None and now == self._before:
            os.replace(partial, self.target)
        elif not _named(partial, self.target):
            names = (self.target.with_stem(f"{self.target.stem}.{n}") for n in count(2))
            kept = next(name for name in names if _named(partial, name))
            to_disk(kept.parent)
            raise TakenError(
                f"output = {self.path}: somebody has written it meanwhile, and it is left as it is; what was made here "
                f"is in {kept}"
            )
        to_disk(self.target.parent)

    def failed(self, why: OSError, needs: str = "") -> WriteError:
        """What is said where the system refuses, and nothing is left of what was written; needs: what is known of the
        room that it takes."""
        folder = self.target.parent
        return WriteError(f"output = {self.path}: could not be written ({why.strerror}){remedy(why, folder, needs)}")


@contextmanager
def owned(path: AnyPath) -> Iterator[Output]:
    """A file that nobody else may write, by the way of this program; an OSError where it cannot be written at all."""
    output = Output(path)
    lock = output.target.with_name(f"{output.target.name}.lock")
    handle, found = _locked(lock, output.path)
    try:
        if found:  # who had it has been killed
            _remove_leftovers(output.target)
        yield output
    finally:
        with suppress(OSError):
            if not os.fstat(handle).st_size:  # else it is no lock of this program
                os.unlink(lock)
        os.close(handle)


@contextmanager
def whole(output: Output | AnyPath, takes: str = "") -> Iterator[Path]:
    """Where to write a file that bears its name only when all of it is on the disk; takes: see `Output.failed`."""
    with _held(output) as own:
        partial = own.partial()
        with _whole_or_nothing(own, partial, takes):
            yield partial
            own.settle(partial)


def write(dataset: xr.Dataset, output: Output | AnyPath) -> None:
    """Write the dataset in one step: at any moment the file is the old one, or none, or the whole new one.

    What a process leaves that is killed on the way is removed when the file is written again.
    """
    with whole(output, f"it takes up to {size(dataset.nbytes)}, and ") as partial, NETCDF:
        try:
            dataset.to_netcdf(partial, mode="w", format="NETCDF4", engine="netcdf4")
        except RuntimeError as error:  # netCDF4's word for a full disk
            raise OSError(str(error)) from error


@contextmanager
def _whole_or_nothing(output: Output, partial: Path, needs: str = "") -> Iterator[None]:
    """While a file is written; a WriteError where the system refuses, and nothing of the file is left."""
    try:
        yield
    except WriteError:
        raise
    except OSError as error:
        why = refusal(error, partial)
        discard(partial)
        raise output.failed(why, needs) from error
    finally:
        discard(partial)


@contextmanager
def _held(output: Output | AnyPath) -> Iterator[Output]:
    """A file that is owned already, or is while it is written."""
    if isinstance(output, Output):
        yield output
        return
    with ExitStack() as stack:
        try:
            own = stack.enter_context(owned(output))
        except OSError as error:
            raise error if isinstance(error, WriteError) else Output(output).failed(error) from error
        yield own


def folder_of(target: Path) -> Path:
    """Where the runs of a sweep are that is not finished."""
    return target.with_name(f"{target.name}.runs")


def size(count: float) -> str:
    """So many bytes, for people."""
    return f"{count / 1e6:,.1f} MB"


def remedy(why: OSError, folder: Path, needs: str = "", then: str = ", or choose another folder") -> str:
    """What is said behind the reason for which a file could not be written to a folder; then: what follows its
    mending."""
    if why.errno == errno.EFBIG:
        return f": a file may not be so large; raise the limit of their sizes (ulimit -f){then}"
    if why.errno not in FULL:
        return f"; see to {folder}{then}"
    with suppress(OSError):
        free = size(shutil.disk_usage(folder).free)
        has = f"{needs}{folder} has {free} free" if needs else f"it takes more than the {free} that {folder} has free"
        return f": {has}; make room there{then}"
    return f"; make room in {folder}{then}"


def refusal(error: OSError | RuntimeError, partial: Path) -> OSError:
    """Why the system did not take more of a file. It is asked again: libraries hide the reason, or give another."""
    try:
        with partial.open("ab", buffering=0) as file:
            for _ in range(PROBES):
                file.write(bytes(PROBE_BYTES))
    except OSError as refused:
        return refused
    if isinstance(error, OSError) and error.strerror:
        return error
    return OSError(errno.EIO, next(iter(str(error).splitlines()), type(error).__name__))


def discard(partial: Path) -> None:
    """Remove what is left of a failed write; nothing to do after a good one."""
    if partial.exists():
        with suppress(OSError):
            if os.stat(partial).st_nlink == 1:  # else it bears its name already
                os.truncate(partial, 0)  # HDF5 may hold a file open that it failed to write: give its room back
        partial.unlink()


def to_disk(path: Path) -> None:
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def _named(partial: Path, name: Path) -> bool:
    """Give a file a name that nobody has taken; whether that was so."""
    try:
        os.link(partial, name)
    except FileExistsError:
        return False
    except OSError:  # a file system without hard links
        if os.path.lexists(name):
            return False
        os.rename(partial, name)
        return True
    os.unlink(partial)
    return True


def stamp_of(path: Path) -> Stamp | None:
    """None where there is no file."""
    try:
        seen = path.stat()
    except OSError:
        return None
    return seen.st_dev, seen.st_ino, seen.st_size, seen.st_mtime_ns


def _locked(lock: Path, named: Path) -> tuple[int, bool]:
    """A handle that nobody else has until this process ends, however it ends; and whether the file was there."""
    while True:
        try:
            handle, found = os.open(lock, os.O_RDWR | os.O_CREAT | os.O_EXCL, SHARED), False
        except FileExistsError:
            try:
                handle, found = os.open(lock, os.O_RDONLY | os.O_NONBLOCK | LINKLESS), True
            except FileNotFoundError:  # its owner is done
                continue
        try:
            if not stat.S_ISREG(os.fstat(handle).st_mode):
                raise ScenarioError(f"output = {named}: {lock} is no file; remove it, or choose another output")
            _take(handle, named)
            if _is(lock, handle):
                return handle, found
        except BaseException:
            os.close(handle)
            raise
        os.close(handle)  # its owner was done in this very moment, and has removed it


def _take(handle: int, named: Path) -> None:
    try:
        import fcntl
    except ImportError:  # not on Windows
        return
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise ScenarioError(
            f"output = {named}: another process is writing it; wait until it is done, or choose another output"
        ) from None
    except OSError:  # a file system without locks
        return


def _is(path: Path, handle: int) -> bool:
    """Whether an open file still has this name."""
    try:
        return os.path.samestat(os.lstat(path), os.fstat(handle))
    except OSError:
        return False


def _remove_leftovers(target: Path) -> None:
    """Those of killed processes that were writing this file."""
    name = re.compile(re.escape(target.name) + r"\.[0-9a-f]{8}\.partial")
    for entry in list(os.scandir(target.parent)):
        if name.fullmatch(entry.name) and entry.is_file(follow_symlinks=False):
            os.unlink(entry.path)
