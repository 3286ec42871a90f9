"""The engine of tests/oracles/mechanisms with what changes: events that act, rigid stops, contacts without friction.

Each mode is a mechanism of its own: the functions of what is on, together. A change is Newton's and Euler's equations
in impulses, solved as they stand; which of the unilateral constraints push is found by trying all of their subsets.
Times are found on SciPy's dense output, and made good by integrating up to them.
"""

import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np
from scipy.integrate import DOP853
from scipy.optimize import brentq

from tests.oracles.mechanisms import joints
from tests.oracles.mechanisms.engine import Mechanism, Motion
from tests.oracles.mechanisms.numbers import number
from tests.oracles.mechanisms.places import Array, Function, Places, State, vee
from tests.oracles.switching.laws import Condition, UnlikeError, complementary, gap, stop

Table = Mapping[str, Any]
AT_ONCE = 1e-11  # s
BESIDE = 1e-9  # s: so near to a change it is not known on which side of it something is seen
TOUCHES = 1e-9  # m or rad
STILL = 1e-9  # m/s or rad/s
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


class Changing:
    """Of a scenario."""

    def __init__(self, data: Table) -> None:
        self.data, self.model = data, data["model"]
        self.events = list(data.get("events", []))
        self.every = {j["name"]: j for j in self.model.get("joints", [])}
        self.first = Mechanism(self.model_with(data.get("parameters", {})))
        acting = {e["joint"] for e in self.events if e.get("action") in ("release", "engage")}
        switched = {name for name, j in self.every.items() if name in acting or not j.get("active", True)}
        self.permanent = [name for name in self.first.functions if name not in switched]
        self.bilateral: dict[str, Function] = {name: self.first.functions[name] for name in switched}
        self.on = {name for name in switched if self.every[name].get("active", True)}
        self.unilateral: dict[str, Function] = {}
        self.restitution: dict[str, tuple[float, float]] = {}
        self.stopped: dict[str, str] = {}  # which joint a stop stops
        for limit in self.model.get("limits", []):
            q = joints.coordinate(self.every[limit["joint"]], limit["coordinate"])
            for key, side in (("low", 1.0), ("high", -1.0)):
                if key in limit:
                    self.stopped[f"{limit['name']}.{key}"] = limit["joint"]
                    self._unilateral(f"{limit['name']}.{key}", stop(q, side, limit[key]), limit)
        for contact in self.model.get("contacts", []):
            self._unilateral(contact["name"], gap(contact), contact)
        self.quantities = {q["name"]: q for q in self.model.get("quantities", [])}
        self.parameters = dict(data.get("parameters", {}))
        self.conditions = [Condition(e["when"], self.quantities) for e in self.events]
        self.locks = {e["joint"] for e in self.events if e.get("action") in ("lock", "unlock")}
        self.course = Course()
        self.true: list[bool] = [False] * len(self.events)
        self.largest = [0.0] * len(self.events)
        self.closed: frozenset[str] = frozenset()
        self.carrying: tuple[str, ...] = ()  # of those that are closed
        self.kept = 0  # how many coordinates have been kept
        self.latest: tuple[Any, Mechanism] = (None, self.first)

    def _unilateral(self, name: str, f: Function, table: Table) -> None:
        self.unilateral[name] = f
        self.restitution[name] = (table.get("restitution", 0.0), table["rest_speed"])

    def model_with(self, parameters: Mapping[str, float]) -> Table:
        """The model with numbers for parameters."""

        def filled(x: Any) -> Any:
            if isinstance(x, str):
                for name, value in parameters.items():
                    x = re.sub(rf"\b{name}\b", f"({float(value)!r})", x)
                return x
            if isinstance(x, Mapping):
                return {key: filled(y) for key, y in x.items()}
            return [filled(y) for y in x] if isinstance(x, list) else x

        return {**self.model, "forces": filled(self.model.get("forces", []))}

    # ------------------------------------------------------------ one mode
    def mechanism(self, more: Iterable[str] = ()) -> Mechanism:
        """What holds now, and unilateral constraints that push."""
        key = (frozenset(self.on), tuple(more), tuple(self.parameters.values()), self.kept)
        if self.latest[0] == key:
            return self.latest[1]
        m = Mechanism(self.model_with(self.parameters))
        m.__dict__["start"] = self.first.start
        every = {name: m.functions[name] for name in self.permanent}
        every |= {name: self.bilateral[name] for name in self.bilateral if name in self.on}
        m.functions = every | {name: self.unilateral[name] for name in more}
        self.latest = key, m
        return m

    def motion(self, state: State, t: float) -> Motion:
        """Of joints the loads with those of their locks and stops."""
        now = _with_all(self.mechanism(self.carrying).motion(state, t), self.every)
        loads = dict(now.loads)
        for name, load in now.loads.items():
            joint = self.stopped.get(name, name.partition(".")[0])
            if name not in self.every and joint in self.every:
                loads[joint] = loads[joint] + load
        return replace(now, loads=loads)

    def force(self, now: Motion, name: str) -> float:
        """That of a unilateral constraint that carries."""
        c = now.state.partial(self.unilateral[name], now.t)[0]
        return float(c @ now.loads[name] / (c @ c))

    def rows(self, names: Iterable[str], state: State, t: float) -> tuple[Array, Array, Array]:
        """C of unilateral constraints, their rates, and what their accelerations are without those of bodies."""
        C, rates, biases = [np.zeros((0, state.u.size))], [np.zeros(0)], [np.zeros(0)]
        for name in names:
            C.append(state.partial(self.unilateral[name], t))
            rate, bias = state.along(self.unilateral[name], t)
            rates.append(rate)
            biases.append(bias)
        return np.concatenate(C), np.concatenate(rates), np.concatenate(biases)

    def distance(self, name: str, state: State, t: float) -> float:
        return float(self.unilateral[name](state.places(), t)[0, 0].real)

    # ------------------------------------------------------------ a change
    def settle(self, state: State, t: float, fired: set[int], hit: set[str]) -> State | None:
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
            self._decide(state, t)
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
        m = self.mechanism(self.carrying)
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
                    self.course.status = "not_closed"
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

    def _decide(self, state: State, t: float) -> None:
        """What stays closed, by accelerations."""
        m = self.mechanism()
        B, _, bias, _ = m.constraints(state, t)
        near = [n for n in self.unilateral if n in self.closed or self._touches(n, state, t)]
        C, rates, biases = self.rows(near, state, t)
        rests = np.abs(rates) < 1e-7
        near = [n for n, r in zip(near, rests, strict=True) if r]
        C, biases = C[rests], biases[rests]
        M, Q = m.forced(state, t)
        _, _, pushes = complementary(M, Q, B, bias, C, -biases)
        self.carrying = tuple(n for n, p in zip(near, pushes, strict=True) if p > 0.0)
        a = self.motion(state, t).accelerations
        scale = 1.0 + float(np.abs(a).max())
        leaves = C @ a + biases
        closed = frozenset(n for n, x in zip(near, leaves, strict=True) if x < 1e-7 * scale)
        self.course.undecided |= {n for n in closed if n not in self.carrying}
        self.course.changes += [Change(t, "closed", n) for n in sorted(closed - self.closed)]
        self.course.changes += [Change(t, "opened", n) for n in sorted(self.closed - closed)]
        self.closed = closed

    # ------------------------------------------------------------ a run
    def run(self, times: list[float], tolerance: float = 1e-11, most: float = 0.01) -> Course:
        """From the start on; most: the longest step (s)."""
        course, state, t = self.course, self.first.start, 0.0
        left = list(times)

        def tell(to: float, at: Callable[[float], State]) -> None:
            while left and left[0] <= to:
                course.motions.append(self.motion(at(left[0]), left[0]))
                course.modes.append(frozenset(self.on | self.closed))
                left.pop(0)

        fired = {n for n in range(len(self.events)) if self.value(n, state, 0.0) > 0.0}
        self.true = [n in fired for n in range(len(self.events))]
        fired = {n for n in sorted(fired) if self._useful(n, 0.0, fired)}
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
        m, state_of = self.mechanism(self.carrying), state.like

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
                if not useful and not hit and not any(key[0] == "force" for key in happens):
                    return at, there
                return at, self.settle(there, at, useful, hit)
            tell(solver.t, partial(_between, state_of, dense, np.inf, solver.y))
        return end, None if solver.t >= end else state_of(solver.y)

    def _watched(self) -> list[tuple[str, Any]]:
        gaps = [("gap", n) for n in self.unilateral if n not in self.closed]
        return [*(("event", n) for n in range(len(self.events))), *gaps, *(("force", n) for n in self.carrying)]

    def _watch(self, key: tuple[str, Any], state: State, t: float) -> float:
        what, n = key
        if what == "event":
            x = self.value(n, state, t)
            if self.true[n] and x <= -BAND * self.largest[n]:
                self.true[n] = False
            return x
        return self.distance(n, state, t) if what == "gap" else self.force(self.motion(state, t), n)

    def _passed(self, key: tuple[str, Any], was: float, now: float) -> bool:
        if key[0] == "event":
            return not self.true[key[1]] and now > 0.0
        return now < 0.0 and (key[0] == "force" or was > 0.0 or now < -TOUCHES)

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


def _with_all(now: Motion, every: Iterable[str]) -> Motion:
    loads = {name: np.zeros_like(now.accelerations) for name in every} | dict(now.loads)
    return Motion(now.t, now.state, now.accelerations, loads, now.efforts, now.redundant, now.condition)


def _between(state_of: Callable[[Array], State], dense: Any, at: float, y: Array, t: float) -> State:
    """Within a step that ends there."""
    return state_of(dense(t) if t < at else y)
