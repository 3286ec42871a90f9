"""The contact problem of one run: forces or impulses x of switched rows with rates or accelerations r = S x + free.

Each switch has a law: HOLDS (r = 0), PRESSES (0 <= x_n, 0 <= r_n, x_n r_n = 0; tangents in the disk |x_t| <= mu x_n,
where they move on its edge against r_t: Coulomb's law), SLIDES (as PRESSES, x_t = -mu d x_n with a given direction d),
BOUNDED (|x| <= bound, where it moves on the edge against r). `pivoting` solves it with polygons for disks; from there
Newton's method for the natural map (Alart and Curnier 1991) converges to roundoff, or from polygons that are turned.
Redundant contacts are compliant, S + eps I; proximal iterations remove what that adds.
"""

import numpy as np

from lienumba.compiler.routines.marks import apart, inlined
from lienumba.integrators.drivers.switching.pivoting import pivot
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

NEWTON_STEPS = 40
EXACT, CLOSE = 1e-15, 1e-10  # relative to the largest impulse: where Newton's method ends, and what is accepted
COMPLIANCE = 1e-6  # eps, relative to the largest diagonal element of S
PROXIMAL_STEPS = 4  # each reduces the error of the compliance by the factor eps over the weakest direction of S
POLYGONS = 16  # each turned by `TURN`
TURN = 0.04  # sine; 8 corners are 0.79 rad apart
ENDLESS = 1e6  # largest impulse, as the root of an energy, over that which rates ask for


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
    for n in range(NEWTON_STEPS):
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
def newton(p: Problem) -> int:
    """Newton's method from x on; SOLVED or UNSOLVED."""
    missed = _newton(p)
    update_rates(p)
    _clean(p)
    update_rates(p)
    return SOLVED if _fulfils(p, missed) else UNSOLVED


@inlined
def _comply(p: Problem, compliance: float) -> None:
    """Let contacts give way by this for a unit of impulse beyond that of the anchor."""
    for s in range(p.law.size):
        first = p.switches[s, SWITCH_FIRST]
        for i in range(first, first + p.switches[s, SWITCH_ROWS] if p.switches[s, SWITCH_SHARES] != 0 else first):
            p.S[i, i] = p.diagonal[i] + compliance
            p.free[i] = p.given[i] - compliance * p.anchor[i]


@apart
def _search(p: Problem) -> int:
    """Newton's method from x, if that is known or all laws are linear, then from solutions with polygons, until one
    converges."""
    known = True
    for s in range(p.law.size):
        known = known and p.law[s] <= HOLDS
    for i in range(p.free.size):
        known = known or p.x[i] != 0.0
    if known and newton(p) == SOLVED:
        return SOLVED
    for n in range(POLYGONS):
        if not pivot(p, TURN * float(n)):
            return UNSOLVED
        if newton(p) == SOLVED:
            return SOLVED
    return UNSOLVED


@apart
def _share(p: Problem) -> int:
    """Find the impulses of contacts that all give way equally, by so little that it is soon made good."""
    q, scale = p.free.size, 0.0
    for i in range(q):
        p.given[i], p.diagonal[i], p.anchor[i] = p.free[i], p.S[i, i], 0.0
        scale = max(scale, p.S[i, i])
    _comply(p, COMPLIANCE * scale)
    status = _search(p)
    for _ in range(PROXIMAL_STEPS if status == SOLVED else 0):
        for i in range(q):
            p.anchor[i] = p.x[i]
        _comply(p, COMPLIANCE * scale)
        _newton(p)
    for i in range(q):
        p.S[i, i], p.free[i] = p.diagonal[i], p.given[i]
    return newton(p) if status == SOLVED else UNSOLVED


@apart
def _is_paradox(p: Problem) -> bool:
    """Whether friction pushes a contact that slides into what it slides on (Painleve)."""
    for s in range(p.law.size):
        first, pivot = p.switches[s, SWITCH_FIRST], p.S[p.switches[s, SWITCH_FIRST], p.switches[s, SWITCH_FIRST]]
        least = DEPENDENT * pivot
        for i in range(first + 1, first + 1 + p.switches[s, SWITCH_TANGENTS]):
            pivot -= p.friction[s] * p.direction[i] * p.S[first, i]
        if p.law[s] == SLIDES and least > 0.0 and not pivot > least:
            return True
    return False


@apart
def solve(p: Problem) -> int:
    """Find x, near the x that is known, if any, and its rates; redundant contacts with friction have impulses of least
    norm. Returns SOLVED, UNSOLVED, or PARADOX where friction leaves no solution; then x is 0."""
    contacts, status = 0, UNSOLVED
    for s in range(p.law.size):
        contacts += 1 if p.law[s] >= PRESSES and p.switches[s, SWITCH_SHARES] != 0 else 0
    if contacts > 1:
        status = _share(p)
    if status == UNSOLVED:
        status = _search(p)
    if status == UNSOLVED:
        for i in range(p.free.size):
            p.x[i] = 0.0
        status = PARADOX if _is_paradox(p) else UNSOLVED
    return status


@apart
def contradicts(p: Problem) -> bool:
    """Whether there is no x either where nothing has friction: what holds and what presses ask for different motions.
    Uses up the problem."""
    for s in range(p.law.size):
        p.friction[s], p.bound[s] = 0.0, 0.0
    return solve(p) != SOLVED
