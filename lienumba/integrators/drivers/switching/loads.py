"""Friction of joints that sticks where others hold them, too, of one run: how large it is.

Rows that say the same as others are not used in a step, and bear nothing. Where what is used could not hold what rests
by itself, as feet that would have to pull where dry hinges may carry, friction that is left out is a load which stays
as it is until something changes. Of all forces that hold, those are taken that are well within all limits (the analytic
center), so that each change halves the way to where nothing holds any more.
"""

from lienumba.compiler.routines.marks import Floats2, apart, inlined
from lienumba.integrators.drivers.switching.problem import BOUNDED, HOLDS, PRESSES, SLIDES, Problem, eliminate, size
from lienumba.integrators.drivers.switching.reactions import Reactions
from lienumba.integrators.drivers.switching.used_rows import BARE, DRY, FIRM, SHARED, TANGENT, lift, take
from lienumba.integrators.layout import SWITCH_FIRST, SWITCH_ROWS, SWITCH_SHARES, SWITCH_TANGENTS

SLIGHT = 1e-9  # of the largest force: what presses with less does not
WITHIN = 1e-9  # of what a force may be: by how much it may be more
SOFTENINGS, SOFTER, STEPS, HALVINGS = 9, 0.1, 8, 40  # of limits, each a tenth of the one before; Newton steps, of each


@apart
def lend(r: Reactions, largest: float) -> None:
    """Of friction that others hold, too, which is a load, `lent`, with forces x that hold all that rests; largest: the
    force that rates ask for."""
    p, some, rough = r.problem, False, False
    for s in range(p.law.size):
        r.lent[s] = 0.0
        some = some or p.law[s] == BOUNDED
    for i in range(p.free.size):
        p.given[i] = p.x[i]
    if not some or not _left_out(r, largest):
        return
    for s in range(p.law.size):
        rough = rough or (_presses(p, s, largest) and p.switches[s, SWITCH_TANGENTS] > 0)
    if not rough:  # stops that would pull may open instead
        lift(r, float(BARE))
        lift(r, float(DRY))
        held = _within(p)
        for i in range(p.free.size):
            p.x[i] = p.given[i]
        if held or not _left_out(r, largest):
            return
    for s in range(p.law.size):
        row = p.switches[s, SWITCH_FIRST]
        r.lent[s] = 1.0 if p.law[s] == BOUNDED and r.taken[row] == 0.0 and p.bound[s] > 0.0 else 0.0
    _center(p, _directions(r), largest)


@apart
def _left_out(r: Reactions, largest: float) -> bool:
    """Take rows that are independent of all that hold; whether friction of joints is left out that may carry."""
    p, some = r.problem, False
    for i in range(p.free.size):
        r.wanted[i], r.taken[i] = -1.0, 0.0
    for s in range(p.law.size):
        row, law, end = p.switches[s, SWITCH_FIRST], p.law[s], p.switches[s, SWITCH_FIRST] + p.switches[s, SWITCH_ROWS]
        if law == BOUNDED:
            r.wanted[row] = float(DRY)
        for i in range(row, end if law == HOLDS else row):
            r.wanted[i] = float(FIRM)
        if _presses(p, s, largest):
            r.wanted[row] = float(SHARED) if p.switches[s, SWITCH_SHARES] != 0 else float(BARE)
            for i in range(row + 1, end if law == PRESSES else row):
                r.wanted[i] = float(TANGENT)
    take(r)
    for s in range(p.law.size):
        row = p.switches[s, SWITCH_FIRST]
        some = some or (p.law[s] == BOUNDED and r.taken[row] == 0.0 and p.S[row, row] > 0.0)
    return some


@inlined
def _presses(p: Problem, switch: int, largest: float) -> bool:
    """With the forces that were given."""
    return p.law[switch] >= PRESSES and p.given[p.switches[switch, SWITCH_FIRST]] > SLIGHT * largest


@apart
def _within(p: Problem) -> bool:
    """Whether all forces are what they may be, where no contact has friction."""
    most, good = 0.0, True
    for s in range(p.law.size):
        if p.law[s] >= PRESSES:
            most = max(most, size(p.x[p.switches[s, SWITCH_FIRST]]))
    for s in range(p.law.size):
        row = p.switches[s, SWITCH_FIRST]
        if p.law[s] == BOUNDED:
            good = good and size(p.x[row]) <= (1.0 + WITHIN) * p.bound[s]
        if p.law[s] >= PRESSES:
            good = good and p.x[row] >= -WITHIN * most
    return good


@apart
def _directions(r: Reactions) -> Floats2:
    """A row for each load: by how much all forces change with it, such that what they hold rests."""
    p, N = r.problem, r.grips.whole
    n, m = 0, 0
    for i in range(p.free.size):
        for j in range(p.free.size):
            N[i, j] = 0.0
    for s in range(p.law.size):
        if r.lent[s] == 0.0:
            continue
        load, n = p.switches[s, SWITCH_FIRST], 0
        for i in range(p.free.size):
            if r.taken[i] != 0.0:
                m = 0
                for j in range(p.free.size):
                    if r.taken[j] != 0.0:
                        p.matrix[n, m] = _given(p, i, j)
                        m += 1
                p.matrix[n, m] = -p.S[i, load]
                n += 1
        eliminate(p.matrix, n, p.step)
        n = 0
        for j in range(p.free.size):
            if r.taken[j] != 0.0:
                N[load, j] = p.step[n]
                n += 1
        N[load, load] = 1.0
        _slide_along(p, N, load)
    return N


