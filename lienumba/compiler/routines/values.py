"""What a name can stand for in a routine: one register, an array, a tuple of values, or something known beforehand."""

from collections.abc import Hashable, Iterator
from dataclasses import dataclass
from typing import Any

from lienumba.compiler.rows import W

INT, FLOAT, BOOL = "i64", "double", "i1"
LANES, MASK = f"<{W} x double>", f"<{W} x i1>"
CALLED = {INT: "a whole number", FLOAT: "a float", BOOL: "a bool", LANES: "lanes", MASK: "a mask"}


class RoutineError(TypeError):
    """Something that is not of the language of routines. placed: whether its line is told."""

    placed = False


@dataclass(frozen=True)
class Scalar:
    """kind: its LLVM type; text: its register, or a literal."""

    kind: str
    text: str

    @property
    def literal(self) -> bool:
        return not self.text.startswith("%")


@dataclass(frozen=True)
class Array:
    """Numbers of eight bytes, side by side, the last index fastest."""

    kind: str
    address: Scalar
    shape: tuple[Scalar, ...]


@dataclass(frozen=True)
class Tuple:
    """of: the class of a named one."""

    of: type | None
    items: "tuple[Value, ...]"


@dataclass(frozen=True)
class Known:
    """A module, a function, a class: a thing of Python's."""

    thing: Any


Value = Scalar | Array | Tuple | Known
NOTHING = Tuple(None, ())


def leaves(value: Value) -> list[Scalar]:
    """The registers of a value, in order."""
    if isinstance(value, Scalar):
        return [value]
    if isinstance(value, Array):
        return [value.address, *value.shape]
    if isinstance(value, Tuple):
        return [leaf for item in value.items for leaf in leaves(item)]
    raise RoutineError(f"{value.thing!r} is no number")


def with_leaves(value: Value, given: Iterator[str]) -> Value:
    """A value like this one in other registers."""
    if isinstance(value, Scalar):
        return Scalar(value.kind, next(given))
    if isinstance(value, Array):
        return Array(value.kind, Scalar(INT, next(given)), tuple(Scalar(INT, next(given)) for _ in value.shape))
    if isinstance(value, Tuple):
        return Tuple(value.of, tuple(with_leaves(item, given) for item in value.items))
    raise RoutineError(f"{value.thing!r} is no number")


def kind_of(value: Value) -> Hashable:
    """What two values have in common that may have the same name."""
    if isinstance(value, Scalar):
        return value.kind
    if isinstance(value, Array):
        return value.kind, len(value.shape)
    if isinstance(value, Tuple):
        return value.of, tuple(map(kind_of, value.items))
    return value.thing


def said(value: Value) -> str:
    """The kind of a value in words."""
    if isinstance(value, Scalar):
        return CALLED[value.kind]
    if isinstance(value, Array):
        return f"an array of {len(value.shape)} dimensions"
    if isinstance(value, Tuple):
        return f"a {value.of.__name__}" if value.of else f"a tuple of {len(value.items)}"
    return repr(value.thing)
