"""Lanes: a Numba type whose values are LLVM vectors of W doubles, one lane per run; and masks of W bits.

Under `@njit`, lanes know `+ - * /`, negation, comparisons, `where`, `sqrt`, `fma`, and through the kernels of
`lienumba.numerics.vector_math` sin, cos, exp and atan2. Nothing is ever contracted or reassociated.
"""

import operator
from collections.abc import Callable, Sequence
from typing import Any

from llvmlite import ir
from numba.core import cgutils, types
from numba.core.base import BaseContext
from numba.core.datamodel import DataModelManager
from numba.core.imputils import lower_builtin
from numba.core.types import BaseTuple  # type: ignore[attr-defined]
from numba.core.typing import BaseContext as TypingContext
from numba.core.typing.templates import AbstractTemplate, Signature, infer_global, signature
from numba.extending import intrinsic, models, register_model
from numba.np.arrayobj import populate_array

from lienumba.compiler.rows import ROW, W
from lienumba.numerics.vector_math import ROUND

DOUBLE = ir.DoubleType()
VECTOR = ir.VectorType(DOUBLE, W)
BITS = ir.VectorType(ir.IntType(1), W)
INT32, INT64 = ir.IntType(32), ir.IntType(64)


class Lanes(types.Type):
    def __init__(self) -> None:
        super().__init__(f"float64x{W}")


class Mask(types.Type):
    def __init__(self) -> None:
        super().__init__(f"boolean{W}")


lanes, mask = Lanes(), Mask()


@register_model(Lanes)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, dmm: DataModelManager, fe_type: types.Type) -> None:
        super().__init__(dmm, fe_type, VECTOR)


@register_model(Mask)
class _MaskModel(models.PrimitiveModel):
    def __init__(self, dmm: DataModelManager, fe_type: types.Type) -> None:
        super().__init__(dmm, fe_type, BITS)


def broadcast(builder: ir.IRBuilder, scalar: ir.Value) -> Any:
    """A scalar in every lane."""
    vector = ir.VectorType(scalar.type, W)
    undefined = ir.Constant(vector, ir.Undefined)
    first = builder.insert_element(undefined, scalar, ir.Constant(INT32, 0))
    return builder.shuffle_vector(first, undefined, ir.Constant(ir.VectorType(INT32, W), [0] * W))


def as_vectors(
    context: BaseContext, builder: ir.IRBuilder, given: tuple[types.Type, ...], args: tuple[ir.Value, ...]
) -> list[Any]:
    """Each argument as a vector of doubles; plain numbers are broadcast."""
    return [
        value if kind == lanes else broadcast(builder, context.cast(builder, value, kind, types.float64))
        for value, kind in zip(args, given, strict=True)
    ]


def are_numbers(args: tuple[types.Type, ...], count: int) -> bool:
    """Whether these are `count` lanes or plain numbers, at least one of them lanes."""
    return len(args) == count and lanes in args and all(a == lanes or isinstance(a, types.Number) for a in args)


def _binary(op: Callable[..., object], result: types.Type, emit: Callable[..., ir.Value]) -> None:
    @infer_global(op)
    class _Typing(AbstractTemplate):
        def generic(self, args: tuple[types.Type, ...], kws: dict[str, types.Type]) -> Any:
            if are_numbers(args, 2):
                return signature(result, *(a if a == lanes else types.float64 for a in args))

    def lower(context: BaseContext, builder: ir.IRBuilder, sig: Signature, args: tuple[ir.Value, ...]) -> Any:
        return emit(builder, *as_vectors(context, builder, sig.args, args))

    for pair in ((lanes, lanes), (lanes, types.float64), (types.float64, lanes)):
        lower_builtin(op, *pair)(lower)


for _names, _emit in (
    (("add", "iadd"), lambda b, x, y: b.fadd(x, y)),
    (("sub", "isub"), lambda b, x, y: b.fsub(x, y)),
    (("mul", "imul"), lambda b, x, y: b.fmul(x, y)),
    (("truediv", "itruediv"), lambda b, x, y: b.fdiv(x, y)),
):
    for _name in _names:
        _binary(getattr(operator, _name), lanes, _emit)
_binary(operator.lt, mask, lambda b, x, y: b.fcmp_ordered("<", x, y))
_binary(operator.le, mask, lambda b, x, y: b.fcmp_ordered("<=", x, y))
_binary(operator.gt, mask, lambda b, x, y: b.fcmp_ordered(">", x, y))
_binary(operator.ge, mask, lambda b, x, y: b.fcmp_ordered(">=", x, y))
_binary(operator.eq, mask, lambda b, x, y: b.fcmp_ordered("==", x, y))
_binary(operator.ne, mask, lambda b, x, y: b.fcmp_unordered("!=", x, y))


