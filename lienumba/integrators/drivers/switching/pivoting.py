"""Lemke's pivoting method for the contact problem with polygons in the place of the friction disks.

Then it is a linear complementarity problem w = M z + c, w >= 0, z >= 0, w z = 0 (Stewart and Trinkle 1996, Anitescu and
Potra 1997). Its unknowns z are normal forces, forces towards the corners of each polygon, and the speed of slipping.
Lemke's method walks from vertex to vertex of w >= 0, z >= 0 until it ends in a solution, or in a ray: then there may be
none. It finds which contacts open, stick and slip, also where friction couples them so strongly that iterations
diverge. Newton's method for the disks starts from there.
"""

import numpy as np

from lienumba.compiler.routines.marks import apart, inlined
from lienumba.integrators.drivers.switching.problem import BOUNDED, FREE, HOLDS, PRESSES, SLIDES, Problem, size
from lienumba.integrators.layout import SWITCH_FIRST, SWITCH_ROWS, SWITCH_TANGENTS

CORNERS, HALF = 8, 0.7071067811865476  # of a polygon; cosine and sine of the angle between two of them
PERTURBATION = 1e-6  # of the largest |c|: c grows by as much, or twice, so that no two vertices are the same
REGULARISATION = 1e-6  # of the diagonal of M, which is 1: redundant forces are then unique
PIVOT_TOL = 1e-9  # of the diagonal: smaller entries are roundoff
MAX_PIVOTS = 20  # per unknown
SIDE, CORNER, SLIP = range(3)  # unknowns: a force with its own rate, one within a polygon, a speed of slipping
FIRST, KIND, LINK, LIMIT = range(3, 7)  # columns of `unknowns`, behind the forces of a unit in three rows


@inlined
def _root(p: Problem, row: int, tangents: int) -> float:
    """The square root of the diagonal of S, of a contact's tangents the mean: 1 over the unit of a force."""
    if tangents == 2:
        return np.sqrt(0.5 * (p.S[row, row] + p.S[row + 1, row + 1]))
    return np.sqrt(max(p.S[row, row], 0.0))


@inlined
def _add(p: Problem, n: int, row: int, kind: int, link: int, limit: float) -> int:
    """The next unknown, as yet without a force; returns how many there are."""
    for i in range(FIRST):
        p.unknowns[n, i] = 0.0
    p.unknowns[n, FIRST], p.unknowns[n, KIND] = float(row), float(kind)
    p.unknowns[n, LINK], p.unknowns[n, LIMIT] = float(link), limit
    return n + 1


@apart
def _list_unknowns(p: Problem, turn: float) -> int:
    """Fill `unknowns`; returns how many there are."""
    n = 0
    for s in range(p.law.size):
        first, tangents, law = p.switches[s, SWITCH_FIRST], p.switches[s, SWITCH_TANGENTS], p.law[s]
        if law == FREE:
            continue
        for row in range(first, first + p.switches[s, SWITCH_ROWS] if law == HOLDS else first):
            root = _root(p, row, 0)
            for side in range(2 if root > 0.0 else 0):
                n = _add(p, n, row, SIDE, -1, 0.0)
                p.unknowns[n - 1, 0] = (1.0 - 2.0 * float(side)) / root
        root = _root(p, first, 0)
        if law >= PRESSES and root > 0.0:
            n = _add(p, n, first, SIDE, -1, 0.0)
            p.unknowns[n - 1, 0] = 1.0 / root
            for i in range(1, 1 + tangents if law == SLIDES else 1):
                p.unknowns[n - 1, i] = -p.friction[s] * p.direction[first + i] / root
        if law == BOUNDED:
            n = _list_corners(p, n, first, 1, -1, p.bound[s], turn)
        if law == PRESSES and root > 0.0 and tangents > 0 and p.friction[s] > 0.0:
            n = _list_corners(p, n, first + 1, tangents, n - 1, p.friction[s] / root, turn)
    return n


@apart
def _list_corners(p: Problem, n: int, row: int, tangents: int, normal: int, limit: float, turn: float) -> int:
    """Forces to the corners of a polygon, one of which is next to the axis of the tangents in which S is largest, or to
    both sides, and the speed of slipping; limit: of the force, of a normal its multiple."""
    root, c, s = _root(p, row, tangents), 1.0, 0.0
    if not root > 0.0:
        return n
    if tangents == 2:
        x, y = p.S[row, row] - p.S[row + 1, row + 1], 2.0 * p.S[row + 1, row]
        length = np.sqrt(x * x + y * y)
        if length > 0.0:
            c, s = np.sqrt(0.5 * max(1.0 + x / length, 0.0)), np.sqrt(0.5 * max(1.0 - x / length, 0.0))
            s = s if y > 0.0 else -s
        along = np.sqrt(1.0 - turn * turn)
        c, s = along * c - turn * s, along * s + turn * c
    corners = CORNERS if tangents == 2 else 2
    slip = n + corners
    for _ in range(corners):
        n = _add(p, n, row, CORNER, slip, 0.0)
        p.unknowns[n - 1, 0], p.unknowns[n - 1, 1] = c / root, s / root
        c, s = (HALF * (c - s), HALF * (c + s)) if tangents == 2 else (-c, 0.0)
    return _add(p, n, row, SLIP, normal, limit * root)


