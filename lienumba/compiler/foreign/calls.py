"""Calls of functions that are not traced: nodes of a graph, and the LLVM text behind them.

A function is known by its symbol and its text. It has the signature  i32 (result, error, given, found, lanes):  it
reads each argument from a row of `lanes` doubles at `given` and writes each output to a row at `found`, lane by lane.
The first two are room for what its compiler returns; the error has to be null before. In a graph it is a node `call`
with the symbol and the arguments, and each output is a node `part`. Nothing is known of its derivatives.
"""

import ctypes
import functools
import inspect
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from types import FunctionType
from typing import Any, Literal, NamedTuple

import numpy as np

from lienumba.compiler.symbols import Graph, Symbol, reached
from lienumba.errors import BadValueError, ScenarioError
from lienumba.laws import Memory, Vector
from lienumba.numerics.jets import Jet
from lienumba.numerics.number import Number

PREFIX = "lienumba_call_"  # of every symbol
DECLARATION = "declare i32 @{}(ptr, ptr, ptr, ptr, i64)\n"
TRACED = "write it with the functions of lienumba.laws, so that it is traced"
TUPLES = (tuple, list, Vector)


class Argument(NamedTuple):
    """What a function gets: a number, a tuple, or an array, whose numbers the function replaces; and its size."""

    kind: Literal["number", "tuple", "array"]
    size: int

    @staticmethod
    def of(x: object) -> "Argument":
        if isinstance(x, Memory):
            return Argument("array", len(x))
        return Argument("tuple", len(x)) if isinstance(x, TUPLES) else Argument("number", 1)


@dataclass(frozen=True)
class Foreign:
    """name: that of the user's function; outputs: how many numbers it writes, those of its arrays behind the others;
    scalar: whether its own output is a number, not a tuple of one; text: LLVM text that defines the symbol, complete in
    itself; outside: whether that calls code that lienumba does not know; sampled: why its law has to be sampled, empty
    if it need not be; evaluate: of functions of Python, outputs (outputs, runs) of arguments (numbers, runs)."""

    symbol: str
    name: str
    outputs: int
    scalar: bool
    text: str
    outside: bool = False
    sampled: str = ""
    evaluate: Callable[[np.ndarray], np.ndarray] | None = None

    def called(self, numbers: Sequence[Any], arrays: Sequence[Memory] = ()) -> Any:
        """Call it: a tuple of its outputs, or a number if there is only one. Its arrays get their new numbers."""
        node = call(self.symbol, *numbers)
        found = [part(node, n) for n in range(self.outputs)]
        for array in reversed(arrays):
            first = len(found) - len(array)
            array[:], found = found[first:], found[:first]
        return found[0] if self.scalar else tuple(found)


class Function:
    """A function that laws call, and that is not traced."""

    __name__: str

    def identity(self) -> str:
        """Return what determines its outputs, as far as that is known."""
        raise NotImplementedError


class PythonFunction(Function):
    """One that is written in Python. `py_func`: the function as it is written."""

    def __init__(self, function: FunctionType) -> None:
        functools.update_wrapper(self, function)
        self.py_func = function
        self._signature = inspect.signature(function)

    def __call__(self, *arguments: object, **named: object) -> Any:
        """Its outputs: symbols of the graph of its arguments, or on floats and arrays of runs numbers like them."""
        bound = self._signature.bind(*arguments, **named)
        bound.apply_defaults()
        numbers, arrays = flat(self.__name__, bound.args), [x for x in bound.args if isinstance(x, Memory)]
        if len({id(x) for x in arrays}) < len(arrays):
            raise BadValueError(f"{self.__name__} gets one array of a memory twice", "give it once")
        return self.compiled([Argument.of(x) for x in bound.args]).called(numbers, arrays)

    def compiled(self, arguments: Sequence[Argument]) -> Foreign:
        """Return what kernels call for such arguments."""
        raise NotImplementedError


KNOWN: dict[str, Foreign] = {}  # by symbol: those that this process has called


