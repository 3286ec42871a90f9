"""Elementary effects of a sweep with `sampler = "morris"`: the change of an output when one input moves, over how far
it moves in its probability; of a vector, which moves as a whole, over 1/2, about which steps lie.

mu_star, the mean of their sizes, says how much an input matters; mu, their mean, in which direction; sigma, their
deviation, whether its effect is straight and the same wherever the others are. Rows of runs are independent, so that
the intervals of means are Student's, and that of sigma is of its logarithm, by the kurtosis of the effects.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import exp, nan

import numpy as np

from lienumba.analysis.sensitivities.sobol import ENDS, columns_of, sampled_inputs, table_of
from lienumba.scenario.base.toml import Tables
from lienumba.sweep.confidence import half_width
from lienumba.sweep.samplers.morris import moved, places, runs_of_row
from lienumba.sweep.samplers.streams import uniforms

CONFIDENCE = 0.95
FEWEST, FEWEST_OF_SIGMA = 4, 50  # effects from which on there are intervals


@dataclass(frozen=True)
class Design:
    """Of each input which run (index) stands before it moves, and which behind it (2, rows), by how much of its
    probability it moves (rows,), below 0 downwards, and whether that has a direction, which a vector has not."""

    steps: Mapping[str, tuple[np.ndarray, np.ndarray, bool]]
    rows: int


def design_of(labels: np.ndarray, sweep: Tables, samples: Mapping[str, np.ndarray]) -> Design:
    """Of a dataset with these labels (runs,) and samples (runs,)."""
    inputs, seed = sampled_inputs(sweep), int(sweep.get("seed", 0))
    rows, table = table_of(labels, runs_of_row(len(inputs)))
    each, steps = np.arange(len(rows)), {}
    for name, part in zip(inputs, places(inputs, rows, seed), strict=True):
        ends = np.array([table[each, part - 1], table[each, part]])
        both = (ends >= 0).all(axis=0)
        ends, size = ends[:, both], np.full(int(both.sum()), 0.5)
        directed = columns_of(name, list(samples)) == [name]
        if directed:
            u, x = uniforms(name, rows[both], seed), samples[name]
            size = abs(moved(u, name, rows[both], seed) - u) * np.where(x[ends[1]] < x[ends[0]], -1.0, 1.0)
        steps[name] = ends, size, directed
    return Design(steps, len(rows))


def effects(values: np.ndarray, design: Design) -> dict[str, dict[str, float]]:
    """Of an output (runs,), by the names of inputs: mean size, mean and deviation with the ends of their 95 %
    intervals, the latter two of what has a direction."""
    return {name: _effects(values, *steps) for name, steps in design.steps.items()}


def _effects(values: np.ndarray, ends: np.ndarray, size: np.ndarray, directed: bool) -> dict[str, float]:
    found = (values[ends[1]] - values[ends[0]]) / size
    found = found[np.isfinite(found)]
    if len(found) < FEWEST:
        return {}
    every = {"mu_star": _mean(abs(found))} | ({"mu": _mean(found), "sigma": _deviation(found)} if directed else {})
    return {f"{name}{end}": x for name, own in every.items() for end, x in zip(ENDS, own, strict=True)}


def _mean(x: np.ndarray) -> tuple[float, float, float]:
    mean, half = float(x.mean()), float(half_width(x.std(ddof=1), len(x), CONFIDENCE))
    return mean, mean - half, mean + half


def _deviation(x: np.ndarray) -> tuple[float, float, float]:
    """That of the logarithm of a variance is about ((kurtosis - 1)/n)^(1/2)."""
    n, rest = len(x), x - x.mean()
    sigma = float(x.std(ddof=1))
    square = float((rest**2).mean())
    if n < FEWEST_OF_SIGMA or not square > 0.0:
        return sigma, nan, nan
    kurtosis = float((rest**4).mean()) / square**2
    half = float(half_width(0.5 * max(kurtosis - 1.0, 2.0) ** 0.5, n, CONFIDENCE))
    return sigma, sigma * exp(-half), sigma * exp(half)
