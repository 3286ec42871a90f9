"""A scenario made ready for loops: other numbers, the same program."""

from collections.abc import Mapping, Sequence
from numbers import Real
from typing import TYPE_CHECKING, Any

import numpy as np

from lienumba.batch.execute import usable_cores
from lienumba.engine.results import Results
from lienumba.engine.runner import check_workers, in_memory
from lienumba.errors import ScenarioError
from lienumba.scenario.base import paths
from lienumba.scenario.base.arguments import check_count, labels_of
from lienumba.scenario.reading.loading import MODEL_KEYS
from lienumba.scenario.resolve import Scenario, resolve
from lienumba.scenario.start.prepare import check_initial, design
from lienumba.store.names import named
from lienumba.sweep.design import NOMINAL_RUN
from lienumba.words import listed, plural

if TYPE_CHECKING:
    import xarray as xr

    from lienumba.engine.calibration.fit import Fit
    from lienumba.engine.kernels.kernels import Kernels
    from lienumba.engine.simulate import Progress
    from lienumba.scenario.start.prepare import Nominal

SETTABLE = (*MODEL_KEYS, "model", "parameters")  # where a path of a number begins


class Prepared:
    """A scenario that is ready to run again and again with other numbers; made by `lienumba.prepare`.

    It may be used by any number of threads at once.

    Parameters
    ----------
    resolved : Scenario
        What was prepared.

    Attributes
    ----------
    scenario : str
        The same, as TOML with every default written out.
    """

    def __init__(self, resolved: Scenario) -> None:
        self._resolved, self._written = resolved, resolved.to_dict()
        self._nominal = check_initial(resolved)
        self._results = Results(resolved, self._nominal)
        self._with_derivatives: dict[tuple[Any, ...], Prepared] = {}

    @property
    def scenario(self) -> str:
        """What was prepared, as TOML with every default written out."""
        return self._resolved.to_toml()

    def run(
        self,
        parameters: Mapping[str, Any] | None = None,
        *,
        samples: Any = None,
        runs: Sequence[int] | None = None,
        workers: int | None = None,
    ) -> "xr.Dataset":
        """Simulate with other numbers, and return the dataset.

        It has the bits, the labels and the attributes of `lienumba.run` of the scenario with these numbers. The first
        call with a number that is exactly 0, 1 or -1 where it was not, or with other columns of samples, may have to
        compile another program. A single run whose joints cannot be assembled with these numbers is data (`status`), as
        every run that fails.

        Parameters
        ----------
        parameters : mapping, optional
            Numbers of the model by path, such as `{"parameters.kp": 40.0, "bodies.top.mass": 14.0}`.
        samples : DataFrame, structured array or mapping, optional
            Columns of numbers (runs,) by path, a row for each run, instead of the sweep of the scenario.
        runs : sequence of int, optional
            The labels of the runs to simulate; all by default. -1 is the nominal run.
        workers : int, optional
            Threads; by default one for each core.

        Returns
        -------
        xarray.Dataset
            In memory, its runs in the order of `runs`.

        Raises
        ------
        ScenarioError
            If there is no such path, or a number cannot be what it should be: a sentence for each.
        """
        from lienumba.engine.simulate import Runs, Threads

        check_workers(workers)
        resolved, labels, nominal = self._chosen(parameters, samples, runs)
        wanted = Runs(np.asarray(labels, np.int64), design(resolved, labels), nominal)
        results = self._results.with_numbers(resolved, nominal)
        return in_memory(results, wanted, Threads(results, workers or usable_cores()), _untold)

    def value_and_gradient(
        self, parameters: Mapping[str, float], of: str, *, workers: int | None = None
    ) -> "tuple[float | np.ndarray, np.ndarray]":
        """Simulate the nominal run with other numbers, and return an output with its derivatives by these numbers.

        It suits `scipy.optimize.minimize(..., jac=True)`. The derivatives are those of the computed numbers, not
        differences. The first call for an output compiles another program; later ones take milliseconds beside the
        steps.

        Parameters
        ----------
        parameters : mapping
            Numbers of the model by path, such as `{"parameters.kp": 40.0, "bodies.top.mass": 14.0}`.
        of : str
            What is differentiated: a name of the dataset, such as "miss", "event_time.landed", "last_position.top.z".
        workers : int, optional
            Threads; by default one for each core.

        Returns
        -------
        float or numpy.ndarray
            The output: a number, or an array where `of` names several. NaN if the run failed.
        numpy.ndarray
            Its derivatives; the last dimension is that of the paths, in their order. NaN where one does not exist, such
            as at an event that only grazes its condition.

        Raises
        ------
        ScenarioError
            If there is no such path or output, or it cannot be differentiated: a sentence for each.
        """
        other = self._differentiated((of,), parameters)
        ds = other.run(parameters, runs=[NOMINAL_RUN], workers=workers)
        value = named(ds, of).isel(run=0).values.astype(float)
        return value if value.ndim else float(value), ds[f"d_{of}"].isel(run=0).values

    def fit(
        self,
        measured: Any,
        parameters: Mapping[str, float],
        *,
        sigma: Any = None,
        bounds: Mapping[str, tuple[float, float]] | None = None,
        samples: Any = None,
        workers: int | None = None,
        max_calls: int = 100,
    ) -> "Fit":
        """Find the numbers of the model with which it moves as was measured, by nonlinear least squares.

        Jacobians are exact derivatives of the runs, also through joints and events, and need no step to choose.

        Parameters
        ----------
        measured : xarray.Dataset, xarray.DataArray or sequence of these
            Variables with names of the dataset, such as "swing.angle" or "event_time.landed"; those of courses have the
            coordinate `time` in s, which may be other times than the scenario stores. NaN: not measured. Several: the
            runs 0, 1, ... of `samples`, or of the sweep; one: the nominal run.
        parameters : mapping
            The numbers that are sought, by path, with the values from which the search starts.
        sigma : float, mapping or xarray.Dataset, optional
            Standard deviations of the errors of measurement: a number, or numbers by the names of the variables.
            Without them the scatter about the fit tells it, which must be that of one variable.
        bounds : mapping, optional
            Of some parameters the lowest and the highest value.
        samples : DataFrame, structured array or mapping, optional
            Columns of numbers by path, a row for each of several recordings, as in `run`: what differed between them.
        workers : int, optional
            Threads; by default one for each core.
        max_calls : int
            How many simulations of all recordings may be tried.

        Returns
        -------
        lienumba.Fit
            Values with standard errors, correlations, and which of them the data cannot tell apart.

        Raises
        ------
        ScenarioError
            If data and dataset do not fit, or something has no derivative: a sentence for each.
        """
        from lienumba.engine.calibration.fit import Search, fit
        from lienumba.engine.calibration.measured import recordings_of

        recordings = recordings_of(measured, sigma)
        recordings.check(self._results.names, self._resolved.data.integrator.end_time)
        swept = samples is None and list(recordings.labels) != [NOMINAL_RUN]
        other = self._differentiated(recordings.names, parameters, recordings.times, swept)

        def run(numbers: Mapping[str, float]) -> "xr.Dataset":
            return other.run(numbers, samples=samples, runs=recordings.labels, workers=workers)

        units = {path: other._resolved.units(path) for path in parameters}
        return fit(Search(run, recordings, dict(parameters), units), dict(bounds or {}), max_calls)

    def kernels(self, observe: str | Sequence[str] = ()) -> "Kernels":
        """Compile the mechanism into functions that code under Numba's `@njit` calls.

        Parameters
        ----------
        observe : str or sequence of str
            What the function `observe` evaluates: the name of a number that the dataset has over time, such as
            "position.top.z", or several.

        Returns
        -------
        Kernels
            Functions `step`, `rhs`, `equations`, `observe` and `prepare`, and methods that make their arguments.

        Raises
        ------
        ScenarioError
            If a step is more than a call: implicit methods, `taylor`, a tolerance, events, switched constraints,
            sampled laws, noise, and functions of time with kinks; or if there is no such name.
        """
        from lienumba.engine.kernels.refusals import refuse

        refuse(self._resolved, self._nominal)
        from lienumba.engine.kernels.kernels import Kernels

        names = (observe,) if isinstance(observe, str) else tuple(observe)
        return Kernels(self._resolved, self._nominal, self._chosen, names)

    def _differentiated(
        self, of: tuple[str, ...], by: Mapping[str, float], times: tuple[float, ...] = (), swept: bool = False
    ) -> "Prepared":
        """The same scenario with derivatives of some outputs by these numbers, which stores other times, if any; made
        once. swept: whether it keeps its sweep, whose inputs cannot be set beside."""
        key = of, tuple(by), times, swept
        if key not in self._with_derivatives:
            _check_numbers(by)
            written = {name: x for name, x in self._written.items() if swept or name != "sweep"}
            resolve(written, overrides=dict(by))
            written["sensitivities"] = {"of": [*of], "by": [*by]}
            if times:
                own = {name: x for name, x in self._written["output"].items() if name != "every"}
                written["output"] = {**own, "times": [*times]}
            try:
                self._with_derivatives[key] = Prepared(resolve(written))
            except ScenarioError as error:
                raise error.inside("measured") if times else error from None
        return self._with_derivatives[key]

    def _chosen(
        self, parameters: Mapping[str, Any] | None, samples: Any, runs: Sequence[int] | None
    ) -> "tuple[Scenario, Sequence[int], Nominal]":
        """The scenario with other numbers, its runs that are asked for, and its nominal start."""
        resolved = self._with(dict(parameters or {}), samples)
        labels = labels_of(runs, resolved.labels)
        check_count(len(labels), len(resolved.data.sweep.vary))
        return resolved, labels, self._start(resolved, labels)

    def _with(self, parameters: dict[str, Any], samples: Any) -> Scenario:
        """The scenario with these numbers."""
        for path, value in parameters.items():
            _check(path, value)
        if samples is None:
            return resolve(self._written, overrides=parameters) if parameters else self._resolved
        table = {"columns": _columns(samples)}
        own = self._resolved.data.sweep
        sweep = {"seed": own.seed, "nominal": own.nominal, "sampler": "table", "table": table}
        return resolve({**self._written, "sweep": sweep}, overrides=parameters)

    def _start(self, resolved: Scenario, labels: Sequence[int]) -> "Nominal":
        """The nominal start with these numbers; that of the scenario as it was where a single run does not fit."""
        from lienumba.batch.statuses import SUCCESS
        from lienumba.scenario.start.prepare import prepare

        if resolved is self._resolved:
            return self._nominal
        try:
            return check_initial(resolved)
        except ScenarioError:
            single = prepare(resolved, labels, nominal=self._nominal) if len(labels) == 1 else None
            if single is None or single.codes[0] == SUCCESS:  # what is wrong is no matter of its joints
                raise
            return self._nominal


