"""The modes of one run after a change: which contacts are closed, stick or slide, and how sliding begins."""

import numpy as np

from lienumba.compiler.routines.marks import apart, inlined
from lienumba.integrators import layout
from lienumba.integrators.drivers.switching import force_distribution
from lienumba.integrators.drivers.switching.complementarity import solve
from lienumba.integrators.drivers.switching.contact_laws import (
    friction_speed,
    has_turned,
    set_laws,
    slide,
    switch_fired,
)
from lienumba.integrators.drivers.switching.independent_rows import (
    NORMAL_ROW,
    TANGENT_ROW,
    UNKNOWN,
    held,
    independent,
    remove,
)
from lienumba.integrators.drivers.switching.joint_friction import prescribe_redundant_friction
from lienumba.integrators.drivers.switching.problem import BOUNDED, FREE, PRESSES, ROUNDING, SLIDES, SOLVED, size
from lienumba.integrators.drivers.switching.reactions import (
    AT_ONCE,
    SMOOTHLY,
    Reactions,
    along,
    find_impulses,
    number,
    slow,
    still,
)
from lienumba.integrators.drivers.workspace import Rows
from lienumba.integrators.layout import (
    FRICTION,
    OFF,
    SLIDE,
    STICK,
    SWITCH_COMPLIANCE,
    SWITCH_FIRST,
    SWITCH_KIND,
    SWITCH_ROWS,
    SWITCH_TANGENTS,
    UNILATERAL,
    Workspace,
)
from lienumba.integrators.sizes import Sizes

FORCE_RTOL = 1e-9  # of the largest force: what slips or leaves by less does not
REDUNDANT_SAFETY = 1e3  # times that: what is left of a force that is none where contacts share
LIMIT_RTOL = 1e-6  # of the most that friction can be
SLIP_SEED, CREEP_SPEED = 0.01, 0.75  # of `still`: how fast it is made to begin, in the one case and in the other
SLIP_RATIO = 0.01  # of the fastest slip: what slips slower rests


@inlined
def _is_at_limit(r: Reactions, switch: int) -> bool:
    """Return whether friction is at its limit: sliding may begin without acceleration."""
    p = r.problem
    most = p.bound[switch]
    if p.law[switch] != BOUNDED:
        most = p.friction[switch] * p.x[p.switches[switch, SWITCH_FIRST]]
    return along(r, switch, p.x) > (1.0 - LIMIT_RTOL) * most


@inlined
def _begins(r: Reactions, switch: int) -> bool:
    """Return whether a switch begins to slide."""
    return r.begins[switch] == AT_ONCE or r.begins[switch] == SMOOTHLY


@apart
def _slips(r: Reactions, switch: int, largest: float) -> bool:
    """Return whether a switch that was at rest accelerates along its tangents."""
    p, scale = r.problem, 0.0
    end = p.switches[switch, SWITCH_FIRST] + p.switches[switch, SWITCH_ROWS]
    for i in range(end - p.switches[switch, SWITCH_TANGENTS], end):
        scale += p.S[i, i]
    least = FORCE_RTOL * largest * scale
    if p.law[switch] == BOUNDED:  # the acceleration of what nothing can move is rounding
        least = max(least, r.least[end - 1] * p.bound[switch])
    return along(r, switch, p.rates) > least


@inlined
def _is_held(r: Reactions, switch: int, largest: float) -> bool:
    """Return whether a switch stays closed: an unloaded contact that does has no friction, and slides."""
    p, row = r.problem, r.problem.switches[switch, SWITCH_FIRST]
    return p.law[switch] == BOUNDED or p.x[row] > 0.0 or p.rates[row] <= FORCE_RTOL * largest * p.S[row, row]


@apart
def decide(r: Reactions, rows: Rows, first: Workspace, sizes: Sizes, lane: int) -> int:
    """Decide the mode of every switch, to the state; see `complementarity`."""
    p, largest = r.problem, 0.0
    set_laws(r, rows, first, sizes, lane, True)
    for i in range(sizes.switched):
        if p.S[i, i] > 0.0:
            largest = max(largest, size(p.free[i]) / p.S[i, i])
    for s in range(sizes.switches):
        largest = max(largest, ROUNDING / FORCE_RTOL * p.least[s])
    for _ in range(2 * sizes.switches + 1):  # kinetic friction of one may let others begin to slide
        status = solve(p)
        if status != SOLVED:
            return status
        prescribe_redundant_friction(r, largest)
        if not _begin(r, rows, first, sizes, lane, largest) and not _assign_modes(
            r, rows, first, sizes, lane, FORCE_RTOL * largest
        ):
            break
    return SOLVED


