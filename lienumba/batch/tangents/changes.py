"""Tangents through a change: of its time, of what events set, of impulses.

All at the time of the change, which moves itself: tangents are those of the state as it is then, whenever that is. The
time follows from the condition that becomes true, impulses from the laws that they fulfil (restitution, sticking,
sliding), in the modes that the run has found.
"""

from typing import NamedTuple

import numpy as np

from lienumba.batch.tangents.marcher import Marcher, Point
from lienumba.compiler.rows import W
from lienumba.integrators import layout
from lienumba.integrators.drivers.switching.closing import CLOSING
from lienumba.integrators.drivers.tangents import SETTLING
from lienumba.integrators.drivers.workspace import Plan
from lienumba.integrators.layout import (
    ACTION,
    BILATERAL,
    CLOCK_ROW,
    ENGAGES,
    FRICTION,
    KINETIC,
    LOCKS,
    RESTITUTION,
    SETS,
    SWITCH_FIRST,
    SWITCH_KIND,
    SWITCH_MEMORIES,
    SWITCH_MEMORY,
    SWITCH_ROWS,
    SWITCH_TANGENTS,
    TARGET,
    TARGETS,
    VALUE,
)

AT_REST = 1e-9  # of the largest speed in an impact: what is no faster has been stopped
SAME = 1e-6  # relative difference of two tangents of a time, or of two coefficients, that say the same
LOCATED = 1e-15  # error of a located zero crossing, relative to the size of the guard function
GRAZES = 1e-6  # relative error of the rate there, above which the crossing is grazing
SIMULTANEOUS, GRAZING, REDUCED, MISSING, TOUCHED = 1, 2, 4, 8, 16  # flags: see `FLAGS`
FLAGS = {
    SIMULTANEOUS: "several events happen at one time, and inputs move them apart: the derivative is one-sided",
    GRAZING: "an event grazes its condition: its time has no derivative, nor has what follows",
    REDUCED: "impulses in which friction of a joint slides, or the rebound was reduced, have no derivative",
    MISSING: "the run failed, or no run begins where its inputs differ a little",
    TOUCHED: "an event that only records grazes its condition: its time has no derivative",
}
FATAL = GRAZING | REDUCED  # behind which nothing is known


class Cause(NamedTuple):
    """tangents: of the time (W,); rate: of the condition along the motion (1/s)."""

    tangents: np.ndarray
    rate: float


def cause(marcher: Marcher, point: Point, along: np.ndarray, condition: int) -> Cause:
    """When a condition comes true; point: with its time held, along: (rows,) how its state moves on with the time."""
    sizes = marcher.machine.sizes
    held = marcher.evaluate(layout.EVENTS, point, layout.event_rows(sizes))[1, condition]
    moving = Point(np.stack([point.x[0], np.repeat(along[:, None], W, axis=1)]), point.t, np.ones(W))
    rate = float(marcher.evaluate(layout.EVENTS, moving, layout.event_rows(sizes))[1, condition, 0])
    start = point.x[1] * 0.0  # what inputs change by themselves is in `held`, and here again
    still = Point(np.stack([point.x[0], start]), point.t)
    own = float(marcher.evaluate(layout.EVENTS, still, layout.event_rows(sizes))[1, condition, 0])
    rate -= own
    with np.errstate(divide="ignore", invalid="ignore"):
        return Cause(-held / rate, rate)


def value(marcher: Marcher, point: Point, condition: int) -> float:
    """The guard function of a condition at a point: above 0 where the condition is true."""
    return float(marcher.evaluate(layout.EVENTS, point, layout.event_rows(marcher.machine.sizes))[0, condition, 0])


def grazes(marcher: Marcher, begin: Point, end: Point, condition: int, rate: float, size: float) -> bool:
    """Whether the guard function grazes 0 at the end of a step: roundoff in the time of the crossing changes the rate.
    size: of the guard function at the start of the run; its curvature is the mean one over the step."""
    h, before, after = end.t - begin.t, *(value(marcher, x, condition) for x in (begin, end))
    if h <= 0.0 or not np.isfinite(rate):
        return False
    curvature = 2.0 * abs(before - after + rate * h) / h**2
    return curvature * LOCATED * max(size, abs(before)) > GRAZES * rate**2


