"""Runs kernels as compiled code: traced on symbols, or under `@njit` on floats."""

import ctypes
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numba import njit

from lienumba.compiler import native
from lienumba.compiler.emit import Kernel
from lienumba.compiler.foreign.calls import linked
from lienumba.compiler.rows import W
from lienumba.compiler.symbols import Graph

Shape = Sequence[int]  # of the arguments: 0 for a number, n for an n-tuple


def flat(values: Any) -> list[Any]:
    """The numbers of nested tuples, in order."""
    if isinstance(values, tuple | list):
        return [x for value in values for x in flat(value)]
    return [values]


def grouped(numbers: Sequence[Any], shape: Shape) -> list[Any]:
    """The flat numbers as arguments of this shape."""
    rest, arguments = list(numbers), []
    for size in shape:
        arguments.append(tuple(rest[:size]) if size else rest[0])
        del rest[: size or 1]
    return arguments


def rows_in(shape: Shape) -> int:
    return sum(size or 1 for size in shape)


def machine_code(kernel: Kernel) -> Callable[..., np.ndarray]:
    """Maps state, parameters, clock, extra (rows, W) to the outputs (rows, W) of a kernel, after its `prepare`."""
    text = linked(kernel.text())  # also counts the work rows
    engine, addresses = native.load(native.compile_text(text), [f"{kernel.name}_prepare", kernel.name])
    functions = [ctypes.CFUNCTYPE(None, *[ctypes.c_int64] * 6)(address) for address in addresses.values()]
    hoisted = max((row + 1 for row in kernel.hoisted.values()), default=0)
    rows = 1 + max(kernel.rows or range(len(kernel.outputs)), default=0)

    def evaluate(**arrays: np.ndarray) -> np.ndarray:
        memory = {n: np.ascontiguousarray(arrays.get(n, np.zeros((1, W)))) for n in ("state", "clock", "extra")}
        parameters = arrays.get("parameters", np.zeros((0, W)))
        memory["parameters"] = np.concatenate([parameters, np.full((max(hoisted - len(parameters), 1), W), np.nan)])
        memory["out"] = arrays["out"].copy() if "out" in arrays else np.full((rows, W), np.nan)
        memory["work"] = np.full((kernel.work_rows + 1, W), np.nan)
        pointers = [memory[name].ctypes.data for name in ("state", "parameters", "clock", "extra", "out", "work")]
        assert engine
        for function in functions:
            function(*pointers)
        return memory["out"]

    return evaluate


def call(kernel: Kernel, **arrays: np.ndarray) -> np.ndarray:
    """The outputs of a kernel, once."""
    return machine_code(kernel)(**arrays)


def traced(function: Callable[..., Any], shape: Shape) -> Callable[[np.ndarray], np.ndarray]:
    """The function as straight-line machine code; maps (rows, n) to (results, n)."""
    graph = Graph()
    outputs = flat(function(*grouped(graph.inputs("state", rows_in(shape)), shape)))
    run = machine_code(Kernel("traced", tuple(outputs), 0))
    return lambda x: _by_blocks(x, lambda block: run(state=block))


def under_njit(function: Callable[..., Any], shape: Shape) -> Callable[[np.ndarray], np.ndarray]:
    """The function under `@njit`, on floats; maps (rows, n) to (results, n)."""
    names = {"function": function}
    parameters = ", ".join(f"a{i}" for i in range(len(shape)))
    exec(f"def wrapper({parameters}):\n    return function({parameters})", names)
    compiled = njit(error_model="numpy")(names["wrapper"])

    def evaluate(x: np.ndarray) -> np.ndarray:
        return np.array([flat(compiled(*grouped(column.tolist(), shape))) for column in x.T]).T

    return evaluate


def on_floats(function: Callable[..., Any], shape: Shape) -> Callable[[np.ndarray], np.ndarray]:
    """The function as plain Python; maps (rows, n) to (results, n)."""
    return lambda x: np.array([flat(function(*grouped(column.tolist(), shape))) for column in x.T]).T


def on_arrays(function: Callable[..., Any], shape: Shape) -> Callable[[np.ndarray], np.ndarray]:
    """The function on NumPy arrays; maps (rows, n) to (results, n)."""

    def evaluate(x: np.ndarray) -> np.ndarray:
        with np.errstate(all="ignore"):
            return np.array([np.broadcast_to(y, x.shape[1:]) for y in flat(function(*grouped(list(x), shape)))])

    return evaluate


def _by_blocks(x: np.ndarray, block: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
    runs = x.shape[1]
    padded = x[:, np.minimum(np.arange(-(-runs // W) * W), runs - 1)]
    outs = [block(padded[:, first : first + W]) for first in range(0, runs, W)]
    return np.concatenate(outs, axis=1)[:, :runs]


def assert_same_bits(a: np.ndarray, b: np.ndarray) -> None:
    """Equal bit for bit, the sign of zero included; one NaN is as good as another."""
    a, b = np.asarray(a, float), np.asarray(b, float)
    assert a.shape == b.shape
    different = (a.view(np.int64) != b.view(np.int64)) & ~(np.isnan(a) & np.isnan(b))
    assert not different.any(), f"{different.sum()} of {a.size} differ: {a[different][:3]} and {b[different][:3]}"
