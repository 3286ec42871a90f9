"""What many tests share."""

import pytest

pytest_plugins = ["tests.quick"]


@pytest.fixture
def anew(monkeypatch: pytest.MonkeyPatch) -> None:
    """Asked for by tests in which every program is made anew, though the process has made it before."""
    from lienumba.integrators.tracing.compiled import PROGRAMS

    PROGRAMS.clear()
    monkeypatch.setattr(PROGRAMS, "entries", 0)