def prepare(
    scenario: Any,
    *,
    overrides: Mapping[str, Any] | None = None,
    seed: int | None = None,
    allow_code: bool = False,
) -> Prepared:
    """Make a scenario ready for loops, such as those of an optimisation.

    It is read, traced, compiled and loaded once; each run then costs some milliseconds beside its steps. Files that it
    names are read now, and not again.

    Parameters
    ----------
    scenario : path, dict or System
        What to simulate: a TOML file, its keys and values, or a `lienumba.System`.
    overrides : mapping, optional
        New values by path, such as `{"integrator.step": 1e-4}`.
    seed : int, optional
        Instead of `sweep.seed`.
    allow_code : bool
        Run also the Python code that a TOML file brings in itself, or names outside its folder.

    Returns
    -------
    Prepared
        Whose method `run` simulates with other numbers.

    Raises
    ------
    ScenarioError
        For bad input, with a sentence for each problem.
    """
    import warnings

    from lienumba.engine.programs import compile_early
    from lienumba.scenario.start.never import warnings_of
    from lienumba.scenario.start.prepare import prepare as prepare_runs

    resolved = resolve(scenario, overrides=overrides, seed=seed, allow_code=allow_code)
    if resolved.plan is not None:
        raise ScenarioError("a study cannot be prepared, because its points are compared; run it, or leave study out")
    for sentence in warnings_of(resolved):
        warnings.warn(str(sentence), stacklevel=2)
    prepared = Prepared(resolved)
    compile_early(resolved, prepare_runs(resolved, list(resolved.labels[:1]), nominal=prepared._nominal), True)
    return prepared


