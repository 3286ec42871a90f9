"""How switched constraints go on from a change, of one run: which close, stick or slide, and how sliding begins."""

import numpy as np

from lienumba.compiler.routines.marks import apart, inlined
from lienumba.integrators import layout
from lienumba.integrators.drivers.switching import force_distribution
from lienumba.integrators.drivers.switching.asking import bluntness, may_act, slide, switch_fired
from lienumba.integrators.drivers.switching.complementarity import solve
from lienumba.integrators.drivers.switching.joint_friction import prescribe_redundant_friction
from lienumba.integrators.drivers.switching.problem import BOUNDED, FREE, PRESSES, ROUNDING, SLIDES, SOLVED, size
from lienumba.integrators.drivers.switching.reactions import (
    AT_ONCE,
    SMOOTHLY,
    Reactions,
    along,
    number,
    push,
    slow,
    still,
)
from lienumba.integrators.drivers.switching.used_rows import SHARED, TANGENT, UNKNOWN, held, independent, remove
from lienumba.integrators.drivers.workspace import Rows
from lienumba.integrators.layout import (
    FRICTION,
    OFF,
    SLIDE,
    STICK,
    SWITCH_FIRST,
    SWITCH_GRIP,
    SWITCH_KIND,
    SWITCH_ROWS,
    SWITCH_TANGENTS,
    UNILATERAL,
    Workspace,
)
from lienumba.integrators.sizes import Sizes

SLIGHT = 1e-9  # of the largest force: what slips or leaves by less does not
SHARING = 1e3  # times that: what is left of a force that is none where contacts share
EDGE = 1e-6  # of the most that friction can be
HEADS, CREEPS = 0.01, 0.75  # of `still`: how fast it is made to begin, in the one case and in the other
FOLLOWS = 0.01  # of the fastest slip: what slips slower rests


@inlined
def _on_edge(r: Reactions, switch: int) -> bool:
    """Whether friction is as large as it may be: what begins to slide has no acceleration yet."""
    p = r.problem
    most = p.bound[switch]
    if p.law[switch] != BOUNDED:
        most = p.friction[switch] * p.x[p.switches[switch, SWITCH_FIRST]]
    return along(r, switch, p.x) > (1.0 - EDGE) * most


@inlined
def _begins(r: Reactions, switch: int) -> bool:
    """Whether it begins to slide."""
    return r.begins[switch] == AT_ONCE or r.begins[switch] == SMOOTHLY


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


@inlined
def _stays(r: Reactions, switch: int, largest: float) -> bool:
    """Whether what rests is held, or stays closed though nothing presses: then it has no friction, and slides."""
    p, row = r.problem, r.problem.switches[switch, SWITCH_FIRST]
    return p.law[switch] == BOUNDED or p.x[row] > 0.0 or p.rates[row] <= SLIGHT * largest * p.S[row, row]


@apart
def decide(r: Reactions, rows: Rows, first: Workspace, sizes: Sizes, lane: int) -> int:
    """How every switch goes on, to the state; see `complementarity`."""
    p, largest = r.problem, 0.0
    may_act(r, rows, first, sizes, lane, True)
    for i in range(sizes.switched):
        if p.S[i, i] > 0.0:
            largest = max(largest, size(p.free[i]) / p.S[i, i])
    for s in range(sizes.switches):
        largest = max(largest, ROUNDING / SLIGHT * p.least[s])
    for _ in range(2 * sizes.switches + 1):  # what begins to slide has less friction: others may begin, too
        said = solve(p)
        if said != SOLVED:
            return said
        prescribe_redundant_friction(r, largest)
        if not _begin(r, rows, first, sizes, lane, largest) and not _settle(
            r, rows, first, sizes, lane, SLIGHT * largest
        ):
            break
    return SOLVED


@inlined
def _static(r: Reactions, rows: Rows, first: Workspace, sizes: Sizes, lane: int, switch: int, static: bool) -> None:
    """A switch that rests has its static friction, or its kinetic one."""
    p = r.problem
    if p.law[switch] == BOUNDED:
        effort = layout.STATIC_EFFORT if static else layout.KINETIC_EFFORT
        p.bound[switch] = number(rows, first, sizes, lane, switch, effort)
    else:
        p.friction[switch] = number(rows, first, sizes, lane, switch, layout.STATIC if static else layout.KINETIC)


