"""The elimination by freedoms: accelerations of all rates from leaf to root and back.

Of a link, A a = f + what its joint and its children say, a = b + S q'', and b follows from the parent's a. The rates
of a link leave with the pivot S^T A S, and what is left of A acts on the parent: X^T (A - A S (S^T A S)^-1 S^T A) X
(Featherstone 1983). They may also wait: then A stays that of a rigid body, and each waiting rate is one more vector on
the way to the root (the composite bodies of Walker and Orin 1982). A constraint that closes a loop is such a vector,
too. What waits is eliminated together, from the leaves on.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from lienumba.groups import so3
from lienumba.mechanics.mechanism.model import GROUND
from lienumba.mechanics.tree.inertia import Inertia, Rigid, Six, column, plus, times
from lienumba.mechanics.tree.links import Link, Tree
from lienumba.mechanics.tree.motion import Moving, down, up
from lienumba.numerics.number import Number
from lienumba.numerics.operations import is_zero

NOTHING: Six = (0.0,) * 6
MASSLESS = Rigid(0.0, (0.0,) * 3, NOTHING)


@dataclass(frozen=True)
class Loads:
    """inertia: of each link, None without a body; wrenches: on each, about its origin; efforts: along rates; biases:
    the accelerations that are there without any q''; ground: of the ground. rows: of each constraint that closes
    loops, by link: its entries of C; resisting: of those rows that are none, but c a - x is given: then c^T x is what
    a unit of mass along c has against being accelerated so."""

    inertia: Sequence[Rigid | None]
    wrenches: Sequence[Six]
    efforts: Mapping[int, Number] = field(default_factory=dict)
    armatures: Sequence[Number] | None = None
    biases: Sequence[Six] | None = None
    ground: Six = NOTHING
    rows: Mapping[int, Mapping[int, Six]] = field(default_factory=dict)
    resisting: Mapping[int, Number] = field(default_factory=dict)


@dataclass(frozen=True)
class _Gone:
    """A rate that was eliminated at a link: q'' = inverse (right - vector . b - sum of others)."""

    variable: int
    inverse: Any
    right: Any
    vector: Six
    others: dict[int, Any]

    def solved(self, b: Six, found: Mapping[int, Any]) -> Any:
        rest = self.right - _dot(self.vector, b)
        for other, value in self.others.items():
            rest = rest - value * found.get(other, 0.0)
        return self.inverse * rest


class Reduction:
    """Rates are variables 0..n-1, constraints n + row. `matrix`, `right`: of what has not been eliminated; at the end
    -C H^-1 C^T of the constraints, lower triangle, and C of the accelerations without multipliers."""

    def __init__(
        self,
        tree: Tree,
        moving: Sequence[Moving],
        loads: Loads,
        waiting: int = 0,
        free: Mapping[int, Number] | None = None,
    ) -> None:
        """waiting: so many rates may wait on the way to the root; free: 0 for rates that stand still, by rate."""
        self.tree, self.moving, self.loads, self.waiting, self.free = tree, moving, loads, waiting, free or {}
        self.n = tree.freedoms
        self.matrix: dict[tuple[int, int], Any] = {}
        self.right: dict[int, Any] = {self.n + row: loads.resisting.get(row, 0.0) for row in loads.rows}
        self.gone: list[list[_Gone]] = [[] for _ in tree.links]
        self.resisting: list[_Gone] = []
        self._arrived: list[list[tuple[Inertia, Six, dict[int, Six]]]] = [[] for _ in tree.links]
        for place in reversed(range(len(tree.links))):
            self._pass(place)
        for variable in [self.n + row for row in loads.resisting]:
            self._set(variable, variable, self.matrix.get((variable, variable), 0.0) - 1.0)
            self.resisting.append(self._leaving(variable, NOTHING, set(self.right) - {variable})[0])

    def _pass(self, place: int) -> None:
        link, loads = self.tree.links[place], self.loads
        A, f, vectors = self._gathered(place)
        A = MASSLESS if A is None else A
        vectors = self._with_rates(link, A, f, vectors)
        bias = NOTHING if loads.biases is None else loads.biases[place]
        if link.parent == GROUND:
            b = _add(_down(self.moving[place], loads.ground), bias)
            for variable, y in vectors.items():
                self.right[variable] = self.right[variable] - _dot(y, b)
            for variable in [v for v in vectors if v < self.n]:
                self._eliminate(place, variable, vectors.pop(variable), None, NOTHING, vectors, settled=True)
            return
        rates = [v for v in vectors if v < self.n]
        if len(rates) > self.waiting:
            for variable in rates:
                y = vectors.pop(variable)
                A, f = self._eliminate(place, variable, y, A, f, vectors)
        f = _subtract(f, times(A, bias))
        for variable, y in vectors.items():
            self.right[variable] = self.right[variable] - _dot(y, bias)
        turns, q = self.moving[place].turns, self.moving[place].q
        for E in reversed(turns):
            A = A.rotated(E)
        up_vectors = {variable: _up(turns, q, y) for variable, y in vectors.items()}
        self._arrived[link.parent].append((A.shifted(q), _up(turns, q, f), up_vectors))

    def _gathered(self, place: int) -> tuple[Inertia | None, Six, dict[int, Six]]:
        """What a link has of itself and of its children."""
        A: Inertia | None = self.loads.inertia[place]
        f: Six = self.loads.wrenches[place]
        vectors: dict[int, Six] = {}
        for other, force, waiting in self._arrived[place]:
            A = other if A is None else plus(A, other)
            f = _add(f, force)
            for variable, y in waiting.items():
                vectors[variable] = _add(vectors[variable], y) if variable in vectors else y
        for row, by_link in self.loads.rows.items():
            if place in by_link:
                variable = self.n + row
                own = by_link[place]
                vectors[variable] = _add(vectors[variable], own) if variable in vectors else own
        return A, f, vectors

    def _with_rates(self, link: Link, A: Inertia, f: Six, vectors: dict[int, Six]) -> dict[int, Six]:
        """With the link's own rates among what waits."""
        new: dict[int, Six] = {}
        for rate, S in zip(link.rates, link.move.columns(link.pitch), strict=True):
            y = NOTHING
            for k, x in S.items():
                y = _plus_scaled(y, x, column(A, k))
            for variable, other in (vectors | new).items():
                self._set(rate, variable, _along(S, other))
            pivot = _along(S, y)
            if self.loads.armatures is not None:
                pivot = pivot + self.loads.armatures[rate]
            self._set(rate, rate, pivot)
            self.right[rate] = _along(S, f) + self.loads.efforts.get(rate, 0.0)
            new[rate] = y
        return vectors | new

    def _eliminate(
        self, place: int, variable: int, y: Six, A: Any, f: Six, vectors: dict[int, Six], settled: bool = False
    ) -> tuple[Any, Six]:
        """A rate leaves at a link; settled: b is known, and in the right sides."""
        gone, scaled = self._leaving(variable, NOTHING if settled else y, vectors)
        self.gone[place].append(gone)
        if settled:
            return A, f
        inverse, right = gone.inverse, gone.right
        clear = self._unit(place, variable)
        for other in scaled:
            vectors[other] = _cleared(_plus_scaled(vectors[other], -scaled[other], y), clear)
        A, f = A.general().without(y, inverse), _plus_scaled(f, -(inverse * right), y)
        if clear is not None:
            effort = self.loads.efforts.get(variable, 0.0)
            A, f = A.cleared(clear), (*f[:clear], -effort, *f[clear + 1 :])
        return A, f

    def _leaving(self, variable: int, y: Six, left: Iterable[int]) -> tuple[_Gone, dict[int, Any]]:
        """A variable out of the matrix and the right sides of those left; their entries times its inverse."""
        inverse, right = 1.0 / self.matrix.pop((variable, variable)), self.right.pop(variable)
        inverse = self.free.get(variable, 1.0) * inverse
        others = {}
        for other in sorted(left):
            value = self.matrix.pop(_key(variable, other), 0.0)
            if not is_zero(value):
                others[other] = value
        scaled = {other: value * inverse for other, value in others.items()}
        values = list(others.items())
        for n, (i, value) in enumerate(values):
            for j, _ in values[: n + 1]:
                self._set(i, j, self.matrix.get(_key(i, j), 0.0) - value * scaled[j])
            self.right[i] = self.right[i] - scaled[i] * right
        return _Gone(variable, inverse, right, y, others), scaled

    def _unit(self, place: int, variable: int) -> int | None:
        """The component along which a link's own rate moves it; None where A keeps something along it."""
        link = self.tree.links[place]
        if variable not in link.rates:
            return None
        S = link.move.columns(link.pitch)[variable - link.first_rate]
        held = self.loads.armatures is not None and not is_zero(self.loads.armatures[variable])
        held = held or variable in self.free
        return None if held or list(S.values()) != [1.0] else next(iter(S))

    def _set(self, i: int, j: int, value: Number) -> None:
        self.matrix[_key(i, j)] = value

    def solution(self, multipliers: Mapping[int, Number]) -> tuple[list[Any], list[Six]]:
        """q'' of all rates, and the acceleration of every link (own axes)."""
        found: dict[int, Any] = {self.n + row: mu for row, mu in multipliers.items()}
        for gone in reversed(self.resisting):
            found[gone.variable] = gone.solved(NOTHING, found)
        accelerations: list[Six] = []
        for place, link in enumerate(self.tree.links):
            above = self.loads.ground if link.parent == GROUND else accelerations[link.parent]
            a = _down(self.moving[place], above)
            if self.loads.biases is not None:
                a = _add(a, self.loads.biases[place])
            for gone in reversed(self.gone[place]):
                found[gone.variable] = gone.solved(a, found)
            for rate, S in zip(link.rates, link.move.columns(link.pitch), strict=True):
                if rate in found:
                    a = _moved(a, S, found[rate])
            accelerations.append(a)
        return [found[rate] for rate in range(self.n)], accelerations


