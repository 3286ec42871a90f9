"""Segments that differ only in the rows that they read and write become one function with many calls.

A function gets a pointer for each group of rows that move together from call to call: its code then holds the same
offsets for all. The few rows that move on their own are looked up in a table of the call.
"""

from dataclasses import dataclass, field

from lienumba.compiler.rows import ARGUMENTS, ARRAYS, ROW
from lienumba.compiler.value_types import ValueType

GROUP = 3  # rows that move together from which on they have a pointer of their own

Move = tuple[int, ...]  # of a row, from the first call to each


@dataclass
class Segment:
    """Lines of LLVM text. Those of `accesses` (line, array, row, whether it is written) are filled in last."""

    lines: list[str] = field(default_factory=list)
    accesses: list[tuple[int, str, int, bool]] = field(default_factory=list)

    def pointer(self, array: str, row: int, written: bool) -> str:
        self.accesses.append((len(self.lines), array, row, written))
        self.lines.append("")
        return f"%p{len(self.lines) - 1}"

    def key(self) -> tuple[object, ...]:
        """Equal for segments that may share their code."""
        return (*self.lines, *((array, written) for _, array, _, written in self.accesses))


def distinct(segments: list[Segment]) -> int:
    """How many functions they need."""
    return len({segment.key() for segment in segments})


def assembled(name: str, segments: list[Segment], values: ValueType) -> str:
    """The function that calls the segments one after the other."""
    alike: dict[tuple[object, ...], list[int]] = {}
    for number, segment in enumerate(segments):
        alike.setdefault(segment.key(), []).append(number)
    text: list[str] = []
    calls = [""] * len(segments)
    for numbers in alike.values():
        shared = _Shared(f"{name}.{numbers[0]}", [segments[number] for number in numbers])
        text.append(shared.function(values))
        for call, number in enumerate(numbers):
            calls[number] = shared.call(call, f"{name}.{number}")
            text.append(shared.table(call, f"{name}.{number}"))
    every = "\n".join(calls)
    return "\n".join(text) + f"\ndefine void @{name}({ARGUMENTS}) nounwind {{\n{every}\nret void\n}}\n"


class _Shared:
    """The function of equal segments. Each group of rows has its pointer in the middle of them, since instructions are
    shorter, and fetching them is what long kernels wait for, where an offset is within 127 rows."""

    def __init__(self, name: str, segments: list[Segment]) -> None:
        self.name, self.segments = name, segments
        groups: dict[tuple[str, bool, Move], list[int]] = {}
        rows = zip(*([row for _, _, row, _ in segment.accesses] for segment in segments), strict=True)
        for access, own in enumerate(rows):
            _, array, first, written = segments[0].accesses[access]
            groups.setdefault((array, written, tuple(row - first for row in own)), []).append(access)
        self.group: dict[int, int] = {}  # of an access
        self.middle: list[int] = []  # of a group: an access
        self.alone: list[int] = []  # accesses by table
        for accesses in groups.values():
            if len(accesses) < GROUP and len(segments) > 1:
                self.alone += accesses
                continue
            self.group |= dict.fromkeys(accesses, len(self.middle))
            self.middle.append(sorted(accesses, key=self._row)[len(accesses) // 2])

    def _row(self, access: int, call: int = 0) -> int:
        return self.segments[call].accesses[access][2]

    def function(self, values: ValueType) -> str:
        segment = self.segments[0]
        lines = list(segment.lines)
        for access, (line, _, row, _) in enumerate(segment.accesses):
            if access in self.group:
                group = self.group[access]
                offset = ROW * (row - self._row(self.middle[group]))
                lines[line] = f"%p{line} = getelementptr i8, ptr %g{group}, i64 {offset}"
        for n, access in enumerate(self.alone):
            line, array, _, _ = segment.accesses[access]
            lines[line] = (
                f"%t{n} = getelementptr i32, ptr %rows, i64 {n}\n%o{n} = load i32, ptr %t{n}, align 4\n"
                f"%p{line} = getelementptr i8, ptr %{array}, i32 %o{n}"
            )
        of = [segment.accesses[access] for access in self.middle]
        renewed = any(array == "out" and not written for _, array, _, written in segment.accesses)
        alone = ["" if array == "out" and renewed else "noalias " for _, array, _, _ in of]
        pointers = [f"ptr {alone[group]}{'' if x[3] else 'readonly '}%g{group}" for group, x in enumerate(of)]
        if self.alone:
            pointers += [f"ptr %{array}" for array in ARRAYS]
        table = ["ptr noalias readonly %rows"] if self.alone else []
        return values.function(self.name, pointers, table, "\n".join(lines), "noinline nounwind")

    def call(self, call: int, label: str) -> str:
        local = label.replace(".", "_")
        text, given = "", []
        for group, access in enumerate(self.middle):
            array, offset = self.segments[call].accesses[access][1], ROW * self._row(access, call)
            text += f"%{local}.{group} = getelementptr i8, ptr %{array}, i64 {offset}\n"
            given.append(f"ptr %{local}.{group}")
        if self.alone:
            given += [ARGUMENTS, f"ptr @{label}.rows"]
        return f"{text}call void @{self.name}({', '.join(given)})"

    def table(self, call: int, label: str) -> str:
        if not self.alone:
            return ""
        rows = ", ".join(f"i32 {ROW * self._row(access, call)}" for access in self.alone)
        return f"@{label}.rows = internal constant [{len(self.alone)} x i32] [{rows}]\n"
