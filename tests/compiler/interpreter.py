"""What a graph means, operation by operation, with exactly rounded fused multiply-adds; and random graphs."""

import ctypes
import math
import operator
import random
from fractions import Fraction
from typing import Any

import numpy as np

from lienumba.compiler.rows import W
from lienumba.compiler.symbols import Graph, Symbol, live
from lienumba.numerics import operations
from lienumba.numerics.vector_math import round_to_integer


def fma(a: float, b: float, c: float) -> float:
    """a b + c, rounded once."""
    if not (math.isfinite(a) and math.isfinite(b)):
        return a * b + c
    if not math.isfinite(c):
        return c
    exact = Fraction(a) * Fraction(b) + Fraction(c)
    if exact == 0:
        return a * b + c if a * b == 0.0 and c == 0.0 else 0.0
    try:
        return float(exact)
    except OverflowError:
        return math.inf if exact > 0 else -math.inf


def _fused(a: Any, b: Any, c: Any) -> np.ndarray:
    return np.array([fma(*map(float, abc)) for abc in np.broadcast(a, b, c)])


def _gathered(address: Any, index: Any) -> np.ndarray:
    """What lies in memory at an address, which is the bits of a number."""
    starts = np.ascontiguousarray(np.broadcast_to(address, (W,))).view(np.int64)
    places = np.broadcast_to(index, (W,)).astype(int)
    return np.array(
        [ctypes.c_double.from_address(a + 8 * i).value for a, i in zip(starts.tolist(), places.tolist(), strict=True)]
    )


ACTIONS = {
    "+": lambda a, b: a + b,
    "-": lambda a, b: a - b,
    "*": lambda a, b: a * b,
    "/": lambda a, b: np.divide(a, b),
    "neg": lambda a: -a,
    "fma": _fused,
    "fms": lambda a, b, c: _fused(a, b, -np.asarray(c)),
    "fnma": lambda a, b, c: _fused(-np.asarray(a), b, c),
    "sqrt": np.sqrt,
    "power_of_two": lambda n: np.ldexp(1.0, n.astype(int)),
    "<": lambda a, b: np.asarray(a < b),
    "<=": lambda a, b: np.asarray(a <= b),
    "==": lambda a, b: np.asarray(a == b),
    "where": np.where,
    "gather": _gathered,
}


def interpret(outputs: tuple[Any, ...], **arrays: np.ndarray) -> np.ndarray:
    """The outputs (rows, W) of a graph on state, parameters, clock, extra (rows, W)."""
    values: dict[int, Any] = {}

    def value(x: Any) -> Any:
        return values[x.id] if isinstance(x, Symbol) else x

    with np.errstate(all="ignore"):
        for node in live(outputs):
            if node.op == "input":
                values[node.id] = arrays[node.args[0]][node.args[1]]
            else:
                values[node.id] = ACTIONS[node.op](*map(value, node.args))
        return np.array([np.broadcast_to(np.asarray(value(x), float), (W,)) for x in outputs])


KINDS = ["+", "-", "*", "*", "a b + c", "a b - c", "c - a b", "/", "neg", "sqrt", "where", "2^n"]


class RandomGraph:
    """Random expressions; all choices come from the seed."""

    def __init__(self, seed: int) -> None:
        self.random = random.Random(seed)
        self.graph = Graph()
        self.values: list[Any] = [
            *self.graph.inputs("state", 5), *self.graph.inputs("parameters", 4), *self.graph.inputs("clock", 2),
        ]  # fmt: skip

    def pick(self) -> Any:
        """A value, mostly a recent one, at times a number."""
        if self.random.random() < 0.15:
            return self.random.choice([0.0, 1.0, -1.0, 0.5, 3.0, 1e-9, self.random.uniform(-4.0, 4.0)])
        recent = self.values[-12:] if self.random.random() < 0.6 else self.values
        return self.random.choice(recent)

    def grow(self, count: int) -> list[Any]:
        """`count` more expressions."""
        first = len(self.values)
        while len(self.values) < first + count:
            self.values.append(self._expression(self.pick(), self.pick(), self.pick()))
        return self.values[first:]

    def _expression(self, a: Any, b: Any, c: Any) -> Any:
        kind = self.random.choice(KINDS)
        if kind == "sqrt":
            return operations.sqrt(operations.absolute(a))
        if kind == "where":
            compare = self.random.choice([operator.lt, operator.le, operator.gt, operator.ge, operator.eq])
            return operations.where(compare(a, b), b, c)
        if kind == "2^n":
            return operations.power_of_two(round_to_integer(operations.minimum(operations.maximum(a, -40.0), 40.0)))
        if kind == "/":
            return a / b if isinstance(b, Symbol) or b else a
        simple = {"+": a + b, "-": a - b, "*": a * b, "neg": -a}
        fused = {"a b + c": a * b + c, "a b - c": a * b - c, "c - a b": c - a * b}
        return (simple | fused)[kind]


def numbers(rows: int, seed: int) -> np.ndarray:
    """(rows, W): ordinary numbers, the last lanes spiced with what is huge, tiny, zero or not finite."""
    rng = np.random.default_rng(seed)
    x = rng.standard_normal((rows, W)) * 10.0 ** rng.uniform(-3, 3, (rows, W))
    spices = np.array([0.0, -0.0, 1.0, -1.0, 5e-324, 1e-310, 1e300, -1e300, np.inf, -np.inf, np.nan])
    spiced = rng.random((rows, 3)) < 0.3
    x[:, -3:][spiced] = rng.choice(spices, spiced.sum())
    return x
