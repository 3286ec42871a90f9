"""The LLVM text of one function: registers, slots for names, blocks."""

from lienumba.compiler.routines.values import Scalar


class Writer:
    """`open`: whether the block that is being written goes on."""

    def __init__(self) -> None:
        self.lines: list[str] = []
        self.slots: list[str] = []
        self.open = True
        self._count = 0

    def _new(self) -> int:
        self._count += 1
        return self._count

    def op(self, kind: str, text: str) -> Scalar:
        """The register of what an instruction gives."""
        name = f"%r{self._new()}"
        self.lines.append(f"  {name} = {text}")
        return Scalar(kind, name)

    def do(self, text: str) -> None:
        """An instruction that gives nothing."""
        self.lines.append(f"  {text}")

    def slot(self, kind: str) -> str:
        """Memory for a name; LLVM makes registers of it."""
        name = f"%s{self._new()}"
        self.slots.append(f"  {name} = alloca {kind}, align 8")
        return name

    def put(self, slot: str, x: Scalar) -> None:
        """Write a slot."""
        self.do(f"store {x.kind} {x.text}, ptr {slot}, align 8")

    def get(self, slot: str, kind: str) -> Scalar:
        """Read a slot."""
        return self.op(kind, f"load {kind}, ptr {slot}, align 8")

    def label(self) -> str:
        """The name of a block to come."""
        return f"b{self._new()}"

    def begin(self, label: str) -> None:
        """From here on this block is written."""
        self.jump(label)
        self.lines.append(f"{label}:")
        self.open = True

    def jump(self, label: str) -> None:
        """Go on in another block."""
        if self.open:
            self.do(f"br label %{label}")
        self.open = False

    def branch(self, condition: Scalar, yes: str, no: str) -> None:
        """Go on in one of two blocks."""
        self.do(f"br i1 {condition.text}, label %{yes}, label %{no}")
        self.open = False

    def text(self, head: str) -> str:
        """The function."""
        return "\n".join((f"{head} {{", "b0:", *self.slots, *self.lines, "}\n"))
