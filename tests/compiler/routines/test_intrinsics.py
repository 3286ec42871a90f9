"""Lanes in routines: every lane computes what a float would, and nothing of its neighbours."""

import platform
import re
from collections.abc import Callable

import numpy as np
import pytest

from lienumba.compiler import native
from lienumba.compiler.flat import PASSES, compiled
from lienumba.compiler.lanes import all_lanes, any_lane, choose, fma, load, matrix, splat, store
from lienumba.compiler.routines.marks import Floats2, Integers1
from lienumba.compiler.rows import W
from lienumba.numerics import operations
from tests.compiler.evaluation import assert_same_bits
from tests.compiler.interpreter import fma as exact_fma
from tests.compiler.interpreter import numbers

ROWS = 26


def every_operation(given: Floats2, out: Floats2) -> None:
    """All that lanes can do, to rows of `out`."""
    to, n = out.ctypes.data, 3
    x, y = load(given.ctypes.data, 0), load(given.ctypes.data, 1)
    store(to, 0, x + y)
    store(to, 1, x - y)
    store(to, 2, x * y)
    store(to, 3, x / y)
    store(to, 4, 2.0 * x)
    store(to, 5, x - 1)
    store(to, 6, 1 / y)
    store(to, 7, -x)
    store(to, 8, x * y + x)
    store(to, 9, fma(x, y, x))
    store(to, 10, fma(x, n, 1.0))
    store(to, 11, operations.sqrt(x))
    store(to, 12, choose(x < y, x, y))
    store(to, 13, choose(x <= y, x, 7))
    store(to, 14, choose(x > y, x, y))
    store(to, 15, choose(x >= y, x, y))
    store(to, 16, choose(x == y, 1.0, 0.0))
    store(to, 17, choose(x != y, 1.0, 0.0))
    store(to, 18, choose((x < y) & (y > 1.0), 1.0, 0.0))
    store(to, 19, choose((x < y) | (y > 1), 1.0, 0.0))
    store(to, 20, operations.minimum(x, y))
    store(to, 21, operations.maximum(x, y))
    store(to, 22, operations.absolute(x))
    total = splat(0)
    for _ in range(n):
        total = (total + x) * 0.5
    store(to, 23, total)
    store(to, 24, splat(float(n)))
    for lane in range(W):
        matrix(to, 26, W)[25, lane] = given[1, lane]


def expected(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    with np.errstate(all="ignore"):
        rows = [x + y, x - y, x * y, x / y, 2.0 * x, x - 1, 1 / y, -x, x * y + x]
        rows += [np.array(list(map(exact_fma, x, y, x))), np.array([exact_fma(a, 3.0, 1.0) for a in x]), np.sqrt(x)]
        rows += [np.where(x < y, x, y), np.where(x <= y, x, 7), np.where(x > y, x, y), np.where(x >= y, x, y), x == y]
        rows += [x != y, (x < y) & (y > 1), (x < y) | (y > 1), np.where(x < y, x, y), np.where(x > y, x, y)]
        rows += [np.where(x < 0, -x, x), ((((0.0 + x) * 0.5) + x) * 0.5 + x) * 0.5, np.full_like(x, 3.0), y]
    return np.array(rows, float)


def test_lanes_are_floats_side_by_side() -> None:
    """Ordinary numbers and every pair of special ones; rows of memory need no alignment."""
    special = np.array([0.0, -0.0, 1.0, -1.0, 5e-324, 1e308, np.inf, -np.inf, np.nan, 1.5])
    x, y = np.meshgrid(special, special)
    given = np.concatenate([*(numbers(2, seed) for seed in range(9)), np.array([x.ravel(), y.ravel()])], axis=1)
    given = np.concatenate([given, np.ones((2, -given.shape[1] % W))], axis=1)
    run = compiled(every_operation)  # type: ignore[arg-type]
    for first in range(0, given.shape[1], W):
        memory = np.full(ROWS * W + 1, 0.25)
        out = memory[1:].reshape(ROWS, W)
        run(np.ascontiguousarray(given[:, first : first + W]), out)
        assert_same_bits(out, expected(*given[:, first : first + W]))
        assert memory[0] == 0.25


def test_some_and_all() -> None:
    def count(x: Floats2, out: Integers1) -> None:
        below = load(x.ctypes.data, 0) < 1.5
        out[0] = 1 if any_lane(below) else 0
        out[1] = 1 if all_lanes(below) else 0

    run, out = _of(count), np.zeros(2, np.int64)
    for held in range(W + 1):
        x = np.where(np.arange(W) < held, 1.0, np.nan)[None]
        run(np.ascontiguousarray(np.roll(x, 3)), out)
        assert out.tolist() == [held > 0, held == W]


def _of(function: Callable[..., None]) -> Callable[..., None]:
    return compiled(function)  # type: ignore[arg-type]


def some_lanes(given: Floats2, out: Floats2) -> None:
    """Rows of `out` in the lanes in which others are above 0."""
    for row in range(3):
        held, other = load(out.ctypes.data, row), load(given.ctypes.data, row)
        store(out.ctypes.data, row, choose(other > 0.0, other, held))


@pytest.mark.skipif(platform.machine() not in ("x86_64", "AMD64"), reason="machine code of x86-64")
def test_some_lanes_are_stored_as_whole_rows() -> None:
    """Stores by a mask (vmaskmovpd: VEX.0F38 2F) take many times as long, and what is read back waits for them."""
    from lienumba.compiler.routines.program import text_of

    code = native.emit(text_of(some_lanes)[1], "haswell", "+avx2,+fma", passes=PASSES)
    assert not re.search(rb"\xc4[\x42\x62\xc2\xe2].\x2f", code, re.DOTALL)
    out = np.zeros((3, W))
    given = numbers(3, 5)[:, :W].copy()
    compiled(some_lanes)(given, out)
    np.testing.assert_array_equal(out, np.where(given > 0.0, given, 0.0))
