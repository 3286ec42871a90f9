"""Text becomes the same machine code wherever it is compiled, and code with the same bits at every level."""

import subprocess
import sys
from typing import Any

import pytest

from lienumba.compiler import cache, emit, native
from lienumba.compiler.emit import Kernel
from lienumba.compiler.value_types import DOUBLE, VECTOR
from tests.compiler.evaluation import assert_same_bits, call
from tests.compiler.interpreter import RandomGraph, numbers

ROWS = {"state": 5, "parameters": 4, "clock": 2, "extra": 3}


def kernel(seed: int, size: int) -> Kernel:
    return Kernel("main", tuple(RandomGraph(seed).grow(size)[-20:]), ROWS["parameters"])


@pytest.fixture
def elsewhere(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Every text is long; grows by the exit code of each process that compiled one."""
    found: list[int] = []
    run = subprocess.run

    def counted(*arguments: Any, **options: Any) -> Any:
        done = run(*arguments, **options)
        found.append(done.returncode)
        return done

    monkeypatch.setattr(native, "LONG_TEXT", 0)
    monkeypatch.setattr(cache, "recall", lambda name: None)
    monkeypatch.setattr(cache, "keep", lambda name, content: None)
    monkeypatch.setattr(subprocess, "run", counted)
    return found


def test_long_texts_become_the_same_code_in_another_process(elsewhere: list[int]) -> None:
    text = kernel(3, 400).text()
    assert native.compile_text(text) == native.emit(text, *native.cpu())
    assert elsewhere == [0]


def test_where_no_process_can_be_started_it_is_compiled_here(
    elsewhere: list[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    text = kernel(4, 100).text()
    monkeypatch.setattr(sys, "executable", "/there/is/none")
    assert native.compile_text(text) == native.emit(text, *native.cpu())
    assert elsewhere == []


def test_what_fails_there_is_tried_here_and_what_is_killed_is_told(
    elsewhere: list[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    text = kernel(5, 100).text()
    monkeypatch.setattr(native, "CHILD", "raise SystemExit(3)")
    assert native.compile_text(text) == native.emit(text, *native.cpu())
    monkeypatch.setattr(native, "CHILD", "import os; os.kill(os.getpid(), 9)")
    with pytest.raises(RuntimeError, match="the compiling process was ended by signal 9"):
        native.compile_text(text)
    assert elsewhere == [3, -9]


@pytest.mark.parametrize("seed", range(4))
def test_levels_and_types_of_values_change_no_bit_and_share_no_entry(
    seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    made = kernel(seed, 400)
    given = {name: numbers(rows, 40 * seed + n) for n, (name, rows) in enumerate(ROWS.items())}
    found, entries = [], set()
    for level, values in ((native.LEVEL, VECTOR), (0, VECTOR), (3, VECTOR), (0, DOUBLE), (3, DOUBLE)):
        monkeypatch.setattr(native, "LEVEL", level)
        monkeypatch.setattr(emit, "VALUES", values)
        entries.add(native.entry(made.text()))
        found.append(call(made, **given))
    assert len(entries) == len(found)
    for other in found[1:]:
        assert_same_bits(other, found[0])
