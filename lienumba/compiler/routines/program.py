"""A routine with all that it calls as one module of LLVM text."""

import ast
import functools
import linecache
from collections.abc import Hashable, Sequence
from types import FunctionType
from typing import Annotated, Any, get_args, get_origin, get_type_hints

from lienumba.compiler.routines.arithmetic import constant
from lienumba.compiler.routines.intrinsics import DECLARATIONS
from lienumba.compiler.routines.marks import ATTRIBUTES, ENTRY, Numbers
from lienumba.compiler.routines.statements import Body, aggregate
from lienumba.compiler.routines.values import (
    FLOAT,
    INT,
    Array,
    RoutineError,
    Scalar,
    Tuple,
    Value,
    kind_of,
    leaves,
    with_leaves,
)  # fmt: skip
from lienumba.compiler.routines.writer import Writer
from lienumba.compiler.rows import ROW

# No loop becomes a call of the C library, for which `native.load` leaves no room; no row straddles a cache line.
PLAIN = f'"no-builtins" alignstack({ROW})'


class Module:
    """Functions so far, by what they are and what kinds of arguments they get."""

    def __init__(self) -> None:
        self.texts: list[str] = [DECLARATIONS]
        self._known: dict[Hashable, tuple[str, Value]] = {}

    def call(self, writer: Writer, function: FunctionType, arguments: Sequence[Value]) -> Value:
        """Write the call of a routine, and the routine itself where it is not yet there."""
        key = function, tuple(map(kind_of, arguments))
        if key not in self._known:
            self._known[key] = self._compile(function, arguments, f"f{len(self._known)}")
        name, result = self._known[key]
        given = [leaf for x in arguments for leaf in leaves(x)]
        kinds = leaves(result)
        call = f"call {aggregate(kinds)} @{name}({', '.join(f'{x.kind} {x.text}' for x in given)})"
        if not kinds:
            writer.do(call)
            return result
        whole = writer.op(aggregate(kinds), call)
        if len(kinds) == 1:
            return with_leaves(result, iter([whole.text]))
        parts = [
            writer.op(x.kind, f"extractvalue {whole.kind} {whole.text}, {n}").text for n, x in enumerate(kinds)
        ]  # fmt: skip
        return with_leaves(result, iter(parts))

    def _compile(self, function: FunctionType, arguments: Sequence[Value], name: str) -> tuple[str, Value]:
        self._known[function, tuple(map(kind_of, arguments))] = name, Tuple(None, ())  # no routine calls itself
        registers = [leaf for x in arguments for leaf in leaves(x)]
        names = iter([f"%a{n}" for n in range(len(registers))])
        inside = [with_leaves(x, names) for x in arguments]
        body = Body(function, tree_of(function), self.call, inside)
        assert body.result is not None
        heads = ", ".join(f"{x.kind} %a{n}" for n, x in enumerate(registers))
        attribute = ATTRIBUTES.get(function, "")
        kind = aggregate(leaves(body.result))
        self.texts.append(body.writer.text(f"define internal {kind} @{name}({heads}) {attribute} {PLAIN}"))
        return name, body.result


def text_of(function: FunctionType) -> tuple[str, str]:
    """The kinds of the arguments of a routine (see `flat`), and the LLVM text of ENTRY, which hands them on."""
    module, writer, reader = Module(), Writer(), _Reader()
    hints = get_type_hints(function, include_extras=True)
    hints.pop("return", None)
    arguments = [reader.next(writer, hint) for hint in hints.values()]
    module.call(writer, function, arguments)
    writer.do("ret void")
    module.texts.append(writer.text(f"define void @{ENTRY}(ptr %whole, ptr %floats) {PLAIN}"))
    return reader.kinds, "\n".join(module.texts)


class _Reader:
    """Reads arguments that `flat` has packed, one after the other."""

    def __init__(self) -> None:
        self.kinds = ""
        self._read = {INT: 0, FLOAT: 0}

    def next(self, writer: Writer, hint: Any) -> Value:
        """The argument of this annotation."""
        if get_origin(hint) is Annotated:
            (numbers,) = (x for x in get_args(hint) if isinstance(x, Numbers))
            self.kinds += f"{'I' if numbers.whole else 'F'}{numbers.dimensions}"
            address, *shape = (self._number(writer, INT) for _ in range(1 + numbers.dimensions))
            return Array(INT if numbers.whole else FLOAT, address, tuple(shape))
        if hasattr(hint, "_fields"):
            fields = get_type_hints(hint, include_extras=True)
            return Tuple(hint, tuple(self.next(writer, fields[name]) for name in hint._fields))
        if hint in (int, float):
            self.kinds += "i" if hint is int else "f"
            return self._number(writer, INT if hint is int else FLOAT)
        raise RoutineError(f"an argument from outside is not {hint}")

    def _number(self, writer: Writer, kind: str) -> Scalar:
        place = constant(self._read[kind])
        self._read[kind] += 1
        base = "%whole" if kind == INT else "%floats"
        return writer.get(writer.op("ptr", f"getelementptr {kind}, ptr {base}, i64 {place.text}").text, kind)


def tree_of(function: FunctionType) -> ast.FunctionDef:
    """The source of a function as it was read."""
    code = function.__code__
    try:
        return _functions(code.co_filename)[code.co_firstlineno, code.co_name]
    except KeyError:
        raise RoutineError(f"{code.co_filename} has no function {code.co_name} in line {code.co_firstlineno}") from None


@functools.cache
def _functions(file: str) -> dict[tuple[int, str], ast.FunctionDef]:
    tree = ast.parse("".join(linecache.getlines(file)))
    found = [node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)]
    return {(min([node.lineno, *(x.lineno for x in node.decorator_list)]), node.name): node for node in found}
