"""The Karcher mean of rotations: where the mean of the squared angles to them, the cost, is least.

H. Karcher, Riemannian center of mass and mollifier smoothing, Comm. Pure Appl. Math. 30 (1977); X. Pennec, Intrinsic
statistics on Riemannian manifolds, J. Math. Imaging Vis. 25 (2006).

Here rotations are unit quaternions up to their sign, and an angle is twice that on the sphere. A step goes along the
mean of the logarithms. SO(3) is nowhere negatively curved, so that a squared distance is at most that of the flat space
of the logarithms (Toponogov), and no step raises the cost. The second derivatives of a squared angle a^2/2 are 1 along
and (a/2) cot(a/2) > 0 across the way, up to the cut locus a = pi, where it has a concave edge. So the steps end in a
minimum, and none lies on a cut locus; but there may be many.

One is the mean for sure if all rotations are within a quarter turn of it (B. Afsari, Riemannian L^p center of mass,
Proc. AMS 139 (2011)). Otherwise minima are sought from starts all over the group.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lienumba.groups import so3

UNIQUE, BEST, SEVERAL, NOT_CONVERGED, NONE = range(5)
QUARTER, HALF = 0.5 * 3.141592653589793, 3.141592653589793  # turns, rad
MARGIN = 1e-9  # rad: what is nearer than this to a limit is not known to be below it
STEPS, TOLERANCE = 1000, 1e-13  # half of rad
GRID, STARTS, FINALISTS, LAST = 512, 128, 16, 8  # points, those that begin, that go on, that end in minima
FEW = 1024  # runs among which starts are sought
ROUGH_STEPS, ROUGH, CLOSE = 16, 1e-5, 1e-3  # half of rad, and rad between points on the way to one minimum
NUMBERS = 2**16  # pairs of a start and a run at a time
SHELLS = 16  # distances from a mean at which it is shown that no other is there
EQUAL, APART = 1e-9, 1e-4  # costs that differ by less, relative, are the same; means that differ by more (rad) are not


@dataclass(frozen=True)
class Mean:
    """rotation: nine numbers, the angle to each run (labels, runs), and how sure each is (labels,)."""

    rotation: so3.Matrix3
    angles: np.ndarray
    status: np.ndarray


def mean(R: so3.Matrix3, finite: np.ndarray, margin: np.ndarray) -> Mean:
    """The mean of rotations, nine numbers (labels, runs), at each label over the runs that are known; margin (labels,):
    how well angles to them are known (rad)."""
    q = np.stack(so3.to_quaternion(R), axis=-1)
    weights = _weights(finite)
    p, _, arrived = descend(_chordal(q, weights)[:, None], q, weights)
    p, arrived = p[:, 0], arrived[:, 0]
    found = angles(R, p, finite)
    margin = np.maximum(margin, MARGIN)
    status = np.where(arrived & _only(found, finite, margin), UNIQUE, BEST)
    doubtful = np.flatnonzero(status == BEST)
    at_once = max(1, NUMBERS // min(q.shape[1], FEW) // STARTS)
    for first in range(0, len(doubtful), at_once):
        these = doubtful[first : first + at_once]
        p[these], status[these] = _search(q[these], finite[these], p[these], np.maximum(margin[these], EQUAL))
        found[these] = angles(tuple(x[these] for x in R), p[these], finite[these])
        only = _only(found[these], finite[these], margin[these])
        status[these] = np.where((status[these] == BEST) & only, UNIQUE, status[these])
    status = np.where(found.max(axis=1) > HALF - MARGIN, NOT_CONVERGED, status)
    rotation = so3.from_quaternion(tuple(p.T))
    none = ~finite.any(axis=1)
    return Mean(tuple(np.where(none, np.nan, x) for x in rotation), found, np.where(none, NONE, status))


def _only(angles: np.ndarray, finite: np.ndarray, margin: np.ndarray) -> np.ndarray:
    """Whether a minimum is the mean for sure (labels,), from its angles to the runs, each known to a margin: all are
    below a quarter turn, or the cost is larger everywhere else.

    At a distance d in any direction a squared angle a^2 has grown against its tangent by at least d^2 g(a + d), with
    g(x) = (x/2) cot(x/2), before the cut locus; behind it by at least d^2 - 4 pi (a + d - pi), which is that of the
    opposite direction. The tangents add up to 0. From twice the mean angle on, the triangle inequality says it.
    """
    weights, farthest = _weights(finite), angles.max(axis=1)
    sure: np.ndarray = farthest < QUARTER - margin
    near = HALF - farthest
    far = np.clip(2.0 * (weights * angles).sum(axis=1), near, HALF)
    wider = ~sure & (near > margin)
    for k in range(SHELLS if wider.any() else 0):
        low, high = ((near + (far - near) * (k + j) / SHELLS)[wider, None] for j in (0, 1))
        reach = angles[wider] + high
        half = 0.5 * np.minimum(reach, HALF)
        inside = low * low * half / np.tan(half)
        grown = np.where(reach < HALF, inside, np.minimum(low * low - 4.0 * HALF * (reach - HALF), 0.0))
        wider[wider] = (weights[wider] * grown).sum(axis=1) > 0.0
    return sure | wider


def angles(R: so3.Matrix3, p: np.ndarray, finite: np.ndarray) -> np.ndarray:
    """From rotations p (labels, 4) to R, nine numbers (labels, runs); 0 where these are not known."""
    back = so3.transpose(so3.from_quaternion(tuple(x[:, None] for x in p.T)))
    u = so3.log(so3.multiply(back, R))
    return np.where(finite, so3.dot(u, u) ** 0.5, 0.0)


def descend(
    p: np.ndarray, q: np.ndarray, weights: np.ndarray, tolerance: float = TOLERANCE, steps: int = STEPS
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """From starts p (labels, starts, 4) to minima for rotations q (labels, runs, 4): these, their costs, and whether
    they were reached."""
    away = np.ones(p.shape[:2], bool)
    for _ in range(steps):
        step, cost = _step(p, q, weights)
        length = (step * step).sum(axis=-1) ** 0.5
        away &= length > tolerance
        if not away.any():
            break
        ahead = np.cos(length)[..., None] * p + np.sinc(length / np.pi)[..., None] * step
        ahead /= (ahead * ahead).sum(axis=-1, keepdims=True) ** 0.5
        p = np.where(away[..., None], ahead, p)
    return p, cost, ~away


def _step(p: np.ndarray, q: np.ndarray, weights: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The mean of the logarithms at p, on the sphere, and the cost there (rad^2)."""
    cosine, weights = p @ np.swapaxes(q, -1, -2), weights[:, None]
    near = np.minimum(abs(cosine), 1.0)  # of the two quaternions of a rotation the nearer one
    angle = np.arccos(near)
    sine = ((1.0 - near) * (1.0 + near)) ** 0.5
    ratio = np.divide(angle, sine, out=np.ones_like(angle), where=sine > 0.0)
    pull = (weights * np.copysign(ratio, cosine)) @ q
    cost = 4.0 * (weights * (angle * angle)).sum(axis=-1)
    return pull - (pull * p).sum(axis=-1, keepdims=True) * p, cost


