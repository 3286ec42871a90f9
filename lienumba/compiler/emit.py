"""A graph becomes LLVM text: one vector of doubles per value, straight-line functions of bounded length.

Every kernel has the signature  void (state, parameters, clock, extra, out, work)  of pointers to rows of W doubles.
What depends on parameters alone is moved to a second function, `prepare`, which stores it behind the parameters.
LLVM slows down on one huge block, so a graph is cut into segments, functions of a few hundred operations; values that
cross a cut travel through `work`, and segments that do the same share their code. A value is one register of the CPU: a
segment passes over the lanes of its rows before the next one begins. No instruction carries a fast-math flag.
"""

import struct
from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass, field
from functools import lru_cache
from math import inf
from typing import Any, TypeGuard

from lienumba.compiler import native
from lienumba.compiler.foreign.calls import KNOWN
from lienumba.compiler.rows import W, WorkRows
from lienumba.compiler.segments import LONGEST, Segments, by_content, by_size, with_parts
from lienumba.compiler.sharing import Segment, assembled, distinct
from lienumba.compiler.symbols import FUSED, Symbol, live, operation_counts, uncollected
from lienumba.compiler.value_types import VECTOR, ValueType
from lienumba.numerics.vector_math import ROUND

Value = Symbol | float  # of a graph
VALUES = ValueType(min(W, native.register_lanes()))  # the type of values in the text
LONG = 8000  # operations from which on equal parts are looked for,
REPEATED = 0.7  # and worth it where this fraction of the segments, or less, are distinct
SOON = 8  # segments within which a value is read for the last time, or it is kept apart
BINARY = {"+": "fadd", "-": "fsub", "*": "fmul", "/": "fdiv"}
COMPARE = {"<": "olt", "<=": "ole", "==": "oeq"}


@dataclass
class Kernel:
    """One compiled function.

    first_hoisted: the row behind the parameters where its invariants begin; rows: where in `out` each output goes, by
    default one after the other; renews: whether it reads rows of `out`: each is then stored behind what loads it.
    """

    name: str
    outputs: tuple[Any, ...]
    first_hoisted: int
    rows: tuple[int, ...] | None = None
    renews: bool = False
    order: list[Symbol] = field(init=False)
    hoisted: dict[int, int] = field(init=False)
    work_rows: int = field(init=False, default=0)

    def __post_init__(self) -> None:
        self.order = with_parts(live(self.outputs))
        used: dict[int, int] = {}
        for read in (*(node.args for node in self.order if not node.invariant), self.outputs):
            for x in read:
                if isinstance(x, Symbol) and x.invariant and x.op != "input":
                    used.setdefault(x.id, self.first_hoisted + len(used))
        self.hoisted = used

    def hoisted_from(self, row: int) -> "Kernel":
        """The same with its invariants from this row of the parameters on."""
        moved = copy(self)
        moved.first_hoisted, moved.hoisted = row, {id_: row + n for n, id_ in enumerate(self.hoisted)}
        return moved

    @property
    def hoists(self) -> set[int]:
        """The rows of parameters on which its invariants depend."""
        computed = (node for node in self.order if node.invariant and node.op != "input")
        return {x.args[1] for node in computed for x in node.args if _is_input(x)}

    @property
    def values(self) -> ValueType:
        """The type of its values: all lanes where it calls a function, so that it is called once for a block."""
        return VECTOR if VALUES.lanes > 1 and any(node.op == "call" for node in self.order) else VALUES

    def counts(self) -> dict[str, int]:
        """Operations of one evaluation; invariants are not counted."""
        return operation_counts([n for n in self.order if not n.invariant])

    @uncollected()
    def text(self) -> str:
        """The LLVM text of this kernel and of its `prepare`."""
        main = [n for n in self.order if not n.invariant and n.op != "input"]
        writer = _Writer(self)
        rows = range(len(self.outputs)) if self.rows is None else self.rows
        body = writer.function(self.name, main, [("out", *store) for store in zip(rows, self.outputs, strict=True)])
        invariant = [n for n in self.order if n.invariant and n.op != "input"]
        kept = [("parameters", self.hoisted[n.id], n) for n in invariant if n.id in self.hoisted]
        preparer = _Writer(self, preparing=True)
        prepare = preparer.function(f"{self.name}_prepare", invariant, kept)
        self.work_rows = max(writer.work.count, preparer.work.count)
        return self.values.declarations + body + "\n" + prepare


_bits = struct.Struct(">d").pack  # by which a zero with a sign is another


@lru_cache(1024)
def _constant(bits: bytes, values: ValueType) -> str:
    return values.constant("double", f"0x{bits.hex().upper()}")


