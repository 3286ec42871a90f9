"""Steps with the tangents of the state: how it changes with each input, which are the lanes.

All lanes have the values of one run, so no lane decides for itself. Kernels are those of
`lienumba.integrators.tracing.tangents`: `shift` rows behind a value is its tangent.
"""

from typing import NamedTuple

from lienumba.compiler.lanes import Address, any_lane, call, load, splat, store
from lienumba.compiler.routines.marks import Floats1, Floats2, Floats3, Integers1, apart, inlined
from lienumba.compiler.rows import ROW
from lienumba.integrators import layout
from lienumba.integrators.drivers.stages import copy
from lienumba.integrators.sizes import Sizes

ITERATIONS, TANGENT_ITERATIONS = 20, 10  # of implicit stages
CHANGE = 1e-26  # of the last iterate, squared, by the numbers of a state
SETTLING = 2  # iterations of a projection that follow once its values have converged: tangents lag behind


class Memory(NamedTuple):
    """Addresses: state and parameters of the run, a new state, two iterates, the argument of a stage, slopes, the
    clock, and the work of kernels."""

    state: int
    parameters: int
    new: int
    now: int
    following: int
    u: int
    slopes: int
    clock: int
    work: int


class Steps(NamedTuple):
    """times (5, steps): begin, end and length (s) of each, the record that its end fills, or -1, and whether the state
    goes on from there; tangents (2, lanes): of the time when the first one begins, and when the last one ends; records
    (records, rows, lanes)."""

    times: Floats2
    tangents: int
    records: Floats3


class Limits(NamedTuple):
    """Of the projections: how many iterations, and the tolerance."""

    iterations: int
    tolerance: float


def march(
    kernels: Integers1, nodes: Floats1, sizes: Sizes, memory: Memory, steps: Steps, limits: Limits, shift: int
) -> None:
    """Advance the state and its tangents by some steps with their projections."""
    rows, clock = layout.state_rows(sizes), memory.clock
    count, begins = steps.times.shape[1], load(steps.tangents, 0)
    for n in range(count):
        ends = splat(0.0)
        if n == count - 1:
            ends = load(steps.tangents, 1)
        t, until, h = steps.times[0, n], steps.times[1, n], steps.times[2, n]
        store(clock, layout.LENGTH, splat(h))
        store(clock, layout.MIDDLE, splat(t + 0.5 * h))
        store(clock, layout.CLOCK + layout.LENGTH, ends - begins)
        if kernels[layout.NEWTON] != 0:
            store(clock, layout.TIME, splat(t))
            store(clock, layout.CLOCK + layout.TIME, begins)
            _solve(kernels, sizes, memory, shift)
        else:
            for s in range(sizes.stages):
                _stage(kernels, sizes, memory, shift, s, nodes[s], t, begins)
        store(clock, layout.TIME, splat(until))
        store(clock, layout.CLOCK + layout.TIME, ends)
        if kernels[layout.NEWTON] == 0:
            _advance(kernels, sizes, memory, shift)
        if kernels[layout.POSITION] != 0:
            _project_positions(kernels, sizes, memory, limits, shift)
        if kernels[layout.VELOCITY] != 0:
            _project_velocities(kernels, sizes, memory, limits, shift)
        if steps.times[3, n] >= 0.0:
            record = steps.records[int(steps.times[3, n])].ctypes.data
            copy(record, memory.new + ROW * shift, rows)
            if kernels[layout.OBSERVE] != 0:
                call(kernels[layout.OBSERVE], memory.new, memory.parameters, clock, 0, memory.now, memory.work)
                copy(record + ROW * rows, memory.now + ROW * shift, sizes.observed)
        if steps.times[4, n] != 0.0:
            _both(memory.state, memory.new, rows, shift)
            begins = splat(0.0)


@inlined
def _both(target: Address, source: Address, rows: int, shift: int) -> None:
    """Copy values and tangents."""
    copy(target, source, rows)
    copy(target + ROW * shift, source + ROW * shift, rows)


