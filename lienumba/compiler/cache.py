"""The cache on disk: one folder per state of the kernels, the libraries and the interpreter.

The folder's name carries a hash of every source file
that the drivers may see and of the versions below it: what edits mechanics or the tracer compiles no driver again.
Inside, object code is found by the hash of the complete LLVM text and CPU it was made from, and its own checksum stands
before it: neither a stale nor a torn entry can be served. So are drivers, by their names (`lienumba.compiler.flat`),
and programs, by all that decides about them (`lienumba.integrators.tracing.compiled`).
"""

import atexit
import contextlib
import functools
import hashlib
import os
import platform
import shutil
import stat
import sys
import tempfile
import warnings
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[1]
KERNELS = (  # all that the drivers can see, and what makes object code of text; a test compares
    "compiler/cache.py", "compiler/flat.py", "compiler/lanes.py", "compiler/native.py",
    "compiler/routines", "compiler/rows.py", "groups/so3.py", "groups/state.py", "integrators/codes.py",
    "integrators/drivers", "integrators/drivers/events", "integrators/drivers/measuring",
    "integrators/drivers/switching", "integrators/layout.py", "integrators/bounds.py", "integrators/selection_table.py",
    "integrators/sizes.py", "integrators/hysteresis.py", "numerics/number.py", "numerics/operations.py",
    "numerics/vector_math.py",
)  # fmt: skip


def root() -> Path:
    """LIENUMBA_CACHE_DIR, or the user's cache folder."""
    if named := os.environ.get("LIENUMBA_CACHE_DIR"):
        return Path(named)
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA", Path.home() / "AppData" / "Local")) / "lienumba" / "cache"
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Caches" / "lienumba"
    xdg = os.environ.get("XDG_CACHE_HOME", "")
    return (Path(xdg) if os.path.isabs(xdg) else Path.home() / ".cache") / "lienumba"


def seen() -> list[Path]:
    """The source files of KERNELS."""
    every = (PACKAGE / name for name in KERNELS)
    return sorted(path for place in every for path in ([place] if place.is_file() else place.glob("*.py")))


def state() -> str:
    """A digest of KERNELS, of the libraries and of the interpreter, as they are now."""
    digest = hashlib.sha256()
    for path in seen():
        digest.update(str(path.relative_to(PACKAGE)).encode() + b"\0" + path.read_bytes() + b"\0")
    digest.update(_versions().encode())
    return digest.hexdigest()[:20]


@functools.cache
def _versions() -> str:
    """The libraries and the interpreter of this process."""
    libraries = "".join(f"{name} {version(name)}\0" for name in ("llvmlite", "numpy"))
    return f"{libraries}{sys.version} {platform.machine()}"


_state = functools.cache(lambda: state())  # that of this process


@functools.cache
def folder() -> Path:
    """The folder of this state of package, libraries and interpreter; made if need be, temporary if it cannot be, or
    if it is not the user's own: who can write there could plant machine code."""
    path = root() / _state()
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.mkdir(mode=0o700, exist_ok=True)
        foreign = _foreign(path)
        if not foreign:
            with tempfile.TemporaryFile(dir=path):
                return path
        warnings.warn(
            f"the cache {path} {foreign}, so its machine code is not trusted and is made anew for this process; delete "
            "that folder, or name one of your own in LIENUMBA_CACHE_DIR",
            stacklevel=2,
        )
    except OSError:
        pass
    path = Path(tempfile.mkdtemp(prefix="lienumba-cache-"))
    atexit.register(shutil.rmtree, path, ignore_errors=True)
    return path


def _foreign(path: Path) -> str:
    """Why others could have written into a folder; empty if they could not."""
    if not hasattr(os, "geteuid"):
        return ""  # on Windows the user's folder is the user's
    at = path.lstat()
    if stat.S_ISLNK(at.st_mode):
        return "is a link"
    if at.st_uid != os.geteuid():
        return "belongs to another user"
    return "may be written by others" if at.st_mode & (stat.S_IWGRP | stat.S_IWOTH) else ""


def name_of(key: str, kind: str = "o") -> str:
    """The name of the entry of a key: "o" for object code, "program" for what is known of a program."""
    return f"{hashlib.sha256(key.encode()).hexdigest()}.{kind}"


def recall(name: str) -> bytes | None:
    """An entry, if it is there whole."""
    try:
        stored = (folder() / name).read_bytes()
    except OSError:
        return None
    return stored[32:] if hashlib.sha256(stored[32:]).digest() == stored[:32] else None


def keep(name: str, content: bytes) -> None:
    """Write an entry. A full or read-only disk costs the next start its cache, nothing else; so do sources that were
    edited while it was made."""
    with contextlib.suppress(OSError):
        if state() == _state():
            _write(folder() / name, hashlib.sha256(content).digest() + content)


def remember(key: str, make: Callable[[], bytes]) -> bytes:
    """The bytes made from `key`, from disk if they are there whole."""
    name = name_of(key)
    stored = recall(name)
    if stored is None:
        stored = make()
        keep(name, stored)
    return stored


def _write(path: Path, content: bytes) -> None:
    """Write a file in one step."""
    with tempfile.NamedTemporaryFile(dir=path.parent, delete=False) as file, contextlib.ExitStack() as left:
        left.callback(lambda: Path(file.name).unlink(missing_ok=True))
        file.write(content)
        file.close()
        os.replace(file.name, path)
