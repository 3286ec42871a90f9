"""What the numbers of runs are called by whoever asks for one: `tip`, `position.top.z`, `event_time.far`; of several,
`position` or `position.top`. A dataset has them, or a scenario will have them.

The name of a requirement is also that of its value, be it a formula or another number of the dataset.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import product
from typing import TYPE_CHECKING

from lienumba.batch.statistics import STATISTICS
from lienumba.errors import BadValueError, ScenarioError
from lienumba.mechanics.system.joint_coordinates import UNITS
from lienumba.mechanics.system.output_variables import OUTPUT_VARIABLES
from lienumba.store.form import scenario_tables
from lienumba.store.layout import FAILED, FULL, MARGIN, RUN, SAID_OF, VARIABLES
from lienumba.words import ALIKE, listed, near, show, suggestion

if TYPE_CHECKING:
    import xarray as xr

NOT_OF_A_NAME = (*RUN, FULL, "time")  # dimensions
SHOW = "show"  # the attribute of a dataset with the names of `output.show`
STATUS, START_STATE = "status", "start_state"  # the latter has no names: a replay alone reads it
BY, RATE, FLAGS = "input", "event_rate", "sensitivity_flags"  # of derivatives: their dimension, rates, flags
LAST, AT_EVENTS = "last_", "event_"  # of the names of what each run has once, or once for each event

# Kinds of names, as messages call them.
COURSE, SOME, MEASURE, SUMMARY, EVENT = "courses", "courses of some runs", "measures", "summaries", "events"
REQUIREMENT, END, CHANGE, WHOLE = "requirements", "last states", "changes", "numbers of the whole run"
INPUT, OUTCOME, DERIVATIVE = "inputs", "outcomes", "derivatives"
KINDS = (COURSE, MEASURE, SUMMARY, EVENT, REQUIREMENT, END, CHANGE, WHOLE, INPUT, SOME, OUTCOME, DERIVATIVE)
OVER_TIME = (COURSE, SOME)


@dataclass(frozen=True)
class Name:
    """One number of every run, or one at every time of it: in which variable it is, and where along its dimensions but
    run and time; kind: one of KINDS."""

    name: str
    variable: str
    place: tuple[int, ...]
    kind: str
    units: str


@dataclass(frozen=True)
class Names:
    """All that there are; requirements: their names, and value_of(one) how the value of one is called, empty where that
    is a formula; whose: of what they are."""

    every: Mapping[str, Name]
    requirements: Sequence[str] = ()
    value_of: Callable[[str], str] = field(default=lambda name: "", compare=False)
    whose: str = "the dataset"

    def but(self, *kinds: str) -> Names:
        """Those of other kinds."""
        return replace(self, every={x.name: x for x in self.every.values() if x.kind not in kinds})


def known(ds: xr.Dataset) -> Names:
    """The names of a dataset of runs."""
    labels = _labels(ds, map(str, ds.dims))
    found = [
        x
        for name, variable in ds.drop_vars(START_STATE, errors="ignore").variables.items()
        if name not in ds.dims and {*RUN, FULL} & {*variable.dims} and variable.dtype.kind in "biuf"
        for x in _names(str(name), variable, labels)
    ]
    requirements = [*map(str, ds["requirement"].values)] if MARGIN in ds else []

    def value_of(requirement: str) -> str:
        tables = scenario_tables(ds, "the dataset").get("requirements", [])
        own = (x for x in tables if isinstance(x, dict) and x.get("name") == requirement)
        return str(next(own, {}).get("value", ""))

    return Names(with_failed(found), requirements, value_of)


def by_variable(names: Iterable[Name]) -> dict[str, list[Name]]:
    """Names, each once, by their variables, in the order of the first of each."""
    found: dict[str, list[Name]] = {}
    for name in dict.fromkeys(names):
        found.setdefault(name.variable, []).append(name)
    return found


def with_failed(names: Iterable[Name]) -> dict[str, Name]:
    """These by what they are called; whether a run failed follows from how it ended."""
    return {FAILED: Name(FAILED, STATUS, (), OUTCOME, "1"), **{x.name: x for x in names}}


def names_of(variable: xr.DataArray) -> list[Name]:
    """The names of the numbers of a variable of a dataset."""
    return _names(str(variable.name), variable.variable, _labels(variable, dims_of(variable)))


def _labels(of: xr.Dataset | xr.DataArray, dims: Iterable[str]) -> dict[str, list[str]]:
    """Those of dimensions, and what else is said of these."""
    own = [dim for dim in dims if dim not in NOT_OF_A_NAME]
    there = [*own, *(said for said, dim in SAID_OF.items() if dim in own and said in of.coords)]
    return {name: [*map(str, of[name].values)] for name in there}


def _names(name: str, variable: xr.Variable, labels: Mapping[str, Sequence[str]]) -> list[Name]:
    dims, attributes = dims_of(variable), variable.attrs
    kind = kind_of(name, variable.dims, "measure" in attributes, attributes.get("role") == "input")
    return names_in(name, dims, labels, str(attributes.get("units", "1")), kind)


def dims_of(variable: xr.DataArray | xr.Variable) -> list[str]:
    """The dimensions that tell the names of a variable apart."""
    return [str(dim) for dim in variable.dims if dim not in NOT_OF_A_NAME]


def names_in(
    variable: str, dims: Sequence[str], labels: Mapping[str, Sequence[str]], units: str, kind: str
) -> list[Name]:
    """The names of the numbers of a variable; labels: of its dimensions, and units of coordinates and requirements."""
    found = []
    for place in product(*(range(len(labels[dim])) for dim in dims)):
        own = dict(zip(dims, place, strict=True))
        name = ".".join([variable, *(labels[dim][n] for dim, n in own.items())])
        found.append(Name(name, variable, place, kind, _units(variable, own, labels, units)))
    return found


def _units(variable: str, place: Mapping[str, int], labels: Mapping[str, Sequence[str]], units: str) -> str:
    """Of coordinates of joints, and of margins, each has its own."""
    along = UNITS.get(variable.removeprefix(LAST).removeprefix(AT_EVENTS).partition("_")[0])
    if along is not None and units == "1" and {"coordinate"} <= place.keys() and "coordinate_units" in labels:
        return along.get(labels["coordinate_units"][place["coordinate"]], units)
    if variable == MARGIN and "requirement_units" in labels:
        return labels["requirement_units"][place["requirement"]]
    return units


def kind_of(variable: str, dims: Iterable[object], measure: bool, sampled: bool = False) -> str:
    """Which kind the names of a variable are of; measure: it is a formula of the whole run."""
    own = {*dims}
    if sampled:
        return INPUT
    if BY in own or variable in (RATE, FLAGS):
        return DERIVATIVE
    if "time" in own:
        return SOME if FULL in own else COURSE
    if variable == STATUS:
        return OUTCOME
    for dim, kind in (("event", EVENT), ("change", CHANGE), ("requirement", REQUIREMENT)):
        if dim in own:
            return kind
    if measure:
        return MEASURE
    if variable in VARIABLES:
        return END if variable.startswith(LAST) else WHOLE
    return SUMMARY if any(variable.endswith(f"_{statistic}") for statistic in STATISTICS) else WHOLE


def named(ds: xr.Dataset, asked: str) -> xr.DataArray:
    """What is called so, of all runs or of one: a variable, or one number of it."""
    if asked in ds:
        return ds[asked]
    variables = [ds[name] for name in ds.data_vars if asked.startswith(f"{name}.")]
    variable, place = next((x, one.place) for x in variables for one in names_of(x) if one.name == asked)
    return variable.isel(dict(zip(dims_of(variable), place, strict=True)), drop=True)


def match(asked: str, names: Names) -> list[Name]:
    """What is called so: one name, those of a variable, those of a body or joint, or the value of a requirement; none
    if nothing is."""
    if asked in names.every:
        return [names.every[asked]]
    found = [x for x in names.every.values() if x.variable == asked]
    found = found or [x for name, x in names.every.items() if name.startswith(f"{asked}.")]
    if not found and asked in names.requirements:
        value = names.value_of(asked)
        return match(value, names) if value != asked and value not in names.requirements else []
    return found


def find(asked: str, names: Names, what: str = "output") -> list[Name]:
    """The same; a ScenarioError with what is like it if nothing is called so; what: the word for what is asked for."""
    found = match(asked, names)
    if not found:
        raise ScenarioError(f"{names.whose} has no {what} {show(asked)}; {hint(asked, names)}")
    return found


def find_one(asked: str, names: Names) -> Name:
    """The one number of each run that is called so; a BadValueError for what is none."""
    found = match(asked, names)
    if not found:
        remedy = f"{hint(asked, names.but(INPUT, OUTCOME))}, or ask for it in output.summary"
        raise BadValueError("is not a number that the dataset has for each run", remedy)
    if len(found) > 1:
        raise BadValueError(f"is {len(found)} numbers", f"give one, such as {show(found[-1].name)}")
    (only,) = found
    if only.kind in OVER_TIME:
        summaries = [x.name for x in names.every.values() if x.kind == SUMMARY and x.name.startswith(f"{only.name}_")]
        remedy = f"give {listed(map(show, summaries), 'or')}" if summaries else "ask for it in output.summary"
        raise BadValueError("has a value at each time, not one for each run", f"{remedy}, or give a measure of it")
    if only.kind == INPUT:
        raise BadValueError("is an input, not what a run comes to", "give a measure, a summary or a last state")
    if only.kind == OUTCOME:
        raise BadValueError("says how a run ended, not a number", "give a measure, a summary or a last state")
    return only


def one_of(asked: str, there: Iterable[str], whose: str, what: str, none: str) -> str:
    """The same word if it is among these, else a ScenarioError; none: what to do where there are none at all."""
    names = [*there]
    if asked not in names:
        raise ScenarioError(f"{whose} has no {what} {show(asked)}; {suggestion(asked, names) if names else none}")
    return asked


def hint(asked: str, names: Names) -> str:
    """What to do about a name that nothing has."""
    variables = dict.fromkeys(x.variable for x in names.every.values())
    first = asked.partition(".")[0]
    if first in OUTPUT_VARIABLES and first not in variables:
        return _not_stored(asked, first, names)
    every = dict.fromkeys([*variables, *names.requirements, *names.every])
    own = [name for name in every if "." in asked and name.startswith(f"{first}.")]
    if close := near(asked, own or every, ALIKE):
        return f"the nearest known {'name is' if len(close) == 1 else 'names are'} {listed(map(show, close))}"
    return f"it has {listed(_examples(names))}" if names.every else "it has none"


def _not_stored(asked: str, variable: str, names: Names) -> str:
    if OUTPUT_VARIABLES[variable].asked:
        return f'it is stored where a scenario asks for it: give output.also = ["{variable}"]'
    ends = match(f"{LAST}{asked}", names)
    there = f"there is {show(f'{LAST}{asked}')}" if ends else 'output.full_runs or output.mode = "full" stores it'
    return f"its course is not stored; {there}"


def _examples(names: Names) -> list[str]:
    """Of each kind its first name."""
    first = {x.kind: x.name for x in reversed([*names.every.values()])}
    if names.requirements:
        first[REQUIREMENT] = names.requirements[0]
    return [f"{kind} such as {show(first[kind])}" for kind in KINDS if kind in first and kind != OUTCOME]