def _is_input(x: Value) -> TypeGuard[Symbol]:
    return isinstance(x, Symbol) and x.op == "input"


class _Writer:
    """Writes one function as a row of segments."""

    def __init__(self, kernel: Kernel, preparing: bool = False) -> None:
        self.kernel, self.preparing, self.work, self.values = kernel, preparing, WorkRows(), kernel.values
        self.segments: list[Segment] = []
        self.names: dict[int, str] = {}  # of the values that the segment has computed or loaded,
        self.masks: dict[int, str] = {}  # and of its comparisons
        self.computed = self.loads = 0

    def function(self, name: str, order: list[Symbol], stores: Sequence[tuple[str, int, Value]]) -> str:
        """`stores`: (array, row, value) of everything the function leaves behind."""
        if len(order) >= LONG:
            self._write(by_content(order), stores, frames=True)
            if distinct(self.segments) <= REPEATED * len(self.segments):
                return assembled(name, self.segments, self.values)
        self._write(by_size(order, self.values.lanes < W), stores, frames=False)
        return assembled(name, self.segments, self.values)

    def _write(self, parts: Segments, stores: Sequence[tuple[str, int, Value]], frames: bool) -> None:
        """Fill the segments; frames: what each leaves lies side by side."""
        self.segments, self.work = [], WorkRows()
        last_use: dict[int, int] = {}
        for i, part in enumerate(parts):
            last_use |= {x.id: i for node in part for x in node.args if x.__class__ is Symbol}
        stored: dict[int, list[tuple[str, int]]] = {}  # where a value goes when it has been computed
        late: list[tuple[str, int, Value]] = []  # not computed here, or not stored before all is
        ready = {node.id: n for n, node in enumerate(node for part in parts for node in part)}
        loads = self._last_loads(parts, stores) if self.kernel.renews else {}
        for array, row, x in stores:
            if isinstance(x, Symbol) and x.id in ready and loads.get((array, row), -1) > ready[x.id]:
                last_use[x.id] = len(parts)
                late.append((array, row, x))
            elif isinstance(x, Symbol) and x.id in ready:
                stored.setdefault(x.id, []).append((array, row))
            else:
                late.append((array, row, x))
        for i, part in enumerate(parts):
            self._begin()
            crossing = [node.id for node in part if last_use.get(node.id, i) > i]
            if frames:
                self.work.keep([id_ for id_ in crossing if last_use[id_] - i <= SOON])
                self.work.keep([id_ for id_ in crossing if last_use[id_] - i > SOON])
            else:
                for id_ in crossing:
                    self.work.keep([id_])
            for node in part:
                self._compute(node)
                if node.id in stored:
                    for array, row in stored[node.id]:
                        self._store(array, row, self._value(node))
                if last_use.get(node.id, i) > i:
                    self._store("work", self.work.of[node.id], self._value(node))
            for id_ in [id_ for id_ in self.work.of if last_use[id_] <= i]:
                self.work.release(id_)
        for n, (array, row, x) in enumerate(late):
            if n and n % LONGEST == 0:
                self._begin()
            self._store(array, row, self._value(x))

    @staticmethod
    def _last_loads(parts: Segments, stores: Sequence[tuple[str, int, Value]]) -> dict[tuple[str, int], float]:
        """Which operation loads each row of memory for the last time: in a segment the first one that reads it; an
        infinite one where a row is read to be stored."""
        last: dict[tuple[str, int], float] = {}
        first = 0
        for part in parts:
            nodes = [*enumerate(part, first)]
            last |= {x.args: n for n, node in reversed(nodes) for x in node.args if _is_input(x)}
            first += len(part)
        return last | {x.args: inf for _, _, x in stores if _is_input(x)}

    def _begin(self) -> None:
        """The next segment."""
        self.segments.append(Segment())
        self.names, self.masks = {}, {}
        self.computed = self.loads = 0

    # ------------------------------------------------------------ rows of memory
    def _store(self, array: str, row: int, value: str) -> None:
        pointer = self.segments[-1].pointer(array, row, True)
        self.segments[-1].lines.append(f"store {self.values.name} {value}, ptr {pointer}, align 8")

    # ------------------------------------------------------------ values
    def _value(self, x: Value) -> str:
        if not isinstance(x, Symbol):
            return _constant(_bits(x), self.values)
        return self.names.get(x.id) or self._load(x)

    def _load(self, x: Symbol) -> str:
        if x.op == "input":
            array, row = x.args
        elif x.invariant and not self.preparing:
            array, row = "parameters", self.kernel.hoisted[x.id]
        else:
            array, row = "work", self.work.of[x.id]
        pointer = self.segments[-1].pointer(array, row, False)
        name = self.names[x.id] = f"%l{self.loads}"
        self.loads += 1
        self.segments[-1].lines.append(f"{name} = load {self.values.name}, ptr {pointer}, align 8")
        return name

    def _call(self, node: Symbol) -> None:
        """A function of another compiler, whose arguments and outputs are rows of lanes on the stack."""
        symbol, *given = node.args
        values, n, v = [self._value(x) for x in given], self.computed, self.values.name
        lines = self.segments[-1].lines
        lines.append(f"%given{n} = alloca [{len(given)} x {v}], align 8")
        lines.append(f"%found{n} = alloca [{KNOWN[symbol].outputs} x {v}], align 8")
        lines.append(f"%room{n} = alloca [2 x ptr], align 8")
        for row, x in enumerate(values):
            lines.append(f"%given{n}.{row} = getelementptr {v}, ptr %given{n}, i64 {row}")
            lines.append(f"store {v} {x}, ptr %given{n}.{row}, align 8")
        lines.append(f"%error{n} = getelementptr ptr, ptr %room{n}, i64 1")
        lines.append(f"store ptr null, ptr %error{n}, align 8")
        arguments = f"ptr %room{n}, ptr %error{n}, ptr %given{n}, ptr %found{n}, i64 {self.values.lanes}"
        lines.append(f"%status{n} = call i32 @{symbol}({arguments})")
        self.names[node.id] = f"%found{n}"
        self.computed += 1

    def _part(self, node: Symbol) -> None:
        """An output of a call, which is in the same segment."""
        (called, row), n, v = node.args, self.computed, self.values.name
        self.segments[-1].lines += [
            f"%place{n} = getelementptr {v}, ptr {self.names[called.id]}, i64 {row}",
            f"%v{n} = load {v}, ptr %place{n}, align 8",
        ]
        self.names[node.id] = f"%v{n}"
        self.computed += 1

    def _compute(self, node: Symbol) -> None:
        if node.op in ("call", "part"):
            return self._call(node) if node.op == "call" else self._part(node)
        known, v = self.names, self.values.name
        a = [
            known.get(x.id) or self._load(x) if x.__class__ is Symbol else _constant(_bits(x), self.values)
            for x in node.args
        ]
        number, lines = self.computed, self.segments[-1].lines
        if node.op in FUSED:
            if node.op != "fma":
                which = 2 if node.op == "fms" else 0
                lines.append(f"%n{number} = fneg {v} {a[which]}")
                a[which] = f"%n{number}"
            right = f"{self.values.fma}({v} {a[0]}, {v} {a[1]}, {v} {a[2]})"
        elif node.op in BINARY:
            right = f"{BINARY[node.op]} {v} {a[0]}, {a[1]}"
        elif node.op == "neg":
            right = f"fneg {v} {a[0]}"
        elif node.op == "sqrt":
            right = f"{self.values.sqrt}({v} {a[0]})"
        elif node.op == "where":
            right = f"select {self.values.mask} {self._condition(node, number)}, {v} {a[1]}, {v} {a[2]}"
        elif node.op in COMPARE:  # masks live as 0 or 1 beside ordinary values, so that they may cross a cut
            one, zero = self._value(1.0), self._value(0.0)
            self.masks[node.id] = f"%m{number}"
            lines.append(f"%m{number} = fcmp {COMPARE[node.op]} {v} {a[0]}, {a[1]}")
            right = f"select {self.values.mask} %m{number}, {v} {one}, {v} {zero}"
        elif node.op == "power_of_two":
            bias, shift = self._value(ROUND + 1023.0), self.values.constant("i64", "52")
            lines.append(f"%f{number} = fadd {v} {a[0]}, {bias}")
            lines.append(f"%b{number} = bitcast {v} %f{number} to {self.values.bits}")
            lines.append(f"%s{number} = shl {self.values.bits} %b{number}, {shift}")
            right = f"bitcast {self.values.bits} %s{number} to {v}"
        elif node.op == "gather":
            *before, right = self.values.gathered(number, *a)
            lines += before
        else:
            raise ValueError(f"no instruction for the operation {node.op!r}")
        lines.append(f"%v{number} = {right}")
        known[node.id] = f"%v{number}"
        self.computed += 1

    def _condition(self, node: Symbol, number: int) -> str:
        condition = node.args[0]
        if condition.id in self.masks:
            return self.masks[condition.id]
        name, zero = f"%c{number}", self._value(0.0)
        self.segments[-1].lines.append(f"{name} = fcmp une {self.values.name} {self._value(condition)}, {zero}")
        return name
