"""Whether a dataset has the form of one that lienumba wrote: asked before anything looks at what it says."""

from __future__ import annotations

import tomllib
from collections.abc import Collection, Mapping, Sequence, Set
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from lienumba.batch.changes import KIND_OF, NONE
from lienumba.batch.statuses import STATUSES
from lienumba.errors import ScenarioError
from lienumba.store import linear_layout, study_layout
from lienumba.store.layout import COORDINATES, FULL, RUN, SAID_OF, VARIABLES, VERDICT, VERDICTS, WARNINGS
from lienumba.store.refusals import check_dimension, check_together, damaged
from lienumba.sweep.samplers import DEFAULT, RETIRED

if TYPE_CHECKING:
    import xarray as xr

DIMENSIONS = ("run", "time", "body", "joint", "axis", "body_axis")  # of which a selection keeps at least one label
NUMBERED = (RUN[0], FULL, "change")  # dimensions whose labels are whole numbers
# Attributes that are texts: of variables, and of the whole.
TEXTS = ("units", "long_name", "frame", "role", "path", "not_unique", "measure")
SHORT_STEPS = ("short_steps", "stiff", "chatters")  # the last two in older files
SAID = ("title", "history", "source", "scenario_sha256", "cpu", "stopped", *SHORT_STEPS, WARNINGS, VERDICT, VERDICTS)
LONGEST = 10_000  # characters of a title, of what is said of a variable, of a label
PACKED = ("scale_factor", "add_offset")  # of variables of other programs
SECTIONS = ("model", "integrator", "output", "sweep", "files", "study", "start")
KINDS: dict[str, type] = {"runs": int, "nominal": bool, "seed": int, "sampler": str}  # of keys of a sweep
NUMERIC, TEXT = "biuf", "US"  # kinds of arrays

VARY, ORDER = "sweep.vary", " (order)"  # another order of these names draws other samples, or stores other records

Tables = dict[str, Any]


def check_form(ds: xr.Dataset, where: str, needed: Sequence[str] = ("status",), kinds: Collection[str] = ()) -> None:
    """Refuse what lienumba has not written, or a selection that has lost too much.

    It may lack variables and runs, and have variables of the user's own; whatever is there by a name of lienumba has
    the dimensions, the type and the labels that it is written with. where: what the dataset is called; needed:
    variables of each run that must be there; kinds: see `linear_layout`, which may be there instead of courses.
    """
    _check_packing(ds, where)
    if linear_layout.check_kind(ds, where, kinds):
        _check_attributes(ds, where)
        linear_layout.check_modes(ds, where)
        return
    _check_selection(ds, where, needed)
    _check_attributes(ds, where)
    grid = {str(dim) for x in ds.coords.values() if x.attrs.get("role") == "grid" for dim in x.dims}
    for name, x in ds.variables.items():
        _check_variable(ds, str(name), x, grid, where)
    _check_statuses(ds["status"], where)
    check_together(ds, where)
    _check_changes(ds, where)
    if study_layout.is_study(ds):
        _check_study(ds, where)


def scenario_tables(ds: xr.Dataset | Mapping[str, Any], where: str) -> Tables:
    """The scenario of a dataset, or of its attributes, as tables; none if it does not have one."""
    text = (ds.attrs if hasattr(ds, "attrs") else ds).get("scenario", "")
    try:
        if not isinstance(text, str):
            raise ValueError("it is no text")
        return _tables(text)
    except (ValueError, RecursionError) as error:
        raise damaged(where, f"its attribute scenario cannot be read ({error})") from None


def current(tables: Tables) -> Tables:
    """A stored scenario as this version has it: without a rule that ended the sweep by a requirement, and with a known
    sampler, since the dataset has the samples."""
    sweep = tables.get("sweep", {})
    kept = {key: x for key, x in sweep.items() if key != "stop" or "requirement" not in x}
    if kept.get("sampler") in RETIRED:
        kept["sampler"] = DEFAULT
    return tables if kept == sweep else {**tables, "sweep": kept}


