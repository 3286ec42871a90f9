"""What many tests share."""

from collections.abc import Iterator

import pytest

pytest_plugins = ["tests.quick"]


@pytest.fixture
def anew(monkeypatch: pytest.MonkeyPatch) -> None:
    """Asked for by tests in which every program is made anew, though the process has made it before."""
    from lienumba.integrators.tracing.compiled import PROGRAMS

    PROGRAMS.clear()
    monkeypatch.setattr(PROGRAMS, "entries", 0)


@pytest.fixture(autouse=True, scope="session")
def traced() -> Iterator[None]:
    """In this process every program is traced: tests count what is traced, and change what tracing reads."""
    from lienumba.integrators.tracing import stored

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(stored, "find", lambda key: None)
        patch.setattr(stored, "keep", lambda key, outline, code: None)
        yield