@inlined
def _set_friction(
    r: Reactions, rows: Rows, first: Workspace, sizes: Sizes, lane: int, switch: int, static: bool
) -> None:
    """Give a switch that rests its static or its kinetic friction."""
    p = r.problem
    if p.law[switch] == BOUNDED:
        effort = layout.STATIC_EFFORT if static else layout.KINETIC_EFFORT
        p.bound[switch] = number(rows, first, sizes, lane, switch, effort)
    else:
        p.friction[switch] = number(rows, first, sizes, lane, switch, layout.STATIC if static else layout.KINETIC)


@apart
def _let_one_stick(r: Reactions, rows: Rows, first: Workspace, sizes: Sizes, lane: int, largest: float) -> bool:
    """Find one switch that slips with its kinetic friction and sticks with its static one; return whether there is one.
    It got kinetic friction since it slipped together with others."""
    p, many = r.problem, 0
    for s in range(sizes.switches):
        many += 1 if _has_kinetic_friction(r, rows, first, sizes, lane, s) and _slips(r, s, largest) else 0
    for s in range(sizes.switches if many > 1 else 0):
        if _has_kinetic_friction(r, rows, first, sizes, lane, s) and _slips(r, s, largest):
            _set_friction(r, rows, first, sizes, lane, s, True)
            if solve(p) == SOLVED and not _slips(r, s, largest):
                return True
            _set_friction(r, rows, first, sizes, lane, s, False)
            solve(p)
    return False


@inlined
def _has_kinetic_friction(r: Reactions, rows: Rows, first: Workspace, sizes: Sizes, lane: int, switch: int) -> bool:
    """Return whether a switch that rests has less than its static friction."""
    p, now, static = r.problem, 0.0, 0.0
    if p.law[switch] == BOUNDED:
        now, static = p.bound[switch], number(rows, first, sizes, lane, switch, layout.STATIC_EFFORT)
    if p.law[switch] == PRESSES and p.switches[switch, SWITCH_TANGENTS] > 0:
        now, static = p.friction[switch], number(rows, first, sizes, lane, switch, layout.STATIC)
    return now < static


@apart
def _begin(r: Reactions, rows: Rows, first: Workspace, sizes: Sizes, lane: int, largest: float) -> bool:
    """Let switches begin to slide along their accelerations, once all that slip have kinetic friction; return whether
    anything has changed."""
    p, less, slid = r.problem, False, False
    for s in range(sizes.switches):
        rests = (p.law[s] == PRESSES or p.law[s] == BOUNDED) and p.switches[s, SWITCH_TANGENTS] > 0
        if rests and _is_held(r, s, largest) and _slips(r, s, largest):
            kinetic = number(rows, first, sizes, lane, s, layout.KINETIC)
            effort = number(rows, first, sizes, lane, s, layout.KINETIC_EFFORT)
            if p.law[s] == PRESSES and p.friction[s] > kinetic:
                p.friction[s], less = kinetic, True
            if p.law[s] == BOUNDED and p.bound[s] > effort:
                p.bound[s], less = effort, True
    if not less and _let_one_stick(r, rows, first, sizes, lane, largest):
        return True
    for s in range(0 if less else sizes.switches):
        rests = (p.law[s] == PRESSES or p.law[s] == BOUNDED) and p.switches[s, SWITCH_TANGENTS] > 0
        pressed = _is_held(r, s, largest)
        if rests and pressed and _slips(r, s, largest):
            slide(r, rows, first, sizes, lane, s, p.rates, 1.0 / along(r, s, p.rates))
            r.begins[s], slid = AT_ONCE, True
        elif p.law[s] == BOUNDED and switch_fired(rows, first, sizes, lane, s, layout.SLIDES) and _is_at_limit(r, s):
            slide(r, rows, first, sizes, lane, s, p.x, -1.0 / along(r, s, p.x))
            r.begins[s], slid = SMOOTHLY, True
    return less or slid


