"""Recordings that were measured, beside the runs that are to fit them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import xarray as xr

from lienumba.errors import ScenarioError
from lienumba.store.names import Names, hint, named
from lienumba.sweep.design import NOMINAL_RUN
from lienumba.words import listed, show

PLACE = "measured"
NEAR = 1e-9  # s, relative above 1 s: times nearer to each other than this are one


@dataclass(frozen=True)
class Recording:
    """What was measured in one run: variables by their names, with the standard deviations of their errors."""

    variables: Mapping[str, xr.DataArray]
    sigma: Mapping[str, np.ndarray]

    @property
    def times(self) -> list[float]:
        """All at which something was measured (s)."""
        found = [x["time"].values for x in self.variables.values() if "time" in x.dims]
        return np.unique(np.concatenate(found)).tolist() if found else []

    def differences(self, ds: xr.Dataset) -> dict[str, np.ndarray]:
        """What a run has too much of each variable, in its units; NaN where nothing was measured."""
        return {name: _where(named(ds, name), x, name) - x.values for name, x in self.variables.items()}

    def residuals(self, ds: xr.Dataset) -> np.ndarray:
        """The differences in standard deviations, of what was measured (residuals,)."""
        differences = self.differences(ds)
        return np.concatenate([(differences[name] / self.sigma[name])[seen] for name, seen in self.seen.items()])

    def jacobian(self, ds: xr.Dataset) -> np.ndarray:
        """The derivatives of the residuals (residuals, inputs)."""
        rows = []
        for name, seen in self.seen.items():
            slopes = _where(ds[f"d_{name}"], self.variables[name], name)
            rows.append((slopes / self.sigma[name][..., None])[seen])
        return np.concatenate(rows)

    @cached_property
    def seen(self) -> dict[str, np.ndarray]:
        """What was measured of each variable."""
        return {name: np.isfinite(x.values) for name, x in self.variables.items()}


@dataclass(frozen=True)
class Recordings:
    """Recordings of the runs with these labels. given: whether the errors of measurement are known."""

    each: Sequence[Recording]
    labels: Sequence[int]
    given: bool

    @property
    def names(self) -> tuple[str, ...]:
        """The variables that were measured."""
        return tuple(dict.fromkeys(name for one in self.each for name in one.variables))

    @property
    def times(self) -> tuple[float, ...]:
        """All times at which something was measured (s)."""
        every = np.unique([t for one in self.each for t in one.times])
        apart = np.diff(every, prepend=-np.inf) > NEAR * np.maximum(1.0, np.abs(every))
        return tuple(every[apart].tolist())

    def check(self, known: Names, end: float) -> None:
        """The dataset has these variables, until then (s)."""
        every = {x for one in known.every.values() for x in (one.variable, one.name)}
        for name in self.names:
            if name not in every:
                rule = f"has {show(name)}, which the dataset does not have"
                raise ScenarioError.at(PLACE, rule, hint(name, known))
        late = [t for t in self.times if not 0.0 <= t <= end + NEAR * max(1.0, end)]
        if late:
            rule = f"has the time {late[0]:.6g} s, but runs go from 0 to {end:g} s"
            raise ScenarioError.at(PLACE, rule, "cut it there, or set integrator.end_time when you prepare")

    def residuals(self, ds: xr.Dataset) -> np.ndarray:
        """Of all recordings (residuals,)."""
        return np.concatenate([x.residuals(ds.isel(run=n)) for n, x in enumerate(self.each)])

    def jacobian(self, ds: xr.Dataset) -> np.ndarray:
        """The derivatives of the residuals (residuals, inputs)."""
        return np.concatenate([x.jacobian(ds.isel(run=n)) for n, x in enumerate(self.each)])

    def differences(self, ds: xr.Dataset) -> xr.Dataset:
        """What the runs have too much, in the units of each variable, as it was measured."""
        found = []
        for n, one in enumerate(self.each):
            values = one.differences(ds.isel(run=n))
            found.append(xr.Dataset({name: x.copy(data=values[name]) for name, x in one.variables.items()}))
        return found[0] if len(found) == 1 else xr.concat(found, "run", join="outer")


def recordings_of(measured: Any, sigma: Any) -> Recordings:
    """What was measured, by whatever holds it; sigma: a number, or numbers by names."""
    several = measured if isinstance(measured, Sequence) and not isinstance(measured, str) else [measured]
    if not several:
        raise ScenarioError(f"{PLACE}: is empty; give a dataset of each recording")
    each = [_recording(x, sigma) for x in several]
    names = list(dict.fromkeys(name for one in each for name in one.variables))
    if sigma is None and len(names) > 1:
        raise ScenarioError(
            f"sigma: is missing, and {len(names)} variables were measured, whose errors may differ; give the standard "
            f"deviation of the errors of each, such as {{{show(names[0])}: 0.01}}"
        )
    if not any(seen.any() for one in each for seen in one.seen.values()):
        raise ScenarioError(f"{PLACE}: has no number that is finite; give what was measured")
    one = measured is several or len(several) > 1
    return Recordings(each, range(len(several)) if one else [NOMINAL_RUN], sigma is not None)


def _recording(measured: Any, sigma: Any) -> Recording:
    if isinstance(measured, xr.DataArray):
        if measured.name is None:
            raise ScenarioError(f"{PLACE}: has no name; give the array the name of a variable, such as swing.angle")
        measured = measured.to_dataset()
    if not isinstance(measured, xr.Dataset):
        kind = type(measured).__name__
        raise ScenarioError(f"{PLACE}: is a {kind}; give an xarray.Dataset, or several of them in a list")
    if "run" in measured.dims:
        raise ScenarioError(f"{PLACE}: has a dimension run; give a list with one dataset for each recording")
    variables = {str(name): x.astype(float) for name, x in measured.data_vars.items()}
    if not variables:
        raise ScenarioError(f"{PLACE}: has no variable; give such as swing.angle over the time")
    for name, x in variables.items():
        if "time" in x.dims and "time" not in x.coords:
            raise ScenarioError.at(f"{PLACE}.{name}", "has no times", "give it the coordinate time, in s")
    return Recording(variables, {name: _sigma(name, x, sigma) for name, x in variables.items()})


def _sigma(name: str, measured: xr.DataArray, sigma: Any) -> np.ndarray:
    """The standard deviations of the errors of a variable, each of its numbers."""
    own = sigma
    if isinstance(sigma, Mapping | xr.Dataset):
        if name not in sigma:
            raise ScenarioError.at("sigma", f"has none of {name}", "give the standard deviation of its errors")
        own = sigma[name]
    try:
        found: np.ndarray = np.broadcast_to(np.asarray(1.0 if own is None else own, float), measured.shape)
    except (TypeError, ValueError):
        rule = f"must be one number, or as many as were measured: {measured.shape}"
        raise ScenarioError.at(f"sigma.{name}", rule, "correct it") from None
    if not (found > 0.0).all():
        raise ScenarioError.at(f"sigma.{name}", "must be above 0", "give the standard deviation of its errors")
    return found


def _where(values: xr.DataArray, measured: xr.DataArray, name: str) -> np.ndarray:
    """The numbers of a run where a variable was measured, in the order of its dimensions, and of inputs."""
    own = [dim for dim in values.dims if dim != "input"]
    if {*own} != {*measured.dims}:
        given, there = (listed(map(str, x)) or "none" for x in (measured.dims, own))
        rule = f"has the dimensions {given}, but the dataset has {there}"
        raise ScenarioError.at(f"{PLACE}.{name}", rule, "give it those")
    found = values.transpose(*measured.dims, *(dim for dim in values.dims if dim == "input")).values
    for axis, dim in enumerate(measured.dims):
        place = f"{PLACE}.{name}"
        labels = values[dim].values
        if dim == "time":
            found = found.take([int(np.argmin(np.abs(labels - t))) for t in measured["time"].values], axis)
        elif dim in measured.coords:
            known = labels.tolist()
            strange = [x for x in measured[dim].values.tolist() if x not in known]
            if strange:
                rule = f"has the {dim} {show(strange[0])}, but the dataset has {listed(map(str, known))}"
                raise ScenarioError.at(place, rule, "give it those labels")
            found = found.take([known.index(x) for x in measured[dim].values.tolist()], axis)
        elif len(labels) != measured.sizes[dim]:
            raise ScenarioError.at(place, f"has {measured.sizes[dim]} of {dim}, not {len(labels)}", "give its labels")
    return found
