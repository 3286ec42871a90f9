"""Impulses and forces of what may open, stick or slide: a complementarity problem of a few rows, solved run by run.

With the impulses (or forces) x of the switched rows their rates (or accelerations) are r = S x + free. Of each switch a
law says how x and r fit: HOLDS (r = 0), PRESSES (0 <= x_n, 0 <= r_n, x_n r_n = 0; tangents in the disk |x_t| <= mu x_n,
those on its edge against r_t: Coulomb's law), SLIDES (as PRESSES, x_t = -mu d x_n with a given direction d), BOUNDED
(|x| <= bound, on the edge against r). Block Gauss-Seidel sweeps (Jean and Moreau) come near, from wherever they begin,
also with redundant rows; the Newton method for the natural map (Alart and Curnier) then ends to rounding.
"""

import numpy as np

from lienumba.compiler.routines.marks import apart, inlined
from lienumba.integrators.drivers.switching.problem import (
    BOUNDED,
    DEPENDENT,
    FREE,
    HOLDS,
    PARADOX,
    PRESSES,
    ROUNDING,
    SLIDES,
    SOLVED,
    UNSOLVED,
    Problem,
    eliminate,
    size,
    update_rates,
)
from lienumba.integrators.layout import SWITCH_FIRST, SWITCH_ROWS, SWITCH_SHARES, SWITCH_TANGENTS

SWEEPS, ROUNDS, NEWTONS = 25, 40, 12  # sweeps between two trials of Newton's method, how many of these, its steps
EXACT, CLOSE = 1e-15, 1e-10  # of the largest impulse: what Newton's method tries to reach, and what will do
STIFF, STIFFER = 1e-6, 0.3  # of the largest diagonal: how much contacts give way, and how less where that is too hard
FEW, REFINED = 4, 4  # rounds; how often it is made good that contacts give way
SMOOTH, ROUGHER = 0.25, 1.5  # from which coefficient on, and how friction grows
AROUND, TURN_C, TURN_S = 64, 0.9951847266721969, 0.0980171403295606  # directions, and from one to the next
HALVINGS = 52  # of the angle between two of them
ENDLESS = 1e6  # times what rates ask for, as roots of energies
SECULAR = 60  # steps for the distance to the edge of a disk


@inlined
def _push(p: Problem, row: int, change: float) -> None:
    """Another impulse in a row, and what it does to all rates."""
    p.x[row] += change
    for i in range(p.free.size):
        p.rates[i] += p.S[i, row] * change


@apart
def _hold(p: Problem, first: int, rows: int) -> None:
    """The rows of one switch to rate 0."""
    for i in range(rows):
        for j in range(rows):
            p.matrix[i, j] = p.S[first + i, first + j]
        p.matrix[i, rows] = -p.rates[first + i]
    eliminate(p.matrix, rows, p.step)
    for i in range(rows):
        _push(p, first + i, p.step[i])


@apart
def _hold_all(p: Problem) -> bool:
    """All rows that hold to rate 0 at once, where there is no other law; whether that is so."""
    n = 0
    for s in range(p.law.size):
        if p.law[s] != FREE and p.law[s] != HOLDS:
            return False
    for s in range(p.law.size):
        for i in range(p.switches[s, SWITCH_FIRST], p.switches[s, SWITCH_FIRST] + p.switches[s, SWITCH_ROWS]):
            if p.law[s] == HOLDS:
                p.best[n] = float(i)
                n += 1
    for i in range(n):
        for j in range(n):
            p.matrix[i, j] = p.S[int(p.best[i]), int(p.best[j])]
        p.matrix[i, n] = -p.rates[int(p.best[i])]
    eliminate(p.matrix, n, p.step)
    for i in range(n):
        _push(p, int(p.best[i]), p.step[i])
    return True


