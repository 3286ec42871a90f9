"""The one driver: advances blocks of W runs, step by step, by kernels that it gets as addresses.

It knows rows of lanes, not mechanics. Compiled once for all mechanisms. A run feels nothing of its neighbours: every
iteration is committed by lane, and a lane that fails is frozen while the others go on.
"""

from typing import Any

import numpy as np
from numba import njit
from numba.core import types

from lienumba.compiler import cache, jit
from lienumba.compiler.lanes import any_lane, call, choose, load, splat, store
from lienumba.compiler.rows import ROW, W
from lienumba.groups.state import ELEMENT
from lienumba.integrators import codes
from lienumba.integrators.exchange import WEAKENED, choose_rows
from lienumba.integrators.munthe_kaas import verdict
from lienumba.operations import maximum

# `kernels`: addresses in this order, 0 where the method has no such kernel; behind them combine0, combine1, ...
ORDER = ("step", "position", "velocity", "observe", "first", "stage", "advance", "finish", "exchange", "sample")
STEP, POSITION, VELOCITY, OBSERVE, FIRST, STAGE, ADVANCE, FINISH, EXCHANGE, SAMPLE = range(len(ORDER))
TIME, LENGTH, NODE, MIDDLE = range(4)  # rows of the clock: t, the length of the part of a step, c of a stage, and
# the time in the middle of the part, which tells in which piece of a table a stage lies
OPTIONS: dict[str, Any] = {"nogil": True, "error_model": "numpy", "no_cfunc_wrapper": True}

jit.register()  # `verdict` is a kernel


@njit(**OPTIONS)
def table_rows(q: int) -> int:
    """S, the scales, the masks, and which lanes are asked for (see `exchange.choose_rows`)."""
    return q * (q + 1) // 2 + 2 * q + 1


def scratch_rows(k: int, size: int, held: int, q: int, stages: int) -> int:
    """The rows of lanes that the driver needs beside the kernels' work."""
    return 3 * _state_rows(k, held) + 8 + (size * k + held + 1) + _slope_rows(k, size, stages) + table_rows(q)


@njit(**OPTIONS)
def _slope_rows(k: int, size: int, stages: int) -> int:
    """Of the slopes of all stages with what the stages report behind them, accelerations included."""
    return size * stages * (k + 1) + codes.REPORTS + 6 * k


@njit(**OPTIONS)
def _state_rows(k: int, held: int) -> int:
    """Of a state with what a kernel says behind it, or of a projection's iterate."""
    return 24 * k + held + 4


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
    pending: Any,
    limit: int,
    tolerance: float,
    violation: int,
    committed: int,
) -> Any:
    """Iterate a projection until every pending lane is within the tolerance; returns each lane's iterations.

    `violation`: its row in `new`, followed by the code; `committed`: how many rows of `new` go to `now`.
    """  # fmt: skip
    used = splat(0.0)
    for _ in range(limit):
        if not any_lane(pending):
            return used
        call(kernel, hat, parameters, clock, now, new, work)
        _commit(pending, now, new, committed)
        used = used + choose(pending, 1.0, 0.0)
        code = load(new, violation + 1)
        store(status, 0, choose(pending, choose(code == 0.0, load(status, 0), code), load(status, 0)))
        pending = pending & (load(status, 0) == 0.0) & (load(new, violation) > tolerance)
    store(status, 0, choose(pending, splat(codes.NOT_CONVERGED), load(status, 0)))
    return used


@njit(**OPTIONS)
def _exchange(
    kernel: int, state: int, p: int, clock: int, lanes: Any, work: int, table: Any, q: int, target: int, first: int
) -> Any:
    """Choose the constraint rows anew at a state in these lanes; the masks go to `target`, its rows from `first`.
    Returns in which lanes they are others than before."""
    address = table.ctypes.data
    masks, asked = q * (q + 1) // 2 + q, q * (q + 1) // 2 + 2 * q
    call(kernel, state, p, clock, 0, address, work)
    for i in range(q):
        store(address, masks + i, load(target, first + i))
    store(address, asked, choose(lanes, splat(1.0), splat(0.0)))
    for lane in range(W):
        if table[asked, lane] != 0.0:
            choose_rows(table, lane, q)
    same = splat(1.0)
    for i in range(q):
        mask = choose(lanes, load(address, masks + i), load(target, first + i))
        same = choose(mask == load(target, first + i), same, 0.0)
        store(target, first + i, mask)
    store(target, first + q, choose(lanes, splat(0.0), load(target, first + q)))
    return same == 0.0


