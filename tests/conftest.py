"""What many tests share."""

import gc
import os
import sys
from collections.abc import Iterator

import pytest

pytest_plugins = ["tests.quick"]

# Else every process, of which tests start hundreds, would compile all sources anew.
sys.dont_write_bytecode = False
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)

# Rooms whose tests are about what is computed, whatever the machine code looks like: it is made in half the time.
EQUATIONS = (
    *("tests/integrators/", "tests/laws/", "tests/mechanics/", "tests/scenario/"),
    *(f"tests/oracles/{room}/" for room in ("changing", "mechanisms", "minimal", "trees")),
)


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
    from lienumba.integrators.tracing import stored

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(stored, "find", lambda key: None)
        patch.setattr(stored, "keep", lambda key, outline, code: None)
        patch.setattr(native, "LONG_TEXT", sys.maxsize)
        yield


@pytest.fixture(autouse=True, scope="module")
def level(request: pytest.FixtureRequest) -> Iterator[None]:
    """Equations are compiled without optimisation, which changes no bit (tests/compiler/test_native.py)."""
    from lienumba.compiler import native

    with pytest.MonkeyPatch.context() as patch:
        if request.node.nodeid.startswith(EQUATIONS):
            patch.setattr(native, "LEVEL", 0)
        yield