@apart
def _rub(p: Problem, first: int, tangents: int, most: float) -> None:
    """Tangents to rate 0, or onto the edge of the disk of radius `most`, against their rates: (S + k) x = g, k >= 0."""
    a, b, c = p.S[first, first], 0.0, 1.0
    g, f = a * p.x[first] - p.rates[first], 0.0
    if tangents == 2:
        b, c = p.S[first + 1, first], p.S[first + 1, first + 1]
        g += b * p.x[first + 1]
        f = b * p.x[first] + c * p.x[first + 1] - p.rates[first + 1]
    k, x, y = 0.0, 0.0, 0.0
    for _ in range(SECULAR):
        determinant = (a + k) * (c + k) - b * b
        if not determinant > DEPENDENT * (a + k) * (c + k):
            k = max(2.0 * k, 1e-6 * (a + c))
            continue
        x, y = ((c + k) * g - b * f) / determinant, ((a + k) * f - b * g) / determinant
        length = np.sqrt(x * x + y * y)
        if length <= most * (1.0 + 4.0 * EXACT):
            break
        slope = ((c + k) * x * x - 2.0 * b * x * y + (a + k) * y * y) / (determinant * length)  # -d|x|/dk
        if most <= EXACT * EXACT * length or not slope > 0.0:
            x, y = 0.0, 0.0
            break
        k += (length - most) * length / (most * slope)  # Newton's step for 1/|x|
    length = np.sqrt(x * x + y * y)
    shrink = most / length if length > most else 1.0
    _push(p, first, shrink * x - p.x[first])
    if tangents == 2:
        _push(p, first + 1, shrink * y - p.x[first + 1])


@inlined
def _leaning(p: Problem, first: int, tangents: int, mu: float) -> float:
    """How a normal's rate grows with its impulse where friction follows from it."""
    total = p.S[first, first]
    for i in range(first + 1, first + 1 + tangents):
        total -= mu * p.direction[i] * p.S[first, i]
    return total


@inlined
def _slid(
    p: Problem, first: int, mu: float, b: tuple[float, float, float], c: float, s: float
) -> tuple[float, float, float]:  # fmt: skip
    """Of a contact alone that slides along (c, s), with rates b without its impulse: its pivot, and times this how fast
    it slides along (c, s), and across."""
    S = p.S
    pivot = S[first, first] - mu * (c * S[first, first + 1] + s * S[first, first + 2])
    u = S[first, first + 1] - mu * (c * S[first + 1, first + 1] + s * S[first + 1, first + 2])
    v = S[first, first + 2] - mu * (c * S[first + 1, first + 2] + s * S[first + 2, first + 2])
    u, v = pivot * b[1] - b[0] * u, pivot * b[2] - b[0] * v
    return pivot, c * u + s * v, c * v - s * u


@apart
def _alone(p: Problem, first: int, mu: float) -> None:
    """Of a contact alone what fulfils its law: it opens, sticks, or slides along one of the directions, of which there
    are four at most, that friction does not turn."""
    b0, b1, b2 = p.rates[first], p.rates[first + 1], p.rates[first + 2]
    for j in range(first, first + 3):
        b0, b1, b2 = b0 - p.S[first, j] * p.x[j], b1 - p.S[first + 1, j] * p.x[j], b2 - p.S[first + 2, j] * p.x[j]
    for i in range(3):
        for j in range(3):
            p.matrix[i, j] = p.S[first + i, first + j]
    p.matrix[0, 3], p.matrix[1, 3], p.matrix[2, 3] = -b0, -b1, -b2
    eliminate(p.matrix, 3, p.step)
    x, y, z = p.step[0], p.step[1], p.step[2]
    if b0 >= 0.0:
        x, y, z = 0.0, 0.0, 0.0
    elif np.sqrt(y * y + z * z) > mu * x:
        x, y, z = p.x[first], p.x[first + 1], p.x[first + 2]
        b, c, s = (b0, b1, b2), 1.0, 0.0
        before = _slid(p, first, mu, b, c, s)[2]
        for _ in range(AROUND):
            to_c, to_s = c * TURN_C - s * TURN_S, s * TURN_C + c * TURN_S
            after = _slid(p, first, mu, b, to_c, to_s)[2]
            if before * after <= 0.0:
                low_c, low_s, high_c, high_s = c, s, to_c, to_s
                for _ in range(HALVINGS):
                    length = np.sqrt((low_c + high_c) * (low_c + high_c) + (low_s + high_s) * (low_s + high_s))
                    mid_c, mid_s = (low_c + high_c) / length, (low_s + high_s) / length
                    if before * _slid(p, first, mu, b, mid_c, mid_s)[2] > 0.0:
                        low_c, low_s = mid_c, mid_s
                    else:
                        high_c, high_s = mid_c, mid_s
                pivot, ahead, _aside = _slid(p, first, mu, b, high_c, high_s)
                if pivot > DEPENDENT * p.S[first, first] and ahead >= 0.0:
                    x = -b0 / pivot
                    y, z = -mu * x * high_c, -mu * x * high_s
            c, s, before = to_c, to_s, after
    _push(p, first, x - p.x[first])
    _push(p, first + 1, y - p.x[first + 1])
    _push(p, first + 2, z - p.x[first + 2])


