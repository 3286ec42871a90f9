"""The one driver: advances blocks of W runs, step by step, by kernels that it gets as addresses.

It knows rows of lanes, not mechanics. Compiled once for all mechanisms. A run feels nothing of its neighbours: every
iteration is committed by lane, and a lane that fails is frozen while the others go on.
"""

from typing import Any

import numpy as np
from numba import njit
from numba.core import types

from lienumba.compiler import cache, jit
from lienumba.compiler.emit import W
from lienumba.compiler.lanes import any_lane, call, choose, load, splat, store
from lienumba.groups.state import ALGEBRA, ELEMENT
from lienumba.integrators import codes
from lienumba.integrators.munthe_kaas import verdict
from lienumba.operations import maximum

# `kernels`: addresses in this order, 0 where the method has no such kernel; behind them combine0, combine1, ...
ORDER = ("step", "position", "velocity", "observe", "first", "stage", "advance")
STEP, POSITION, VELOCITY, OBSERVE, FIRST, STAGE, ADVANCE = range(len(ORDER))
OPTIONS: dict[str, Any] = {"nogil": True, "error_model": "numpy"}
ROW = 8 * W  # bytes

jit.register()  # `verdict` is a kernel


def scratch_rows(k: int, stages: int) -> int:
    """The rows of lanes that the driver needs beside the kernels' work."""
    return 3 * (24 * k + 4) + 4 + (ALGEBRA * k + 1) + ALGEBRA * stages * (k + 1) + 1


@njit(**OPTIONS)
def _commit(mask: Any, target: int, source: int, rows: int) -> None:
    """target = source in the lanes of the mask."""
    for row in range(rows):
        store(target, row, choose(mask, load(source, row), load(target, row)))


@njit(**OPTIONS)
def _copy(target: int, source: int, rows: int) -> None:
    for row in range(rows):
        store(target, row, load(source, row))


@njit(**OPTIONS)
def _record(
    record: int,
    observe: int,
    state: int,
    parameters: int,
    clock: int,
    work: int,
    rows: int,
    seen: int,
    alive: Any,
    counts: int,
) -> None:
    """Store state, observed rows and iteration counts; NaN in the lanes that are not alive."""
    call(observe, state, parameters, clock, 0, record + ROW * rows, work)
    _copy(record, state, rows)
    _copy(record + ROW * (rows + seen), counts, 2)
    for row in range(rows + seen + 2):
        store(record, row, choose(alive, load(record, row), splat(np.nan)))


@njit(**OPTIONS)
def _iterate(
    kernel: int,
    parameters: int,
    clock: int,
    hat: int,
    now: int,
    new: int,
    work: int,
    status: int,
    limit: int,
    tolerance: float,
    violation: int,
    committed: int,
) -> Any:
    """Iterate a projection until every lane is within the tolerance; returns each lane's iterations.

    `violation`: its row in `new`, followed by the code; `committed`: how many rows of `new` go to `now`.
    """  # fmt: skip
    used = splat(0.0)
    pending = load(status, 0) == 0.0
    for _ in range(limit):
        call(kernel, hat, parameters, clock, now, new, work)
        _commit(pending, now, new, committed)
        used = used + choose(pending, 1.0, 0.0)
        code = load(new, violation + 1)
        store(status, 0, choose(pending, choose(code == 0.0, load(status, 0), code), load(status, 0)))
        pending = pending & (load(status, 0) == 0.0) & (load(new, violation) > tolerance)
        if not any_lane(pending):
            return used
    store(status, 0, choose(pending, splat(codes.NOT_CONVERGED), load(status, 0)))
    return used


@njit(**OPTIONS)
def _staged_step(
    kernels: Any, k: int, nodes: Any, t: float, h: float, x: int, p: int, clock: int, new: int, u: int, slopes: int,
    work: int,
) -> None:  # fmt: skip
    """One step stage by stage, for mechanisms whose step is too long for one kernel; the code goes behind `new`.

    The kernels of one body put what they report behind the body's rows: it is read before the next body's call, whose
    rows begin there.
    """
    stages = nodes.size
    rotation, square, first, every = splat(0.0), splat(0.0), splat(1.0), splat(1.0)
    for s in range(stages):
        store(clock, 0, splat(t + nodes[s] * h))
        combine = kernels[len(ORDER) + s]
        for i in range(k if combine != 0 else 0):
            call(combine, 0, p, clock, slopes + ROW * ALGEBRA * stages * i, u + ROW * ALGEBRA * i, work)
            rotation = maximum(load(u, ALGEBRA * (i + 1)), rotation)
        call(kernels[STAGE if combine != 0 else FIRST], x, p, clock, u, slopes + ROW * ALGEBRA * s, work)
        every = every * load(slopes + ROW * ALGEBRA * s, ALGEBRA * stages * k)
        first = every if s == 0 else first
    for i in range(k):
        call(kernels[ADVANCE], x + ROW * ELEMENT * i, p, clock, slopes + ROW * ALGEBRA * stages * i,
             new + ROW * ELEMENT * i, work)  # fmt: skip
        rotation = maximum(load(new, ELEMENT * (i + 1)), rotation)
        square = square + load(new, ELEMENT * (i + 1) + 1)
    store(new, ELEMENT * k, verdict(rotation, square, first, every))


