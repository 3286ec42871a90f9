"""How small deviations from a rest, or from a uniform rotation, grow: the eigenvalues of every run.

With y, z and s deviations of the places along Q_p, of the rates along Q, and of the states of laws,

    dq = Q_p y,   dv = Q z - C^+ H dq,   da = C^+ (G_q dq + G_v dv) + Q w,   Q^T M da = Q^T (F_q dq + F_v dv + F_s s),
    Q_p y' = dv - Gamma dq,   Q z' = da - Lambda dv,   s' = L_q dq + L_v dv + L_a da + L_s s,

where the columns of Q_p and Q are what the constraints of places and of rates leave free, H, G_q and G_v what their
rates and accelerations change by, and Gamma and Lambda the turning of the axes of free bodies and balls, along which
everything is constant.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from lienumba.compiler.dense.decompositions import (
    Rows,
    accelerations,
    beyond_rounding,
    eigenvalues,
    growing,
    product,
    turned,
)
from lienumba.integrators.tracing.linear.equations import Linear
from lienumba.integrators.tracing.linear.rounding import SMALL, Moves
from lienumba.integrators.tracing.linear.standing import REDUNDANT

Array = npt.NDArray[Any]


@dataclass(frozen=True)
class Near:
    """What is known of a state: the equations there; `scale` (runs,), and the terms `of_forces` of some runs (indices),
    see `Moves.rounded`; the constraints of rates and those of places among them; G and H (runs, m, n), over how long
    the rows of C were; the sizes of coordinates (runs, n); gamma, lambda_ (runs, n, n). Their "halted" states of laws
    (runs, s), where they are not 0, move no more."""

    at: Linear
    scale: Array
    of_forces: Callable[[Array], Mapping[str, Array]]
    rows: Rows
    places: Rows
    G: Mapping[str, Array]
    H: Array
    sizes: Array
    gamma: Array
    lambda_: Array

    def held(self, C: Array, of_places: Array, rates: Array) -> "Near":
        """The same where the angle is given, and with it the rate, by which all turns with these rates (runs, n), along
        them; C (runs, m, n): rows of length 1; of_places (m,): 1 for those of places, else 0."""
        along = rates / self.sizes
        along = (along / np.maximum(np.sqrt((along * along).sum(axis=1)), 1e-300)[:, None])[:, None, :]
        own = along / self.sizes[:, None, :]
        changes = {"q": -product(product(own, self.gamma), self.gamma), "v": product(own, self.lambda_ + self.gamma)}
        rows, places = (
            Rows.of(np.concatenate([kept, along], axis=1), REDUNDANT, np.minimum(known.rank + 1, along.shape[2]))
            for kept, known in ((C, self.rows), (C * of_places[:, None], self.places))
        )
        G = {by: np.concatenate([self.G[by], x], axis=1) for by, x in changes.items()}
        H = np.concatenate([self.H, -product(own, self.gamma)], axis=1)
        return replace(self, rows=rows, places=places, G=G, H=H)


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
    for own, A, moves in _systems(near):

        def rounded(which: Array, own: Array = own, moves: Moves = moves) -> tuple[Array, Array]:
            return moves.part(which).rounded(near.of_forces(own[which]))

        values, nothing = beyond_rounding(A, eigenvalues(A), moves.rates, near.scale[own], rounded)
        growth[own] = values.real.max(axis=1, initial=-np.inf)
        grows[own] = growing(values).any(axis=1)
        zeros[own] = nothing.sum(axis=1)
    return Stability(growth, grows, zeros)


def _systems(near: Near) -> Iterator[tuple[Array, Array, Moves]]:
    """x' = A x of the runs (indices) with as many freedoms, those of each kind together."""
    whole, moves = _whole(near)
    n, laws = near.sizes.shape[1], near.at.equations.moving
    for y, z in np.unique(np.stack([near.places.rank, near.rows.rank], axis=1), axis=0):
        which = np.flatnonzero((near.places.rank == y) & (near.rows.rank == z))
        kept = np.concatenate([np.arange(y, n), np.arange(n + z, 2 * n), 2 * n + laws])
        yield which, whole[np.ix_(which, kept, kept)], moves.part(which).only(kept, slice(n - y, 2 * n - y - z))


def _whole(near: Near) -> tuple[Array, Moves]:
    """A in all reflected coordinates (runs, 2 n + laws, 2 n + laws), of which constraints leave some."""
    at, D, (runs, n) = near.at, near.sizes, near.sizes.shape
    laws = len(at.equations.columns["laws"])
    Q, Qp, Qt = near.rows.Q, near.places.Q, turned(near.rows.Q)
    forces = {by: at.dense("along", by, runs) * D[:, :, None] for by in ("q", "v", "a", "laws")}

    def scaled(x: Array) -> Array:
        return x * D[:, None, :]

    size = 2 * n + laws
    dq, dv, ds = np.zeros((runs, n, size)), np.zeros((runs, n, size)), np.zeros((runs, laws, size))
    dq[:, :, :n], dv[:, :, n : 2 * n], ds[:, :, 2 * n :] = Qp, Q, np.eye(laws)
    dv -= near.rows.least(product(scaled(near.H), dq))
    da = near.rows.least(product(scaled(near.G["q"]), dq) + product(scaled(near.G["v"]), dv))
    M = -scaled(forces["a"])
    force = product(scaled(forces["q"]), dq) + product(scaled(forces["v"]), dv) - product(M, da)
    force += product(forces["laws"], ds)
    w = accelerations(product(Qt, product(M, Q)), product(Qt, force), near.rows.rank, SMALL)
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
    found -= np.eye(size) * (halted * fastest[:, None])[:, None, :]
    return found, Moves(M, dq, dv, da, slice(n, 2 * n))