@inlined
def _entry(p: Problem, k: int, j: int) -> float:
    """Of the matrix M."""
    of, by, total = int(p.unknowns[k, KIND]), int(p.unknowns[j, KIND]), 0.0
    if of == SLIP and by == SLIP:
        return 0.0
    if by == SLIP:
        return 1.0 if of == CORNER and int(p.unknowns[k, LINK]) == j else 0.0
    if of == SLIP:
        if int(p.unknowns[k, LINK]) == j:
            return p.unknowns[k, LIMIT]
        return -1.0 if by == CORNER and int(p.unknowns[j, LINK]) == k else 0.0
    row, column = int(p.unknowns[k, FIRST]), int(p.unknowns[j, FIRST])
    for a in range(2 if of == CORNER else 1):
        for b in range(FIRST):
            if p.unknowns[k, a] != 0.0 and p.unknowns[j, b] != 0.0:
                total += p.unknowns[k, a] * p.S[row + a, column + b] * p.unknowns[j, b]
    return total + (REGULARISATION if k == j else 0.0)


@apart
def _fill(p: Problem, n: int) -> None:
    """The tableau: M, a column of 1, c; its rows are w, its columns z."""
    for k in range(n):
        for j in range(n):
            p.tableau[k, j] = _entry(p, k, j)
        p.tableau[k, n], total = 1.0, 0.0
        row = int(p.unknowns[k, FIRST])
        if int(p.unknowns[k, KIND]) == SLIP:
            total = p.unknowns[k, LIMIT] if p.unknowns[k, LINK] < 0.0 else 0.0
        else:
            for a in range(2 if int(p.unknowns[k, KIND]) == CORNER else 1):
                if p.unknowns[k, a] != 0.0:
                    total += p.unknowns[k, a] * p.free[row + a]
        p.tableau[k, n + 1] = total
        p.labels[0, k], p.labels[1, k] = float(k), float(n + k)
    p.labels[1, n] = float(2 * n)
    largest = 0.0
    for k in range(n):
        largest = max(largest, size(p.tableau[k, n + 1]))
    for k in range(n):
        p.tableau[k, n + 1] += PERTURBATION * largest * (1.0 + float(k) / float(n))


@apart
def _pivot(p: Problem, n: int, row: int, column: int) -> None:
    """Let the unknowns of a row and of a column change places."""
    inverse = 1.0 / p.tableau[row, column]
    for j in range(n + 2):
        p.tableau[row, j] *= -inverse
    p.tableau[row, column] = inverse
    for i in range(n):
        factor = p.tableau[i, column]
        if i != row and factor != 0.0:
            p.tableau[i, column] = 0.0
            for j in range(n + 2):
                p.tableau[i, j] += factor * p.tableau[row, j]
    label = p.labels[0, row]
    p.labels[0, row], p.labels[1, column] = p.labels[1, column], label


@apart
def _leaving(p: Problem, n: int, column: int) -> int:
    """The row whose unknown reaches 0 first as that of the column grows; -1 for a ray. Of several the artificial one,
    else that with the largest pivot."""
    row, least, pivot = -1, np.inf, 0.0
    for i in range(n):
        slope = -p.tableau[i, column]
        if slope > PIVOT_TOL:
            ratio = max(p.tableau[i, n + 1], 0.0) / slope
            prior = int(p.labels[0, i]) == 2 * n or slope > pivot
            if ratio < least * (1.0 - PIVOT_TOL) or (ratio <= least * (1.0 + PIVOT_TOL) and prior):
                row, least, pivot = i, min(ratio, least), slope
                if int(p.labels[0, i]) == 2 * n:
                    pivot = np.inf
    return row


@apart
def _walk(p: Problem, n: int) -> bool:
    """Lemke's method; whether it ends in a solution."""
    row, least = -1, 0.0
    for i in range(n):
        if p.tableau[i, n + 1] < least:
            row, least = i, p.tableau[i, n + 1]
    column = n
    for _ in range(MAX_PIVOTS * n):
        if row < 0:
            break
        leaves = int(p.labels[0, row])
        _pivot(p, n, row, column)
        if leaves == 2 * n:
            return True
        enters = leaves + n if leaves < n else leaves - n
        for j in range(n + 1):
            column = j if int(p.labels[1, j]) == enters else column
        row = _leaving(p, n, column)
    return least == 0.0


@apart
def pivot(p: Problem, turn: float) -> bool:
    """Solve the contact problem with polygons, turned by an angle with the sine `turn`, for x; returns whether there is
    a solution."""
    n = _list_unknowns(p, turn)
    for i in range(p.free.size):
        p.x[i] = 0.0
    _fill(p, n)
    if not _walk(p, n):
        return False
    for i in range(n):
        label = int(p.labels[0, i])
        if label >= n:
            k, z = label - n, max(p.tableau[i, n + 1], 0.0)
            row = int(p.unknowns[k, FIRST])
            for a in range(FIRST):
                if p.unknowns[k, a] != 0.0 and int(p.unknowns[k, KIND]) != SLIP:
                    p.x[row + a] += z * p.unknowns[k, a]
    return True
