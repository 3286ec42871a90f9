"""The engine of tests/oracles/mechanisms with what changes: events that act, rigid stops, contacts without friction,
friction of joints that sticks.

Each mode is a mechanism of its own: the functions of what is on, together. A change is Newton's and Euler's equations
in impulses, solved as they stand; which of the unilateral constraints push is found by trying all of their subsets.
Times are found on SciPy's dense output, and made good by integrating up to them.
"""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from functools import partial
from itertools import product
from typing import Any

import numpy as np
from scipy.integrate import DOP853
from scipy.optimize import brentq

from tests.oracles.mechanisms import joints
from tests.oracles.mechanisms.engine import Motion
from tests.oracles.mechanisms.numbers import number
from tests.oracles.mechanisms.places import Array, Function, Places, State, vee
from tests.oracles.switching.laws import Condition, UnlikeError, complementary
from tests.oracles.switching.modes import Modes, Table

AT_ONCE = 1e-11  # s
BESIDE = 1e-9  # s: so near to a change it is not known on which side of it something is seen
TOUCHES = 1e-9  # m or rad
STILL = 1e-9  # m/s or rad/s
RESTS = 1e-7  # the same, of what may stick
CLOSED = 1e-9  # m or rad: how far apart what is engaged may be, for nothing here moves bodies together
BAND = 1e-9  # of the largest number of a condition: so far it falls before it can come true again
SAMPLES = 6  # of conditions in a step
ROUNDS = 64  # at one time


@dataclass(frozen=True)
class Change:
    """What happened: when (s), as which kind, to which event or switch."""

    t: float
    kind: str
    what: str


@dataclass
class Course:
    """Of a run: motions at the times that were asked for, as far as it came, with what was on, and behind what changes
    at such a time; all changes; times of events; what impulses took (J); how it ended."""

    motions: list[Motion] = field(default_factory=list)
    behind: dict[int, Motion] = field(default_factory=dict)
    modes: list[frozenset[str]] = field(default_factory=list)
    changes: list[Change] = field(default_factory=list)
    events: dict[str, list[float]] = field(default_factory=dict)
    lost: float = 0.0
    status: str = "success"
    end: float = 0.0
    undecided: set[str] = field(default_factory=set)  # switches of which nothing tells whether they are closed


