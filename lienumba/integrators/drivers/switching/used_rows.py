"""Which of the rows of switched constraints that say the same are used, of one run."""

from lienumba.compiler.routines.marks import apart, inlined
from lienumba.integrators import layout
from lienumba.integrators.drivers.switching.problem import DEPENDENT, HOLDS, Problem, eliminate
from lienumba.integrators.drivers.switching.reactions import Reactions
from lienumba.integrators.drivers.workspace import Rows
from lienumba.integrators.layout import (
    FRICTION,
    OFF,
    STICK,
    SWITCH_FIRST,
    SWITCH_KIND,
    SWITCH_MEMORY,
    SWITCH_ROWS,
    UNILATERAL,
    Workspace,
)
from lienumba.integrators.sizes import Sizes

FIRM, BARE, SHARED, IDLE, TANGENT, DRY, PHASES = range(7)  # rows, in the order in which they are taken
ASKED = PHASES  # never taken, but asked what others leave of them
UNKNOWN = 3.0  # how a switch is on that presses with nothing: others may hold it


@inlined
def held(r: Reactions, row: int) -> bool:
    """Whether rows that are taken say the same as this one."""
    return not r.problem.matrix[row, row] > r.least[row]


@inlined
def is_lent(rows: Rows, first: Workspace, sizes: Sizes, p: Problem, lane: int, switch: int) -> bool:
    """Whether friction of a joint that sticks is a load."""
    return rows[first.state + layout.memory_row(sizes) + p.switches[switch, SWITCH_MEMORY], lane] != 0.0


@apart
def _want(r: Reactions, rows: Rows, first: Workspace, sizes: Sizes, lane: int) -> None:
    """Which rows are to be used, and in which phase they are taken; none is taken."""
    p, on = r.problem, first.state + layout.on_row(sizes)
    for i in range(sizes.switched):
        r.taken[i], r.wanted[i] = 0.0, -1.0
    for s in range(sizes.switches):
        row, how, kind = p.switches[s, SWITCH_FIRST], rows[on + s, lane], p.switches[s, SWITCH_KIND]
        for i in range(row, row + p.switches[s, SWITCH_ROWS]):
            if kind == layout.BILATERAL and how != OFF:
                r.wanted[i] = float(FIRM)
            if kind == UNILATERAL and how != OFF:
                normal = float(SHARED) if p.switches[s, layout.SWITCH_SHARES] != 0 else float(BARE)
                if how == UNKNOWN:
                    normal = float(ASKED) if p.switches[s, SWITCH_ROWS] == 1 else float(IDLE)
                r.wanted[i] = normal if i == row else float(TANGENT) if how == STICK else -1.0
            if kind == FRICTION and how == STICK and not is_lent(rows, first, sizes, p, lane, s):
                r.wanted[i] = float(DRY)


@apart
def independent(r: Reactions, rows: Rows, first: Workspace, sizes: Sizes, lane: int) -> None:
    """Take rows that are independent: what holds first, then normals without friction, those that press most first,
    then normals that share what they carry, last of these what nothing presses, then tangents, then the friction of
    joints."""
    _want(r, rows, first, sizes, lane)
    take(r)


@apart
def take(r: Reactions) -> None:
    """Take rows that are wanted, phase by phase."""
    for phase in range(PHASES):
        _take(r, float(phase))


@apart
def take_firm(r: Reactions, sizes: Sizes) -> None:
    """Take what holds, of which there is some; `held` says then of all other rows whether that leaves them anything."""
    p = r.problem
    for i in range(sizes.switched):
        r.taken[i], r.wanted[i] = 0.0, float(ASKED)
    for s in range(sizes.switches):
        if p.law[s] == HOLDS:
            for i in range(p.switches[s, SWITCH_FIRST], p.switches[s, SWITCH_FIRST] + p.switches[s, SWITCH_ROWS]):
                r.wanted[i] = float(FIRM)
    _take(r, float(FIRM))


@apart
def choose_rows(r: Reactions, rows: Rows, first: Workspace, sizes: Sizes, lane: int) -> None:
    """Masks of independent rows, to the state; what others say, too, is carried by those that are taken."""
    independent(r, rows, first, sizes, lane)
    lift(r, float(BARE))
    lift(r, float(DRY))
    for i in range(sizes.switched):
        rows[first.state + layout.mask_row(sizes) + i, lane] = r.taken[i]


@apart
def _take(r: Reactions, phase: float) -> None:
    """Take rows of this phase as long as they are independent of those that are taken."""
    p, q, some = r.problem, r.taken.size, False
    for i in range(q):
        some = some or r.wanted[i] == phase
    if not some:
        return
    for i in range(q):
        for j in range(q):
            p.matrix[i, j] = p.S[i, j]
    for i in range(q):
        if r.taken[i] != 0.0:
            remove(r, i)
    while True:
        best = -1
        for i in range(q):
            if r.wanted[i] == phase and r.taken[i] == 0.0 and p.matrix[i, i] > r.least[i]:
                stronger = phase != BARE and best >= 0 and p.matrix[i, i] > 2.0 * p.matrix[best, best]
                if best < 0 or stronger or (phase == BARE and p.x[i] > p.x[best]):
                    best = i
        if best < 0:
            return
        r.taken[best] = 1.0
        remove(r, best)


@inlined
def remove(r: Reactions, row: int) -> None:
    """What a row leaves of the others that are wanted."""
    p = r.problem
    pivot = p.matrix[row, row]
    for i in range(p.free.size):
        if i != row and r.wanted[i] >= 0.0:
            factor = p.matrix[i, row] / pivot
            for j in range(p.free.size):
                p.matrix[i, j] -= factor * p.matrix[row, j]


@apart
def lift(r: Reactions, phase: float) -> None:
    """Forces of rows of this phase that are not taken go over to those that are, which change places with them where a
    normal without friction would begin to pull (Caratheodory)."""
    p, q = r.problem, r.taken.size
    for extra in range(q):
        if r.wanted[extra] == phase and r.taken[extra] == 0.0 and p.x[extra] != 0.0:
            n = 0
            for i in range(q):
                if r.taken[i] != 0.0:
                    m = 0
                    for j in range(q):
                        if r.taken[j] != 0.0:
                            p.matrix[n, m] = p.S[i, j]
                            m += 1
                    p.matrix[n, m] = p.S[i, extra]
                    n += 1
            eliminate(p.matrix, n, p.step)
            sign = 1.0 if p.x[extra] > 0.0 else -1.0
            n, most, leaves = 0, sign * p.x[extra], extra
            for i in range(q):
                if r.taken[i] != 0.0:
                    share, pushes = sign * p.step[n], r.wanted[i] == BARE or (phase == BARE and r.wanted[i] == SHARED)
                    if pushes and share < -DEPENDENT and p.x[i] < -share * most:
                        most, leaves = -p.x[i] / share, i
                    n += 1
            n = 0
            for i in range(q):
                if r.taken[i] != 0.0:
                    p.x[i] += sign * p.step[n] * most
                    n += 1
            p.x[extra] -= sign * most
            if leaves != extra:
                r.taken[extra], r.taken[leaves], p.x[leaves] = 1.0, 0.0, 0.0
