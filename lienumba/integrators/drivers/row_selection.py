"""Which of the constraint rows that say the same are used: a set of independent ones, chosen anew where it gets weak.

Works on the Schur complement S of these rows (`kkt.schur_complement`), run by run: a Cholesky factorisation that takes
the strongest row first finds the rank and a well-conditioned set. Loops of numbers: Numba takes seconds to compile
expressions of arrays.
"""

import numpy as np

from lienumba.integrators.selection_table import table_masks, table_scales
from lienumba.numerics.operations import kernel

INDEPENDENT = 1e-10  # a pivot of the scaled S below this is a row that adds nothing
NEARLY = 0.5  # rows within this fraction of the strongest are equals: the first of them is taken
BETTER = 4.0  # another set of the same number replaces the present one if its weakest pivot is stronger by this
WEAKENED = 0.5  # a selection is looked at again when its margin falls below this fraction of the largest that it had


@kernel
def strongest(S: np.ndarray, left: np.ndarray, taken: np.ndarray) -> tuple[int, float]:
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


@kernel
def select_rows(table: np.ndarray, lane: int, q: int, room: np.ndarray) -> None:
    """Choose for one lane. table: rows of lanes: lower triangle of S, scale of each row, masks (updated);
    room (q + 2, q): to work in."""
    scales, masks = table_scales(q), table_masks(q)
    S, left, taken = room[:q], room[q], room[q + 1]
    count, weakest = 0, 1.0
    for attempt in range(2):  # with the present rows, with all
        n = 0
        for i in range(q):
            left[i], taken[i] = (table[masks + i, lane] if attempt == 0 else 1.0), 0.0
            for j in range(i + 1):
                S[i, j] = S[j, i] = table[n, lane] / np.sqrt(table[scales + i, lane] * table[scales + j, lane])
                n += 1
        found, pivot = strongest(S, left, taken)
        if attempt == 0:
            count, weakest = found, pivot
    if found > count or (found == count and pivot > BETTER * weakest):
        for i in range(q):
            table[masks + i, lane] = taken[i]
