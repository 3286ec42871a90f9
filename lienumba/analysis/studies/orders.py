"""Observed orders of convergence, each with a 95 % confidence interval.

The order is p in error = C h^p exp(b h), which has the first two terms of the expansion of an error in the mean step h:
least squares of log error on log h and h; of three points, without b. Not every point belongs to that. Errors below a
hundred times that of the reference, or of rounding, are left out, and so are points at which runs failed. Of the others
the finest begin, since an order shows where steps are small; a coarser one joins as long as it lies within the 95 %
prediction interval of those before it, so that the range ends where the steps are too coarse. The interval is that of p
in this regression (Student's t): how far the points are from such a law. Where that is nothing but chance, choosing the
range leaves about 90 % of the 95 %.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import nan

import numpy as np
import xarray as xr

from lienumba.analysis.studies.study import REFINING, check_study, curves, other_dims, steps_of
from lienumba.errors import ScenarioError
from lienumba.store.study_layout import TRUSTED, errors_of, typical

CONFIDENCE = 0.95
FEWEST = 3  # points that say how sure an order is
EXACT = 1e-9  # of an error, relative: points nearer than this to a law obey it


@dataclass(frozen=True)
class Fit:
    """order: low to high with 95 % confidence; points: how many it is from, the steps (s) from finest to coarsest."""

    order: float = nan
    low: float = nan
    high: float = nan
    points: int = 0
    finest: float = nan
    coarsest: float = nan


def orders(ds: xr.Dataset) -> xr.Dataset:
    """The observed orders of a study, each with its 95 % confidence interval.

    Parameters
    ----------
    ds : xarray.Dataset
        What `lienumba.run` returned of a scenario with [study]. Of a sweep, the median error of the runs counts.

    Returns
    -------
    xarray.Dataset
        `order` between `low` and `high` from so many `points`, for steps (s) from `finest` to `coarsest`. Dimensions:
        `error` (position, rotation, velocity, angular_velocity, measures) and those of the grid but for the step or
        tolerance; of several grids `curve`.
    """
    check_study(ds)
    lines = curves(ds)
    if not lines:
        raise ScenarioError(f"the study has no grid over {' or '.join(REFINING)}, so there is no order to observe")
    names = [*errors_of(ds)]
    steps, usable = steps_of(ds), _all_succeeded(ds)
    fits = []
    for name in names:
        error, floor = (typical(ds, f"{kind}{name}_error").values.ravel() for kind in ("", "reference_"))
        error = np.where(usable, error, np.nan)
        fits.append([fit(steps[line.points], error[line.points], floor[line.points]) for line in lines])
    dims = other_dims(ds)
    coordinates = {str(name): x for name, x in ds.coords.items() if x.attrs.get("role") == "grid" and x.dims[0] in dims}
    if dims == ("curve",):
        coordinates = {name: ("curve", np.array([line.labels[name] for line in lines])) for name in lines[0].labels}
        coordinates["along"] = ("curve", np.array([line.along for line in lines]))
    shape = (len(names), *(ds.sizes[dim] if dim in ds.sizes else len(lines) for dim in dims))
    found = {}
    for key, (units, long_name) in TEXTS.items():
        values = np.array([[getattr(one, key) for one in row] for row in fits]).reshape(shape)
        found[key] = xr.Variable(("error", *dims), values, {"units": units, "long_name": long_name})
    return xr.Dataset(found, {"error": names, **coordinates})


TEXTS = {
    "order": ("1", "observed order"),
    "low": ("1", "lower end of the 95 % confidence interval"),
    "high": ("1", "upper end of the 95 % confidence interval"),
    "points": ("1", "number of points"),
    "finest": ("s", "smallest mean step"),
    "coarsest": ("s", "largest mean step"),
}


def _all_succeeded(ds: xr.Dataset) -> np.ndarray:
    """Whether all runs succeeded at a point, but for those that do nowhere: then points have the same samples."""
    good = ds["status"].values.reshape(ds.sizes["run"], -1) == 0
    somewhere = good.any(axis=1)
    all_of_them: np.ndarray = good[somewhere].all(axis=0) & somewhere.any()
    return all_of_them


def fit(steps: np.ndarray, errors: np.ndarray, floor: np.ndarray) -> Fit:
    """The order of errors over steps (s, each once), as said at the top of this file; floor: the errors of the
    reference."""
    with np.errstate(invalid="ignore"):
        usable = np.flatnonzero((errors > TRUSTED * floor) & (errors > 0.0) & (steps > 0.0) & np.isfinite(errors))
    h, first = np.unique(steps[usable], return_index=True)
    usable = usable[first]
    y, own = np.log(errors[usable]), EXACT + floor[usable] / errors[usable]
    if len(h) < 2:
        return Fit(points=len(h))
    if len(h) < FEWEST:
        return Fit(float((y[1] - y[0]) / np.log(h[1] / h[0])), points=len(h), finest=float(h[0]), coarsest=float(h[-1]))
    columns = np.stack([np.ones(len(h)), np.log(h), h / h[-1]][: len(h) - 1], axis=1)
    points = columns.shape[1] + 1
    found, covariance, variance, quantile = _regression(columns[:points], y[:points])
    for row, value, slack in zip(columns[points:], y[points:], own[points:], strict=True):
        uncertainty = quantile * (variance + row @ covariance @ row) ** 0.5  # half the prediction interval
        if abs(value - row @ found) > uncertainty + slack:
            break
        points += 1
        found, covariance, variance, quantile = _regression(columns[:points], y[:points])
    order, half = float(found[1]), float(quantile * covariance[1, 1] ** 0.5)
    return Fit(order, order - half, order + half, points, float(h[0]), float(h[points - 1]))


def _regression(columns: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray, float, float]:
    """Least squares: the coefficients, their covariance, the variance of what is left, and the quantile of Student's t
    with as many degrees of freedom as there are values more than coefficients."""
    from scipy.special import stdtrit

    Q, R = np.linalg.qr(columns)
    inverse = np.linalg.inv(R)
    found, freedom = inverse @ (Q.T @ y), len(y) - columns.shape[1]
    rest = y - columns @ found
    variance = float(rest @ rest) / freedom
    return found, variance * inverse @ inverse.T, variance, float(stdtrit(freedom, 0.5 + 0.5 * CONFIDENCE))
