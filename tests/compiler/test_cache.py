"""The cache on disk: it survives processes, and serves neither what is stale nor what is torn."""

import errno
import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

import lienumba
from lienumba.compiler import cache, flat, native

PACKAGE = Path(lienumba.__file__).parent

COMPILE = """
import ctypes
import numpy as np
from lienumba.compiler import cache, native
from lienumba.compiler.emit import Kernel
from lienumba.compiler.rows import W
from lienumba.compiler.symbols import Graph

emitted = []
emit = native.emit
native.emit = lambda *arguments: emitted.append(1) or emit(*arguments)
graph = Graph()
x = graph.input("state", 0)
text = Kernel("main", (x * x + 0.5,), 0).text()
engine, addresses = native.load(native.compile_text(text), ["main"])
state, out = np.full(W, 3.0), np.zeros(W)
ctypes.CFUNCTYPE(None, *[ctypes.c_int64] * 6)(addresses["main"])(state.ctypes.data, 0, 0, 0, out.ctypes.data, 0)
assert (out == 9.5).all(), out
print(len(emitted), cache.folder())
"""


def python(script: str, folder: Path, **more: str) -> str:
    """What a new process prints."""
    settings = {"LIENUMBA_CACHE_DIR": str(folder), "PYTHONDONTWRITEBYTECODE": "1", **more}
    file = Path(more.get("SCRIPTS", folder.parent)) / "script.py"
    if not file.exists() or file.read_text() != script:
        file.write_text(script)
    command = [sys.executable, "-W", "error", str(file)]
    done = subprocess.run(command, env=os.environ | settings, capture_output=True, text=True, cwd=file.parent)
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


def compiled(folder: Path, **more: str) -> tuple[int, Path]:
    """How many modules a new process had to compile, and its cache folder."""
    count, path = python(COMPILE, folder, **more).split(maxsplit=1)
    return int(count), Path(path)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return tmp_path / "cache"