def call(symbol: str, *numbers: Number) -> Any:
    """The call as a node of the graph of its arguments; on floats and arrays the outputs."""
    graph = next((x.graph for x in numbers if isinstance(x, Symbol)), None)
    return _evaluated(symbol, numbers) if graph is None else recorded(graph, symbol, numbers)


def recorded(graph: Graph, symbol: str, numbers: Sequence[Number]) -> Symbol:
    """The call as a node of a graph."""
    return graph.node("call", symbol, *(x if isinstance(x, Symbol) else float(x) for x in numbers))  # type: ignore[arg-type]


def part(called: Any, n: int) -> Any:
    """One output of a call."""
    return called.graph.node("part", called, n) if isinstance(called, Symbol) else called[n]


def flat(name: str, arguments: Sequence[object]) -> list[Any]:
    """The numbers of arguments that are numbers or tuples of numbers. Raises errors that name the function."""
    numbers: list[Any] = []
    for x in arguments:
        numbers.extend(x if isinstance(x, (*TUPLES, Memory)) else (x,))
    for x in numbers:
        if isinstance(x, Jet):
            raise underivable(name)
        if not isinstance(x, Symbol | float | int | np.number | np.ndarray):
            raise BadValueError(f"{name} gets {x!r}, a {type(x).__name__}", "give it numbers, or tuples of numbers")
    return numbers


def called_by(values: Sequence[object]) -> tuple[str, ...]:
    """The names of the functions on whose outputs values of a graph depend."""
    return tuple(sorted({name_of(node) for node in reached(values) if node.op == "call"}))


def name_of(node: Symbol) -> str:
    """The name of the function that a node calls."""
    return KNOWN[node.args[0]].name


def underivable(name: str) -> ScenarioError:
    """The error where the derivative of a function is needed."""
    rule = "is not traced and so has no derivative, which is needed here"
    return ScenarioError.at(f"the function {name}", rule, f"sample its law (every), or {TRACED}")


def linked(text: str) -> str:
    """LLVM text of kernels with the functions that it calls."""
    symbols = sorted(set(re.findall(rf"@({PREFIX}\w+)\(", text)))
    if not symbols:
        return text
    from llvmlite import binding

    module = binding.parse_assembly(text + "\n" + "".join(map(DECLARATION.format, symbols)))
    for symbol in symbols:
        module.link_in(binding.parse_assembly(KNOWN[symbol].text))
    for function in module.functions:
        if function.name in symbols:
            function.linkage = "internal"
    return str(module)


def _evaluated(symbol: str, numbers: Sequence[Any]) -> list[Any]:
    """The outputs: floats, or arrays where an argument is one."""
    shape = np.broadcast_shapes(*(np.shape(x) for x in numbers))
    rows = [np.broadcast_to(x, shape).ravel() for x in numbers]
    given = np.array(rows, np.float64).reshape(len(rows), int(np.prod(shape)))
    evaluate = KNOWN[symbol].evaluate
    found = _found(symbol, given) if evaluate is None else evaluate(given)
    return [row.reshape(shape) for row in found] if shape else [float(x) for x in found[:, 0]]


def _found(symbol: str, given: np.ndarray) -> np.ndarray:
    """Compute the outputs (outputs, runs) of arguments (numbers, runs) by machine code."""
    found = np.empty((KNOWN[symbol].outputs, given.shape[1]))
    room = np.zeros(2, np.int64)
    first = room.ctypes.data
    _machine(symbol)(first, first + 8, given.ctypes.data, found.ctypes.data, given.shape[1])
    return found


@cache
def _machine(symbol: str) -> Callable[..., int]:
    """The function as machine code; its engine lives as long as the process."""
    from lienumba.compiler import native

    engine, addresses = native.load(native.compile_text(KNOWN[symbol].text), [symbol])
    function = ctypes.CFUNCTYPE(ctypes.c_int32, *[ctypes.c_void_p] * 4, ctypes.c_int64)(addresses[symbol])
    function.engine = engine  # type: ignore[attr-defined]
    return function