@apart
def _stay(r: Reactions, rows: Rows, first: Workspace, sizes: Sizes, lane: int, largest: float) -> bool:
    """Of what has kinetic friction since it slipped beside others some may rest with these slipping, of which one is
    found; returns whether it is."""
    p, many = r.problem, 0
    for s in range(sizes.switches):
        many += 1 if _is_eased(r, rows, first, sizes, lane, s) and _slips(r, s, largest) else 0
    for s in range(sizes.switches if many > 1 else 0):
        if _is_eased(r, rows, first, sizes, lane, s) and _slips(r, s, largest):
            _static(r, rows, first, sizes, lane, s, True)
            if solve(p) == SOLVED and not _slips(r, s, largest):
                return True
            _static(r, rows, first, sizes, lane, s, False)
            solve(p)
    return False


@inlined
def _is_eased(r: Reactions, rows: Rows, first: Workspace, sizes: Sizes, lane: int, switch: int) -> bool:
    """Whether what rests has less friction than its static one."""
    p, now, static = r.problem, 0.0, 0.0
    if p.law[switch] == BOUNDED:
        now, static = p.bound[switch], number(rows, first, sizes, lane, switch, layout.STATIC_EFFORT)
    if p.law[switch] == PRESSES and p.switches[switch, SWITCH_TANGENTS] > 0:
        now, static = p.friction[switch], number(rows, first, sizes, lane, switch, layout.STATIC)
    return now < static


@apart
def _begin(r: Reactions, rows: Rows, first: Workspace, sizes: Sizes, lane: int, largest: float) -> bool:
    """What was at rest begins to slide, along its acceleration, once everything that begins has its kinetic friction;
    returns whether anything has changed by that."""
    p, less, slid = r.problem, False, False
    for s in range(sizes.switches):
        rests = (p.law[s] == PRESSES or p.law[s] == BOUNDED) and p.switches[s, SWITCH_TANGENTS] > 0
        if rests and _stays(r, s, largest) and _slips(r, s, largest):
            kinetic = number(rows, first, sizes, lane, s, layout.KINETIC)
            effort = number(rows, first, sizes, lane, s, layout.KINETIC_EFFORT)
            if p.law[s] == PRESSES and p.friction[s] > kinetic:
                p.friction[s], less = kinetic, True
            if p.law[s] == BOUNDED and p.bound[s] > effort:
                p.bound[s], less = effort, True
    if not less and _stay(r, rows, first, sizes, lane, largest):
        return True
    for s in range(0 if less else sizes.switches):
        rests = (p.law[s] == PRESSES or p.law[s] == BOUNDED) and p.switches[s, SWITCH_TANGENTS] > 0
        pressed = _stays(r, s, largest)
        if rests and pressed and _slips(r, s, largest):
            slide(r, rows, first, sizes, lane, s, p.rates, 1.0 / along(r, s, p.rates))
            r.begins[s], slid = AT_ONCE, True
        elif p.law[s] == BOUNDED and switch_fired(rows, first, sizes, lane, s, layout.SLIDES) and _on_edge(r, s):
            slide(r, rows, first, sizes, lane, s, p.x, -1.0 / along(r, s, p.x))
            r.begins[s], slid = SMOOTHLY, True
    return less or slid


