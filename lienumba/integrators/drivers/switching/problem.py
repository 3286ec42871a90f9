"""A complementarity problem of a few switched rows of one run, and systems of as many equations; see `complementarity`
for its laws."""

from typing import NamedTuple

import numpy as np

from lienumba.compiler.routines.marks import Floats1, Floats2, Integers2, apart, inlined

FREE, HOLDS, BOUNDED, PRESSES, SLIDES = range(5)  # laws; the last two have normals
SOLVED, UNSOLVED, PARADOX = range(3)
UNKNOWNS = 4  # of the problem with polygons per row, at most: a contact has 3 rows and 10 of them
ROUNDING = 1e-12  # of `Problem.least`: a force that is none
DEPENDENT = 1e-12  # of a row's own size: a pivot below this is none


class Problem(NamedTuple):
    """S (q, q), free (q,); switches (s, 8): see `layout`; law, friction (mu), bound (s,); direction (q,): d in the rows
    of tangents; x (q,): the impulses, where to begin, 0 without a law, and then the answer; rates (q,): r of them;
    step, best, given, diagonal, anchor (q,), matrix (q, q + 1): to work in. least (s,): what `ROUNDING` is a part of,
    where all that is asked for nearly cancels. tableau (4 q, 4 q + 2), unknowns (4 q, 7), labels (2, 4 q + 1): see
    `pivoting`."""

    S: Floats2
    free: Floats1
    switches: Integers2
    law: Floats1
    friction: Floats1
    bound: Floats1
    direction: Floats1
    x: Floats1
    rates: Floats1
    step: Floats1
    best: Floats1
    given: Floats1
    diagonal: Floats1
    anchor: Floats1
    matrix: Floats2
    least: Floats1
    tableau: Floats2
    unknowns: Floats2
    labels: Floats2


@inlined
def size(x: float) -> float:
    """|x|."""
    return max(x, -x)


@apart
def update_rates(p: Problem) -> None:
    """r = S x + free."""
    for i in range(p.free.size):
        total = p.free[i]
        for j in range(p.free.size):
            total += p.S[i, j] * p.x[j]
        p.rates[i] = total


@apart
def eliminate(matrix: np.ndarray, n: int, x: np.ndarray) -> None:
    """Solve a system of n rows, the right-hand side in column n, by complete pivoting; what nothing says is 0.
    The matrix is used up."""
    scale = 0.0
    for i in range(n):
        x[i] = 0.0
        for j in range(n):
            scale = max(scale, size(matrix[i, j]))
    done = 0
    while done < n:  # rows from `done` on are free; a column that was taken is 0 in them
        row, column, best = done, 0, DEPENDENT * scale
        for i in range(done, n):
            for j in range(n):
                if size(matrix[i, j]) > best:
                    row, column, best = i, j, size(matrix[i, j])
        if best == DEPENDENT * scale:
            break
        for j in range(n + 1):
            swapped = matrix[row, j]
            matrix[row, j] = matrix[done, j]
            matrix[done, j] = swapped
        for i in range(n):
            if i != done:
                factor = matrix[i, column] / matrix[done, column]
                for j in range(n + 1):
                    matrix[i, j] -= factor * matrix[done, j]
                matrix[i, column] = 0.0
        x[column] = float(done + 1)  # for now, the row that gives it
        done += 1
    for j in range(n):
        taken = int(x[j]) - 1
        if taken >= 0:
            x[j] = matrix[taken, n] / matrix[taken, j]
