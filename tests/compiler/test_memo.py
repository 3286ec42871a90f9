"""Things made once: what counts as the same, and what threads that ask at once are given."""

import threading
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field

import numpy as np
import pytest

from lienumba.compiler.memo import Memo, UnknownError, content


@dataclass(frozen=True)
class Point:
    x: object
    y: object = 0.0
    told: object = field(default=None, compare=False)


@dataclass(frozen=True)
class Other:
    x: object
    y: object = 0.0


DIFFERENT = [
    0, 0.0, -0.0, False, None, 1, 1.0, True, -1.0, "1", "0x1.0p+0", "", (), [], {}, (1.0,), [1.0], frozenset({1.0}),
    {"a": 1.0}, {"a": 1}, {"b": 1.0}, float("nan"), float("inf"), Point(0.0), Point(-0.0), Point(0), Point(False),
    Other(0.0), Point(Point(0.0)), (Point(0.0),), ("a", ("b",)), (("a",), "b"), 0.1, np.nextafter(0.1, 1.0).item(),
]  # fmt: skip


def test_what_differs_in_anything_has_another_key() -> None:
    keys = [content(thing) for thing in DIFFERENT]
    for n, key in enumerate(keys):
        assert [m for m, other in enumerate(keys) if other == key] == [n]
    assert len(set(keys)) == len(DIFFERENT)


def test_what_is_the_same_has_the_same_key() -> None:
    assert content(Point([1.0, "a"], told=3)) == content(Point([1.0, "a"], told=4))
    assert content(float("nan")) == content(float("nan"))


@pytest.mark.parametrize("thing", [lambda: 0, np.zeros(2), object(), np.float64(1.0), np.float32(1.0), Point])
def test_what_is_not_data_has_no_key(thing: object) -> None:
    with pytest.raises(UnknownError, match="is not data"):
        content((1.0, Point(thing)))


def test_the_least_recently_asked_for_is_forgotten() -> None:
    memo: Memo[object] = Memo(2)
    a, b = memo.get("a", object), memo.get("b", object)
    assert memo.get("a", object) is a
    memo.get("c", object)
    assert memo.get("a", object) is a
    assert memo.get("b", object) is not b
    memo.clear()
    assert len(memo) == 0


def test_without_entries_everything_is_made_anew() -> None:
    memo: Memo[object] = Memo(0)
    assert memo.get("a", object) is not memo.get("a", object)


def test_threads_that_ask_at_once_are_given_the_same_thing_made_once() -> None:
    memo: Memo[object] = Memo(4)
    made, ready, go = [], threading.Barrier(8), threading.Event()

    def make() -> object:
        made.append(threading.get_ident())
        go.wait(10)
        return object()

    def ask() -> object:
        ready.wait(10)
        return memo.get("a", make)

    with ThreadPoolExecutor(8) as pool:
        asked = [pool.submit(ask) for _ in range(8)]
        while not made:
            pass
        go.set()
        found = {future.result(10) for future in asked}
    assert len(found) == len(made) == 1


def test_nobody_waits_for_another_thing() -> None:
    memo: Memo[str] = Memo(4)
    begun, go = threading.Event(), threading.Event()

    def slow() -> str:
        begun.set()
        assert go.wait(10)
        return "slow"

    with ThreadPoolExecutor(1) as pool:
        waiting = pool.submit(memo.get, "a", slow)
        assert begun.wait(10)
        assert memo.get("b", lambda: "quick") == "quick"
        assert not waiting.done()
        go.set()
        assert waiting.result(10) == "slow"


def test_what_cannot_be_made_is_tried_again_also_by_those_who_wait() -> None:
    memo: Memo[str] = Memo(4)
    begun, go = threading.Event(), threading.Event()

    def fails() -> str:
        begun.set()
        assert go.wait(10)
        raise KeyboardInterrupt

    with ThreadPoolExecutor(2) as pool:
        first = pool.submit(memo.get, "a", fails)
        assert begun.wait(10)
        second = pool.submit(memo.get, "a", lambda: "made")
        go.set()
        with pytest.raises(KeyboardInterrupt):
            first.result(10)
        assert second.result(10) == "made"
    assert memo.get("a", lambda: "again") == "made"
