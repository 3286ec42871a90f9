"""What the functions of drivers carry: the compiled mechanism, its events and contacts, and the memory of a driver."""

from typing import NamedTuple, cast

import numpy as np

from lienumba.compiler.lanes import Address
from lienumba.compiler.routines.marks import Floats1, Floats2, Integers1, Integers2, apart
from lienumba.compiler.rows import ROW
from lienumba.integrators.layout import Workspace, workspace
from lienumba.integrators.sizes import Sizes

Rows = np.ndarray  # (rows, W): memory as a lane is seen in it, one by one


class Places(NamedTuple):
    """Where states are: one that a step has led to, and two iterates of its projections. What is computed anew for all
    lanes is not copied: it changes places with what it replaces."""

    new: Address
    now: Address
    following: Address


class Plan(NamedTuple):
    """What events do, and what the rows of contacts and of measures are.

    stops (events,): whether an event ends a run; acts (events, 7): see `layout.ACTION`; targets: of all events;
    switches (s, 8): see `layout.SWITCH_KIND`; kept (n, 6): see `KEPT_NUMBERS`; guards: the signals at whose zeros
    records have breakpoints, those of each record side by side; straight (signals,): whether one has no kinks.
    """

    stops: Integers1
    acts: Integers2
    targets: Integers1
    switches: Integers2
    kept: Integers2
    guards: Integers1
    straight: Integers1


NO_PLAN = cast(Plan, None)  # of a driver in which nothing happens, and nothing is measured


class Context(NamedTuple):
    """What is the same in all steps of a driver.

    kernels: addresses, see `layout.ORDER`; nodes: c of all stages; limit, tolerance: of the projections; at: the
    regions of memory as addresses, first: their first rows in `rows`; table: in which constraint rows are selected.
    """

    kernels: Integers1
    nodes: Floats1
    sizes: Sizes
    plan: Plan
    limit: int
    tolerance: float
    at: Workspace
    first: Workspace
    rows: Floats2
    table: Floats2


@apart
def addresses(buffer: np.ndarray, sizes: Sizes) -> Workspace:
    """The regions in this buffer."""
    at, rows = buffer.ctypes.data, workspace(sizes)
    return Workspace(
        at + ROW * rows.state, at + ROW * rows.new, at + ROW * rows.slopes, at + ROW * rows.control,
        at + ROW * rows.now, at + ROW * rows.following, at + ROW * rows.clock, at + ROW * rows.lanes, at + ROW * rows.u,
        at + ROW * rows.conditions, at + ROW * rows.table, at + ROW * rows.change, at + ROW * rows.measures,
        at + ROW * rows.parameters, at + ROW * rows.work,
    )  # fmt: skip