def _check_numbers(parameters: Mapping[str, Any]) -> None:
    """What is differentiated by is one number at each path."""
    if not parameters:
        raise ScenarioError("parameters: are empty; give numbers of the model by path, such as bodies.top.mass")
    for path, value in parameters.items():
        _check(path, value)
        if np.ndim(value):
            raise ScenarioError.at(path, "must be one number", f"give its components, such as {path}[0]", value)


def _check(path: str, value: Any) -> None:
    """A parameter is a number of the model, or several of them."""
    if not isinstance(path, str):
        raise ScenarioError.at("parameters", "have paths as keys, which are texts", 'write "bodies.top.mass"', path)
    try:
        first = paths.parse(path)[0]
    except paths.PathError as error:
        raise ScenarioError.at(f"parameters: {path}", *error.args) from None
    if first not in SETTABLE:
        raise ScenarioError.at(
            path, "is no number of the model", f'give it when you prepare: overrides = {{"{path}": ...}}', value
        )
    plain = value.tolist() if hasattr(value, "tolist") else value
    numbers = plain if isinstance(plain, list | tuple) else [plain]
    while any(isinstance(x, list | tuple) for x in numbers):
        numbers = [y for x in numbers for y in (x if isinstance(x, list | tuple) else [x])]
    if not all(isinstance(x, Real) and not isinstance(x, bool) for x in numbers):
        remedy = "give a number; what else is to change makes another scenario, which is to be prepared itself"
        raise ScenarioError.at(path, "must be a number", remedy, value)


