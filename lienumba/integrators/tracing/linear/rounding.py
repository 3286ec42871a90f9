"""What rounding may make of the linear equations of runs, by how large what their numbers are sums of is."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from lienumba.compiler.dense.decompositions import accelerations, product, turned
from lienumba.compiler.terms import ROUNDED
from lienumba.integrators.tracing.linear.equations import Linear

Array = npt.NDArray[Any]
SMALL = 1e-13  # of the largest pivot of the masses, by their own sizes
ELIMINATED = 2e-15  # of masses times accelerations: what elimination may make of forces


@dataclass(frozen=True)
class Moves:
    """How a mechanism of masses M (runs, n, n) moves with the states x that are left of it: its places, rates and
    accelerations dq, dv and da (runs, n, size); rates: which of x are rates."""

    M: Array
    dq: Array
    dv: Array
    da: Array
    rates: slice

    def part(self, which: Array) -> "Moves":
        """Of these runs."""
        return Moves(self.M[which], self.dq[which], self.dv[which], self.da[which], self.rates)

    def only(self, kept: Array, rates: slice) -> "Moves":
        """With these of x alone, of which `rates` are those."""
        return Moves(self.M, self.dq[:, :, kept], self.dv[:, :, kept], self.da[:, :, kept], rates)

    def rounded(self, sums: Mapping[str, Array]) -> tuple[Array, Array]:
        """The inverse of the masses along what is free (runs, rates, rates), and what may be rounding of the forces
        there (runs, rates, size); sums: of forces by places and by rates, the terms (runs, n, n)."""
        W = self.dv[:, :, self.rates]
        along = turned(_spread(W))
        terms = ROUNDED * (product(sums["q"], _spread(self.dq)) + product(sums["v"], _spread(self.dv)))
        terms += ELIMINATED * product(np.abs(self.M), np.abs(self.da))
        reduced = product(turned(W), product(self.M, W))
        free = np.broadcast_to(np.eye(W.shape[2]), reduced.shape)
        inverse = accelerations(reduced, free, np.zeros(len(W), np.int64), SMALL)
        return _finite(inverse), _finite(product(along, terms))


def _finite(x: Array) -> Array:
    return np.where(np.isfinite(x), x, 0.0)


def _spread(x: Array) -> Array:
    """As large as the largest of its column wherever it is not 0: what is orthonormal is rounded as a whole."""
    found: Array = np.where(x != 0.0, np.abs(x).max(axis=1, keepdims=True), 0.0)
    return found


def scale(force: Array, at: Linear, rates: Array, sizes: Array) -> Array:
    """How fast (1/s) what forces are sums of (runs, n) could move something, or something moves (runs,)."""
    masses = np.abs(at.dense("along", "a", len(sizes)).diagonal(axis1=1, axis2=2)) * sizes
    with np.errstate(all="ignore"):
        found = force / masses
    largest = np.where(np.isfinite(found), found, 0.0).max(axis=1, initial=0.0)
    fastest: Array = np.maximum(np.sqrt(largest), np.abs(rates / sizes).max(axis=1, initial=0.0))
    return fastest