@njit(**OPTIONS)
def _project(
    kernels: Any, k: int, held: int, q: int, masks: int, p: int, clock: int, new: int, now: int, following: int,
    work: int, status: int, pending: Any, table: Any, limit: int, tolerance: float, fixed: bool,
) -> Any:  # fmt: skip
    """Project the positions of `new` in the pending lanes; returns each lane's iterations.

    Where it does not converge, a constraint that said the same as others may have begun to say something of its own:
    the rows are chosen anew where the iteration has come to, and it starts again; with fixed rows that is for another
    program to do.
    """
    rows = ELEMENT * k
    used = splat(0.0)
    for attempt in range(2):
        _copy(now, new, rows)
        for row in range(rows, rows + 6 * k):
            store(now, row, splat(0.0))
        used = used + _iterate(kernels[POSITION], p, clock, new, now, following, work, status, pending, limit,
                               tolerance, rows + 6 * k, rows + 6 * k)  # fmt: skip
        _commit(pending & (load(status, 0) == 0.0), new, now, rows)
        pending = pending & (load(status, 0) == codes.NOT_CONVERGED)
        if attempt == 1 or q == 0 or not any_lane(pending):
            break
        _copy(now + ROW * rows, new + ROW * rows, held)
        others = _exchange(kernels[EXCHANGE], now, p, clock, pending, work, table, q, new, masks)
        if fixed:
            store(status, 0, choose(others, codes.EXCHANGED, load(status, 0)))
            break
        store(status, 0, choose(pending, splat(0.0), load(status, 0)))
    return used


@njit(**OPTIONS)
def _staged_step(
    kernels: Any, k: int, size: int, held: int, nodes: Any, x: int, p: int, clock: int, new: int, u: int, slopes: int,
    work: int,
) -> None:  # fmt: skip
    """One step stage by stage, for mechanisms whose step is too long for one kernel; code and margin go behind `new`.

    The kernels of one body put what they report behind the body's rows: it is read before the next body's call, whose
    rows begin there.
    """
    stages = nodes.size
    t, h = load(clock, TIME), load(clock, LENGTH)
    rotation, square, first, every = splat(0.0), splat(0.0), splat(1.0), splat(1.0)
    said = slopes + ROW * size * stages * k
    for s in range(stages):
        store(clock, TIME, t + nodes[s] * h)
        store(clock, NODE, splat(nodes[s]))
        combine = kernels[len(ORDER) + s]
        for i in range(k if combine != 0 else 0):
            call(combine, 0, p, clock, slopes + ROW * size * stages * i, u + ROW * size * i, work)
            rotation = maximum(load(u, size * (i + 1)), rotation)
        call(kernels[STAGE if combine != 0 else FIRST], x, p, clock, u, slopes + ROW * size * s, work)
        every = every * load(said, size * s)
        first = every if s == 0 else first
    for i in range(k):
        call(kernels[ADVANCE], x + ROW * ELEMENT * i, p, clock, slopes + ROW * size * stages * i,
             new + ROW * ELEMENT * i, work)  # fmt: skip
        rotation = maximum(load(new, ELEMENT * (i + 1)), rotation)
        square = square + load(new, ELEMENT * (i + 1) + 1)
    rows = ELEMENT * k
    _copy(new + ROW * rows, x + ROW * rows, held)
    if held > 0:
        call(kernels[FINISH], new, p, clock, slopes, u, work)
        _copy(new + ROW * rows, u, held)
    store(new, rows + held, verdict(rotation, square, first, every))
    store(new, rows + held + 1, load(said, 2))


@njit(**OPTIONS)
def _next_landing(times: Any, landings: Any, passed: Any, end: float) -> bool:
    """The end of the next part of a step in each lane: at the end of the step, or at a time on which it has to land.
    times: since when, until when. Returns whether any lane lands."""
    landed = False
    for lane in range(W):
        while landings[passed[lane], lane] <= times[0, lane]:
            passed[lane] += 1
        landed = landed or landings[passed[lane], lane] <= end
        times[1, lane] = min(landings[passed[lane], lane], end)
    return landed


@njit(**OPTIONS)
def _set_clock(clock: int, since: int, until: int, begin: float, end: float, h: float) -> None:
    """The clock of a part of a step. A step that is not cut is h long, whatever its ends round to."""
    t, to = load(since, 0), load(until, 0)
    length = choose((to == end) & (t == begin), splat(h), to - t)
    store(clock, TIME, t)
    store(clock, LENGTH, length)
    store(clock, MIDDLE, t + 0.5 * length)