def carried(tree: Tree, moving: Sequence[Moving], loads: Loads, rates: Sequence[Number]) -> list[Six]:
    """The acceleration of every link (own axes) where the rates change so."""
    found: list[Six] = []
    for place, link in enumerate(tree.links):
        a = _down(moving[place], loads.ground if link.parent == GROUND else found[link.parent])
        a = a if loads.biases is None else _add(a, loads.biases[place])
        for rate, S in zip(link.rates, link.move.columns(link.pitch), strict=True):
            a = _moved(a, S, rates[rate])
        found.append(a)
    return found


def gathered(tree: Tree, moving: Sequence[Moving], loads: Loads) -> list[Any]:
    """The efforts along all rates that together do as much as the wrenches and efforts on the links."""
    wrenches, found = list(loads.wrenches), dict(loads.efforts)
    for place in reversed(range(len(tree.links))):
        link, f = tree.links[place], wrenches[place]
        for rate, S in zip(link.rates, link.move.columns(link.pitch), strict=True):
            found[rate] = found.get(rate, 0.0) + _along(S, f)
        if link.parent != GROUND:
            wrenches[link.parent] = _add(wrenches[link.parent], _up(moving[place].turns, moving[place].q, f))
    return [found[rate] for rate in range(tree.freedoms)]