def by_path(value: object, path: str = "") -> Tables:
    """Every value of a scenario by its path; tables of a list by their names, and the order of these."""
    found: Tables = {}
    if isinstance(value, Mapping):
        items = [(str(key), item) for key, item in value.items()]
        if path == VARY:
            found[path + ORDER] = list(value)
    elif isinstance(value, list) and value and all(isinstance(item, Mapping) for item in value):
        own = ({key: x for key, x in item.items() if key != "name"} for item in value)
        items = [(str(item.get("name", n)), rest) for n, (item, rest) in enumerate(zip(value, own, strict=True))]
        found[path + ORDER] = [name for name, _ in items]
    else:
        return {path: value}
    for key, item in items:
        found |= by_path(item, f"{path}.{key}" if path else key)
    return found


@lru_cache(maxsize=4)
def _tables(text: str) -> Tables:
    tables = tomllib.loads(text)
    for name in (name for name in SECTIONS if name in tables):
        if not isinstance(tables[name], dict):
            raise ValueError(f"{name} is no table")
    sweep = tables.get("sweep", {})
    for key, kind in KINDS.items():
        if not isinstance(sweep.get(key, kind()), kind):
            raise ValueError(f"sweep.{key} is of another kind")
    for key in ("vary", "stop"):
        if not isinstance(sweep.get(key, {}), dict):
            raise ValueError(f"sweep.{key} is no table")
    return tables


def _check_selection(ds: xr.Dataset, where: str, needed: Sequence[str]) -> None:
    for dim in DIMENSIONS:
        check_dimension(ds, dim, where)
    for name in needed:
        if name not in ds or "run" not in ds[name].dims:
            raise ScenarioError(
                f"{where}: does not say {name} of each run; select runs and variables of what lienumba run wrote, and "
                f"keep {' and '.join(needed)}"
            )
    for dim in (dim for dim in COORDINATES if dim != FULL and ds.sizes.get(dim) == 0):
        raise ScenarioError(f"{where}: has no {dim}; select at least one")


def _check_attributes(ds: xr.Dataset, where: str) -> None:
    for name, value in ds.attrs.items():
        if (name in SAID or name.endswith("_version")) and not isinstance(value, str):
            raise damaged(where, f"its attribute {name} is no text")
    if len(ds.attrs.get("title", "")) > LONGEST:
        raise damaged(where, f"its title is longer than {LONGEST:,} characters")
    for name, x in ds.variables.items():
        for key in TEXTS:
            text = x.attrs.get(key, "")
            if not isinstance(text, str) or len(text) > LONGEST:
                raise damaged(where, f"the attribute {key} of {name} is no text of at most {LONGEST:,} characters")
    scenario_tables(ds, where)


def _check_packing(ds: xr.Dataset, where: str) -> None:
    """What values are made by, when they are read."""
    for name, x in ds.variables.items():
        packed = [np.asarray(x.encoding[key]) for key in PACKED if key in x.encoding]
        if any(number.dtype.kind not in NUMERIC or number.size != 1 for number in packed):
            raise damaged(where, f"{name} is packed by something that is no number")


def _check_variable(ds: xr.Dataset, name: str, x: xr.Variable, grid: Set[str], where: str) -> None:
    role = x.attrs.get("role")
    if name in COORDINATES:
        _check_labels(name, x, where)
    elif role == "grid":
        if "path" not in x.attrs or len(x.dims) != 1 or x.dtype.kind not in NUMERIC + TEXT + "O":
            raise damaged(where, f"{name} is no coordinate of a grid")
    elif role == "input":
        if x.dims != RUN or x.dtype.kind != "f":
            raise damaged(where, f"the input {name} is not one number for each run")
    elif (spec := VARIABLES.get(name) or study_layout.VARIABLES.get(name)) is not None:
        own = [FULL if dim == RUN[0] and FULL in x.dims else dim for dim in spec.dims]
        kept = [dim for dim in own if dim in x.dims or dim in DIMENSIONS]
        if [dim for dim in x.dims if dim not in grid] != kept or x.dtype.kind not in NUMERIC:
            raise damaged(where, f"{name} is not {' by '.join(spec.dims) or 'one number'}")
    for dim in (str(dim) for dim in x.dims if dim in COORDINATES and dim not in ds.coords):
        raise damaged(where, f"{dim} has no labels")


