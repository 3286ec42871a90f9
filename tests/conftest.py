"""Tests that take the same mechanism through several runs trace and compile it once.

A program is a function of a model, a method, the choice of rows and a few limits, so that these tell whether it is
another one. Where tests look at how programs are made, or say that making one twice gives the same, each is made anew.
"""

import io
import pickle
from collections import OrderedDict
from collections.abc import Iterator
from types import FunctionType
from typing import Any

import pytest

from lienumba.compiler import emit, segments
from lienumba.integrators.tracing import program, step_kernels
from lienumba.integrators.tracing.row_selection import UNIQUE

KEPT = 8
BUILD = program.build
programs: "OrderedDict[bytes, Any]" = OrderedDict()


class Content(pickle.Pickler):
    """What numbers and expressions say; a function of a user's own cannot be told from another of its name."""

    def reducer_override(self, thing: Any) -> Any:
        if isinstance(thing, FunctionType) and thing.__module__.split(".")[0] not in ("lienumba", "numpy"):
            raise pickle.PicklingError(thing.__name__)
        return NotImplemented


def content(*things: Any) -> bytes | None:
    written = io.BytesIO()
    try:
        Content(written).dump(things)
    except (pickle.PicklingError, AttributeError, TypeError):
        return None
    return written.getvalue()


def build(model: Any, method: Any, choice: Any = UNIQUE, fixed: bool = True) -> Any:
    limits = step_kernels.INLINE, emit.LONG, segments.SIZE, segments.SHORTEST, segments.LONGEST, segments.MEAN
    key = content(model, method, choice, fixed, limits)
    if key is None:
        return BUILD(model, method, choice, fixed)
    if key not in programs:
        programs[key] = BUILD(model, method, choice, fixed)
    programs.move_to_end(key)
    if len(programs) > KEPT:
        programs.popitem(last=False)
    return programs[key]


@pytest.fixture
def anew() -> None:
    """Asked for by tests that make every program anew."""


@pytest.fixture(autouse=True)
def made_once(request: pytest.FixtureRequest) -> Iterator[None]:
    from lienumba.integrators.tracing import machine

    if "anew" in request.fixturenames:
        yield
        return
    compile_program = machine.compile_program

    def compiled(made: Any) -> Any:
        if not any(made is known for known in programs.values()):
            return compile_program(made)
        if not hasattr(made, "machine"):
            made.machine = compile_program(made)
        return made.machine

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(program, "build", build)
        patch.setattr(machine, "compile_program", compiled)
        yield
