"""What all drivers are written with: the types of their arguments, and the addresses of the regions of their memory."""

from typing import Any, NamedTuple, Protocol

import numpy as np
from numba import njit
from numba.core import types

from lienumba.compiler import jit
from lienumba.compiler.rows import ROW
from lienumba.integrators.layout import Sizes, Workspace, workspace
from lienumba.numerics.number import Number

OPTIONS: dict[str, Any] = {"nogil": True, "error_model": "numpy", "no_cfunc_wrapper": True, "_nrt": False}
INLINE: dict[str, Any] = OPTIONS | {"forceinline": True}  # for what is done in each step: arguments cost more than code
SIZES: Any = types.NamedUniTuple(types.int64, len(Sizes._fields), Sizes)  # type: ignore[attr-defined]

jit.register()  # the functions of the layout, the verdict, the selection of rows

Address = int  # of a row of lanes
Lanes = Number  # one number per lane
Rows = np.ndarray  # (rows, W): memory as a lane is seen in it, one by one


class Mask(Protocol):
    """Some lanes."""

    def __and__(self, other: "Mask", /) -> "Mask": ...
    def __or__(self, other: "Mask", /) -> "Mask": ...


class Places(NamedTuple):
    """Where states are: one that a step has led to, and two iterates of its projections. What is computed anew for all
    lanes is not copied: it changes places with what it replaces."""

    new: Address
    now: Address
    following: Address


@njit(**OPTIONS)
def addresses(buffer: np.ndarray, sizes: Sizes) -> Workspace:
    """The regions in this buffer."""
    at, rows = buffer.ctypes.data, workspace(sizes)
    return Workspace(
        at + ROW * rows.state, at + ROW * rows.new, at + ROW * rows.slopes, at + ROW * rows.control,
        at + ROW * rows.now, at + ROW * rows.following, at + ROW * rows.clock, at + ROW * rows.lanes, at + ROW * rows.u,
        at + ROW * rows.conditions, at + ROW * rows.table, at + ROW * rows.parameters, at + ROW * rows.work,
    )  # fmt: skip
