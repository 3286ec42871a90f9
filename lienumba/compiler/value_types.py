"""The type of a value in the text of kernels: a vector with one double per lane, or the double of one lane.

A function does the W lanes of its rows in passes of as many lanes as a value has, and gives the same bits whatever that
number is. LLVM's fast instruction selection (level 0) does not support vectors: doubles compile in a third of the time,
and run slower. Tests use them.
"""

from collections.abc import Sequence

from lienumba.compiler.rows import W


class ValueType:
    """Names of types, operations and constants of `lanes` lanes."""

    def __init__(self, lanes: int) -> None:
        self.lanes = lanes
        self.name, self.mask, self.bits, self.pointer = map(self._each, ("double", "i1", "i64", "ptr"))
        v, suffix = self.name, f"v{lanes}f64" if lanes > 1 else "f64"
        self.fma, self.sqrt = f"call {v} @llvm.fma.{suffix}", f"call {v} @llvm.sqrt.{suffix}"
        self._gather = f"{v} @llvm.masked.gather.{suffix}.v{lanes}p0"
        self.declarations = f"\ndeclare {v} @llvm.fma.{suffix}({v}, {v}, {v})\ndeclare {v} @llvm.sqrt.{suffix}({v})\n"
        if lanes > 1:
            self.declarations += f"declare {self._gather}({self.pointer}, i32, {self.mask}, {v})\n"

    def _each(self, scalar: str) -> str:
        return f"<{self.lanes} x {scalar}>" if self.lanes > 1 else scalar

    def constant(self, scalar: str, x: str) -> str:
        """The same number in every lane."""
        return f"<{', '.join([f'{scalar} {x}'] * self.lanes)}>" if self.lanes > 1 else x

    def gathered(self, n: int, address: str, index: str) -> list[str]:
        """Instructions, numbered n, of which the last loads a double per lane: at an address, which is the bits of a
        number, and an index from there. X86's fast selection of a sum of pointers takes the number for the address."""
        v, bits, pointer = self.name, self.bits, self.pointer
        start, place = f"%b{n} = bitcast {v} {address} to {bits}", f"%i{n} = fptosi {v} {index} to {bits}"
        if self.lanes == 1:
            total = f"%a{n} = shl i64 %i{n}, 3", f"%s{n} = add i64 %b{n}, %a{n}", f"%q{n} = inttoptr i64 %s{n} to ptr"
            return [start, place, *total, f"load double, ptr %q{n}, align 8"]
        first = f"%a{n} = inttoptr {bits} %b{n} to {pointer}"
        sought = f"%q{n} = getelementptr double, {pointer} %a{n}, {bits} %i{n}"
        every = self.constant("i1", "true")
        load = f"call {self._gather}({pointer} %q{n}, i32 8, {self.mask} {every}, {v} undef)"
        return [start, first, place, sought, load]

    def function(
        self, name: str, pointers: Sequence[str], others: Sequence[str], body: str, attributes: str = "nounwind"
    ) -> str:
        """A function within its module. pointers: its arguments that point to rows; others: those that are the same in
        every pass; body: of one pass, without branches."""
        if self.lanes < W:
            names = [x.rpartition("%")[2] for x in pointers]
            moved = "\n".join(f"%{x} = getelementptr double, ptr %{x}.row, i64 %lane" for x in names)
            pointers = [f"{x}.row" for x in pointers]
            body = f"""br label %next
next:
%lane = phi i64 [0, %0], [%after, %next]
{moved}
{body}
%after = add i64 %lane, {self.lanes}
%more = icmp ult i64 %after, {W}
br i1 %more, label %next, label %end
end:"""
        return (
            f"define internal void @{name}({', '.join([*pointers, *others])}) {attributes} {{\n{body}\nret void\n}}\n"
        )


VECTOR, DOUBLE = ValueType(W), ValueType(1)
