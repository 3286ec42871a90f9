"""A program as machine code: addresses for the driver, and the memory that it needs."""

import ctypes
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from importlib import import_module

import numpy as np

from lienumba.compiler import native
from lienumba.compiler.emit import W
from lienumba.groups.state import ELEMENT
from lienumba.integrators.program import Program

ORDER = ("step", "position", "velocity", "observe")
ALIGNMENT = 64  # bytes: a row of lanes never straddles a cache line


def aligned(*shape: int) -> np.ndarray:
    """Zeros of this shape, float64, aligned to a cache line."""
    size = int(np.prod(shape))
    raw = np.zeros(size + ALIGNMENT // 8)
    offset = (-raw.ctypes.data % ALIGNMENT) // 8
    return raw[offset : offset + size].reshape(shape)


@dataclass(frozen=True)
class Machine:
    """`kernels`: addresses in the driver's order; `prepares`: of the functions that fill the hoisted rows."""

    kernels: np.ndarray
    prepares: tuple[int, ...]
    bodies: int
    parameter_rows: int
    seen: int
    buffer_rows: int

    def buffer(self) -> np.ndarray:
        return aligned(self.buffer_rows * W)


def compile_program(program: Program) -> Machine:
    """Compile or load every kernel; two at a time."""
    named = [(name, program.kernels[name]) for name in ORDER if name in program.kernels]
    with ThreadPoolExecutor(2) as threads:
        compiling = [threads.submit(native.compile_text, kernel.text()) for _, kernel in named]
        import_module("lienumba.integrators.driver")  # compiled or loaded meanwhile
        objects = [future.result() for future in compiling]
    kernels = np.zeros(len(ORDER), np.int64)
    prepares: list[int] = []
    for (name, kernel), code in zip(named, objects, strict=True):
        functions = [kernel.name, *(f"{k.name}_prepare" for k in (kernel, *kernel.calls))]
        addresses = native.load(code, functions)
        kernels[ORDER.index(name)] = addresses[kernel.name]
        prepares += [addresses[f] for f in functions[1:]]
    seen = sum(rows for _, rows in program.observed.values())
    work = max(kernel.work_rows for kernel in program.kernels.values())
    state = (ELEMENT + 6) * program.bodies + 4
    return Machine(kernels, tuple(prepares), program.bodies, program.parameter_rows, seen, 4 * state + work)


def prepare(machine: Machine, parameters: np.ndarray) -> None:
    """Fill the hoisted rows of every block of parameters (blocks, P, W)."""
    work = machine.buffer()
    for address in machine.prepares:
        function = ctypes.CFUNCTYPE(None, *[ctypes.c_int64] * 6)(address)
        for block in parameters:
            function(0, block.ctypes.data, 0, 0, 0, work.ctypes.data)