@inlined
def _given(p: Problem, row: int, column: int) -> float:
    """What a force in one row gives another; of what slides with its friction."""
    total = p.S[row, column]
    for s in range(p.law.size):
        first = p.switches[s, SWITCH_FIRST]
        if p.law[s] == SLIDES and first == column:
            for i in range(first + 1, first + 1 + p.switches[s, SWITCH_TANGENTS]):
                total -= p.friction[s] * p.direction[i] * p.S[row, i]
    return total


@inlined
def _slide_along(p: Problem, N: Floats2, load: int) -> None:
    for s in range(p.law.size):
        first = p.switches[s, SWITCH_FIRST]
        if p.law[s] == SLIDES:
            for i in range(first + 1, first + 1 + p.switches[s, SWITCH_TANGENTS]):
                N[load, i] = -p.friction[s] * p.direction[i] * N[load, first]


@apart
def _center(p: Problem, N: Floats2, largest: float) -> None:
    """Forces from x on along N to where the product of their distances from all limits is largest. Limits are soft at
    first: x may lie on some."""
    q, soft, most = p.free.size, 1.0, 0.0
    for s in range(p.law.size):
        if _presses(p, s, largest):
            most = max(most, p.given[p.switches[s, SWITCH_FIRST]])
    most = most if most > 0.0 else largest
    for _ in range(SOFTENINGS):
        soft *= SOFTER
        for i in range(q):  # towards what fulfils all limits, until these do, too
            p.x[i] = p.given[i] + 0.5 * SOFTER * (p.x[i] - p.given[i])
        for _ in range(STEPS):
            before, part = _room(p, soft, most, largest), 1.0
            _to_center(p, N, soft, most, largest)
            eliminate(p.matrix, q, p.step)
            for i in range(q):
                p.best[i], p.anchor[i] = p.x[i], 0.0
                for k in range(q):
                    p.anchor[i] += N[k, i] * p.step[k]
            for _ in range(HALVINGS):
                for i in range(q):
                    p.x[i] = p.best[i] + part * p.anchor[i]
                if _room(p, soft, most, largest) > before:
                    break
                part *= 0.5
            if not _room(p, soft, most, largest) > before:
                for i in range(q):
                    p.x[i] = p.best[i]
                break


@inlined
def _rubs(p: Problem, switch: int) -> bool:
    return p.law[switch] == PRESSES and p.switches[switch, SWITCH_TANGENTS] == 2 and p.friction[switch] > 0.0


@apart
def _room(p: Problem, soft: float, most: float, largest: float) -> float:
    """The product of the distances, in parts of the limits; 0 where one is passed. soft: how much farther these are;
    most: of what presses."""
    room = 1.0
    for s in range(p.law.size):
        row = p.switches[s, SWITCH_FIRST]
        if p.law[s] == BOUNDED and p.bound[s] > 0.0:
            part = p.x[row] / ((1.0 + soft) * p.bound[s])
            room *= max(1.0 - part * part, 0.0)
        if _presses(p, s, largest):
            normal = p.x[row] + soft * most
            room *= max(normal, 0.0) / most
            if _rubs(p, s):
                square = p.x[row + 1] * p.x[row + 1] + p.x[row + 2] * p.x[row + 2]
                limit = p.friction[s] * normal
                room *= max(limit * limit - square, 0.0) / (p.friction[s] * p.friction[s] * most * most)
    return room


@apart
def _to_center(p: Problem, N: Floats2, soft: float, most: float, largest: float) -> None:
    """Newton's method for the logarithm of this along N: its slope to the last column of `matrix`, its bend with a
    minus to the others."""
    q = p.free.size
    for k in range(q):
        for j in range(q + 1):
            p.matrix[k, j] = 0.0
    for s in range(p.law.size):
        row, mu = p.switches[s, SWITCH_FIRST], p.friction[s]
        if p.law[s] == BOUNDED and p.bound[s] > 0.0:
            limit = (1.0 + soft) * p.bound[s]
            _add(p, N, row, -1.0 / (limit - p.x[row]))
            _add(p, N, row, 1.0 / (limit + p.x[row]))
        if _presses(p, s, largest):
            _add(p, N, row, 1.0 / (p.x[row] + soft * most))
            if _rubs(p, s):
                limit, x, y = mu * (p.x[row] + soft * most), p.x[row + 1], p.x[row + 2]
                square = limit * limit - x * x - y * y
                for k in range(q):
                    mk, xk, yk = mu * N[k, row], N[k, row + 1], N[k, row + 2]
                    rise = 2.0 * (limit * mk - x * xk - y * yk) / square
                    p.matrix[k, q] += rise
                    for j in range(q):
                        mj, xj, yj = mu * N[j, row], N[j, row + 1], N[j, row + 2]
                        other = 2.0 * (limit * mj - x * xj - y * yj) / square
                        p.matrix[k, j] += rise * other - 2.0 * (mk * mj - xk * xj - yk * yj) / square


@inlined
def _add(p: Problem, N: Floats2, row: int, pull: float) -> None:
    """Of a distance that changes by +-1 along a row; pull: that over the distance."""
    q = p.free.size
    for k in range(q):
        p.matrix[k, q] += pull * N[k, row]
        for j in range(q):
            p.matrix[k, j] += pull * pull * N[k, row] * N[j, row]
