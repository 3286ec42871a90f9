"""The layout of the dataset: names, dimensions, units and encodings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from lienumba.compiler.memo import Memo, content

if TYPE_CHECKING:
    import numpy as np
    import xarray as xr

STATE = ("run", "time", "body", "axis")
JOINT = ("run", "time", "joint", "axis")
LAST = ("run", "body", "axis")
SERIES = ("run", "time")
RUN = ("run",)
FULL = "full_run"  # the dimension of the runs whose course is stored where that of others is not
CHUNK_BYTES = 1 << 17  # whole runs up to this size share a chunk: few chunks to write, quick to read run by run


@dataclass(frozen=True)
class Variable:
    """One variable of the dataset; `dtype` is how the file holds it."""

    dims: tuple[str, ...]
    units: str
    long_name: str
    frame: str | None = None
    dtype: str = "float64"


FEW = 64  # runs, up to which what datasets have in common is kept
FRAMES: Memo[xr.Dataset] = Memo(16)

VARIABLES: dict[str, Variable] = {
    "position": Variable(STATE, "m", "position of the mass centre", "global"),
    "rotation": Variable((*STATE, "body_axis"), "1", "rotation matrix", "body to global"),
    "velocity": Variable(STATE, "m s-1", "velocity of the mass centre", "global"),
    "angular_velocity": Variable(STATE, "rad s-1", "angular velocity", "body"),
    "joint_force": Variable(JOINT, "N", "force of the joint on its second body, at its point", "global"),
    "joint_torque": Variable(JOINT, "N m", "torque of the joint on its second body, about its point", "global"),
    "multiplier": Variable(("run", "time", "constraint"), "1", "Lagrange multiplier (N, or N m of an angle)"),
    "driver_effort": Variable(
        ("run", "time", "effort"),
        "1",
        "force (N) or torque (N m) of the driver",
        "of a joint: along or about its axis; point: global; orientation: body; angular_velocity: that of its value",
    ),
    "energy": Variable(SERIES, "J", "total energy"),
    "kinetic_energy": Variable(SERIES, "J", "kinetic energy"),
    "potential_energy": Variable(SERIES, "J", "potential energy"),
    "work": Variable(SERIES, "J", "work done on the system since the start"),
    "energy_residual": Variable(SERIES, "J", "total energy minus work minus initial energy"),
    "position_violation": Variable(SERIES, "m", "largest component of the position constraints"),
    "velocity_violation": Variable(SERIES, "m s-1", "largest component of the velocity constraints"),
    "position_iterations": Variable(SERIES, "1", "iterations of the position projection", dtype="int32"),
    "velocity_iterations": Variable(SERIES, "1", "iterations of the velocity projection", dtype="int32"),
    "status": Variable(RUN, "1", "how the run ended", dtype="int8"),
    "end_time": Variable(RUN, "s", "simulated time that the run reached"),
    "steps": Variable(RUN, "1", "accepted steps", dtype="int64"),
    "rejected_steps": Variable(RUN, "1", "rejected steps", dtype="int64"),
    "max_position_violation": Variable(RUN, "m", "largest position violation at the stored times"),
    "max_velocity_violation": Variable(RUN, "m s-1", "largest velocity violation at the stored times"),
    "last_position": Variable(LAST, "m", "position of the mass centre at the end of the run", "global"),
    "last_rotation": Variable((*LAST, "body_axis"), "1", "rotation matrix at the end of the run", "body to global"),
    "last_velocity": Variable(LAST, "m s-1", "velocity of the mass centre at the end of the run", "global"),
    "last_angular_velocity": Variable(LAST, "rad s-1", "angular velocity at the end of the run", "body"),
    "event_time": Variable(("run", "event"), "s", "time at which the condition first became true"),
    "event_count": Variable(("run", "event"), "1", "how often the condition became true", dtype="int64"),
    "max_energy_drift": Variable(RUN, "J", "largest absolute energy residual at the stored times"),
}
REACTIONS = {"joint_force", "joint_torque", "multiplier", "driver_effort"}
# Counts are NaN after a failure, as everything is; the file holds them as integers, and NaN as this.
NO_COUNT = -1
COUNTS = ("position_iterations", "velocity_iterations", "max_position_iterations", "max_velocity_iterations")

COORDINATES = {
    "run": ("1", "label of the run (-1: the nominal run)"),
    FULL: ("1", "label of a run whose course is stored"),
    "time": ("s", "elapsed simulation time"),
    "body": ("1", "name of the body"),
    "joint": ("1", "name of the joint"),
    "constraint": ("1", "name of the joint and number of its constraint equation"),
    "effort": ("1", "name of the driver, and axis where it drives three"),
    "event": ("1", "name of the event"),
    "axis": ("1", "axis of the global frame, or of the body frame where the variable's frame is body"),
    "body_axis": ("1", "axis of the body frame"),
}


def dataset(
    *,
    variables: Mapping[str, np.ndarray],
    times: Sequence[float],
    runs: Sequence[int],
    bodies: Sequence[str],
    joints: Sequence[str],
    constraints: Sequence[str],
    efforts: Sequence[str] = (),
    events: Sequence[str] = (),
    inputs: Mapping[str, np.ndarray],
    input_units: Mapping[str, str],
    attributes: Mapping[str, str | int | float],
    shared: Sequence[str] = (),
    own: Mapping[str, Variable] | None = None,
    full_runs: Sequence[int] = (),
    total: int | None = None,
) -> xr.Dataset:
    """The labelled dataset of these arrays; `inputs` are the samples (runs,) of each varied path; `shared`: joints and
    drivers whose reactions are not unique; `own`: variables that are not those of every scenario; `total`: of how many
    runs it will be, if it has none of them yet.

    Dimensions without entries (a system without joints) are left out together with their variables.
    """
    import numpy as np

    labels: dict[str, np.ndarray] = {
        "run": np.asarray(runs, dtype=np.int64),
        FULL: np.asarray(full_runs, dtype=np.int64),
        "time": np.asarray(times, dtype=np.float64),
        "body": np.asarray(bodies, dtype=str),
        "joint": np.asarray(joints, dtype=str),
        "constraint": np.asarray(constraints, dtype=str),
        "effort": np.asarray(efforts, dtype=str),
        "event": np.asarray(events, dtype=str),
        "axis": np.array(["x", "y", "z"], dtype=str),
        "body_axis": np.array(["x", "y", "z"], dtype=str),
    }
    specs, total = VARIABLES | dict(own or {}), len(runs) if total is None else total
    arrays = {
        name: _as_kept(name, specs[name], array)
        for name, array in variables.items()
        if all(len(labels[dim]) for dim in specs[name].dims[1:])
    }
    columns = input_coordinates(inputs, input_units, total)
    if len(runs) > FEW:
        found = _frame(arrays, specs, labels, shared, total)
    else:
        shapes = tuple((name, x.shape, content(specs[name])) for name, x in arrays.items())
        key = shapes, tuple((name, x.dtype.str, x.tobytes()) for name, x in labels.items()), tuple(shared), total
        nothing = {name: np.broadcast_to(np.zeros((), x.dtype), x.shape) for name, x in arrays.items()}
        found = FRAMES.get(key, lambda: _frame(nothing, specs, labels, shared, total)).copy(data=arrays)
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
        for name in REACTIONS & data.keys():
            data[name].attrs |= {"not_unique": ", ".join(shared), "comment": "of all possible ones those of least norm"}
    used = {"run", *(dim for variable in data.values() for dim in variable.dims)}
    coordinates: dict[str, Any] = {
        name: xr.Variable(name, values, texts(*COORDINATES[name]), _bare(name, values, total))
        for name, values in labels.items()
        if name in used
    }
    return xr.Dataset(data, coordinates)


def input_coordinates(inputs: Mapping[str, np.ndarray], units: Mapping[str, str], total: int) -> dict[str, xr.Variable]:
    """The samples (runs,) of each varied path, by path."""
    import numpy as np
    import xarray as xr

    columns = {path: np.asarray(samples, dtype=np.float64) for path, samples in inputs.items()}
    return {
        path: xr.Variable(
            "run", x, texts(units[path], f"sampled input {path}") | {"role": "input"}, _bare("run", x, total)
        )
        for path, x in columns.items()
    }


def _bare(dim: str, values: np.ndarray, total: int) -> dict[str, Any]:
    """The encoding of a coordinate: as it is; those of runs in few parts."""
    chunks = _chunks((max(min(total, CHUNK_BYTES // 8), 1),), values.shape) if dim in ("run", FULL) else {}
    return {"_FillValue": None} | chunks


def _chunks(chunk: tuple[int, ...], shape: tuple[int, ...]) -> dict[str, Any]:
    """How an array of this shape is cut; xarray forgets it in selections, which may have fewer dimensions."""
    return {"chunksizes": chunk, "original_shape": shape}


def variable(name: str, spec: Variable, array: np.ndarray, total: int) -> xr.Variable:
    """A variable of the dataset with its texts and encoding; a count below 0 is none; total: number of runs."""
    import xarray as xr

    attributes: dict[str, Any] = texts(spec.units, spec.long_name)
    if spec.frame is not None:
        attributes["frame"] = spec.frame
    if name == "status":
        attributes |= _flags()
    array = _as_kept(name, spec, array)
    return xr.Variable(spec.dims, array, attributes, _encoding(spec, name, array.shape, total))


def _as_kept(name: str, spec: Variable, array: np.ndarray) -> np.ndarray:
    """An array in the type that it has in memory; a count below 0 is none."""
    import numpy as np

    if name in COUNTS:
        array = np.where(array < 0, np.nan, array)
    return np.asarray(array, dtype=np.float64 if name in COUNTS else spec.dtype)


def _encoding(spec: Variable, name: str, shape: tuple[int, ...], total: int) -> dict[str, Any]:
    import numpy as np

    fill_value = NO_COUNT if name in COUNTS else np.nan if spec.dtype == "float64" else None
    run_bytes = int(np.prod(shape[1:])) * np.dtype(spec.dtype).itemsize
    runs_per_chunk = max(min(CHUNK_BYTES // max(run_bytes, 1), total), 1)
    return {
        "dtype": spec.dtype,
        "_FillValue": fill_value,
        "zlib": True,
        "complevel": 1,
        "shuffle": True,
        **_chunks((runs_per_chunk, *shape[1:]), shape),
    }


def texts(units: str, long_name: str) -> dict[str, str]:
    """The attributes that every variable and coordinate has."""
    return {"units": units, "long_name": long_name}


def _flags() -> dict[str, Any]:
    import numpy as np

    from lienumba.batch.statuses import STATUSES

    return {
        "flag_values": np.array([status.code for status in STATUSES], dtype=np.int8),
        "flag_meanings": " ".join(status.name for status in STATUSES),
        "comment": "\n".join(f"{status.name}: {status.sentence}" for status in STATUSES),
    }
