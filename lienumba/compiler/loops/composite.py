"""Kernels of several parts, which have straight-line code, and of loops that call them."""

from collections.abc import Mapping, Sequence
from copy import copy
from typing import Any, Self

from lienumba.compiler import emit
from lienumba.compiler.emit import Kernel
from lienumba.compiler.rows import ARGUMENTS


class Composite:
    """parts: kernels `name`_part, each of the rows and values that it stores."""

    def __init__(self, name: str, parts: Mapping[str, Sequence[tuple[int, Any]]]) -> None:
        self.name, self.work_rows = name, 0
        self.parts = [
            Kernel(f"{name}_{part}", tuple(x for _, x in stores), 0, tuple(row for row, _ in stores))
            for part, stores in parts.items()
        ]

    @property
    def hoisted(self) -> list[int]:
        return [row for part in self.parts for row in part.hoisted.values()]

    def hoisted_from(self, row: int) -> Self:
        """The same with its invariants from this row of the parameters on."""
        moved = copy(self)
        moved.parts = []
        for part in self.parts:
            moved.parts.append(part.hoisted_from(row))
            row += len(part.hoisted)
        return moved

    def counts(self) -> dict[str, int]:
        """Operations of one evaluation."""
        raise NotImplementedError

    def body(self) -> str:
        """The LLVM text that calls the parts."""
        raise NotImplementedError

    def text(self) -> str:
        """The LLVM text of this kernel and of its `prepare`."""
        texts = [part.text().replace(emit.VALUES.declarations, "") for part in self.parts]
        self.work_rows = max(part.work_rows for part in self.parts)
        prepares = "\n".join(f"call void @{part.name}_prepare({ARGUMENTS})" for part in self.parts)
        prepare = f"define void @{self.name}_prepare({ARGUMENTS}) nounwind {{\n{prepares}\nret void\n}}\n"
        return "\n".join((emit.VALUES.declarations, *texts, self.body(), prepare))
