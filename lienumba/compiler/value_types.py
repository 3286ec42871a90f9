"""The type of a value in the text of kernels: a vector with one double per lane, or the double of one lane.

A kernel of doubles runs its body for one lane after the other, on the same rows of W doubles, and gives the same bits.
LLVM's fast instruction selection (level 0) does not support these vectors: doubles compile in a third of the time, and
run slower. Tests use them.
"""

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

    def function(self, name: str, arguments: str, body: str, linkage: str = "") -> str:
        """A function of all W lanes; body: of `lanes` lanes; arguments: pointers to rows, and whole numbers."""
        whole = f"define {linkage}void @{name}({arguments}) nounwind {{\n"
        if self.lanes == W:
            return f"{whole}{body}\nret void\n}}\n"
        pointers = [x for x in arguments.split(", ") if x.startswith("ptr")]
        moved = "\n".join(f"{x[4:]}.lane = getelementptr double, {x}, i64 %lane" for x in pointers)
        given = ", ".join(f"{x}.lane" if x in pointers else x for x in arguments.split(", "))
        return f"""define internal void @{name}.lane({arguments}) nounwind {{
{body}
ret void
}}
{whole}br label %next
next:
%lane = phi i64 [0, %0], [%after, %next]
{moved}
call void @{name}.lane({given})
%after = add i64 %lane, 1
%more = icmp ult i64 %after, {W}
br i1 %more, label %next, label %end
end:
ret void
}}
"""


VECTOR, DOUBLE = ValueType(W), ValueType(1)
