"""The cache on disk: one folder per state of the kernels, the libraries and the interpreter.

Numba's own cache does not notice an edit in another module, so the folder's name carries a hash of every source file
that the drivers may see and of the versions below it: what edits mechanics or the tracer compiles no driver again.
Inside, object code is found by the hash of the complete LLVM text and CPU it was made from, and its own checksum stands
before it: neither a stale nor a torn entry can be served.
"""

import atexit
import contextlib
import functools
import hashlib
import os
import platform
import shutil
import sys
import tempfile
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path
from typing import Any

PACKAGE = Path(__file__).resolve().parents[1]
KERNELS = (  # all that the drivers can see, and what makes object code of text; a test compares
    "compiler/cache.py", "compiler/jit.py", "compiler/lanes.py", "compiler/native.py", "compiler/rows.py",
    "groups/so3.py", "groups/state.py", "integrators/codes.py", "integrators/drivers", "integrators/layout.py",
    "numerics/number.py", "numerics/operations.py", "numerics/vector_math.py",
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


@functools.cache
def folder() -> Path:
    """The folder of this state of package, libraries and interpreter; made if need be, temporary if it cannot be."""
    digest = hashlib.sha256()
    for path in seen():
        digest.update(str(path.relative_to(PACKAGE)).encode() + b"\0" + path.read_bytes() + b"\0")
    for name in ("numba", "llvmlite", "numpy"):
        digest.update(f"{name} {version(name)}\0".encode())
    digest.update(f"{sys.version} {platform.machine()}".encode())
    path = root() / digest.hexdigest()[:20]
    try:
        path.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=path):
            return path
    except OSError:
        path = Path(tempfile.mkdtemp(prefix="lienumba-cache-"))
        atexit.register(shutil.rmtree, path, ignore_errors=True)
        return path


def remember(key: str, make: Callable[[], bytes]) -> bytes:
    """The bytes made from `key`, from disk if they are there whole."""
    path = folder() / f"{hashlib.sha256(key.encode()).hexdigest()}.o"
    try:
        stored = path.read_bytes()
        if hashlib.sha256(stored[32:]).digest() == stored[:32]:
            return stored[32:]
    except OSError:
        pass
    made = make()
    with contextlib.suppress(OSError):  # a full or read-only disk costs the next start its cache, nothing else
        _write(path, hashlib.sha256(made).digest() + made)
    return made


def numba_cached(signature: Any, **options: Any) -> Callable[[Callable[..., Any]], Any]:
    """`njit(signature, cache=True)` with Numba's files in this state's folder, whatever the user's own setting is."""

    def compile_now(function: Callable[..., Any]) -> Any:
        from numba import njit
        from numba.core import config

        users, path = config.CACHE_DIR, folder() / "numba"
        if _checksums(path) != _written_checksums(path):
            shutil.rmtree(path, ignore_errors=True)  # torn by a killed process, or damaged: it could crash this one
        config.CACHE_DIR = str(path)
        try:
            return njit(signature, cache=True, **options)(function)
        except OSError:
            return njit(signature, **options)(function)  # a full disk
        finally:
            config.CACHE_DIR = users
            if (now := _checksums(path)) != _written_checksums(path):
                with contextlib.suppress(OSError):
                    _write(path.with_suffix(".sha256"), now.encode())

    return compile_now


def _checksums(path: Path) -> str:
    """The checksums of all files of a folder."""
    files = sorted(p for p in path.rglob("*") if p.is_file()) if path.is_dir() else []
    return "".join(f"{hashlib.sha256(p.read_bytes()).hexdigest()} {p.name}\n" for p in files)


def _written_checksums(path: Path) -> str:
    try:
        return path.with_suffix(".sha256").read_text()
    except OSError:
        return ""


def _write(path: Path, content: bytes) -> None:
    """Write a file in one step."""
    with tempfile.NamedTemporaryFile(dir=path.parent, delete=False) as file:
        file.write(content)
    os.replace(file.name, path)
