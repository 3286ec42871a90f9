"""States of the laws that a user writes: they travel with the bodies, as more elements of the state-space group.

Of an element, nine numbers form a vector space (those of r, v and w): there nine states are, and R stays the identity.
So every method and every kernel that moves bodies moves them, too. A sampled law has behind its states what it holds of
its loads, and how often it has been sampled; none of these moves between samples.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from lienumba.groups import so3
from lienumba.groups.state import ALGEBRA, ELEMENT
from lienumba.mechanics.elements import user_laws
from lienumba.mechanics.mechanism.kinematics import Instant
from lienumba.mechanics.mechanism.model import Force, Model
from lienumba.numerics.operations import where

SLOTS = (0, 1, 2, 12, 13, 14, 15, 16, 17)  # of an element
RATES = (0, 1, 2, 6, 7, 8, 9, 10, 11)  # of its algebra, in the same order
EARLY = 1e-6  # a sample may come this fraction of its interval early


@dataclass(frozen=True)
class Carried:
    """sizes: how many numbers each law carries, by its name."""

    sizes: Mapping[str, int]

    @staticmethod
    def of(model: Model, now: Instant) -> "Carried":
        """Of a model; now: any state."""
        sizes = {}
        for force in model.forces:
            if force.code is not None and (force.code.states or force.code.every is not None):
                held = 0
                if force.code.every is not None:
                    held = 1 + sum(user_laws.HELD[load.kind] for load in user_laws.outcome(model, force, now)[0])
                sizes[force.name] = len(force.code.states) + held
        return Carried(sizes)

    @property
    def elements(self) -> int:
        return -(-sum(self.sizes.values()) // len(SLOTS))

    def read(self, elements: Sequence[Any]) -> dict[str, tuple[Any, ...]]:
        """The numbers of each law."""
        numbers = [element[slot] for element in elements for slot in SLOTS]
        found = {}
        for name, size in self.sizes.items():
            found[name], numbers = tuple(numbers[:size]), numbers[size:]
        return found

    def placed(self, values: Mapping[str, Sequence[Any]]) -> list[tuple[Any, ...]]:
        """The elements with these numbers."""
        blank = [0.0] * 3 + list(so3.IDENTITY) + [0.0] * 6
        return self._filled(values, blank, SLOTS)

    def slopes(self, rates: Mapping[str, Sequence[Any]]) -> list[tuple[Any, ...]]:
        """How the elements move with these rates; what has none rests."""
        return self._filled(rates, [0.0] * ALGEBRA, RATES)

    def _filled(self, values: Mapping[str, Sequence[Any]], blank: list[Any], slots: Sequence[int]) -> list[Any]:
        found = [list(blank) for _ in range(self.elements)]
        place = 0
        for name, size in self.sizes.items():
            for n, x in enumerate(values.get(name, ())):
                found[(place + n) // len(slots)][slots[(place + n) % len(slots)]] = x
            place += size
        return [tuple(element) for element in found]

    def start(self, forces: Sequence[Force], runs: int) -> np.ndarray:
        """(runs, rows) at the start: the laws' initial states; nothing is held yet."""
        initial = {force.name: tuple(force.initial.values()) for force in forces}
        rows = np.zeros((runs, ELEMENT * self.elements))
        for i, element in enumerate(self.placed({name: initial[name] for name in self.sizes})):
            for n, x in enumerate(element):
                rows[:, ELEMENT * i + n] = x
        return rows


def rates(model: Model, now: Instant) -> dict[str, list[Any]]:
    """The rates of the states of every law that is not sampled."""
    return {
        force.name: user_laws.outcome(model, force, now)[1]
        for force in model.forces
        if force.code is not None and force.code.states and force.code.every is None
    }


def sampled(model: Model, now: Instant) -> dict[str, tuple[Any, ...]]:
    """What every law carries after those whose time has come were sampled."""
    found = dict(now.states)
    for force in model.forces:
        if force.code is None or force.code.every is None:
            continue
        old = now.states[force.name]
        loads, states = user_laws.outcome(model, force, now)
        held = [x for load in loads for x in (*load.value, *(load.at if load.kind == "force" else ()))]
        due = now.t >= (old[-1] - EARLY) * force.code.every
        new = (*states, *held, old[-1] + 1.0)
        found[force.name] = tuple(where(due, x, y) for x, y in zip(new, old, strict=True))
    return found


def variables(model: Model, now: Instant) -> dict[str, list[Any]]:
    """Every state by the name of its variable: that of the law, a dot, its own."""
    return {
        f"{force.name}.{state}": [x]
        for force in model.forces
        if force.code is not None
        for state, x in zip(force.code.states, user_laws.states_of(force, now), strict=False)
    }
