"""Which mode is which over the runs.

A mode keeps its number by its shape: the modal assurance criterion |a^H W b|^2 / (a^H W a)(b^H W b), W the masses and
mean moments of inertia of the bodies, and pairs that give the largest sum (Allemang 2003, The modal assurance
criterion, Sound and Vibration). Where one number is swept each run is compared with its neighbour, else with the first
run. Of equal shapes, such as those by which a damped pair has become two real modes, the nearer eigenvalue counts,
which is then the slower of the two.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from lienumba.mechanics.mechanism.model import Model

Array = npt.NDArray[Any]
EQUAL = 1e-9  # of the largest frequency: two that differ by less are equal
NEARNESS = 1e-3  # what equal eigenvalues count, where equal shapes count 1
TINY = np.finfo(float).tiny


def _none() -> Array:
    return np.zeros((0, 0))


@dataclass(frozen=True)
class Tracked:
    """Eigenvalues (runs, modes), shapes (runs, modes, 6 k), and MAC with the mode of the run it was compared with."""

    values: Array
    shapes: Array = field(default_factory=_none)
    mac: Array = field(default_factory=_none)


def weights_of(model: Model) -> Array:
    """The weights of shapes (6 k): for the shift and turn of each body its mass and mean moment of inertia."""
    weights: list[float] = []
    for body in model.bodies:
        weights += [float(body.mass)] * 3 + [float(sum(body.inertia[:3])) / 3.0] * 3
    return np.array(weights)


def compared(there: Array, samples: Mapping[str, Array]) -> tuple[Array, Array]:
    """Runs (indices), and the one with which each is compared, which comes before it; the first with itself. there
    (runs,): which have modes."""
    runs = np.flatnonzero(there)
    if len(samples) == 1:
        runs = runs[np.argsort(next(iter(samples.values()))[runs], kind="stable")]
        return runs, np.concatenate([runs[:1], runs[:-1]])
    return runs, np.repeat(runs[:1], len(runs))


def tracked(values: Array, shapes: Array, weights: Array, samples: Mapping[str, Array]) -> Tracked:
    """Give modes that are alike one number in all runs.

    values (runs, modes), shapes (runs, modes, 6 k): in the order of frequencies, NaN where there are fewer.
    """
    from scipy.optimize import linear_sum_assignment

    values, shapes, units = values.copy(), shapes.copy(), _unit(shapes, weights)
    mac = np.where(np.isnan(values.real), np.nan, 1.0)
    runs, others = compared(np.isfinite(values.real).any(axis=1), samples)
    for run, other in zip(runs[1:], others[1:], strict=True):
        alike = np.abs(units[other].conj() * weights @ units[run].T) ** 2
        apart = np.abs(values[other][:, None] - values[run]) / (np.nanmean(np.abs(values[other])) + TINY)
        order = linear_sum_assignment(-alike - NEARNESS * np.nan_to_num(1.0 / (1.0 + apart)))[1]
        values[run], shapes[run], units[run] = values[run][order], shapes[run][order], units[run][order]
        mac[run] = np.where(np.isnan(values[other].real), np.nan, alike[np.arange(len(order)), order])
    return Tracked(values, shapes, np.where(np.isnan(values.real), np.nan, mac))


def crossings(values: Array) -> Array:
    """Whether the frequency of a mode (runs, modes) is on the other side of that of some mode than in the first run
    where these two differ."""
    frequency = values.imag
    least = EQUAL * np.nanmax(np.abs(frequency), axis=1, initial=0.0)[:, None]
    crossed = np.zeros(frequency.shape, bool)
    for n in range(frequency.shape[1]):
        above = np.nan_to_num(frequency - frequency[:, n : n + 1])
        side = np.where(np.abs(above) > least, np.sign(above), 0.0)
        first = (side != 0.0).argmax(axis=0)
        crossed |= side * side[first, np.arange(len(first))] < 0.0
    return crossed


def _unit(shapes: Array, weights: Array) -> Array:
    """Shapes of length 1; 0 where nothing moves, or there is none."""
    finite = np.nan_to_num(shapes)
    sizes = np.sqrt((np.abs(finite) ** 2 * weights).sum(axis=2, keepdims=True))
    sizes[sizes == 0.0] = 1.0
    return finite / sizes