@apart
def _solve(kernels: Integers1, sizes: Sizes, memory: Memory, shift: int) -> None:
    """A step by collocation: its stages by Newton's method from nothing, then their tangents, by the last matrix."""
    rows, slopes = sizes.iterate, memory.slopes
    now, following = slopes + ROW * layout.iterate_row(sizes), slopes + ROW * layout.following_row(sizes)
    for n in range(layout.TOLERANCES):
        store(memory.clock, layout.TOLERANCE + n, splat(1.0))
    for row in range(rows):
        store(now, row, splat(0.0))
        store(now, shift + row, splat(0.0))
    going = True
    for _ in range(ITERATIONS):
        if going:
            call(kernels[layout.NEWTON], memory.state, memory.parameters, memory.clock, slopes, slopes, memory.work)
            copy(now, following, rows)
            going = any_lane(load(following, rows + layout.CHANGE) > CHANGE)
    for _ in range(TANGENT_ITERATIONS):
        call(kernels[layout.SIMPLIFIED], memory.state, memory.parameters, memory.clock, slopes, slopes, memory.work)
        _both(now, following, rows, shift)
    call(kernels[layout.STEP], memory.state, memory.parameters, memory.clock, slopes, memory.new, memory.work)


@apart
def _stage(
    kernels: Integers1, sizes: Sizes, memory: Memory, shift: int, s: int, node: float, t: float, begins: float
) -> None:
    """The slopes of a stage."""
    size, clock, combine = sizes.coordinates, memory.clock, kernels[layout.COMBINE + s]
    h, changes = load(clock, layout.LENGTH), load(clock, layout.CLOCK + layout.LENGTH)
    store(clock, layout.TIME, splat(t) + node * h)
    store(clock, layout.CLOCK + layout.TIME, begins + node * changes)
    store(clock, layout.NODE, splat(node))
    for i in range(sizes.elements):
        u = memory.u + ROW * size * i
        if combine != 0:
            slopes = memory.slopes + ROW * layout.slope_row(sizes, i, 0)
            call(combine, 0, memory.parameters, clock, slopes, u, memory.work)
        else:
            for row in range(size):
                store(u, row, splat(0.0))
                store(u, shift + row, splat(0.0))
    slopes = memory.slopes + ROW * layout.slope_row(sizes, 0, s)
    call(kernels[layout.STAGE], memory.state, memory.parameters, clock, memory.u, slopes, memory.work)


@apart
def _advance(kernels: Integers1, sizes: Sizes, memory: Memory, shift: int) -> None:
    """The state behind a step."""
    for i in range(sizes.elements):
        element = ROW * sizes.element * i
        slopes = memory.slopes + ROW * layout.slope_row(sizes, i, 0)
        call(
            kernels[layout.ADVANCE],
            memory.state + element,
            memory.parameters,
            memory.clock,
            slopes,
            memory.new + element,
            memory.work,
        )
    if sizes.augmented > 0:
        behind = ROW * layout.element_rows(sizes)
        _both(memory.new + behind, memory.state + behind, sizes.augmented, shift)
        call(kernels[layout.FINISH], memory.new, memory.parameters, memory.clock, memory.slopes, memory.u, memory.work)
        _both(memory.new + behind, memory.u, sizes.augmented, shift)


@apart
def _project_positions(kernels: Integers1, sizes: Sizes, memory: Memory, limits: Limits, shift: int) -> None:
    rows, now, following = layout.element_rows(sizes), memory.now, memory.following
    iterated = rows + sizes.correction
    _both(now, memory.new, rows, shift)
    for row in range(rows, iterated):
        store(now, row, splat(0.0))
        store(now, shift + row, splat(0.0))
    left = SETTLING
    for _ in range(limits.iterations + SETTLING):
        if left > 0:
            call(kernels[layout.POSITION], memory.new, memory.parameters, memory.clock, now, following, memory.work)
            if not any_lane(load(following, iterated + layout.VIOLATION) > limits.tolerance):
                left -= 1
            now, following = following, now
    _both(memory.new, now, rows, shift)


@apart
def _project_velocities(kernels: Integers1, sizes: Sizes, memory: Memory, limits: Limits, shift: int) -> None:
    rows, left = layout.element_rows(sizes), SETTLING - 1
    for _ in range(limits.iterations + SETTLING):
        if left > 0:
            call(kernels[layout.VELOCITY], memory.new, memory.parameters, memory.clock, 0, memory.now, memory.work)
            if not any_lane(load(memory.now, rows + layout.VIOLATION) > limits.tolerance):
                left -= 1
            _both(memory.new, memory.now, rows, shift)
