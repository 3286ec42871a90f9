"""What many tests share."""

import functools
import gc
import os
import sys
from collections.abc import Iterator

import hypothesis
import pytest
from typer import testing

pytest_plugins = ["tests.suites"]

# Else every process, of which tests start hundreds, would compile all sources anew.
sys.dont_write_bytecode = False
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)

# On a machine that does other work, too, examples take as long as they take.
hypothesis.settings.register_profile("patient", deadline=None)
hypothesis.settings.load_profile("patient")

# Tests of machine code, or of many steps. All others are about values, which do not depend on optimisation: they
# compile scalar code without it, which is faster.
CODE = ("tests/compiler/", "tests/process/test_", "tests/documents/test_accuracy.py", "tests/oracles/paper/")


def pytest_collection_finish() -> None:
    """Garbage is not looked for among thousands of tests and modules, which stay."""
    gc.collect()
    gc.freeze()


@pytest.fixture
def anew(monkeypatch: pytest.MonkeyPatch) -> None:
    """Asked for by tests in which every program is made anew, though the process has made it before."""
    from lienumba.integrators.tracing.compiled import PROGRAMS

    PROGRAMS.clear()
    monkeypatch.setattr(PROGRAMS, "entries", 0)


@pytest.fixture(autouse=True, scope="session")
def traced() -> Iterator[None]:
    """In this process every program is traced: tests count what is traced, and change what tracing reads. And all is
    compiled in this process: the other cores have tests of their own."""
    from lienumba.compiler import native
    from lienumba.integrators.tracing import compiled

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(compiled, "find", lambda key: None)
        patch.setattr(compiled, "keep", lambda key, outline, code: None)
        patch.setattr(native, "LONG_TEXT", sys.maxsize)
        yield


@pytest.fixture(autouse=True, scope="session")
def commands() -> Iterator[None]:
    """Typer makes all commands anew of their signatures for each call, which takes longer than most of the calls."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(testing, "_get_command", functools.cache(testing._get_command))
        yield


@pytest.fixture(autouse=True, scope="module")
def level(request: pytest.FixtureRequest) -> Iterator[None]:
    """Most is compiled without optimisation and for one lane at a time, which changes no bit
    (tests/compiler/test_value_types.py)."""
    from lienumba.compiler import emit, flat, native
    from lienumba.compiler.value_types import DOUBLE

    with pytest.MonkeyPatch.context() as patch:
        if not request.node.nodeid.startswith(CODE):
            patch.setattr(native, "LEVEL", 0)
            patch.setattr(flat, "PASSES", 0)
            patch.setattr(emit, "VALUES", DOUBLE)
        yield


@pytest.fixture
def vectors(monkeypatch: pytest.MonkeyPatch) -> None:
    """Asked for by tests of many steps, which kernels of vectors make in less than half the time."""
    from lienumba.compiler import emit
    from lienumba.compiler.value_types import VECTOR

    monkeypatch.setattr(emit, "VALUES", VECTOR)
