"""The one driver: advances blocks of W runs, step by step, by kernels that it gets as addresses.

It knows rows of lanes, not mechanics. Compiled once for all mechanisms. A run feels nothing of its neighbours: every
iteration is committed by lane, and a lane that fails is frozen while the others go on.
"""

from typing import Any

import numpy as np
from numba import njit
from numba.core import types

from lienumba.compiler import cache
from lienumba.compiler.emit import W
from lienumba.compiler.lanes import any_lane, call, choose, load, splat, store
from lienumba.groups.state import ELEMENT
from lienumba.integrators import codes

# rows of `kernels`: addresses, 0 where the method has no such kernel
STEP, POSITION, VELOCITY, OBSERVE, KERNELS = 0, 1, 2, 3, 4
OPTIONS: dict[str, Any] = {"nogil": True, "error_model": "numpy"}


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
    call(observe, state, parameters, clock, 0, record + 8 * W * rows, work)
    _copy(record, state, rows)
    _copy(record + 8 * W * (rows + seen), counts, 2)
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


@cache.numba_cached(
    types.void(
        types.int64[::1], types.int64, types.int64, types.int64, types.int64, types.float64, types.float64,
        types.int64[::1], types.float64[:, :, ::1], types.float64[:, :, ::1], types.float64[:, :, :, ::1],
        types.float64[:, ::1], types.float64[:, ::1], types.float64[::1], types.int64[::1], types.int64[::1],
    ),
    **OPTIONS,
)  # fmt: skip
def drive(
    kernels: Any, k: int, seen: int, steps: int, limit: int, h: float, tolerance: float, output_steps: Any,
    states: Any, parameters: Any, records: Any, statuses: Any, end_steps: Any, buffer: Any, progress: Any, stop: Any,
) -> None:  # fmt: skip
    """Integrate all blocks.

    states (blocks, 18 k, W): initial, left at the last good state; parameters (blocks, P, W), invariants prepared;
    records (blocks, outputs, 18 k + seen + 2, W): what is stored, at the steps `output_steps`;
    statuses (blocks, W): in, 0 for lanes that may run, out, the code; end_steps (blocks, W): the last good step;
    buffer: scratch of at least 4 (24 k + 4) W doubles and the kernels' work; progress[0]: outputs done so far;
    stop[0]: set from outside to end early. Every array is contiguous.
    """
    rows = ELEMENT * k
    size = 8 * W * (rows + 6 * k + 4)
    now, new, hat, clock = buffer.ctypes.data, 0, 0, 0
    new, hat, clock = now + size, now + 2 * size, now + 3 * size
    counts, work = clock + 8 * W * 2, clock + 8 * W * 4
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
                store(clock, 0, splat((n - 1) * h))
                call(kernels[STEP], x, p, clock, 0, new, work)
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
