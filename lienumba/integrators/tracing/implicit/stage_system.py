"""The linear systems of implicit stages, by a sparse elimination on symbols.

With the equations of motion f(q, v, s, a, mu) = 0 (`lienumba.integrators.tracing.linear.equations`) at every stage,
u = h A k and so dq = h^2 A^2 da, dv = h A da, Newton's matrix couples the stages:

    along:  d_ij M - h A_ij F_v - (h^2 A^2)_ij F_q,  C^T;      rows:  d_ij C, and what xi - C a changes by.

A variable leaves with its copies of all stages, one behind the other, in the order in which the mechanism's own matrix
is eliminated. Of Radau IIA, I + x A + y A^2 has positive pivots, the largest of their rows, for all x, y >= 0.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from lienumba.compiler.loops.elimination import Elimination, Terms
from lienumba.compiler.loops.elimination_text import NO_WEIGHT
from lienumba.compiler.symbols import Symbol
from lienumba.integrators.tracing.linear.equations import Equations, Linear
from lienumba.integrators.tracing.tracer import Tracer
from lienumba.numerics.number import Number
from lienumba.numerics.operations import is_zero

LOOPS = 1500  # products of an elimination up to which it stays straight-line code, and its bits what they were

Rows = list[dict[int, Any]]
Matrix = Sequence[Sequence[float]]


def unknowns(tracer: Tracer) -> tuple[int, int, int]:
    """Of one stage: accelerations, rates of the states of laws, multipliers of the rows in use."""
    laws = sum(tracer.law_states.sizes.values())
    return tracer.velocities, laws, len(tracer.used)


def factors(tracer: Tracer, stages: Sequence[Linear], A: Matrix, h: Number, mask: Sequence[Number]) -> "Factors":
    """Of Newton's matrix, stage by stage; mask: 1 or 0 for each row of C."""
    size = sum(unknowns(tracer))
    order = [size * i + variable for variable in order_of(tracer) for i in range(len(stages))]
    return Factors.of(matrix(tracer, stages, A, h, mask), order)


@dataclass(frozen=True)
class Blocks:
    """Where loops have Newton's matrix and what it is solved for.

    place: of each variable in the order in which they leave; first: the row of memory where the matrix begins.
    """

    elimination: Elimination
    place: dict[int, int]
    first: int

    @staticmethod
    def of(tracer: Tracer, equations: Equations, stages: int, first: int) -> "Blocks | None":
        """None of small systems."""
        entries = ((row, column) for _, row, column, _ in placed(tracer, equations))
        return Blocks._of(entries, order_of(tracer), stages, first)

    @staticmethod
    def of_rows(rows: Rows, order: Sequence[int], first: int) -> "Blocks | None":
        """Of a matrix with one copy of each variable."""
        entries = ((n, column) for n, row in enumerate(rows) for column, x in row.items() if not is_zero(x))
        return Blocks._of(entries, order, 1, first)

    @staticmethod
    def _of(entries: Iterable[tuple[int, int]], order: Sequence[int], stages: int, first: int) -> "Blocks | None":
        place = {variable: number for number, variable in enumerate(order)}
        found = Elimination.of(((place[row], place[column]) for row, column in entries), len(place), stages)
        return Blocks(found, place, first) if found.products > LOOPS else None

    def terms(self, tracer: Tracer, equations: Equations, A: Matrix, first: int) -> list[Terms]:
        """What the numbers of `Linear` add to the matrix, which lie from a row on."""
        one = [[float(i == j) for j in range(len(A))] for i in range(len(A))]
        found: dict[str, Terms] = {}
        for by, weights, power in (("q", squared(A), 2), ("v", A, 1), ("a", one, 0)):
            found[by] = Terms([], [], weights, power)
        same = {"laws": "v", "mu": "a"}
        for by, row, column, number in placed(tracer, equations):
            terms = found[same.get(by, by)]
            terms.numbers.append(first + number)
            terms.places.append((self.place[row], self.place[column]))
        return [*found.values()]

    def entries(self, rows: Rows) -> list[tuple[int, Any]]:
        """The rows of memory of a matrix, and its entries."""
        found, size = list[tuple[int, Any]](), len(self.place)
        for row, entries in enumerate(rows):
            i, own = divmod(row, size)
            for column, x in entries.items():
                j, other = divmod(column, size)
                if not is_zero(x):
                    found.append((self.first + self.elimination.row(self.place[own], self.place[other], i, j), x))
        return found

    @property
    def vector(self) -> list[int]:
        """The rows of memory of a right-hand side, variable by variable of each stage."""
        first, stages = self.first + self.elimination.vector, self.elimination.side
        return [first + stages * self.place[v] + i for i in range(stages) for v in range(len(self.place))]


