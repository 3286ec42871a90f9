"""Names of what a dataset holds: `tip`, `position.top.z`, `event_time.far`; of several, `position` or `position.top`.

A component is one number of every run, or one at every time of it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import product

import xarray as xr

from lienumba.errors import ScenarioError
from lienumba.mechanics.system.joint_coordinates import UNITS
from lienumba.store.layout import FULL, RUN, remedy
from lienumba.words import show, suggestion

NOT_OF_A_COMPONENT = (*RUN, FULL, "time")


def dims_of(variable: xr.DataArray) -> list[str]:
    """The dimensions that tell components apart."""
    return [str(dim) for dim in variable.dims if dim not in NOT_OF_A_COMPONENT]


def places(variable: xr.DataArray) -> Iterator[tuple[int, ...]]:
    """The indices of each component along `dims_of`."""
    return product(*(range(variable.sizes[dim]) for dim in dims_of(variable)))


def components(variable: xr.DataArray) -> list[str]:
    """The name of each component, in the order of `places`."""
    each = [[str(label) for label in variable[dim].values] for dim in dims_of(variable)]
    return [".".join([str(variable.name), *labels]) for labels in product(*each)]


def unit(variable: xr.DataArray, place: Sequence[int]) -> str:
    """The unit of the component at a place; of coordinates of joints each has its own."""
    units, dims = str(variable.attrs.get("units", "1")), dims_of(variable)
    own = UNITS.get(str(variable.name).partition("_")[0])
    if own is None or "coordinate" not in dims or "coordinate_units" not in variable.coords or units != "1":
        return units
    return own[str(variable["coordinate_units"].values[place[dims.index("coordinate")]])]


def matching(asked: str, by_variable: Mapping[str, Sequence[str]], what: str) -> list[str]:
    """The components of a variable, one of them, or those of a body or joint; by_variable: those that there are; what:
    the word for what is asked for."""
    found = list(by_variable.get(asked, ())) or [
        name for each in by_variable.values() for name in each if f"{name}.".startswith(f"{asked}.")
    ]
    if not found:
        whole = f"{asked.partition('.')[0]}."
        own = [name for each in by_variable.values() for name in each if "." in asked and name.startswith(whole)]
        told = suggestion(asked, own) if own else remedy(asked, by_variable)
        raise ScenarioError(f"the dataset has no {what} {show(asked)}; {told}")
    return found
