"""Independent rows of the active switched constraints of one run; redundant ones are not used in a step."""

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

BILATERAL_ROW, FRICTIONLESS_ROW, NORMAL_ROW, UNLOADED_ROW, TANGENT_ROW, JOINT_FRICTION_ROW = range(6)
PHASES = 6  # rows are taken in this order
CHECKED_ROW = PHASES  # never taken, but asked what others leave of them
UNKNOWN = 3.0  # how a switch is on that presses with nothing: others may hold it


@inlined
def held(r: Reactions, row: int) -> bool:
    """Return whether a row depends on rows that are taken."""
    return not r.problem.matrix[row, row] > r.least[row]


@inlined
def is_prescribed(rows: Rows, first: Workspace, sizes: Sizes, p: Problem, lane: int, switch: int) -> bool:
    """Return whether the friction of a joint that sticks is a prescribed force."""
    return rows[first.state + layout.memory_row(sizes) + p.switches[switch, SWITCH_MEMORY], lane] != 0.0


@apart
def _want(r: Reactions, rows: Rows, first: Workspace, sizes: Sizes, lane: int) -> None:
    """Set the phase in which each active row is to be taken; no row is taken yet."""
    p, on = r.problem, first.state + layout.on_row(sizes)
    for i in range(sizes.switched):
        r.taken[i], r.wanted[i] = 0.0, -1.0
    for s in range(sizes.switches):
        row, how, kind = p.switches[s, SWITCH_FIRST], rows[on + s, lane], p.switches[s, SWITCH_KIND]
        for i in range(row, row + p.switches[s, SWITCH_ROWS]):
            if kind == layout.BILATERAL and how != OFF:
                r.wanted[i] = float(BILATERAL_ROW)
            if kind == UNILATERAL and how != OFF:
                normal = float(NORMAL_ROW) if p.switches[s, layout.SWITCH_SHARES] != 0 else float(FRICTIONLESS_ROW)
                if how == UNKNOWN:
                    normal = float(CHECKED_ROW) if p.switches[s, SWITCH_ROWS] == 1 else float(UNLOADED_ROW)
                r.wanted[i] = normal if i == row else float(TANGENT_ROW) if how == STICK else -1.0
            if kind == FRICTION and how == STICK and not is_prescribed(rows, first, sizes, p, lane, s):
                r.wanted[i] = float(JOINT_FRICTION_ROW)


@apart
def independent(r: Reactions, rows: Rows, first: Workspace, sizes: Sizes, lane: int) -> None:
    """Take independent rows: of joints and locks, then normals without friction in the order of their forces, other
    normals, unloaded ones, tangents, and the friction of joints."""
    _want(r, rows, first, sizes, lane)
    take(r)


@apart
def take(r: Reactions) -> None:
    """Take independent rows, phase by phase."""
    for phase in range(PHASES):
        _take(r, float(phase))


@apart
def take_bilateral(r: Reactions, sizes: Sizes) -> None:
    """Take the rows of joints and locks; then `held` tells for all other rows whether they depend on these."""
    p = r.problem
    for i in range(sizes.switched):
        r.taken[i], r.wanted[i] = 0.0, float(CHECKED_ROW)
    for s in range(sizes.switches):
        if p.law[s] == HOLDS:
            for i in range(p.switches[s, SWITCH_FIRST], p.switches[s, SWITCH_FIRST] + p.switches[s, SWITCH_ROWS]):
                r.wanted[i] = float(BILATERAL_ROW)
    _take(r, float(BILATERAL_ROW))


@apart
def choose_rows(r: Reactions, rows: Rows, first: Workspace, sizes: Sizes, lane: int) -> None:
    """Write the masks of independent rows to the state; these rows carry the forces of redundant ones."""
    independent(r, rows, first, sizes, lane)
    _carry_over(r)
    for i in range(sizes.switched):
        rows[first.state + layout.mask_row(sizes) + i, lane] = r.taken[i]


@apart
def _take(r: Reactions, phase: float) -> None:
    """Take rows of one phase that are independent of all rows taken before."""
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
                stronger = phase != FRICTIONLESS_ROW and best >= 0 and p.matrix[i, i] > 2.0 * p.matrix[best, best]
                if best < 0 or stronger or (phase == FRICTIONLESS_ROW and p.x[i] > p.x[best]):
                    best = i
        if best < 0:
            return
        r.taken[best] = 1.0
        remove(r, best)


@inlined
def remove(r: Reactions, row: int) -> None:
    """Eliminate a row from all others that are wanted."""
    p = r.problem
    pivot = p.matrix[row, row]
    for i in range(p.free.size):
        if i != row and r.wanted[i] >= 0.0:
            factor = p.matrix[i, row] / pivot
            for j in range(p.free.size):
                p.matrix[i, j] -= factor * p.matrix[row, j]


@apart
def _carry_over(r: Reactions) -> None:
    """Let rows that are taken carry the forces of normals without friction that are not; where one of them would begin
    to pull, it and the other normal change places (Caratheodory)."""
    p, q = r.problem, r.taken.size
    for extra in range(q):
        if r.wanted[extra] == FRICTIONLESS_ROW and r.taken[extra] == 0.0 and p.x[extra] > 0.0:
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
            n, most, leaves = 0, p.x[extra], extra
            for i in range(q):
                if r.taken[i] != 0.0:
                    share, pushes = p.step[n], FRICTIONLESS_ROW <= r.wanted[i] <= NORMAL_ROW
                    if pushes and share < -DEPENDENT and p.x[i] < -share * most:
                        most, leaves = -p.x[i] / share, i
                    n += 1
            n = 0
            for i in range(q):
                if r.taken[i] != 0.0:
                    p.x[i] += p.step[n] * most
                    n += 1
            p.x[extra] -= most
            if leaves != extra:
                r.taken[extra], r.taken[leaves], p.x[leaves] = 1.0, 0.0, 0.0
