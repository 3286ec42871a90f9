"""The language of routines: what is compiled does what Python does with the same source, and what is not of the
language is an error with its line."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import pytest

from lienumba.compiler.flat import compiled, object_code
from lienumba.compiler.routines.marks import Floats1, Floats2, Floats3, Integers1, apart, inlined
from lienumba.compiler.routines.values import RoutineError


class Pair(NamedTuple):
    count: int
    weight: float = 0.5


class Table(NamedTuple):
    rows: Floats3
    pair: Pair


THREE = 3
NAN = float("nan")


@inlined
def _scaled(pair: Pair, x: float) -> tuple[float, Pair]:
    return pair.weight * x, Pair(pair.count + 1, x)


@apart
def _first_above(row: np.ndarray, limit: float) -> int:
    for n in range(row.size):
        if row[n] > limit:
            return n
    return row.shape[0]


@apart
def _noted(calls: np.ndarray, place: int, answer: bool) -> bool:
    calls[place] += 1
    return answer


def arithmetic(x: Floats1, n: Integers1, out: Floats1, whole: Integers1) -> None:
    for i in range(n.size):
        whole[4 * i] = n[i] // 4 + n[i] % THREE
        whole[4 * i + 1] = n[i] // -THREE - n[i] % -8
        whole[4 * i + 2] = min(n[i], 2) * max(n[i], -2)
        whole[4 * i + 3] = int(x[i]) - -n[i]
        out[i] = -x[i] * n[i] + float(n[i]) / THREE - np.sqrt(abs_of(x[i])) + n[i] / 7
    out[0] += NAN


def abs_of(x: float) -> float:
    return x if x >= 0.0 else -x


def branches(x: Floats1, out: Floats1, calls: Integers1) -> None:
    for i in range(x.size):
        low, high = x[i] < 0.0, 1.0 <= x[i] < 2.0
        if low:
            out[i] = 1.0
        elif high or x[i] != x[i]:
            out[i] = 2.0
        else:
            out[i] = 3.0
        if (not low and _noted(calls, 0, high)) or _noted(calls, 1, x[i] > 2.5):
            out[i] += 10.0
        out[i] += 100.0 if low or high_of(x[i]) else 200.0


def high_of(x: float) -> bool:
    return x >= 1.0


def loops(x: Floats2, out: Integers1, start: int) -> None:
    n = turns = 0
    while True:
        n += 1
        if n % 2 == 0:
            continue
        for k in range(start, n):
            if k == 5:
                break
            turns += 1
        if n > 8:
            break
    while turns > 20:
        turns -= 7
    out[0], out[1] = n, turns
    for i in range(x.shape[0]):
        out[2 + i] = _first_above(x[i], 0.5)
    for _ in range(3, 2):
        out[0] = -1


def parts(table: Table, out: Floats3) -> None:
    rows, pair = table.rows, table.pair
    out[0] = rows[1][0, 2]
    a = out[1:3]
    for i in range(2):
        a[i, 1, 0] = rows[i, 1, i]
        x, pair = _scaled(pair, rows[i, 0, 0])
        a[i, 0, 0] = x + pair.count
    a[1][0][1:] = 7
    a[0, 0, 1] = a[0, 0, 2] = Pair(2).weight
    out[3, 0, 0] = rows[:1].size + rows[1:].shape[0]


def arguments(name: str) -> list[Any]:
    random = np.random.default_rng(3)
    x = np.array([-2.5, -0.0, 0.0, 1.0, 1.5, 2.0, 2.75, np.inf])
    if name == "arithmetic":
        return [np.where(np.isinf(x), 9.5, x), np.arange(-9, 15, 3), np.zeros(8), np.zeros(32, np.int64)]
    if name == "branches":
        return [np.append(x, np.nan), np.zeros(9), np.zeros(2, np.int64)]
    if name == "loops":
        return [random.uniform(size=(4, 5)) * np.array([[1.0], [0.2], [1.0], [0.6]]), np.zeros(6, np.int64), 2]
    return [Table(random.uniform(size=(2, 3, 4)), Pair(4, 0.25)), np.zeros((4, 3, 4))]


@pytest.mark.parametrize("routine", [arithmetic, branches, loops, parts], ids=lambda f: f.__name__)
def test_compiled_routines_do_what_python_does(routine: Callable[..., None]) -> None:
    by_python, by_machine = arguments(routine.__name__), arguments(routine.__name__)
    routine(*by_python)
    compiled(routine)(*by_machine)  # type: ignore[arg-type]
    for a, b in zip(by_python, by_machine, strict=True):
        for one, other in zip(*(y if isinstance(y, Table) else (y,) for y in (a, b)), strict=True):
            np.testing.assert_array_equal(one, other)
            assert np.signbit(one).tolist() == np.signbit(other).tolist() if isinstance(one, np.ndarray) else True


# ---------------------------------------------------------------- what is not of the language
def other_kind(n: int, out: Floats1) -> None:
    x = 1.0
    x = n
    out[0] = x


def power(n: int) -> None:
    n**2


def text(out: Floats1) -> None:
    out[0] = "a"


def by_name(x: Floats1) -> None:
    high_of(x=x[0])


def from_the_end(x: Floats1) -> None:
    x[-1] = 0.0


def too_deep(x: Floats1) -> None:
    x[0, 0] = 0.0


def over_a_list(n: int) -> None:
    for _ in [1, 2]:
        n += 1


def stepped(x: Floats1) -> None:
    x[::2] = 0.0


def caught(n: int) -> None:
    try:
        n += 1
    finally:
        n += 2


def number_as_truth(n: int) -> None:
    if n:
        n += 1


def of_two_kinds(x: Floats1) -> None:
    x[0] = _of_two_kinds(x[0])


def _of_two_kinds(x: float) -> float:
    if x > 0.0:
        return 1
    return x


def nowhere(out: Floats1) -> None:
    out[0] = nothing_of_the_kind  # noqa: F821


def unknown_function(x: Floats1) -> None:
    x[0] = sum(x)


def without_field(x: Floats1) -> None:
    x[0] = Pair(1).length


WRONG = {
    other_kind: "x is a float, and cannot become a whole number",
    power: "there is no Pow of a whole number and a whole number",
    text: "'a' is no number",
    by_name: "routines take no arguments by name",
    from_the_end: "indices of routines count from the front",
    too_deep: "an array of 1 dimensions has no 2",
    over_a_list: "loops go over a range, and have no else",
    stepped: "a slice is the only index, and has no step",
    caught: "routines know no Try",
    number_as_truth: "a whole number stands where there should be a bool",
    of_two_kinds: "_of_two_kinds returns a whole number and a float",
    nowhere: "nothing_of_the_kind has no value here",
    unknown_function: "<built-in function sum> cannot be called",
    without_field: "a Pair has no length",
}


@pytest.mark.parametrize("routine", WRONG, ids=lambda f: f.__name__)
def test_what_is_not_of_the_language_is_told_with_its_line(routine: Callable[..., None]) -> None:
    with pytest.raises(RoutineError) as told:
        object_code(routine)  # type: ignore[arg-type]
    where, _, what = str(told.value).partition(": ")
    file, line = where.split(", line ")
    assert (file, what) == (__file__, WRONG[routine])
    assert 1 <= int(line) - routine.__code__.co_firstlineno < 9


def test_a_function_without_source_is_told_by_name() -> None:
    made: dict[str, Any] = {}
    exec("def without(n: int) -> None:\n    n = 1", made)
    with pytest.raises(RoutineError, match="<string> has no function without in line 1"):
        object_code(made["without"])


def test_an_argument_from_outside_has_a_kind() -> None:
    def loose(x: np.ndarray) -> None:
        x[0] = 1.0

    with pytest.raises(RoutineError, match=r"an argument from outside is not .*ndarray"):
        object_code(loose)  # type: ignore[arg-type]
