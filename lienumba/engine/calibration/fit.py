"""Nonlinear least squares with exact Jacobians."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from math import sqrt

import numpy as np
import xarray as xr

from lienumba.batch.statuses import GOOD
from lienumba.engine.calibration.identifiability import Identified, identified
from lienumba.engine.calibration.measured import Recordings
from lienumba.errors import ScenarioError
from lienumba.words import plural

FALLS = 1e-8  # relative, by which the sum of squares falls at least: a thousandth of a standard error
MOVES = 1e-6  # relative, by which parameters change at least: steps that a tolerance chooses make smaller ones noise
STEEP = 1e-10  # gradient of the sum of squares, of parameters relative to where they start
ENDS = {
    0: "the fit is not done: {calls} were not enough; raise max_calls, or start nearer",
    1: "the sum of squares has its minimum here: its gradient vanishes",
    2: "the sum of squares has its minimum here: it falls no more",
    3: "the sum of squares has its minimum here: the parameters change no more",
    4: "the sum of squares has its minimum here: neither it nor the parameters change any more",
}  # by the status of `scipy.optimize.least_squares`
BY = "by_parameter"  # the second dimension of matrices


@dataclass(frozen=True, eq=False)
class Fit:
    """The numbers with which a scenario moves as was measured; made by `Prepared.fit`. Printed, it is a table.

    Parameters
    ----------
    values : dict
        The numbers that were found, by path.
    standard_errors : dict
        Their standard errors, by path; infinite where the data cannot tell.
    covariance, correlation : xarray.DataArray
        Of the numbers that were found (parameter, by_parameter).
    residuals : xarray.Dataset
        What the runs have too much of each variable, in its units.
    scatter : float
        The standard deviation of the residuals: in the units of `sigma`, so near 1 if the model fits and `sigma` is
        right; without `sigma` in those of the variable.
    freedom : int
        Numbers that were measured, less parameters.
    known : bool
        Whether `sigma` was given: else standard errors follow from the scatter.
    singular_values : xarray.DataArray
        Of the Jacobian with columns of length 1, the largest first: near 0 where the data cannot tell parameters apart.
    identifiability : str
        Which parameters the data cannot tell apart, if any.
    calls : int
        How often all recordings were simulated.
    success : bool
        Whether the search has found a minimum.
    message : str
        Why it ended.
    """

    values: dict[str, float]
    standard_errors: dict[str, float]
    covariance: xr.DataArray
    correlation: xr.DataArray
    residuals: xr.Dataset
    scatter: float
    freedom: int
    known: bool
    singular_values: xr.DataArray
    identifiability: str
    calls: int
    success: bool
    message: str

    def intervals(self, confidence: float = 0.95) -> dict[str, tuple[float, float]]:
        """Within which the true numbers lie, if the model is right near them and errors are normal.

        Parameters
        ----------
        confidence : float
            How probable that is, of each.

        Returns
        -------
        dict
            The lower and the upper end, by path.
        """
        from scipy import stats

        if not 0.0 < confidence < 1.0:
            raise ScenarioError.at("confidence", "must be between 0 and 1", "give such as 0.95", confidence)
        tail = 0.5 + 0.5 * confidence
        factor = float(stats.norm.ppf(tail) if self.known else stats.t.ppf(tail, max(self.freedom, 1)))
        ends = {path: factor * error for path, error in self.standard_errors.items()}
        return {path: (x - ends[path], x + ends[path]) for path, x in self.values.items()}

    def __str__(self) -> str:
        width = max(map(len, self.values))
        rows = [f"{path:<{width}}  {x:.8g} +- {self.standard_errors[path]:.2g}" for path, x in self.values.items()]
        return "\n".join([*rows, f"{self.message} ({plural(self.calls, 'call', 'calls')})", self.identifiability])


@dataclass
class Search:
    """Residuals and Jacobians as functions of the parameters. run(numbers): the dataset of all recordings; start: the
    first numbers by path; units: theirs; calls: how many runs there were."""

    run: Callable[[Mapping[str, float]], xr.Dataset]
    recordings: Recordings
    start: dict[str, float]
    units: dict[str, str]
    calls: int = 0
    latest: tuple[bytes, xr.Dataset | None] = (b"", None)
    shape: int = field(default=0)

    def dataset(self, x: np.ndarray) -> xr.Dataset | None:
        """That of these numbers; none if they are no mechanism."""
        if self.latest[0] == x.tobytes():
            return self.latest[1]
        self.calls += 1
        try:
            found = self.run(dict(zip(self.start, x.tolist(), strict=True)))
        except ScenarioError:
            if self.calls == 1:
                raise
            found = None
        self.latest = x.tobytes(), found
        return found

    def residuals(self, x: np.ndarray) -> np.ndarray:
        """In standard deviations; NaN where a run failed, so that the search takes shorter steps."""
        ds = self.dataset(x)
        found = np.full(self.shape, np.nan) if ds is None else self.recordings.residuals(ds)
        self.shape = len(found)
        return found

    def jacobian(self, x: np.ndarray) -> np.ndarray:
        """The derivatives of the residuals (residuals, parameters)."""
        ds = self.dataset(x)
        assert ds is not None, "the search goes on where there are residuals"
        found = self.recordings.jacobian(ds)
        if not np.isfinite(found).all():
            told = ", ".join(f"{path} = {value:.6g}" for path, value in zip(self.start, x, strict=True))
            raise ScenarioError(
                f"at {told} a measured number has no derivative, such as at an event that grazes its condition "
                "(sensitivity_flags); leave out what was measured there (NaN), or start elsewhere"
            )
        return found

    def check(self) -> None:
        """The search can begin."""
        ds, values = self.dataset(np.array([*self.start.values()])), self.residuals(np.array([*self.start.values()]))
        assert ds is not None
        failed = ~ds["status"].isin(GOOD).values
        if failed.any():
            label = int(ds["run"].values[failed][0])
            rule = f"run {label} fails with the values from which the search starts"
            raise ScenarioError.at("parameters", rule, "start elsewhere; Prepared.run says why (status)")
        if not np.isfinite(values).all():
            rule = "something that was measured does not happen with the values from which the search starts"
            raise ScenarioError.at("parameters", rule, "start elsewhere, where all events happen")
        if len(values) < len(self.start):
            rule = f"has {plural(len(values), 'number', 'numbers')} for {len(self.start)} parameters"
            raise ScenarioError.at("measured", rule, "seek fewer parameters, or measure more")


def fit(search: Search, bounds: Mapping[str, tuple[float, float]], max_calls: int) -> Fit:
    """The numbers with which the runs are nearest to what was measured."""
    from scipy.optimize import least_squares

    if isinstance(max_calls, bool) or not isinstance(max_calls, int) or max_calls < 1:
        raise ScenarioError.at("max_calls", "must be a whole number, at least 1", "give such as 100", max_calls)
    start = np.array([*search.start.values()], float)
    ends = _bounds(search.start, bounds)
    search.start = dict(zip(search.start, start.tolist(), strict=True))
    search.check()
    sizes = np.where(start == 0.0, 1.0, np.abs(start))
    found = least_squares(
        lambda y: search.residuals(y * sizes), start / sizes, jac=lambda y: search.jacobian(y * sizes) * sizes,
        bounds=(ends[0] / sizes, ends[1] / sizes), x_scale="jac", ftol=FALLS, xtol=MOVES, gtol=STEEP,
        max_nfev=max_calls,
    )  # fmt: skip
    x = found.x * sizes
    ds = search.dataset(x)
    assert ds is not None
    told = identified(found.jac / sizes, x, list(search.start))
    return _fit(search, ds, told, x, float(found.cost), int(found.status))


def _fit(search: Search, ds: xr.Dataset, told: Identified, x: np.ndarray, cost: float, status: int) -> Fit:
    paths = list(search.start)
    freedom = search.shape - len(paths)
    scatter = sqrt(2.0 * cost / freedom) if freedom else float("nan")
    known = search.recordings.given
    matrix = told.covariance if known else told.covariance * scatter**2
    errors = np.sqrt(np.diag(matrix))
    with np.errstate(invalid="ignore"):
        correlation = matrix / np.outer(errors, errors)
    units = {"units_of_parameters": ", ".join(search.units.values())}

    def square(values: np.ndarray, name: str, more: dict[str, str]) -> xr.DataArray:
        return xr.DataArray(values, {"parameter": paths, BY: paths}, ("parameter", BY), name, more)

    return Fit(
        values=dict(zip(paths, x.tolist(), strict=True)),
        standard_errors=dict(zip(paths, errors.tolist(), strict=True)),
        covariance=square(matrix, "covariance", units),
        correlation=square(correlation, "correlation", {"units": "1"}),
        residuals=search.recordings.differences(ds),
        scatter=scatter,
        freedom=freedom,
        known=known,
        singular_values=xr.DataArray(told.singular_values, dims="direction", name="singular_values"),
        identifiability=told.sentence,
        calls=search.calls,
        success=status > 0,
        message=ENDS[status].format(calls=plural(search.calls, "call", "calls")),
    )


def _bounds(start: Mapping[str, float], bounds: Mapping[str, tuple[float, float]]) -> tuple[np.ndarray, np.ndarray]:
    """The lowest and the highest values (parameters,)."""
    low, high = np.full((2, len(start)), [[-np.inf], [np.inf]])
    for path, ends in bounds.items():
        if path not in start:
            raise ScenarioError.at(f"bounds.{path}", "is none of the parameters", "remove it, or seek it")
        n = list(start).index(path)
        if np.shape(ends) != (2,) or not float(ends[0]) < float(ends[1]):
            raise ScenarioError.at(
                f"bounds.{path}", "must be a lower and an upper end", "give such as (0.0, 10.0)", ends
            )
        low[n], high[n] = map(float, ends)
        if not low[n] <= start[path] <= high[n]:
            raise ScenarioError.at(
                path, f"lies outside its bounds, {low[n]:g} to {high[n]:g}", "start between", start[path]
            )
    return low, high
