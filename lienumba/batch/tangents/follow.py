"""Tangents of one run along the steps that it made.

The derivative is that of the discrete method, with the steps held: of each stage, of the projections at their converged
state, of what is sampled. Where a step ends at an event, its end moves with the event. What is asked between the ends
of steps is read off a step of the same method that ends there.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from lienumba.batch.tangents import changes
from lienumba.batch.tangents.marcher import Marcher, Point
from lienumba.integrators import layout
from lienumba.integrators.drivers.trail import ACTS, CAUSES, CLOSES, GOES_ON, HEAD, KICKS, SAMPLES, STEPS
from lienumba.integrators.drivers.workspace import Plan
from lienumba.integrators.layout import (
    ACTION,
    CONDITIONS,
    ENGAGES,
    LOCKS,
    OFF,
    SWITCH_FIRST,
    SWITCH_KIND,
    UNILATERAL,
)
from lienumba.integrators.tracing.tangents.jumps import Jumps, Where

EVENT, SIGNAL = range(2)  # what a look is at, in this order at one time
ROUNDING = 1e-12  # of times
SEEN = 1e-6  # of a signal, by which its value may be another one
AT_END = 1e-10  # of the time of a change: what is seen so near to it is seen at it
MARGIN = 1e-6  # of a step: so far before a bend of forces it ends, and behind it goes on,
ROUNDED = 4.0  # and at least so many roundings of the time
REFINEMENTS = 8  # of the place of a bend
REST = 1e-4  # of a step that ends with a change: its last part, in which a body may come to rest


class Look(NamedTuple):
    """At a time (s) something is asked: the first time of an event, or a signal, which is this value then, by its
    number; event: that whose time this is, and moves with it, -1 if none."""

    t: float
    kind: int
    number: int
    value: float = np.nan
    event: int = -1


@dataclass
class Found:
    """What was found of a run for the inputs of a pack.

    records (outputs + 1, rows, W): tangents of records, the last one of where the run ended; times (events, W): of the
    first times of events; signals (kept, W); rates (events,): how fast their conditions grew then (1/s); flags: see
    `changes.FLAGS`.
    """

    records: np.ndarray
    times: np.ndarray
    signals: np.ndarray
    rates: np.ndarray
    flags: int = 0


class Crossing(NamedTuple):
    """At this part of a step forces bend or, if they leap, jump, where these comparisons of `jumps` turn."""

    jumps: Jumps
    comparisons: tuple[int, ...]
    part: float
    leaps: bool


class Trodden(NamedTuple):
    """What a run went through: entries of its trail (`drivers.trail`), times (s) at which F may jump with their
    tangents (jumps, inputs), its events, and crossings of the step of an entry, in their order."""

    entries: np.ndarray
    jumps: np.ndarray
    jump_tangents: np.ndarray
    plan: Plan
    crossings: Mapping[int, list[Crossing]]


@dataclass
class Follower:
    """Follows a run with one pack of inputs. outputs: their times, of which the next one is at `place`; looks: others,
    in their order; signals: which one each `SIGNAL` is about; holds: whether something has been turned on that is yet
    to be stopped, though it may have been at rest."""

    marcher: Marcher
    point: Point
    outputs: np.ndarray
    looks: list[Look]
    run: Trodden
    found: Found
    signals: Sequence[int]
    place: int = 0
    holds: bool = False

    def __post_init__(self) -> None:
        self.start = self.point.copy()

    def follow(self) -> Found:
        """All that it went through."""
        entries, n = self.run.entries, 0
        if self.marcher.machine.kernels[layout.SAMPLE]:
            self._sample()
        rough = np.flatnonzero(np.append(~self._smooth(), True))
        while n < len(entries):
            entry = entries[n]
            kind, t, what, length = int(entry[0]), *(float(x) for x in entry[1:HEAD])
            after = entry[HEAD : HEAD + self.marcher.rows]
            if kind == STEPS:
                self._see_here(t)
                last = int(rough[np.searchsorted(rough, n)])
                causes = self._causes(n)
                if last > n:
                    after = self._stride(n, last)
                    n = last - 1
                elif n in self.run.crossings:
                    self._bend(t, what, causes, self.run.crossings[n])
                else:
                    self._step(t, what, length, causes)
            else:
                self._change(kind, what, entry, after)
            if not np.isnan(after).any():
                self.point.x[0] = after[:, None]
            if self.found.flags & changes.FATAL:
                self._lose()
                return self.found
            n += 1
        self._see_here(self.point.t * (1.0 + ROUNDING))
        for look in self.looks:
            if look.t <= self.point.t * (1.0 + ROUNDING) and look.kind == SIGNAL:
                self._see(look, self.point)
        self.place = len(self.outputs)
        self._record(self.point)
        return self.found

    def _causes(self, n: int) -> list[int]:
        """The conditions that become true at the end of a step, where a change follows or the run ends. Those of other
        contacts that close in this change come last."""
        entries, end = self.run.entries, self.run.entries[n, 2]
        change = _behind(entries, n)
        found = [int(x[2]) for x in change if x[0] == CAUSES]
        if found:
            found += [x for x in self._closed_by(change) if x not in found]
        if n == len(entries) - 1:
            stops = self.run.plan.stops
            found += [x.number for x in self.looks if x.kind == EVENT and x.t == end and stops[x.number]]
        return found

    def _closed_by(self, change: Sequence[np.ndarray]) -> Iterator[int]:
        """The conditions of open contacts that take part in a change: of those that close at one time, the trail has
        the first one alone."""
        sizes, switches = self.marcher.machine.sizes, self.run.plan.switches
        on = layout.on_row(sizes)
        for s, switch in enumerate(switches):
            if switch[SWITCH_KIND] != UNILATERAL or self.point.x[0, on + s, 0] != OFF:
                continue
            impulse = switch[SWITCH_FIRST] - sizes.switched
            pushed = any(entry[0] == KICKS and entry[impulse] != 0.0 for entry in change)
            if pushed or any(entry[0] == GOES_ON and entry[HEAD + on + s] != OFF for entry in change):
                yield sizes.events + CONDITIONS * s

    def _smooth(self) -> np.ndarray:
        """Which entries are steps that can be made one after the other."""
        entries, sizes = self.run.entries, self.marcher.machine.sizes
        found = entries[:, 0] == STEPS
        found[:-1] &= entries[1:, 0] != CAUSES
        found[[*self.run.crossings]] = False
        moving = self.run.jumps[self.run.jump_tangents.any(axis=1)]
        found &= ~np.isin(entries[:, 2], moving)
        for look in self.looks:
            found &= ~((entries[:, 1] < look.t) & (look.t <= entries[:, 2]) & (entries[:, 0] == STEPS))
        if sizes.exchangeable and len(entries):  # other rows of constraints are in use from here on
            first = layout.element_rows(sizes) + sizes.first_mask
            rows = entries[:, HEAD + first : HEAD + first + sizes.exchangeable]
            before = np.concatenate([self.point.x[0, first : first + sizes.exchangeable, :1].T, rows[:-1]])
            found &= ~((rows != before) & ~np.isnan(rows)).any(axis=1)
        return found

    def _stride(self, first: int, last: int) -> np.ndarray:
        """The steps of these entries and the outputs on the way; returns the state of the run behind them. An output
        at the end of the last one is seen behind what happens there."""
        steps = self.run.entries[first:last, 1:HEAD]
        begin, end, length = steps.T
        stop = int(np.searchsorted(self.outputs, end[-1], "left"))
        asked = np.arange(self.place, stop)
        times = self.outputs[asked]
        of = np.searchsorted(end, times, "left")
        inside = times < end[of]
        rows = np.full((len(steps), 5), -1.0)
        rows[:, 0], rows[:, 1], rows[:, 4] = begin, end, 1.0
        rows[:, 2] = np.where(length > 0.0, length, end - begin)
        rows[of[~inside], 3] = asked[~inside]
        sides = np.full((int(inside.sum()), 5), 0.0)
        at = of[inside]
        sides[:, 0], sides[:, 1], sides[:, 3] = begin[at], times[inside], asked[inside]
        sides[:, 2] = sides[:, 1] - sides[:, 0]
        rows = np.insert(rows, at, sides, axis=0)
        self.marcher.march(self.point, rows.T, records=self.found.records)
        self.place = stop
        after: np.ndarray = self.run.entries[last - 1, HEAD : HEAD + self.marcher.rows]
        return after

    def _change(self, kind: int, what: float, entry: np.ndarray, after: np.ndarray) -> None:
        """What is no step."""
        if kind == SAMPLES:
            self._sample()
        elif kind == ACTS:
            changes.act(self.marcher, self.point, self.run.plan, int(what))
            self.holds = self.holds or LOCKS <= self.run.plan.acts[int(what), ACTION] <= ENGAGES
        elif kind == KICKS or (kind == GOES_ON and self.holds and what == 0.0):
            impulses = entry[len(entry) - self.marcher.machine.sizes.switched :]
            impulses = np.zeros(len(impulses)) if kind == GOES_ON else impulses
            self.found.flags |= changes.kick(
                self.marcher, self.point, self.run.plan, impulses, kind == KICKS and what != 0.0
            )
            self.holds = False
        if kind == GOES_ON:
            changes.remember(self.marcher, self.point, self.run.plan, after)
        elif kind == CLOSES:
            changes.close(self.marcher, self.point)

    def _see_here(self, t: float) -> None:
        """The outputs up to this time, at the point."""
        while self.place < len(self.outputs) and self.outputs[self.place] <= t:
            self._record(self.point)
        while self.looks and self.looks[0].t <= t and self.looks[0].kind == SIGNAL:
            self._see(self.looks.pop(0), self.point)

    def _record(self, there: Point) -> None:
        """The next output, at a point."""
        rows, record = self.marcher.machine.sizes.observed, self.found.records[self.place]
        record[: self.marcher.rows] = there.x[1]
        if rows:
            observed = self.marcher.evaluate(layout.OBSERVE, there, rows)[1]
            record[self.marcher.rows : self.marcher.rows + rows] = observed
        self.place += 1

    def _lose(self) -> None:
        """What is asked later is unknown."""
        self.found.records[self.place :] = np.nan
        for look in self.looks:
            of = self.found.times if look.kind == EVENT else self.found.signals
            of[look.number] = np.nan

    def _sample(self) -> None:
        """Laws of the user's own."""
        rows = layout.element_rows(self.marcher.machine.sizes)
        self.point.x[:, :rows] = self.marcher.evaluate(layout.SAMPLE, self.point, rows)

    def _step(self, begin: float, end: float, length: float, causes: Sequence[int]) -> None:
        """A step, which ends where these conditions come true, and what is asked within it."""
        moves = bool(causes) or self._moving(end) is not None
        while self._next() < end or (moves and self._next() == end):  # outputs do not move with its end
            side, t = self.point.copy(), self._next()
            self.marcher.march(side, np.array([[begin], [t], [t - begin]]))
            self._record(side)
        while self.looks and self._is_within(self.looks[0], end, bool(causes)):
            look = self.looks.pop(0)
            side, part = self.point.copy(), np.array([[begin], [look.t], [look.t - begin]])
            if look.t > begin:
                self.marcher.march(side, part)
            if look.kind == EVENT:
                self._cross(look, part, side)
                continue
            if look.event >= 0 and look.t > begin:
                side.moves = self.found.times[look.event]
                side.x[1] += self._along(part, side)[:, None] * side.moves
            self._see(look, side)
        times = np.array([[begin], [end], [length or end - begin]])
        if moves:
            self._reach(times, causes)
        else:
            self.marcher.march(self.point, times)

    def _moving(self, t: float) -> np.ndarray | None:
        """The tangents of a time (W,) at which F may jump, if inputs move it; where they move one of several that are
        the same now, of this one."""
        here = self.run.jump_tangents[self.run.jumps == t]
        if not here.any():
            return None
        if (here != here[0]).any():
            self.found.flags |= changes.SIMULTANEOUS
        found: np.ndarray = here[np.abs(here).max(axis=1).argmax()]
        return found

    def _next(self) -> float:
        """The time of the next output."""
        return float(self.outputs[self.place]) if self.place < len(self.outputs) else np.inf

    def _bend(self, begin: float, end: float, causes: Sequence[int], crossings: Sequence[Crossing]) -> None:
        """A step in which forces bend or jump, in parts; the time of a jump moves with the inputs."""
        margin = max(MARGIN * (end - begin), ROUNDED * float(np.spacing(end)))
        start = begin
        for crossing in crossings:
            place = max(begin + crossing.part * (end - begin), start + 2.0 * margin)
            for _ in range(REFINEMENTS):  # the line from begin to end is not the way of the run
                part = np.array([[start], [place - margin], [place - margin - start]])
                there = self.point.copy()
                self.marcher.march(there, part)
                along = self._along(part, there)
                moves, ahead = self._time_of(crossing, there, along)
                if not abs(ahead - margin) > 0.5 * margin or not start < place + ahead - 2.0 * margin < end:
                    break
                place += ahead - margin
            behind = min(place + ahead, end)
            late = place + ahead > end + 2.0 * margin or (behind == end and causes)
            if late or not start < behind:  # by roundoff, or since the guard function has no slope
                self.found.flags |= changes.GRAZING if crossing.leaps else 0
                continue
            self._step(start, place - margin, 0.0, ())
            self.point.x[0] += (behind - place + margin) * along[:, None]
            self.point.t = start = behind
            if crossing.leaps:
                self.found.flags |= 0 if np.isfinite(moves).all() else changes.GRAZING
                self.point.moves = moves
                self.point.x[1] += along[:, None] * moves
        if start < end:
            self._step(start, end, 0.0, causes)

    def _time_of(self, crossing: Crossing, there: Point, along: np.ndarray) -> tuple[np.ndarray, float]:
        """The tangents of the time (W,) when a comparison turns, and how far ahead (s) of a point that is; along: how
        the state moves on with the time. Of those that turn together one that changes there says it: a force that
        begins with a square does not."""
        slots = self.marcher.machine.slots
        values, own = np.split(self.marcher.memory["parameters"][: 2 * slots], 2)
        where, none = Where(there.x[0, :, 0], values[:, 0], there.t), np.zeros(len(there.moves))
        moving, found, ahead = np.repeat(along[:, None], len(none), axis=1), np.full(len(none), np.nan), 0.0
        for n in crossing.comparisons:
            held = crossing.jumps.moves(n, where, there.x[1], own, none)
            rate = crossing.jumps.moves(n, where, moving, 0.0 * own, none + 1.0)
            if np.isnan(found).any() and (rate != 0.0).all():
                found, ahead = -held / rate, -crossing.jumps.value(n, where) / float(rate[0])
        return found, ahead

    def _is_within(self, look: Look, end: float, changes_there: bool) -> bool:
        """Whether a look is seen apart from the end of a step."""
        if look.kind == SIGNAL and changes_there:  # what is largest as a change comes is so at the change
            return look.t < end * (1.0 - AT_END)
        return look.t < end or (look.t == end and look.kind == EVENT and not changes_there)

    def _reach(self, times: np.ndarray, causes: Sequence[int]) -> None:
        """A step to where conditions come true; the time of the first one is the end of the step. Its last part is made
        apart: where a body comes to rest, the direction of its friction is unknown to the last stages."""
        begin, end, before_it = times[0, 0], times[1, 0], self.point.copy()
        before = end - REST * (end - begin)
        if begin < before < end:
            self.marcher.march(self.point, np.array([[begin], [before], [before - begin]]))
            times = np.array([[before], [end], [end - before]])
        there = self.point.copy()
        self.marcher.march(there, times)
        along = self._along(times, there)
        known = {n: changes.cause(self.marcher, there, along, n) for n in causes}
        if np.isin(end, self.run.jumps):  # at a time that is given
            moves = self._moving(end)
            first = changes.Cause(np.zeros(len(there.moves)) if moves is None else moves, np.inf)
        else:
            first = known[causes[0]]
            if self._grazes(before_it, there, causes[0], first.rate):
                first = known[causes[0]] = first._replace(tangents=np.full_like(first.tangents, np.nan))
        if not np.isfinite(first.tangents).all():
            self.found.flags |= changes.GRAZING
        apart = (x for x in known.values() if not np.allclose(x.tangents, first.tangents, changes.SAME, 0.0, True))
        if np.isfinite(first.rate) and any(True for _ in apart):
            self.found.flags |= changes.SIMULTANEOUS
        there.x[1] += along[:, None] * first.tangents
        there.moves = first.tangents.copy()
        self.point = there
        later = [look for look in self.looks if look.t > end]
        for look in self.looks[: len(self.looks) - len(later)]:
            if look.kind == EVENT:  # one that comes true by the change happens with it
                self.found.times[look.number], self.found.rates[look.number] = known.get(look.number, first)
            elif not self._see(look, there):
                later.insert(0, look)
        self.looks = later

    def _grazes(self, begin: Point, end: Point, condition: int, rate: float) -> bool:
        """Whether the crossing at the end of a step is grazing."""
        size = abs(changes.value(self.marcher, self.start, condition))
        return changes.grazes(self.marcher, begin, end, condition, rate, size)

    def _along(self, times: np.ndarray, there: Point) -> np.ndarray:
        """How the state at the end of a step changes with the length of the step (rows,)."""
        moved = self.point.copy()
        self.marcher.march(moved, times, np.ones_like(self.point.moves))
        changed: np.ndarray = (moved.x[1] - there.x[1])[:, 0]
        return changed

    def _see(self, look: Look, there: Point) -> bool:
        """A signal, at a point; whether it has the value there that was kept: else it jumps, and is seen behind."""
        found = self.marcher.evaluate(layout.MEASURE, there, self.marcher.machine.sizes.signals)
        value, tangents = found[:, self.signals[look.number]]
        self.found.signals[look.number] = tangents
        return bool(abs(value[0] - look.value) <= SEEN * abs(look.value))

    def _cross(self, look: Look, part: np.ndarray, there: Point) -> None:
        """An event at which nothing changes; one that holds from the start on stays there."""
        if part[2, 0] > 0.0:
            moves, rate = changes.cause(self.marcher, there, self._along(part, there), look.number)
            if self._grazes(self.point, there, look.number, rate):
                self.found.flags |= changes.TOUCHED
                moves = np.full_like(moves, np.nan)
            self.found.times[look.number], self.found.rates[look.number] = moves, rate
        else:
            self.found.times[look.number], self.found.rates[look.number] = 0.0, np.inf


def _behind(entries: np.ndarray, n: int) -> list[np.ndarray]:
    """The entries of the change that follows a step."""
    found = []
    for entry in entries[n + 1 :]:
        if entry[0] == STEPS:
            break
        found.append(entry)
    return found
