"""Which of the constraint rows that say the same are used: a set of independent ones, chosen anew where it gets weak.

Works on the Schur complement S of these rows (`kkt.exchange`), run by run: a Cholesky factorisation that takes the
strongest row first finds the rank and a well-conditioned set.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numba import njit

from lienumba.mechanics.mechanism.kinematics import Instant
from lienumba.mechanics.mechanism.model import Model
from lienumba.mechanics.system import constraints, dynamics, kkt

INDEPENDENT = 1e-10  # a pivot of the scaled S below this is a row that adds nothing
NEARLY = 0.5  # rows within this fraction of the strongest are equals: the first of them is taken
BETTER = 4.0  # another set of the same number replaces the present one if its weakest pivot is stronger by this
WEAKENED = 0.5  # a choice is looked at again when its margin falls below this fraction of the largest that it had


@njit(nogil=True, error_model="numpy", no_cfunc_wrapper=True)
def _strongest(S: Any, left: Any, taken: Any) -> Any:
    """Mark the independent ones among the rows with left = 1 in `taken`; returns their number and the weakest pivot.
    S and `left` are used up."""
    q = left.size
    count, weakest = 0, 1.0
    while True:
        best = 0.0
        for i in range(q):
            if left[i] > 0.0 and S[i, i] > best:
                best = S[i, i]
        if not best > INDEPENDENT:
            return count, weakest
        chosen = 0
        while not (left[chosen] > 0.0 and S[chosen, chosen] >= NEARLY * best):
            chosen += 1
        left[chosen] = 0.0
        taken[chosen] = 1.0
        count += 1
        pivot = S[chosen, chosen]
        weakest = min(weakest, pivot)
        for i in range(q):
            if left[i] > 0.0:
                factor = S[i, chosen] / pivot
                for j in range(q):
                    S[i, j] -= factor * S[chosen, j]


@dataclass(frozen=True)
class Choice:
    """Of the exchangeable rows of C (indices) those in use, 1.0 or 0.0 for each, and the margin at the start, which may
    be a singular position."""

    rows: tuple[int, ...] = ()
    masks: tuple[float, ...] = ()
    margin: float = 0.0
    singular: bool = False

    @property
    def dropped(self) -> tuple[int, ...]:
        return tuple(row for row, used in zip(self.rows, self.masks, strict=True) if not used)


UNIQUE = Choice()  # no row says the same as others


def first_choice(model: Model, masked: tuple[int, ...], now: Instant) -> Choice:
    """With which rows all runs begin, from the nominal start `now` in floats."""
    if not masked:
        return UNIQUE
    structure = kkt.Structure.of(model, masked)
    C, M = constraints.jacobian(model, now), dynamics.mass_matrix(model)
    triangle, scales = kkt.exchange(structure, dynamics.shapes(model), C)
    S = np.zeros((len(scales), len(scales)))
    S[np.tril_indices(len(scales))] = triangle
    S = (S + np.tril(S, -1).T) / np.sqrt(np.outer(scales, scales))
    masks = np.zeros(len(scales))
    _strongest.py_func(S, np.ones(len(scales)), masks)
    mask = [1.0] * structure.rows
    for row, used in zip(masked, masks, strict=True):
        mask[row] = float(used)
    zero = [0.0] * structure.rows
    margin = float(kkt.solve(structure, M, C, [0.0] * (6 * structure.bodies), zero, mask).margin)
    return Choice(masked, tuple(masks.tolist()), margin)


@njit(nogil=True, error_model="numpy", no_cfunc_wrapper=True)
def choose_rows(table: Any, lane: int, q: int) -> None:
    """Choose for one lane. table: rows of lanes: lower triangle of S, scale of each row, masks (updated).

    Loops of numbers: Numba takes seconds to compile expressions of arrays.
    """
    scales, masks = q * (q + 1) // 2, q * (q + 1) // 2 + q
    S, left, taken = np.empty((q, q)), np.empty(q), np.empty(q)
    count, weakest = 0, 1.0
    for attempt in range(2):  # with the present rows, with all
        n = 0
        for i in range(q):
            left[i], taken[i] = (table[masks + i, lane] if attempt == 0 else 1.0), 0.0
            for j in range(i + 1):
                S[i, j] = S[j, i] = table[n, lane] / np.sqrt(table[scales + i, lane] * table[scales + j, lane])
                n += 1
        found, pivot = _strongest(S, left, taken)
        if attempt == 0:
            count, weakest = found, pivot
    if found > count or (found == count and pivot > BETTER * weakest):
        for i in range(q):
            table[masks + i, lane] = taken[i]
