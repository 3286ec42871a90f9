"""How the jitted functions are compiled: without LLVM's costliest passes, in two thirds of the time, and as fast."""

from contextlib import suppress
from pathlib import Path
from threading import Lock
from typing import Any

from numba import njit, typeof
from numba.core import config

entry = njit(nogil=True, error_model="numpy", cache=True)  # of a function that Python calls
compiled = njit(nogil=True, error_model="numpy", cache=True, no_cpython_wrapper=True, no_cfunc_wrapper=True)

LEVEL = 1  # of optimisation; with 3, the heavy top takes as long, and compiling it half as long again
LOCK = Lock()  # threads share the setting


def is_kept(function: Any) -> bool:
    """Whether Numba's cache has an entry, compiled from the sources as they are."""
    folder = Path(function.stats.cache_path)
    _forget_stale(folder)
    return any(folder.glob(f"*.{function.__name__}-*.nbi"))


def compile_for(function: Any, *arguments: object) -> None:
    """Compile an entry for arguments of these types, or load it from Numba's cache, where that has not been done."""
    with LOCK:
        if not function.signatures:
            _forget_stale(Path(function.stats.cache_path))
        level, config.OPT = config.OPT, type(config.OPT)(LEVEL)
        try:
            function.compile(tuple(map(typeof, arguments)))
        finally:
            config.OPT = level


def _forget_stale(folder: Path) -> None:
    """Remove what Numba has kept of older sources: it compares a function with its own file alone, and not with those
    of the functions that it calls."""
    newest = max(source.stat().st_mtime for source in Path(__file__).parent.glob("*.py"))
    for index in folder.glob("*.nbi"):
        with suppress(OSError):  # another process has been faster
            if index.stat().st_mtime < newest:
                index.unlink()
