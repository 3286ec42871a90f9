"""What all drivers are written with: the addresses of the regions of their memory."""

from typing import NamedTuple

import numpy as np

from lienumba.compiler.lanes import Address
from lienumba.compiler.routines.marks import apart
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
