"""Forces of redundant contacts and joint friction at rest, of one run: regularised Coulomb friction.

Statics leaves these forces undetermined. They are those of members that all follow one small motion z: a normal force
is that of a spring, max(z_n, 0); friction is mu N u / sqrt(1 + |u|^2) with u = z_t over the largest mu N; that of a
joint is bound u / sqrt(1 + u^2), its row scaled to the length of a contact's. The limits are reached only where no
forces within Coulomb's disks hold the mechanism, so that all members that have to slip reach them together. Newton's
method finds z. Between changes a step has this law of contacts to first order, and the friction of joints is constant.
"""

from typing import NamedTuple

import numpy as np

from lienumba.compiler.routines.marks import Floats1, Floats2, apart, inlined
from lienumba.integrators.drivers.switching.problem import BOUNDED, PRESSES, SLIDES, Problem, eliminate, size
from lienumba.integrators.layout import SWITCH_FIRST, SWITCH_ROWS, SWITCH_TANGENTS

AT_EDGE, NEXT_TO_EDGE = 1e4, 2e3  # u: all but 5e-9, and all but 1e-7, of what there may be
PATIENCE, HALVINGS = 60, 12  # Newton steps, and how often one is halved
BALANCED, NEARLY = 1e-13, 1e-7  # of the largest load: rounding, and what is close to a limit
FAINT = 1e-9  # of the largest mu N: what presses by less counts as this
SOFTEST = 1e-8  # of 1 - |g|^2
STICKS, FOLLOWS = 1.0, 2.0  # rows with a force of their own, and with one that follows from a normal


class Distribution(NamedTuple):
    """whole (q, q): 1 + G of `mechanics.system.switched.border`, its columns those of rows that are taken; carries
    (q,): STICKS for rows that have a force of their own, FOLLOWS for tangents that slide; group (q,): see `part`;
    static (s,): coefficients; y, z, forces, loads (q,): see `find`."""

    whole: Floats2
    carries: Floats1
    group: Floats1
    static: Floats1
    y: Floats1
    z: Floats1
    forces: Floats1
    loads: Floats1


@apart
def part(p: Problem, g: Distribution) -> None:
    """Divide the rows into groups without coupling in S, named by their first rows: each has a scale of its own."""
    q, some = p.free.size, True
    for s in range(p.law.size):
        first = p.switches[s, SWITCH_FIRST]
        for i in range(first, first + p.switches[s, SWITCH_ROWS]):
            g.group[i] = float(first)
    while some:
        some = False
        for i in range(q):
            for j in range(q):
                if p.S[i, j] != 0.0 and g.group[i] > g.group[j]:
                    g.group[i] = g.group[j]
                    some = True
        for s in range(p.law.size):
            first = p.switches[s, SWITCH_FIRST]
            for i in range(first, first + p.switches[s, SWITCH_ROWS]):
                g.group[first] = min(g.group[first], g.group[i])
            for i in range(first, first + p.switches[s, SWITCH_ROWS]):
                some = some or g.group[i] != g.group[first]
                g.group[i] = g.group[first]


@apart
def find_dependence(p: Problem, g: Distribution, taken: Floats1) -> bool:
    """Find 1 + G from S less all other rows, in `matrix`; return whether any rows are redundant."""
    q, some = p.free.size, False
    for k in range(q):
        if g.carries[k] != 0.0 and taken[k] != 0.0:
            pivot = p.matrix[k, k]
            for i in range(q):
                if i != k and g.carries[i] != 0.0:
                    for j in range(q):
                        if j != k:
                            p.matrix[i, j] -= p.matrix[i, k] * p.matrix[k, j] / pivot
            for i in range(q):
                p.matrix[i, k] /= pivot
                p.matrix[k, i] = p.matrix[i, k] if i != k else -1.0 / pivot
    for i in range(q):
        free = g.carries[i] != 0.0 and taken[i] == 0.0
        some = some or free
        for j in range(q):
            whole = 1.0 if i == j and g.carries[i] != 0.0 and taken[i] != 0.0 else 0.0
            g.whole[i, j] = p.matrix[i, j] if free and g.carries[j] != 0.0 and taken[j] != 0.0 else whole
    return some


@inlined
def _motion(p: Problem, g: Distribution, switch: int, scale: float) -> tuple[float, float, float]:
    """Of a contact that sticks: w, the limit of its friction in parts of the scale, and u along its tangents."""
    first = p.switches[switch, SWITCH_FIRST]
    w = max(g.static[switch] * g.forces[first], FAINT * scale) / scale
    return w, g.z[first + 1] / scale, g.z[first + 2] / scale