def act(marcher: Marcher, point: Point, plan: Plan, event: int) -> None:
    """What an event sets, and what it turns on."""
    sizes = marcher.machine.sizes
    if plan.acts[event, ACTION] == SETS:
        values = marcher.evaluate(layout.EVENTS, point, layout.event_rows(sizes))[1]
        first, target = layout.conditions(sizes) + plan.acts[event, VALUE], plan.acts[event, TARGET]
        for n in range(plan.acts[event, TARGETS]):
            point.x[1, plan.targets[target + n]] = values[first + n]
    if LOCKS <= plan.acts[event, ACTION] <= ENGAGES:
        first = plan.acts[event, TARGET]
        for s in plan.targets[first : first + plan.acts[event, TARGETS]]:
            _keep(marcher, point, plan, int(s))
    if plan.acts[event, CLOCK_ROW] >= 0:
        point.x[1, plan.acts[event, CLOCK_ROW]] = point.moves


def remember(marcher: Marcher, point: Point, plan: Plan, after: np.ndarray) -> None:
    """What switches keep of the state in which they begin to hold, where that is new in the state `after`; the
    direction in which something slides is no such thing."""
    sizes = marcher.machine.sizes
    first = layout.memory_row(sizes)
    changed = after[first : first + sizes.memory] != point.x[0, first : first + sizes.memory, 0]
    for s, switch in enumerate(plan.switches):
        own = switch[SWITCH_MEMORY]
        if changed[own : own + switch[SWITCH_MEMORIES]].any():
            _keep(marcher, point, plan, s)


def _keep(marcher: Marcher, point: Point, plan: Plan, s: int) -> None:
    """What a switch keeps if it begins to hold now."""
    sizes, switch = marcher.machine.sizes, plan.switches[s]
    first, own = layout.memory_row(sizes), switch[SWITCH_MEMORY]
    border = marcher.evaluate(layout.BORDER, point, layout.border_rows(sizes))[1]
    kept = 0 if switch[SWITCH_KIND] == BILATERAL else switch[SWITCH_TANGENTS]
    for n in range(own, own + switch[SWITCH_MEMORIES]):
        point.x[1, first + n] = border[layout.border_memory(sizes) + n] if n >= own + kept else 0.0


def close(marcher: Marcher, point: Point) -> None:
    """Joints that close over their gaps: positions onto the constraints, then velocities, with which bodies move on as
    before, onto those that always hold."""
    machine, sizes = marcher.machine, marcher.machine.sizes
    rows, (_, tolerance) = layout.element_rows(sizes), marcher.limits
    if not machine.kernels[layout.POSITION]:
        return
    kernel = layout.CLOSURE if machine.kernels[layout.CLOSURE] else layout.POSITION
    before, iterated = point.copy(), rows + sizes.correction
    iterate = np.zeros((2, iterated, W))
    iterate[:, :rows] = before.x[:, :rows]
    left = SETTLING
    for _ in range(CLOSING):
        found = marcher.evaluate(kernel, before, iterated + layout.VIOLATION + 1, iterate)
        iterate = found[:, :iterated]
        left -= 1 if found[0, iterated + layout.VIOLATION, 0] <= tolerance else 0
        if not left:
            break
    point.x[:, :rows] = iterate[:, :rows]
    if machine.kernels[layout.CARRY]:
        point.x[:, :rows] = marcher.evaluate(layout.CARRY, point, rows, before.x)
    point.x[0, layout.mask_row(sizes) : layout.on_row(sizes)] = 0.0
    for _ in range(SETTLING if machine.kernels[layout.VELOCITY] else 0):
        point.x[:, :rows] = marcher.evaluate(layout.VELOCITY, point, rows)