def _of_masks(op: Callable[..., object], emit: Callable[..., ir.Value]) -> None:
    @infer_global(op)
    class _Typing(AbstractTemplate):
        def generic(self, args: tuple[types.Type, ...], kws: dict[str, types.Type]) -> Any:
            if args == (mask, mask):
                return signature(mask, mask, mask)

    lower_builtin(op, mask, mask)(lambda context, builder, sig, args: emit(builder, *args))


_of_masks(operator.and_, lambda b, x, y: b.and_(x, y))
_of_masks(operator.or_, lambda b, x, y: b.or_(x, y))


@infer_global(operator.neg)
class _Negation(AbstractTemplate):
    def generic(self, args: tuple[types.Type, ...], kws: dict[str, types.Type]) -> Any:
        if args == (lanes,):
            return signature(lanes, lanes)


@lower_builtin(operator.neg, lanes)
def _lower_negation(context: BaseContext, builder: ir.IRBuilder, sig: Signature, args: tuple[ir.Value, ...]) -> Any:
    return builder.fneg(args[0])


def _llvm(builder: ir.IRBuilder, name: str, *args: ir.Value) -> Any:
    kind = ir.FunctionType(VECTOR, [VECTOR] * len(args))
    function = cgutils.get_or_insert_function(builder.module, kind, f"llvm.{name}.v{W}f64")
    return builder.call(function, args)


@intrinsic
def splat(typing: TypingContext, x: types.Type) -> Any:
    """A float in every lane."""
    return lanes(types.float64), lambda context, builder, sig, args: broadcast(builder, args[0])


@intrinsic
def sqrt(typing: TypingContext, x: types.Type) -> Any:
    if x == lanes:
        return lanes(lanes), lambda context, builder, sig, args: _llvm(builder, "sqrt", *args)


@intrinsic
def fma(typing: TypingContext, a: types.Type, b: types.Type, c: types.Type) -> Any:
    """a b + c, rounded once."""
    if are_numbers((a, b, c), 3):
        given = [x if x == lanes else types.float64 for x in (a, b, c)]

        def codegen(context: BaseContext, builder: ir.IRBuilder, sig: Signature, args: tuple[ir.Value, ...]) -> Any:
            return _llvm(builder, "fma", *as_vectors(context, builder, sig.args, args))

        return lanes(*given), codegen


@intrinsic
def choose(typing: TypingContext, condition: types.Type, x: types.Type, y: types.Type) -> Any:
    """x in the lanes where the mask holds, else y."""
    if condition == mask and all(a == lanes or isinstance(a, types.Number) for a in (x, y)):
        given = [a if a == lanes else types.float64 for a in (x, y)]

        def codegen(context: BaseContext, builder: ir.IRBuilder, sig: Signature, args: tuple[ir.Value, ...]) -> Any:
            return builder.select(args[0], *as_vectors(context, builder, sig.args[1:], args[1:]))

        return lanes(mask, *given), codegen


def _bits_compare(builder: ir.IRBuilder, how: str, condition: ir.Value, bits: int) -> Any:
    number = ir.IntType(W)
    return builder.icmp_unsigned(how, builder.bitcast(condition, number), ir.Constant(number, bits))


@intrinsic
def any_lane(typing: TypingContext, condition: types.Type) -> Any:
    """Whether the mask holds in some lane."""
    if condition == mask:
        return types.boolean(mask), lambda context, builder, sig, args: _bits_compare(builder, "!=", args[0], 0)


@intrinsic
def all_lanes(typing: TypingContext, condition: types.Type) -> Any:
    """Whether the mask holds in every lane."""
    if condition == mask:
        return types.boolean(mask), lambda context, builder, sig, args: _bits_compare(builder, "==", args[0], 2**W - 1)


@intrinsic
def power_of_two(typing: TypingContext, n: types.Type) -> Any:
    """2**n for an integral n in [-1022, 1023]."""
    if n == lanes:
        integers = ir.VectorType(INT64, W)

        def codegen(context: BaseContext, builder: ir.IRBuilder, sig: Signature, args: tuple[ir.Value, ...]) -> Any:
            biased = builder.fadd(args[0], ir.Constant(VECTOR, [ROUND + 1023.0] * W))
            shifted = builder.shl(builder.bitcast(biased, integers), ir.Constant(integers, [52] * W))
            return builder.bitcast(shifted, VECTOR)

        return lanes(lanes), codegen


