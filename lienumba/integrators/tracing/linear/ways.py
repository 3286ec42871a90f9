"""Ways along which a mechanism is stiff by one number each: the eigenvectors of its stiffness, in each run.

Each is judged by itself, so that nothing is said of a soft spring by a stiff one beside it: whether anything holds what
moves along it, and whether what pushes along it is more than rounding.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from lienumba.compiler.dense.decompositions import product, symmetric, turned

Array = npt.NDArray[Any]
QUIET = 1e-12  # rad, and of the size: how far forces may push where they are rounding
TURNED = 10.0  # times a force: what is stiff by no more may be so because the force turns with what it moves
EDGE = 1e-14  # of directions: what is rounding
SMALL = 1e-12  # of the largest of its kind: what counts as 0


@dataclass(frozen=True)
class Ways:
    """V (runs, n, n): in its columns; values (runs, n): how stiff each is; free (runs, n): which ones are no
    constraint's; flat, held (runs, n): whether it may be rounding, and is more than that; unmoved (runs, n): where what
    pushes may be rounding; excess (runs,): what pushes most elsewhere; largest (runs,): stiffness, laws' included."""

    V: Array
    values: Array
    free: Array
    flat: Array
    held: Array
    unmoved: Array
    excess: Array
    largest: Array

    @staticmethod
    def of(K: Array, rounded: Array, noise: Array, along: Array, force: Array, by_laws: Array, rank: Array) -> "Ways":
        """K (runs, n, n): the stiffness, the first `rank` rows and columns of which constraints decide; rounded, noise
        (runs, n): what may be rounding of it, and of forces; along (runs, n): forces, the largest of which is `force`;
        by_laws: as K, sizes of what laws do as their states follow places."""
        values, V = (np.nan_to_num(x) for x in symmetric(0.5 * (K + turned(K)), rank))
        largest = np.maximum(np.abs(values).max(axis=1, initial=0.0), by_laws.max(axis=(1, 2), initial=0.0))
        far, free = np.abs(V), np.arange(K.shape[1]) >= rank[:, None]
        push = np.abs(product(turned(V), along))
        level = (far * product(rounded, far)).sum(axis=1) + TURNED * force[:, None]
        rounding = product(turned(far), rounded.sum(axis=2) + noise)
        holds = np.maximum(np.abs(values), (far * product(by_laws, far)).sum(axis=1))
        unmoved = push <= QUIET * holds + rounding
        excess = np.where(unmoved | ~free, 0.0, push).max(axis=1, initial=0.0)
        return Ways(V, values, free, np.abs(values) <= level, values > level, unmoved, excess, largest)

    @property
    def least(self) -> Array:
        """The least stiffness of any that has one (runs,)."""
        return np.where(self.free & ~self.flat, np.abs(self.values), np.inf).min(axis=1, initial=np.inf)

    @property
    def unheld(self) -> Array:
        """Where nothing holds what nothing but rounding pushes, as on a top, or where all is turned about an axis."""
        return self.free & ~self.held & self.unmoved

    def falling(self, but: Array) -> Array:
        """How much the stiffness is below 0 where it is most, but for some ways (runs,)."""
        found: Array = -np.where(self.held | but, 0.0, self.values).min(axis=1, initial=0.0)
        return found

    def onto(self, which: Array) -> Array:
        """The projection onto some of them (runs, n, n)."""
        if not which.any():
            return np.zeros(self.V.shape)
        found = product(self.V * which[:, None, :], turned(self.V))
        return np.where(np.abs(found) <= EDGE, 0.0, np.where(np.abs(found - 1.0) <= EDGE, 1.0, found))

    def felt(self, S: Array, L: Array) -> Array:
        """Along which ones states of laws push (S: runs, n, s), or are changed (L: runs, s, n)."""
        if not S.shape[2]:
            return np.zeros(self.values.shape, bool)
        pushed, changes = np.abs(product(turned(self.V), S)), np.abs(product(L, self.V))
        found: Array = (pushed > SMALL * pushed.max(axis=(1, 2), keepdims=True)).any(axis=2)
        return found | (changes > SMALL * changes.max(axis=(1, 2), keepdims=True)).any(axis=1)

    def balanced(self, K: Array, rounded: Array, S: Array, L: Array, stands: Array, still: Array) -> Array:
        """Along which ones no force changes, as where all turns about the axis, but states of laws push that nothing
        changes (stands: runs, s), as of a motor that is at its speed: these are what balances forces. still (runs, s):
        what is 0 of a rate."""
        if not S.shape[2]:
            return np.zeros(self.values.shape, bool)
        rounding = product(rounded, np.abs(self.V)).sum(axis=1)
        changes = np.maximum(np.abs(product(K, self.V)).max(axis=1), np.abs(product(turned(K), self.V)).max(axis=1))
        unchanged = np.asarray((np.abs(product(L, self.V)) <= still[:, :, None]).all(axis=1))
        pushed = np.abs(product(turned(self.V), np.where(stands[:, None, :], S, 0.0)))
        pushes = np.asarray((pushed > SMALL * np.abs(S).max(axis=(1, 2), keepdims=True)).any(axis=2))
        found: Array = self.free & (changes <= rounding) & unchanged & pushes
        return found
