"""Routines as object code: what arrives, and what a second process does without compiling."""

import os
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest

FUNCTION = """
from typing import NamedTuple
import numpy as np
from lienumba.compiler.routines.marks import Floats2, Floats3, Floats4, Integers1

class Sizes(NamedTuple):
    a: int
    b: int

class Mixed(NamedTuple):
    x: Floats3
    y: float
    z: Integers1

def gather(n: int, out: Floats2, sizes: Sizes, f: float, mixed: Mixed, deep: Floats4):
    out[1, 0] = n
    out[1, 1] = sizes.a
    out[1, 2] = sizes.b
    out[2, 0] = f
    out[2, 1] = mixed.y
    out[2, 2] = mixed.z[mixed.z.size - 1]
    out[0, 0] = mixed.x[1, 2, 3]
    out[0, 1] = deep[1, 0, 1, 2]
    out[0, 2] = deep[1].size + mixed.x.shape[1]
"""
CALLED = """
import sys
import numpy as np
from lienumba.compiler.flat import kept
gather = kept("function", "gather")
out = np.zeros((3, 3))
x, deep = np.arange(24.0).reshape(2, 3, 4), np.arange(36.0).reshape(2, 3, 2, 3)
arguments = [7, out, (3, -4), 0.5, (x, 2.5, np.arange(5)), deep]
gather(*arguments)
assert out.tolist() == [[23.0, 23.0, 21.0], [7.0, 3.0, -4.0], [0.5, 2.5, 4.0]], out
for place, wrong in ((0, 7.0), (3, 1), (1, out[0]), (1, out.T), (1, out.astype("f4")), (2, (3, -4, 5))):
    try:
        gather(*(wrong if n == place else a for n, a in enumerate(arguments)))
    except TypeError as error:
        assert str(error), error
    else:
        raise AssertionError(wrong)
assert "numba" not in sys.modules
print("function" in sys.modules)
"""


def compiles(place: Path, **more: str) -> bool:
    """Whether a new process needs the source; it asserts that what it calls is right."""
    (place / "function.py").write_text(FUNCTION)
    (place / "script.py").write_text(CALLED)
    settings = {"LIENUMBA_CACHE_DIR": str(place / "cache"), **more}
    command = [sys.executable, "-W", "error", str(place / "script.py")]
    done = subprocess.run(command, env=os.environ | settings, capture_output=True, text=True, cwd=place)
    assert done.returncode == 0, done.stderr
    return done.stdout.strip() == "True"


def test_a_second_process_does_without_the_source(tmp_path: Path) -> None:
    assert compiles(tmp_path)
    assert not compiles(tmp_path, PYTHONHASHSEED="12345")


def test_another_cpu_is_other_code(tmp_path: Path) -> None:
    assert compiles(tmp_path)
    assert compiles(tmp_path, NUMBA_CPU_NAME="generic")
    assert not compiles(tmp_path, NUMBA_CPU_NAME="generic")
    assert not compiles(tmp_path)


def test_a_damaged_file_is_made_again(tmp_path: Path) -> None:
    """Whatever the damage: see `test_cache`."""
    compiles(tmp_path)
    (code,) = (tmp_path / "cache").rglob("*.o")
    content = code.read_bytes()
    code.write_bytes(content[: len(content) // 3])
    assert compiles(tmp_path)
    assert code.read_bytes()[32:36] == content[32:36]
    assert not compiles(tmp_path)


def test_other_versions_are_other_code(monkeypatch: pytest.MonkeyPatch) -> None:
    from lienumba.compiler import cache

    monkeypatch.setattr(cache, "_versions", cache._versions.__wrapped__)  # as in processes of their own
    states = {cache.state()}
    for package in ("llvmlite", "numpy"):
        other = lambda name, changed=package: "0.0" if name == changed else "1.0"  # noqa: E731
        monkeypatch.setattr(cache, "version", other)
        states.add(cache.state())
    assert len(states) == 3


@pytest.mark.parametrize("driver", ["fixed_step", "variable_step"])
def test_drivers_call_nothing_of_the_c_library(driver: str) -> None:
    """There would be no room for it where they are loaded, and a loop of stores looks like a memset to LLVM."""
    from lienumba.compiler.flat import object_code

    code = object_code(import_module(f"lienumba.integrators.drivers.{driver}").drive)
    assert not any(name in code for name in (b"memset", b"memcpy", b"memmove", b"bcmp"))
