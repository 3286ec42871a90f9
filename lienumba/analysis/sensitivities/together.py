"""How much of the variance of an output two inputs explain together beyond what each does alone: second Sobol' indices
of any independent runs.

As `explained`, with parabolas in both inputs on k by k cells of as many runs each, from which the fits of either input
alone are taken off. What jumps across cells is smoothed: the difference to half as many cells along each input, by
which it shrinks as they do, widens the interval.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from lienumba.analysis.sensitivities.explained import Fit, fit, half_of

FEWEST = 500  # runs, from which on intervals hold what they say (docs/statistics.md)
FEWEST_OF_TWO = 50  # runs with the rarer of two values
MOST, MOST_INPUTS = 10_000, 24  # runs and inputs that are looked at
SMALLEST = 30  # cell
DIFFER = 1e-10  # of the largest: squares of columns that are others than those before
COARSE = 1.5  # times the difference to coarser cells


def second_indices(inputs: Sequence[np.ndarray], y: np.ndarray, evenly: bool = False) -> np.ndarray | None:
    """The indices of pairs of inputs (n,) for an output y (n,), with the ends of their 95 % intervals (3, d, d), NaN
    where no pair is; None of too few runs, or too many inputs. evenly: as for `explained`."""
    d, y = len(inputs), y[:MOST]
    rarer = min(np.count_nonzero(y == y[0]), np.count_nonzero(y != y[0])) if len(y) else 0
    if not 2 <= d <= MOST_INPUTS or len(y) < FEWEST or (len(np.unique(y)) == 2 and rarer < FEWEST_OF_TWO):
        return None
    inputs, y = [x[:MOST] for x in inputs], y - y.mean()
    alone, found = [fit(x, y) for x in inputs], np.full((3, d, d), np.nan)
    for k, m in zip(*np.triu_indices(d, 1), strict=True):
        found[:, k, m] = _pair(inputs[k], inputs[m], y, (alone[k], alone[m]), evenly)
    return found


def _pair(
    x: np.ndarray, z: np.ndarray, y: np.ndarray, alone: tuple[Fit, Fit], evenly: bool
) -> tuple[float, float, float]:
    """The index, and the ends of its interval."""
    n = len(y)
    scale, variance = 1.0 / float(y @ y), float(y @ y) / (n - 1)
    k = max(min(round(2.0 * n**0.2), int((n / SMALLEST) ** 0.5)), 1)
    both, coarse = _fit(x, z, y, k), _fit(x, z, y, max(k // 2, 1))
    index = scale * (both.squares - sum(one.squares for one in alone))
    of_lines = scale * (both.of_lines - sum(one.of_lines for one in alone))
    explained = y * y - (y - both.m) ** 2 - sum(y * y - (y - one.m) ** 2 for one in alone)
    widest = max(abs(index - of_lines), COARSE * scale * abs(both.squares - coarse.squares))
    half = half_of((explained - index * y * y) / variance, both, variance, widest)
    if evenly:
        more, less = (0.5 * scale * x for x in (both.added, sum(one.added for one in alone)))
        index, half = index + more - less, half + more + less
    return index, index - half, index + half


def _fit(x: np.ndarray, z: np.ndarray, y: np.ndarray, k: int) -> Fit:
    """That of k by k cells."""
    slices = np.array_split(np.argsort(x, kind="stable"), k)
    cells = [cell for own in slices for cell in np.array_split(own[np.argsort(z[own], kind="stable")], k)]
    m, squares, of_lines, added, noise, coefficients = np.empty(len(y)), 0.0, 0.0, 0.0, 0.0, 0
    for size in {len(cell) for cell in cells}:
        some = np.stack([cell for cell in cells if len(cell) == size])
        own = y[some]
        columns = _columns(x[some], z[some])
        lines, _ = _projected(columns[..., :3], own)
        part, p = _projected(columns, own)
        s2 = ((own - part) ** 2).sum(axis=1) / (size - p)
        m[some] = part
        squares += float(((part**2).sum(axis=1) - p * s2).sum())
        of_lines += float(((lines**2).sum(axis=1) - np.minimum(p, 3) * s2).sum())
        added += float((p * s2).sum())
        noise += float((2.0 * s2 * s2 * p * size / (size - p)).sum())
        coefficients += int(p.sum())
    return Fit(m, squares, of_lines, added, noise, coefficients)


def _columns(x: np.ndarray, z: np.ndarray) -> np.ndarray:
    """Powers of both inputs (cells, runs) up to the second (cells, runs, 6), about their means."""
    x, z = (t - t.mean(axis=1, keepdims=True) for t in (x, z))
    x, z = (t / np.maximum(abs(t).max(axis=1, keepdims=True), np.finfo(float).tiny) for t in (x, z))
    return np.stack([np.ones_like(x), x, z, x * x, x * z, z * z], axis=-1)


def _projected(columns: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Outputs (cells, runs) as far as columns (cells, runs, p) make them, and how many of these differ (cells,)."""
    transposed = columns.swapaxes(1, 2)
    sizes, vectors = np.linalg.eigh(transposed @ columns)
    kept = sizes > DIFFER * sizes[:, -1:]
    part = vectors.swapaxes(1, 2) @ (transposed @ y[..., None])
    part *= np.divide(1.0, sizes, where=kept, out=np.zeros_like(sizes))[..., None]
    return (columns @ (vectors @ part))[..., 0], kept.sum(axis=1)