class Changing(Modes):
    """Of a scenario: what changes, and the run."""

    def __init__(self, data: Table) -> None:
        super().__init__(data)
        self.quantities = {q["name"]: q for q in self.model.get("quantities", [])}
        self.conditions = [Condition(e["when"], self.quantities) for e in self.events]
        self.course = Course()
        self.true: list[bool] = [False] * len(self.events)
        self.largest = [0.0] * len(self.events)
        self.begun = False

    # ------------------------------------------------------------ a change
    def settle(
        self, state: State, t: float, fired: set[int], hit: set[str], gave: frozenset[str] = frozenset()
    ) -> State | None:
        """What happens at a time, to the books; None: the run ends."""
        for _ in range(ROUNDS):
            if any(self.events[n].get("action", "record") == "stop" for n in fired):
                for n in fired:
                    if self.events[n].get("action", "record") in ("record", "stop"):
                        self._note(n, t)
                self.course.status = "stopped"
                return None
            if not self._act(state, t, fired):
                return None
            state = self._impulses(state, t, hit)
            self._decide(state, t, gave)
            gave = frozenset()
            values = [self.value(n, state, t) for n in range(len(self.events))]
            true = [self._holds(n, values[n]) or n in fired for n in range(len(self.events))]
            fired = {n for n, now in enumerate(true) if now and not self.true[n]}
            self.true = true
            fired = {n for n in sorted(fired) if self._useful(n, t, fired)}
            hit = set()
            if not fired:
                return state
        raise UnlikeError("endless changes")

    def value(self, n: int, state: State, t: float) -> float:
        """Of a condition, which is true above 0."""
        condition = self.conditions[n]
        m = self.mechanism((*self.carrying, *self.bears))
        now = self.motion(state, t) if condition.forces else Motion(t, state, np.zeros_like(state.u), {}, {}, 0, 1.0)
        if condition.forces and not now.unique:
            raise UnlikeError("a reaction that is not unique")
        x = condition.value(m, now)
        self.largest[n] = max(self.largest[n], abs(x))
        return x

    def _holds(self, n: int, x: float) -> bool:
        return x > 0.0 or (self.true[n] and x > -BAND * self.largest[n])

    def _note(self, n: int, t: float) -> None:
        self.course.events.setdefault(self.events[n]["name"], []).append(t)

    def _useful(self, n: int, t: float, fired: Iterable[int]) -> bool:
        """Whether an event does something, behind those before it in the file."""
        event = self.events[n]
        action, on = event.get("action", "record"), set(self.on)
        for other in sorted(fired):
            if other < n:
                on = self._switches(self.events[other], on)
        if event.get("once") and self.course.events.get(event["name"]):
            return False
        if action in ("lock", "unlock") and event["joint"] in self.bilateral and event["joint"] not in on:
            return False
        return action in ("record", "stop", "set") or self._switches(event, on) != on

    def _switches(self, event: Table, on: set[str]) -> set[str]:
        """What is on when an event has acted."""
        action = event.get("action", "record")
        if action == "engage":
            return on | {event["joint"]}
        if action == "release":
            return on - {event["joint"]} - {name for name in on if name.startswith(f"{event['joint']}.")}
        if action in ("lock", "unlock"):
            own = set(self._locks(event))
            return on | own if action == "lock" else on - own
        return on

    def _locks(self, event: Table) -> Iterator[str]:
        joint = self.every[event["joint"]]
        if joint["type"] == "spherical":
            yield f"{joint['name']}.ball"
        else:
            for kind in joints.COORDINATES[joint["type"]]:
                if event.get("coordinate", kind) == kind:
                    yield f"{joint['name']}.{kind}"

    def _act(self, state: State, t: float, fired: set[int]) -> bool:
        """Actions, in the order of the file; whether the run goes on."""
        was = set(self.on)
        for n in sorted(fired):
            event = self.events[n]
            action = event.get("action", "record")
            self._note(n, t)
            before, self.on = self.on, self._switches(event, self.on)
            if action == "set":
                self.parameters |= {name: float(number(x)(t)) for name, x in event["parameters"].items()}
            for name in self.on - before:
                if name not in self.bilateral or "." in name:
                    self.bilateral[name], self.kept = self._held(name, state, t), self.kept + 1
            told = {"lock": "locked", "unlock": "released", "release": "released", "engage": "engaged", "set": "set"}
            if action in told:
                self.course.changes.append(Change(t, told[action], event["name"]))
        for name in self.on - was:
            if name in self.every:
                apart = float(np.abs(self.bilateral[name](state.places(), t)[0].real).max())
                if apart > CLOSED:
                    closing = next(e.get("closing", 0.02) for e in self.events if e.get("joint") == name)
                    if apart < 2 * closing:
                        raise UnlikeError(f"bodies have to be moved by {apart:.1e} to close {name}")
                    self.course.status = "capture_failed"
                    return False
        return True

    def _held(self, name: str, state: State, t: float) -> Function:
        """What stays 0 while a coordinate is locked where it is."""
        joint = self.every[name.partition(".")[0]]
        if joint["type"] == "spherical":
            (_, A), (_, B) = (state.places()[b] for b in joint["bodies"])
            K = (A[0].T @ B[0]).real

            def turned(places: Places, t: Any) -> Array:
                A, B = (places[b][1] for b in joint["bodies"])
                return vee(K.T @ (A.swapaxes(-1, -2) @ B))

            return turned
        q = joints.coordinate(joint, name.partition(".")[2])
        value = float(q(state.places(), t)[0, 0].real)
        return lambda places, t: q(places, t) - value

    def _impulses(self, state: State, t: float, hit: set[str]) -> State:
        m = self.mechanism()
        B, off, _, rows = m.constraints(state, t)
        touching = [n for n in self.unilateral if n in self.closed or n in hit or self._touches(n, state, t)]
        C, rates, _ = self.rows(touching, state, t)
        comes = [name for name, v in zip(touching, rates, strict=True) if v < -STILL]
        if not comes and np.abs(off).max(initial=0.0) < STILL:
            return state
        wanted = np.zeros(len(touching))
        for i, name in enumerate(touching):
            e, rest = self.restitution[name]
            rebound = -e * rates[i]
            if rates[i] < -STILL and rebound >= rest:
                wanted[i] = rebound
        M, _ = m.forced(state, t)
        u = state.u
        after, held, pushes = complementary(M, M @ u, B, B @ u - off, C, C @ u - rates + wanted)
        largest = max([abs(x) for x in pushes], default=0.0)
        for name, p in zip(touching, pushes, strict=True):
            if p > 1e-7 * largest:
                self.course.changes.append(Change(t, "impact", name))
        changing = [i for name, own in rows.items() if name in self.on for i in range(own.start, own.stop)]
        taken = float(held[changing] @ off[changing] + pushes @ (2 * rates + C @ (after - u)))
        self.course.lost -= 0.5 * taken
        return state.with_velocities(after)

    def _touches(self, name: str, state: State, t: float) -> bool:
        return abs(self.distance(name, state, t)) < TOUCHES

    def _decide(self, state: State, t: float, gave: frozenset[str]) -> None:
        """What stays closed, and sticks, by accelerations: of what is at rest all choices are tried, those first of
        which least slides; gave: what has just been pushed by all that it holds, or does not push any more."""
        moves = self._moves(state, t)
        rest, before = [name for name in self.rubbed if name not in moves], self.heads
        for some in sorted(product((0.0, 1.0, -1.0), repeat=len(rest)), key=lambda x: sum(map(abs, x))):
            begins = {name: d for name, d in zip(rest, some, strict=True) if d}
            self.heads = moves | begins
            if self._fits(state, t, [name for name in rest if name not in begins], begins, gave):
                break
        else:
            raise UnlikeError("friction that neither sticks nor slides")
        if self.begun:
            self.course.changes += [Change(t, "slid", n) for n in self.heads if n not in before]
        self.course.changes += [Change(t, "stuck", n) for n in before if n not in self.heads]
        self.begun = True

    def _moves(self, state: State, t: float) -> dict[str, float]:
        """Where to what may stick moves."""
        rates = {name: float(state.along(q, t)[0][0]) for name, q in self.rubbed.items()}
        return {name: float(np.sign(x)) for name, x in rates.items() if abs(x) > RESTS}

    def _fits(self, state: State, t: float, sticks: list[str], begins: dict[str, float], gave: frozenset[str]) -> bool:
        """Whether forces and accelerations are those of friction if some of what rests sticks, and the rest begins to
        slide; if so, what stays closed."""
        m = self.mechanism()
        B, _, bias, _ = m.constraints(state, t)
        bears, alone = [], B
        for name in sticks:
            row, _, b = self.rows([name], state, t)
            if _rank(B, row) > _rank(B):
                B, bias, bears = np.concatenate([B, row]), np.concatenate([bias, -b]), [*bears, name]
            elif _rank(alone, row) > _rank(alone):
                raise UnlikeError("two that stick where one would do")
        near = [n for n in self.unilateral if n in self.closed or self._touches(n, state, t)]
        C, rates, biases = self.rows(near, state, t)
        rests = np.abs(rates) < 1e-7
        near = [n for n, r in zip(near, rests, strict=True) if r]
        C, biases = C[rests], biases[rests]
        M, Q = m.forced(state, t)
        a, held, pushes = complementary(M, Q, B, bias, C, -biases)
        for name, effort in zip(bears, held[len(held) - len(bears) :], strict=True):
            if abs(effort) > self.dry[name]["static"] * (1.0 - 1e-6 if name in gave else 1.0 + 1e-9):
                return False
        scale = 1.0 + float(np.abs(a).max())
        for name in sticks:
            row, _, b = self.rows([name], state, t)
            if abs(float((row @ a + b)[0])) > 1e-7 * scale:  # which turns here, since all else has it so
                return False
        for name, d in begins.items():
            row, _, b = self.rows([name], state, t)
            if not d * float((row @ a + b)[0]) > 1e-7 * scale:
                return False
        pushing = pushes > 0.0
        if bears and _rank(B, C[pushing]) < _rank(B) + pushing.sum():
            raise UnlikeError("friction and stops that share")
        self.carrying, self.bears = tuple(n for n, p in zip(near, pushing, strict=True) if p), tuple(bears)
        leaves = C @ a + biases
        closed = frozenset(n for n, x in zip(near, leaves, strict=True) if x < 1e-7 * scale)
        closed -= gave.difference(self.carrying)
        self.course.undecided |= {n for n in closed if n not in self.carrying}
        self.course.changes += [Change(t, "closed", n) for n in sorted(closed - self.closed)]
        self.course.changes += [Change(t, "opened", n) for n in sorted(self.closed - closed)]
        self.closed = closed
        return True

    # ------------------------------------------------------------ a run
    def run(self, times: list[float], tolerance: float = 1e-11, most: float = 0.01) -> Course:
        """From the start on; most: the longest step (s)."""
        course, state, t = self.course, self.first.start, 0.0
        left = list(times)

        def tell(to: float, at: Callable[[float], State]) -> None:
            while left and left[0] <= to:
                course.motions.append(self.motion(at(left[0]), left[0]))
                course.modes.append(frozenset(self.on | self.closed | (self.rubbed.keys() - self.heads.keys())))
                left.pop(0)

        fired = {n for n in range(len(self.events)) if self.value(n, state, 0.0) > 0.0}
        self.true = [n in fired for n in range(len(self.events))]
        fired = {n for n in sorted(fired) if self._useful(n, 0.0, fired)}
        self.heads = self._moves(state, 0.0)
        going = self.settle(state, 0.0, fired, set())
        tell(0.0, lambda _: going or state)
        while going is not None and t < times[-1]:
            t, going = self._segment(going, t, times[-1], tolerance, most, tell)
            if going is not None:
                course.behind |= {n: self.motion(going, t) for n, x in enumerate(times) if abs(x - t) < BESIDE}
        course.end = t
        return course

    def _segment(
        self, state: State, t: float, end: float, tolerance: float, most: float, tell: Callable[..., None]
    ) -> tuple[float, State | None]:
        """Up to the next change, and behind it."""
        m, state_of = self.mechanism((*self.carrying, *self.bears)), state.like

        def slope(t: float, y: Array) -> Array:
            return m.slope(state_of(y), t)

        def steps(t: float, y: Array, to: float) -> DOP853:
            return DOP853(slope, t, y, to, rtol=tolerance, atol=0.01 * tolerance, max_step=most)

        watched = self._watched()
        values = {key: self._watch(key, state, t) for key in watched}
        solver = steps(t, state.flat, end)
        while solver.status == "running":
            before, y0 = solver.t, solver.y.copy()
            message = solver.step()
            if solver.status == "failed":
                raise UnlikeError(str(message))
            dense = solver.dense_output()
            last = before
            for s in np.linspace(before, solver.t, SAMPLES + 1)[1:]:
                now = {key: self._watch(key, state_of(dense(s)), s) for key in watched}
                found = [key for key in watched if self._passed(key, values[key], now[key])]
                if not found:
                    values, last = now, s
                    continue
                roots = {key: self._root(key, dense, state_of, last, s, values[key], now[key]) for key in found}
                at = min(roots.values())
                for _ in range(2):
                    lead = min(roots, key=lambda key: roots[key])
                    y = _at(steps, before, y0, at)
                    x, h = self._watch(lead, state_of(y), at), 1e-7 * most
                    rate = (
                        self._watch(lead, state_of(dense(at + h)), at + h)
                        - self._watch(lead, state_of(dense(at - h)), at - h)
                    ) / (2 * h)
                    if abs(rate) < 1e-4:
                        raise UnlikeError(f"{lead} comes to 0 with a rate of {rate:.0e}")
                    if lead[0] != "event" or not self.conditions[lead[1]].timed:
                        at = min(max(at - x / rate, before), s)
                y = _at(steps, before, y0, at)
                happens = {key for key in found if roots[key] <= min(roots.values()) + AT_ONCE}
                close = [key for key in found if key not in happens and roots[key] < at + 1e-7]
                if close:
                    raise UnlikeError("changes follow each other at once")
                tell(min(at + BESIDE, end), partial(_between, state_of, dense, at, y))
                there = state_of(y)
                fired = {key[1] for key in happens if key[0] == "event"}
                for n in fired:
                    self.true[n] = True
                useful = {n for n in sorted(fired) if self._useful(n, at, fired)}
                hit = {str(key[1]) for key in happens if key[0] == "gap"}
                if not useful and not hit and not any(key[0] in ("force", "holds", "slides") for key in happens):
                    return at, there
                gave = frozenset(str(key[1]) for key in happens if key[0] in ("holds", "force"))
                return at, self.settle(there, at, useful, hit, gave)
            tell(solver.t, partial(_between, state_of, dense, np.inf, solver.y))
        return end, None if solver.t >= end else state_of(solver.y)

    def _watched(self) -> list[tuple[str, Any]]:
        gaps = [("gap", n) for n in self.unilateral if n not in self.closed]
        dry = [*(("holds", n) for n in self.bears), *(("slides", n) for n in self.heads)]
        return [*(("event", n) for n in range(len(self.events))), *gaps, *(("force", n) for n in self.carrying), *dry]

    def _watch(self, key: tuple[str, Any], state: State, t: float) -> float:
        what, n = key
        if what == "event":
            x = self.value(n, state, t)
            if self.true[n] and x <= -BAND * self.largest[n]:
                self.true[n] = False
            return x
        if what == "holds":
            return float(self.dry[n]["static"]) - abs(self.force(self.motion(state, t), n))
        if what == "slides":
            return self.heads[n] * float(state.along(self.rubbed[n], t)[0][0])
        return self.distance(n, state, t) if what == "gap" else self.force(self.motion(state, t), n)

    def _passed(self, key: tuple[str, Any], was: float, now: float) -> bool:
        if key[0] == "event":
            return not self.true[key[1]] and now > 0.0
        return now < 0.0 and (key[0] in ("force", "holds") or was > 0.0 or now < -TOUCHES)

    def _root(
        self, key: tuple[str, Any], dense: Any, state_of: Callable[[Array], State], a: float, b: float, fa: float,
        fb: float,
    ) -> float:  # fmt: skip
        if fa == 0.0 or fa * fb > 0.0:
            raise UnlikeError(f"{key} has come to 0 twice")
        return float(brentq(lambda t: self._watch(key, state_of(dense(t)), t), a, b, xtol=1e-15, rtol=1e-15))


def _at(steps: Callable[..., DOP853], t: float, y: Array, to: float) -> Array:
    if to <= t:
        return y
    solver = steps(t, y, to)
    while solver.status == "running":
        solver.step()
    return np.asarray(solver.y)


def _rank(*rows: Array) -> int:
    return int(np.linalg.matrix_rank(np.concatenate(rows), tol=1e-7))


def _between(state_of: Callable[[Array], State], dense: Any, at: float, y: Array, t: float) -> State:
    """Within a step that ends there."""
    return state_of(dense(t) if t < at else y)