@apart
def _assign_modes(r: Reactions, rows: Rows, first: Workspace, sizes: Sizes, lane: int, slight: float) -> bool:
    """Assign modes from laws, forces and accelerations, and write them to the state. A contact is closed where it
    presses, or where no other rows hold it. Distribute redundant forces anew; contacts at their limits begin to slide.
    Return whether that changes forces."""
    p, on, asks = r.problem, first.state + layout.on_row(sizes), False
    before = first.conditions + layout.conditions(sizes) + sizes.events
    pulls = first.conditions + sizes.events + layout.OPENS  # minus the force at the start of the step
    parts = False  # if one contact opens, so do all whose force is zero, and open ones do not close
    prescribes, left, least = False, False, slight
    for s in range(sizes.switches):
        parts = parts or switch_fired(rows, first, sizes, lane, s, layout.OPENS)
        prescribes = prescribes or r.prescribed[s] != 0.0
    if prescribes:  # each redistribution shortens the way to the limit load by a factor: an end
        least = LIMIT_RTOL / FORCE_RTOL * slight
    for s in range(sizes.switches):
        kind, row, bare = p.switches[s, SWITCH_KIND], p.switches[s, SWITCH_FIRST], p.switches[s, SWITCH_TANGENTS] == 0
        how = rows[before + s, lane]
        if kind == FRICTION:
            how = float(STICK) if p.law[s] == BOUNDED else float(SLIDE)
            memory = first.state + layout.memory_row(sizes) + p.switches[s, layout.SWITCH_MEMORY]
            rows[memory, lane] = -p.x[row] if how == STICK and r.prescribed[s] != 0.0 else 0.0
        if kind == UNILATERAL:
            pressed = p.law[s] >= PRESSES and p.rates[row] <= slight * p.S[row, row]
            idle, had = pressed and p.x[row] <= slight, -rows[pulls + layout.CONDITIONS * s, lane]
            faint = pressed and p.x[row] <= max(least, FORCE_RTOL * had)
            falls = switch_fired(rows, first, sizes, lane, s, layout.OPENS) or (parts and p.x[row] <= FORCE_RTOL * had)
            pressed = pressed and not (faint and how != OFF and falls) and not (idle and how == OFF and parts)
            pressed = pressed and not (idle and (_is_opened_by_slip(r, row) or _is_held_by_joint_friction(r, row)))
            if prescribes and p.law[s] >= PRESSES and not pressed:  # solve again without it
                p.law[s], left = float(FREE), True
                for i in range(row, row + p.switches[s, SWITCH_ROWS]):
                    p.x[i] = 0.0
            how = (float(SLIDE) if p.law[s] == SLIDES or bare else float(STICK)) if pressed else float(OFF)
            asked = p.switches[s, layout.SWITCH_SHARES] != 0 and p.x[row] <= slight * REDUNDANT_SAFETY if bare else idle
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
    slid = _update_distribution(r, rows, first, sizes, lane, slight)
    for s in range(sizes.switches):
        row, tangents = p.switches[s, SWITCH_FIRST], p.switches[s, SWITCH_TANGENTS]
        goes_on = rows[before + s, lane] == SLIDE and not _begins(r, s)
        least_speed = friction_speed(r, rows, first, sizes, lane, s) if goes_on else 0.0
        if rows[on + s, lane] >= SLIDE and (least_speed == 0.0 or has_turned(r, rows, first, sizes, lane, s)):
            end, speed = row + p.switches[s, SWITCH_ROWS], max(least_speed, slow(rows, first, sizes, lane, s))
            for n in range(tangents):
                memory = first.state + layout.memory_row(sizes) + p.switches[s, layout.SWITCH_MEMORY] + n
                rows[memory, lane] = p.direction[end - tangents + n] * (speed if tangents > 1 else 1.0)
            for n in range(tangents, p.switches[s, layout.SWITCH_MEMORIES]):
                memory = p.switches[s, layout.SWITCH_MEMORY] + n
                measured = rows[first.change + layout.border_memory(sizes) + memory, lane]
                rows[first.state + layout.memory_row(sizes) + memory, lane] = measured
            if p.switches[s, SWITCH_COMPLIANCE] >= 0 and _begins(r, s):  # with what is faster, so it may be slow
                rows[first.state + layout.memory_row(sizes) + p.switches[s, SWITCH_COMPLIANCE] + 2, lane] = 0.0
    return slid or left


