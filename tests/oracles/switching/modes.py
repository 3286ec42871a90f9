"""Each mode of a scenario as a mechanism of its own: the functions of what is on, together. Joints that events turn on
and off, their locks, rigid stops, contacts, and friction of joints that sticks or slides."""

import re
from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from tests.oracles.mechanisms import joints
from tests.oracles.mechanisms.engine import Mechanism, Motion
from tests.oracles.mechanisms.places import Array, Function, State
from tests.oracles.switching.laws import gap, stop

Table = Mapping[str, Any]


class Modes:
    """Of a scenario, and which of them is on."""

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
        dry = [f for f in self.model.get("forces", []) if "static" in f]
        self.dry = {f["name"]: f for f in dry}
        self.rubbed = {f["name"]: joints.coordinate(self.every[f["joint"]], f["coordinate"]) for f in dry}
        self.heads: dict[str, float] = {}  # in which direction friction slides; the rest sticks
        self.bears: tuple[str, ...] = ()  # what sticks and is not held by anything else
        for limit in self.model.get("limits", []):
            q = joints.coordinate(self.every[limit["joint"]], limit["coordinate"])
            for key, side in (("low", 1.0), ("high", -1.0)):
                if key in limit:
                    self.stopped[f"{limit['name']}.{key}"] = limit["joint"]
                    self._unilateral(f"{limit['name']}.{key}", stop(q, side, limit[key]), limit)
        for contact in self.model.get("contacts", []):
            self._unilateral(contact["name"], gap(contact), contact)
        self.parameters = dict(data.get("parameters", {}))
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

        smooth = [f for f in self.model.get("forces", []) if "static" not in f]
        return {**self.model, "forces": filled(smooth)}

    # ------------------------------------------------------------ one mode
    def mechanism(self, more: Iterable[str] = ()) -> Mechanism:
        """What holds now, friction that slides, and unilateral constraints that push, or friction that sticks."""
        slides = tuple(sorted(self.heads.items()))
        key = (frozenset(self.on), tuple(more), tuple(self.parameters.values()), self.kept, slides)
        if self.latest[0] == key:
            return self.latest[1]
        m = Mechanism(self.model_with(self.parameters))
        m.__dict__["start"] = self.first.start
        every = {name: m.functions[name] for name in self.permanent}
        every |= {name: self.bilateral[name] for name in self.bilateral if name in self.on}
        m.functions = every | {name: self._function(name) for name in more}
        for name, d in slides:
            m.along.append(({"type": "actuator", "value": -d * self.dry[name]["coulomb"]}, self.rubbed[name]))
        self.latest = key, m
        return m

    def _function(self, name: str) -> Function:
        return self.rubbed[name] if name in self.rubbed else self.unilateral[name]

    def motion(self, state: State, t: float) -> Motion:
        """Of joints the loads with those of their locks and stops, and of friction that sticks."""
        now = _with_all(self.mechanism((*self.carrying, *self.bears)).motion(state, t), self.every)
        loads = dict(now.loads)
        for name, load in now.loads.items():
            joint = self.dry[name]["joint"] if name in self.dry else self.stopped.get(name, name.partition(".")[0])
            if name not in self.every and joint in self.every:
                loads[joint] = loads[joint] + load
        return replace(now, loads=loads)

    def force(self, now: Motion, name: str) -> float:
        """That of a unilateral constraint that carries, or of friction that sticks."""
        c = now.state.partial(self._function(name), now.t)[0]
        return float(c @ now.loads[name] / (c @ c))

    def rows(self, names: Iterable[str], state: State, t: float) -> tuple[Array, Array, Array]:
        """C of unilateral constraints, their rates, and what their accelerations are without those of bodies."""
        C, rates, biases = [np.zeros((0, state.u.size))], [np.zeros(0)], [np.zeros(0)]
        for name in names:
            C.append(state.partial(self._function(name), t))
            rate, bias = state.along(self._function(name), t)
            rates.append(rate)
            biases.append(bias)
        return np.concatenate(C), np.concatenate(rates), np.concatenate(biases)

    def distance(self, name: str, state: State, t: float) -> float:
        return float(self.unilateral[name](state.places(), t)[0, 0].real)


def _with_all(now: Motion, every: Iterable[str]) -> Motion:
    loads = {name: np.zeros_like(now.accelerations) for name in every} | dict(now.loads)
    return Motion(now.t, now.state, now.accelerations, loads, now.efforts, now.redundant, now.condition)
