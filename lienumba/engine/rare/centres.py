"""About which points importance sampling draws: design points, and more, until no failure lies far from all of them.

Along a limit that bends about the origin failures are as likely next to a design point as there, and of what lies s
away a sample about it has exp(-s^2/2), each with the weight exp(s^2/2): few runs would say most, or none all of it. So
the mixture grows as in incremental mixture importance sampling (A. E. Raftery, L. Bao, Biometrics 66 (2010) 1162): by
points about failures whose weights are many times the mean, and by what a wider sample finds elsewhere.
"""

from typing import NamedTuple

import numpy as np
from scipy import stats

from lienumba.engine.rare.estimate import Margins, finite, gradient
from lienumba.errors import ScenarioError

DEFENSIVE = 0.1  # the part of the sample that is drawn as the inputs are
RELEVANT = 2.0  # how much farther than the nearest a centre may be
PILOT = 500  # runs of a round, about the centres, and as many farther away
WIDEST, WIDER = 1.5, 0.5  # standard deviations of these at least, and in parts of the distance
HEAVY = 10.0  # times the mean weight of what fails: another centre is needed
BETWEEN = 1.0  # centres
TRIED, ROUNDS, MANY = 8, 20, 60  # in a round; rounds; centres
ON_RAY = np.linspace(0.5, 1.0, 11)  # of the way to a failure
BEYOND = np.array([1.0, 1.02, 1.1])  # of the distance of a limit's tangent plane
AROUND, AROUND_EACH, TURNS = 100, 8, 4  # runs about a failure, and for each input; how often
PARTS, ON_FOOT = np.linspace(0.25, 1.0, 4), np.linspace(0.8, 1.2, 9)  # of the way to a foot; of its distance
VALLEY = 2.5  # where no other centre is nearer to the origin within this distance it is a design point


class Mixture(NamedTuple):
    """Standard normal densities about centres (k + 1, d), the last one the origin, each with its share (k + 1,)."""

    centres: np.ndarray
    share: np.ndarray

    def weights(self, z: np.ndarray) -> np.ndarray:
        """The density of the inputs over that of the mixture, (n, d) to (n,)."""
        exponents = z @ self.centres.T - 0.5 * (self.centres**2).sum(axis=1)
        top = exponents.max(axis=1)
        found: np.ndarray = np.exp(-top - np.log(np.exp(exponents - top[:, None]) @ self.share))
        return found

    def drawn(self, n: int, rng: np.random.Generator) -> tuple[np.ndarray, "Mixture"]:
        """n points, as many about each centre as its share says, and the mixture that these whole numbers make."""
        counts = np.diff(np.rint(n * np.cumsum(self.share[:-1])).astype(int), prepend=0)
        counts = np.append(counts, n - counts.sum())
        z = np.concatenate([about(centre, k, rng) for centre, k in zip(self.centres, counts, strict=True)])
        return z, Mixture(self.centres, counts / n)


def about(centre: np.ndarray, n: int, rng: np.random.Generator) -> np.ndarray:
    """n standard normal points about a centre, a Latin hypercube in axes of which the first leads from the origin to
    it: a reflection turns them there."""
    places = rng.permuted(np.tile(np.arange(n)[:, None], len(centre)), axis=0)
    within = rng.uniform(1e-9, 1.0 - 1e-9, places.shape)  # not on an end, which is infinitely far away
    z: np.ndarray = stats.norm.ppf((places + within) / n)
    mirror = centre + np.copysign(np.linalg.norm(centre), centre[0]) * np.eye(len(centre))[0]
    square = float(mirror @ mirror)
    return centre + (z - np.outer(z @ mirror, 2.0 / square * mirror) if square > 0.0 else z)


def mixture(points: np.ndarray) -> Mixture:
    """About points (k, d), each as likely as failures are there, and the origin."""
    squares = (points**2).sum(axis=1)
    share = np.exp(-0.5 * (squares - squares.min()))
    centres = np.vstack([points, np.zeros(points.shape[1])])
    return Mixture(centres, np.append((1.0 - DEFENSIVE) * share / share.sum(), DEFENSIVE))