def placed(tracer: Tracer, equations: Equations) -> Iterator[tuple[str, int, int, int]]:
    """Yield of every entry of the equations by what it is, its row and column in the matrix of a stage, and its place
    in the numbers of a `Linear`."""
    n, laws, _ = unknowns(tracer)
    rows = {"along": 0, "laws": n, "rows": n + laws}
    columns = {"q": 0, "v": 0, "a": 0, "laws": n, "mu": n + laws}
    for of, row in rows.items():
        for by, column in columns.items():
            for i, j, number in zip(*equations.places[of, by], strict=True):
                yield by, row + i, column + j, number


def squared(A: Matrix) -> list[list[float]]:
    """A A."""
    s = range(len(A))
    return [[sum(A[i][m] * A[m][j] for m in s) for j in s] for i in s]


def order_of(tracer: Tracer) -> list[int]:
    n, laws, _ = unknowns(tracer)
    bodies = 6 * tracer.structure.bodies
    place = {row: n + laws + m for m, row in enumerate(tracer.used)}
    own = [v if v < bodies else place[v - bodies] for v in tracer.structure.order if v < bodies or v - bodies in place]
    rates = [] if bodies else list(reversed(range(n)))
    return [*range(n, n + laws), *rates, *own]


def matrix(tracer: Tracer, stages: Sequence[Linear], A: Matrix, h: Number, mask: Sequence[Number]) -> Rows:
    n, laws, count = unknowns(tracer)
    size, s = n + laws + count, range(len(stages))
    first = {"along": 0, "laws": n, "rows": n + laws}
    A2 = squared(A)
    rows: Rows = [{} for _ in range(size * len(stages))]

    def add(i: int, row: int, j: int, column: int, x: Any) -> None:
        own = rows[size * i + row]
        own[size * j + column] = own.get(size * j + column, 0.0) + x

    for i, stage in enumerate(stages):
        for name, start in first.items():
            for by, column, weights in (("v", 0, A), ("laws", n, A), ("q", 0, A2)):
                for (row, c), x in stage.block(name, by).items():
                    scaled = (h * h if by == "q" else h) * x
                    for j in s:
                        if abs(weights[i][j]) > NO_WEIGHT:
                            add(i, start + row, j, column + c, -(weights[i][j] * scaled))
            for by, column in (("a", 0), ("mu", n + laws)):
                for (row, c), x in stage.block(name, by).items():
                    add(i, start + row, i, column + c, -x)
        for m in range(laws):
            add(i, n + m, i, n + m, 1.0)
        for m, row in enumerate(tracer.used):
            off = 1.0 - mask[row]
            if not is_zero(off):
                add(i, n + laws + m, i, n + laws + m, off)
    return rows


@dataclass(frozen=True)
class Factors:
    """Of an eliminated matrix. values: at (p, p) 1 over the pivot of a variable, at (p, c) what its row still has of
    those that leave later, at (r, p) how much of it a later row takes away; order: in which they leave."""

    values: dict[tuple[int, int], Any]
    order: tuple[int, ...]

    @staticmethod
    def of(rows: Rows, order: Sequence[int]) -> "Factors":
        """The rows are used up."""
        columns: dict[int, set[int]] = {}
        for row, entries in enumerate(rows):
            for column, x in entries.items():
                if not is_zero(x):
                    columns.setdefault(column, set()).add(row)
        place, values = {variable: n for n, variable in enumerate(order)}, {}
        for p in order:
            pivot = rows[p]
            values[p, p] = inverse = 1.0 / pivot[p]
            later = [c for c, x in pivot.items() if place[c] > place[p] and not is_zero(x)]
            later.sort(key=place.__getitem__)
            values |= {(p, c): pivot[c] for c in later}
            for row in sorted((r for r in columns[p] if place[r] > place[p]), key=place.__getitem__):
                values[row, p] = factor = rows[row].pop(p) * inverse
                for c in later:
                    rows[row][c] = rows[row].get(c, 0.0) - factor * pivot[c]
                    columns.setdefault(c, set()).add(row)
        return Factors(values, tuple(order))

    def solved(self, right: Sequence[Any]) -> list[Any]:
        """What the matrix makes of a right-hand side."""
        place, total, found = {variable: n for n, variable in enumerate(self.order)}, list(right), dict[int, Any]()
        above: dict[int, list[tuple[int, Any]]] = {p: [] for p in self.order}
        for (row, column), x in self.values.items():
            if place[row] > place[column]:
                total[row] = total[row] - x * total[column]
            elif row != column:
                above[row].append((column, x))
        for p in reversed(self.order):
            for c, x in above[p]:
                total[p] = total[p] - x * found[c]
            found[p] = total[p] * self.values[p, p]
        return [found[p] for p in range(len(total))]

    @property
    def kept(self) -> list[Symbol]:
        """Those of its numbers that are not known beforehand."""
        return [x for x in self.values.values() if isinstance(x, Symbol)]

    def again(self, kept: Sequence[Any]) -> "Factors":
        """The same from these."""
        numbers = iter(kept)
        values = {key: next(numbers) if isinstance(x, Symbol) else x for key, x in self.values.items()}
        return Factors(values, self.order)
