"""Impulses at a change, of one run: Newton's restitution at all that is hit at once, with friction, and no more than
energy allows. Works on what `reactions.read` has read."""

import numpy as np

from lienumba.compiler.routines.marks import apart, inlined
from lienumba.integrators import layout
from lienumba.integrators.drivers.switching.complementarity import solve
from lienumba.integrators.drivers.switching.independent_rows import held, take_bilateral
from lienumba.integrators.drivers.switching.problem import HOLDS, PRESSES, SOLVED, size
from lienumba.integrators.drivers.switching.reactions import (
    STILL,
    Reactions,
    along,
    number,
    solve_impulses,
    still,
    touches,
)
from lienumba.integrators.drivers.workspace import Rows
from lienumba.integrators.layout import (
    BILATERAL,
    KINETIC,
    OFF,
    REST_SPEED,
    RESTITUTION,
    SWITCH_FIRST,
    SWITCH_KIND,
    SWITCH_ROWS,
    SWITCH_TANGENTS,
    UNILATERAL,
    Workspace,
)
from lienumba.integrators.sizes import Sizes

DRIVEN = 1e3  # times what is at rest: what holds or touches, and still moves faster after all impulses, is driven
SLOW = 1e-6  # the same: what leaves no faster than this where something is hit has only been rocked
GAINS, LESSER = 1e-12, 60  # of what goes to and fro in an impact: rounding; halvings of what comes back
FAINT = 1e-6  # of what comes back: a part that is none


@apart
def impulses(r: Reactions, rows: Rows, first: Workspace, sizes: Sizes, lane: int) -> int:
    """Find the impulses x of all closed contacts and joints; see `complementarity`."""
    p, on, firm, back = r.problem, first.state + layout.on_row(sizes), False, False
    for s in range(sizes.switches):
        if p.switches[s, SWITCH_KIND] == BILATERAL and rows[on + s, lane] != OFF:
            p.law[s], firm = float(HOLDS), True
    if firm:
        take_bilateral(r, sizes)
    for i in range(sizes.switched):
        r.wanted[i] = 0.0
    for s in range(sizes.switches):
        row, closed = p.switches[s, SWITCH_FIRST], rows[on + s, lane] != OFF
        unilateral = p.switches[s, SWITCH_KIND] == UNILATERAL
        if unilateral and (closed or touches(rows, first, sizes, lane, s, row)):
            p.law[s], p.friction[s] = float(PRESSES), number(rows, first, sizes, lane, s, KINETIC)
            rebound = -number(rows, first, sizes, lane, s, RESTITUTION) * p.free[row]
            comes = p.free[row] < -still(rows, first, sizes, lane, s)
            free = not (firm and held(r, row))  # what holds from now on lets nothing come back
            if free and comes and rebound > 0.0 and rebound >= number(rows, first, sizes, lane, s, REST_SPEED):
                r.wanted[row], back = rebound, True
    status = _solve_restitution(r, 1.0)
    if back and (status != SOLVED or _gained(r) > 0.0):
        status = _reduce_restitution(r)
    if status == SOLVED:
        _end_slow_rebounds(r, rows, first, sizes, lane)
    return status


@apart
def holds(r: Reactions, rows: Rows, first: Workspace, sizes: Sizes, lane: int) -> bool:
    """Return whether the impulses have stopped all joints and locks that hold."""
    p, on = r.problem, first.state + layout.on_row(sizes)
    for s in range(sizes.switches):
        bilateral = p.switches[s, SWITCH_KIND] == BILATERAL and rows[on + s, lane] != OFF
        row, most = p.switches[s, SWITCH_FIRST], DRIVEN * still(rows, first, sizes, lane, s)
        for i in range(row, row + p.switches[s, SWITCH_ROWS] if bilateral else row):
            if size(p.rates[i]) > most:
                return False
    return True


@apart
def _solve_restitution(r: Reactions, part: float) -> int:
    """Find impulses with this part of the rebound speeds."""
    for i in range(r.rates.size):
        r.problem.free[i], r.problem.x[i] = r.rates[i] - part * r.wanted[i], 0.0
    return solve(r.problem)


@apart
def _gained(r: Reactions) -> float:
    """Return the energy gained by an impact over the energy exchanged in it; 0 where it is roundoff."""
    p, gained, scale = r.problem, 0.0, 0.0
    for i in range(p.free.size):
        after = r.rates[i]
        for j in range(p.free.size):
            after += p.S[i, j] * p.x[j]
        gained += p.x[i] * (r.rates[i] + after)
        scale += size(p.x[i]) * (size(r.rates[i]) + size(after))
    return gained / scale if size(gained) > GAINS * scale else 0.0


@apart
def _reduce_restitution(r: Reactions) -> int:
    """Reduce all rebound speeds by the largest factor with which there are impulses that give no energy. With Newton's
    restitution there may be none where friction reverses the sliding (Kane's paradox), or in a wedge."""
    low, high = 0.0, 1.0
    for _ in range(LESSER):
        part = low + 0.5 * (high - low)
        gained = _gained(r) if _solve_restitution(r, part) == SOLVED else np.inf
        if gained > 0.0:
            high = part
        else:
            low = part
        if gained == 0.0 or high - low < GAINS:
            break
    return _solve_restitution(r, low if low > FAINT else 0.0)


@apart
def _end_slow_rebounds(r: Reactions, rows: Rows, first: Workspace, sizes: Sizes, lane: int) -> None:
    """Add impulses that stop contacts which leave so slowly that their way would be roundoff; else a body would rock
    from one contact to another without end. Contacts that rest stay at rest."""
    p, slow = r.problem, False
    for i in range(sizes.switched):
        r.wanted[i] = 0.0
    for s in range(sizes.switches):
        row, tangents = p.switches[s, SWITCH_FIRST], p.switches[s, SWITCH_TANGENTS]
        rest = still(rows, first, sizes, lane, s)
        stays = p.law[s] == PRESSES and p.free[row] >= r.rates[row] and p.rates[row] <= SLOW / STILL * rest
        if p.law[s] == HOLDS or stays:
            slow = slow or (stays and p.rates[row] > rest)
            sticks = p.law[s] == HOLDS or (tangents > 0 and along(r, s, p.rates) <= rest)
            for i in range(row, row + (p.switches[s, SWITCH_ROWS] if sticks else 1)):
                r.wanted[i] = 1.0
    if slow:
        for i in range(sizes.switched):
            p.free[i] = -p.rates[i]
        solve_impulses(r)


@inlined
def energy_lost(r: Reactions, switch: int) -> float:
    """Return the energy (J) lost by the impulses of a switch."""
    p, total = r.problem, 0.0
    for i in range(
        p.switches[switch, SWITCH_FIRST], p.switches[switch, SWITCH_FIRST] + p.switches[switch, SWITCH_ROWS]
    ):
        after = r.rates[i]
        for j in range(p.free.size):
            after += p.S[i, j] * p.x[j]
        total -= 0.5 * p.x[i] * (r.rates[i] + after)
    return total


@inlined
def impulse(r: Reactions, switch: int) -> float:
    """Return the size (N s or N m s) of the impulses of a switch."""
    p, total = r.problem, 0.0
    for i in range(
        p.switches[switch, SWITCH_FIRST], p.switches[switch, SWITCH_FIRST] + p.switches[switch, SWITCH_ROWS]
    ):
        total += p.x[i] * p.x[i]
    return np.sqrt(total)
