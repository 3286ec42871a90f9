"""The layout of the dataset: names, dimensions, units and encodings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from lienumba.batch.changes import NAMES, NONE
from lienumba.compiler.memo import Memo
from lienumba.integrators.codes import EQUILIBRIA
from lienumba.mechanics.system.output_variables import (
    MODE,
    OUTPUT_VARIABLES,
    OutputVariable,
    kept_at_end,
    kept_largest,
)

if TYPE_CHECKING:
    import xarray as xr

SERIES = ("run", "time")
RUN = ("run",)
CHANGE = ("run", "change")
LABEL = "label"  # the field of records that says which run they are of
FULL = "full_run"  # the dimension of the runs whose course is stored where that of others is not
CHUNK_BYTES = 1 << 17  # whole runs up to this size share a chunk: few chunks to write, quick to read run by run


@dataclass(frozen=True)
class Variable:
    """One variable of the dataset; `dtype` is how the file holds it, one of CF 1.8, which has no int64; count: a whole
    number that failed runs have none of; flags: what whole numbers mean, from the first on; reaction, since: see
    `OutputVariable`; measure: its formula."""

    dims: tuple[str, ...]
    units: str
    long_name: str
    frame: str | None = None
    dtype: str = "float64"
    count: bool = False
    reaction: bool = False
    flags: tuple[str, ...] = ()
    first_flag: int = 0
    since: bool = False
    measure: str | None = None


MARGIN, MET = "requirement_margin", "requirement_met"
WEIGHT, RELATIVE_DRIFT = "weight", "max_relative_energy_drift"
VERDICT, VERDICTS = "verdict", "verdicts"  # attributes: sentences, and the same as JSON
WARNINGS = "warnings"  # an attribute: a sentence in each line
FEW = 64  # runs, up to which what datasets have in common is kept
FRAMES: Memo[xr.Dataset] = Memo(16)
# Of every run, whatever is stored over time.
OF_RUNS: dict[str, Variable] = {
    "status": Variable(RUN, "1", "how the run ended", dtype="int8"),
    "end_time": Variable(RUN, "s", "simulated time that the run reached"),
    "steps": Variable(RUN, "1", "accepted steps", dtype="int32"),
    "rejected_steps": Variable(RUN, "1", "rejected steps", dtype="int32"),
    "event_time": Variable(("run", "event"), "s", "time at which the condition first became true"),
    "event_count": Variable(("run", "event"), "1", "how often the condition became true", dtype="int32"),
    "change_time": Variable(CHANGE, "s", "time of the change"),
    "change_kind": Variable(CHANGE, "1", "what changed", dtype="int8", flags=("none", *NAMES), first_flag=NONE),
    "change_what": Variable(
        CHANGE, "1", "index of the event, or from an impact on of the switch, that it is of; -1: none", dtype="int32"
    ),
    "change_impulse": Variable(CHANGE, "1", "size of the impulse of the change (N s, or N m s of an angle)"),
    "change_energy": Variable(CHANGE, "J", "mechanical energy that was lost in the change"),
    "changes": Variable(RUN, "1", "how many changes there were", dtype="int32"),
    "start_equilibrium": Variable(
        RUN, "1", "what kind of equilibrium the run starts in", dtype="int8", flags=EQUILIBRIA
    ),
    "start_state": Variable((*RUN, "start_number"), "1", "state in which the run starts, from which a replay begins"),
    RELATIVE_DRIFT: Variable(RUN, "1", "largest energy residual at the stored times by the energy that was exchanged"),
    "energy_lost": Variable(RUN, "J", "mechanical energy that was lost in all changes"),
    "last_mode": Variable(
        (*RUN, "switch"), "1", f"{MODE.long_name} at the end of the run", dtype="int8", flags=MODE.flags
    ),
    MARGIN: Variable(
        (*RUN, "requirement"), "1", "how far the value is on the good side of the limit, in the unit of the requirement"
    ),
    MET: Variable(
        (*RUN, "requirement"), "1", "whether the run meets it (1 or 0), if it counts", dtype="int32", count=True
    ),
    WEIGHT: Variable(RUN, "1", "density of the inputs over that by which the run was drawn"),
}
TABLE = tuple(name for name, x in OF_RUNS.items() if x.dims == CHANGE)  # of changes
# What is of no use without the other: a selection keeps both, or none.
TOGETHER = {**dict.fromkeys(TABLE, (*TABLE, "changes", "energy_lost")), MET: (MARGIN,)}
VARIABLES: dict[str, Variable] = {}


def _derive() -> None:
    """What follows from the output variables: each over time, its largest value, and what it is at the end."""
    VARIABLES.clear()
    VARIABLES.update({name: course(x) for name, x in {**OUTPUT_VARIABLES, MODE.name: MODE}.items()})
    VARIABLES.update(OF_RUNS)
    for name, x in kept_largest().items():
        VARIABLES[name] = Variable(RUN, x.units, x.largest_text)
    for x in kept_at_end():
        VARIABLES[f"last_{x.name}"] = Variable(
            (*RUN, *x.dims), x.units, f"{x.long_name} at the end of the run", x.frame
        )


def course(x: OutputVariable) -> Variable:
    """An output variable as the dataset has it."""
    dtype = "int32" if x.count else "float64"
    return Variable((*SERIES, *x.dims), x.units, x.long_name, x.frame, dtype, x.count, x.reaction, x.flags, 0, x.since)


_derive()
OUTPUT_VARIABLES.listeners.append(_derive)
# Counts are NaN after a failure, as everything is; the file holds them as integers, and NaN as this.
NO_COUNT = -1

COORDINATES = {
    "run": ("1", "label of the run (-1: the nominal run)"),
    FULL: ("1", "label of a run whose course is stored"),
    "time": ("s", "elapsed simulation time"),
    "body": ("1", "name of the body"),
    "joint": ("1", "name of the joint"),
    "constraint": ("1", "name of the joint and number of its constraint equation"),
    "effort": ("1", "name of the driver, and axis where it drives three"),
    "coordinate": ("1", "name of the joint, and of its coordinate where it has several"),
    "coordinate_units": ("1", "unit of the coordinate; its rate has this per s, what acts along it N m or N"),
    "event": ("1", "name of the event"),
    "change": ("1", "number of the change, from 0 on"),
    "start_number": ("1", "what the number of a start is (m, rad, m/s, rad/s; global frame, angular velocity: body)"),
    "requirement": ("1", "name of the requirement"),
    "requirement_units": ("1", "unit of the margin of the requirement"),
    "input": ("1", "path of the number of the scenario by which it is differentiated"),
    "input_units": ("1", "unit of the number by which it is differentiated"),
    "switch": ("1", "name of the joint, lock, limit, contact or friction that may be on or off"),
    "axis": ("1", "axis of the global frame, or of the body frame where the variable's frame is body"),
    "body_axis": ("1", "axis of the body frame"),
}

# Coordinates that say more of a dimension than its labels do.
SAID_OF = {"coordinate_units": "coordinate", "requirement_units": "requirement", "input_units": "input"}


FAILED = "failed"  # 1 or 0 of each run, as its status says


def is_taken(name: object) -> bool:
    """Whether the dataset has a variable, a coordinate or another number of this name, whatever a scenario calls its
    own."""
    return name in VARIABLES or name in COORDINATES or name == FAILED


def dataset(
    *,
    variables: Mapping[str, np.ndarray],
    times: Sequence[float],
    runs: Sequence[int],
    bodies: Sequence[str],
    joints: Sequence[str],
    constraints: Sequence[str],
    efforts: Sequence[str] = (),
    coordinates: Mapping[str, str] | None = None,
    events: Sequence[str] = (),
    changes: int = 0,
    switches: Sequence[str] = (),
    requirements: Mapping[str, str] | None = None,
    by: Mapping[str, str] | None = None,
    inputs: Mapping[str, np.ndarray],
    input_units: Mapping[str, str],
    attributes: Mapping[str, str | int | float],
    shared: Sequence[str] = (),
    own: Mapping[str, Variable] | None = None,
    full_runs: Sequence[int] = (),
    total: int | None = None,
    start: Sequence[str] = (),
) -> xr.Dataset:
    """The labelled dataset of these arrays; `inputs` are the samples (runs,) of each varied path; `shared`: joints and
    drivers whose reactions are not unique; `coordinates`: of joints, and `requirements`, with their units; `changes`:
    of how many of a run it tells; `own`: variables that are not those of every scenario; `total`: of how many runs it
    will be, if it has none of them yet; `start`: the names of the numbers of a start that is stored; `by`:
    inputs of derivatives, with their units.

    Dimensions without entries (a system without joints) are left out together with their variables.
    """
    labels: dict[str, np.ndarray] = {
        "run": np.asarray(runs, dtype=np.int32),
        FULL: np.asarray(full_runs, dtype=np.int32),
        "time": np.asarray(times, dtype=np.float64),
        "body": np.asarray(bodies, dtype=str),
        "joint": np.asarray(joints, dtype=str),
        "constraint": np.asarray(constraints, dtype=str),
        "effort": np.asarray(efforts, dtype=str),
        "coordinate": np.asarray(list(coordinates or {}), dtype=str),
        "coordinate_units": np.asarray(list((coordinates or {}).values()), dtype=str),
        "event": np.asarray(events, dtype=str),
        "change": np.arange(changes, dtype=np.int32),
        "start_number": np.asarray(start, dtype=str),
        "switch": np.asarray(switches, dtype=str),
        "requirement": np.asarray(list(requirements or {}), dtype=str),
        "requirement_units": np.asarray(list((requirements or {}).values()), dtype=str),
        "input": np.asarray(list(by or {}), dtype=str),
        "input_units": np.asarray(list((by or {}).values()), dtype=str),
        "axis": np.array(["x", "y", "z"], dtype=str),
        "body_axis": np.array(["x", "y", "z"], dtype=str),
    }
    specs, total = VARIABLES | dict(own or {}), len(runs) if total is None else total
    arrays = {
        name: _as_kept(specs[name], array)
        for name, array in variables.items()
        if all(len(labels[dim]) for dim in specs[name].dims[1:])
    }
    columns = input_coordinates(inputs, input_units, total)
    if len(runs) > FEW:
        found = _frame(arrays, specs, labels, shared, total)
    else:
        shapes = tuple((name, x.shape, specs[name]) for name, x in arrays.items())
        key = shapes, tuple((name, x.dtype.str, x.tobytes()) for name, x in labels.items()), tuple(shared), total

        def empty() -> xr.Dataset:
            nothing = {name: np.broadcast_to(np.zeros((), x.dtype), x.shape) for name, x in arrays.items()}
            return _frame(nothing, specs, labels, shared, total)

        found = FRAMES.get(key, empty).copy(data=arrays)
    found.attrs = dict(attributes)
    return found.assign_coords(columns) if columns else found


def _frame(
    arrays: Mapping[str, np.ndarray],
    specs: Mapping[str, Variable],
    labels: Mapping[str, np.ndarray],
    shared: Sequence[str],
    total: int,
) -> xr.Dataset:
    """The dataset with its labels and texts."""
    import xarray as xr

    data = {name: variable(name, specs[name], array, total) for name, array in arrays.items()}
    if shared:
        for name in (name for name in data if specs[name].reaction):
            data[name].attrs |= {"not_unique": ", ".join(shared), "comment": "of all possible ones those of least norm"}
    used = {"run", *(dim for variable in data.values() for dim in variable.dims)}
    coordinates: dict[str, xr.Variable] = {
        name: xr.Variable(SAID_OF.get(name, name), values, texts(*COORDINATES[name]), _bare(name, values, total))
        for name, values in labels.items()
        if SAID_OF.get(name, name) in used
    }
    return xr.Dataset(data, coordinates)


def input_coordinates(inputs: Mapping[str, np.ndarray], units: Mapping[str, str], total: int) -> dict[str, xr.Variable]:
    """The samples (runs,) of each varied path, by path."""
    import xarray as xr

    columns = {path: np.asarray(samples, dtype=np.float64) for path, samples in inputs.items()}
    return {
        path: xr.Variable(
            "run", x, texts(units[path], f"sampled input {path}") | {"role": "input"}, _bare("run", x, total)
        )
        for path, x in columns.items()
    }


def _bare(dim: str, values: np.ndarray, total: int) -> dict[str, object]:
    """The encoding of a coordinate: as it is; those of runs in few parts."""
    chunks = _chunks((max(min(total, CHUNK_BYTES // 8), 1),), values.shape) if dim in ("run", FULL) else {}
    return bare(values) | chunks


def bare(labels: np.ndarray) -> dict[str, object]:
    """The encoding of labels: texts as characters, which older readers know, too."""
    return {"_FillValue": None} | ({"dtype": "S1"} if labels.dtype.kind == "U" else {})


def _chunks(chunk: tuple[int, ...], shape: tuple[int, ...]) -> dict[str, object]:
    """How an array of this shape is cut; xarray forgets it in selections, which may have fewer dimensions."""
    return {"chunksizes": chunk, "original_shape": shape}


def variable(name: str, spec: Variable, array: np.ndarray, total: int) -> xr.Variable:
    """A variable of the dataset with its texts and encoding; a count below 0 is none; total: number of runs."""
    import xarray as xr

    attributes: dict[str, object] = {**texts(spec.units, spec.long_name)}
    if spec.frame is not None:
        attributes["frame"] = spec.frame
    if spec.measure is not None:
        attributes["measure"] = spec.measure
    if spec.dtype == "float32":
        attributes["precision"] = "computed as float64, stored rounded to float32"
    if name == "status":
        attributes |= _flags()
    if spec.flags:
        values = np.arange(spec.first_flag, spec.first_flag + len(spec.flags), dtype=spec.dtype)
        attributes |= {"flag_values": values, "flag_meanings": " ".join(spec.flags)}
    array = _as_kept(spec, array)
    return xr.Variable(spec.dims, array, attributes, _encoding(spec, array.shape, total))


def _as_kept(spec: Variable, array: np.ndarray) -> np.ndarray:
    """An array in the type that it has in memory; a count below 0 is none."""
    if spec.count:
        array = np.where(array < 0, np.nan, array)
    return array if spec.count else narrowed(array, np.dtype(spec.dtype))


def narrowed(array: np.ndarray, dtype: np.dtype[Any]) -> np.ndarray:
    """An array in this type: of counts that are beyond it, its largest number."""
    array = np.asarray(array)
    if dtype.kind == "i" and dtype.itemsize < array.itemsize:
        array = np.minimum(array, np.iinfo(dtype).max)
    return array.astype(dtype, copy=False)


def _encoding(spec: Variable, shape: tuple[int, ...], total: int) -> dict[str, object]:
    fill_value = NO_COUNT if spec.count else np.nan if spec.dtype.startswith("float") else None
    run_bytes = int(np.prod(shape[1:])) * np.dtype(spec.dtype).itemsize
    runs_per_chunk = max(min(CHUNK_BYTES // max(run_bytes, 1), total), 1)
    return {
        "dtype": spec.dtype,
        "_FillValue": fill_value,
        "coordinates": None,  # of the whole: brackets of paths must not stand in this attribute of a variable
        "zlib": True,
        "complevel": 1,
        "shuffle": True,
        **_chunks((runs_per_chunk, *shape[1:]), shape),
    }


def texts(units: str, long_name: str) -> dict[str, str]:
    """The attributes that every variable and coordinate has."""
    return {"units": units, "long_name": long_name}


def _flags() -> dict[str, object]:
    from lienumba.batch.statuses import STATUSES

    values = np.array([status.code for status in STATUSES], dtype=np.int8)
    values.flags.writeable = False  # it is that of every dataset
    return {
        "flag_values": values,
        "flag_meanings": " ".join(status.name for status in STATUSES),
        "comment": "\n".join(f"{status.name}: {status.sentence}" for status in STATUSES),
    }


def warnings_in(ds: xr.Dataset) -> list[str]:
    """The warnings about its results that a dataset has."""
    return str(ds.attrs.get(WARNINGS, "")).splitlines()
