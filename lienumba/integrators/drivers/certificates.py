"""What ends a run, though no step tells it: what works nothing is in no book of energies, and conditions that have been
true since they were last decided are not found again."""

import numpy as np

from lienumba.compiler.lanes import Lanes, Mask, choose, load, splat
from lienumba.compiler.routines.marks import apart, inlined
from lienumba.integrators import codes, layout
from lienumba.integrators.drivers.workspace import Plan
from lienumba.integrators.layout import (
    BILATERAL,
    FRICTION,
    OFF,
    OPENS,
    SLIDE,
    SLIDES,
    STICK,
    SWITCH_FIRST,
    SWITCH_KIND,
    UNILATERAL,
    Workspace,
)
from lienumba.integrators.sizes import Sizes
from lienumba.numerics.operations import absolute, maximum

BEYOND = 1e-6  # of the largest speed of a switch so far, of the force that gives this, of its length: no rounding
FAINT = 1e-9  # of that force: what presses with less has no friction but rounding


@inlined
def _excess(sizes: Sizes, at: Workspace, plan: Plan, switch: int) -> Lanes:
    """By how much, at the end of the open step, a contact, a stop or friction does what it cannot: pulls, or holds more
    than it may, as a part of the force that it is compared with, or overlaps though it is open, in its lengths."""
    row = layout.conditions(sizes) + sizes.events + layout.CONDITIONS * switch
    parts, slips = load(at.conditions, row + OPENS), load(at.conditions, row + SLIDES)
    on, force = load(at.new, layout.on_row(sizes) + switch), load(at.change, layout.change_forces(sizes) + switch)
    if plan.switches[switch, SWITCH_KIND] == FRICTION:  # where others hold it, this is a speed
        used = load(at.new, layout.mask_row(sizes) + plan.switches[switch, SWITCH_FIRST]) != 0.0
        slips = choose(used, slips, splat(0.0))
    held = choose(on == STICK, maximum(parts, slips), parts) / force
    return choose(on == OFF, parts, held)


@inlined
def _presses_faintly(sizes: Sizes, at: Workspace, switch: int) -> Mask:
    row = layout.conditions(sizes) + sizes.events + layout.CONDITIONS * switch + OPENS
    return absolute(load(at.conditions, row)) < FAINT * load(at.change, layout.change_forces(sizes) + switch)


@apart
def judge(sizes: Sizes, at: Workspace, plan: Plan) -> Lanes:
    """The status of lanes in which at the end of the open step friction pushes, what holds moves, or a contact, a stop
    or what sticks does what it cannot; 0 elsewhere."""
    fails, moving = splat(0.0), layout.conditions(sizes) + layout.pushing_row(sizes)
    for s in range(sizes.switches):
        status, kind = splat(codes.CONTRADICTS), plan.switches[s, SWITCH_KIND]
        most = BEYOND * load(at.change, layout.change_speeds(sizes) + s)
        if kind != BILATERAL:
            fails = choose(_excess(sizes, at, plan, s) > BEYOND, splat(codes.VIOLATED), fails)
            slides = load(at.new, layout.on_row(sizes) + s) == SLIDE
            if kind == UNILATERAL:
                used = load(at.new, layout.mask_row(sizes) + plan.switches[s, SWITCH_FIRST]) != 0.0
                most = choose(slides & used & _presses_faintly(sizes, at, s), splat(np.inf), most)
                slides = used
            status = choose(slides, splat(codes.PUSHED), splat(codes.VIOLATED))
        fast = load(at.conditions, moving + s) > most
        fails = choose(fast, status, fails)
    return fails
