"""A program as machine code: addresses for the driver, and the memory that it needs."""

import ctypes
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from importlib import import_module

import numpy as np

from lienumba.compiler import native
from lienumba.compiler.rows import W
from lienumba.integrators.carried import Carried
from lienumba.integrators.held import Held
from lienumba.integrators.program import Program

ALIGNMENT = 64  # bytes: a row of lanes never straddles a cache line


def aligned(*shape: int) -> np.ndarray:
    """Zeros of this shape, float64, aligned to a cache line."""
    size = int(np.prod(shape))
    raw = np.zeros(size + ALIGNMENT // 8)
    offset = (-raw.ctypes.data % ALIGNMENT) // 8
    return raw[offset : offset + size].reshape(shape)


@dataclass(frozen=True)
class Machine:
    """`kernels`: addresses in the driver's order; `prepares`: of the functions that fill the hoisted rows;
    `nodes`: c of the tableau; `correction`, `kept`: as in the program."""

    kernels: np.ndarray
    prepares: tuple[int, ...]
    nodes: np.ndarray
    elements: int
    carried: Carried
    held: Held
    parameter_rows: int
    seen: int
    correction: int
    kept: int
    buffer_rows: int

    def buffer(self) -> np.ndarray:
        return aligned(self.buffer_rows * W)


def compile_program(program: Program) -> Machine:
    """Compile or load every kernel; two at a time."""
    with ThreadPoolExecutor(2) as threads:
        compiling = {name: threads.submit(native.compile_text, k.text()) for name, k in program.kernels.items()}
        driver = import_module("lienumba.integrators.driver")  # compiled or loaded meanwhile
        objects = {name: future.result() for name, future in compiling.items()}
    stages = len(program.nodes)
    order = [*driver.ORDER, *(f"combine{s}" for s in range(stages))]
    kernels = np.zeros(len(order), np.int64)
    prepares: list[int] = []
    for name, code in objects.items():
        addresses = native.load(code, [name, f"{name}_prepare"])
        kernels[order.index(name)] = addresses[name]
        prepares.append(addresses[f"{name}_prepare"])
    return Machine(
        kernels,
        tuple(prepares),
        np.array(program.nodes),
        program.elements,
        program.carried,
        program.held,
        program.parameter_rows,
        sum(rows for _, rows in program.observed.values()),
        program.correction,
        program.kept,
        driver.scratch_rows(
            program.elements, program.held.rows, program.correction, program.kept, len(program.held.masks), stages
        )
        + max(k.work_rows for k in program.kernels.values()),
    )


def prepare(machine: Machine, parameters: np.ndarray) -> None:
    """Fill the hoisted rows of every block of parameters (blocks, P, W)."""
    work = machine.buffer()
    for address in machine.prepares:
        function = ctypes.CFUNCTYPE(None, *[ctypes.c_int64] * 6)(address)
        for block in parameters:
            function(0, block.ctypes.data, 0, 0, 0, work.ctypes.data)
