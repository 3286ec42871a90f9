"""Arithmetic of scalars: whole numbers, floats, lanes. No instruction carries a fast-math flag."""

import ast
import struct

from lienumba.compiler.routines.values import BOOL, CALLED, FLOAT, INT, LANES, MASK, RoutineError, Scalar, Value, said
from lienumba.compiler.routines.writer import Writer
from lienumba.compiler.rows import W

ORDER = (INT, FLOAT, LANES)  # a number becomes one of the other's kind where that stands later
WHOLE: dict[type, str] = {ast.Add: "add", ast.Sub: "sub", ast.Mult: "mul"}
FLOATING: dict[type, str] = {ast.Add: "fadd", ast.Sub: "fsub", ast.Mult: "fmul", ast.Div: "fdiv"}
LOGICAL: dict[type, str] = {ast.BitAnd: "and", ast.BitOr: "or"}
COMPARE: dict[type, tuple[str, str]] = {
    ast.Lt: ("slt", "olt"), ast.LtE: ("sle", "ole"), ast.Gt: ("sgt", "ogt"), ast.GtE: ("sge", "oge"),
    ast.Eq: ("eq", "oeq"), ast.NotEq: ("ne", "une"),
}  # fmt: skip


def constant(x: bool | int | float) -> Scalar:
    """A number that is known."""
    if isinstance(x, bool):
        return Scalar(BOOL, "true" if x else "false")
    if isinstance(x, int):
        return Scalar(INT, str(x))
    return Scalar(FLOAT, f"0x{struct.unpack('<Q', struct.pack('<d', x))[0]:016X}")


def scalar(value: Value, *kinds: str) -> Scalar:
    """The value, if it is of one of these kinds."""
    kinds = kinds or (*ORDER, BOOL, MASK)
    if isinstance(value, Scalar) and value.kind in kinds:
        return value
    wanted = " or ".join(CALLED[kind] for kind in kinds)
    raise RoutineError(f"{said(value)} stands where there should be {wanted}")


def cast(writer: Writer, x: Scalar, kind: str) -> Scalar:
    """A number as one of another kind: a whole one as a float, a float in every lane."""
    if x.kind == kind:
        return x
    if kind == FLOAT and x.kind == INT:
        return constant(float(int(x.text))) if x.literal else writer.op(FLOAT, f"sitofp i64 {x.text} to double")
    if kind == INT and x.kind == FLOAT:
        return writer.op(INT, f"fptosi double {x.text} to i64")
    if kind == LANES and x.kind in ORDER:
        x = cast(writer, x, FLOAT)
        if x.literal:
            return Scalar(LANES, f"<{', '.join([f'double {x.text}'] * W)}>")
        first = writer.op(LANES, f"insertelement {LANES} poison, double {x.text}, i32 0")
        return writer.op(LANES, f"shufflevector {LANES} {first.text}, {LANES} poison, <{W} x i32> zeroinitializer")
    raise RoutineError(f"{said(x)} does not become {said(Scalar(kind, ''))}")


def alike(writer: Writer, *given: Scalar) -> tuple[str, list[Scalar]]:
    """Numbers as such of one kind, and that."""
    kind = max((scalar(x, *ORDER).kind for x in given), key=ORDER.index)
    return kind, [cast(writer, x, kind) for x in given]


def binary(writer: Writer, op: ast.operator, x: Scalar, y: Scalar) -> Scalar:
    """x op y."""
    how = type(op)
    if how in LOGICAL and x.kind == y.kind and x.kind in (BOOL, MASK):
        return writer.op(x.kind, f"{LOGICAL[how]} {x.kind} {x.text}, {y.text}")
    kind, (a, b) = alike(writer, x, y)
    if how in (ast.FloorDiv, ast.Mod) and kind == INT:
        return _rounded_down(writer, how, a, b)
    if how is ast.Div and kind == INT:
        kind, a, b = FLOAT, cast(writer, a, FLOAT), cast(writer, b, FLOAT)
    names = WHOLE if kind == INT else FLOATING
    if how not in names:
        raise RoutineError(f"there is no {how.__name__} of {said(x)} and {said(y)}")
    return writer.op(kind, f"{names[how]} {kind} {a.text}, {b.text}")


def _rounded_down(writer: Writer, how: type, x: Scalar, y: Scalar) -> Scalar:
    """The quotient of whole numbers or its remainder, as Python has them; by 0 they mean nothing."""
    quotient, rest = (writer.op(INT, f"{op} i64 {x.text}, {y.text}") for op in ("sdiv", "srem"))
    other = writer.op(INT, f"xor i64 {rest.text}, {y.text}")
    signs = writer.op(BOOL, f"icmp slt i64 {other.text}, 0")
    some = writer.op(BOOL, f"icmp ne i64 {rest.text}, 0")
    below = writer.op(BOOL, f"and i1 {signs.text}, {some.text}")
    if how is ast.Mod:
        return select(writer, below, writer.op(INT, f"add i64 {rest.text}, {y.text}"), rest)
    return select(writer, below, writer.op(INT, f"sub i64 {quotient.text}, 1"), quotient)


def compare(writer: Writer, op: ast.cmpop, x: Scalar, y: Scalar) -> Scalar:
    """x op y, a bool or a mask."""
    if type(op) not in COMPARE:
        raise RoutineError(f"there is no comparison {type(op).__name__}")
    kind, (a, b) = alike(writer, x, y)
    whole, floating = COMPARE[type(op)]
    how = f"icmp {whole}" if kind == INT else f"fcmp {floating}"
    return writer.op(MASK if kind == LANES else BOOL, f"{how} {kind} {a.text}, {b.text}")


def negative(writer: Writer, x: Scalar) -> Scalar:
    """-x."""
    if scalar(x, *ORDER).kind == INT:
        return constant(-int(x.text)) if x.literal else writer.op(INT, f"sub i64 0, {x.text}")
    return writer.op(x.kind, f"fneg {x.kind} {x.text}")


def select(writer: Writer, condition: Scalar, x: Scalar, y: Scalar) -> Scalar:
    """x where a bool or a mask holds, else y."""
    kind, (a, b) = alike(writer, x, y)
    if condition.kind == MASK:
        kind, a, b = LANES, cast(writer, a, LANES), cast(writer, b, LANES)
    text = f"select {condition.kind} {condition.text}, {kind} {a.text}, {kind} {b.text}"
    return writer.op(kind, text)