def _check_study(ds: xr.Dataset, where: str) -> None:
    """What belongs together in the dataset of a study."""
    states = [name for name in study_layout.ERRORS if f"{name}_error" in ds or f"reference_{name}_error" in ds]
    known = dict.fromkeys([*states, *study_layout.errors_of(ds)])
    needed = [f"{of}{name}_error" for name in known for of in ("", "reference_")]
    lost = [name for name in [*needed, *study_layout.COSTS] if name not in ds.data_vars]
    if lost:
        raise damaged(where, f"it has lost {lost[0]}")
    grid = {dim for name in study_layout.grid_of(ds) for dim in ds[name].dims}
    if any(not ds.sizes[dim] for dim in grid) or not {*ds["status"].dims} - {RUN[0]} <= grid:
        raise damaged(where, "its grid has no points")


def _check_changes(ds: xr.Dataset, where: str) -> None:
    """Each must be of something, of a kind and at a time."""
    if "change_kind" not in ds:
        return
    kinds, whats = ds["change_kind"].values, ds["change_what"].values
    some = kinds != NONE
    for kind in np.unique(kinds[some]).tolist():
        if kind not in KIND_OF:
            raise damaged(where, f"change_kind has a value {kind}, which means nothing")
        of, here = "event" if KIND_OF[kind].of_event else "switch", whats[kinds == kind]
        if not (here.min() >= 0 and here.max() < ds.sizes.get(of, 0)):
            raise damaged(where, f"change_what is of no {of}")
    if not np.isfinite(ds["change_time"].values[some]).all():
        raise damaged(where, "changes have no times")


def _check_labels(name: str, x: xr.Variable, where: str) -> None:
    """Those of a dimension, each of which names one place."""
    if x.dims != (SAID_OF.get(name, name),):
        raise damaged(where, f"{name} does not label the dimension of its name")
    values = x.values
    if name in NUMBERED and values.dtype.kind not in "iu":
        raise damaged(where, f"{name} has labels that are no whole numbers")
    if name == "time" and (values.dtype.kind != "f" or not np.isfinite(values).all() or (np.diff(values) <= 0).any()):
        raise damaged(where, "its times do not ascend")
    if name not in (*NUMBERED, "time") and not all(isinstance(label, str) for label in values.tolist()):
        raise damaged(where, f"{name} has labels that are no names")
    if values.dtype.kind in "OU" and any(len(label) > LONGEST for label in values.tolist()):
        raise damaged(where, f"{name} has a label of more than {LONGEST:,} characters")
    if name not in SAID_OF and len(np.unique(values)) != len(values):
        raise damaged(where, f"{name} has a label twice")


def _check_statuses(status: xr.DataArray, where: str) -> None:
    """They must be those that this version knows, and mean the same."""
    known = {code.code: code.name for code in STATUSES}
    former = {code.code: code.former for code in STATUSES}
    if status.dtype.kind not in "iu":
        raise damaged(where, "status is no code")
    flags, names = status.attrs.get("flag_values"), status.attrs.get("flag_meanings")
    if flags is not None or names is not None:
        codes = np.atleast_1d(np.asarray(flags)).tolist()
        meant = names.split() if isinstance(names, str) else []
        named = zip(codes, meant, strict=False)
        if len(codes) != len(meant) or any(word not in (known.get(code), former.get(code)) for code, word in named):
            raise damaged(where, "what its statuses mean (flag_values, flag_meanings) is not known")
    for code in np.unique(status.values).tolist():
        if code not in known:
            raise damaged(where, f"status has a value {code}, which means nothing")