@apart
def _sweep(p: Problem, rays: bool) -> bool:
    """Let every switch follow its law, one by one; whether each can."""
    for s in range(p.law.size):
        first, rows, tangents = p.switches[s, SWITCH_FIRST], p.switches[s, SWITCH_ROWS], p.switches[s, SWITCH_TANGENTS]
        law, mu = p.law[s], p.friction[s]
        if law == HOLDS:
            _hold(p, first, rows)
        if law == BOUNDED:
            _rub(p, first, 1, p.bound[s])
        if law >= PRESSES and p.S[first, first] > 0.0:
            pivot = p.S[first, first] if law == PRESSES else _leaning(p, first, tangents, mu)
            if not pivot > DEPENDENT * p.S[first, first]:
                return False
            _push(p, first, max(-p.x[first], -p.rates[first] / pivot))
            if law == PRESSES and tangents > 0:
                _rub(p, first + 1, tangents, mu * p.x[first])
                if rays and tangents == 2:
                    _alone(p, first, mu)
            for i in range(first + 1, first + 1 + tangents if law == SLIDES else first):
                _push(p, i, -mu * p.direction[i] * p.x[first] - p.x[i])
    return True


@inlined
def scaled(p: Problem, row: int) -> float:
    """What a rate of 1 is as an impulse."""
    return 1.0 / p.S[row, row] if p.S[row, row] > 0.0 else 0.0


@apart
def _map(p: Problem) -> float:
    """The natural map, 0 where all laws hold, to the last column of `matrix`, with a minus, and its Jacobian to the
    others. Returns its largest entry."""
    q, worst = p.free.size, 0.0
    for i in range(q):
        for j in range(q):
            p.matrix[i, j] = 0.0
        p.matrix[i, i], p.matrix[i, q] = 1.0, p.x[i]
    for s in range(p.law.size):
        first, rows, tangents = p.switches[s, SWITCH_FIRST], p.switches[s, SWITCH_ROWS], p.switches[s, SWITCH_TANGENTS]
        law, mu = p.law[s], p.friction[s]
        if law == HOLDS:
            for i in range(first, first + rows):
                _row_of_rates(p, i)
        if law == BOUNDED:
            _rows_of_disk(p, first, 1, -1, p.bound[s])
        if law >= PRESSES:
            if p.x[first] - scaled(p, first) * p.rates[first] > 0.0:
                _row_of_rates(p, first)
            if law == PRESSES and tangents > 0:
                _rows_of_disk(p, first + 1, tangents, first, mu)
            for i in range(first + 1, first + 1 + tangents if law == SLIDES else first):
                p.matrix[i, first] = mu * p.direction[i]
                p.matrix[i, q] = p.x[i] + mu * p.direction[i] * p.x[first]
    for i in range(q):
        worst = max(worst, size(p.matrix[i, q])) if p.matrix[i, q] == p.matrix[i, q] else np.inf
        p.matrix[i, q] = -p.matrix[i, q]
    return worst