@apart
def _find_redundant_rows(r: Reactions, rows: Rows, first: Workspace, sizes: Sizes, lane: int, group: float) -> None:
    """Choose independent rows, and which rows of a group of contacts carry forces; eliminate all others from S."""
    p, g = r.problem, r.distribution
    independent(r, rows, first, sizes, lane)
    for i in range(sizes.switched):
        carries = g.group[i] == group and (r.wanted[i] == NORMAL_ROW or r.wanted[i] == TANGENT_ROW)
        g.carries[i] = 1.0 if carries else 0.0
        for j in range(sizes.switched):
            p.matrix[i, j] = p.S[i, j]
    for i in range(sizes.switched):
        if r.taken[i] != 0.0 and g.carries[i] == 0.0 and g.group[i] == group:
            remove(r, i)


@apart
def _update_distribution(r: Reactions, rows: Rows, first: Workspace, sizes: Sizes, lane: int, slight: float) -> bool:
    """Distribute the forces of redundant contacts at rest, and write the distribution to their memory. Contacts begin
    to slide where all that could hold them are at their limits; return whether any does."""
    p, g, on, limit, slid = r.problem, r.distribution, first.state + layout.on_row(sizes), False, False
    before = first.conditions + layout.conditions(sizes) + sizes.events
    for s in range(sizes.switches):
        g.static[s] = number(rows, first, sizes, lane, s, layout.STATIC)
        rested = rows[on + s, lane] == STICK and p.law[s] == PRESSES and rows[before + s, lane] == STICK
        limit = limit or (rested and switch_fired(rows, first, sizes, lane, s, layout.SLIDES))
    force_distribution.part(p, g)
    for row in range(sizes.switched):
        if g.group[row] == float(row):
            slid = _update_contact_group(r, rows, first, sizes, lane, slight, float(row), limit) or slid
    return slid


@inlined
def _edge(r: Reactions, rows: Rows, first: Workspace, sizes: Sizes, lane: int, switch: int) -> float:
    """Return the motion u beyond which redundant contacts count as at their limits. It is smaller for a contact that
    was next to its limit at the change before, and has reached it: in a step its forces are then roundoff."""
    p, edge = r.problem, force_distribution.AT_EDGE
    if switch_fired(rows, first, sizes, lane, switch, layout.SLIDES) and force_distribution.has_friction(
        p, r.distribution, switch
    ):
        grip = first.state + layout.memory_row(sizes) + p.switches[switch, SWITCH_COMPLIANCE]
        rest = 1.0 - rows[grip, lane] * rows[grip, lane] - rows[grip + 1, lane] * rows[grip + 1, lane]
        if rest * force_distribution.NEXT_TO_EDGE * force_distribution.NEXT_TO_EDGE < 1.0:
            edge = 0.5 * force_distribution.NEXT_TO_EDGE
    return edge


@inlined
def _slip_ratio(
    r: Reactions, switch: int, slight: float, shared: bool, scale: float, fastest: float, edge: float
) -> float:
    """Return the slip speed of a contact at its limit over that of the fastest in its group; 0 where it sticks."""
    p, row = r.problem, r.problem.switches[switch, SWITCH_FIRST]
    if p.switches[switch, SWITCH_TANGENTS] == 0 or not p.x[row] > slight:
        return 0.0
    if shared and force_distribution.has_friction(p, r.distribution, switch):
        return along(r, switch, r.distribution.z) / (scale * fastest) if fastest > edge else 0.0
    return 1.0 if _is_at_limit(r, switch) else 0.0


