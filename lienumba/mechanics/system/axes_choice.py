"""In which axes the equations of a mechanism cost least, found by counting operations on symbols.

A body that all its joints are turned to has a constant block in C, and what the bodies behind these joints give gets
dearer by their rotations relative to it. Which is more depends on where points and axes lie: so both ways are counted,
first body by body on what a body and its neighbours give, and then on the whole.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from lienumba.compiler.symbols import Graph, operation_counts, reached
from lienumba.mechanics.mechanism import kinematics
from lienumba.mechanics.mechanism.kinematics import Instant
from lienumba.mechanics.mechanism.massless import massless
from lienumba.mechanics.mechanism.model import GROUND, Model
from lienumba.mechanics.system import constraints, dynamics, kkt
from lienumba.mechanics.system.body_axes import GLOBAL, Axes
from lienumba.mechanics.system.rotors import rotors_of
from lienumba.mechanics.tolerances import (
    DIVISION_COST,
    MAX_COUNTED_BODIES,
    MAX_TRIED_BODIES,
)
from lienumba.numerics.jets import lift
from lienumba.numerics.operations import is_zero


def cheapest(graph: Graph, model: Model, structure: kkt.Structure, now: Instant, dropped: Sequence[int] = ()) -> Axes:
    """The axes with the least operations of one map of accelerations; `model` and `now`: symbols of `graph`. Rows
    stay global where single ones of a vector count: where some may be left out, as the `dropped` ones always are, and
    where a loop closes, so that some may fade (see `kkt`)."""
    if massless(model) or len(model.bodies) > MAX_COUNTED_BODIES:
        return GLOBAL
    of = _Counted(graph, model, structure, now, set(dropped))
    if not of.turnable:
        return GLOBAL
    tried = [GLOBAL]
    for axes in (*of.by_bodies(), *of.by_one_body()):
        tried += [axes] if axes not in tried else []
    return min(tried, key=of.whole) if len(tried) > 1 else GLOBAL


@dataclass
class _Counted:
    """turnable: the constraints (numbers) whose rows may be turned; at: those of each body; slides: the bodies whose
    translations a rotor couples."""

    graph: Graph
    model: Model
    structure: kkt.Structure
    now: Instant
    dropped: set[int]
    turnable: set[int] = field(init=False)
    at: dict[int, list[int]] = field(init=False)
    slides: set[int] = field(init=False)
    mass: kkt.Entries = field(init=False)
    blocks: dict[tuple[int, int, int | None, int | None], list[list[Any]]] = field(init=False, default_factory=dict)
    biases: dict[tuple[int, int | None], list[Any]] = field(init=False, default_factory=dict)

    def __post_init__(self) -> None:
        self.every = constraints.constraints_of(self.model)
        single = {*self.structure.masked, *self.dropped, *self._closing()}
        self.turnable = {
            n
            for n, (c, rows) in enumerate(zip(self.every, constraints.rows_of(self.model), strict=True))
            if c.indifferent and len(c.bodies) == 2 and single.isdisjoint(range(rows.start, rows.start + c.vector))
        }
        bodies = range(len(self.model.bodies))
        self.loads = (
            list(self.graph.inputs("extra", 6 * len(bodies)))
            if self.model.forces
            else dynamics.loads(self.model, self.now)
        )
        self.mass = dynamics.mass_matrix(self.model, self.now)
        self.slides = {i for rotor in rotors_of(self.model) if not rotor.constant for i in rotor.bodies}
        self.at = {i: [n for n in sorted(self.turnable) if i in self.every[n].bodies] for i in bodies}

    def _closing(self) -> Iterator[int]:
        """The rows of constraints that tie bodies which others, eliminated before them, have tied already. Only among
        these can pivots be weak, whatever the axes of the others."""
        place = {variable - 6 * self.structure.bodies: n for n, variable in enumerate(self.structure.order)}
        group = {i: {i} for i in range(GROUND, self.structure.bodies)}
        both = [(c, rows) for c, rows in zip(self.every, constraints.rows_of(self.model), strict=True) if c.rows]
        for c, rows in sorted(both, key=lambda each: place[each[1].start]):
            first, *others = {*c.bodies} if len({*c.bodies}) > 1 else {GROUND, *c.bodies}
            for other in others:
                if group[first] is group[other]:
                    yield from range(rows.start, rows.stop)
                    continue
                tied = group[first] | group[other]
                group |= dict.fromkeys(tied, tied)

    def by_bodies(self) -> Iterator[Axes]:
        """The bodies that save most, no two of them neighbours, have all their joints turned to them. What is behind
        a joint moves along the same axes, if that is cheaper. First the best alone, then all."""
        gains: list[tuple[int, int, Axes]] = []
        for i, own in self.at.items():
            if own and i not in self.slides:
                bodies = [i, *self._neighbours(i)]
                before = self._around(i, bodies, GLOBAL)
                for moves in ({i: i}, {body: i for body in bodies if body not in self.slides}):
                    axes = Axes(dict.fromkeys(own, i), moves)
                    gains.append((self._around(i, bodies, axes) - before, i, axes))
        found = GLOBAL
        for gain, i, axes in sorted(gains, key=lambda x: x[:2]):
            if gain < 0 and not found.rows.keys() & axes.rows.keys() and i not in found.moves.values():
                first = found is GLOBAL
                found = Axes(found.rows | axes.rows, axes.moves | found.moves | {i: i})
                if first:
                    yield found
        yield found

    def by_one_body(self) -> Iterator[Axes]:
        """Everything in the axes of one body."""
        bodies = range(len(self.model.bodies))
        for i in bodies if len(bodies) <= MAX_TRIED_BODIES and not self.slides else ():
            yield Axes(dict.fromkeys(self.turnable, i), dict.fromkeys(bodies, i))

    def _neighbours(self, i: int) -> list[int]:
        ends = (other for n in self.at[i] for other in self.every[n].bodies)
        return sorted({*ends} - {i, GROUND})

    def whole(self, axes: Axes) -> int:
        """The cost of all accelerations, without what no axes change: forces and prescribed motions are taken as
        known."""
        bodies = range(len(self.model.bodies))
        C, xi = self._constrained(range(len(self.every)), {i: 6 * i for i in bodies}, axes)
        mask = [0.0 if row in self.dropped else 1.0 for row in range(self.structure.rows)]
        solution = kkt.solve(self.structure, self.mass, C, self._forces(axes, bodies), xi, mask)
        return _operations(axes.out_of(self.now, solution.x))

    def _around(self, i: int, bodies: Sequence[int], axes: Axes) -> int:
        """The cost of the accelerations of these bodies, if the joints of body i were all."""
        place = {body: 6 * n for n, body in enumerate(bodies)}
        M: kkt.Entries = {}
        for (a, b), x in self.mass.items():
            if a // 6 == b // 6 and a // 6 in place:
                M[place[a // 6] + a % 6, place[b // 6] + b % 6] = x
        C, xi = self._constrained(self.at[i], place, axes)
        structure = kkt.Structure(len(bodies), len(xi), tuple(range(6 * len(bodies) + len(xi))))
        x = kkt.solve(structure, M, C, self._forces(axes, bodies), xi).x
        back = [0.0] * (6 * len(self.model.bodies))
        for body, first in place.items():
            back[6 * body : 6 * body + 6] = x[first : first + 6]
        return _operations(axes.out_of(self.now, back))

    def _forces(self, axes: Axes, bodies: Sequence[int]) -> list[Any]:
        Q = axes.into(self.now, self.loads)
        return [x for i in bodies for x in Q[6 * i : 6 * i + 6]]

    def _constrained(
        self, numbers: Iterable[int], place: Mapping[int, int], axes: Axes
    ) -> tuple[kkt.Entries, list[Any]]:
        """C and the right-hand side of these constraints; place: of a body, its first column."""
        C: kkt.Entries = {}
        xi: list[Any] = []
        for n in numbers:
            for body in self.every[n].bodies:
                if body != GROUND:
                    for row, values in enumerate(self._block(n, body, axes), len(xi)):
                        C |= {(row, place[body] + m): x for m, x in enumerate(values) if not is_zero(x)}
            xi += self._bias(n, axes)
        return C, xi

    def _block(self, n: int, body: int, axes: Axes) -> list[list[Any]]:
        """Of a constraint and a body in C; most are asked for again and again."""
        key = n, body, axes.rows.get(n), axes.moves.get(body)
        if key not in self.blocks:
            self.blocks[key] = constraints.block(self.every[n], n, self.now, body, axes)
        return self.blocks[key]

    def _bias(self, n: int, axes: Axes) -> list[Any]:
        key = n, axes.rows.get(n)
        if key not in self.biases:
            self.biases[key] = self._given(n, axes)
        return self.biases[key]

    def _given(self, n: int, axes: Axes) -> list[Any]:
        c = self.every[n]
        if not c.indifferent:
            return [self.graph.input("extra", 6 * len(self.model.bodies) + n)] * c.rows
        view = kinematics.moving(axes.view(n, self.now, c.bodies))
        return [-lift(row).c for row in c.law(view)]


def _operations(outputs: Sequence[object]) -> int:
    counts = operation_counts([node for node in reached(outputs) if not node.invariant])
    return counts["operations"] + (DIVISION_COST - 1) * counts["divide"]
