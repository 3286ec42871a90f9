"""Latin hypercubes of standard normal points about a centre."""

import numpy as np
from scipy import stats


def about(centre: np.ndarray, n: int, rng: np.random.Generator) -> np.ndarray:
    """n standard normal points about a centre, a Latin hypercube in axes of which the first leads from the origin to
    it: a reflection turns them there."""
    places = rng.permuted(np.tile(np.arange(n)[:, None], len(centre)), axis=0)
    within = rng.uniform(1e-9, 1.0 - 1e-9, places.shape)  # not on an end, which is infinitely far away
    z: np.ndarray = stats.norm.ppf((places + within) / n)
    mirror = centre + np.copysign(np.linalg.norm(centre), centre[0]) * np.eye(len(centre))[0]
    square = float(mirror @ mirror)
    return centre + (z - np.outer(z @ mirror, 2.0 / square * mirror) if square > 0.0 else z)
