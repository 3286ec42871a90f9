"""The contact problem of one run at a change, read from what the kernel `border` wrote, and its scales of speed and
force. `impacts` and `modes` solve it."""

from typing import NamedTuple

import numpy as np

from lienumba.compiler.lanes import matrix
from lienumba.compiler.routines.marks import Integers2, apart, inlined
from lienumba.compiler.rows import ROW
from lienumba.integrators import layout
from lienumba.integrators.drivers.events.tolerances import CLOSED_GAP_RTOL
from lienumba.integrators.drivers.switching.force_distribution import Distribution
from lienumba.integrators.drivers.switching.problem import FREE, UNKNOWNS, Problem, eliminate
from lienumba.integrators.drivers.workspace import Rows
from lienumba.integrators.layout import SWITCH_FIRST, SWITCH_ROWS, SWITCH_TANGENTS, Workspace
from lienumba.integrators.sizes import Sizes

STILL = 1e-9  # of the largest speed of a switch so far: what moves no faster than this is at rest
MOVES = 1e-2  # of that: what is asked as at rest, and is faster, is brought to rest before
SLOWEST = 1e-3  # of a length in a whole run: no speed that others are compared with is less
REACHED = 0.1  # of a change that is asked for: what misses it by more than this was not to be had
SLOW = 1e-7  # of the largest speed so far: what slides slower has no direction of its own
INDEPENDENT, NOISE = 1e-10, 1e-12  # of a row's own size, and of that alone: a pivot below says that others say the same
RESTS, AT_ONCE, SMOOTHLY = 0.0, 1.0, 2.0  # sliding begins: with an acceleration, or where its limit is just reached


class Reactions(NamedTuple):
    """rates (q,): of the switched rows before the change; least (q,): pivots below which a row is redundant; wanted,
    taken (q,): which rows may be used, and which are; begins (s,): whether and how sliding begins from rest;
    slip_ratios (s,): its speed over that of the fastest, where it begins without acceleration; prescribed (s,): see
    `joint_friction`."""

    problem: Problem
    rates: np.ndarray
    least: np.ndarray
    wanted: np.ndarray
    taken: np.ndarray
    begins: np.ndarray
    slip_ratios: np.ndarray
    prescribed: np.ndarray
    distribution: Distribution


@apart
def contact_workspace(at: Workspace, sizes: Sizes, switches: Integers2) -> Reactions:
    """Memory for the contact problem of one run at a time."""
    q, s = sizes.switched, sizes.switches
    address = at.change + ROW * layout.change_room(sizes)
    v = matrix(address, q + layout.CHANGE_VECTORS, q)
    system = matrix(address + 8 * q * (q + layout.CHANGE_VECTORS), q, q + 1)
    address += 8 * q * (2 * q + layout.CHANGE_VECTORS + 1)
    whole, tableau = matrix(address, q, q), matrix(address + 8 * q * q, UNKNOWNS * q, UNKNOWNS * q + 2)
    address += 8 * q * (q + UNKNOWNS * (UNKNOWNS * q + 2))
    unknowns, labels = matrix(address, UNKNOWNS * q, 7), matrix(address + 56 * UNKNOWNS * q, 2, UNKNOWNS * q + 1)
    p = Problem(
        v[0:q], v[q], switches, v[q + 1][:s], v[q + 2][:s], v[q + 3][:s], v[q + 4], v[q + 5], v[q + 6], v[q + 7],
        v[q + 8], v[q + 9], v[q + 10], v[q + 11], system, v[q + 12][:s], tableau, unknowns, labels,
    )  # fmt: skip
    g = Distribution(whole, v[q + 18], v[q + 25], v[q + 19][:s], v[q + 20], v[q + 21], v[q + 22], v[q + 23])
    return Reactions(p, v[q + 13], v[q + 14], v[q + 15], v[q + 16], v[q + 17][:s], v[q + 24][:s], v[q + 26][:s], g)


@apart
def read(r: Reactions, rows: Rows, first: Workspace, sizes: Sizes, lane: int) -> None:
    """Read S and the rates of a lane; set no laws and no impulses."""
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
        r.slip_ratios[s] = 1.0


@inlined
def number(rows: Rows, first: Workspace, sizes: Sizes, lane: int, switch: int, which: int) -> float:
    """A coefficient of a switch."""
    return rows[first.change + layout.border_numbers(sizes) + layout.CONTACT_NUMBERS * switch + which, lane]


