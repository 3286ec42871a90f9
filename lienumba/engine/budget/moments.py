"""Means and covariances of the inputs of a sweep."""

import numpy as np

from lienumba.scenario.resolve import Scenario
from lienumba.scenario.start.design import draw, weights
from lienumba.sweep.distributions.base import NUMBER
from lienumba.sweep.distributions.external import Column, Expression
from lienumba.sweep.normal import probability
from lienumba.sweep.samplers import GROWING, SAMPLERS

POINTS = 2**14  # of the Sobol' sequence, by which correlations are known to some 1e-4
REACH, SCORES = 8.0, 2**13 + 1  # of the trapezoidal rule over normal scores: exact to rounding where samples are smooth


def moments(resolved: Scenario) -> tuple[np.ndarray, np.ndarray]:
    """Means (inputs,) and covariances (inputs, inputs) of all columns of the sweep: by its table, if it has one; else
    those of single numbers by quadrature, and what belongs together by points spread evenly."""
    sweep = resolved.data.sweep
    given = SAMPLERS[sweep.sampler].from_table or any(isinstance(x, Column) for x in sweep.vary.values())
    if sweep.table is not None and given:
        labels = range(sweep.table.end()) if sweep.table.runs is None else sorted(sweep.table.runs)
        parts = weights(resolved, list(labels)) if resolved.weighted else np.ones(len(labels))
        every = np.stack([*draw(resolved, labels).values()])
        return np.average(every, axis=1, weights=parts), np.atleast_2d(np.cov(every, aweights=parts))
    mean, covariance = _together(resolved)
    kinds = [kind for path, kind in sweep.vary.items() for _ in kind.columns(path)]
    single = np.array([x.shape == NUMBER and x.dimensions == 1 and not isinstance(x, Expression) for x in kinds])
    own_mean, own_variance = _apart(resolved)
    mean = np.where(single, own_mean, mean)
    before = np.diag(covariance)
    ratio = np.divide(own_variance, before, out=np.ones_like(before), where=single & (before > 0.0))
    return mean, covariance * np.sqrt(np.outer(ratio, ratio))


def _together(resolved: Scenario) -> tuple[np.ndarray, np.ndarray]:
    """Of all columns, by the Sobol' sequence."""
    sweep = resolved.data.sweep
    streams = {path: kind.streams(path) for path, kind in sweep.vary.items()}
    uniforms = SAMPLERS[GROWING].draw(streams, np.arange(POINTS), sweep.seed, POINTS)
    every = np.stack([*draw(resolved, range(POINTS), uniforms).values()])
    covariance = np.atleast_2d(np.cov(every))
    if not sweep.correlate and not any(isinstance(kind, Expression) for kind in sweep.vary.values()):
        owners = [path for path, kind in sweep.vary.items() for _ in kind.columns(path)]
        covariance *= np.equal.outer(owners, owners)  # those of different paths are independent
    return every.mean(axis=1), covariance


def _apart(resolved: Scenario) -> tuple[np.ndarray, np.ndarray]:
    """Means and variances (inputs,) of columns that each follow from one random number."""
    scores = np.linspace(-REACH, REACH, SCORES)
    density = np.exp(-0.5 * scores**2)
    parts = density / density.sum()
    streams = [name for path, kind in resolved.data.sweep.vary.items() for name in kind.streams(path)]
    uniforms = dict.fromkeys(streams, probability(scores))
    every = np.stack([*draw(resolved, range(SCORES), uniforms, correlate=False).values()])
    mean = every @ parts
    return mean, (every - mean[:, None]) ** 2 @ parts