@inlined
def _row_of_rates(p: Problem, i: int) -> None:
    """The map is the rate of this row."""
    scale = scaled(p, i)
    for j in range(p.free.size):
        p.matrix[i, j] = scale * p.S[i, j]
    p.matrix[i, p.free.size] = scale * p.rates[i]


@apart
def _rows_of_disk(p: Problem, first: int, tangents: int, normal: int, radius: float) -> None:
    """x - the projection of x - rates onto the disk; its radius is a bound, or of a normal's impulse a multiple."""
    q = p.free.size
    trace = p.S[first, first] + (p.S[first + 1, first + 1] if tangents == 2 else 0.0)
    scale = float(tangents) / trace if trace > 0.0 else 0.0
    most = radius if normal < 0 else radius * max(p.x[normal], 0.0)
    u = p.x[first] - scale * p.rates[first]
    v = p.x[first + 1] - scale * p.rates[first + 1] if tangents == 2 else 0.0
    length = np.sqrt(u * u + v * v)
    if length <= most:
        for i in range(first, first + tangents):
            for j in range(q):
                p.matrix[i, j] = scale * p.S[i, j]
            p.matrix[i, q] = scale * p.rates[i]
        return
    u, v, shrink = u / length, v / length, most / length
    p.matrix[first, q] = p.x[first] - most * u
    if tangents == 2:
        p.matrix[first + 1, q] = p.x[first + 1] - most * v
        for j in range(q):  # across the direction the projection shrinks, along it it is constant
            across = -v * ((1.0 if j == first else 0.0) - scale * p.S[first, j])
            across += u * ((1.0 if j == first + 1 else 0.0) - scale * p.S[first + 1, j])
            p.matrix[first, j] += shrink * v * across
            p.matrix[first + 1, j] -= shrink * u * across
    if normal >= 0 and p.x[normal] > 0.0:
        p.matrix[first, normal] -= radius * u
        if tangents == 2:
            p.matrix[first + 1, normal] -= radius * v


@apart
def asked(p: Problem) -> float:
    """The largest impulse that there is, or that any rate asks for."""
    most = 0.0
    for i in range(p.free.size):
        most = max(most, max(size(p.x[i]), scaled(p, i) * size(p.free[i])))
    return most


@apart
def _fulfils(p: Problem, missed: float) -> bool:
    """Whether x does, with the natural map so far from 0. Impulses far beyond what rates ask for, as those with which a
    wedge may hold itself, leave of all rates rounding."""
    enough, asked, most = 0.0, 0.0, 0.0
    for i in range(p.free.size):
        root = np.sqrt(scaled(p, i))
        enough = max(enough, CLOSE * root * root * size(p.free[i]))
        asked, most = max(asked, root * size(p.free[i])), max(most, size(p.x[i]) / root if root > 0.0 else 0.0)
    for s in range(p.law.size):
        enough = max(enough, ROUNDING * p.least[s]) if p.law[s] != FREE else enough
        row = p.switches[s, SWITCH_FIRST]
        asked = max(asked, p.least[s] * np.sqrt(p.S[row, row])) if p.law[s] != FREE else asked
    return missed <= enough and most <= ENDLESS * asked


@apart
def _newton(p: Problem) -> float:
    """Newton's method from x on; returns how far the natural map is from 0 at the best x that was found, in x then."""
    q, least = p.free.size, np.inf
    for n in range(NEWTONS):
        update_rates(p)
        worst = _map(p)
        if worst < least:
            least = worst
            for i in range(q):
                p.best[i] = p.x[i]
        elif n > 2 and least <= CLOSE * asked(p):
            break
        if worst <= EXACT * asked(p) or not worst < np.inf:
            break
        eliminate(p.matrix, q, p.step)
        for i in range(q):
            p.x[i] += p.step[i]
    for i in range(q):
        p.x[i] = p.best[i]
    return least


@apart
def _clean(p: Problem) -> None:
    """No impulse, to the bit, where there is no law, and of contacts that open."""
    for s in range(p.law.size):
        first, law = p.switches[s, SWITCH_FIRST], p.law[s]
        leaves = p.x[first] - scaled(p, first) * p.rates[first] <= 0.0
        for i in range(first, first + p.switches[s, SWITCH_ROWS]):
            if law == FREE or (law >= PRESSES and leaves):
                p.x[i] = 0.0


