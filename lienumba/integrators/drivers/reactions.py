"""What switched constraints do at a change, of one run: which contacts close, stick or slide, and which of the rows
that say the same are used. Read from what the kernel `border` wrote; see `impacts` for impulses."""

from typing import NamedTuple

import numpy as np

from lienumba.compiler.lanes import matrix
from lienumba.compiler.routines.marks import Integers2, apart, inlined
from lienumba.compiler.rows import ROW
from lienumba.integrators import layout
from lienumba.integrators.drivers.acting import fired, used
from lienumba.integrators.drivers.complementarity import (
    BOUNDED,
    DEPENDENT,
    FREE,
    HOLDS,
    PRESSES,
    SLIDES,
    Problem,
    eliminate,
    size,
    solve,
)
from lienumba.integrators.drivers.event_search import TOUCH
from lienumba.integrators.drivers.workspace import Rows
from lienumba.integrators.layout import (
    FRICTION,
    LEAN,
    OFF,
    SLIDE,
    STICK,
    SWITCH_FIRST,
    SWITCH_KIND,
    SWITCH_ROWS,
    SWITCH_TANGENTS,
    UNILATERAL,
    Sizes,
    Workspace,
)  # fmt: skip

STILL = 1e-9  # of the largest speed of a switch so far: what moves no faster than this is at rest
SLOW = 1e-7  # the same: what slides slower has no direction of its own
SLIGHT = 1e-9  # of the largest force: what slips or leaves by less does not
SHARING = 1e3  # times that: what is left of a force that is none where contacts share
EDGE = 1e-6  # of the most that friction can be
RESTS, AT_ONCE, SMOOTHLY = 0.0, 1.0, 2.0  # sliding begins: with an acceleration, or where its limit is just reached
HEADS, CREEPS = 0.01, 0.75  # of `still`: how fast it is made to begin, in the one case and in the other
FIRM, BARE, SHARED, TANGENT, DRY, PHASES = range(6)  # rows, in the order in which they are taken
ASKED = PHASES  # never taken, but asked what others leave of them
INDEPENDENT, NOISE = 1e-10, 1e-12  # of a row's own size, and of that alone: a pivot below says that others say the same


class Reactions(NamedTuple):
    """rates (q,): of the switched rows before; least (q,): pivots below which rows say nothing new; wanted, taken (q,):
    which of the rows may be used, and which are; begins (s,): whether and how sliding begins from rest."""

    problem: Problem
    rates: np.ndarray
    least: np.ndarray
    wanted: np.ndarray
    taken: np.ndarray
    begins: np.ndarray


@apart
def room(at: Workspace, sizes: Sizes, switches: Integers2) -> Reactions:
    """Where one run at a time is worked on."""
    q, s = sizes.switched, sizes.switches
    address = at.change + ROW * layout.change_room(sizes)
    v = matrix(address, q + layout.CHANGE_VECTORS, q)
    system = matrix(address + 8 * q * (q + layout.CHANGE_VECTORS), q, q + 1)
    p = Problem(
        v[0:q], v[q], switches, v[q + 1][:s], v[q + 2][:s], v[q + 3][:s], v[q + 4], v[q + 5], v[q + 6], v[q + 7],
        v[q + 8], v[q + 9], v[q + 10], v[q + 11], system, v[q + 12][:s],
    )  # fmt: skip
    return Reactions(p, v[q + 13], v[q + 14], v[q + 15], v[q + 16], v[q + 17][:s])


@apart
def read(r: Reactions, rows: Rows, first: Workspace, sizes: Sizes, lane: int) -> None:
    """S and the rates of a lane; no laws, and no impulses."""
    p, n = r.problem, first.change
    for i in range(sizes.switched):
        for j in range(i + 1):
            p.S[i, j] = p.S[j, i] = rows[n, lane]
            n += 1
    for i in range(sizes.switched):
        r.rates[i] = rows[first.change + layout.border_rates(sizes) + i, lane]
        r.least[i] = INDEPENDENT * p.S[i, i] + NOISE * rows[first.change + layout.border_alone(sizes) + i, lane]
        p.free[i], p.x[i], p.direction[i], r.wanted[i] = r.rates[i], 0.0, 0.0, 0.0
    for s in range(sizes.switches):
        p.law[s], p.friction[s], p.bound[s], p.least[s], r.begins[s] = float(FREE), 0.0, 0.0, 0.0, RESTS