def _key(i: int, j: int) -> tuple[int, int]:
    return (i, j) if i >= j else (j, i)


def _down(moving: Moving, a: Six) -> Six:
    """X a: the parent's acceleration at a link's origin, along the link's axes."""
    return (
        *down(moving.turns, so3.add(a[0:3], so3.cross(a[3:6], moving.q))),
        *down(moving.turns, a[3:6]),
    )


def _up(turns: Any, q: Any, f: Six) -> Six:
    """X^T f."""
    force = up(turns, f[0:3])
    return (*force, *so3.add(up(turns, f[3:6]), so3.cross(q, force)))


def _along(S: Mapping[int, Number], y: Six) -> Any:
    """S . y."""
    total: Any = 0.0
    for k, x in S.items():
        total = total + x * y[k]
    return total


def _moved(a: Six, S: Mapping[int, Number], x: Number) -> Six:
    """a + S x."""
    return tuple(c + S[k] * x if k in S else c for k, c in enumerate(a))


def _cleared(y: Six, k: int | None) -> Six:
    return y if k is None else (*y[:k], 0.0, *y[k + 1 :])


def _dot(a: Six, b: Six) -> Any:
    total: Any = 0.0
    for x, y in zip(a, b, strict=True):
        total = total + x * y
    return total


def _add(a: Six, b: Six) -> Six:
    return tuple(x + y for x, y in zip(a, b, strict=True))


def _subtract(a: Six, b: Six) -> Six:
    return tuple(x - y for x, y in zip(a, b, strict=True))


def _plus_scaled(a: Six, s: Number, b: Six) -> Six:
    return tuple(x + s * y for x, y in zip(a, b, strict=True))