def spread(margins: Margins, points: np.ndarray, rng: np.random.Generator) -> tuple[np.ndarray, int]:
    """Centres (k, d), from design points (n, d) on, and the runs that finding them took."""
    points, taken, d = points.copy(), 0, points.shape[1]
    failures = np.empty((0, d))
    for _ in range(ROUNDS):
        nearest = float(np.linalg.norm(points, axis=1).min())
        points = points[np.linalg.norm(points, axis=1) <= nearest + RELEVANT]
        near, _drawn = mixture(points).drawn(PILOT, rng)
        wide = max(WIDEST, WIDER * nearest) * rng.standard_normal((PILOT, d))
        failed = finite(margins(np.concatenate([near, wide]))) <= 0.0
        taken += 2 * PILOT
        near = near[failed[:PILOT]]
        failures, before = np.concatenate([failures, near, wide[failed[PILOT:]]]), len(points)
        for _ in range(TRIED):
            own = mixture(points)
            mean = float(own.weights(near).mean()) if len(near) else 0.0
            far = np.flatnonzero(own.weights(failures) > HEAVY * mean)
            if not len(far):
                break
            first = far[np.argmin(np.linalg.norm(failures[far], axis=1))]
            centre, count = _nearer(margins, failures[first], rng)
            failures, taken = np.delete(failures, first, axis=0), taken + count
            apart = np.linalg.norm(points - centre, axis=1).min() > BETWEEN
            if apart and np.linalg.norm(centre) <= nearest + RELEVANT:
                points = np.vstack([points, centre])
        if len(points) == before:
            return points, taken
        if len(points) > MANY:
            break
    raise ScenarioError(
        f"failures are as likely in {len(points)} directions or more, too many to sample about each of them; "
        'take method = "subset"'
    )


def valleys(points: np.ndarray, failures: np.ndarray) -> np.ndarray:
    """Those of the centres that are nearest to the origin among their neighbours, nearest first; a failure beside one
    of them that is nearer takes its place."""
    points = _nearest_first(points)
    lone = [all(np.linalg.norm(x - y) > VALLEY for y in points[:n]) for n, x in enumerate(points)]
    beside = [failures[np.linalg.norm(failures - x, axis=1) < BETWEEN] for x in points[lone]]
    own = zip(points[lone], beside, strict=True)
    return _nearest_first(np.array([_nearest_first(np.vstack([x, near]))[0] for x, near in own]))


def _nearest_first(points: np.ndarray) -> np.ndarray:
    found: np.ndarray = points[np.argsort(np.linalg.norm(points, axis=1), kind="stable")]
    return found


def _nearer(margins: Margins, z: np.ndarray, rng: np.random.Generator) -> tuple[np.ndarray, int]:
    """A failure nearer to the origin than this one, in the same region of failures, and the runs that this took. Along
    the normal of the limit's tangent plane, from the margins next to it; where these say nothing (a jump, runs that
    fail), along the way from what is safe about it to what fails."""
    g, slope, taken = gradient(margins, z)
    square = float(slope @ slope)
    tried = ON_RAY[:, None] * z
    if 0.0 < square < np.inf:
        tried = np.vstack([tried, BEYOND[:, None] * ((slope @ z - g) / square * slope)])
    fails = finite(margins(tried)) <= 0.0
    taken += len(tried)
    z = tried[int(np.argmin(np.where(fails, np.linalg.norm(tried, axis=1), np.inf)))]
    if fails[len(ON_RAY) :].any():
        return z, taken
    normal, runs = np.zeros(len(z)), AROUND + AROUND_EACH * len(z)
    for _ in range(TURNS):
        x = z + rng.standard_normal((runs, len(z)))
        fails = finite(margins(x)) <= 0.0
        taken += runs
        if not 0 < fails.sum() < runs:
            break
        normal += x[fails].mean(axis=0) - x[~fails].mean(axis=0)
        foot = float(z @ normal) / float(normal @ normal) * normal
        tried = (ON_FOOT[:, None, None] * (z + PARTS[:, None] * (foot - z))).reshape(-1, len(z))
        fails = finite(margins(tried)) <= 0.0
        taken += len(tried)
        lengths = np.where(fails, np.linalg.norm(tried, axis=1), np.linalg.norm(z))
        if lengths.min() < np.linalg.norm(z):
            z = tried[int(np.argmin(lengths))]
    return z, taken