@inlined
def has_friction(p: Problem, g: Distribution, switch: int) -> bool:
    """Whether a contact sticks with friction of its own."""
    return p.switches[switch, SWITCH_TANGENTS] == 2 and g.carries[p.switches[switch, SWITCH_FIRST] + 1] == STICKS


@inlined
def _is_dry(p: Problem, g: Distribution, switch: int) -> bool:
    """Whether a joint sticks by friction."""
    return p.law[switch] == BOUNDED and g.carries[p.switches[switch, SWITCH_FIRST]] == STICKS


@inlined
def _presses(p: Problem, g: Distribution, switch: int) -> bool:
    return p.law[switch] >= PRESSES and g.carries[p.switches[switch, SWITCH_FIRST]] != 0.0


@apart
def _unbalanced(p: Problem, g: Distribution, scale: float) -> float:
    """Find the forces of the motion y; return the largest residual of the loads, which is the last column of
    `matrix`."""
    q, worst = p.free.size, 0.0
    for i in range(q):
        total = 0.0
        for j in range(q):
            total += g.whole[i, j] * g.y[j]
        g.z[i], g.forces[i] = total, 0.0
    for s in range(p.law.size):
        first = p.switches[s, SWITCH_FIRST]
        if _presses(p, g, s):
            g.forces[first] = max(g.z[first], 0.0)
        if has_friction(p, g, s):
            w, u, v = _motion(p, g, s, scale)
            most = w * scale / np.sqrt(1.0 + u * u + v * v)
            g.forces[first + 1], g.forces[first + 2] = most * u, most * v
        elif _is_dry(p, g, s):
            u = g.z[first] / (p.anchor[first] * scale)
            g.forces[first] = p.bound[s] * u / np.sqrt(1.0 + u * u)
        elif p.law[s] == SLIDES:
            for i in range(first + 1, first + 1 + p.switches[s, SWITCH_TANGENTS]):
                g.forces[i] = -p.friction[s] * p.direction[i] * g.forces[first]
    for j in range(q):
        total = g.loads[j]
        for i in range(q):
            total -= g.whole[i, j] * g.forces[i]
        worst = max(worst, max(total, -total)) if total == total else np.inf
        p.matrix[j, q] = total
    return worst


@apart
def _stiffness(p: Problem, g: Distribution, scale: float) -> None:
    """Write the derivative of the loads by y to `matrix`, its columns scaled to a diagonal of 1 by `diagonal`, its rows
    by their largest entries: next to a limit friction grows with the normal force, by 1e5 times the diagonal."""
    q = p.free.size
    for i in range(q):
        for j in range(q):
            p.matrix[i, j] = 0.0
    for s in range(p.law.size):
        first = p.switches[s, SWITCH_FIRST]
        if _presses(p, g, s) and g.z[first] > 0.0:
            _add(p, g, first, first, 1.0)
            for i in range(first + 1, first + 1 + p.switches[s, SWITCH_TANGENTS] if p.law[s] == SLIDES else first):
                _add(p, g, i, first, -p.friction[s] * p.direction[i])
        if has_friction(p, g, s):
            w, u, v = _motion(p, g, s, scale)
            one = 1.0 + u * u + v * v
            part, along = w / (one * np.sqrt(one)), g.static[s] / np.sqrt(one) if g.z[first] > 0.0 else 0.0
            _add(p, g, first + 1, first, along * u)
            _add(p, g, first + 2, first, along * v)
            _add(p, g, first + 1, first + 1, part * (one - u * u))
            _add(p, g, first + 1, first + 2, -part * u * v)
            _add(p, g, first + 2, first + 1, -part * u * v)
            _add(p, g, first + 2, first + 2, part * (one - v * v))
        elif _is_dry(p, g, s):
            u = g.z[first] / (p.anchor[first] * scale)
            one = 1.0 + u * u
            _add(p, g, first, first, p.bound[s] / (one * np.sqrt(one) * p.anchor[first] * scale))
    for i in range(q):
        p.diagonal[i] = 1.0 / np.sqrt(p.matrix[i, i]) if p.matrix[i, i] > 0.0 else 1.0
    for i in range(q):
        most = 0.0
        for j in range(q):
            p.matrix[i, j] *= p.diagonal[j]
            most = max(most, max(p.matrix[i, j], -p.matrix[i, j]))
        for j in range(q + 1 if most > 0.0 else 0):
            p.matrix[i, j] /= most


