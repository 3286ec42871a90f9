"""Attitudes as people understand them: the angles of the axes of a body from where they should be.

The reference of each axis is, of a sweep, its direction in the nominal run at that time, or, without one, its mean
direction over the runs (the mean of the unit vectors, made a unit vector again); of a single run, its direction at the
start. Angles are between 0 and 180 degrees, 2 asin(|a - b|/2), which is exact where a and b are near.
"""

from __future__ import annotations

import numpy as np

NOMINAL, MEAN, START = "the nominal run", "their mean directions", "the start"


def angles(directions: np.ndarray, reference: np.ndarray) -> np.ndarray:
    """The angles (degrees) between unit vectors (..., 3) and others that broadcast to them."""
    half: np.ndarray = 0.5 * np.linalg.norm(directions - reference, axis=-1)
    return np.degrees(2.0 * np.arcsin(np.minimum(half, 1.0)))


def mean_directions(total: np.ndarray) -> np.ndarray:
    """The mean directions of unit vectors whose sums (..., 3) these are; NaN where the sum is 0."""
    length = np.linalg.norm(total, axis=-1, keepdims=True)
    with np.errstate(invalid="ignore"):
        mean: np.ndarray = total / length
    return mean
