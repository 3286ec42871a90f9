"""The memory of a driver: rows of lanes, one region behind the other."""

from typing import Any, NamedTuple

from numba import njit
from numba.core import types

from lienumba.compiler.rows import ROW
from lienumba.groups.state import ELEMENT
from lienumba.integrators import codes

OPTIONS: dict[str, Any] = {"nogil": True, "error_model": "numpy", "no_cfunc_wrapper": True}
LANES = 17  # rows of what a driver knows of each lane: see `driver` and `free_lanes`


class Sizes(NamedTuple):
    """Of a machine, all whole numbers.

    elements: of S; held: rows behind them; first_mask: the row there of the first mask of the q rows of C that may be
    exchanged; fixed: whether only those in use are compiled; seen: rows that are observed; parameters: rows of them;
    slope: coordinates of an element in a step; stages: of a step, slots: of slopes that are kept of an element; events;
    correction: rows of an iterate of the position projection between its state and its violation; kept: behind it.
    """

    elements: int
    held: int
    first_mask: int
    q: int
    fixed: int
    seen: int
    parameters: int
    slope: int
    stages: int
    slots: int
    events: int
    correction: int
    kept: int


SIZES: Any = types.NamedUniTuple(types.int64, len(Sizes._fields), Sizes)  # type: ignore[attr-defined]


class Scratch(NamedTuple):
    """The first row of each region; as addresses in a driver.

    state, parameters: of the runs in the lanes; new: a state with what a kernel says behind it; slopes: see
    `slope_row`; control: what is said of the error of a step, and behind it accelerations that stages report; now,
    following: iterates of a projection; u: the argument of a stage; conditions: of events, at the start and at the end
    of a step, and when they come true; table: see `exchange.choose_rows`; work: of the kernels.
    """

    state: int
    new: int
    slopes: int
    control: int
    now: int
    following: int
    clock: int
    lanes: int
    u: int
    conditions: int
    table: int
    parameters: int
    work: int


@njit(**OPTIONS)
def table_rows(q: int) -> int:
    """S, the scales, the masks, and which lanes are asked for (see `exchange.choose_rows`)."""
    return q * (q + 1) // 2 + 2 * q + 1


@njit(**OPTIONS)
def state_rows(sizes: Sizes) -> int:
    """Of a state with what a kernel says behind it; slopes lie behind `new`."""
    return ELEMENT * sizes.elements + sizes.held + 4


@njit(**OPTIONS)
def slope_row(sizes: Sizes, element: int, slot: int) -> int:
    """The first row of a slope: all of an element side by side; behind those of all elements, at the same distances,
    lies what each stage reports."""
    return sizes.slope * (sizes.slots * element + slot)


@njit(**OPTIONS)
def layout(sizes: Sizes) -> Scratch:
    """The first row of each region."""
    k = sizes.elements
    state = state_rows(sizes)
    new = state
    slopes = new + state
    control = slopes + slope_row(sizes, k + 1, 0) + codes.REPORTS
    reported = control + codes.CONTROL
    now = reported + sizes.slope * sizes.slots + 6 * k
    following = now + state + sizes.correction
    clock = following + state + sizes.correction + sizes.kept
    lanes = clock + codes.CLOCK
    u = lanes + LANES
    conditions = u + sizes.slope * k + sizes.held + 1
    table = conditions + 3 * sizes.events
    parameters = table + table_rows(sizes.q)
    work = parameters + sizes.parameters
    return Scratch(0, new, slopes, control, now, following, clock, lanes, u, conditions, table, parameters, work)


@njit(**OPTIONS)
def addresses(buffer: Any, sizes: Sizes) -> Scratch:
    """The regions in this buffer."""
    at, rows = buffer.ctypes.data, layout(sizes)
    return Scratch(
        at + ROW * rows.state, at + ROW * rows.new, at + ROW * rows.slopes, at + ROW * rows.control,
        at + ROW * rows.now, at + ROW * rows.following, at + ROW * rows.clock, at + ROW * rows.lanes, at + ROW * rows.u,
        at + ROW * rows.conditions, at + ROW * rows.table, at + ROW * rows.parameters, at + ROW * rows.work,
    )  # fmt: skip