@cache.numba_cached(
    types.void(
        types.int64[::1], types.float64[::1], types.int64, types.int64, types.int64, types.int64, types.int64,
        types.boolean, types.int64, types.int64, types.int64, types.float64, types.float64,
        types.int64[::1], types.float64[:, :, ::1], types.float64[:, :, ::1], types.float64[:, :, ::1],
        types.float64[:, :, :, ::1], types.float64[:, ::1], types.float64[:, ::1], types.float64[::1],
        types.int64[::1], types.int64[::1],
    ),
    **OPTIONS,
)  # fmt: skip
def drive(
    kernels: Any, nodes: Any, k: int, size: int, held: int, first_mask: int, q: int, fixed: bool, seen: int,
    steps: int, limit: int, h: float, tolerance: float, output_steps: Any, states: Any, parameters: Any, landings: Any,
    records: Any, statuses: Any, end_steps: Any, buffer: Any, progress: Any, stop: Any,
) -> None:  # fmt: skip
    """Integrate all blocks.

    states (blocks, 18 k + held, W): initial, left at the last good state; size: the coordinates of each of k elements
    in a step; q: how many rows of C may be exchanged, their masks from row `first_mask` of what is held, which is
    `fixed` if only those in use are compiled;
    parameters (blocks, P, W), invariants prepared; landings (blocks, L, W): the times on which a step must land, those
    of a lane ascending, and an infinite one last;
    records (blocks, outputs, 18 k + held + seen + 2, W): what is stored, at the steps `output_steps`;
    statuses (blocks, W): in, 0 for lanes that may run, out, the code; end_steps (blocks, W): the last good step;
    buffer: `scratch_rows` rows and the kernels' work; progress[0]: outputs done so far;
    stop[0]: set from outside to end early. Every array is contiguous.
    """
    rows = ELEMENT * k
    masks = rows + first_mask
    new = buffer.ctypes.data
    now = new + ROW * _state_rows(k, held)
    following = now + ROW * _state_rows(k, held)
    clock = following + ROW * _state_rows(k, held)
    counts = clock + ROW * 4
    since = counts + ROW * 2
    until = since + ROW
    times = buffer[(since - new) // 8 : (since - new) // 8 + 2 * W].reshape((2, W))
    u = until + ROW
    slopes = u + ROW * (size * k + held + 1)
    exchanged = (slopes - new) // 8 + W * _slope_rows(k, size, nodes.size)
    table = buffer[exchanged : exchanged + W * table_rows(q)].reshape((table_rows(q), W))
    work = table.ctypes.data + ROW * table_rows(q)
    passed, cuts = np.zeros(W, np.int64), landings.shape[1] > 1  # passed: landings of each lane
    for block in range(states.shape[0]):
        x, p = states[block].ctypes.data, parameters[block].ctypes.data
        ours = landings[block]
        status, ends = statuses[block].ctypes.data, end_steps[block].ctypes.data
        store(counts, 0, splat(0.0))
        store(counts, 1, splat(0.0))
        store(ends, 0, splat(0.0))
        store(clock, TIME, splat(0.0))
        store(since, 0, splat(0.0))
        passed[:] = 0
        if kernels[SAMPLE] != 0:
            call(kernels[SAMPLE], x, p, clock, 0, new, work)
            _commit(load(status, 0) == 0.0, x, new, rows)
        done = 0
        for n in range(steps + 1):
            if stop[0] != 0:
                return
            alive = load(status, 0) == 0.0
            going = alive & (load(since, 0) < n * h)
            while any_lane(going):
                landed = cuts and _next_landing(times, ours, passed, n * h)
                if not cuts:
                    store(until, 0, splat(n * h))
                _set_clock(clock, since, until, (n - 1) * h, n * h, h)
                if kernels[STEP] != 0:
                    call(kernels[STEP], x, p, clock, 0, new, work)
                else:
                    _staged_step(kernels, k, size, held, nodes, x, p, clock, new, u, slopes, work)
                store(clock, TIME, load(until, 0))
                code = load(new, rows + held)
                margin = load(new, rows + held + 1)
                store(status, 0, choose(going, code, load(status, 0)))
                if kernels[POSITION] != 0:
                    used = _project(kernels, k, held, q, masks, p, clock, new, now, following, work, status,
                                    going & (load(status, 0) == 0.0), table, limit, tolerance, fixed)  # fmt: skip
                    store(counts, 0, choose(used > load(counts, 0), used, load(counts, 0)))
                if kernels[VELOCITY] != 0:
                    used = _iterate(kernels[VELOCITY], p, clock, new, new, following, work, status,
                                    going & (load(status, 0) == 0.0), limit, tolerance, rows, rows)  # fmt: skip
                    store(counts, 1, choose(used > load(counts, 1), used, load(counts, 1)))
                good = going & (load(status, 0) == 0.0)
                _commit(good, x, new, rows + held)
                if q > 0:
                    weak = good & (margin < WEAKENED * load(x, masks + q))
                    if any_lane(weak):
                        others = _exchange(kernels[EXCHANGE], x, p, clock, weak, work, table, q, x, masks)
                        if fixed:
                            store(status, 0, choose(others, codes.EXCHANGED, load(status, 0)))
                if landed and kernels[SAMPLE] != 0:
                    call(kernels[SAMPLE], x, p, clock, 0, new, work)
                    _commit(good, x, new, rows)
                store(since, 0, choose(good, load(until, 0), load(since, 0)))
                going = good & (load(since, 0) < n * h)
            store(clock, TIME, splat(n * h))
            alive = load(status, 0) == 0.0
            store(ends, 0, choose(alive, splat(float(n)), load(ends, 0)))
            if done < output_steps.size and output_steps[done] == n:
                record = records[block, done].ctypes.data
                _record(record, kernels[OBSERVE], x, p, clock, work, rows + held, seen, alive, counts)
                store(counts, 0, splat(0.0))
                store(counts, 1, splat(0.0))
                done += 1
                progress[0] += 1
                if not any_lane(alive):
                    break
        for rest in range(done, output_steps.size):
            for row in range(rows + held + seen + 2):
                store(records[block, rest].ctypes.data, row, splat(np.nan))
        progress[0] += output_steps.size - done
