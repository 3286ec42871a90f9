"""Eliminations by loops against NumPy's solutions of the same systems, lane by lane."""

import ctypes
from collections.abc import Callable

import numpy as np
import pytest

from lienumba.compiler import emit, native
from lienumba.compiler.loops.elimination import Each, Elimination, Terms
from lienumba.compiler.rows import W
from lienumba.compiler.value_types import ValueType
from lienumba.integrators.tracing.machine import aligned

Functions = dict[str, Callable[..., None]]


def functions(system: Elimination, each: Each | None = None) -> Functions:
    names = ["clear", "eliminate", "solve", *(["add"] if each else [])]
    code = native.compile_text(emit.VALUES.declarations + system.text("some", each))
    engine, addresses = native.load(code, [f"some_{name}" for name in names])
    found: Functions = {}
    for name in names:
        function = ctypes.CFUNCTYPE(None, *[ctypes.c_int64] * (2 if name == "add" else 1))(addresses[f"some_{name}"])
        function.engine = engine  # type: ignore[attr-defined]
        found[name] = function
    return found


def pattern(size: int, generator: np.random.Generator) -> set[tuple[int, int]]:
    """Places of blocks, more in the rows than in the columns, and the diagonal."""
    given = generator.random((size, size)) < np.where(np.tri(size), 0.15, 0.3)
    return {(int(i), int(j)) for i, j in zip(*np.nonzero(given | np.eye(size, dtype=bool)), strict=True)}


@pytest.mark.parametrize(("side", "size"), [(1, 14), (2, 9), (3, 8), (5, 6)])
def test_the_solution_is_that_of_numpy(side: int, size: int) -> None:
    generator = np.random.default_rng(side)
    places = pattern(size, generator)
    system, n = Elimination.of(places, size, side), size * side
    memory, matrix = aligned(system.memory, W), np.zeros((W, n, n))
    run = functions(system)
    memory[:] = np.nan
    run["clear"](memory.ctypes.data)
    for row, column in places:
        block = generator.standard_normal((side, side, W)) + 8.0 * (row == column) * np.eye(side)[:, :, None]
        for i, j in np.ndindex(side, side):
            matrix[:, side * row + i, side * column + j] = memory[system.row(row, column, i, j)] = block[i, j]
    right = generator.standard_normal((2, n, W))
    run["eliminate"](memory.ctypes.data)
    for each in right:  # the matrix is kept
        memory[system.vector :] = each
        run["solve"](memory.ctypes.data)
        exact = np.linalg.solve(matrix, each.T[:, :, None])[:, :, 0].T
        np.testing.assert_allclose(memory[system.vector :], exact, rtol=0, atol=1e-13)


def test_bits_do_not_depend_on_the_lanes_of_a_value(monkeypatch: pytest.MonkeyPatch) -> None:
    generator, size, side = np.random.default_rng(7), 8, 3
    system = Elimination.of(pattern(size, generator), size, side)
    start, found = generator.standard_normal((system.memory, W)), []
    monkeypatch.setattr(native, "LEVEL", 1)
    for lanes in (1, 2, 4, W):
        monkeypatch.setattr(emit, "VALUES", ValueType(lanes))
        run, memory = functions(system), aligned(system.memory, W)
        memory[:] = start
        run["eliminate"](memory.ctypes.data)
        run["solve"](memory.ctypes.data)
        found.append(memory)
    assert np.isfinite(found[0]).all()
    for each in found[1:]:
        np.testing.assert_array_equal(each, found[0])


def test_blocks_that_stay_empty_take_no_memory() -> None:
    """An arrow fills nothing if its point leaves last, and everything if it leaves first."""
    size = 12
    last = {(i, j) for i in range(size) for j in range(size) if size - 1 in (i, j)}
    first = {(size - 1 - i, size - 1 - j) for i, j in last}
    assert Elimination.of(last, size, 2).vector == 4 * (3 * size - 2)
    assert Elimination.of(first, size, 2).vector == 4 * size**2
    assert Elimination.of(last, size, 2).products == 8 * (size - 1)


def test_rows_and_columns_fill_each_for_itself() -> None:
    upper = {(0, 1), (0, 2), (1, 2)}
    system = Elimination.of(upper, 3, 1)
    assert system.columns == ((1, 2), (2,), ())
    assert system.rows == ((), (), ())
    assert system.products == 0


def test_terms_are_taken_from_blocks() -> None:
    """B_ij - w_ij f^p x_i, of which a weight that is only rounding is none."""
    generator, side, size, rows = np.random.default_rng(2), 3, 4, 5
    weights = [generator.standard_normal((side, side)) for _ in range(3)]
    weights[1][0, 2] = 1e-17
    places = [[(0, 0), (1, 2)], [(1, 2), (3, 0)], [(2, 2)]]
    numbers = [[0, 3], [4, 1], [2]]
    every = [*zip(numbers, places, weights, strict=True)]
    terms = [Terms(n, p, w.tolist(), power) for power, (n, p, w) in enumerate(every)]
    system = Elimination.of([place for own in places for place in own], size, side)
    memory, each = aligned(system.memory, W), aligned(side * rows + 1, W)
    memory[:], each[:] = generator.standard_normal(memory.shape), generator.standard_normal(each.shape)
    given = memory.copy()
    run = functions(system, Each([], side, 0, rows, terms))
    run["add"](memory.ctypes.data, each.ctypes.data)
    for power, (n, p, w) in enumerate(every):
        for number, place in zip(n, p, strict=True):
            for i, j in np.ndindex(side, side):
                x = each[rows * i + number] * each[-1] ** power
                given[system.row(*place, i, j)] -= w[i, j] * x
    np.testing.assert_allclose(memory, given, rtol=0, atol=1e-14)