@inlined
def touches(rows: Rows, first: Workspace, sizes: Sizes, lane: int, switch: int, row: int) -> bool:
    """Return whether the contact with this normal row is closed within its tolerance."""
    gap = rows[first.change + layout.border_gaps(sizes) + row, lane]
    return gap <= CLOSED_GAP_RTOL * number(rows, first, sizes, lane, switch, layout.SIZE)


@apart
def update_velocity_scale(
    rows: Rows, first: Workspace, sizes: Sizes, switches: Integers2, lane: int, begins: bool, end: float
) -> None:
    """Update the largest speed of each switch so far, and the force that gives it within the switch's length; begins:
    at the start of the run, which lasts until `end`."""
    for s in range(sizes.switches):
        row, speed = first.change + layout.change_speeds(sizes) + s, number(rows, first, sizes, lane, s, layout.SPEED)
        slowest = SLOWEST * number(rows, first, sizes, lane, s, layout.SIZE) / end
        speed = max(speed, slowest) if begins or speed > rows[row, lane] else rows[row, lane]
        i = switches[s, SWITCH_FIRST]
        alone = rows[first.change + layout.border_alone(sizes) + i, lane]
        gives = max(rows[first.change + layout.border_place(i, i), lane], NOISE * alone)
        force = speed * speed / (gives * number(rows, first, sizes, lane, s, layout.SIZE)) if gives > 0.0 else np.inf
        rows[row, lane], rows[first.change + layout.change_forces(sizes) + s, lane] = speed, force


@inlined
def still(rows: Rows, first: Workspace, sizes: Sizes, lane: int, switch: int) -> float:
    """Return the speed (m/s or rad/s) below which a switch is at rest."""
    return STILL * rows[first.change + layout.change_speeds(sizes) + switch, lane]


@inlined
def slow(rows: Rows, first: Workspace, sizes: Sizes, lane: int, switch: int) -> float:
    """Return the speed (m/s) below which the direction of sliding in a plane is roundoff."""
    return SLOW * rows[first.change + layout.change_speeds(sizes) + switch, lane]


@apart
def solve_impulses(r: Reactions) -> None:
    """Add impulses to x that change the rates of the wanted rows by `free`."""
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


@apart
def find_impulses(r: Reactions, rows: Rows, first: Workspace, sizes: Sizes, lane: int) -> None:
    """Find impulses x as `solve_impulses` does. Where the two tangents of a contact depend on each other, their rates
    change by the nearest values that are possible."""
    p = r.problem
    _solve_anew(r, sizes)
    for s in range(sizes.switches):
        end, asked, lacks = p.switches[s, SWITCH_FIRST] + p.switches[s, SWITCH_ROWS], 0.0, 0.0
        for i in range(end - p.switches[s, SWITCH_TANGENTS], end):
            left = p.free[i] - _changed(r, i)
            asked, lacks = asked + p.free[i] * p.free[i], lacks + left * left
        least = MOVES * still(rows, first, sizes, lane, s)
        if p.switches[s, SWITCH_TANGENTS] == 2 and asked > least * least and lacks > REACHED * REACHED * asked:
            held = end - 1 if p.x[end - 1] == 0.0 else end - 2  # the tangent that moves with the other one, or not
            moves, wanted = 2 * end - 3 - held, p.free[held]
            r.wanted[held] = 0.0
            _solve_anew(r, sizes)
            before, asked = _changed(r, held), p.free[moves]
            p.free[moves] = asked + 1.0
            _solve_anew(r, sizes)
            with_it = _changed(r, held) - before
            change = with_it * (wanted - before) / (1.0 + with_it * with_it)
            p.free[moves], p.free[held] = asked + change, before + with_it * change
            _solve_anew(r, sizes)


@inlined
def _solve_anew(r: Reactions, sizes: Sizes) -> None:
    for i in range(sizes.switched):
        r.problem.x[i] = 0.0
    solve_impulses(r)


@inlined
def _changed(r: Reactions, row: int) -> float:
    """Return the change of the rate of a row by the impulses x."""
    total = 0.0
    for j in range(r.problem.free.size):
        total += r.problem.S[row, j] * r.problem.x[j]
    return total


@inlined
def along(r: Reactions, switch: int, x: np.ndarray) -> float:
    """Return the length of the tangential part of a vector."""
    p, total = r.problem, 0.0
    end = p.switches[switch, SWITCH_FIRST] + p.switches[switch, SWITCH_ROWS]
    for i in range(end - p.switches[switch, SWITCH_TANGENTS], end):
        total += x[i] * x[i]
    return np.sqrt(total)
