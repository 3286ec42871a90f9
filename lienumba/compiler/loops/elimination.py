"""Sparse elimination without pivoting as loops over blocks of a matrix: the text does not grow with the matrix.

A block has side x side numbers, one row of lanes each; its rows and columns are the copies of two variables. Blocks lie
one behind the other in the order in which they are eliminated: of every pivot its own, those of later columns in its
row, those of later rows in its column. A table tells how many there are, and which block each product of one of the
column and one of the row is taken from.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from lienumba.compiler.loops.composite import Composite
from lienumba.compiler.loops.elimination_text import Text, table
from lienumba.compiler.rows import ARGUMENTS, ROW

Stores = Sequence[tuple[int, Any]]


@dataclass(frozen=True)
class Elimination:
    """side: of a block; columns, rows: of each pivot, in the order of elimination, the places of later variables in its
    row and in its column."""

    side: int
    columns: tuple[tuple[int, ...], ...]
    rows: tuple[tuple[int, ...], ...]

    @staticmethod
    def of(entries: Iterable[tuple[int, int]], size: int, side: int) -> "Elimination":
        """Of a matrix with blocks at these places (row, column); size: variables."""
        columns: list[set[int]] = [{n} for n in range(size)]
        rows: list[set[int]] = [{n} for n in range(size)]
        for row, column in entries:
            columns[row].add(column)
            rows[column].add(row)
        for pivot in range(size):
            columns[pivot] = {n for n in columns[pivot] if n > pivot}
            rows[pivot] = {n for n in rows[pivot] if n > pivot}
            for row in rows[pivot]:
                columns[row] |= columns[pivot]
            for column in columns[pivot]:
                rows[column] |= rows[pivot]
        return Elimination(side, *(tuple(tuple(sorted(own)) for own in every) for every in (columns, rows)))

    @property
    def size(self) -> int:
        """How many variables there are."""
        return len(self.columns)

    @property
    def products(self) -> int:
        """How many products of numbers are subtracted."""
        return self.side**3 * sum(len(c) * len(r) for c, r in zip(self.columns, self.rows, strict=True))

    @cached_property
    def _blocks(self) -> dict[tuple[int, int], int]:
        places = [
            place
            for pivot, (columns, rows) in enumerate(zip(self.columns, self.rows, strict=True))
            for place in ((pivot, pivot), *((pivot, c) for c in columns), *((r, pivot) for r in rows))
        ]
        return {place: n for n, place in enumerate(places)}

    @property
    def vector(self) -> int:
        """The first row of a right-hand side, which becomes the solution: behind the matrix."""
        return self.side**2 * len(self._blocks)

    @property
    def memory(self) -> int:
        """The rows of the matrix and of a right-hand side."""
        return self.vector + self.side * self.size

    def row(self, row: int, column: int, i: int, j: int) -> int:
        """The row of memory of an entry: of copy i of the variable at a place, and copy j of another one."""
        return self.side * (self.side * self._blocks[row, column] + i) + j

    def text(self, name: str, each: "Each | None" = None) -> str:
        """Functions `name`_clear, which sets the matrix to 0, `name`_eliminate and `name`_solve of a pointer to it, and
        `name`_add, also of one to the rows of `each`, for its terms."""
        numbers, places, targets = [], list[int](), list[int]()
        for pivot, (columns, rows) in enumerate(zip(self.columns, self.rows, strict=True)):
            numbers += [len(columns), len(rows), self._blocks[pivot, pivot], len(places), len(targets)]
            places += [*columns, *rows]
            targets += [self._blocks[r, c] for r in rows for c in columns]
        tables, text = {"numbers": numbers, "places": places, "targets": targets}, Text(name, self.side)
        functions = [
            text.pivot(), text.row(), text.forward(), text.backward(), text.clear(self.vector),
            text.eliminate(self.size), text.solve(self.size, self.vector),
        ]  # fmt: skip
        if each:
            for n, x in enumerate(each.terms):
                blocks = (self._blocks[place] for place in x.places)
                tables[f"terms{n}"] = [y for pair in zip(x.numbers, blocks, strict=True) for y in pair]
                functions.append(text.terms(n, len(x.places), x.weights, x.power, each.count * each.rows, each.rows))
            functions.append(text.add(len(each.terms)))
        return "\n".join((*(table(f"{name}.{x}", own) for x, own in tables.items()), *functions))


@dataclass(frozen=True)
class Terms:
    """What is taken from blocks: from i, j of each of these places (row, column) weights[i][j] times a number of the
    copy i. numbers: their rows there; power: of a factor that all are multiplied by before."""

    numbers: list[int]
    places: list[tuple[int, int]]
    weights: Sequence[Sequence[float]]
    power: int


@dataclass(frozen=True)
class Each:
    """A part that is computed `count` times, each time from so many `rows` of "extra", from the row `first` on, to rows
    among these: (row, value). terms: what goes to the matrix; behind the last rows is the factor of these."""

    stores: Stores
    count: int
    first: int
    rows: int
    terms: Sequence[Terms] = ()

    @property
    def factor(self) -> int:
        """The row of the factor of terms."""
        return self.first + self.count * self.rows


class EliminatingKernel(Composite):
    """Writes a matrix and a right-hand side behind a row of "extra", eliminates the one and solves for the other, which
    becomes the solution, and then says what `end` says of it.

    parts: (row, value) of "start", if there is something to be done before `each`, "matrix" and "end", which goes to
    "out", the others to "extra"; fresh: whether the matrix is written and eliminated, or was so before.
    """

    def __init__(
        self, name: str, system: Elimination, first: int, parts: Mapping[str, Stores], fresh: bool = True,
        each: Each | None = None,
    ) -> None:  # fmt: skip
        self.system, self.first, self.fresh, self.each = system, first, fresh, each
        super().__init__(name, {**parts, **({"each": each.stores} if each else {})})

    @property
    def memory(self) -> int:
        """The rows of "extra" that it needs."""
        return self.system.memory + (self.each.count * self.each.rows + 1 if self.each else 0)

    def counts(self) -> dict[str, int]:
        """Operations of one evaluation, without those of loops."""
        found: dict[str, int] = {}
        for part in self.parts:
            times = self.each.count if self.each and part.name == f"{self.name}_each" else 1
            for name, count in part.counts().items():
                found[name] = found.get(name, 0) + times * count
        return found

    def body(self) -> str:
        name, each = f"{self.name}_system", self.each
        given = "ptr %state, ptr %parameters, ptr %clock, ptr %extra"
        lines = [f"%matrix = getelementptr i8, ptr %extra, i64 {ROW * self.first}"]
        if each:
            lines.append(f"%each = getelementptr i8, ptr %extra, i64 {ROW * each.first}")
            lines.append(f"call void @{self.name}_start({given}, ptr %extra, ptr %work)")
            for n in range(each.count):
                lines.append(f"%each{n} = getelementptr i8, ptr %each, i64 {ROW * each.rows * n}")
                own = f"ptr %state, ptr %parameters, ptr %clock, ptr %each{n}, ptr %each{n}, ptr %work"
                lines.append(f"call void @{self.name}_each({own})")
        lines += [f"call void @{name}_clear(ptr %matrix)"] if self.fresh else []
        lines.append(f"call void @{self.name}_matrix({given}, ptr %extra, ptr %work)")
        if self.fresh:
            lines += [f"call void @{name}_add(ptr %matrix, ptr %each)"] if each and each.terms else []
            lines.append(f"call void @{name}_eliminate(ptr %matrix)")
        lines += [f"call void @{name}_solve(ptr %matrix)", f"call void @{self.name}_end({given}, ptr %out, ptr %work)"]
        text = "\n".join(lines)
        return (
            f"{self.system.text(name, each)}\ndefine void @{self.name}({ARGUMENTS}) nounwind {{\n{text}\nret void\n}}\n"
        )
