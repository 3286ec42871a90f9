"""The law of each switch of one run in the contact problem of accelerations, from its mode and speed."""

import numpy as np

from lienumba.compiler.routines.marks import apart, inlined
from lienumba.integrators import layout
from lienumba.integrators.drivers.events.acting import fired, used
from lienumba.integrators.drivers.switching import independent_rows
from lienumba.integrators.drivers.switching.problem import BOUNDED, FREE, HOLDS, PRESSES, SLIDES
from lienumba.integrators.drivers.switching.reactions import (
    MOVES,
    Reactions,
    along,
    find_impulses,
    number,
    slow,
    still,
    touches,
)
from lienumba.integrators.drivers.workspace import Rows
from lienumba.integrators.layout import (
    FRICTION,
    OFF,
    SLIDE,
    STICK,
    SWITCH_FIRST,
    SWITCH_KIND,
    SWITCH_ROWS,
    SWITCH_TANGENTS,
    UNILATERAL,
    Workspace,
)
from lienumba.integrators.sizes import Sizes


@inlined
def switch_fired(rows: Rows, first: Workspace, sizes: Sizes, lane: int, switch: int, which: int) -> bool:
    """Return whether a guard function of a switch crosses zero now."""
    return fired(sizes, first, rows, lane, sizes.events + layout.CONDITIONS * switch + which)


@apart
def set_laws(r: Reactions, rows: Rows, first: Workspace, sizes: Sizes, lane: int, halted: bool) -> None:
    """Set the law of each switch, and the accelerations without their reactions. halted: contacts that are to stick
    have been stopped, so that those that move slide on."""
    p, on = r.problem, first.state + layout.on_row(sizes)
    halts = not halted and _stops(r, rows, first, sizes, lane)
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
            stops = halts and friction_speed(r, rows, first, sizes, lane, s) > 0.0
            if not stops and speed > (rest if halted else slow(rows, first, sizes, lane, s)):
                slide_on(r, rows, first, sizes, lane, s, speed)
        if kind == FRICTION:
            p.law[s], p.bound[s] = float(BOUNDED), number(rows, first, sizes, lane, s, layout.STATIC_EFFORT)
            carried = rows[on + s, lane] == STICK and not used(sizes, first, rows, p.switches, lane, s)
            if speed > (0.0 if carried and switch_fired(rows, first, sizes, lane, s, layout.SLIDES) else rest):
                slide(r, rows, first, sizes, lane, s, r.rates, 1.0 / speed)


@apart
def _stops(r: Reactions, rows: Rows, first: Workspace, sizes: Sizes, lane: int) -> bool:
    """Return whether a contact has reversed that slides slower than explicit steps of given length can follow."""
    some = False
    for s in range(sizes.switches):
        slides = rows[first.state + layout.on_row(sizes) + s, lane] == SLIDE
        turned = switch_fired(rows, first, sizes, lane, s, layout.SLIDES)
        some = some or (slides and turned and friction_speed(r, rows, first, sizes, lane, s) > 0.0)
    return some


@inlined
def slide(
    r: Reactions, rows: Rows, first: Workspace, sizes: Sizes, lane: int, switch: int, along: np.ndarray, scale: float
) -> None:
    """Let a switch slide along `scale * along`; the friction of a joint is then a load."""
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


@inlined
def slide_on(r: Reactions, rows: Rows, first: Workspace, sizes: Sizes, lane: int, switch: int, speed: float) -> None:
    """Let a switch slide along its rates; below its friction speed along the direction that a step uses."""
    p, slides = r.problem, rows[first.state + layout.on_row(sizes) + switch, lane] == SLIDE
    keeps = slides and not has_turned(r, rows, first, sizes, lane, switch)
    if keeps and friction_speed(r, rows, first, sizes, lane, switch) > 0.0:
        row = p.switches[switch, SWITCH_FIRST] + p.switches[switch, SWITCH_ROWS] - p.switches[switch, SWITCH_TANGENTS]
        measured = first.change + layout.border_memory(sizes) + p.switches[switch, layout.SWITCH_MEMORY]
        for n in range(p.switches[switch, SWITCH_TANGENTS]):
            p.direction[row + n] = rows[measured + n, lane]
        slide(r, rows, first, sizes, lane, switch, p.direction, 1.0)
    else:
        slide(r, rows, first, sizes, lane, switch, r.rates, 1.0 / speed)


@inlined
def has_turned(r: Reactions, rows: Rows, first: Workspace, sizes: Sizes, lane: int, switch: int) -> bool:
    """Return whether a contact that slides takes a new direction: its guard function says so, or an impact has
    reversed it."""
    p, back = r.problem, 0.0
    memory = first.state + layout.memory_row(sizes) + p.switches[switch, layout.SWITCH_MEMORY]
    tangents = p.switches[switch, SWITCH_TANGENTS]
    end = p.switches[switch, SWITCH_FIRST] + p.switches[switch, SWITCH_ROWS]
    for n in range(tangents):
        back -= rows[memory + n, lane] * r.rates[end - tangents + n]
    return back > 0.0 or switch_fired(rows, first, sizes, lane, switch, layout.SLIDES)


@inlined
def friction_speed(r: Reactions, rows: Rows, first: Workspace, sizes: Sizes, lane: int, switch: int) -> float:
    """Return the speed below which friction keeps its direction, of a contact that slides slower; else 0."""
    if r.problem.switches[switch, SWITCH_TANGENTS] < 2:
        return 0.0
    memory = first.state + layout.memory_row(sizes) + r.problem.switches[switch, layout.SWITCH_MEMORY]
    x, y, speed = rows[memory, lane], rows[memory + 1, lane], along(r, switch, r.rates)
    kept = np.sqrt(x * x + y * y)
    return kept if slow(rows, first, sizes, lane, switch) < speed and speed < kept else 0.0


@apart
def halt(r: Reactions, rows: Rows, first: Workspace, sizes: Sizes, lane: int) -> bool:
    """Find impulses x that stop all contacts that are to stick; return whether there are any. Their remaining speeds,
    times angular velocities, would be accelerations that redundant contacts cannot remove."""
    p, some = r.problem, False
    set_laws(r, rows, first, sizes, lane, False)
    for i in range(sizes.switched):
        r.wanted[i], r.taken[i], p.free[i] = -1.0, 0.0, 0.0
    for s in range(sizes.switches):
        row, law, tangents = p.switches[s, SWITCH_FIRST], p.law[s], p.switches[s, SWITCH_TANGENTS]
        rests = BOUNDED <= law <= PRESSES
        some = some or (rests and along(r, s, r.rates) > MOVES * still(rows, first, sizes, lane, s))
        end = row + p.switches[s, SWITCH_ROWS]
        for i in range(row, end):
            tangent = i >= end - tangents
            if law == HOLDS:
                r.wanted[i] = float(independent_rows.BILATERAL_ROW)
            if law >= PRESSES and not tangent:
                r.wanted[i] = float(independent_rows.NORMAL_ROW)
            if rests and tangent:
                r.wanted[i] = float(
                    independent_rows.JOINT_FRICTION_ROW if law == BOUNDED else independent_rows.TANGENT_ROW
                )
                p.free[i] = -r.rates[i]
    if some:
        independent_rows.take(r)
        for i in range(sizes.switched):
            r.wanted[i] = r.taken[i]
        find_impulses(r, rows, first, sizes, lane)
    return some