def _row(builder: ir.IRBuilder, base: ir.Value, row: ir.Value) -> Any:
    address = builder.add(base, builder.mul(row, ir.Constant(INT64, ROW)))
    return builder.inttoptr(address, VECTOR.as_pointer())


@intrinsic
def load(typing: TypingContext, base: types.Type, row: types.Type) -> Any:
    """The W doubles of a row of the flat array at address `base`."""

    def codegen(context: BaseContext, builder: ir.IRBuilder, sig: Signature, args: tuple[ir.Value, ...]) -> Any:
        value = builder.load(_row(builder, *args), typ=VECTOR)
        value.align = 8
        return value

    return lanes(types.int64, types.int64), codegen


@intrinsic
def store(typing: TypingContext, base: types.Type, row: types.Type, value: types.Type) -> Any:
    def codegen(context: BaseContext, builder: ir.IRBuilder, sig: Signature, args: tuple[ir.Value, ...]) -> Any:
        builder.store(args[2], _row(builder, *args[:2])).align = 8
        return context.get_dummy_value()

    return types.void(types.int64, types.int64, lanes), codegen


@intrinsic
def call(
    typing: TypingContext,
    address: types.Type,
    state: types.Type,
    parameters: types.Type,
    clock: types.Type,
    extra: types.Type,
    out: types.Type,
    work: types.Type,
) -> Any:
    """Call the kernel at `address` (see `lienumba.compiler.emit`) with six addresses."""

    def codegen(context: BaseContext, builder: ir.IRBuilder, sig: Signature, args: tuple[ir.Value, ...]) -> Any:
        kind = ir.FunctionType(ir.VoidType(), [INT64] * 6)
        builder.call(builder.inttoptr(args[0], kind.as_pointer()), args[1:])
        return context.get_dummy_value()

    return types.void(*[types.int64] * 7), codegen


@intrinsic
def matrix(typing: TypingContext, address: types.Type, rows: types.Type, columns: types.Type) -> Any:
    """The doubles at an address as an array (rows, columns)."""
    kind = types.Array(types.float64, 2, "C")

    def codegen(context: BaseContext, builder: ir.IRBuilder, sig: Signature, args: tuple[ir.Value, ...]) -> Any:
        return _array(context, builder, kind, args[0], args[1:])

    return kind(*[types.int64] * 3), codegen


def _array(
    context: BaseContext, builder: ir.IRBuilder, kind: types.Array, address: ir.Value, shape: Sequence[ir.Value]
) -> Any:
    """An array of numbers of eight bytes, side by side."""
    array = context.make_array(kind)(context, builder)
    size = ir.Constant(INT64, 8)
    strides = [size]
    for n in reversed(shape[1:]):
        strides.insert(0, builder.mul(strides[0], n))
    populate_array(array, builder.inttoptr(address, array.data.type), list(shape), strides, size, None)
    return array._getvalue()


def words(kind: types.Type) -> str:
    """The kind of an argument as `lienumba.compiler.flat` says it."""
    if isinstance(kind, BaseTuple):
        return "".join(map(words, kind))
    if isinstance(kind, types.Array):
        return f"{'I' if kind.dtype == types.int64 else 'F'}{kind.ndim}"
    return "i" if kind == types.int64 else "f"


class Reader:
    """Reads the arguments that `lienumba.compiler.flat` has packed, one after the other."""

    def __init__(self, context: BaseContext, builder: ir.IRBuilder, given: ir.Value, numbers: ir.Value) -> None:
        self.context, self.builder = context, builder
        self.given, self.numbers, self.read = given, numbers, {INT64: 0, DOUBLE: 0}

    def _next(self, kind: ir.Type) -> Any:
        place = ir.Constant(INT64, self.read[kind])
        self.read[kind] += 1
        base = self.given if kind == INT64 else self.numbers
        return self.builder.load(self.builder.gep(base, [place]))

    def next(self, kind: types.Type) -> Any:
        if isinstance(kind, BaseTuple):
            return self.context.make_tuple(self.builder, kind, [self.next(part) for part in kind])
        if isinstance(kind, types.Array):
            address = self._next(INT64)
            shape = [self._next(INT64) for _ in range(kind.ndim)]
            return _array(self.context, self.builder, kind, address, shape)
        return self._next(INT64 if kind == types.int64 else DOUBLE)
