"""How small deviations from a rest, or from a uniform rotation, grow: the eigenvalues of every run.

With y, z and s deviations of the places along Q_p, of the rates along Q, and of the states of laws,

    dq = Q_p y,   dv = Q z - C^+ H dq,   da = C^+ (G_q dq + G_v dv) + Q w,   Q^T M da = Q^T (F_q dq + F_v dv + F_s s),
    Q_p y' = dv - Gamma dq,   Q z' = da - Lambda dv,   s' = L_q dq + L_v dv + L_a da + L_s s,

where the columns of Q_p and Q are what the constraints of places and of rates leave free, H, G_q and G_v what their
rates and accelerations change by, and Gamma and Lambda the turning of the axes of free bodies and balls, along which
everything is constant.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from lienumba.compiler.dense.decompositions import Rows, beyond_rounding, eigenvalues, growing, product, solved, turned
from lienumba.integrators.tracing.linear.equations import Linear

Array = npt.NDArray[Any]
SMALL = 1e-13  # of the largest pivot of the masses


@dataclass(frozen=True)
class Near:
    """What is known of a state: the equations there, how large what these are sums of is, the multipliers of their rows (runs, m), the constraints of rates
    and those of places among them, how long the rows of both were, the sizes of coordinates (runs, n); gamma, lambda_
    (runs, n, n). Their "halted" states of laws (runs, s), where they are not 0, move no more."""

    at: Linear
    sums: Linear
    mu: Array
    rows: Rows
    places: Rows
    lengths: Array
    sizes: Array
    gamma: Array
    lambda_: Array


@dataclass(frozen=True)
class Stability:
    """growth (1/s): of what grows most, -inf where nothing is free; grows: whether by more than rounding; zeros: how
    many eigenvalues are 0; each (runs,)."""

    growth: Array
    grows: Array
    zeros: Array


def stability(near: Near) -> Stability:
    """growth is NaN where there are no finite equations."""
    runs = len(near.sizes)
    growth, grows, zeros = np.full(runs, np.nan), np.zeros(runs, bool), np.zeros(runs, int)
    accelerations, fastest = terms(near.at, near.sums, near.mu, near.sizes)
    for which, A, rates in _systems(near):
        values, nothing = beyond_rounding(A, eigenvalues(A), rates, accelerations[which], fastest[which])
        growth[which] = values.real.max(axis=1, initial=-np.inf)
        grows[which] = growing(values).any(axis=1)
        zeros[which] = nothing.sum(axis=1)
    return Stability(growth, grows, zeros)


def terms(at: Linear, sums: Linear, mu: Array, sizes: Array) -> tuple[Array, Array]:
    """Of one coordinate without the others what its stiffness and damping give it, at most (runs,): as an acceleration
    in a unit and at a unit of speed, and how fast (1/s) that could move it. sums: `Equations.terms` there, since what
    cancels is rounded as what it is a sum of. What constraints carry counts as stiffness: turned, it is some."""
    D, runs = sizes, len(sizes)
    carried = (np.abs(at.dense("rows", "a", runs) * mu[:, :, None]) * D[:, None, :]).sum(axis=1)
    K, damping = (sums.dense("along", by, runs) * D[:, None, :] * D[:, :, None] for by in ("q", "v"))
    masses = np.abs(at.dense("along", "a", runs).diagonal(axis1=1, axis2=2)) * D * D
    with np.errstate(all="ignore"):
        stiff, damped = np.maximum(K.max(axis=2), carried) / masses, damping.max(axis=2) / masses
    stiff, damped = (np.where(np.isfinite(x), x, 0.0).max(axis=1, initial=0.0) for x in (stiff, damped))
    return np.maximum(stiff, damped), np.maximum(np.sqrt(stiff), damped)


def _systems(near: Near) -> Iterator[tuple[Array, Array, slice]]:
    """x' = A x of the runs (indices) with as many freedoms, those of each kind together; which rows are those of
    rates."""
    whole = _whole(near)
    n, laws = near.sizes.shape[1], near.at.equations.moving
    for y, z in np.unique(np.stack([near.places.rank, near.rows.rank], axis=1), axis=0):
        which = np.flatnonzero((near.places.rank == y) & (near.rows.rank == z))
        kept = np.concatenate([np.arange(y, n), np.arange(n + z, 2 * n), 2 * n + laws])
        yield which, whole[np.ix_(which, kept, kept)], slice(n - y, 2 * n - y - z)


def _whole(near: Near) -> Array:
    """A in all reflected coordinates (runs, 2 n + laws, 2 n + laws), of which constraints leave some."""
    at, D, (runs, n) = near.at, near.sizes, near.sizes.shape
    laws = len(at.equations.columns["laws"])
    Q, Qp, Qt = near.rows.Q, near.places.Q, turned(near.rows.Q)
    forces = {by: at.dense("along", by, runs) * D[:, :, None] for by in ("q", "v", "a", "laws")}
    rows = {by: at.dense("rows", by, runs) / near.lengths[:, :, None] for by in ("q", "v")}
    rates = at.dense("rates", "q", runs) / near.lengths[:, :, None]

    def scaled(x: Array) -> Array:
        return x * D[:, None, :]

    size = 2 * n + laws
    dq, dv, ds = np.zeros((runs, n, size)), np.zeros((runs, n, size)), np.zeros((runs, laws, size))
    dq[:, :, :n], dv[:, :, n : 2 * n], ds[:, :, 2 * n :] = Qp, Q, np.eye(laws)
    dv -= near.rows.least(product(scaled(rates), dq))
    da = near.rows.least(product(scaled(rows["q"]), dq) + product(scaled(rows["v"]), dv))
    M = -scaled(forces["a"])
    force = product(scaled(forces["q"]), dq) + product(scaled(forces["v"]), dv) - product(M, da)
    force += product(forces["laws"], ds)
    w = solved(product(Qt, product(M, Q)), product(Qt, force), near.rows.rank, SMALL)
    da += product(Q, w)
    turning = [x * (D[:, None, :] / D[:, :, None]) for x in (near.gamma, near.lambda_)]
    own = {by: at.dense("laws", by, runs) for by in ("q", "v", "a", "laws")}
    changes = product(scaled(own["q"]), dq) + product(scaled(own["v"]), dv) + product(scaled(own["a"]), da)
    found = np.concatenate(
        [
            product(turned(Qp), dv - product(turning[0], dq)),
            product(Qt, da - product(turning[1], dv)),
            changes + product(own["laws"], ds),
        ],
        axis=1,
    )
    halted = np.concatenate([np.zeros((runs, 2 * n), bool), at.vector("halted", runs) != 0.0], axis=1)
    fastest = 1.0 + np.abs(found).max(axis=(1, 2), initial=0.0)  # what is halted comes back faster than all else moves
    found[halted[:, :, None] | halted[:, None, :]] = 0.0
    return found - np.eye(size) * (halted * fastest[:, None])[:, None, :]