@apart
def _settle(r: Reactions, rows: Rows, first: Workspace, sizes: Sizes, lane: int, slight: float) -> bool:
    """Modes to the state, from laws, forces and accelerations. What presses, or is held by no others, is closed; how
    what rests shares what holds it is found anew. Where that is no more possible, what rested slips: returns whether
    anything does, which changes forces."""
    p, on, asks = r.problem, first.state + layout.on_row(sizes), False
    before = first.conditions + layout.conditions(sizes) + sizes.events
    pulls = first.conditions + sizes.events + layout.OPENS  # minus the force with which the step began
    parts = False  # with what lets go all does whose force has fallen to nothing, and what has let go does not return
    lends, left, least = False, False, slight
    for s in range(sizes.switches):
        parts = parts or switch_fired(rows, first, sizes, lane, s, layout.OPENS)
        lends = lends or r.lent[s] != 0.0
    if lends:  # the way to where nothing holds is halved each time, and has an end
        least = EDGE / SLIGHT * slight
    for s in range(sizes.switches):
        kind, row, bare = p.switches[s, SWITCH_KIND], p.switches[s, SWITCH_FIRST], p.switches[s, SWITCH_TANGENTS] == 0
        how = rows[before + s, lane]
        if kind == FRICTION:
            how = float(STICK) if p.law[s] == BOUNDED else float(SLIDE)
            memory = first.state + layout.memory_row(sizes) + p.switches[s, layout.SWITCH_MEMORY]
            rows[memory, lane] = -p.x[row] if how == STICK and r.lent[s] != 0.0 else 0.0
        if kind == UNILATERAL:
            pressed = p.law[s] >= PRESSES and p.rates[row] <= slight * p.S[row, row]
            idle, had = pressed and p.x[row] <= slight, -rows[pulls + layout.CONDITIONS * s, lane]
            faint = pressed and p.x[row] <= max(least, SLIGHT * had)
            falls = switch_fired(rows, first, sizes, lane, s, layout.OPENS) or (parts and p.x[row] <= SLIGHT * had)
            pressed = pressed and not (faint and how != OFF and falls) and not (idle and how == OFF and parts)
            pressed = pressed and not (idle and (_drawn(r, row) or _is_held_dry(r, row)))
            if lends and p.law[s] >= PRESSES and not pressed:  # what it left to loads is asked again without it
                p.law[s], left = float(FREE), True
                for i in range(row, row + p.switches[s, SWITCH_ROWS]):
                    p.x[i] = 0.0
            how = (float(SLIDE) if p.law[s] == SLIDES or bare else float(STICK)) if pressed else float(OFF)
            asked = p.switches[s, layout.SWITCH_SHARES] != 0 and p.x[row] <= slight * SHARING if bare else idle
            if pressed and asked:
                how, asks = UNKNOWN, True
        rows[on + s, lane] = how
    if asks:
        independent(r, rows, first, sizes, lane)
    for s in range(sizes.switches):
        if rows[on + s, lane] == UNKNOWN:
            slides = p.switches[s, SWITCH_TANGENTS] == 0 or p.law[s] == SLIDES
            opens = held(r, p.switches[s, SWITCH_FIRST])
            rows[on + s, lane] = float(OFF) if opens else float(SLIDE) if slides else float(STICK)
    slid = _grip(r, rows, first, sizes, lane, slight)
    for s in range(sizes.switches):
        row, tangents = p.switches[s, SWITCH_FIRST], p.switches[s, SWITCH_TANGENTS]
        goes_on = rows[before + s, lane] == SLIDE and not _begins(r, s)
        blunt = bluntness(r, rows, first, sizes, lane, s) if goes_on else 0.0
        turned = switch_fired(rows, first, sizes, lane, s, layout.SLIDES)
        if rows[on + s, lane] >= SLIDE and (blunt == 0.0 or turned):
            end, speed = row + p.switches[s, SWITCH_ROWS], max(blunt, slow(rows, first, sizes, lane, s))
            for n in range(tangents):
                memory = first.state + layout.memory_row(sizes) + p.switches[s, layout.SWITCH_MEMORY] + n
                rows[memory, lane] = p.direction[end - tangents + n] * (speed if tangents > 1 else 1.0)
            for n in range(tangents, p.switches[s, layout.SWITCH_MEMORIES]):
                memory = p.switches[s, layout.SWITCH_MEMORY] + n
                measured = rows[first.change + layout.border_memory(sizes) + memory, lane]
                rows[first.state + layout.memory_row(sizes) + memory, lane] = measured
            if p.switches[s, SWITCH_GRIP] >= 0 and _begins(r, s):  # with what is faster, so it may be slow
                rows[first.state + layout.memory_row(sizes) + p.switches[s, SWITCH_GRIP] + 2, lane] = 0.0
    return slid or left


@apart
def _lean(r: Reactions, rows: Rows, first: Workspace, sizes: Sizes, lane: int, group: float) -> None:
    """Choose rows that are independent; which of the contacts' of a group carry, and what else that is used leaves of
    S."""
    p, g = r.problem, r.grips
    independent(r, rows, first, sizes, lane)
    for i in range(sizes.switched):
        carries = g.group[i] == group and (r.wanted[i] == SHARED or r.wanted[i] == TANGENT)
        g.carries[i] = 1.0 if carries else 0.0
        for j in range(sizes.switched):
            p.matrix[i, j] = p.S[i, j]
    for i in range(sizes.switched):
        if r.taken[i] != 0.0 and g.carries[i] == 0.0 and g.group[i] == group:
            remove(r, i)


