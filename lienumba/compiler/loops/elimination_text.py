"""The LLVM text of `lienumba.compiler.loops.elimination`: functions of a pointer to the matrix, on tables."""

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from struct import pack

from lienumba.compiler import emit
from lienumba.compiler.rows import ROW

REGISTERS = 24  # rows of lanes that the innermost loop may hold: factors, and what they are taken from
NUMBERS = 5  # of a pivot in the table: its columns, its rows, its first block, its first place, its first target
NO_WEIGHT = 1e-15  # what rounding leaves of weights of methods that are 0


def table(name: str, numbers: Sequence[int]) -> str:
    given = ", ".join(f"i32 {n}" for n in numbers or [0])
    return f"@{name} = internal constant [{max(len(numbers), 1)} x i32] [{given}]"


class Text:
    """Writes the functions, which keep blocks in registers: the sizes of loops are in tables, side is not."""

    def __init__(self, name: str, side: int) -> None:
        self.name, self.side, self.lines, self._values = name, side, list[str](), 0

    # ------------------------------------------------------------ lines
    def _new(self, right: str) -> str:
        self._values += 1
        self.lines.append(f"%v{self._values} = {right}")
        return f"%v{self._values}"

    def _at(self, base: str, n: int) -> str:
        return self._new(f"getelementptr i8, ptr {base}, i64 {ROW * n}") if n else base

    def _behind(self, base: str, count: str, size: int) -> str:
        """The address so many times `size` bytes behind one."""
        return self._new(f"getelementptr i8, ptr {base}, i64 {self._new(f'mul i64 {count}, {size}')}")

    def _load(self, base: str, n: int) -> str:
        return self._new(f"load {emit.VALUES.name}, ptr {self._at(base, n)}, align 8")

    def _store(self, base: str, n: int, value: str) -> None:
        self.lines.append(f"store {emit.VALUES.name} {value}, ptr {self._at(base, n)}, align 8")

    def _whole(self, base: str, n: int = 0) -> str:
        """A number of a table."""
        place = self._new(f"getelementptr i32, ptr {base}, i64 {n}") if n else base
        return self._new(f"sext i32 {self._new(f'load i32, ptr {place}, align 4')} to i64")

    def _times(self, a: str, b: str) -> str:
        return self._new(f"fmul {emit.VALUES.name} {a}, {b}")

    def _less(self, x: str, a: str, b: str) -> str:
        """x - a b."""
        v = emit.VALUES.name
        return self._new(f"{emit.VALUES.fma}({v} {self._new(f'fneg {v} {a}')}, {v} {b}, {v} {x})")

    def _rows(self, base: str, rows: Iterable[int]) -> dict[tuple[int, int], str]:
        """These rows of a block."""
        return {(i, j): self._load(base, self.side * i + j) for i in rows for j in range(self.side)}

    def _keep(self, base: str, block: dict[tuple[int, int], str]) -> None:
        for (i, j), value in block.items():
            self._store(base, self.side * i + j, value)

    @contextmanager
    def _loop(self, name: str, count: str, entry: str, **moving: tuple[str, int | str]) -> Iterator[None]:
        """The lines of a loop over %name below a count. entry: the block before it, which it leaves as `name`.done;
        moving: of a pointer where it begins, and by how many bytes it moves."""
        phis = [f"%{x} = phi ptr [{start}, %{entry}], [%{x}.next, %{name}.end]" for x, (start, _) in moving.items()]
        self.lines += [
            f"br label %{name}.next", f"{name}.next:",
            f"%{name} = phi i64 [0, %{entry}], [%{name}.after, %{name}.end]", *phis,
            f"%{name}.more = icmp slt i64 %{name}, {count}",
            f"br i1 %{name}.more, label %{name}.body, label %{name}.done", f"{name}.body:",
        ]  # fmt: skip
        yield
        steps = [f"%{x}.next = getelementptr i8, ptr %{x}, i64 {by}" for x, (_, by) in moving.items()]
        self.lines += [
            f"br label %{name}.end", f"{name}.end:", *steps, f"%{name}.after = add i64 %{name}, 1",
            f"br label %{name}.next", f"{name}.done:",
        ]  # fmt: skip

    def _function(self, name: str, arguments: str, inner: bool = True) -> str:
        """What has been written, as a function; inner: of as many lanes as a value has, else of all of them."""
        body, self.lines = "\n".join(self.lines), []
        whole = f"{self.name}_{name}"
        own = whole if inner else f"{whole}.pass"
        text = f"define internal void @{own}({arguments}) noinline nounwind {{\n{body}\nret void\n}}\n"
        if inner:
            return text
        return text + emit.VALUES.function(whole, arguments.split(", "), (), f"call void @{own}({arguments})")

    # ------------------------------------------------------------ entries
    def clear(self, rows: int) -> str:
        with self._loop("n", str(rows), "0", row=("%matrix", ROW)):
            self._store("%row", 0, _constant(0.0))
        return self._function("clear", "ptr %matrix", inner=False)

    def terms(
        self, number: int, count: int, weights: Sequence[Sequence[float]], power: int, factor: int, rows: int
    ) -> str:
        """Take terms from blocks; factor, rows: see `Each`."""
        given = [self._load("%each", factor)] * power
        with self._loop("n", str(count), "0", term=(f"@{self.name}.terms{number}", 8)):
            place = self._behind("%each", self._whole("%term"), ROW)
            block = self._behind("%matrix", self._whole("%term", 1), ROW * self.side**2)
            for i, row in enumerate(weights):
                x = self._load(place, rows * i)
                for y in given:
                    x = self._times(x, y)
                for j, weight in enumerate(row):
                    if abs(weight) > NO_WEIGHT:
                        entry = self._load(block, self.side * i + j)
                        self._store(block, self.side * i + j, self._less(entry, x, _constant(weight)))
        return self._function(f"terms{number}", "ptr %matrix, ptr %each")

    def add(self, count: int) -> str:
        self.lines += [f"call void @{self.name}_terms{n}(ptr %matrix, ptr %each)" for n in range(count)]
        return self._function("add", "ptr %matrix, ptr %each", inner=False)

    # ------------------------------------------------------------ elimination
    def pivot(self) -> str:
        """The pivot's block becomes its factors, with 1 over what stands on its diagonal, and its row what is left."""
        block, copies = self._rows("%block", range(self.side)), range(self.side)
        for k in copies:
            block[k, k] = self._new(f"fdiv {emit.VALUES.name} {_constant(1.0)}, {block[k, k]}")
            for i in copies[k + 1 :]:
                block[i, k] = self._times(block[i, k], block[k, k])
                block |= {(i, j): self._less(block[i, j], block[i, k], block[k, j]) for j in copies[k + 1 :]}
        self._keep("%block", block)
        if self.side > 1:
            with self._loop("n", "%count", "0", column=("%columns", ROW * self.side**2)):
                own = self._rows("%column", copies)
                for k in copies:
                    for i in copies[k + 1 :]:
                        own |= {(i, j): self._less(own[i, j], block[i, k], own[k, j]) for j in copies}
                self._keep("%column", {place: x for place, x in own.items() if place[0] > 0})
        return self._function("pivot", "ptr %block, ptr %columns, i64 %count")

    def row(self) -> str:
        """The block of a later row becomes its factors, times which the pivot's row is taken from that row."""
        copies, size = range(self.side), ROW * self.side**2
        block, factors = self._rows("%block", copies), self._rows("%factors", copies)
        for k in copies:
            for i in copies:
                factors[i, k] = self._times(factors[i, k], block[k, k])
                factors |= {(i, j): self._less(factors[i, j], factors[i, k], block[k, j]) for j in copies[k + 1 :]}
        self._keep("%factors", factors)
        entry, together = "0", max(1, (REGISTERS - self.side) // (2 * self.side))
        for n, first in enumerate(range(0, self.side, together)):
            some = copies[first : first + together]
            moving = {f"column{n}": ("%columns", size), f"target{n}": ("%targets", 4)}
            with self._loop(f"n{n}", "%count", entry, **moving):
                target = self._behind("%matrix", self._whole(f"%target{n}"), size)
                own = self._rows(target, some)
                for k in copies:
                    above = self._rows(f"%column{n}", [k])
                    own |= {(i, j): self._less(x, factors[i, k], above[k, j]) for (i, j), x in own.items()}
                self._keep(target, own)
            entry = f"n{n}.done"
        return self._function("row", "ptr %matrix, ptr %block, ptr %factors, ptr %columns, ptr %targets, i64 %count")

    def _step(self, pivot: str) -> tuple[list[str], str, str, str]:
        """The numbers of a pivot, its block, those of its columns, those of its rows."""
        size = ROW * self.side**2
        numbers = self._behind(f"@{self.name}.numbers", pivot, 4 * NUMBERS)
        found = [self._whole(numbers, n) for n in range(NUMBERS)]
        block = self._behind("%matrix", found[2], size)
        columns = self._new(f"getelementptr i8, ptr {block}, i64 {size}")
        return found, block, columns, self._behind(columns, found[0], size)

    def eliminate(self, size: int) -> str:
        with self._loop("p", str(size), "0"):
            (count, rows, _, _, first), block, columns, factors = self._step("%p")
            self.lines.append(f"call void @{self.name}_pivot(ptr {block}, ptr {columns}, i64 {count})")
            targets, by = self._behind(f"@{self.name}.targets", first, 4), self._new(f"mul i64 {count}, 4")
            given = f"ptr {block}, ptr %factors, ptr {columns}, ptr %targets, i64 {count}"
            with self._loop("r", rows, "p.body", factors=(factors, ROW * self.side**2), targets=(targets, by)):
                self.lines.append(f"call void @{self.name}_row(ptr %matrix, {given})")
        return self._function("eliminate", "ptr %matrix", inner=False)

    # ------------------------------------------------------------ solution
    def forward(self) -> str:
        """The right-hand side of a pivot is known, and leaves those of later rows."""
        copies = range(self.side)
        block, known = self._rows("%block", copies), [self._load("%own", k) for k in copies]
        for k in copies:
            for i in copies[k + 1 :]:
                known[i] = self._less(known[i], block[i, k], known[k])
        for k in copies[1:]:
            self._store("%own", k, known[k])
        moving = {"row": ("%rows", ROW * self.side**2), "place": ("%places", 4)}
        with self._loop("n", "%count", "0", **moving):
            other = self._behind("%vector", self._whole("%place"), ROW * self.side)
            factors = self._rows("%row", copies)
            for i in copies:
                total = self._load(other, i)
                for k in copies:
                    total = self._less(total, factors[i, k], known[k])
                self._store(other, i, total)
        return self._function("forward", "ptr %block, ptr %rows, ptr %vector, ptr %own, ptr %places, i64 %count")

    def backward(self) -> str:
        """The copies of a variable, the last one first: of those that left later, the solution is known."""
        copies, v = range(self.side), emit.VALUES.name
        block, given = self._rows("%block", copies), [self._load("%own", k) for k in copies]
        moving = {"column": ("%columns", ROW * self.side**2), "place": ("%places", 4)}
        with self._loop("n", "%count", "0", **moving):
            place = self.lines.index("n.next:") + 1
            other = self._behind("%vector", self._whole("%place"), ROW * self.side)
            above, known = self._rows("%column", copies), [self._load(other, j) for j in copies]
            for k in copies:
                total = f"%total{k}"
                for j in copies:
                    total = self._less(total, above[k, j], known[j])
                self.lines.insert(place, f"%total{k} = phi {v} [{given[k]}, %0], [{total}, %n.end]")
        found = [f"%total{k}" for k in copies]
        for k in reversed(copies):
            for j in copies[k + 1 :]:
                found[k] = self._less(found[k], block[k, j], found[j])
            found[k] = self._times(found[k], block[k, k])
            self._store("%own", k, found[k])
        return self._function("backward", "ptr %block, ptr %columns, ptr %vector, ptr %own, ptr %places, i64 %count")

    def solve(self, size: int, vector: int) -> str:
        right = self._at("%matrix", vector)
        for name, entry in (("f", "0"), ("b", "f.done")):
            with self._loop(name, str(size), entry):
                pivot = f"%{name}" if name == "f" else self._new(f"sub i64 {size - 1}, %b")
                (columns, rows, _, first, _), block, above, below = self._step(pivot)
                own = self._behind(right, pivot, ROW * self.side)
                places = self._behind(f"@{self.name}.places", first, 4)
                if name == "f":
                    places = self._behind(places, columns, 4)
                    given = f"ptr {block}, ptr {below}, ptr {right}, ptr {own}, ptr {places}, i64 {rows}"
                    self.lines.append(f"call void @{self.name}_forward({given})")
                else:
                    given = f"ptr {block}, ptr {above}, ptr {right}, ptr {own}, ptr {places}, i64 {columns}"
                    self.lines.append(f"call void @{self.name}_backward({given})")
        return self._function("solve", "ptr %matrix", inner=False)


def _constant(x: float) -> str:
    """A number in every lane; its bits, since not every decimal is a double."""
    return emit.VALUES.constant("double", f"0x{pack('>d', x).hex().upper()}")
