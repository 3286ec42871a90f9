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

NEGLIGIBLE = 1e-9  # of the largest singular value of the rows of C, scaled to length 1
Array = npt.NDArray[Any]  # (runs, rows, columns)


@dataclass(frozen=True)
class Blocks:
    """Everything above (runs, rows, columns); position: which rows of C hold positions (runs, rows)."""

    M: Array
    C: Array
    F: Mapping[str, Array]
    G: Mapping[str, Array]
    H: Mapping[str, Array]
    P: Array
    gamma: Array
    turning: Array
    laws: Mapping[str, Array]
    position: npt.NDArray[np.bool_]


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
    """Of runs whose constraints have the same rank (see `ranks`); chosen: see `Reduced`, if that is decided."""
    b, runs, n = blocks, len(blocks.M), blocks.M.shape[1]
    s, u = b.F["laws"].shape[2], b.F["inputs"].shape[2]
    held = np.where(b.position[:, :, None], b.C, 0.0)
    Np, inverse_p, yq = _null(held, chosen and chosen[0])
    Nv, inverse_v, zv = _null(b.C, chosen and chosen[1])
    y, z = Np.shape[2], Nv.shape[2]
    size = y + z + s

    def zeros(rows: int) -> Array:
        return np.zeros((runs, rows, size + u))

    states, ends = (slice(0, y), slice(y, y + z), slice(y + z, size)), slice(size, size + u)
    dq, dv, ds, du = zeros(n), zeros(n), zeros(s), zeros(u)
    ds[:, :, states[2]], du[:, :, ends] = np.eye(s), np.eye(u)
    dq[:, :, states[0]] = Np
    dq += _solved(inverse_p, np.where(b.position[:, :, None], b.P, 0.0) @ du, Np, yq)
    dv[:, :, states[1]] = Nv
    dv += _solved(inverse_v, -(b.H["q"] @ dq) - b.H["inputs"] @ du, Nv, zv)
    every = {"q": dq, "v": dv, "laws": ds, "inputs": du}
    force = sum(b.F[name] @ x for name, x in every.items())
    wanted = zeros(b.C.shape[1]) + sum(b.G[name] @ x for name, x in every.items())
    da = _solved(inverse_v, wanted, Nv, zv)
    Nt = Nv.transpose(0, 2, 1)
    da = da + Nv @ np.linalg.solve(Nt @ b.M @ Nv, Nt @ (force - b.M @ da)) if z else da
    dmu = inverse_v.transpose(0, 2, 1) @ (force - b.M @ da)
    rates = [
        np.take(dv + b.gamma @ dq, yq, axis=1),
        np.take(da + b.turning @ dv, zv, axis=1),
        sum(b.laws[name] @ x for name, x in {**every, "a": da, "mu": dmu}.items() if name in b.laws) + zeros(s),
    ]
    whole = np.concatenate(rates, axis=1)
    q, v, a, mu = ((x[:, :, :size], x[:, :, size:]) for x in (dq, dv, da, dmu))
    return Reduced(whole[:, :, :size], whole[:, :, size:], q, v, a, mu, (yq, zv))


def ranks(C: Array) -> Array:
    """Of each run."""
    if not C.shape[1]:
        return np.zeros(len(C), int)
    sizes = np.linalg.svd(_unit_rows(C)[0], compute_uv=False)
    return (sizes > NEGLIGIBLE * sizes[:, :1]).sum(axis=1)


def _unit_rows(C: Array) -> tuple[Array, Array]:
    lengths = np.linalg.norm(C, axis=2, keepdims=True)
    lengths[lengths == 0.0] = 1.0
    return C / lengths, lengths


def _null(C: Array, chosen: Array | None) -> tuple[Array, Array, Array]:
    """A basis of what C leaves free, the pseudo-inverse of C, and the rows of the basis that are the unit matrix."""
    runs, rows, n = C.shape
    if not rows or not C.any():
        return np.broadcast_to(np.eye(n), (runs, n, n)), np.zeros((runs, n, rows)), np.arange(n)
    scaled, lengths = _unit_rows(C)
    U, sizes, Vt = np.linalg.svd(scaled, full_matrices=True)
    rank = int((sizes[0] > NEGLIGIBLE * sizes[0, 0]).sum())
    V = Vt.transpose(0, 2, 1)
    inverse = (V[:, :, :rank] / sizes[:, None, :rank]) @ U.transpose(0, 2, 1)[:, :rank]
    free = V[:, :, rank:]
    chosen = _independent(free[0]) if chosen is None or len(chosen) != free.shape[2] else chosen
    basis = free @ np.linalg.inv(free[:, chosen]) if len(chosen) else free
    return basis, inverse / lengths.transpose(0, 2, 1), chosen


def _independent(basis: Array) -> Array:
    """The rows of a basis (n, f) that are most independent, in their order."""
    left, chosen = basis.copy(), list[int]()
    for _ in range(basis.shape[1]):
        sizes = np.round((left * left).sum(axis=1), 9)  # of equals the first
        sizes[chosen] = -1.0
        best = int(sizes.argmax())
        direction = left[best] / np.linalg.norm(left[best])
        left = left - np.outer(left @ direction, direction)
        chosen.append(best)
    return np.array(sorted(chosen), int)


def _solved(inverse: Array, wanted: Array, basis: Array, chosen: Array) -> Array:
    """A solution of C x = wanted that is 0 where the basis is the unit matrix."""
    x = inverse @ wanted
    return x - basis @ np.take(x, chosen, axis=1)
