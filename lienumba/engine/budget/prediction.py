"""Outputs of the nominal run with their derivatives, from which those of other runs are predicted."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr

from lienumba.batch.statuses import GOOD
from lienumba.batch.tangents.changes import FLAGS
from lienumba.engine.runner import run
from lienumba.errors import ScenarioError
from lienumba.scenario.resolve import Scenario, resolve
from lienumba.store.names import known, match, named
from lienumba.sweep.design import NOMINAL_RUN
from lienumba.words import listed

ASKED = "sensitivities.of"  # the place of problems with an output
EVENT_TIME = "event_time"


@dataclass(frozen=True)
class Prediction:
    """Outputs by name: values (outputs,) of the nominal run, units, slopes (outputs, inputs).

    asked: the variables or numbers that they are of; inputs (inputs,): the nominal values of these paths; notes:
    sentences about derivatives that do not exist, or are doubtful.
    """

    names: list[str]
    units: list[str]
    values: np.ndarray
    slopes: np.ndarray
    asked: list[str]
    paths: list[str]
    inputs: np.ndarray
    notes: list[str]

    def of(self, inputs: np.ndarray) -> np.ndarray:
        """The outputs (..., outputs) where the inputs are (..., inputs)."""
        found: np.ndarray = self.values + (inputs - self.inputs) @ self.slopes.T
        return found


def prediction(resolved: Scenario, of: Sequence[str], workers: int | None) -> Prediction:
    """That of the outputs of these names, or of the scenario's own."""
    asked, notes = list(of) or _own(resolved), list[str]()
    while True:
        try:
            ds = run(_asking(resolved, asked), runs=[NOMINAL_RUN], workers=workers, progress=False)
            break
        except ScenarioError as error:
            wrong = [x for x in error.problems if x.place == ASKED]
            if of or not wrong:
                raise
            notes += [f"{problem.value} is left out: it {problem.rule.partition('which ')[2]}" for problem in wrong]
            asked = [name for name in asked if name not in {problem.value for problem in wrong}]
            if not asked:
                raise
    if not ds["status"].isin(GOOD).all():
        raise ScenarioError("the nominal run fails, so nothing can be said of runs near it; correct it first")
    flags = int(ds["sensitivity_flags"].item())
    notes += [f"in the nominal run {sentence}" for bit, sentence in FLAGS.items() if flags & bit]
    names, values, slopes = [], list[float](), list[np.ndarray]()
    every = known(ds)
    for name in asked:
        value, slope = _last(named(ds, name)), _last(ds[f"d_{name}"])
        names += match(name, every)
        values += value.values.ravel().tolist()
        slopes += [*slope.values.reshape(-1, ds.sizes["input"])]
    paths = [str(path) for path in ds["input"].values]
    inputs = np.array([float(ds[path].item()) for path in paths])
    units = [x.units for x in names]
    return Prediction([x.name for x in names], units, np.array(values), np.array(slopes), asked, paths, inputs, notes)


def outputs_of(ds: xr.Dataset, asked: Sequence[str]) -> np.ndarray:
    """The same outputs (runs, outputs) of a dataset; NaN of runs that failed."""
    missing = [name for name in asked if not match(name, known(ds))]
    if missing:
        raise ScenarioError(f"the dataset has no {listed(missing)}; give one that stores it")
    columns = [_last(named(ds, name)).values.reshape(ds.sizes["run"], -1) for name in asked]
    found = np.concatenate(columns, axis=1).astype(float)
    found[~ds["status"].isin(GOOD).values] = np.nan
    return found


def _last(values: xr.DataArray) -> xr.DataArray:
    """Of a course what it comes to at the last stored time."""
    return values.isel(time=-1) if "time" in values.dims else values


def _own(resolved: Scenario) -> list[str]:
    """What the scenario differentiates; else its measures and the times of its events."""
    data = resolved.data
    if data.sensitivities is not None:
        return list(data.sensitivities.of)
    found = [*resolved.parameters.measures, *([EVENT_TIME] if data.model.events else [])]
    if not found:
        raise ScenarioError(
            "the scenario has no measures and no events; name outputs, such as last_position, or a quantity"
        )
    return found


def _asking(resolved: Scenario, of: Sequence[str]) -> Scenario:
    """The scenario with derivatives of these outputs by all inputs of its sweep."""
    return resolve({**resolved.to_dict(), "sensitivities": {"of": [*of]}}, counted=False)
