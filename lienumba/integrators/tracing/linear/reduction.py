"""From partial derivatives to the linear system of a mechanism in as many coordinates as it has freedoms.

Small changes of a motion obey

    dq' = dv + Gamma dq,                         M da + C^T dmu = F_q dq + F_v dv + F_s ds + F_u du,
    C_p dq = P_u du,  C dv = -H_q dq - H_u du,   C da = G_q dq + G_v dv + G_u du,      dv' = da + Lambda dv,

in coordinates whose axes turn so that Gamma and Lambda are what remains of their turning. Redundant rows of C add
nothing to its null space N. The coordinates y and z are independent ones of dq and dv, chosen once for all runs: in
them N is the unit matrix. So no derivative of N is needed, and without loops y and z are the coordinates and rates of
the joints.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from lienumba.integrators.tracing.linear.algebra import Array, NullSpace


@dataclass(frozen=True)
class Blocks:
    """The matrices above (runs, rows, columns). P has rows of zeros where C holds no places, as has C_p (`places`);
    rates: the constraints C."""

    M: Array
    places: NullSpace
    rates: NullSpace
    F: Mapping[str, Array]
    G: Mapping[str, Array]
    H: Mapping[str, Array]
    P: Array
    gamma: Array
    turning: Array
    laws: Mapping[str, Array]

    def independent(self, run: int) -> tuple[Array, Array]:
        """Which numbers of dq and of dv are independent in a run (n,)."""
        return self.places.independent[run], self.rates.independent[run]

    def fits(self, runs: Array, independent: tuple[Array, Array]) -> Array:
        """In which of these runs such numbers are independent, far from dependent."""
        places, rates = (x.part(runs) for x in (self.places, self.rates))
        fits: Array = places.fits(independent[0]) & rates.fits(independent[1])
        return fits


@dataclass(frozen=True)
class Reduced:
    """x' = slopes (x, u) of x = (y, z, s), and how dq, dv, da and dmu (`motion`) follow from (x, u): matrices of `size`
    columns for x and behind them those for u; chosen: the numbers of dq and of dv that y and z are."""

    slopes: Array
    motion: Mapping[str, Array]
    chosen: tuple[Array, Array]
    size: int


def reduced(blocks: Blocks, independent: tuple[Array, Array]) -> Reduced:
    """Reduce runs in which these numbers of dq and of dv (n,) are independent."""
    b, runs, n = blocks, len(blocks.M), blocks.M.shape[1]
    s, u = b.F["laws"].shape[2], b.F["inputs"].shape[2]
    places, rates = b.places.along(independent[0]), b.rates.along(independent[1])
    chosen = np.flatnonzero(independent[0]), np.flatnonzero(independent[1])
    y, z = map(len, chosen)
    size = y + z + s

    def zeros(rows: int) -> Array:
        return np.zeros((runs, rows, size + u))

    states, ends = (slice(0, y), slice(y, y + z), slice(y + z, size)), slice(size, size + u)
    dq, dv, ds, du = zeros(n), zeros(n), zeros(s), zeros(u)
    ds[:, :, states[2]], du[:, :, ends] = np.eye(s), np.eye(u)
    dq[:, :, states[0]], dv[:, :, states[1]] = places.basis[:, :, chosen[0]], rates.basis[:, :, chosen[1]]
    dq += places.dependent(b.P @ du)
    dv -= rates.dependent(b.H["q"] @ dq + b.H["inputs"] @ du)
    every = {"q": dq, "v": dv, "laws": ds, "inputs": du}

    def sums(of: Mapping[str, Array], rows: int, by: Mapping[str, Array]) -> Array:
        return sum((of[name] @ x for name, x in by.items() if name in of), zeros(rows))

    da, dmu = rates.motion(b.M, sums(b.F, n, every), sums(b.G, b.P.shape[1], every))
    slopes = [
        (dv + b.gamma @ dq)[:, chosen[0]],
        (da + b.turning @ dv)[:, chosen[1]],
        sums(b.laws, s, {**every, "a": da, "mu": dmu}),
    ]
    return Reduced(np.concatenate(slopes, axis=1), {"q": dq, "v": dv, "a": da, "mu": dmu}, chosen, size)