@apart
def _grip(r: Reactions, rows: Rows, first: Workspace, sizes: Sizes, lane: int, slight: float) -> bool:
    """How contacts that rest share what holds them, to their memory. Where one of them has all the friction that it may
    have, and no others are left to hold it, what slips begins to slide; returns whether anything does."""
    p, g, on, limit, slid = r.problem, r.grips, first.state + layout.on_row(sizes), False, False
    before = first.conditions + layout.conditions(sizes) + sizes.events
    for s in range(sizes.switches):
        g.static[s] = number(rows, first, sizes, lane, s, layout.STATIC)
        rested = rows[on + s, lane] == STICK and p.law[s] == PRESSES and rows[before + s, lane] == STICK
        limit = limit or (rested and switch_fired(rows, first, sizes, lane, s, layout.SLIDES))
    force_distribution.part(p, g)
    for row in range(sizes.switched):
        if g.group[row] == float(row):
            slid = _grip_together(r, rows, first, sizes, lane, slight, float(row), limit) or slid
    return slid


@inlined
def _edge(r: Reactions, rows: Rows, first: Workspace, sizes: Sizes, lane: int, switch: int) -> float:
    """The motion beyond which contacts that share are at their limits: less where this one was next to its own when
    all was decided last, and has come to it. Nearer than that its forces in a step are rounding."""
    p, edge = r.problem, force_distribution.AT_EDGE
    if switch_fired(rows, first, sizes, lane, switch, layout.SLIDES) and force_distribution.has_grip(
        p, r.grips, switch
    ):
        grip = first.state + layout.memory_row(sizes) + p.switches[switch, SWITCH_GRIP]
        rest = 1.0 - rows[grip, lane] * rows[grip, lane] - rows[grip + 1, lane] * rows[grip + 1, lane]
        if rest * force_distribution.NEXT_TO_EDGE * force_distribution.NEXT_TO_EDGE < 1.0:
            edge = 0.5 * force_distribution.NEXT_TO_EDGE
    return edge


@inlined
def _pace(r: Reactions, switch: int, slight: float, shared: bool, scale: float, fastest: float, edge: float) -> float:
    """How fast what has come to its limit slips, in parts of the fastest that slips with it; 0 where it does not."""
    p, row = r.problem, r.problem.switches[switch, SWITCH_FIRST]
    if p.switches[switch, SWITCH_TANGENTS] == 0 or not p.x[row] > slight:
        return 0.0
    if shared and force_distribution.has_grip(p, r.grips, switch):
        return along(r, switch, r.grips.z) / (scale * fastest) if fastest > edge else 0.0
    return 1.0 if _on_edge(r, switch) else 0.0