@pytest.fixture
def here(folder: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The cache of this process, in a folder of the test's own."""
    monkeypatch.setenv("LIENUMBA_CACHE_DIR", str(folder))
    for known in (cache.folder, cache._state):
        known.cache_clear()
    yield folder
    for known in (cache.folder, cache._state):
        known.cache_clear()


# ---------------------------------------------------------------- processes
def test_the_second_process_compiles_nothing(folder):
    assert compiled(folder)[0] == 1
    again, path = compiled(folder, PYTHONHASHSEED="12345")
    assert again == 0
    assert path.parent == folder


def test_another_cpu_is_another_entry(here, monkeypatch):
    """Of kernels and of drivers."""
    emitted, cpus, drivers = [], [("skylake", "+avx2"), ("skylake", "-avx2"), ("generic", "")], set()
    monkeypatch.setattr(native, "emit", lambda text, *cpu: emitted.append(cpu) or " ".join(cpu).encode())
    monkeypatch.setattr(native, "cpu", native.cpu.__wrapped__)
    for cpu in (*cpus, *cpus):
        monkeypatch.setattr(native, "_wanted", lambda cpu=cpu: cpu)
        assert native.compile_text("text") == " ".join(cpu).encode()
        drivers.add(flat.key_of("driver"))
    assert emitted == cpus
    assert len(drivers) == 3


def test_an_empty_or_relative_xdg_cache_home_is_none(monkeypatch):
    """As its specification says; else the cache would lie in the working directory."""
    monkeypatch.delenv("LIENUMBA_CACHE_DIR", raising=False)
    for value in ("", "relative"):
        monkeypatch.setenv("XDG_CACHE_HOME", value)
        assert cache.root().is_absolute()


# ---------------------------------------------------------------- an edited package
def test_an_edit_of_any_source_file_leads_to_another_folder(tmp_path, folder):
    """Also in another module than the one that holds the kernel: numba's own cache is blind to that."""
    copy = tmp_path / "copy"
    shutil.copytree(PACKAGE, copy / "lienumba", ignore=shutil.ignore_patterns("__pycache__"))
    more = {"PYTHONPATH": str(copy), "SCRIPTS": str(copy)}
    assert compiled(folder, **more)[0] == 1
    count, before = compiled(folder, **more)
    assert count == 0
    edited = copy / "lienumba" / "groups" / "so3.py"
    edited.write_text(edited.read_text().replace("0.5", "0.50", 1))
    count, after = compiled(folder, **more)
    assert count == 1
    assert after != before
    (copy / "lienumba" / "integrators" / "drivers" / "another.py").write_text("")
    assert compiled(folder, **more)[1] not in (before, after)


SEEN = (
    "integrators/drivers/stages.py",
    "compiler/routines/statements.py",
    "integrators/layout.py",
    "integrators/codes.py",
)
UNSEEN = (
    "mechanics/system/kkt.py", "integrators/tracing/tracer.py", "integrators/methods/tableau.py", "compiler/emit.py",
)  # fmt: skip


@pytest.mark.parametrize("edited", [*SEEN, *UNSEEN])
def test_only_what_drivers_see_compiles_them_again(tmp_path, monkeypatch, edited):
    monkeypatch.setenv("LIENUMBA_CACHE_DIR", str(tmp_path / "cache"))
    monkeypatch.setattr(cache, "PACKAGE", tmp_path / "lienumba")
    shutil.copytree(PACKAGE, tmp_path / "lienumba", ignore=shutil.ignore_patterns("__pycache__", "*.js"))
    before = cache.state()
    with open(tmp_path / "lienumba" / edited, "a") as file:
        file.write("\n")
    assert (cache.state() != before) == (edited in SEEN)


def test_a_copy_that_is_not_edited_shares_the_folder(tmp_path, folder):
    copy = tmp_path / "copy"
    shutil.copytree(PACKAGE, copy / "lienumba", ignore=shutil.ignore_patterns("__pycache__"))
    first = compiled(folder, PYTHONPATH=str(copy), SCRIPTS=str(copy))[1]
    other = tmp_path / "other"
    shutil.copytree(copy, other)
    assert compiled(folder, PYTHONPATH=str(other), SCRIPTS=str(other)) == (0, first)


# ---------------------------------------------------------------- whose it is
def test_a_new_folder_is_the_users_alone(here):
    old = os.umask(0o002)
    try:
        path = cache.folder()
    finally:
        os.umask(old)
    assert path.parent == here
    assert path.stat().st_mode & 0o777 == 0o700


@pytest.mark.skipif(not hasattr(os, "geteuid"), reason="needs owners")
@pytest.mark.parametrize("why", ["is a link", "belongs to another user", "may be written by others"])
def test_what_others_could_have_planted_is_not_loaded(here, why, monkeypatch):
    cache.keep("entry", b"planted")
    path = cache.folder()
    assert cache.recall("entry") == b"planted"
    if why == "is a link":
        path.rename(here / "elsewhere")
        path.symlink_to(here / "elsewhere")
    elif why == "belongs to another user":
        owner = os.geteuid()
        monkeypatch.setattr(os, "geteuid", lambda: owner + 1)
    else:
        path.chmod(0o770)
    cache.folder.cache_clear()
    with pytest.warns(UserWarning, match=f"the cache {path} {why}, so its machine code is not trusted .* delete that"):
        other = cache.folder()
    assert other != path
    assert other.stat().st_mode & 0o777 == 0o700
    assert cache.recall("entry") is None
    cache.keep("entry", b"own")
    assert cache.recall("entry") == b"own"


# ---------------------------------------------------------------- entries
def counted(value: bytes) -> tuple[Callable[[], bytes], list[int]]:
    calls: list[int] = []

    def make() -> bytes:
        calls.append(1)
        return value

    return make, calls


def test_an_entry_is_made_once(here):
    make, calls = counted(b"code")
    assert [cache.remember("key", make) for _ in range(3)] == [b"code"] * 3
    assert len(calls) == 1
    assert cache.remember("another key", make) == b"code"
    assert len(calls) == 2


@pytest.mark.parametrize(
    "damage",
    [
        lambda b: b"",
        lambda b: b[:10],
        lambda b: b[:32],
        lambda b: b[:-1],
        lambda b: b + b"\0",
        lambda b: bytes([b[0] ^ 1]) + b[1:],
        lambda b: b[:-1] + bytes([b[-1] ^ 128]),
        lambda b: b[:40] + bytes([b[40] ^ 1]) + b[41:],
        lambda b: b"\0" * len(b),
    ],
    ids=["empty", "head", "checksum only", "one short", "one more", "first bit", "last bit", "inner bit", "zeros"],
)
def test_a_damaged_entry_is_made_again(here, damage):
    make, calls = counted(bytes(range(256)))
    cache.remember("key", make)
    (entry,) = cache.folder().glob("*.o")
    entry.write_bytes(damage(entry.read_bytes()))
    assert cache.remember("key", make) == bytes(range(256))
    assert len(calls) == 2
    assert cache.remember("key", make) == bytes(range(256))
    assert len(calls) == 2  # and healed


def test_no_temporary_files_are_left(here):
    make, _ = counted(b"code")
    for key in "abc":
        cache.remember(key, make)
    assert [p.suffix for p in cache.folder().iterdir()] == [".o"] * 3


def test_of_two_that_make_an_entry_at_once_both_have_it(here):
    """While one makes it, another process has made and written it."""

    def slow() -> bytes:
        assert cache.remember("key", lambda: b"code") == b"code"
        return b"code"

    assert cache.remember("key", slow) == b"code"
    make, calls = counted(b"other")
    assert cache.remember("key", make) == b"code"
    assert not calls
    assert len(list(cache.folder().iterdir())) == 1


def test_two_processes_with_a_cold_cache_leave_it_whole(folder):
    with ThreadPoolExecutor(2) as threads:
        script = folder.parent / "script.py"
        script.write_text(COMPILE)
        both = [threads.submit(compiled, folder) for _ in range(2)]
    assert all(count.result()[0] <= 1 for count in both)
    again, path = compiled(folder)
    assert again == 0
    assert [file.suffix for file in path.iterdir()] == [".o"]


def test_what_was_edited_meanwhile_is_not_kept(here, monkeypatch):
    def edit() -> bytes:
        monkeypatch.setattr(cache, "state", lambda: "another")
        return b"code of neither"

    assert cache.remember("key", edit) == b"code of neither"
    assert not list(cache.folder().iterdir())


# ---------------------------------------------------------------- a folder that cannot be used
def test_without_a_writable_folder_it_still_works(tmp_path):
    """A file stands where the folder should be: nobody, not even root, can write there."""
    (tmp_path / "file").write_text("")
    count, path = compiled(tmp_path / "file" / "cache", SCRIPTS=str(tmp_path))
    assert count == 1
    assert tmp_path not in path.parents
    assert not path.exists()  # it went with its process


def test_a_folder_that_vanishes_costs_the_entry_only(here):
    make, calls = counted(b"code")
    cache.remember("key", make)
    shutil.rmtree(here)
    assert cache.remember("key", make) == b"code"
    assert len(calls) == 2


def test_a_full_disk_costs_the_entry_only(here, monkeypatch):
    def full(source: str, target: Path) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    make, calls = counted(b"code")
    monkeypatch.setattr(os, "replace", full)
    assert [cache.remember("key", make) for _ in range(2)] == [b"code"] * 2
    assert len(calls) == 2
    assert not list(cache.folder().iterdir())


def test_a_failure_to_compile_is_not_remembered(here):
    def fail() -> bytes:
        raise RuntimeError("no code")

    with pytest.raises(RuntimeError):
        cache.remember("key", fail)
    make, calls = counted(b"code")
    assert cache.remember("key", make) == b"code"
    assert calls