@inlined
def number(rows: Rows, first: Workspace, sizes: Sizes, lane: int, switch: int, which: int) -> float:
    """A coefficient of a switch."""
    return rows[first.change + layout.border_numbers(sizes) + layout.CONTACT_NUMBERS * switch + which, lane]


@inlined
def touches(rows: Rows, first: Workspace, sizes: Sizes, lane: int, switch: int, row: int) -> bool:
    """Whether a contact with this normal row does."""
    gap = rows[first.change + layout.border_gaps(sizes) + row, lane]
    return gap <= TOUCH * number(rows, first, sizes, lane, switch, layout.SIZE)


@apart
def hasten(rows: Rows, first: Workspace, sizes: Sizes, switches: Integers2, lane: int, begins: bool) -> None:
    """The largest speeds of a lane's switches so far, and the forces that give these within their lengths; begins: with
    the run."""
    for s in range(sizes.switches):
        row, speed = first.change + layout.change_speeds(sizes) + s, number(rows, first, sizes, lane, s, layout.SPEED)
        speed = speed if begins or speed > rows[row, lane] else rows[row, lane]
        i = switches[s, SWITCH_FIRST]
        alone = rows[first.change + layout.border_alone(sizes) + i, lane]
        gives = max(rows[first.change + layout.border_place(i, i), lane], NOISE * alone)
        force = speed * speed / (gives * number(rows, first, sizes, lane, s, layout.SIZE)) if gives > 0.0 else np.inf
        rows[row, lane], rows[first.change + layout.change_forces(sizes) + s, lane] = speed, force


@inlined
def still(rows: Rows, first: Workspace, sizes: Sizes, lane: int, switch: int) -> float:
    """How fast (m/s or rad/s) what is at rest may seem to be."""
    return STILL * rows[first.change + layout.change_speeds(sizes) + switch, lane]


@inlined
def slow(rows: Rows, first: Workspace, sizes: Sizes, lane: int, switch: int) -> float:
    """How fast (m/s) what slides in a plane may be without a direction of its own: it may have come to rest."""
    return SLOW * rows[first.change + layout.change_speeds(sizes) + switch, lane]


@apart
def spread(r: Reactions) -> None:
    """Impulses, added to x, that change the rates of the wanted rows by what is in `free`."""
    p, n = r.problem, 0
    for i in range(p.free.size):
        if r.wanted[i] != 0.0:
            m = 0
            for j in range(p.free.size):
                if r.wanted[j] != 0.0:
                    p.matrix[n, m] = p.S[i, j]
                    m += 1
            p.matrix[n, m] = p.free[i]
            n += 1
    eliminate(p.matrix, n, p.step)
    n = 0
    for i in range(p.free.size):
        if r.wanted[i] != 0.0:
            p.x[i] += p.step[n]
            n += 1


@inlined
def along(r: Reactions, switch: int, x: np.ndarray) -> float:
    """The length of what is along the tangents of a switch."""
    p, total = r.problem, 0.0
    end = p.switches[switch, SWITCH_FIRST] + p.switches[switch, SWITCH_ROWS]
    for i in range(end - p.switches[switch, SWITCH_TANGENTS], end):
        total += x[i] * x[i]
    return np.sqrt(total)


@inlined
def _fired(rows: Rows, first: Workspace, sizes: Sizes, lane: int, switch: int, which: int) -> bool:
    """Whether a condition of a switch has become true now."""
    return fired(sizes, first, rows, lane, sizes.events + layout.CONDITIONS * switch + which)


@inlined
def _on_edge(r: Reactions, switch: int) -> bool:
    """Whether friction is as large as it may be: what begins to slide has no acceleration yet."""
    p = r.problem
    most = p.bound[switch]
    if p.law[switch] != BOUNDED:
        most = p.friction[switch] * p.x[p.switches[switch, SWITCH_FIRST]]
    return along(r, switch, p.x) > (1.0 - EDGE) * most


