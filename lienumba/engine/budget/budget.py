"""The share of each input in the variance of outputs, from one run with derivatives; and runs that check it."""

import os
import warnings
from typing import TYPE_CHECKING, Any

import numpy as np

from lienumba.engine.budget.moments import moments
from lienumba.engine.budget.prediction import Prediction, outputs_of, prediction
from lienumba.engine.progress import shown
from lienumba.engine.runner import check_workers, run
from lienumba.errors import ResultWarning, ScenarioError
from lienumba.scenario.resolve import Scenario, resolve
from lienumba.store import provenance
from lienumba.store.files import reading
from lienumba.store.layout import WEIGHT
from lienumba.store.linear_layout import BUDGET, KIND, dataset
from lienumba.sweep.samplers import DEFAULT, SAMPLERS
from lienumba.words import show

if TYPE_CHECKING:
    import xarray as xr

FEWEST = 10  # runs that check a budget
NEARLY_LINEAR = 0.95  # correlation of prediction and result: the prediction then explains 90 % of the variance
OF_OUTPUT = "output"
TEXTS = {  # of variables
    "nominal": "value in the nominal run",
    "predicted_mean": "mean by the linear prediction",
    "deviation": "standard deviation by the linear prediction",
    "derivative": "derivative of the output by the input, in the nominal run",
    "share": "part of the input in the variance by the linear prediction",
    "input_deviation": "standard deviation of the input",
    "counted": "runs that count",
    "mean": "mean over the runs",
    "mean_error": "its standard error",
    "controlled_mean": "mean over the runs with the linear prediction as control variate",
    "controlled_mean_error": "its standard error",
    "sampled_deviation": "standard deviation over the runs",
    "correlation": "correlation of prediction and result over the runs",
}
PURE = {"share", "counted", "correlation"}  # without units


def budget(
    scenario: Any,
    *,
    of: "str | list[str] | tuple[str, ...]" = (),
    runs: int | None = None,
    sweep: "xr.Dataset | str | os.PathLike[str] | None" = None,
    seed: int | None = None,
    overrides: Any = None,
    workers: int | None = None,
    allow_code: bool = False,
    progress: Any = None,
) -> "xr.Dataset":
    """Say which share each input of a sweep has in the variance of each output, from one run.

    The nominal run is differentiated by all inputs of the sweep. By the derivatives and the covariances of the inputs
    follows the variance of each output, exact where the response is linear. Runs check it, and the linear prediction is
    their control variate: it narrows the mean where it is correlated with the result.

    Parameters
    ----------
    scenario : path, dict, System or Scenario
        With `[sweep.vary]`.
    of : str or sequence of str, optional
        Outputs by the names of the dataset; of courses the last stored time counts. By default those of
        `[sensitivities]`, else measures and times of events.
    runs : int, optional
        Simulate so many random runs to check it.
    sweep : xarray.Dataset or path, optional
        Instead, the dataset of a sweep of this scenario.
    seed, overrides, workers, allow_code, progress
        As in `lienumba.run`.

    Returns
    -------
    xarray.Dataset
        On `output` and `input`: `share`, `derivative`, `input_deviation`; on `output`: `nominal`, `predicted_mean`,
        `deviation`, and of runs `counted`, `mean`, `mean_error`, `controlled_mean`, `controlled_mean_error`,
        `sampled_deviation`, `correlation`. The attribute `notes` has a sentence for what is doubtful.

    Raises
    ------
    ScenarioError
        For bad input, and for outputs that have no derivatives.
    """
    resolved = resolve(scenario, overrides=overrides, seed=seed, allow_code=allow_code, counted=False)
    check_workers(workers)
    _check(resolved, runs, sweep)
    with shown(progress) as tell:
        predicted = prediction(resolved, [of] if isinstance(of, str) else list(of), workers)
        mean, covariance = moments(resolved)
        variables, notes = _linear(predicted, mean, covariance)
        if runs is not None:
            ds = run(_sampled(resolved, runs), workers=workers, progress=tell)
            variables |= _checked(predicted, mean, ds, notes)
        elif sweep is not None:
            with reading(sweep) as (ds, where):
                variables |= _checked(predicted, mean, _counting(ds, where, resolved), notes)
    if resolved.data.model.noise:
        notes.append("[[noise]] is no input: its part of the variance is in the runs alone")
    if not isinstance(scenario, Scenario):  # else the command line tells them
        for sentence in notes:
            warnings.warn(sentence, ResultWarning, stacklevel=2)
    return _dataset(resolved, predicted, variables, notes)


def _check(resolved: Scenario, runs: object, sweep: object) -> None:
    if not resolved.data.sweep.vary:
        raise ScenarioError("sweep.vary: is empty, so no output varies; give inputs and their scatter")
    if runs is not None and sweep is not None:
        raise ScenarioError("runs: are simulated where no sweep is given; leave one of the two out")
    if runs is not None and (isinstance(runs, bool) or not isinstance(runs, int) or runs < FEWEST):
        raise ScenarioError(f"runs = {show(runs)}: must be a whole number, at least {FEWEST}; give such as 200")


