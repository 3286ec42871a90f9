"""Datasets that are no courses of runs: modes, equilibria, linear systems, searches for failures."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from lienumba.errors import ScenarioError
from lienumba.store.layout import COORDINATES, RUN, WEIGHT, bare, input_coordinates
from lienumba.store.refusals import check_dimension, damaged

if TYPE_CHECKING:
    import xarray as xr

KIND = "kind"  # the attribute that says it
MODES, EQUILIBRIA, SYSTEMS = "vibration modes", "equilibria", "linear systems"
RARE, WORST = "the search for a rare failure", "the search for a worst case"
BUDGET = "a budget of tolerances"
SHOWN = {
    MODES: "lienumba info, plot, report, animate, analyse and table show it",
    EQUILIBRIA: "xarray.open_dataset reads it",
    SYSTEMS: "xarray.open_dataset reads it",
    RARE: "xarray.open_dataset reads it",
    WORST: "xarray.open_dataset reads it",
    BUDGET: "xarray.open_dataset reads it",
}
MODE = ("run", "time", "mode")
SHAPE, PLACE = (*MODE, "body", "axis", "part"), ("body", "axis")
NEEDED = {
    "growth": MODE, "angular_frequency": MODE, "frequency": MODE, "damping_ratio": MODE, "grows": MODE,
    "stable": MODE[:2], "status": MODE[:2], "frequency_quantiles": ("quantile", *MODE[1:]),
    "damping_ratio_quantiles": ("quantile", *MODE[1:]),
}  # fmt: skip
SHAPES = {
    "translation": SHAPE, "turn": SHAPE, "mac": MODE, "crossed": MODE, "position": (*MODE[:2], *PLACE),
    "rotation": (*MODE[:2], *PLACE, "body_axis"), "start_position": (MODE[0], *PLACE),
    "start_rotation": (MODE[0], *PLACE, "body_axis"),
}  # fmt: skip
OPTIONAL = {"origin": ("time",), WEIGHT: RUN}
KINDS = {"grows": "b", "stable": "b", "crossed": "b", "status": "iu", "origin": "iu"}  # of arrays; else numbers
QUANTILES, PARTS, STILL = (0.05, 0.5, 0.95), ("real", "imag"), (0.0, 0.0, 0.0)
# Kinds of labels, and which there are always.
LABELS = {
    "run": "iu", "time": "f", "mode": "iu", "quantile": "f", "body": "UOST", "axis": "UOST", "part": "UOST",
    "body_axis": "UOST",
}  # fmt: skip
ALWAYS = {"quantile": QUANTILES, "axis": ("x", "y", "z"), "part": PARTS, "body_axis": ("x", "y", "z")}
GIVEN, STORED, SIMULATED = range(3)
ORIGINS = ("start", "stored", "simulated")  # of the states at a time
# What coordinates are that courses of runs have not.
OWN = {
    "mode": "number of the mode", "quantile": "share of the runs that lie below", "part": "part of a complex number",
    "state": "name of the state", "by_state": "name of the state that is differentiated by",
    "input": "name of the input, and which derivative of it", "output": "name of the quantity",
    "stream": "input that is drawn",
}  # fmt: skip


def dataset(
    variables: Mapping[str, Any],
    coordinates: Mapping[str, Any],
    inputs: Mapping[str, np.ndarray],
    input_units: Mapping[str, str],
    attributes: Mapping[str, Any],
) -> xr.Dataset:
    """The labelled dataset of these, with texts and types as CF 1.8 has them; inputs: the samples (runs,) of each
    varied path."""
    import xarray as xr

    columns = input_coordinates(inputs, input_units, len(coordinates.get("run", ())))
    ds = xr.Dataset(variables, {**coordinates, **columns}, attributes)
    said = COORDINATES | {name: ("1", text) for name, text in OWN.items()}
    for key, x in ds.variables.items():
        name = str(key)
        units, text = said.get(name, (None if x.dtype.kind == "f" else "1", name.replace("_", " ")))
        x.attrs = ({} if units is None else {"units": units}) | {"long_name": text} | x.attrs
        x.encoding |= bare(x.values) if name in ds.coords else {}
        x.encoding |= {"coordinates": None} | ({"dtype": "int32"} if x.dtype == np.int64 else {})
    return ds


def is_modes(ds: xr.Dataset) -> bool:
    """Whether a dataset is one of vibration modes."""
    return bool(ds.attrs.get(KIND) == MODES)


def has_shapes(ds: xr.Dataset) -> bool:
    """Whether it says how bodies move in each mode."""
    return all(name in ds for name in SHAPES)


def check_kind(ds: xr.Dataset, where: str, kinds: Collection[str]) -> bool:
    """Whether it is of one of these kinds; a ScenarioError if it is of another. where: what the dataset is called."""
    kind = ds.attrs.get(KIND)
    if kind not in SHOWN:
        return False
    if kind not in kinds:
        raise ScenarioError(
            f"{where}: is of {kind}, not of runs over time; {SHOWN[kind]}, or give what lienumba run wrote"
        )
    return True


def check_modes(ds: xr.Dataset, where: str) -> None:
    """Refuse one that has lost what belongs to it, or of which a selection has kept too little."""
    shapes = [name for name in SHAPES if name in ds]
    for dim in LABELS if shapes else (*MODE, "quantile"):
        if dim not in ds.coords:
            raise damaged(where, f"{dim} has no labels")
        check_dimension(ds, dim, where)
        values = ds[dim].values
        if not len(values):
            raise ScenarioError(f"{where}: has no {dim}; select at least one")
        if values.dtype.kind not in LABELS[dim] or len(set(values.tolist())) < len(values):
            raise damaged(where, f"{dim} has other labels")
        if dim in ALWAYS and tuple(values.tolist()) != ALWAYS[dim]:
            raise ScenarioError(f"{where}: has not every {dim} in its order; select runs, times and modes only")
    variables = NEEDED | {name: dims for name, dims in (SHAPES | OPTIONAL).items() if name in ds}
    for name, dims in variables.items():
        kinds = KINDS.get(name, "f")
        if name not in ds or ds[name].dims != dims or ds[name].dtype.kind not in kinds:
            raise damaged(where, f"{name} is not {' by '.join(dims)}")
    if np.shape(ds.attrs.get("rotation", STILL)) != (3,) or not isinstance(ds.attrs.get("scenario_sha256"), str):
        raise damaged(where, "its attributes are others")
