"""A program as machine code: addresses for the driver, and the memory that it needs."""

import ctypes
import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np

from lienumba.compiler import native
from lienumba.compiler.flat import Flat, kept, plain
from lienumba.compiler.foreign.calls import linked
from lienumba.compiler.memo import Memo
from lienumba.compiler.rows import W
from lienumba.groups.state import ELEMENT
from lienumba.integrators.layout import CLOCK, COMBINE, MEASURE, OBSERVE, ORDER, PLACE, READ, TIME, workspace
from lienumba.integrators.sizes import Sizes
from lienumba.integrators.tracing.program import Outline, Program

_DRIVERS: Memo[Flat] = Memo(3)
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
    `nodes`: c of all stages; `queued`: see `Outline`; `drive`: the driver; `engines`: which hold the machine code."""

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


@dataclass(frozen=True)
class ObjectCode:
    """Of a program. `objects`: by kernel; `entries`: the names under which the cache has them; `work_rows`: those that
    the kernels need for themselves."""

    objects: dict[str, bytes]
    entries: dict[str, str]
    work_rows: int


def compile_kernels(program: Program) -> ObjectCode:
    """Compile every kernel; two at a time."""
    with ThreadPoolExecutor(2) as threads:
        compiling, entries = {}, {}
        for name, kernel in program.kernels.items():
            text = linked(kernel.text())
            compiling[name], entries[name] = threads.submit(native.compile_text, text), native.entry(text)
        _driver(program)  # meanwhile
        objects = {name: future.result() for name, future in compiling.items()}
    return ObjectCode(objects, entries, max(kernel.work_rows for kernel in program.kernels.values()))


def compile_program(program: Program) -> Machine:
    """The program as machine code."""
    made = compile_kernels(program)
    return load(program, made)


def _driver(outline: Outline) -> Callable[..., None]:
    """The driver of a program, as plain Python where the environment variable LIENUMBA_DRIVERS is "python"."""
    name = f"lienumba.integrators.drivers.{'variable_step' if outline.queued else 'fixed_step'}"
    if os.environ.get("LIENUMBA_DRIVERS") == "python":
        return plain(name, "drive")
    return _DRIVERS.get(name, lambda: kept(name, "drive"))


def load(outline: Outline, made: ObjectCode) -> Machine:
    """The program of this object code."""
    nodes = np.array(outline.nodes)
    order = [*ORDER, *(f"combine{s}" for s in range(len(nodes)))]
    kernels = np.zeros(COMBINE + len(nodes), np.int64)
    prepares: list[int] = []
    engines: list[Any] = []
    for name, code in made.objects.items():
        engine, addresses = native.load(code, [name, f"{name}_prepare"])
        engines.append(engine)
        kernels[order.index(name)] = addresses[name]
        prepares.append(addresses[f"{name}_prepare"])
    rows, drive = workspace(outline.sizes).work + made.work_rows, _driver(outline)
    return Machine(kernels, tuple(prepares), nodes, outline.sizes, outline.queued, drive, rows, tuple(engines))


def prepare(machine: Machine, parameters: np.ndarray) -> None:
    """Fill the hoisted rows of every block of parameters (blocks, P, W)."""
    work, every = machine.buffer(), _addresses(parameters)
    room = work.ctypes.data
    for address in machine.prepares:
        function = _function(address)
        for block in every:
            function(0, block, 0, 0, 0, room)


def place(machine: Machine, states: np.ndarray, parameters: np.ndarray, bodies: int) -> np.ndarray:
    """The bodies of states (blocks, rows, W), also by rows; the states as they are if these have them."""
    if not machine.kernels[PLACE]:
        return states
    found = aligned(len(states), ELEMENT * bodies, W)
    _each(machine, PLACE, states, parameters, found)
    return found


def read(machine: Machine, bodies: np.ndarray, parameters: np.ndarray, states: np.ndarray) -> None:
    """Put where the moves are into the states (blocks, rows, W), from the bodies, likewise by rows."""
    _each(machine, READ, bodies, parameters, states)


def observe(machine: Machine, states: np.ndarray, parameters: np.ndarray, times: np.ndarray) -> np.ndarray:
    """What is observed (blocks, rows, W) of states (blocks, rows, W) at times (blocks, W)."""
    found = aligned(len(states), machine.sizes.observed, W)
    _each(machine, OBSERVE, states, parameters, found, times)
    return found


def measure(machine: Machine, states: np.ndarray, parameters: np.ndarray, times: np.ndarray) -> np.ndarray:
    """The signals of measures (blocks, signals, W) of states (blocks, rows, W) at times (blocks, W)."""
    found = aligned(len(states), machine.sizes.signals, W)
    _each(machine, MEASURE, states, parameters, found, times)
    return found


def observe_events(
    machine: Machine, states: np.ndarray, times: np.ndarray, parameters: np.ndarray, records: np.ndarray, limit: int,
    tolerance: float,
) -> None:  # fmt: skip
    """See `events.states.observe_events`."""
    name = "lienumba.integrators.drivers.events.states"
    routine = _DRIVERS.get(name, lambda: kept(name, "observe_events"))
    routine(
        machine.kernels, machine.nodes, machine.sizes, states, times, parameters, records, limit, tolerance,
        machine.buffer(),
    )  # fmt: skip


def _each(
    machine: Machine, kernel: int, given: np.ndarray, parameters: np.ndarray, found: np.ndarray,
    times: np.ndarray | None = None,
) -> None:  # fmt: skip
    """Call a kernel for each block, at times (blocks, W), or at 0."""
    work, clock = machine.buffer(), aligned(CLOCK, W)
    function, ticks, room = _function(int(machine.kernels[kernel])), clock.ctypes.data, work.ctypes.data
    every = zip(*(_addresses(x) for x in (given, parameters, found)), strict=True)
    for n, (x, p, out) in enumerate(every):
        if times is not None:
            clock[TIME] = times[n]
        function(x, p, ticks, 0, out, room)


def _function(kernel: int) -> Callable[..., None]:
    return ctypes.CFUNCTYPE(None, *[ctypes.c_int64] * 6)(kernel)


def _addresses(blocks: np.ndarray) -> list[int]:
    """The address of every block of an array (blocks, rows, W)."""
    first, step = blocks.ctypes.data, blocks.strides[0]
    return [first + step * n for n in range(len(blocks))]