def _chordal(q: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """The mean in the space of matrices (F. L. Markley et al., Averaging quaternions, J. Guid. Control Dyn. 30 (2007)),
    which is near where the spread is small (labels, 4)."""
    chords: np.ndarray = np.linalg.eigh(np.swapaxes(q, 1, 2) @ (weights[..., None] * q))[1][..., -1]
    return chords


def _search(q: np.ndarray, finite: np.ndarray, first: np.ndarray, equal: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The best minimum from many starts (labels, 4), `first` among them, and what is known of it. Starts are the best
    points of a grid; of those that lie best after some steps, far from one another, the best go on to their minima.
    Of many runs, some are asked where to start. equal (labels,): costs that differ by less, relative, are the same."""
    few, of_few = (q, finite) if q.shape[1] <= FEW else _some(q, finite)
    weights, weights_few = _weights(finite), _weights(of_few)
    p = _best(np.broadcast_to(_grid(), (len(q), GRID, 4)), few, weights_few, STARTS)
    p = _best(descend(p, few, weights_few, ROUGH, ROUGH_STEPS)[0], few, weights_few, FINALISTS, CLOSE)
    p = _best(descend(p, q, weights, ROUGH, ROUGH_STEPS)[0], q, weights, LAST, CLOSE)
    p, cost, arrived = descend(np.concatenate([first[:, None], p], axis=1), q, weights)
    best = cost.argmin(axis=1)[:, None]
    least, mean = np.take_along_axis(cost, best, 1), np.take_along_axis(p, best[..., None], 1)
    same = abs((p * mean).sum(axis=-1)) > np.cos(0.5 * APART)
    several = (~same & arrived & (cost <= (1.0 + equal[:, None]) * least)).any(axis=1)
    status = np.where(np.take_along_axis(arrived, best, 1)[:, 0], np.where(several, SEVERAL, BEST), NOT_CONVERGED)
    return mean[:, 0], status


def _weights(finite: np.ndarray) -> np.ndarray:
    weights: np.ndarray = finite / np.maximum(finite.sum(axis=1, keepdims=True), 1)
    return weights


def _best(p: np.ndarray, q: np.ndarray, weights: np.ndarray, most: int, apart: float = 0.0) -> np.ndarray:
    """Those of the points p (labels, points, 4) whose costs are least, one of those that are not `apart` (rad)."""
    cost = _step(p, q, weights)[1]
    p = np.take_along_axis(p, np.argsort(cost, axis=1, kind="stable")[..., None], 1)
    if apart > 0.0:
        near = np.tril(abs(p @ np.swapaxes(p, 1, 2)) > np.cos(0.5 * apart), -1).any(axis=2)  # to a better one
        p = np.take_along_axis(p, np.argsort(near, axis=1, kind="stable")[..., None], 1)
        most = min(most, int((~near).sum(axis=1).max()))
    return p[:, :most]


def _some(q: np.ndarray, finite: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Some of the runs that are known at each label: evenly by their places in an order that is the runs' own, so that
    it does not matter in which order they come."""
    key = np.where(finite, sum(abs(q[..., k]) * 3.0 ** (0.5 * k) for k in range(4)), np.inf)
    count = np.maximum(finite.sum(axis=1, keepdims=True), FEW)
    which = np.argsort(key, axis=1, kind="stable")
    which = np.take_along_axis(which, np.arange(FEW) * count // FEW, 1)
    return np.take_along_axis(q, which[..., None], 1), np.take_along_axis(finite, which, 1)


def _grid() -> np.ndarray:
    """Rotations all over the group (GRID, 4): super-Fibonacci spirals (M. Alexa, CVPR 2022)."""
    s = np.arange(GRID) + 0.5
    low, high = (s / GRID) ** 0.5, (1.0 - s / GRID) ** 0.5
    a, b = 2.0 * np.pi * s / 2.0**0.5, 2.0 * np.pi * s / 1.533751168755204288118041
    return np.stack([low * np.sin(a), low * np.cos(a), high * np.sin(b), high * np.cos(b)], axis=1)
