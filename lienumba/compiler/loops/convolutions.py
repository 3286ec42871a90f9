"""The kernel of a series: its first coefficients, and for each order the sums of products and what follows from them.

Sums are loops over j, several side by side: what they read is read once for all of them, and none waits for itself.
"""

from collections.abc import Sequence
from struct import pack, unpack
from typing import Any

from lienumba.compiler import emit
from lienumba.compiler.loops.composite import Composite
from lienumba.compiler.rows import ARGUMENTS, ROW
from lienumba.compiler.series import Orders, Sum
from lienumba.compiler.value_types import VECTOR

TILE = 14  # sums side by side: registers are left for what they read
NUMBERS = 3  # k, 1/k, 1/(k + 1)
LAST = "last"  # the array in which whoever reads the series finds it


class SeriesKernel(Composite):
    """Writes the coefficients 0 to `order` to the rows of `out` from `first` on, series by series; and then what
    `outputs` (row, value) says of them, which reads them in "extra", from the first coefficient on."""

    def __init__(self, name: str, orders: Orders, order: int, first: int, outputs: Sequence[tuple[int, Any]]) -> None:
        self.orders, self.order, self.first, slices = orders, order, first, orders.rows
        known = slices + len(orders.sums)
        start = [*orders.start, *((known + n, x) for n, x in enumerate(orders.known))]
        self.rows = known + len(orders.known)
        super().__init__(name, {"start": start, "order": orders.order, "end": outputs})

    def counts(self) -> dict[str, int]:
        """Operations of a step: sums of products count as often as they are computed."""
        found: dict[str, int] = {}
        for part, times in zip(self.parts, (1, self.order - 1, 1), strict=True):
            for name, count in part.counts().items():
                found[name] = found.get(name, 0) + times * count
        for each in self.orders.sums:
            terms = sum(k + 1 if each.full else k - 1 for k in range(1, self.order)) * len(each.terms)
            for name, count in (("fma", terms), ("operations", terms), ("flops", 2 * terms)):
                found[name] += count
        return found

    def body(self) -> str:
        return "\n".join((*_sums(f"{self.name}_sums", self.orders, self.order), self._whole()))

    def _whole(self) -> str:
        slices = self.orders.rows
        rows = [c for k in range(self.order) for c in (float(k), 1.0 / max(k, 1), 1.0 / (k + 1))]
        table = ", ".join(f"{VECTOR.name} {VECTOR.constant('double', _hex(c))}" for c in rows)
        return f"""
@{self.name}.table = internal constant [{len(rows)} x {VECTOR.name}] [{table}], align 64
define void @{self.name}({ARGUMENTS}) nounwind {{
%slices = getelementptr i8, ptr %out, i64 {ROW * self.first}
%sums = getelementptr i8, ptr %slices, i64 {ROW * slices}
%known = getelementptr i8, ptr %sums, i64 {ROW * len(self.orders.sums)}
call void @{self.name}_start(ptr %state, ptr %parameters, ptr %clock, ptr %extra, ptr %slices, ptr %work)
br label %next
next:
%k = phi i64 [1, %0], [%after, %body]
%done = icmp uge i64 %k, {self.order}
br i1 %done, label %end, label %body
body:
%offset = mul i64 %k, {ROW}
%slice = getelementptr i8, ptr %slices, i64 %offset
%place = mul i64 %k, {ROW * NUMBERS}
%numbers = getelementptr i8, ptr @{self.name}.table, i64 %place
call void @{self.name}_sums(ptr %slices, ptr %sums, i64 %k)
call void @{self.name}_order(ptr %known, ptr %parameters, ptr %numbers, ptr %slice, ptr %slice, ptr %work)
%after = add i64 %k, 1
br label %next
end:
call void @{self.name}_end(ptr %state, ptr %parameters, ptr %clock, ptr %slices, ptr %out, ptr %work)
ret void
}}
"""


def _hex(x: float) -> str:
    return f"0x{unpack('<Q', pack('<d', x))[0]:016X}"


