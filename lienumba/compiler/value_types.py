"""The type of a value in the text of kernels: a vector with one double per lane, or the double of one lane.

A kernel of doubles runs its body for one lane after the other, on the same rows of W doubles, and gives the same bits.
LLVM's fast instruction selection, which level 0 uses, knows no such vectors: doubles compile in a third of the time,
and run slower. Tests use them.
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

    def gathered(self, pointer: str) -> str:
        """The doubles at the pointers of all lanes."""
        if self.lanes == 1:
            return f"load double, ptr {pointer}, align 8"
        every = self.constant("i1", "true")
        return f"call {self._gather}({self.pointer} {pointer}, i32 8, {self.mask} {every}, {self.name} undef)"

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
