"""From partial derivatives to the linear system of a mechanism in as many coordinates as it has freedoms.

Small changes of a motion obey

    dq' = dv + Gamma dq,                         M da + C^T dmu = F_q dq + F_v dv + F_s ds + F_u du,
    C_p dq = P_u du,  C dv = -H_q dq - H_u du,   C da = G_q dq + G_v dv + G_u du,      dv' = da + Lambda dv,

in coordinates whose axes turn so that Gamma and Lambda are what remains of their turning. Where rows of C are redundant
the null space has no part of them. Some of the numbers of dq and dv, chosen once for all runs, are the coordinates y
and z; all others follow from the null space N of C, in which these are the unit matrix. So no derivative of N is
needed, and where nothing closes a loop y and z are the coordinates and rates of the joints themselves.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from lienumba.compiler.dense.decompositions import Rows, accelerations, product, solved, turned, unit_rows

NEGLIGIBLE = 1e-9  # of rows of C of length 1, what is left of one beside those before it
Array = npt.NDArray[Any]  # (runs, rows, columns)


@dataclass(frozen=True)
class Blocks:
    """Everything above (runs, rows, columns), P with rows that are 0 where C holds no places; places: the constraints
    C_p, with rows that are 0 likewise, and rates: C; scale (runs,): see `rounding.scale`."""

    M: Array
    places: "Constraints"
    rates: "Constraints"
    F: Mapping[str, Array]
    G: Mapping[str, Array]
    H: Mapping[str, Array]
    P: Array
    gamma: Array
    turning: Array
    laws: Mapping[str, Array]
    scale: Array


@dataclass(frozen=True)
class Reduced:
    """x' = A x + B u of x = (y, z, s), and how dq, dv, da and dmu follow from x and u; chosen: the numbers of dq and of
    dv that y and z are."""

    A: Array
    B: Array
    q: tuple[Array, Array]
    v: tuple[Array, Array]
    a: tuple[Array, Array]
    mu: tuple[Array, Array]
    chosen: tuple[Array, Array]


def reduced(blocks: Blocks, chosen: tuple[Array, Array] | None = None) -> Reduced:
    """Of runs whose constraints, of both kinds, have the same ranks; chosen: see `Reduced`, if that is decided."""
    b, runs, n = blocks, len(blocks.M), blocks.M.shape[1]
    s, u = b.F["laws"].shape[2], b.F["inputs"].shape[2]
    places, rates = _Free.of(b.places, chosen and chosen[0]), _Free.of(b.rates, chosen and chosen[1])
    y, z = places.basis.shape[2], rates.basis.shape[2]
    size = y + z + s

    def zeros(rows: int) -> Array:
        return np.zeros((runs, rows, size + u))

    states, ends = (slice(0, y), slice(y, y + z), slice(y + z, size)), slice(size, size + u)
    dq, dv, ds, du = zeros(n), zeros(n), zeros(s), zeros(u)
    ds[:, :, states[2]], du[:, :, ends] = np.eye(s), np.eye(u)
    dq[:, :, states[0]], dv[:, :, states[1]] = places.basis, rates.basis
    dq += places.solved(product(b.P, du))
    dv -= rates.solved(product(b.H["q"], dq) + product(b.H["inputs"], du))
    every = {"q": dq, "v": dv, "laws": ds, "inputs": du}

    def sums(of: Mapping[str, Array], rows: int, by: Mapping[str, Array]) -> Array:
        return sum((product(of[name], x) for name, x in by.items() if name in of), zeros(rows))

    force = sums(b.F, n, every)
    da = rates.solved(sums(b.G, b.P.shape[1], every))
    M = b.M if rates.all else product(rates.along(b.M), rates.basis)
    da += rates.moved(accelerations(M, rates.along(force - product(b.M, da)), np.zeros(runs, np.int64), 0.0))
    dmu = b.rates.multipliers(force - product(b.M, da))
    slopes = [
        np.take(dv + product(b.gamma, dq), places.chosen, axis=1),
        np.take(da + product(b.turning, dv), rates.chosen, axis=1),
        sums(b.laws, s, {**every, "a": da, "mu": dmu}),
    ]
    whole = np.concatenate(slopes, axis=1)
    q, v, a, mu = ((x[:, :, :size], x[:, :, size:]) for x in (dq, dv, da, dmu))
    return Reduced(whole[:, :, :size], whole[:, :, size:], q, v, a, mu, (places.chosen, rates.chosen))


@dataclass(frozen=True)
class Constraints:
    """C by rows of length 1, and how long they were (runs, rows)."""

    rows: Rows
    lengths: Array

    @staticmethod
    def of(C: Array) -> "Constraints":
        own, lengths = unit_rows(C)
        return Constraints(Rows.of(own, NEGLIGIBLE), lengths)

    def part(self, runs: Array) -> "Constraints":
        """Of these runs alone."""
        return Constraints(self.rows.part(runs), self.lengths[runs])

    def least(self, wanted: Array) -> Array:
        """The shortest x (runs, n, k) with C x = wanted (runs, rows, k)."""
        return self.rows.least(wanted / self.lengths[:, :, None])

    def multipliers(self, g: Array) -> Array:
        """mu (runs, rows, k) with C^T mu = g (runs, n, k) as far as rows can; of redundant ones the least."""
        return self.rows.least_multipliers(g) / self.lengths[:, :, None]


@dataclass(frozen=True)
class _Free:
    """A basis (runs, n, f) of what constraints leave free, and its rows that are the unit matrix; all: whether nothing
    is constrained."""

    constraints: Constraints
    basis: Array
    chosen: Array
    all: bool = False

    @staticmethod
    def of(constraints: Constraints, chosen: Array | None) -> "_Free":
        Q, rank = constraints.rows.Q, int(constraints.rows.rank[0])
        runs, n = Q.shape[:2]
        if not rank:
            return _Free(constraints, np.broadcast_to(np.eye(n), (runs, n, n)), np.arange(n), True)
        free, first = Q[:, :, rank:], np.zeros(runs, np.int64)
        chosen = _independent(free[0]) if chosen is None or len(chosen) != n - rank else chosen
        basis = turned(solved(turned(free[:, chosen]), turned(free), first, 0.0)).copy()
        basis[:, chosen] = np.eye(n - rank)
        return _Free(constraints, basis, chosen)

    def solved(self, wanted: Array) -> Array:
        """A solution of C x = wanted that is 0 where the basis is the unit matrix."""
        x = self.constraints.least(wanted)
        return x if self.all else x - product(self.basis, np.take(x, self.chosen, axis=1))

    def along(self, x: Array) -> Array:
        """N^T x."""
        return x if self.all else product(turned(self.basis), x)

    def moved(self, x: Array) -> Array:
        """N x."""
        return x if self.all else product(self.basis, x)


def _independent(basis: Array) -> Array:
    """The rows of a basis (n, f) that are most independent, in their order."""
    left, chosen = basis.copy(), list[int]()
    for _ in range(basis.shape[1]):
        sizes = np.round((left * left).sum(axis=1), 9)  # of equals the first
        sizes[chosen] = -1.0
        best = int(sizes.argmax())
        direction = left[best] / np.sqrt((left[best] * left[best]).sum())
        left = left - np.outer((left * direction).sum(axis=1), direction)
        chosen.append(best)
    return np.array(sorted(chosen), int)
