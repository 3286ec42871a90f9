"""Check of the contact laws after each step. A violated unilateral constraint does no work, so the energy balance
cannot reveal it, and a guard function that has been positive since the last change is not located again."""

import numpy as np

from lienumba.compiler.lanes import Lanes, Mask, choose, load, splat, store
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

BEYOND = 1e-6  # tolerance of the contact laws, relative to the speed, force and length scale of each constraint
FAINT = 1e-9  # relative to the force scale: a contact that presses with less has no friction but roundoff
FORCE_ROUNDOFF = 1e-12  # relative to the force scale: a smaller force, such as that of a stop in free fall, is zero


@inlined
def _guard_row(sizes: Sizes, switch: int, which: int) -> int:
    """The row of a guard function at the end of the step."""
    return layout.conditions(sizes) + sizes.events + layout.CONDITIONS * switch + which


@inlined
def _violation(sizes: Sizes, at: Workspace, plan: Plan, switch: int) -> Lanes:
    """The violation of a contact law at the end of the step: a pull, or friction beyond its limit, relative to the
    force scale; of an open contact the penetration relative to its length."""
    opens = load(at.conditions, _guard_row(sizes, switch, OPENS))
    slips = load(at.conditions, _guard_row(sizes, switch, SLIDES))
    on, force = load(at.new, layout.on_row(sizes) + switch), load(at.change, layout.change_forces(sizes) + switch)
    if plan.switches[switch, SWITCH_KIND] == FRICTION:  # the second guard of a redundant row is a speed
        used = load(at.new, layout.mask_row(sizes) + plan.switches[switch, SWITCH_FIRST]) != 0.0
        slips = choose(used, slips, splat(0.0))
    held = choose(on == STICK, maximum(opens, slips), opens) / force
    return choose(on == OFF, opens, held)


@inlined
def _presses_faintly(sizes: Sizes, at: Workspace, switch: int) -> Mask:
    force = absolute(load(at.conditions, _guard_row(sizes, switch, OPENS)))
    return force < FAINT * load(at.change, layout.change_forces(sizes) + switch)


@inlined
def _clear_roundoff(sizes: Sizes, at: Workspace, switch: int) -> None:
    """Set the force of a closed contact to zero where it is roundoff. Else a guard function that is positive by
    roundoff would not cross zero when the contact really pulls."""
    row = _guard_row(sizes, switch, OPENS)
    force, scale = load(at.conditions, row), load(at.change, layout.change_forces(sizes) + switch)
    closed = load(at.new, layout.on_row(sizes) + switch) != OFF
    store(
        at.conditions,
        row,
        choose(closed & (scale < np.inf) & (absolute(force) < FORCE_ROUNDOFF * scale), splat(0.0), force),
    )


@apart
def judge(sizes: Sizes, at: Workspace, plan: Plan) -> Lanes:
    """Check the contact laws at the end of the step; returns the status of each lane, 0 where they hold. Forces that
    are roundoff are set to zero in the guard functions."""
    fails, moving = splat(0.0), layout.conditions(sizes) + layout.pushing_row(sizes)
    for s in range(sizes.switches):
        status, kind = splat(codes.CONTRADICTS), plan.switches[s, SWITCH_KIND]
        most = BEYOND * load(at.change, layout.change_speeds(sizes) + s)
        if kind != BILATERAL:
            fails = choose(_violation(sizes, at, plan, s) > BEYOND, splat(codes.VIOLATED), fails)
            slides = load(at.new, layout.on_row(sizes) + s) == SLIDE
            if kind == UNILATERAL:
                used = load(at.new, layout.mask_row(sizes) + plan.switches[s, SWITCH_FIRST]) != 0.0
                most = choose(slides & used & _presses_faintly(sizes, at, s), splat(np.inf), most)
                slides = used
                _clear_roundoff(sizes, at, s)
            status = choose(slides, splat(codes.PUSHED), splat(codes.VIOLATED))
        fast = load(at.conditions, moving + s) > most
        fails = choose(fast, status, fails)
    return fails