@inlined
def _add(p: Problem, g: Distribution, row: int, column: int, stiffness: float) -> None:
    """The stiffness of a force in one row against the motion of another."""
    for i in range(p.free.size):
        for j in range(p.free.size):
            p.matrix[i, j] += g.whole[row, i] * stiffness * g.whole[column, j]


@apart
def _scale(p: Problem, g: Distribution) -> float:
    """The largest limit of friction (N), of a joint as that of a contact that moves its row alike: by a length, to
    `anchor`."""
    softest, dry, scale = 0.0, 0.0, 0.0
    for s in range(p.law.size):
        first = p.switches[s, SWITCH_FIRST]
        if _presses(p, g, s):
            softest = max(softest, p.S[first, first])
        if _is_dry(p, g, s):
            dry = max(dry, p.S[first, first])
    for s in range(p.law.size):
        first = p.switches[s, SWITCH_FIRST]
        if has_friction(p, g, s):
            scale = max(scale, g.static[s] * p.x[first])
        if _is_dry(p, g, s):
            p.anchor[first] = np.sqrt(p.S[first, first] / (softest if softest > 0.0 else dry))
            scale = max(scale, p.bound[s] * p.anchor[first])
    return scale


@apart
def find(p: Problem, g: Distribution, taken: Floats1) -> tuple[float, float]:
    """Find the forces of all rows that carry with the resultant of x, and the motion z = whole y; return the largest
    |u| and the largest limit of friction. Where there are no such forces, |u| is above `AT_EDGE`, and z is the slip."""
    q, scale, largest = p.free.size, _scale(p, g), 0.0
    for j in range(q):
        g.loads[j], g.y[j] = 0.0, 0.0
        for i in range(q):
            g.loads[j] += g.whole[i, j] * p.x[i]
        largest = max(largest, max(g.loads[j], -g.loads[j]))
    for s in range(p.law.size):
        first = p.switches[s, SWITCH_FIRST]
        if g.carries[first] != 0.0 and taken[first] != 0.0:
            g.y[first] = p.x[first]
    if not scale > 0.0:
        return 0.0, 0.0
    worst = _unbalanced(p, g, scale)
    for _ in range(PATIENCE):
        slips = worst <= NEARLY * largest and _farthest(p, g, scale) > AT_EDGE
        if slips or worst <= BALANCED * largest:
            break
        _stiffness(p, g, scale)
        eliminate(p.matrix, q, p.step)
        for i in range(q):
            p.best[i], p.step[i] = g.y[i], p.diagonal[i] * p.step[i]
        before, part = worst, 1.0
        for _ in range(HALVINGS):
            for i in range(q):
                g.y[i] = p.best[i] + part * p.step[i]
            worst, part = _unbalanced(p, g, scale), 0.5 * part
            if worst < before:
                break
        if not worst < before:
            for i in range(q):
                g.y[i] = p.best[i]
            _unbalanced(p, g, scale)
            break
    return _farthest(p, g, scale), scale


@apart
def _farthest(p: Problem, g: Distribution, scale: float) -> float:
    """Return the largest |u|."""
    most = 0.0
    for s in range(p.law.size):
        if has_friction(p, g, s):
            _, u, v = _motion(p, g, s, scale)
            most = max(most, np.sqrt(u * u + v * v))
        elif _is_dry(p, g, s):
            row = p.switches[s, SWITCH_FIRST]
            most = max(most, size(g.z[row]) / (p.anchor[row] * scale))
    return most


@apart
def kept(p: Problem, g: Distribution, switch: int, scale: float) -> tuple[float, float, float, float, float]:
    """Return c, g and w of `laws.compliance` for a contact, such that a step begins with these forces."""
    first, (w, u, v) = p.switches[switch, SWITCH_FIRST], _motion(p, g, switch, scale)
    one = 1.0 + u * u + v * v
    soft = np.sqrt(min(1.0 / one, (1.0 - SOFTEST) / max(one - 1.0, FAINT)))
    gx, gy, w, x, y = soft * u, soft * v, w / np.sqrt(one), 0.0, 0.0
    for s in range(p.law.size):  # what a motion along the normals alone, with which a step then begins, is along these
        j = p.switches[s, SWITCH_FIRST]
        x, y = x + g.whole[first + 1, j] * g.y[j], y + g.whole[first + 2, j] * g.y[j]
    along, normal = gx * x + gy * y, g.forces[first]
    if not normal > FAINT * scale:
        return 0.0, 0.0, gx, gy, w
    c, d = (g.forces[first + 1] - w * (x - gx * along)) / normal, (g.forces[first + 2] - w * (y - gy * along)) / normal
    return c, d, gx, gy, w