@apart
def search(p: Problem, rounds: int, rays: bool) -> int:
    """Sweeps and Newton's method from x on, in turn; of no round the latter alone."""
    for _ in range(max(rounds, 1)):
        update_rates(p)
        if rounds > 0 and not _hold_all(p):
            for _ in range(SWEEPS):
                if not _sweep(p, rays):
                    return PARADOX
        least = _newton(p)
        update_rates(p)
        _clean(p)
        update_rates(p)
        if _fulfils(p, least):
            return SOLVED
    return UNSOLVED


@inlined
def _shift(p: Problem, by: float) -> None:
    """Contacts give way by this for a unit of impulse beyond those of the anchor."""
    for s in range(p.law.size):
        first = p.switches[s, SWITCH_FIRST]
        for i in range(first, first + p.switches[s, SWITCH_ROWS] if p.switches[s, SWITCH_SHARES] != 0 else first):
            p.S[i, i] = p.diagonal[i] + by
            p.free[i] = p.given[i] - by * p.anchor[i]


@apart
def _share(p: Problem) -> int:
    """Find the impulses of contacts that all give way equally, by so little that it is soon made good; where that is
    not to be found, from what gives way more on."""
    q, scale = p.free.size, 0.0
    for i in range(q):
        p.given[i], p.diagonal[i], p.anchor[i] = p.free[i], p.S[i, i], 0.0
        scale = max(scale, p.S[i, i])
    _shift(p, STIFF * scale)
    said, by = search(p, 1, False), scale
    while said == UNSOLVED and by > STIFF * scale:
        by = max(STIFFER * by, STIFF * scale)
        _shift(p, by)
        said = search(p, FEW, True)
        if by > STIFF * scale:
            said = UNSOLVED
    for _ in range(REFINED if said == SOLVED else 0):
        for i in range(q):
            p.anchor[i] = p.x[i]
        _shift(p, STIFF * scale)
        _newton(p)
    for i in range(q):
        p.S[i, i], p.free[i] = p.diagonal[i], p.given[i]
    return said


@apart
def _roughen(p: Problem) -> int:
    """Let friction grow up to what it is."""
    said, cap, most = UNSOLVED, SMOOTH, 0.0
    for s in range(p.law.size):
        p.anchor[s], most = p.friction[s], max(most, p.friction[s])
    for i in range(p.free.size):
        p.x[i] = 0.0
    while cap < ROUGHER * most:
        for s in range(p.law.size):
            p.friction[s] = min(p.anchor[s], cap)
        said = search(p, FEW, True)
        cap *= ROUGHER
    for s in range(p.law.size):
        p.friction[s] = p.anchor[s]
    return said


@apart
def refine(p: Problem) -> int:
    """By Newton's method alone, from x on."""
    return search(p, 0, False)


@apart
def contradicts(p: Problem) -> bool:
    """Whether there is no x either where nothing has friction: what holds and what presses ask for different motions.
    Uses up the problem."""
    for s in range(p.law.size):
        p.friction[s], p.bound[s] = 0.0, 0.0
    for i in range(p.free.size):
        p.x[i] = 0.0
    return iterate(p) != SOLVED


@apart
def iterate(p: Problem) -> int:
    """Find x, and its rates; SOLVED, UNSOLVED, or PARADOX where friction leaves nothing to be found. Of contacts with
    friction that say the same the impulses of least norm."""
    contacts = 0
    for s in range(p.law.size):
        contacts += 1 if p.law[s] >= PRESSES and p.switches[s, SWITCH_SHARES] != 0 else 0
    said = UNSOLVED
    if contacts > 1:
        said = _share(p)
        if said == SOLVED:
            said = search(p, 0, False)
    if said == UNSOLVED:
        said = search(p, FEW, False)
    if said == UNSOLVED:
        said = _roughen(p)
    if said == UNSOLVED:
        said = search(p, ROUNDS, True)
    return said
