"""Least changes: by NumPy's pseudo-inverse; and by entries or by a matrix, to the bit and to the type."""

from typing import Any

import numpy as np
import pytest

from lienumba.mechanics.start import least_norm
from lienumba.mechanics.start.least_norm import Least


def problem(rng: np.random.Generator, runs: int, varied: float) -> tuple[Any, Any, list[Any], int]:
    """C, W^-1, b and the columns; runs: 0 for floats alone; varied: how many of the numbers are arrays."""

    def number() -> Any:
        return rng.normal(size=runs) if runs and rng.uniform() < varied else float(rng.normal())

    rows = int(rng.integers(1, 16))
    size, filled = rows + int(rng.integers(0, 16)), rng.uniform(0.1, 0.7)
    entries = [(int(i), int(c)) for i in rng.permutation(rows) for c in rng.permutation(size)]
    C = {place: number() for place in entries if rng.uniform() < filled}
    if rng.uniform() < 0.3:  # a row that says the same
        C |= {(rows - 1, c): C.get((0, c), 0.0) for c in range(size)}
    inverse = {(c, c): 1.0 + abs(number()) for c in range(size)}
    for c in range(0, size - 1, 3):
        inverse[c, c + 1] = inverse[c + 1, c] = 0.1 * number() / (1.0 + abs(number()))
    return C, inverse, [number() for _ in range(rows)], size


@pytest.mark.parametrize("seed", range(10))
def test_the_change_is_the_least(seed: int) -> None:
    """x = W^-1/2 (C W^-1/2)^+ b, where the rows do not contradict each other."""
    rng = np.random.default_rng(seed)
    for _ in range(10):
        C, inverse, _, size = problem(rng, 0, 0.0)
        rows = 1 + max(row for row, _ in C) if C else 1
        dense, W1 = np.zeros((rows, size)), np.zeros((size, size))
        for place, x in C.items():
            dense[place] = x
        for place, x in inverse.items():
            W1[place] = x
        b = dense @ rng.normal(size=size)
        root = np.linalg.cholesky(W1)
        expected = root @ np.linalg.pinv(dense @ root, rcond=1e-9) @ b
        found = np.array(Least(C, inverse, rows, size).change(b.tolist()), float)
        np.testing.assert_allclose(found, expected, atol=1e-6 * (1.0 + abs(expected).max()))


@pytest.mark.parametrize("runs", [0, 1, 3, least_norm.FEW])
def test_by_a_matrix_every_bit_is_that_by_entries(runs: int, monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(runs)
    matrices = []
    for varied in (1.0, 0.5, 0.05) * 40:
        C, inverse, b, size = problem(rng, runs, varied)
        solved = []
        for solver in (least_norm._Entries, None):
            with monkeypatch.context() as patch, np.errstate(all="ignore"):
                if solver is not None:
                    patch.setattr(least_norm, "eliminated", solver)
                least = Least(C, inverse, len(b), size, damping=0.0 if varied == 1.0 else 0.01)
                solved.append([*least.change(b), *least.change(b[::-1])])
        matrices.append(isinstance(least._solve, least_norm._Matrix))
        for x, y in zip(*solved, strict=True):
            assert type(x) is type(y)
            assert np.shape(x) == np.shape(y)
            assert np.asarray(x).tobytes() == np.asarray(y).tobytes()
    assert any(matrices)
