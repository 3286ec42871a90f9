"""A graph becomes LLVM text: one vector of W doubles per value, straight-line functions of bounded length.

Every kernel has the signature  void (state, parameters, clock, extra, out, work)  of pointers to rows of W doubles.
What depends on parameters alone is moved to a second function, `prepare`, which stores it behind the parameters.
LLVM slows down on one huge block, so a long graph is cut into functions of at most SEGMENT operations; values that
cross a cut travel through `work`. No instruction carries a fast-math flag.
"""

import struct
from dataclasses import dataclass, field
from typing import Any

from lienumba.compiler.symbols import Symbol, live, operation_counts

W = 8  # lanes: one AVX-512 register, two AVX2, four SSE2
SEGMENT = 300
ARRAYS = ("state", "parameters", "clock", "extra")
VECTOR = f"<{W} x double>"
MASK = f"<{W} x i1>"
BITS = f"<{W} x i64>"
SIGNATURE = ", ".join(f"ptr noalias readonly %{name}" for name in ARRAYS) + ", ptr noalias %out, ptr noalias %work"
ARGUMENTS = ", ".join(f"ptr %{name}" for name in (*ARRAYS, "out", "work"))
BINARY = {"+": "fadd", "-": "fsub", "*": "fmul", "/": "fdiv"}
COMPARE = {"<": "olt", "<=": "ole", "==": "oeq"}
DECLARATIONS = f"""
declare {VECTOR} @llvm.fma.v{W}f64({VECTOR}, {VECTOR}, {VECTOR})
declare {VECTOR} @llvm.sqrt.v{W}f64({VECTOR})
"""


@dataclass
class Kernel:
    """One compiled function.

    first_hoisted: the row behind the parameters where its invariants begin; rows: where in `out` each output goes, by
    default one after the other.
    """

    name: str
    outputs: tuple[Any, ...]
    first_hoisted: int
    rows: tuple[int, ...] | None = None
    order: list[Symbol] = field(init=False)
    hoisted: dict[int, int] = field(init=False)
    work_rows: int = field(init=False, default=0)

    def __post_init__(self) -> None:
        self.order = live(self.outputs)
        used: dict[int, int] = {}
        for read in (*(node.args for node in self.order if not node.invariant), self.outputs):
            for x in read:
                if isinstance(x, Symbol) and x.invariant and x.op != "input":
                    used.setdefault(x.id, self.first_hoisted + len(used))
        self.hoisted = used

    def counts(self) -> dict[str, int]:
        """Operations of one evaluation; invariants are not counted."""
        return operation_counts([n for n in self.order if not n.invariant])

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
        self.work_rows = max(writer.rows, preparer.rows)
        return DECLARATIONS + body + "\n" + prepare


def _hex(x: float) -> str:
    return f"0x{struct.unpack('<Q', struct.pack('<d', x))[0]:016X}"


def _cut(order: list[Symbol]) -> list[list[Symbol]]:
    """Segments of at most SEGMENT operations and loads of inputs."""
    segments: list[list[Symbol]] = [[]]
    size = 0
    for node in order:
        cost = 1 + sum(isinstance(x, Symbol) and x.op == "input" for x in node.args)
        if size + cost > SEGMENT and segments[-1]:
            segments.append([])
            size = 0
        size += cost
        segments[-1].append(node)
    return segments