@apart
def _may_act(r: Reactions, rows: Rows, first: Workspace, sizes: Sizes, lane: int) -> None:
    """The laws of what holds, rests or slides, with the accelerations that all else gives."""
    p, on = r.problem, first.state + layout.on_row(sizes)
    for i in range(sizes.switched):
        p.free[i] = rows[first.change + layout.border_accelerations(sizes) + i, lane]
    for s in range(sizes.switches):
        kind, row = p.switches[s, SWITCH_KIND], p.switches[s, SWITCH_FIRST]
        closed, speed, rest = rows[on + s, lane] != OFF, along(r, s, r.rates), still(rows, first, sizes, lane, s)
        force = rows[first.change + layout.change_forces(sizes) + s, lane]
        p.least[s] = force if force < np.inf else 0.0
        if kind == layout.BILATERAL and closed:
            p.law[s] = float(HOLDS)
        if kind == UNILATERAL and r.rates[row] <= rest and (closed or touches(rows, first, sizes, lane, s, row)):
            p.law[s], p.friction[s] = float(PRESSES), number(rows, first, sizes, lane, s, layout.STATIC)
            if speed > slow(rows, first, sizes, lane, s):
                _slide(r, rows, first, sizes, lane, s, r.rates, 1.0 / speed)
        if kind == FRICTION:
            p.law[s], p.bound[s] = float(BOUNDED), number(rows, first, sizes, lane, s, layout.STATIC_EFFORT)
            carried = rows[on + s, lane] == STICK and not used(sizes, first, rows, p.switches, lane, s)
            if speed > (0.0 if carried and _fired(rows, first, sizes, lane, s, layout.SLIDES) else rest):
                _slide(r, rows, first, sizes, lane, s, r.rates, 1.0 / speed)


@inlined
def _slide(
    r: Reactions, rows: Rows, first: Workspace, sizes: Sizes, lane: int, switch: int, along: np.ndarray, scale: float
) -> None:
    """A switch slides along `scale * along`; the friction of a joint is a load."""
    p = r.problem
    end = p.switches[switch, SWITCH_FIRST] + p.switches[switch, SWITCH_ROWS]
    for i in range(end - p.switches[switch, SWITCH_TANGENTS], end):
        p.direction[i] = scale * along[i]
    if p.law[switch] == BOUNDED:
        row = p.switches[switch, SWITCH_FIRST]
        p.law[switch], p.x[row] = float(FREE), 0.0
        load = -number(rows, first, sizes, lane, switch, layout.KINETIC_EFFORT) * p.direction[row]
        for i in range(p.free.size):
            p.free[i] += p.S[i, row] * load
    else:
        p.law[switch], p.friction[switch] = float(SLIDES), number(rows, first, sizes, lane, switch, layout.KINETIC)


@apart
def _slips(r: Reactions, switch: int, largest: float) -> bool:
    """Whether what was at rest begins to slide."""
    p, scale = r.problem, 0.0
    end = p.switches[switch, SWITCH_FIRST] + p.switches[switch, SWITCH_ROWS]
    for i in range(end - p.switches[switch, SWITCH_TANGENTS], end):
        scale += p.S[i, i]
    least = SLIGHT * largest * scale
    if p.law[switch] == BOUNDED:  # the acceleration of what nothing can move is rounding
        least = max(least, r.least[end - 1] * p.bound[switch])
    return along(r, switch, p.rates) > least


@apart
def modes(r: Reactions, rows: Rows, first: Workspace, sizes: Sizes, lane: int) -> int:
    """How every switch goes on, to the state; see `complementarity.solve`."""
    p, largest = r.problem, 0.0
    _may_act(r, rows, first, sizes, lane)
    for i in range(sizes.switched):
        if p.S[i, i] > 0.0:
            largest = max(largest, size(p.free[i]) / p.S[i, i])
    for _ in range(2 * sizes.switches + 1):  # what begins to slide has less friction: others may begin, too
        said = solve(p)
        if said != 0:
            return said
        if not _begin(r, rows, first, sizes, lane, largest) and not _settle(
            r, rows, first, sizes, lane, SLIGHT * largest
        ):
            break
    return 0


@apart
def _begin(r: Reactions, rows: Rows, first: Workspace, sizes: Sizes, lane: int, largest: float) -> bool:
    """What was at rest begins to slide, along its acceleration, once everything that begins has its kinetic friction;
    returns whether anything has changed by that."""
    p, less, slid = r.problem, False, False
    for s in range(sizes.switches):
        rests = (p.law[s] == PRESSES or p.law[s] == BOUNDED) and p.switches[s, SWITCH_TANGENTS] > 0
        pressed = p.law[s] == BOUNDED or p.x[p.switches[s, SWITCH_FIRST]] > 0.0
        kinetic = number(rows, first, sizes, lane, s, layout.KINETIC)
        if rests and pressed and p.law[s] == PRESSES and p.friction[s] > kinetic and _slips(r, s, largest):
            p.friction[s], less = kinetic, True
    for s in range(0 if less else sizes.switches):
        rests = (p.law[s] == PRESSES or p.law[s] == BOUNDED) and p.switches[s, SWITCH_TANGENTS] > 0
        pressed = p.law[s] == BOUNDED or p.x[p.switches[s, SWITCH_FIRST]] > 0.0
        if rests and pressed and _slips(r, s, largest):
            _slide(r, rows, first, sizes, lane, s, p.rates, 1.0 / along(r, s, p.rates))
            r.begins[s], slid = AT_ONCE, True
        elif p.law[s] == BOUNDED and _fired(rows, first, sizes, lane, s, layout.SLIDES) and _on_edge(r, s):
            _slide(r, rows, first, sizes, lane, s, p.x, -1.0 / along(r, s, p.x))
            r.begins[s], slid = SMOOTHLY, True
    return less or slid


