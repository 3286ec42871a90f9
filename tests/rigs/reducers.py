"""Numbers of courses, for measures."""

import numpy as np


def swept(tip):
    """The length of the way of a point between stored times."""
    return np.linalg.norm(np.diff(tip, axis=0), axis=1).sum()