class _Writer:
    """Writes one function as a row of segments. `rows`: of work that it needs."""

    def __init__(self, kernel: Kernel, preparing: bool = False) -> None:
        self.kernel, self.preparing, self.rows = kernel, preparing, 0
        self.lines: list[str] = []
        self.accesses: list[tuple[int, str, int]] = []  # line, array, row of every pointer of the segment
        self.loaded: dict[tuple[str, int], str] = {}
        self.here: set[int] = set()
        self.slots: dict[int, int] = {}  # work rows of the values that cross a cut
        self.free: list[int] = []

    def function(self, name: str, order: list[Symbol], stores: list[tuple[str, int, Any]]) -> str:
        """`stores`: (array, row, value) of everything the function leaves behind."""
        segments = _cut(order)
        last_use: dict[int, int] = {}
        for i, segment in enumerate(segments):
            last_use |= {x.id: i for node in segment for x in node.args if isinstance(x, Symbol)}
        computed = {node.id for node in order}
        stored: dict[int, list[tuple[str, int]]] = {}  # where a value goes when it has been computed
        late = []  # values that are not computed here
        for array, row, x in stores:
            if isinstance(x, Symbol) and x.id in computed:
                stored.setdefault(x.id, []).append((array, row))
            else:
                late.append((array, row, x))
        signature = SIGNATURE.replace("readonly %parameters", "%parameters") if self.preparing else SIGNATURE
        text, calls = [], []
        for i, segment in enumerate(segments):
            self.lines, self.accesses, self.loaded, self.here = [], [], {}, set()
            for node in segment:
                self._compute(node)
                for array, row in stored.get(node.id, ()):
                    self._store(array, row, f"%v{node.id}")
                if last_use.get(node.id, i) > i:
                    self._store("work", self._slot(node), f"%v{node.id}")
            if i + 1 == len(segments):
                for array, row, x in late:
                    self._store(array, row, self._value(x))
            calls += self._call(f"{name}.{i}", i)
            body = "\n".join(self.lines)
            text.append(f"define internal void @{name}.{i}({signature}) noinline nounwind {{\n{body}\nret void\n}}\n")
            for id_ in [id_ for id_ in self.slots if last_use[id_] <= i]:
                self.free.append(self.slots.pop(id_))
        text.append(f"define void @{name}({ARGUMENTS}) nounwind {{\n" + "\n".join(calls) + "\nret void\n}\n")
        return "\n".join(text)

    # ------------------------------------------------------------ rows of memory
    def _slot(self, node: Symbol) -> int:
        if not self.free:
            self.free.append(self.rows)
            self.rows += 1
        self.slots[node.id] = self.free.pop()
        return self.slots[node.id]

    def _pointer(self, array: str, row: int) -> str:
        self.accesses.append((len(self.lines), array, row))
        self.lines.append("")  # filled in by _call
        return f"%p{len(self.lines) - 1}"

    def _call(self, segment: str, number: int) -> list[str]:
        """The call of a segment. It gets its pointers in the middle of the rows that it uses, since instructions are
        shorter, and fetching them is what long kernels wait for, where an offset is within 127 rows."""
        middle = {}
        for array in (*ARRAYS, "out", "work"):
            rows = sorted(row for _, name, row in self.accesses if name == array)
            middle[array] = rows[len(rows) // 2] if rows else 0
        for line, array, row in self.accesses:
            self.lines[line] = f"%p{line} = getelementptr double, ptr %{array}, i64 {W * (row - middle[array])}"
        shifts = [f"%{a}.{number} = getelementptr double, ptr %{a}, i64 {W * row}" for a, row in middle.items()]
        return [*shifts, f"call void @{segment}({', '.join(f'ptr %{array}.{number}' for array in middle)})"]

    def _store(self, array: str, row: int, value: str) -> None:
        pointer = self._pointer(array, row)
        self.lines.append(f"store {VECTOR} {value}, ptr {pointer}, align 8")

    def _load(self, array: str, row: int) -> str:
        key = (array, row)
        if key not in self.loaded:
            pointer = self._pointer(array, row)
            self.loaded[key] = f"%l{len(self.lines)}"
            self.lines.append(f"{self.loaded[key]} = load {VECTOR}, ptr {pointer}, align 8")
        return self.loaded[key]

    # ------------------------------------------------------------ values
    def _value(self, x: Any) -> str:
        if not isinstance(x, Symbol):
            return f"<{', '.join([f'double {_hex(float(x))}'] * W)}>"
        if x.id in self.here:
            return f"%v{x.id}"
        if x.op == "input":
            return self._load(*x.args)
        if x.invariant and not self.preparing:
            return self._load("parameters", self.kernel.hoisted[x.id])
        return self._load("work", self.slots[x.id])

    def _compute(self, node: Symbol) -> None:
        a = [self._value(x) for x in node.args]
        if node.op in BINARY:
            right = f"{BINARY[node.op]} {VECTOR} {a[0]}, {a[1]}"
        elif node.op in ("fma", "fms", "fnma"):
            if node.op != "fma":
                which = 2 if node.op == "fms" else 0
                self.lines.append(f"%n{node.id} = fneg {VECTOR} {a[which]}")
                a[which] = f"%n{node.id}"
            right = f"call {VECTOR} @llvm.fma.v{W}f64({', '.join(f'{VECTOR} {v}' for v in a)})"
        elif node.op == "neg":
            right = f"fneg {VECTOR} {a[0]}"
        elif node.op == "sqrt":
            right = f"call {VECTOR} @llvm.sqrt.v{W}f64({VECTOR} {a[0]})"
        elif node.op == "where":
            right = f"select {MASK} {self._condition(node)}, {VECTOR} {a[1]}, {VECTOR} {a[2]}"
        elif node.op in COMPARE:  # masks live as 0 or 1 beside ordinary values, so that they may cross a cut
            one, zero = self._value(1.0), self._value(0.0)
            self.lines.append(f"%m{node.id} = fcmp {COMPARE[node.op]} {VECTOR} {a[0]}, {a[1]}")
            right = f"select {MASK} %m{node.id}, {VECTOR} {one}, {VECTOR} {zero}"
        elif node.op == "power_of_two":
            bias, shift = self._value(6755399441055744.0 + 1023.0), ", ".join(["i64 52"] * W)
            self.lines.append(f"%f{node.id} = fadd {VECTOR} {a[0]}, {bias}")
            self.lines.append(f"%b{node.id} = bitcast {VECTOR} %f{node.id} to {BITS}")
            self.lines.append(f"%s{node.id} = shl {BITS} %b{node.id}, <{shift}>")
            right = f"bitcast {BITS} %s{node.id} to {VECTOR}"
        else:
            raise ValueError(f"no instruction for the operation {node.op!r}")
        self.lines.append(f"%v{node.id} = {right}")
        self.here.add(node.id)

    def _condition(self, node: Symbol) -> str:
        condition = node.args[0]
        if condition.id in self.here and condition.op in COMPARE:
            return f"%m{condition.id}"
        name = f"%c{node.id}"
        self.lines.append(f"{name} = fcmp une {VECTOR} {self._value(condition)}, {self._value(0.0)}")
        return name
