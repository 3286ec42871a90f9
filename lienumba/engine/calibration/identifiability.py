"""Which parameters data can tell apart, by the Jacobian of the residuals.

R. Brun, P. Reichert, H. R. Kuensch, Water Resources Research 37 (2001) 1015: the smallest singular value of the
Jacobian with columns of length 1 says how nearly its columns depend on one another; below 1/20 is doubtful.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lienumba.words import listed

NO_EFFECT = 1e-10  # of a change by its own size, relative to that of the parameter with the largest one
NONE_APART = 1e-7  # singular value below which derivatives, accurate to 1e-8, cannot tell it from 0
BARELY = 0.05
HAS_PART = 0.1  # of a direction that is barely seen: components from here on are named
IS_LOST = 1e-4  # of a direction that is not seen at all: what has components from here on has no value


@dataclass(frozen=True)
class Identified:
    """singular_values (parameters,): of the Jacobian with columns of length 1; covariance (parameters, parameters) of
    residuals with standard deviation 1: infinite of parameters that cannot be told; sentence: which these are."""

    singular_values: np.ndarray
    covariance: np.ndarray
    sentence: str


def identified(jacobian: np.ndarray, x: np.ndarray, paths: Sequence[str]) -> Identified:
    """What a Jacobian (residuals, parameters) says at x (parameters,)."""
    lengths = np.linalg.norm(jacobian, axis=0)
    effects = lengths * np.where(x == 0.0, 1.0, np.abs(x))
    still = effects <= NO_EFFECT * effects.max()
    lengths = np.where(lengths == 0.0, 1.0, lengths)
    _, values, directions = np.linalg.svd(np.where(still, 0.0, jacobian / lengths), full_matrices=False)
    sentences = []
    if still.any():
        those = listed(np.array(paths)[still])
        sentences.append(f"the data do not depend on {those}: leave it out, or measure what does")
    lost = still.copy()
    for value, direction in zip(values, directions, strict=True):
        shared = (np.abs(direction) >= (IS_LOST if value <= NONE_APART else HAS_PART)) & ~still
        if value > BARELY or not shared.any():
            continue
        those = listed(np.array(paths)[shared])
        if value <= NONE_APART:
            lost |= shared
            sentences.append(
                f"the data cannot tell {those} apart: hold one of them, or measure what depends on one alone"
            )
        else:
            part = f"a change of one is made good by the others but for 1 part in {1.0 / value:.0f}"
            sentences.append(f"the data can barely tell {those} apart: {part}")
    inverse = np.divide(1.0, values, out=np.zeros_like(values), where=values > NONE_APART)
    scaled = (directions.T * inverse**2) @ directions
    covariance = scaled / np.outer(lengths, lengths)
    covariance[lost] = covariance[:, lost] = np.nan
    covariance[lost, lost] = np.inf
    return Identified(values, covariance, "; ".join(sentences) or "the data tell all parameters apart")