@apart
def _settle(r: Reactions, rows: Rows, first: Workspace, sizes: Sizes, lane: int, slight: float) -> bool:
    """Modes to the state, from laws, forces and accelerations. What presses, or is held by no others, is closed; what
    rests with all the friction that there may be leans if others hold it. If it has come to that now and none do, it
    has to slide instead: returns whether anything has, which changes forces."""
    p, on, begins = r.problem, first.state + layout.on_row(sizes), False
    before = first.conditions + layout.conditions(sizes) + sizes.events
    opens = first.conditions + sizes.events + layout.OPENS  # minus the force with which the step began
    for s in range(sizes.switches):
        kind, row, bare = p.switches[s, SWITCH_KIND], p.switches[s, SWITCH_FIRST], p.switches[s, SWITCH_TANGENTS] == 0
        how = rows[before + s, lane]
        if kind == FRICTION:
            how = float(STICK) if p.law[s] == BOUNDED else float(SLIDE)
        if kind == UNILATERAL:
            pressed = p.law[s] >= PRESSES and p.rates[row] <= slight * p.S[row, row]
            idle, had = pressed and p.x[row] <= slight, -rows[opens + layout.CONDITIONS * s, lane]
            faint = pressed and p.x[row] <= max(slight, SLIGHT * had)
            pressed = pressed and not (faint and how != OFF and _fired(rows, first, sizes, lane, s, layout.OPENS))
            pressed = pressed and not (idle and _drawn(r, row))
            how = (float(SLIDE) if p.law[s] == SLIDES or bare else float(STICK)) if pressed else float(OFF)
            asked = p.switches[s, layout.SWITCH_SHARES] != 0 and p.x[row] <= slight * SHARING if bare else idle
            if pressed and (asked or (how == STICK and _on_edge(r, s))):
                how = float(LEAN)  # for now, those in question
        rows[on + s, lane] = how
    _want(r, rows, first, sizes, lane)
    for phase in range(PHASES):
        _take(r, float(phase))
    for s in range(sizes.switches):
        row = p.switches[s, SWITCH_FIRST]
        if rows[on + s, lane] == LEAN:
            bare = p.switches[s, SWITCH_TANGENTS] == 0
            idle = bare or p.x[row] <= slight
            held = _held(r, row) if idle else _held(r, row + 1) and _held(r, row + 2)
            if idle:
                slides = bare or p.law[s] == SLIDES
                rows[on + s, lane] = float(OFF) if held else float(SLIDE) if slides else float(STICK)
            elif not held:
                rows[on + s, lane] = float(STICK)
                begins = begins or _fired(rows, first, sizes, lane, s, layout.SLIDES)
    slid = False
    for s in range(sizes.switches):
        row, tangents = p.switches[s, SWITCH_FIRST], p.switches[s, SWITCH_TANGENTS]
        rests = rows[on + s, lane] == STICK and p.law[s] == PRESSES and tangents > 0 and p.x[row] > slight
        if begins and rests and _on_edge(r, s):
            _slide(r, rows, first, sizes, lane, s, p.x, -1.0 / along(r, s, p.x))
            r.begins[s], slid = SMOOTHLY, True
        if rows[on + s, lane] == LEAN:
            for i in range(row + 1, row + 1 + tangents):
                p.direction[i] = -p.x[i] / (p.friction[s] * p.x[row])
        if rows[on + s, lane] >= SLIDE:
            end, speed = row + p.switches[s, SWITCH_ROWS], slow(rows, first, sizes, lane, s)
            for n in range(tangents):
                memory = first.state + layout.memory_row(sizes) + p.switches[s, layout.SWITCH_MEMORY] + n
                rows[memory, lane] = p.direction[end - tangents + n] * (speed if tangents > 1 else 1.0)
            for n in range(tangents, p.switches[s, layout.SWITCH_MEMORIES]):
                memory = p.switches[s, layout.SWITCH_MEMORY] + n
                measured = rows[first.change + layout.border_memory(sizes) + memory, lane]
                rows[first.state + layout.memory_row(sizes) + memory, lane] = measured
    return slid