def _columns(samples: Any) -> dict[str, list[float]]:
    """The columns of a table of samples, whatever it is."""
    names = getattr(getattr(samples, "dtype", None), "names", None)  # of a structured array
    names = list(samples) if names is None and hasattr(samples, "keys") else names
    if not names:
        what = "has no columns" if hasattr(samples, "keys") else f"is a {type(samples).__name__}"
        raise ScenarioError(f"samples: {what}; give a DataFrame, a structured array, or columns by path in a dict")
    found: dict[str, list[float]] = {}
    for name in map(str, names):
        try:
            column = np.asarray(samples[name], float)
        except (TypeError, ValueError):
            raise ScenarioError.at(f"samples.{name}", "has what is no number", "correct it") from None
        if column.ndim != 1 or not len(column):
            raise ScenarioError.at(
                f"samples.{name}", f"has the shape {column.shape}", "give one number for each run, in one dimension"
            )
        if not np.isfinite(column).all():
            row = int(np.flatnonzero(~np.isfinite(column))[0])
            raise ScenarioError.at(f"samples.{name}", f"row {row} is {column[row]}", "give finite numbers")
        found[name] = column.tolist()
    lengths = {name: len(column) for name, column in found.items()}
    if len(set(lengths.values())) > 1:
        told = listed(f"{name} has {plural(number, 'row', 'rows')}" for name, number in lengths.items())
        raise ScenarioError(f"samples: {told}; give all columns a row for each run")
    return found


def _untold(_: "Progress") -> None:
    pass
