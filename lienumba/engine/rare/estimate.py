"""What is said of the probability that a margin is below 0, of standard normal numbers.

Margins are functions of many points at once, (n, d) to (n,); NaN and minus infinity are failures. All is decided by
the seed.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import exp, log
from typing import Protocol, runtime_checkable

import numpy as np

Margins = Callable[[np.ndarray], np.ndarray]
STEP = 0.02  # of differences, in standard deviations
REPLICAS = 4  # independent subset simulations, whose scatter is the interval; random numbers of others follow


@runtime_checkable
class Differentiable(Protocol):
    """Margins that know derivatives."""

    def gradient(self, z: np.ndarray) -> tuple[float, np.ndarray, int]:
        """The margin at a point (d,), its exact gradient there, NaN where there is none, and the runs taken."""
        ...


@dataclass(frozen=True)
class Estimate:
    """A probability with its interval. runs: that it took; design_points (k, d): where failures are most probable,
    nearest first, and their distances from the origin; of FORM and importance sampling."""

    method: str
    probability: float
    low: float
    high: float
    confidence: float
    runs: int
    design_points: np.ndarray
    distances: np.ndarray


def around(mean: float, half: float) -> tuple[float, float]:
    """An interval of a probability, from half of the one of its logarithm."""
    return mean * exp(-half), mean * exp(half) if half < -log(mean) else 1.0


def finite(g: np.ndarray) -> np.ndarray:
    """Margins, where runs that have none, or minus infinity, fail farther than any other."""
    finite = g > -np.inf
    least = float(g[finite].min()) if finite.any() else 0.0
    return np.where(finite, g, min(least, 0.0) - 1.0)


def gradient(margins: Margins, z: np.ndarray) -> tuple[float, np.ndarray, int]:
    """The margin at a point (d,), its gradient there, by differences where no exact one is known, and the runs that
    this took."""
    d, taken = len(z), 0
    if isinstance(margins, Differentiable):
        margin, exact, taken = margins.gradient(z)
        if np.isfinite(exact).all():
            return margin, exact, taken
    g = margins(np.vstack([z, z + STEP * np.eye(d), z - STEP * np.eye(d)]))
    with np.errstate(invalid="ignore"):
        return float(g[0]), (g[1 : d + 1] - g[d + 1 :]) / (2.0 * STEP), taken + len(g)
