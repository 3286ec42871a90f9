"""A program as machine code: addresses for the driver, and the memory that it needs."""

import ctypes
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from importlib import import_module
from typing import Any

import numpy as np

from lienumba.compiler import native
from lienumba.compiler.rows import W
from lienumba.integrators.layout import COMBINE, ORDER, Sizes, workspace
from lienumba.integrators.tracing.program import Program

ALIGNMENT = 64  # bytes: a row of lanes never straddles a cache line


def aligned(*shape: int) -> np.ndarray:
    """Zeros of this shape, float64, aligned to a cache line."""
    size = int(np.prod(shape))
    raw = np.zeros(size + ALIGNMENT // 8)
    offset = (-raw.ctypes.data % ALIGNMENT) // 8
    return raw[offset : offset + size].reshape(shape)


@dataclass(frozen=True)
class Machine:
    """`kernels`: addresses, see `layout.ORDER`; `prepares`: of the functions that fill the hoisted rows;
    `nodes`: c of all stages; `queued`: see `Program`; `drive`: the driver; `engines`: which hold the machine code."""

    kernels: np.ndarray
    prepares: tuple[int, ...]
    nodes: np.ndarray
    sizes: Sizes
    queued: bool
    drive: Callable[..., None]
    buffer_rows: int
    engines: tuple[Any, ...]

    def buffer(self) -> np.ndarray:
        return aligned(self.buffer_rows * W)


def compile_program(program: Program) -> Machine:
    """Compile or load every kernel; two at a time."""
    with ThreadPoolExecutor(2) as threads:
        compiling = {name: threads.submit(native.compile_text, k.text()) for name, k in program.kernels.items()}
        name = "variable_step" if program.queued else "fixed_step"
        driver = import_module(f"lienumba.integrators.drivers.{name}")  # meanwhile
        objects = {name: future.result() for name, future in compiling.items()}
    order = [*ORDER, *(f"combine{s}" for s in range(len(program.nodes)))]
    kernels = np.zeros(COMBINE + len(program.nodes), np.int64)
    prepares: list[int] = []
    engines: list[Any] = []
    for name, code in objects.items():
        engine, addresses = native.load(code, [name, f"{name}_prepare"])
        engines.append(engine)
        kernels[order.index(name)] = addresses[name]
        prepares.append(addresses[f"{name}_prepare"])
    rows = workspace(program.sizes).work + max(k.work_rows for k in program.kernels.values())
    nodes = np.array(program.nodes)
    return Machine(kernels, tuple(prepares), nodes, program.sizes, program.queued, driver.drive, rows, tuple(engines))


def prepare(machine: Machine, parameters: np.ndarray) -> None:
    """Fill the hoisted rows of every block of parameters (blocks, P, W)."""
    work = machine.buffer()
    for address in machine.prepares:
        function = ctypes.CFUNCTYPE(None, *[ctypes.c_int64] * 6)(address)
        for block in parameters:
            function(0, block.ctypes.data, 0, 0, 0, work.ctypes.data)