@apart
def _grip_together(
    r: Reactions, rows: Rows, first: Workspace, sizes: Sizes, lane: int, slight: float, group: float, limit: bool
) -> bool:
    """The same of one group of them; limit: whether any contact has come to all that it may hold."""
    p, g, on, slid = r.problem, r.grips, first.state + layout.on_row(sizes), False
    some, shared, fastest, scale, edge = False, False, 0.0, 0.0, force_distribution.AT_EDGE
    for s in range(sizes.switches):
        rests = g.group[p.switches[s, SWITCH_FIRST]] == group and rows[on + s, lane] == STICK and p.law[s] == PRESSES
        some = some or (rests and p.switches[s, SWITCH_GRIP] >= 0)
    for i in range(sizes.switched):
        g.carries[i] = 0.0
    if some:
        _lean(r, rows, first, sizes, lane, group)
        shared = force_distribution.depend(p, g, r.taken)
    if shared:
        fastest, scale = force_distribution.find(p, g, r.taken)
        for s in range(sizes.switches):
            edge = min(edge, _edge(r, rows, first, sizes, lane, s))
    less = False
    for s in range(sizes.switches if limit else 0):  # what slips with less friction does so with an acceleration
        kinetic = number(rows, first, sizes, lane, s, layout.KINETIC)
        rests = g.group[p.switches[s, SWITCH_FIRST]] == group and rows[on + s, lane] == STICK and p.law[s] == PRESSES
        if rests and p.friction[s] > kinetic and _pace(r, s, slight, shared, scale, fastest, edge) > FOLLOWS:
            p.friction[s], less = kinetic, True
    for s in range(sizes.switches):
        row, own = p.switches[s, SWITCH_FIRST], force_distribution.has_grip(p, g, s)
        rests = g.group[row] == group and rows[on + s, lane] == STICK and p.law[s] == PRESSES
        pace = _pace(r, s, slight, shared, scale, fastest, edge) if rests and limit and not less else 0.0
        if pace > FOLLOWS:
            for i in range(row + 1, row + 3 if shared and own else row + 1):
                p.x[i] = g.forces[i]
            slide(r, rows, first, sizes, lane, s, p.x, -1.0 / along(r, s, p.x))
            r.begins[s], r.paces[s], slid = SMOOTHLY, pace, True
        if own:
            c, d, u, v, w = 0.0, 0.0, 0.0, 0.0, 1.0
            if shared and scale > 0.0:
                c, d, u, v, w = force_distribution.kept(p, g, s, scale)
            memory = first.state + layout.memory_row(sizes)
            start, grip = memory + p.switches[s, layout.SWITCH_MEMORY], memory + p.switches[s, SWITCH_GRIP]
            rows[start, lane], rows[start + 1, lane] = c, d
            rows[grip, lane], rows[grip + 1, lane], rows[grip + 2, lane] = u, v, w
            for i in range(start + 2, grip):
                rows[i, lane] = rows[first.change + layout.border_memory(sizes) + i - memory, lane]
    return slid or less


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
        if _begins(r, s) and plane:
            some, a = True, along(r, s, p.rates)
            if r.begins[s] == AT_ONCE:
                time, longest = max(time, HEADS * rest / a), min(longest, CREEPS * rest / a)
    if not some:
        return False
    for i in range(sizes.switched):
        r.wanted[i], p.free[i] = r.taken[i], 0.0
    for s in range(sizes.switches):
        row = p.switches[s, SWITCH_FIRST] + p.switches[s, SWITCH_ROWS] - p.switches[s, SWITCH_TANGENTS]
        if rows[on + s, lane] == STICK and p.switches[s, SWITCH_TANGENTS] == 2:
            for i in range(row, row + 2):
                p.free[i] = -r.rates[i]
        if _begins(r, s) and p.switches[s, SWITCH_TANGENTS] == 2:
            rest = still(rows, first, sizes, lane, s)
            for i in range(row, row + 2):
                fast = CREEPS * rest * r.paces[s] * p.direction[i]
                fast = p.rates[i] * min(time, longest) if r.begins[s] == AT_ONCE else fast
                r.wanted[i], p.free[i] = 1.0, fast - r.rates[i]
    push(r, rows, first, sizes, lane)
    return True


@apart
def limit_friction_stiffness(r: Reactions, rows: Rows, first: Workspace, sizes: Sizes, lane: int, step: float) -> None:
    """Set the speed below which friction turns with the direction that was kept. What slides across its direction at w
    is brought back at a rate of `sum |S_ij| mu_j N_j / w` at most, which explicit steps of given length can follow
    where it is below 1/step."""
    p, on, memory = r.problem, first.state + layout.on_row(sizes), first.state + layout.memory_row(sizes)
    for s in range(sizes.switches):
        row, rate = p.switches[s, SWITCH_FIRST], 0.0
        if rows[on + s, lane] != SLIDE or p.switches[s, SWITCH_TANGENTS] < 2:
            continue
        for other in range(sizes.switches):
            i = p.switches[other, SWITCH_FIRST]
            if rows[on + other, lane] == SLIDE and p.switches[other, SWITCH_TANGENTS] == 2:
                a, b, c, d = -p.direction[row + 2], p.direction[row + 1], -p.direction[i + 2], p.direction[i + 1]
                across = a * (p.S[row + 1, i + 1] * c + p.S[row + 1, i + 2] * d)
                across += b * (p.S[row + 2, i + 1] * c + p.S[row + 2, i + 2] * d)
                rate += size(across) * p.friction[other] * max(p.x[i], 0.0)
        speed = max(slow(rows, first, sizes, lane, s), step * rate)
        for n in range(2):
            rows[memory + p.switches[s, layout.SWITCH_MEMORY] + n, lane] = speed * p.direction[row + 1 + n]


@apart
def _is_held_dry(r: Reactions, row: int) -> bool:
    """Whether friction of joints that sticks may hold what touches along a row."""
    p, some = r.problem, False
    for s in range(r.begins.size):
        some = some or (p.law[s] == BOUNDED and p.S[row, p.switches[s, SWITCH_FIRST]] != 0.0)
    return some


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
