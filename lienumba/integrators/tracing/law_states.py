"""States of the laws that a user writes: they travel with the bodies, as more elements of the state-space group.

Of an element, nine numbers form a vector space (those of r, v and w): there nine states are, and R stays the identity.
So every method and every kernel that moves bodies moves them, too. A sampled law has behind its states its memory,
then its loads as they were sampled, and how often that was; none of these moves between samples.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from lienumba.groups import state
from lienumba.groups.state import ALGEBRA, ELEMENT, Algebra, State
from lienumba.mechanics.elements import quantities, user_laws
from lienumba.mechanics.mechanism.kinematics import Instant
from lienumba.mechanics.mechanism.model import HELD, Model
from lienumba.numerics.number import Number
from lienumba.numerics.operations import where

NUMBERS = (0, 1, 2, 12, 13, 14, 15, 16, 17)  # of an element
RATES = (0, 1, 2, 6, 7, 8, 9, 10, 11)  # of its algebra, in the same order
EARLY = 1e-6  # a sample may come this fraction of its interval early


@dataclass(frozen=True)
class LawStates:
    """sizes: how many numbers each law has, by its name."""

    sizes: Mapping[str, int]

    @staticmethod
    def of(model: Model, now: Instant) -> "LawStates":
        """The states of the laws of a model; now: any state."""
        sizes = {}
        for force in model.forces:
            if force.code is not None and (force.code.states or force.code.every is not None):
                sampled = 0
                if force.code.every is not None:
                    sampled = 1 + sum(
                        len(user_laws.numbers_of(load)) for load in user_laws.outcome(model, force, now)[0]
                    )
                sizes[force.name] = force.code.kept + sampled
        return LawStates(sizes | ({HELD: len(model.held)} if model.held else {}))

    def held(self) -> range:
        """Which of the numbers of all laws are held ones."""
        return range(sum(self.sizes.values()) - self.sizes.get(HELD, 0), sum(self.sizes.values()))

    @property
    def elements(self) -> int:
        return -(-sum(self.sizes.values()) // len(NUMBERS))

    def read(self, elements: Sequence[State]) -> dict[str, tuple[Number, ...]]:
        """The numbers of each law."""
        return self.apart([element[i] for element in elements for i in NUMBERS])

    def apart(self, numbers: Sequence[Number]) -> dict[str, tuple[Number, ...]]:
        """The numbers of each law, from those of all."""
        found = {}
        for name, size in self.sizes.items():
            found[name], numbers = tuple(numbers[:size]), numbers[size:]
        return found

    def together(self, values: Mapping[str, Sequence[Number]]) -> list[Number]:
        """The numbers of all laws, one behind the other; 0 where there is none."""
        found: list[Number] = []
        for name, size in self.sizes.items():
            own = list(values.get(name, ()))
            found += [*own, *[0.0] * (size - len(own))]
        return found

    def placed(self, values: Mapping[str, Sequence[Number]]) -> list[State]:
        """The elements with these numbers."""
        return self._filled(values, state.IDENTITY, NUMBERS)

    def slopes(self, rates: Mapping[str, Sequence[Number]]) -> list[Algebra]:
        """How the elements move with these rates; what has none rests."""
        return self._filled(rates, (0.0,) * ALGEBRA, RATES)

    def _filled(
        self, values: Mapping[str, Sequence[Number]], blank: tuple[Number, ...], places: tuple[int, ...]
    ) -> list[tuple[Number, ...]]:
        found = [list(blank) for _ in range(self.elements)]
        first = 0
        for name, size in self.sizes.items():
            for n, x in enumerate(values.get(name, ())):
                element, number = divmod(first + n, len(places))
                found[element][places[number]] = x
            first += size
        return [tuple(element) for element in found]

    def initial(self, model: Model) -> dict[str, tuple[Number, ...]]:
        """The states of the laws at the start."""
        every = {force.name: user_laws.initial(force) for force in model.forces} | {HELD: (*model.held.values(),)}
        return {name: every[name] for name in self.sizes}

    def start(self, model: Model, runs: int) -> np.ndarray:
        """(runs, rows) at the start: the laws' initial states; nothing is sampled yet."""
        rows = np.zeros((runs, ELEMENT * self.elements))
        for i, element in enumerate(self.placed(self.initial(model))):
            for n, x in enumerate(element):
                rows[:, ELEMENT * i + n] = x
        return rows


def rates(model: Model, now: Instant) -> dict[str, list[Number]]:
    """The rates of the states of every law that is not sampled."""
    return {
        force.name: user_laws.outcome(model, force, now)[1]
        for force in model.forces
        if force.code is not None and force.code.states and force.code.every is None
    }


def sampled(model: Model, now: Instant) -> dict[str, tuple[Number, ...]]:
    """The numbers of every law after those whose time has come were sampled."""
    found = dict(now.states)
    for force in model.forces:
        if force.code is None or force.code.every is None:
            continue
        old = now.states[force.name]
        loads, states = user_laws.outcome(model, force, now)
        kept = [x for load in loads for x in user_laws.numbers_of(load)]
        due = now.t >= (old[-1] - EARLY) * force.code.every
        new = (*states, *kept, old[-1] + 1.0)
        found[force.name] = tuple(where(due, x, y) for x, y in zip(new, old, strict=True))
    return found


def variables(model: Model, now: Instant) -> dict[str, list[Number]]:
    """Every state by the name of its variable: that of the law, a dot, its own."""
    return {
        f"{force.name}.{state}": [x]
        for force in model.forces
        if force.code is not None and not quantities.is_input(force.name)
        for state, x in zip(force.code.states, user_laws.states_of(force, now), strict=False)
    }