def kick(marcher: Marcher, point: Point, plan: Plan, impulses: np.ndarray, halts: bool) -> int:
    """What impulses (q,) do to the velocities; returns flags. halts: whether they stop what hardly moves."""
    sizes = marcher.machine.sizes
    q, rows = sizes.switched, layout.kick_rows(sizes)
    rates = slice(layout.kick_rates(sizes), layout.kick_rates(sizes) + q)

    def kicked(at: Point, x: np.ndarray, dx: np.ndarray) -> np.ndarray:
        return marcher.evaluate(layout.KICK, at, rows, np.stack([np.repeat(x[:, None], W, axis=1), dx]))

    none, held = np.zeros((q, W)), Point(np.stack([point.x[0], 0.0 * point.x[1]]), point.t)
    before = kicked(point, np.zeros(q), none)[:, rates]
    after = kicked(point, impulses, none)[:, rates]
    S = np.empty((q, q))
    with marcher.held():  # by impulses alone, so that lanes do not feel each other
        for first in range(0, q, W):
            units, count = np.zeros((q, W)), min(W, q - first)
            units[range(first, first + count), range(count)] = 1.0
            S[:, first : first + count] = kicked(held, impulses, units)[1, rates][:, :count]
    laws = _Laws(np.zeros((q, q)), np.zeros((q, W)), S, before, after, impulses)
    border = marcher.evaluate(layout.BORDER, point, layout.border_rows(sizes))
    flags = 0
    for s, switch in enumerate(plan.switches):
        number = layout.border_numbers(sizes) + layout.CONTACT_NUMBERS * s
        coefficients = border[:, number : number + layout.CONTACT_NUMBERS]
        on = point.x[0, layout.on_row(sizes) + s, 0] != layout.OFF
        flags |= laws.add(switch, bool(on), coefficients, halts)
    changes = np.einsum("ij,jk->ik", np.linalg.pinv(laws.matrix, rcond=1e-13), laws.given)
    missed = np.abs(laws.matrix @ changes - laws.given).max(initial=0.0)
    flags |= SIMULTANEOUS if missed > SAME * np.abs(laws.given).max(initial=0.0) else 0
    point.x[1] = kicked(point, impulses, changes)[1, : marcher.rows]
    return flags


class _Laws(NamedTuple):
    """matrix dx = given: a row for each impulse; S: rates by impulses; before, after (2, q, W): rates and their
    tangents without and with the impulses x, as these are."""

    matrix: np.ndarray
    given: np.ndarray
    S: np.ndarray
    before: np.ndarray
    after: np.ndarray
    x: np.ndarray

    def add(self, switch: np.ndarray, on: bool, coefficients: np.ndarray, halts: bool) -> int:
        """The laws of one switch, which is on or off; coefficients (2, numbers, W); returns flags."""
        first, tangents = switch[SWITCH_FIRST], switch[SWITCH_TANGENTS]
        every = range(first, first + switch[SWITCH_ROWS])
        fastest = max(np.abs(self.before[0, :, 0]).max(), np.abs(self.after[0, :, 0]).max())
        still = np.inf if halts else AT_REST * fastest
        if switch[SWITCH_KIND] == BILATERAL:
            for i in every:
                self._reaches(i, 0.0 * self.given[i]) if on else self._idle(i)
            return 0
        if switch[SWITCH_KIND] == FRICTION:
            i = first
            rests = self.x[i] != 0.0 and abs(self.after[0, i, 0]) <= still
            self._reaches(i, 0.0 * self.given[i]) if rests else self._idle(i)
            return 0 if rests or self.x[i] == 0.0 else REDUCED
        if self.x[first] == 0.0 and not halts:
            for i in every:
                self._idle(i)
            return 0
        flags = self._rebounds(first, coefficients[:, RESTITUTION], still)
        along = [*every][len(every) - tangents :]
        slides = self.after[0, along, 0]
        speed = float(np.sqrt(slides @ slides))
        if not tangents or speed <= still:
            for i in along:
                sticks = self.x[i] != 0.0 or coefficients[0, KINETIC, 0] > 0.0
                self._reaches(i, 0.0 * self.given[i]) if sticks else self._idle(i)
            return flags
        friction, turn = coefficients[:, KINETIC], slides / speed
        across = (np.eye(tangents) - np.outer(turn, turn)) / speed
        normal, mu = self.x[first], friction[0, 0]
        for n, i in enumerate(along):  # x_i + mu x_normal turn = 0
            self.matrix[i, i] += 1.0
            self.matrix[i, first] += mu * turn[n]
            self.matrix[i] += mu * normal * across[n] @ self.S[along]
            self.given[i] = -friction[1] * normal * turn[n] - mu * normal * across[n] @ self.after[1, along]
        return flags

    def _idle(self, i: int) -> None:
        """No impulse."""
        self.matrix[i, i] = 1.0

    def _reaches(self, i: int, tangents: np.ndarray) -> None:
        """The rate of the row afterwards has these tangents."""
        self.matrix[i], self.given[i] = self.S[i], tangents - self.after[1, i]

    def _rebounds(self, i: int, restitution: np.ndarray, still: float) -> int:
        """Newton's restitution at a normal row."""
        came, leaves = self.before[0, i, 0], self.after[0, i, 0]
        if abs(leaves) <= still:
            self._reaches(i, 0.0 * self.given[i])
            return 0
        self._reaches(i, -restitution[0, 0] * self.before[1, i] - restitution[1] * came)
        kept = came < 0.0 and abs(leaves + restitution[0, 0] * came) <= SAME * abs(came)
        return 0 if kept else REDUCED