def _sums(name: str, orders: Orders, order: int) -> list[str]:
    """Functions of (slices, sums, k) that leave every sum in its row; sum n lies n rows before the end."""
    texts, calls = [], []
    for full in (True, False):
        numbered = [(n, each) for n, each in enumerate(orders.sums) if each.full == full]
        for number, tile in enumerate(_tiles(numbered)):
            own = f"{name}_{'full' if full else 'inner'}{number}"
            texts.append(_loop(own, tile, full, len(orders.sums)))
            calls.append(f"call void @{own}(ptr %slices, ptr %sums, i64 %k)")
    return [*texts, emit.VALUES.function(name, ("ptr %slices", "ptr %sums"), ("i64 %k",), "\n".join(calls))]


Numbered = tuple[int, Sum]


def _tiles(every: list[Numbered]) -> list[list[Numbered]]:
    """Sums that read much in common side by side."""
    left, tiles = list(every), []
    while left:
        tile, read = [left.pop(0)], set[int]()
        read |= {place for _, x, y in tile[0][1].terms for place in (x, y)}
        while left and len(tile) < TILE:
            best = min(left, key=lambda each: len({p for _, x, y in each[1].terms for p in (x, y)} - read))
            left.remove(best)
            tile.append(best)
            read |= {place for _, x, y in best[1].terms for place in (x, y)}
        tiles.append(tile)
    return tiles


def _loop(name: str, tile: list[Numbered], full: bool, count: int) -> str:
    """The sums of a tile, in one loop over j."""
    v = emit.VALUES.name
    first, last = (0, "%k") if full else (1, "%before")
    signs: list[str] = []
    loads: dict[tuple[str, int], str] = {}
    lines: list[str] = []
    ends: list[str] = []

    def load(end: str, place: int) -> str:
        if (end, place) not in loads:
            value = loads[end, place] = f"%{end}{place}"
            signs.append(f"{value}.at = getelementptr i8, ptr %{end}, i64 {ROW * place}")
            signs.append(f"{value} = load {v}, ptr {value}.at, align 8")
        return loads[end, place]

    for n, each in tile:
        total = f"%s{n}"
        for t, (sign, x, y) in enumerate(each.terms):
            if ("left", y) in loads and ("right", x) in loads and not (("left", x) in loads and ("right", y) in loads):
                x, y = y, x
            a, b = load("left", x), load("right", y)
            if sign < 0.0:
                lines.append(f"%m{n}.{t} = fneg {v} {a}")
                a = f"%m{n}.{t}"
            lines.append(f"%t{n}.{t} = {emit.VALUES.fma}({v} {a}, {v} {b}, {v} {total})")
            total = f"%t{n}.{t}"
        ends.append(total)
    starts = [f"%s{n} = phi {v} [zeroinitializer, %entry]" for n, _ in tile]
    phis = "\n".join(f"{start}, [{end}, %body]" for start, end in zip(starts, ends, strict=True))
    stores = "\n".join(
        f"%o{n} = getelementptr i8, ptr %sums, i64 {ROW * (count - 1 - n)}\nstore {v} %s{n}, ptr %o{n}, align 8"
        for n, _ in tile
    )
    body = "\n".join(signs + lines)
    return f"""
define internal void @{name}(ptr noalias readonly %slices, ptr noalias %sums, i64 %k) noinline nounwind {{
entry:
%before = sub i64 %k, 1
%far = sub i64 %k, {first}
%left.offset = mul i64 {first}, {ROW}
%right.offset = mul i64 %far, {ROW}
%left.first = getelementptr i8, ptr %slices, i64 %left.offset
%right.first = getelementptr i8, ptr %slices, i64 %right.offset
br label %next
next:
%j = phi i64 [{first}, %entry], [%after, %body]
%left = phi ptr [%left.first, %entry], [%left.next, %body]
%right = phi ptr [%right.first, %entry], [%right.next, %body]
{phis}
%more = icmp sle i64 %j, {last}
br i1 %more, label %body, label %end
body:
{body}
%after = add i64 %j, 1
%left.next = getelementptr i8, ptr %left, i64 {ROW}
%right.next = getelementptr i8, ptr %right, i64 -{ROW}
br label %next
end:
{stores}
ret void
}}
"""
