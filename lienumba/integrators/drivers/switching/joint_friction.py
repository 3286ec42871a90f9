"""Friction of joints that is redundant, of one run: how large it is.

Rows that depend on others are not used in a step, and bear nothing. Redundant friction of joints is therefore a
prescribed force, which stays as it is until something changes, as `force_distribution` has it.
"""

from lienumba.compiler.routines.marks import apart, inlined
from lienumba.integrators.drivers.switching import force_distribution
from lienumba.integrators.drivers.switching.independent_rows import (
    BILATERAL_ROW,
    CHECKED_ROW,
    FRICTIONLESS_ROW,
    JOINT_FRICTION_ROW,
    NORMAL_ROW,
    TANGENT_ROW,
    remove,
    take,
)
from lienumba.integrators.drivers.switching.problem import BOUNDED, HOLDS, PRESSES, SLIDES, Problem
from lienumba.integrators.drivers.switching.reactions import Reactions
from lienumba.integrators.layout import SWITCH_FIRST, SWITCH_ROWS, SWITCH_SHARES

FORCE_RTOL = 1e-9  # of the largest force: what presses with less does not


@apart
def prescribe_redundant_friction(r: Reactions, largest: float) -> None:
    """Find which friction of joints is `prescribed`, and forces x that hold all that rests; largest: the force
    that rates ask for."""
    p, g, some = r.problem, r.distribution, False
    for s in range(p.law.size):
        r.prescribed[s] = 0.0
        some = some or p.law[s] == BOUNDED
    for i in range(p.free.size):
        p.given[i] = p.x[i]
    if not some or not _left_out(r, largest):
        return
    for i in range(p.free.size):
        g.carries[i] = 0.0
        for j in range(p.free.size):
            p.matrix[i, j] = p.S[i, j]
    for s in range(p.law.size):
        row, law, end = p.switches[s, SWITCH_FIRST], p.law[s], p.switches[s, SWITCH_FIRST] + p.switches[s, SWITCH_ROWS]
        if law == BOUNDED and p.bound[s] > 0.0:
            g.carries[row] = force_distribution.STICKS
            r.prescribed[s] = 1.0 - r.taken[row]
        if _presses(p, s, largest):
            g.static[s], g.carries[row] = p.friction[s], force_distribution.STICKS
            for i in range(row + 1, end):
                g.carries[i] = force_distribution.FOLLOWS if law == SLIDES else force_distribution.STICKS
    for i in range(p.free.size):
        if r.taken[i] != 0.0 and g.carries[i] == 0.0:
            remove(r, i)
    force_distribution.find_dependence(p, g, r.taken)
    force_distribution.find(p, g, r.taken)
    for i in range(p.free.size):
        if g.carries[i] != 0.0:
            p.x[i] = g.forces[i]


@apart
def _left_out(r: Reactions, largest: float) -> bool:
    """Take rows that are independent of all that hold; whether friction of joints is left out that may carry."""
    p, some = r.problem, False
    for i in range(p.free.size):
        r.wanted[i], r.taken[i] = -1.0, 0.0
    for s in range(p.law.size):
        row, law, end = p.switches[s, SWITCH_FIRST], p.law[s], p.switches[s, SWITCH_FIRST] + p.switches[s, SWITCH_ROWS]
        if law == BOUNDED and p.bound[s] > 0.0:
            r.wanted[row] = float(JOINT_FRICTION_ROW)
        for i in range(row, end if law == HOLDS else row):
            r.wanted[i] = float(BILATERAL_ROW)
        if _presses(p, s, largest):
            r.wanted[row] = float(NORMAL_ROW) if p.switches[s, SWITCH_SHARES] != 0 else float(FRICTIONLESS_ROW)
            for i in range(row + 1, end):
                r.wanted[i] = float(TANGENT_ROW if law == PRESSES else CHECKED_ROW)
    take(r)
    for s in range(p.law.size):
        row = p.switches[s, SWITCH_FIRST]
        some = some or (r.wanted[row] == JOINT_FRICTION_ROW and r.taken[row] == 0.0 and p.S[row, row] > 0.0)
    return some


@inlined
def _presses(p: Problem, switch: int, largest: float) -> bool:
    """With the forces that were given."""
    return p.law[switch] >= PRESSES and p.given[p.switches[switch, SWITCH_FIRST]] > FORCE_RTOL * largest
