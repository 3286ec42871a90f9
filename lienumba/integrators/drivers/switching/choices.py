"""The complementarity problem of `complementarity`, where iterations lead nowhere.

What is known before may be a solution that sweeps leave: one that a contact alone, which slides, could not have. Else
each of what presses or is bounded is tried as it may be: held, open, on an edge, or sliding to and fro where its
tangents say the same. Then all is linear.
"""

import numpy as np

from lienumba.compiler.routines.marks import apart, inlined
from lienumba.integrators.drivers.switching.complementarity import CLOSE, asked, iterate, refine, scaled
from lienumba.integrators.drivers.switching.problem import (
    BOUNDED,
    FREE,
    HOLDS,
    PRESSES,
    SLIDES,
    SOLVED,
    UNSOLVED,
    Problem,
    size,
    update_rates,
)
from lienumba.integrators.layout import SWITCH_FIRST, SWITCH_TANGENTS

MOST = 4  # switches that are tried, so that there are 256 choices
HELD, OPEN, FORTH, BACK, WAYS = range(5)  # a choice; of what is bounded FORTH and BACK are its edges
ACROSS = 1e-9  # of the rate of what slides: what is along its direction


@apart
def solve(p: Problem) -> int:
    """Find x, and its rates; SOLVED, UNSOLVED, or PARADOX where friction leaves nothing to be found."""
    for i in range(p.free.size):
        p.start[i] = p.x[i]
    said = iterate(p)
    if said == SOLVED:
        return said
    for i in range(p.free.size):
        p.x[i] = p.start[i]
    if refine(p) == SOLVED:
        return SOLVED
    undecided, choices = 0, 1
    for s in range(p.law.size):
        p.laws[s] = p.law[s]
        if p.law[s] == BOUNDED or p.law[s] == PRESSES:
            undecided, choices = undecided + 1, WAYS * choices
    for choice in range(choices if 0 < undecided <= MOST else 0):
        if _tried(p, choice):
            return SOLVED
    for i in range(p.free.size):
        p.x[i] = 0.0
    return said


@inlined
def _chosen(choice: int, n: int) -> int:
    """What is chosen for the nth."""
    for _ in range(n):
        choice //= WAYS
    return choice % WAYS


@inlined
def _load(p: Problem, switch: int, chosen: int) -> float:
    """Of what is bounded the force on its edge."""
    edge = p.bound[switch] if chosen == BACK else -p.bound[switch]
    return edge if p.laws[switch] == BOUNDED and chosen >= FORTH else 0.0


@inlined
def _law(p: Problem, switch: int, chosen: int) -> float:
    slides = p.laws[switch] == PRESSES and chosen >= FORTH
    return float(HOLDS) if chosen == HELD else float(SLIDES) if slides else float(FREE)


@inlined
def _slide(p: Problem, switch: int, sign: float) -> None:
    """Along its tangents as they move each other."""
    row = p.switches[switch, SWITCH_FIRST] + 1
    x, y = p.S[row, row], p.S[row + 1, row]
    if p.S[row + 1, row + 1] > x:
        x, y = y, p.S[row + 1, row + 1]
    length = np.sqrt(x * x + y * y)
    p.direction[row], p.direction[row + 1] = sign * x / length, sign * y / length


@apart
def _tried(p: Problem, choice: int) -> bool:
    """Whether a choice solves the problem; laws are then what they were."""
    n, able = 0, True
    for i in range(p.free.size):
        p.start[i], p.x[i] = p.free[i], 0.0
    for s in range(p.law.size):
        if p.laws[s] == BOUNDED or p.laws[s] == PRESSES:
            chosen, n = _chosen(choice, n), n + 1
            p.law[s], load = _law(p, s, chosen), _load(p, s, chosen)
            if p.law[s] == SLIDES:
                able = able and p.switches[s, SWITCH_TANGENTS] == 2
                if able:
                    _slide(p, s, 1.0 if chosen == FORTH else -1.0)
            able = able and not (p.laws[s] == BOUNDED and chosen == OPEN)
            for i in range(p.free.size):
                p.free[i] += p.S[i, p.switches[s, SWITCH_FIRST]] * load
    said = refine(p) if able else UNSOLVED
    n = 0
    for i in range(p.free.size):
        p.free[i] = p.start[i]
    for s in range(p.law.size):
        if p.laws[s] == BOUNDED or p.laws[s] == PRESSES:
            chosen, n = _chosen(choice, n), n + 1
            p.x[p.switches[s, SWITCH_FIRST]] += _load(p, s, chosen)
            p.law[s] = p.laws[s]
    update_rates(p)
    return said == SOLVED and _may(p, choice)


@apart
def _may(p: Problem, choice: int) -> bool:
    """Whether all that was chosen is so."""
    n, good, enough = 0, True, CLOSE * asked(p)
    for s in range(p.law.size):
        if p.law[s] != BOUNDED and p.law[s] != PRESSES:
            continue
        row, chosen, n = p.switches[s, SWITCH_FIRST], _chosen(choice, n), n + 1
        rate, tangents = scaled(p, row) * p.rates[row], p.switches[s, SWITCH_TANGENTS]
        if p.law[s] == BOUNDED:
            good = good and size(p.x[row]) <= p.bound[s] + enough and (chosen == HELD or p.x[row] * rate <= 0.0)
        elif chosen == OPEN:
            good = good and rate >= -enough
        else:
            square, most, along, total = 0.0, p.friction[s] * p.x[row] + enough, 0.0, 0.0
            for i in range(row + 1, row + 1 + tangents):
                square += p.x[i] * p.x[i]
                along += p.rates[i] * p.direction[i]
                total += p.rates[i] * p.rates[i]
            good = good and p.x[row] >= -enough and (tangents == 0 or square <= most * most)
            slides = along >= 0.0 and total - along * along <= ACROSS * total
            good = good and (chosen == HELD or slides)
    return good
