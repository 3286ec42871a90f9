"""Means and covariances of the inputs of a sweep."""

import numpy as np

from lienumba.scenario.resolve import Scenario
from lienumba.scenario.start.design import draw, weights
from lienumba.sweep.distributions.external import Column, Expression
from lienumba.sweep.samplers import GROWING, SAMPLERS

POINTS = 2**14  # of the Sobol' sequence, by which moments are known to some 1e-4 of a standard deviation


def moments(resolved: Scenario) -> tuple[np.ndarray, np.ndarray]:
    """Means (inputs,) and covariances (inputs, inputs) of all columns of the sweep, by points spread evenly over their
    distributions, or by the table that gives them."""
    sweep = resolved.data.sweep
    if sweep.table is not None and (
        SAMPLERS[sweep.sampler].from_table or any(isinstance(x, Column) for x in sweep.vary.values())
    ):
        labels = range(sweep.table.end()) if sweep.table.runs is None else sorted(sweep.table.runs)
        samples = draw(resolved, labels)
        parts = weights(resolved, list(labels)) if resolved.weighted else np.ones(len(labels))
        every = np.stack([*samples.values()])
        return np.average(every, axis=1, weights=parts), np.atleast_2d(np.cov(every, aweights=parts))
    streams = {path: kind.streams(path) for path, kind in sweep.vary.items()}
    uniforms = SAMPLERS[GROWING].draw(streams, np.arange(POINTS), sweep.seed, POINTS)
    samples = draw(resolved, range(POINTS), uniforms)
    every = np.stack([*samples.values()])
    covariance = np.atleast_2d(np.cov(every))
    if not sweep.correlate and not any(isinstance(kind, Expression) for kind in sweep.vary.values()):
        owners = [path for path, kind in sweep.vary.items() for _ in kind.columns(path)]
        covariance *= np.equal.outer(owners, owners)  # those of different paths are independent
    return every.mean(axis=1), covariance
