"""How switched constraints are asked, of one run: the law of each, from what it does and how fast it slides."""

import numpy as np

from lienumba.compiler.routines.marks import apart, inlined
from lienumba.integrators import layout
from lienumba.integrators.drivers.events.acting import fired, used
from lienumba.integrators.drivers.switching import used_rows
from lienumba.integrators.drivers.switching.problem import BOUNDED, FREE, HOLDS, PRESSES, SLIDES
from lienumba.integrators.drivers.switching.reactions import MOVES, Reactions, along, number, push, slow, still, touches
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
    """Whether a condition of a switch has become true now."""
    return fired(sizes, first, rows, lane, sizes.events + layout.CONDITIONS * switch + which)


@apart
def may_act(r: Reactions, rows: Rows, first: Workspace, sizes: Sizes, lane: int, halted: bool) -> None:
    """The laws of what holds, rests or slides, with the accelerations that all else gives. halted: whether what may be
    at rest was brought to rest: what then moves slides on."""
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
            stops = halts and bluntness(r, rows, first, sizes, lane, s) > 0.0
            if not stops and speed > (rest if halted else slow(rows, first, sizes, lane, s)):
                slide_on(r, rows, first, sizes, lane, s, speed)
        if kind == FRICTION:
            p.law[s], p.bound[s] = float(BOUNDED), number(rows, first, sizes, lane, s, layout.STATIC_EFFORT)
            carried = rows[on + s, lane] == STICK and not used(sizes, first, rows, p.switches, lane, s)
            if speed > (0.0 if carried and switch_fired(rows, first, sizes, lane, s, layout.SLIDES) else rest):
                slide(r, rows, first, sizes, lane, s, r.rates, 1.0 / speed)


@apart
def _stops(r: Reactions, rows: Rows, first: Workspace, sizes: Sizes, lane: int) -> bool:
    """Whether anything that slides has turned, and is slower than explicit steps of given length can follow."""
    some = False
    for s in range(sizes.switches):
        slides = rows[first.state + layout.on_row(sizes) + s, lane] == SLIDE
        turned = switch_fired(rows, first, sizes, lane, s, layout.SLIDES)
        some = some or (slides and turned and bluntness(r, rows, first, sizes, lane, s) > 0.0)
    return some


@inlined
def slide(
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


@inlined
def slide_on(r: Reactions, rows: Rows, first: Workspace, sizes: Sizes, lane: int, switch: int, speed: float) -> None:
    """What slides does so along its rates; where it has no direction of its own as yet, as it does in a step."""
    p, slides = r.problem, rows[first.state + layout.on_row(sizes) + switch, lane] == SLIDE
    turned = switch_fired(rows, first, sizes, lane, switch, layout.SLIDES)
    if slides and not turned and bluntness(r, rows, first, sizes, lane, switch) > 0.0:
        row = p.switches[switch, SWITCH_FIRST] + p.switches[switch, SWITCH_ROWS] - p.switches[switch, SWITCH_TANGENTS]
        measured = first.change + layout.border_memory(sizes) + p.switches[switch, layout.SWITCH_MEMORY]
        for n in range(p.switches[switch, SWITCH_TANGENTS]):
            p.direction[row + n] = rows[measured + n, lane]
        slide(r, rows, first, sizes, lane, switch, p.direction, 1.0)
    else:
        slide(r, rows, first, sizes, lane, switch, r.rates, 1.0 / speed)


@inlined
def bluntness(r: Reactions, rows: Rows, first: Workspace, sizes: Sizes, lane: int, switch: int) -> float:
    """The speed below which what slides in a plane has no direction of its own as yet, where it is slower; else 0."""
    if r.problem.switches[switch, SWITCH_TANGENTS] < 2:
        return 0.0
    memory = first.state + layout.memory_row(sizes) + r.problem.switches[switch, layout.SWITCH_MEMORY]
    x, y, speed = rows[memory, lane], rows[memory + 1, lane], along(r, switch, r.rates)
    kept = np.sqrt(x * x + y * y)
    return kept if slow(rows, first, sizes, lane, switch) < speed and speed < kept else 0.0


@apart
def halt(r: Reactions, rows: Rows, first: Workspace, sizes: Sizes, lane: int) -> bool:
    """Impulses, to x, that bring to rest what is to be asked as at rest; whether there are any. Where contacts say the
    same, what is left of their speeds times that at which bodies turn would be accelerations that no forces give."""
    p, some = r.problem, False
    may_act(r, rows, first, sizes, lane, False)
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
                r.wanted[i] = float(used_rows.FIRM)
            if law >= PRESSES and not tangent:
                r.wanted[i] = float(used_rows.SHARED)
            if rests and tangent:
                r.wanted[i] = float(used_rows.DRY if law == BOUNDED else used_rows.TANGENT)
                p.free[i] = -r.rates[i]
    if some:
        used_rows.take(r)
        for i in range(sizes.switched):
            r.wanted[i] = r.taken[i]
        push(r, rows, first, sizes, lane)
    return some
