"""A state with its tangents, which the kernels of `lienumba.integrators.tracing.tangents` advance and look at."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from lienumba.compiler import flat
from lienumba.compiler.lanes import call
from lienumba.compiler.memo import Memo
from lienumba.compiler.rows import W
from lienumba.integrators import layout
from lienumba.integrators.tracing.machine import aligned
from lienumba.integrators.tracing.tangents.kernels import TangentMachine

# See `drivers.tangents.Memory`.
REGIONS = ("state", "parameters", "new", "now", "following", "u", "slopes", "clock", "work")


DRIVER: Memo[flat.Flat] = Memo(1)
NO_RECORDS = np.zeros((0, 0, W))


class Start(NamedTuple):
    """Where a run begins, and how that changes with its inputs: state (rows,), parameters (slots,), the times (s) at
    which F may jump (jumps,), and the tangents of all these (..., inputs)."""

    state: np.ndarray
    parameters: np.ndarray
    jumps: np.ndarray
    state_tangents: np.ndarray
    parameter_tangents: np.ndarray
    jump_tangents: np.ndarray


@dataclass
class Point:
    """A state (2, rows, W) with its tangents at a time (s), and the tangents of this time (W,), 0 but at an event."""

    x: np.ndarray
    t: float
    moves: np.ndarray = field(default_factory=lambda: np.zeros(W))

    def copy(self) -> "Point":
        return Point(self.x.copy(), self.t, self.moves.copy())


class Marcher:
    """Advances a point; the memory of one thread, with the inputs of one pack of lanes."""

    def __init__(self, machine: TangentMachine, iterations: int, tolerance: float) -> None:
        self.machine, self.limits = machine, (iterations, tolerance)
        self.rows, shift = layout.state_rows(machine.sizes), machine.shift
        self.record_rows = self.rows + machine.sizes.observed + layout.PROJECTIONS
        sizes = dict.fromkeys(REGIONS, 2 * shift + machine.sizes.coordinates)
        sizes |= {"parameters": machine.parameters, "clock": 2 * layout.CLOCK, "work": max(machine.work_rows, 1)}
        self.memory = {name: aligned(rows, W) for name, rows in sizes.items()}
        self.at = tuple(self.memory[name].ctypes.data for name in REGIONS)
        self.ends = aligned(2, W)
        self.drive = DRIVER.get((), lambda: flat.kept("lienumba.integrators.drivers.tangents", "march"))

    def begin(self, start: Start, pack: slice) -> Point:
        """The start, with the inputs of this pack in the lanes; lanes behind the last one change nothing."""
        machine, p = self.machine, self.memory["parameters"]
        p[:] = 0.0
        p[: machine.slots] = start.parameters[:, None]
        changes = start.parameter_tangents[:, pack]
        p[machine.slots : 2 * machine.slots, : changes.shape[1]] = changes
        self._prepare()
        x = np.zeros((2, self.rows, W))
        x[0] = start.state[:, None]
        changes = start.state_tangents[:, pack]
        x[1, :, : changes.shape[1]] = changes
        return Point(x, 0.0)

    def march(
        self, point: Point, times: np.ndarray, ends: np.ndarray | None = None, records: np.ndarray | None = None
    ) -> None:
        """Advance by steps: begin, end and length of each (3, steps), and with records (records, rows, W) which one the
        end of each fills, and whether the state goes on from there (5, steps); ends: tangents of the time when the last
        one ends, 0 if omitted."""
        self._load(point)
        self.ends[0], self.ends[1] = point.moves, 0.0 if ends is None else ends
        if records is None:
            times, records = np.stack([*times, *np.multiply.outer((-1.0, 1.0), np.ones(times.shape[1]))]), NO_RECORDS
        steps = np.ascontiguousarray(times), self.ends.ctypes.data, records
        self.drive(
            self.machine.kernels, self.machine.nodes, self.machine.sizes, self.at, steps, self.limits,
            self.machine.shift,
        )  # fmt: skip
        point.x, point.t, point.moves = self._read("state", self.rows), float(times[1, -1]), self.ends[1].copy()

    def evaluate(self, kernel: int, point: Point, rows: int, extra: np.ndarray | None = None) -> np.ndarray:
        """What a kernel gives at a point (2, rows, W); extra: what else it reads (2, rows, W)."""
        machine, memory = self.machine, self.memory
        self._load(point)
        clock = memory["clock"]
        clock[:] = 0.0
        clock[layout.TIME], clock[layout.CLOCK + layout.TIME], clock[layout.MIDDLE] = point.t, point.moves, point.t
        if extra is not None:
            memory["u"][: extra.shape[1]] = extra[0]
            memory["u"][machine.shift : machine.shift + extra.shape[1]] = extra[1]
        at = dict(zip(REGIONS, self.at, strict=True))
        call(int(machine.kernels[kernel]), at["state"], at["parameters"], at["clock"], at["u"], at["new"], at["work"])
        return self._read("new", rows)

    @contextmanager
    def held(self) -> Iterator[None]:
        """No input changes a parameter meanwhile."""
        own = slice(self.machine.slots, 2 * self.machine.slots)
        changes = self.memory["parameters"][own].copy()
        self.memory["parameters"][own] = 0.0
        self._prepare()
        yield
        self.memory["parameters"][own] = changes
        self._prepare()

    def _prepare(self) -> None:
        """What follows from the parameters and their tangents alone."""
        for prepare in self.machine.prepares:
            call(prepare, 0, self.memory["parameters"].ctypes.data, 0, 0, 0, self.memory["work"].ctypes.data)

    def _load(self, point: Point) -> None:
        state, shift = self.memory["state"], self.machine.shift
        state[: self.rows], state[shift : shift + self.rows] = point.x

    def _read(self, region: str, rows: int) -> np.ndarray:
        memory, shift = self.memory[region], self.machine.shift
        return np.stack([memory[:rows], memory[shift : shift + rows]])