@apart
def heads(r: Reactions, rows: Rows, first: Workspace, sizes: Sizes, lane: int) -> bool:
    """What begins to slide in a plane gets a speed, below that of rest, along its direction: what rounding has left of
    its speed points anywhere, and where it points back friction would push it on. Impulses that do this, and keep all
    rows in use as they are, to x, with the masks that `choose_rows` left; returns whether there are any. Together
    with what accelerates at once, so that the speeds of one body fit each other."""
    p, some, time, longest = r.problem, False, 0.0, np.inf
    on = first.state + layout.on_row(sizes)
    for s in range(sizes.switches):
        rest, plane = still(rows, first, sizes, lane, s), p.switches[s, SWITCH_TANGENTS] == 2
        some = some or (plane and rows[on + s, lane] == STICK and along(r, s, r.rates) > rest)
        if r.begins[s] != RESTS and plane:
            some, a = True, along(r, s, p.rates)
            if r.begins[s] == AT_ONCE:
                time, longest = max(time, HEADS * rest / a), min(longest, CREEPS * rest / a)
    if not some:
        return False
    for i in range(sizes.switched):
        p.x[i], r.wanted[i], p.free[i] = 0.0, r.taken[i], 0.0
    for s in range(sizes.switches):
        row = p.switches[s, SWITCH_FIRST] + p.switches[s, SWITCH_ROWS] - p.switches[s, SWITCH_TANGENTS]
        if rows[on + s, lane] == STICK and p.switches[s, SWITCH_TANGENTS] == 2:
            for i in range(row, row + 2):
                p.free[i] = -r.rates[i]
        if r.begins[s] != RESTS and p.switches[s, SWITCH_TANGENTS] == 2:
            rest = still(rows, first, sizes, lane, s)
            for i in range(row, row + 2):
                fast = p.rates[i] * min(time, longest) if r.begins[s] == AT_ONCE else CREEPS * rest * p.direction[i]
                r.wanted[i], p.free[i] = 1.0, fast - r.rates[i]
    spread(r)
    return True


@apart
def _drawn(r: Reactions, row: int) -> bool:
    """Whether what begins to slide smoothly, without an acceleration by which it could be told, opens this row."""
    p = r.problem
    for s in range(r.begins.size):
        end, rate = p.switches[s, SWITCH_FIRST] + p.switches[s, SWITCH_ROWS], 0.0
        for i in range(end - p.switches[s, SWITCH_TANGENTS], end):
            rate += p.S[row, i] * p.direction[i]
        if r.begins[s] == SMOOTHLY and rate > 0.0:
            return True
    return False


@inlined
def _held(r: Reactions, row: int) -> bool:
    """Whether rows that are taken say the same as this one."""
    return not r.problem.matrix[row, row] > r.least[row]


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
                if how == LEAN and p.switches[s, SWITCH_ROWS] == 1:
                    normal = float(ASKED)
                across = float(TANGENT) if how == STICK else float(ASKED) if how == LEAN else -1.0
                r.wanted[i] = normal if i == row else across
            if kind == FRICTION and how == STICK:
                r.wanted[i] = float(DRY)


@apart
def choose_rows(r: Reactions, rows: Rows, first: Workspace, sizes: Sizes, lane: int) -> None:
    """Masks of independent rows, to the state: what holds first, then normals without friction, those that press most
    first, then normals that share what they carry, then tangents, then the friction of joints."""
    _want(r, rows, first, sizes, lane)
    for phase in range(PHASES):
        if phase == TANGENT:
            _lift(r, float(BARE))
        _take(r, float(phase))
    _lift(r, float(DRY))
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
            _remove(r, i)
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
        _remove(r, best)


@inlined
def _remove(r: Reactions, row: int) -> None:
    """What a row leaves of the others that are wanted."""
    p = r.problem
    pivot = p.matrix[row, row]
    for i in range(p.free.size):
        if i != row and r.wanted[i] >= 0.0:
            factor = p.matrix[i, row] / pivot
            for j in range(p.free.size):
                p.matrix[i, j] -= factor * p.matrix[row, j]


@apart
def _lift(r: Reactions, phase: float) -> None:
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