@cache.numba_cached(
    types.void(
        types.int64[::1], types.float64[::1], types.int64, types.int64, types.int64, types.int64, types.float64,
        types.float64,
        types.int64[::1], types.float64[:, :, ::1], types.float64[:, :, ::1], types.float64[:, :, :, ::1],
        types.float64[:, ::1], types.float64[:, ::1], types.float64[::1], types.int64[::1], types.int64[::1],
    ),
    **OPTIONS,
)  # fmt: skip
def drive(
    kernels: Any, nodes: Any, k: int, seen: int, steps: int, limit: int, h: float, tolerance: float, output_steps: Any,
    states: Any, parameters: Any, records: Any, statuses: Any, end_steps: Any, buffer: Any, progress: Any, stop: Any,
) -> None:  # fmt: skip
    """Integrate all blocks.

    states (blocks, 18 k, W): initial, left at the last good state; parameters (blocks, P, W), invariants prepared;
    records (blocks, outputs, 18 k + seen + 2, W): what is stored, at the steps `output_steps`;
    statuses (blocks, W): in, 0 for lanes that may run, out, the code; end_steps (blocks, W): the last good step;
    buffer: `scratch_rows` rows and the kernels' work; progress[0]: outputs done so far;
    stop[0]: set from outside to end early. Every array is contiguous.
    """
    rows = ELEMENT * k
    now = buffer.ctypes.data
    new = now + ROW * (24 * k + 4)
    hat = new + ROW * (24 * k + 4)
    clock = hat + ROW * (24 * k + 4)
    counts = clock + ROW * 2
    u = counts + ROW * 2
    slopes = u + ROW * (ALGEBRA * k + 1)
    work = slopes + ROW * (ALGEBRA * nodes.size * (k + 1) + 1)
    for block in range(states.shape[0]):
        x, p = states[block].ctypes.data, parameters[block].ctypes.data
        status, ends = statuses[block].ctypes.data, end_steps[block].ctypes.data
        store(counts, 0, splat(0.0))
        store(counts, 1, splat(0.0))
        store(ends, 0, splat(0.0))
        store(clock, 0, splat(0.0))
        store(clock, 1, splat(h))
        done = 0
        for n in range(steps + 1):
            if stop[0] != 0:
                return
            alive = load(status, 0) == 0.0
            if n > 0:
                if kernels[STEP] != 0:
                    store(clock, 0, splat((n - 1) * h))
                    call(kernels[STEP], x, p, clock, 0, new, work)
                else:
                    _staged_step(kernels, k, nodes, (n - 1) * h, h, x, p, clock, new, u, slopes, work)
                code = load(new, rows)
                store(status, 0, choose(alive, code, load(status, 0)))
                now, new = new, now
                if kernels[POSITION] != 0:
                    _copy(hat, now, rows)
                    for row in range(rows, rows + 6 * k):
                        store(now, row, splat(0.0))
                    used = _iterate(kernels[POSITION], p, clock, hat, now, new, work, status, limit, tolerance,
                                    rows + 6 * k, rows + 6 * k)  # fmt: skip
                    store(counts, 0, choose(used > load(counts, 0), used, load(counts, 0)))
                if kernels[VELOCITY] != 0:
                    used = _iterate(
                        kernels[VELOCITY], p, clock, now, now, new, work, status, limit, tolerance, rows, rows
                    )
                    store(counts, 1, choose(used > load(counts, 1), used, load(counts, 1)))
                alive = load(status, 0) == 0.0
                _commit(alive, x, now, rows)
                store(ends, 0, choose(alive, splat(float(n)), load(ends, 0)))
            if done < output_steps.size and output_steps[done] == n:
                record = records[block, done].ctypes.data
                store(clock, 0, splat(n * h))
                _record(record, kernels[OBSERVE], x, p, clock, work, rows, seen, alive, counts)
                store(counts, 0, splat(0.0))
                store(counts, 1, splat(0.0))
                done += 1
                progress[0] += 1
                if not any_lane(alive):
                    break
        for rest in range(done, output_steps.size):
            for row in range(rows + seen + 2):
                store(records[block, rest].ctypes.data, row, splat(np.nan))
        progress[0] += output_steps.size - done