@apart
def _update_contact_group(
    r: Reactions, rows: Rows, first: Workspace, sizes: Sizes, lane: int, slight: float, group: float, limit: bool
) -> bool:
    """Update the distribution of one group; limit: whether any contact has reached its limit."""
    p, g, on, slid = r.problem, r.distribution, first.state + layout.on_row(sizes), False
    some, shared, fastest, scale, edge = False, False, 0.0, 0.0, force_distribution.AT_EDGE
    for s in range(sizes.switches):
        rests = g.group[p.switches[s, SWITCH_FIRST]] == group and rows[on + s, lane] == STICK and p.law[s] == PRESSES
        some = some or (rests and p.switches[s, SWITCH_COMPLIANCE] >= 0)
    for i in range(sizes.switched):
        g.carries[i] = 0.0
    if some:
        _find_redundant_rows(r, rows, first, sizes, lane, group)
        shared = force_distribution.find_dependence(p, g, r.taken)
    if shared:
        fastest, scale = force_distribution.find(p, g, r.taken)
        for s in range(sizes.switches):
            edge = min(edge, _edge(r, rows, first, sizes, lane, s))
    less = False
    for s in range(sizes.switches if limit else 0):  # with less kinetic friction slip begins with an acceleration
        kinetic = number(rows, first, sizes, lane, s, layout.KINETIC)
        rests = g.group[p.switches[s, SWITCH_FIRST]] == group and rows[on + s, lane] == STICK and p.law[s] == PRESSES
        if rests and p.friction[s] > kinetic and _slip_ratio(r, s, slight, shared, scale, fastest, edge) > SLIP_RATIO:
            p.friction[s], less = kinetic, True
    for s in range(sizes.switches):
        row, own = p.switches[s, SWITCH_FIRST], force_distribution.has_friction(p, g, s)
        rests = g.group[row] == group and rows[on + s, lane] == STICK and p.law[s] == PRESSES
        slip_ratio = _slip_ratio(r, s, slight, shared, scale, fastest, edge) if rests and limit and not less else 0.0
        if slip_ratio > SLIP_RATIO:
            for i in range(row + 1, row + 3 if shared and own else row + 1):
                p.x[i] = g.forces[i]
            slide(r, rows, first, sizes, lane, s, p.x, -1.0 / along(r, s, p.x))
            r.begins[s], r.slip_ratios[s], slid = SMOOTHLY, slip_ratio, True
        if own:
            c, d, u, v, w = 0.0, 0.0, 0.0, 0.0, 1.0
            if shared and scale > 0.0:
                c, d, u, v, w = force_distribution.kept(p, g, s, scale)
            memory = first.state + layout.memory_row(sizes)
            start, grip = memory + p.switches[s, layout.SWITCH_MEMORY], memory + p.switches[s, SWITCH_COMPLIANCE]
            rows[start, lane], rows[start + 1, lane] = c, d
            rows[grip, lane], rows[grip + 1, lane], rows[grip + 2, lane] = u, v, w
            for i in range(start + 2, grip):
                rows[i, lane] = rows[first.change + layout.border_memory(sizes) + i - memory, lane]
    return slid or less


@apart
def seed_sliding(r: Reactions, rows: Rows, first: Workspace, sizes: Sizes, lane: int) -> bool:
    """Find impulses x that give contacts which begin to slide a speed, below that of rest, along their directions, and
    keep the rates of all rows in use; return whether there are any. Roundoff of the speed points anywhere, and where it
    points back friction would accelerate it. All contacts are seeded together, so that the speeds of a body agree."""
    p, some, time, longest = r.problem, False, 0.0, np.inf
    on = first.state + layout.on_row(sizes)
    for s in range(sizes.switches):
        rest, plane = still(rows, first, sizes, lane, s), p.switches[s, SWITCH_TANGENTS] == 2
        some = some or (plane and rows[on + s, lane] == STICK and along(r, s, r.rates) > rest)
        if _begins(r, s) and plane:
            some, a = True, along(r, s, p.rates)
            if r.begins[s] == AT_ONCE:
                time, longest = max(time, SLIP_SEED * rest / a), min(longest, CREEP_SPEED * rest / a)
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
                fast = CREEP_SPEED * rest * r.slip_ratios[s] * p.direction[i]
                fast = p.rates[i] * min(time, longest) if r.begins[s] == AT_ONCE else fast
                r.wanted[i], p.free[i] = 1.0, fast - r.rates[i]
    find_impulses(r, rows, first, sizes, lane)
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
def _is_held_by_joint_friction(r: Reactions, row: int) -> bool:
    """Return whether friction of a joint that sticks may hold a closed contact."""
    p, some = r.problem, False
    for s in range(r.begins.size):
        some = some or (p.law[s] == BOUNDED and p.S[row, p.switches[s, SWITCH_FIRST]] != 0.0)
    return some


@apart
def _is_opened_by_slip(r: Reactions, row: int) -> bool:
    """Return whether a slip that begins without acceleration opens this row."""
    p = r.problem
    for s in range(r.begins.size):
        end, rate = p.switches[s, SWITCH_FIRST] + p.switches[s, SWITCH_ROWS], 0.0
        for i in range(end - p.switches[s, SWITCH_TANGENTS], end):
            rate += p.S[row, i] * p.direction[i]
        if r.begins[s] == SMOOTHLY and rate > 0.0:
            return True
    return False
