"""Expressions of routines."""

import ast
import builtins
from collections.abc import Callable, Sequence
from types import FunctionType, ModuleType
from typing import Any

from lienumba.compiler.routines.arithmetic import binary, cast, compare, constant, negative, scalar
from lienumba.compiler.routines.intrinsics import INTRINSICS
from lienumba.compiler.routines.values import (
    BOOL,
    INT,
    NOTHING,
    Array,
    Known,
    RoutineError,
    Scalar,
    Tuple,
    Value,
    kind_of,
    leaves,
    said,
    with_leaves,
)  # fmt: skip
from lienumba.compiler.routines.writer import Writer

Caller = Callable[[Writer, FunctionType, Sequence[Value]], Value]  # writes the call of another routine


class Expressions:
    """names: what is known of them, in slots where they can change."""

    def __init__(self, function: FunctionType, call: Caller) -> None:
        self.writer, self.globals, self.call = Writer(), function.__globals__, call
        self.fixed: dict[str, Value] = {}
        self.slots: dict[str, tuple[Value, list[str]]] = {}

    def value(self, node: ast.expr) -> Value:
        """What an expression gives."""
        how = getattr(self, f"_{type(node).__name__.lower()}", None)
        if how is None:
            raise RoutineError(f"routines know no {type(node).__name__}")
        found: Value = how(node)
        return found

    def number(self, node: ast.expr, *kinds: str) -> Scalar:
        """The one number that an expression gives."""
        return scalar(self.value(node), *kinds)

    def _constant(self, node: ast.Constant) -> Value:
        if not isinstance(node.value, bool | int | float):
            raise RoutineError(f"{node.value!r} is no number")
        return constant(node.value)

    def _name(self, node: ast.Name) -> Value:
        name = node.id
        if name in self.slots:
            like, slots = self.slots[name]
            read = [self.writer.get(slot, x.kind).text for slot, x in zip(slots, leaves(like), strict=True)]
            return with_leaves(like, iter(read))
        if name in self.fixed:
            return self.fixed[name]
        if name in self.globals:
            return known(self.globals[name])
        if hasattr(builtins, name):
            return known(getattr(builtins, name))
        raise RoutineError(f"{name} has no value here")

    def _attribute(self, node: ast.Attribute) -> Value:
        of, name = self.value(node.value), node.attr
        if isinstance(of, Known) and isinstance(of.thing, ModuleType) and hasattr(of.thing, name):
            return known(getattr(of.thing, name))
        if isinstance(of, Array) and name == "shape":
            return Tuple(None, of.shape)
        if isinstance(of, Array) and name == "size":
            return self._product(of.shape)
        if isinstance(of, Array) and name == "ctypes":
            return Tuple(None, (of.address,))
        if isinstance(of, Tuple) and of.of is None and name == "data" and len(of.items) == 1:
            return of.items[0]
        if isinstance(of, Tuple) and of.of is not None and name in of.of._fields:  # type: ignore[attr-defined]
            return of.items[of.of._fields.index(name)]  # type: ignore[attr-defined]
        raise RoutineError(f"{said(of)} has no {name}")

    def _product(self, factors: Sequence[Scalar]) -> Scalar:
        product = factors[0]
        for factor in factors[1:]:
            product = binary(self.writer, ast.Mult(), product, factor)
        return product

    def _tuple(self, node: ast.Tuple) -> Value:
        return Tuple(None, tuple(map(self.value, node.elts)))

    def _binop(self, node: ast.BinOp) -> Value:
        return binary(self.writer, node.op, self.number(node.left), self.number(node.right))

    def _unaryop(self, node: ast.UnaryOp) -> Value:
        x = self.number(node.operand)
        if isinstance(node.op, ast.USub):
            return negative(self.writer, x)
        if isinstance(node.op, ast.Not):
            return self.writer.op(BOOL, f"xor i1 {scalar(x, BOOL).text}, true")
        raise RoutineError(f"routines know no {type(node.op).__name__}")

    def _compare(self, node: ast.Compare) -> Value:
        left, every = self.number(node.left), None
        for op, right in zip(node.ops, map(self.number, node.comparators), strict=True):
            holds, left = compare(self.writer, op, left, right), right
            every = holds if every is None else binary(self.writer, ast.BitAnd(), every, holds)
        assert every is not None
        return every

    def _boolop(self, node: ast.BoolOp) -> Value:
        """Those behind are not evaluated where one decides."""
        decided, end = self.writer.slot(BOOL), self.writer.label()
        for n, part in enumerate(node.values):
            x = self.number(part, BOOL)
            self.writer.put(decided, x)
            if n + 1 < len(node.values):
                more = self.writer.label()
                ways = (more, end) if isinstance(node.op, ast.And) else (end, more)
                self.writer.branch(x, *ways)
                self.writer.begin(more)
        self.writer.begin(end)
        return self.writer.get(decided, BOOL)

    def _ifexp(self, node: ast.IfExp) -> Value:
        yes, no, end = (self.writer.label() for _ in range(3))
        self.writer.branch(self.number(node.test, BOOL), yes, no)
        self.writer.begin(yes)
        x = self.value(node.body)
        slots = [self.writer.slot(leaf.kind) for leaf in leaves(x)]
        self._put(slots, x)
        self.writer.jump(end)
        self.writer.begin(no)
        y = self.value(node.orelse)
        if kind_of(x) != kind_of(y):
            if not (isinstance(x, Scalar) and isinstance(y, Scalar)):
                raise RoutineError(f"either {said(x)} or {said(y)}")
            y = cast(self.writer, y, x.kind)
        self._put(slots, y)
        self.writer.begin(end)
        read = [self.writer.get(slot, leaf.kind).text for slot, leaf in zip(slots, leaves(x), strict=True)]
        return with_leaves(x, iter(read))

    def _put(self, slots: Sequence[str], x: Value) -> None:
        for slot, leaf in zip(slots, leaves(x), strict=True):
            self.writer.put(slot, leaf)

    def _subscript(self, node: ast.Subscript) -> Value:
        of = self.value(node.value)
        if isinstance(of, Tuple):
            place = self.number(node.slice, INT)
            if place.literal and 0 <= int(place.text) < len(of.items):
                return of.items[int(place.text)]
            raise RoutineError("a part of a tuple is asked for by a number that is known and within it")
        if not isinstance(of, Array):
            raise RoutineError(f"{said(of)} has no parts")
        part = self.part(of, node.slice)
        if part.shape:
            return part
        return self.writer.get(self.pointer(part), part.kind)

    def pointer(self, element: Array) -> str:
        """Where an element lies."""
        return self.writer.op("ptr", f"inttoptr i64 {element.address.text} to ptr").text

    def part(self, of: Array, index: ast.expr) -> Array:
        """The part of an array at an index: whole numbers from 0 on, or first a slice."""
        indices = index.elts if isinstance(index, ast.Tuple) else [index]
        if len(indices) > len(of.shape):
            raise RoutineError(f"{said(of)} has no {len(indices)}")
        if isinstance(indices[0], ast.Slice):
            return self._slice(of, indices)
        offset, shape = constant(0), of.shape
        for given in indices:
            n = self.number(given, INT)
            if n.literal and int(n.text) < 0:
                raise RoutineError("indices of routines count from the front")
            stride, shape = self._product((constant(1), *shape[1:])), shape[1:]
            offset = binary(self.writer, ast.Add(), offset, binary(self.writer, ast.Mult(), n, stride))
        return Array(of.kind, self._behind(of.address, offset), shape)

    def _slice(self, of: Array, indices: Sequence[ast.expr]) -> Array:
        cut = indices[0]
        assert isinstance(cut, ast.Slice)
        if len(indices) > 1 or cut.step is not None:
            raise RoutineError("a slice is the only index, and has no step")
        low = constant(0) if cut.lower is None else self.number(cut.lower, INT)
        high = of.shape[0] if cut.upper is None else self.number(cut.upper, INT)
        offset = binary(self.writer, ast.Mult(), low, self._product((constant(1), *of.shape[1:])))
        length = binary(self.writer, ast.Sub(), high, low)
        return Array(of.kind, self._behind(of.address, offset), (length, *of.shape[1:]))

    def _behind(self, address: Scalar, numbers: Scalar) -> Scalar:
        return binary(self.writer, ast.Add(), address, binary(self.writer, ast.Mult(), numbers, constant(8)))

    def _call(self, node: ast.Call) -> Value:
        if node.keywords:
            raise RoutineError("routines take no arguments by name")
        called, given = self.value(node.func), [self.value(x) for x in node.args]
        thing = called.thing if isinstance(called, Known) else None
        if lowering := INTRINSICS.get(thing):
            return lowering(self.writer, *given)
        if isinstance(thing, type) and hasattr(thing, "_fields"):
            defaults = [known(thing._field_defaults[name]) for name in thing._fields[len(given) :]]  # type: ignore[attr-defined]
            return Tuple(thing, (*given, *defaults))
        if isinstance(thing, FunctionType):
            return self.call(self.writer, thing, given)
        raise RoutineError(f"{said(called)} cannot be called")


def known(thing: Any) -> Value:
    """What a thing of Python's is in a routine."""
    if thing is None:
        return NOTHING
    return constant(thing) if isinstance(thing, bool | int | float) else Known(thing)