def _linear(predicted: Prediction, mean: np.ndarray, covariance: np.ndarray) -> tuple[dict[str, Any], list[str]]:
    """What the derivatives say alone."""
    slopes = predicted.slopes
    parts = slopes * (slopes @ covariance)
    variances = parts.sum(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        shares = parts / variances[:, None]
        deviations = np.sqrt(variances)
    notes = list(predicted.notes)
    for name, row, variance in zip(predicted.names, slopes, variances, strict=True):
        if not np.isfinite(row).all():
            notes.append(f"{name} has no derivative in the nominal run: it does not happen there, or only just")
        elif variance == 0.0:
            notes.append(f"{name} does not change with any input, to first order")
    by = (OF_OUTPUT, "input")
    variables = {
        "nominal": (OF_OUTPUT, predicted.values),
        "predicted_mean": (OF_OUTPUT, predicted.of(mean)),
        "deviation": (OF_OUTPUT, deviations),
        "derivative": (by, slopes),
        "share": (by, shares),
        "input_deviation": ("input", np.sqrt(np.diag(covariance))),
    }
    return variables, notes


def _checked(predicted: Prediction, mean: np.ndarray, ds: "xr.Dataset", notes: list[str]) -> dict[str, Any]:
    """What runs say, alone and with the prediction as control variate."""
    results = outputs_of(ds, predicted.asked)
    guesses = predicted.of(np.stack([ds[path].values for path in predicted.paths], axis=-1))
    rows = [_of_output(y, p, m) for y, p, m in zip(results.T, guesses.T, predicted.of(mean), strict=True)]
    names = ("counted", "mean", "mean_error", "controlled_mean", "controlled_mean_error", "sampled_deviation",
             "correlation")  # fmt: skip
    found = {name: (OF_OUTPUT, column) for name, column in zip(names, np.array(rows).T, strict=True)}
    for name, correlation in zip(predicted.names, found["correlation"][1], strict=True):
        if correlation < NEARLY_LINEAR:
            notes.append(
                f"{name} is not nearly linear in the inputs: prediction and result have a correlation of "
                f"{correlation:.2f}, below {NEARLY_LINEAR:g}; trust the runs, not the shares"
            )
    return found


def _of_output(results: np.ndarray, guesses: np.ndarray, expected: float) -> tuple[float, ...]:
    """Of one output: how many runs count, mean, its error, both with the control variate, deviation, correlation."""
    kept = np.isfinite(results) & np.isfinite(guesses)
    y, p, n = results[kept], guesses[kept], int(kept.sum())
    if n < FEWEST:
        return float(n), *(np.nan,) * 6
    mean, deviation, spread = float(y.mean()), float(y.std(ddof=1)), float(p.std(ddof=1))
    error = deviation / np.sqrt(n)
    if not deviation or not spread:
        return float(n), mean, error, mean, error, deviation, np.nan
    correlation = float(np.corrcoef(y, p)[0, 1])
    slope = correlation * deviation / spread
    left = np.sqrt(max(1.0 - correlation**2, 0.0) * (n - 1) / (n - 2))
    return float(n), mean, error, mean - slope * (float(p.mean()) - expected), error * left, deviation, correlation


def _sampled(resolved: Scenario, runs: int) -> Scenario:
    """The scenario with so many independent runs, and without derivatives."""
    written = {key: x for key, x in resolved.to_dict().items() if key != "sensitivities"}
    own = {key: x for key, x in written["sweep"].items() if key not in ("stop", "proposal")}
    if not SAMPLERS[resolved.data.sweep.sampler].from_table:
        own["sampler"] = DEFAULT
    return resolve({**written, "sweep": {**own, "runs": runs, "nominal": False}})


def _counting(ds: "xr.Dataset", where: str, resolved: Scenario) -> "xr.Dataset":
    """The independent runs of a sweep of this scenario."""
    if ds.attrs["scenario_sha256"] != resolved.sha256():
        raise ScenarioError(f"{where}: is of another scenario, or of other numbers of it; give a sweep of this one")
    if WEIGHT in ds:
        raise ScenarioError(f"{where}: its runs have weights; give a sweep without, or runs = 200")
    inputs = sum(kind.dimensions > 0 for kind in resolved.data.sweep.vary.values())
    return ds.isel(run=SAMPLERS[resolved.data.sweep.sampler].counting(ds["run"].values, inputs))


def _dataset(resolved: Scenario, predicted: Prediction, variables: dict[str, Any], notes: list[str]) -> "xr.Dataset":
    title = ": ".join(filter(None, [resolved.data.title, "budget of tolerances"]))
    said = provenance.attributes(
        title, resolved.to_toml(), resolved.sha256(), resolved.data.sweep.seed, provenance.command()
    )
    told = {
        name: (dims, values, {"long_name": TEXTS[name], **({"units": "1"} if name in PURE else {})})
        for name, (dims, values) in variables.items()
    }
    units = [resolved.units(path) for path in predicted.paths]
    labels = {
        OF_OUTPUT: (OF_OUTPUT, predicted.names, "name of the output"),
        "output_units": (OF_OUTPUT, predicted.units, "unit of the output"),
        "input": ("input", predicted.paths, "path of the input"),
        "input_units": ("input", units, "unit of the input"),
    }
    coordinates = {
        name: (dim, values, {"units": "1", "long_name": text}) for name, (dim, values, text) in labels.items()
    }
    return dataset(told, coordinates, {}, {}, {KIND: BUDGET, **said, "notes": "\n".join(notes)})
