"""Observed orders of convergence, each with a 95 % confidence interval.

The order is the slope of the least-squares line of log error over log step (the mean step of the point). Not every
point lies on that line. Errors below a hundred times that of the reference, or of rounding, are left out, and so are
points at which runs failed. Of the others the three finest begin the line, since an order shows where steps are small;
a coarser one joins as long as it lies within the 95 % prediction interval of the line through those before it, so that
the range ends where the steps are too coarse to show the order. The interval is that of the slope in this regression
(Student's t): the scatter of the points is how far they are from one line. Where that is nothing but chance, choosing
the range leaves about 90 % of the 95 %.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import nan
from typing import TYPE_CHECKING

from lienumba.analysis.study import REFINING, check, curves, other_dims
from lienumba.errors import ScenarioError
from lienumba.store.study_layout import ERRORS, TRUSTED, typical

if TYPE_CHECKING:
    import numpy as np
    import xarray as xr

CONFIDENCE = 0.95
FEWEST = 3  # points of a line that can say how sure it is
EXACT = 1e-9  # of an error, relative: points nearer than this to a line lie on it


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
    """The observed orders of a study: `order` between `low` and `high` from so many `points`, for steps (s) from
    `finest` to `coarsest`.

    Dimensions: `error` (position, rotation, velocity, angular_velocity) and those of the grid but for the step or
    tolerance; of several grids `curve`. Of a sweep, the median error of the runs counts.
    """
    import numpy as np
    import xarray as xr

    check(ds)
    lines = curves(ds)
    if not lines:
        raise ScenarioError(f"the study has no grid over {' or '.join(REFINING)}, so there is no order to observe")
    names = [name for name in ERRORS if f"{name}_error" in ds]
    steps = (typical(ds, "end_time") / typical(ds, "steps")).values.ravel()
    usable = _all_succeeded(ds)
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
    """The order of errors over steps (s), as the head of this file says; floor: the errors of the reference."""
    import numpy as np

    with np.errstate(invalid="ignore"):
        usable = np.flatnonzero((errors > TRUSTED * floor) & (errors > 0.0) & (steps > 0.0) & np.isfinite(errors))
    usable = usable[np.argsort(steps[usable], kind="stable")]
    x, y, own = np.log(steps[usable]), np.log(errors[usable]), EXACT + floor[usable] / errors[usable]
    if len(np.unique(x)) < 2:
        return Fit(points=len(usable))
    if len(x) < FEWEST:
        slope = (y[1] - y[0]) / (x[1] - x[0])
        return Fit(float(slope), nan, nan, 2, *_range(steps[usable]))
    line = Line.through(x[:FEWEST], y[:FEWEST])
    for n in range(FEWEST, len(x)):
        if abs(y[n] - line.at(x[n])) > line.uncertainty(x[n]) + own[n]:
            break
        line = Line.through(x[: n + 1], y[: n + 1])
    half = line.quantile * line.scatter / line.spread**0.5
    return Fit(line.slope, line.slope - half, line.slope + half, line.points, *_range(steps[usable][: line.points]))


def _range(steps: np.ndarray) -> tuple[float, float]:
    return float(steps[0]), float(steps[-1])


@dataclass(frozen=True)
class Line:
    """A least-squares line. scatter: the standard deviation of the points about it; spread: the sum of squares of
    x about its mean; quantile: of Student's t."""

    slope: float
    mean: tuple[float, float]
    scatter: float
    spread: float
    points: int

    @staticmethod
    def through(x: np.ndarray, y: np.ndarray) -> Line:
        """Through at least three points."""
        dx, dy = x - x.mean(), y - y.mean()
        spread = float((dx * dx).sum())
        slope = float((dx * dy).sum()) / spread
        rest = dy - slope * dx
        scatter = float((rest * rest).sum() / (len(x) - 2)) ** 0.5
        return Line(slope, (float(x.mean()), float(y.mean())), scatter, spread, len(x))

    @property
    def quantile(self) -> float:
        from scipy.special import stdtrit

        return float(stdtrit(self.points - 2, 0.5 + 0.5 * CONFIDENCE))

    def at(self, x: float) -> float:
        return self.mean[1] + self.slope * (x - self.mean[0])

    def uncertainty(self, x: float) -> float:
        """Half the prediction interval of a further point at x."""
        offset = x - self.mean[0]
        return self.quantile * self.scatter * (1.0 + 1.0 / self.points + offset * offset / self.spread) ** 0.5
