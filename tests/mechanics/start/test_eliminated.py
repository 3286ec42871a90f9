"""Least changes by NumPy's pseudo-inverse."""

from typing import Any

import numpy as np
import pytest

from lienumba.mechanics.start.least_norm import Least


def problem(rng: np.random.Generator) -> tuple[Any, Any, int]:
    """C, W^-1 and the columns."""
    rows = int(rng.integers(1, 16))
    size, filled = rows + int(rng.integers(0, 16)), rng.uniform(0.1, 0.7)
    entries = [(int(i), int(c)) for i in rng.permutation(rows) for c in rng.permutation(size)]
    C = {place: float(rng.normal()) for place in entries if rng.uniform() < filled}
    if rng.uniform() < 0.3:  # a row that says the same
        C |= {(rows - 1, c): C.get((0, c), 0.0) for c in range(size)}
    inverse = {(c, c): 1.0 + abs(float(rng.normal())) for c in range(size)}
    for c in range(0, size - 1, 3):
        inverse[c, c + 1] = inverse[c + 1, c] = 0.1 * float(rng.normal()) / (1.0 + abs(float(rng.normal())))
    return C, inverse, size


@pytest.mark.parametrize("seed", range(10))
def test_the_change_is_the_least(seed: int) -> None:
    """x = W^-1/2 (C W^-1/2)^+ b, where the rows do not contradict each other."""
    rng = np.random.default_rng(seed)
    for _ in range(10):
        C, inverse, size = problem(rng)
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
