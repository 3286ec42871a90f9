"""What routines may call that is not written as a routine: lanes and their memory, and a little of Python and NumPy."""

from collections.abc import Callable
from typing import Any

import numpy as np

from lienumba.compiler import lanes
from lienumba.compiler.routines.arithmetic import ORDER, alike, cast, scalar, select
from lienumba.compiler.routines.values import BOOL, FLOAT, INT, LANES, MASK, NOTHING, Array, Scalar, Value
from lienumba.compiler.routines.writer import Writer
from lienumba.compiler.rows import ROW, W
from lienumba.numerics import operations

Lowering = Callable[..., Value]
DECLARATIONS = f"""
declare double @llvm.sqrt.f64(double)
declare {LANES} @llvm.sqrt.v{W}f64({LANES})
declare {LANES} @llvm.fma.v{W}f64({LANES}, {LANES}, {LANES})
"""


def _splat(writer: Writer, x: Value) -> Scalar:
    return cast(writer, scalar(x, INT, FLOAT), LANES)


def _choose(writer: Writer, mask: Value, x: Value, y: Value) -> Scalar:
    return select(writer, scalar(mask, MASK), scalar(x), scalar(y))


def _where(writer: Writer, condition: Value, x: Value, y: Value) -> Scalar:
    return select(writer, scalar(condition, BOOL, MASK), scalar(x), scalar(y))


def _bits(writer: Writer, mask: Value, how: str, bits: int) -> Scalar:
    number = writer.op(f"i{W}", f"bitcast {MASK} {scalar(mask, MASK).text} to i{W}")
    return writer.op(BOOL, f"icmp {how} i{W} {number.text}, {bits}")


def _row(writer: Writer, base: Value, row: Value) -> str:
    pointer = writer.op("ptr", f"inttoptr i64 {scalar(base, INT).text} to ptr")
    return writer.op("ptr", f"getelementptr [{ROW} x i8], ptr {pointer.text}, i64 {scalar(row, INT).text}").text


def _load(writer: Writer, base: Value, row: Value) -> Scalar:
    return writer.get(_row(writer, base, row), LANES)


def _store(writer: Writer, base: Value, row: Value, value: Value) -> Value:
    whole = writer.op(LANES, f"freeze {LANES} {scalar(value, LANES).text}")  # no store by a mask: slow
    writer.put(_row(writer, base, row), whole)
    return NOTHING


def _call(writer: Writer, address: Value, *arguments: Value) -> Value:
    pointer = writer.op("ptr", f"inttoptr i64 {scalar(address, INT).text} to ptr")
    given = ", ".join(f"i64 {scalar(x, INT).text}" for x in arguments)
    writer.do(f"call void {pointer.text}({given})")
    return NOTHING


def _matrix(writer: Writer, address: Value, rows: Value, columns: Value) -> Array:
    return Array(FLOAT, scalar(address, INT), (scalar(rows, INT), scalar(columns, INT)))


def _sqrt(writer: Writer, x: Value) -> Scalar:
    given = scalar(x, *ORDER)
    y = cast(writer, given, LANES if given.kind == LANES else FLOAT)
    return writer.op(y.kind, f"call {y.kind} @llvm.sqrt.{f'v{W}f64' if y.kind == LANES else 'f64'}({y.kind} {y.text})")


def _fma(writer: Writer, *given: Value) -> Scalar:
    arguments = ", ".join(f"{LANES} {cast(writer, scalar(x, *ORDER), LANES).text}" for x in given)
    return writer.op(LANES, f"call {LANES} @llvm.fma.v{W}f64({arguments})")


def _extreme(how: tuple[str, str]) -> Lowering:
    """min or max of two, as Python has it: the first one unless the second is beyond it."""

    def lowering(writer: Writer, x: Value, y: Value) -> Scalar:
        kind, (a, b) = alike(writer, scalar(x, INT, FLOAT), scalar(y, INT, FLOAT))
        text = f"icmp {how[0]} i64" if kind == INT else f"fcmp {how[1]} double"
        return select(writer, writer.op(BOOL, f"{text} {b.text}, {a.text}"), b, a)

    return lowering


INTRINSICS: dict[Any, Lowering] = {
    lanes.splat: _splat,
    lanes.choose: _choose,
    lanes.fma: _fma,
    lanes.any_lane: lambda writer, mask: _bits(writer, mask, "ne", 0),
    lanes.all_lanes: lambda writer, mask: _bits(writer, mask, "eq", -1),
    lanes.load: _load,
    lanes.store: _store,
    lanes.call: _call,
    lanes.matrix: _matrix,
    operations.where: _where,
    operations.sqrt: _sqrt,
    np.sqrt: _sqrt,
    min: _extreme(("slt", "olt")),
    max: _extreme(("sgt", "ogt")),
    float: lambda writer, x: cast(writer, scalar(x, INT, FLOAT), FLOAT),
    int: lambda writer, x: cast(writer, scalar(x, INT, FLOAT), INT),
}
