"""Vibration modes of every run: eigenvalues of its linear system, and shapes."""

from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from lienumba.batch.execute import usable_cores
from lienumba.engine.linear.linearise import check_states, turning
from lienumba.engine.linear.states import Asked, At
from lienumba.engine.linear.tracking import Tracked, crossings, tracked, weights_of
from lienumba.errors import ScenarioError
from lienumba.groups.state import ELEMENT
from lienumba.integrators.tracing.linear.algebra import eigenvalues, eigenvectors, grows
from lienumba.integrators.tracing.linear.freedoms import FreedomTracer
from lienumba.integrators.tracing.linear.outputs import LinearOutputs
from lienumba.integrators.tracing.linear.systems import STILL, Recorded, Systems
from lienumba.mechanics.mechanism.model import Model
from lienumba.store.layout import RUN, VARIABLES, WEIGHT, texts
from lienumba.store.linear_layout import MODE, MODES, PARTS, QUANTILES, SHAPE, SHAPES
from lienumba.sweep import weighted
from lienumba.sweep.design import NOMINAL_RUN

if TYPE_CHECKING:
    import os

    import xarray as xr

Array = npt.NDArray[Any]
STATUS = "0: linearised, 1: the run is not there at this time, or has no linear equations"
NONE = complex(np.nan, np.nan)
POSE = 12  # numbers of a body's state that say where it is


def modes(
    scenario: "Any | xr.Dataset | str | os.PathLike[str]",
    *,
    at: At = 0.0,
    shapes: bool = True,
    rotation: Sequence[float] = STILL,
    runs: Sequence[int] | None = None,
    overrides: Mapping[str, Any] | None = None,
    allow_code: bool = False,
) -> "xr.Dataset":
    """Find the vibration modes of every run about its motion at some times.

    Parameters
    ----------
    scenario, at, rotation, runs, overrides, allow_code
        As for `lienumba.linearise`.
    shapes : bool
        Whether mode shapes are found as well, and by them which mode is which over the runs; without them modes are in
        the order of their frequencies.

    Returns
    -------
    xarray.Dataset
        On (run, time, mode): `growth` (real part, 1/s) and `angular_frequency` (imaginary part, rad/s) of each
        eigenvalue, of a pair that with the positive one; `frequency` (Hz), `damping_ratio`; `stable` on (run, time).
        `translation` and `turn` of all bodies (global axes, the largest component 1) on (..., body, axis, part);
        `mac`: how alike a shape is to that of the run it was compared with; `crossed`: whether a mode is on the other
        side of another one, in the order of frequencies, than in the first run; `position` and `rotation` of the
        bodies. On (quantile, time, mode): `frequency_quantiles`, `damping_ratio_quantiles` over the sampled runs, by
        their `weight` if they have one. `origin` on time. NaN where a run has fewer modes, or is not there.

    Raises
    ------
    ScenarioError
        For bad input, with a sentence for each problem.
    """
    asked = Asked.of(scenario, at, runs, overrides, allow_code)
    prepared = asked.prepared()
    tracer, model = FreedomTracer.of(prepared.model), prepared.nominal.model
    recorded = Recorded.of(tracer, LinearOutputs((), ()), prepared.model)
    weights, tracks, poses, origins = weights_of(model), [], [], []
    for states in asked.states(tracer, prepared):
        check_states(tracer, states)
        origins.append(states.origin)
        values, moved = _eigenvalues(recorded, states, turning(rotation), shapes)
        tracks.append(Tracked(values) if moved is None else tracked(values, moved, weights, asked.samples))
        if shapes:
            poses.append(states.bodies(tracer, prepared.model)[:, :, :POSE])
    if not any(np.isfinite(x.values).any() for x in tracks):
        raise ScenarioError("no run has modes at these times: it fails before, or nothing of it can move")
    start = np.asarray(prepared.states).reshape(len(asked.labels), -1, ELEMENT)[:, :, :POSE]
    origin = asked.origins(origins, tracer, prepared)
    return _dataset(asked, model, tracks, poses and [start, *poses], origin, turning(rotation))


def _eigenvalues(recorded: Recorded, states: Any, rotation: Any, shapes: bool) -> tuple[Array, Array | None]:
    """Eigenvalues (runs, modes) with an imaginary part of at least 0, ascending; and shapes (runs, modes, 6 k)."""

    with ThreadPoolExecutor(usable_cores()) as pool:  # which find eigenvalues while the next systems are made
        systems = recorded.systems(states, rotation)
        tasks = [pool.submit(_of_system, recorded.moving(system), shapes) for system in systems]
        pieces = [task.result() for task in tasks]
    widest = max((values.shape[1] for _, values, _ in pieces), default=0)
    total = np.full((len(states.good), widest), NONE)
    bodies = 6 * len(recorded.tracer.graph()[1].bodies)
    every = np.full((len(total), widest, bodies), NONE) if shapes else None
    for runs, values, moved in pieces:
        total[runs, : values.shape[1]] = values
        if every is not None and moved is not None:
            every[runs, : values.shape[1]] = moved
    return total, every


def _of_system(system: Systems, shapes: bool) -> tuple[Array, Array, Array | None]:
    """Runs, eigenvalues and shapes. Of eigenvalues that are 0 every second one counts: a coordinate without stiffness
    has two of them."""
    finite = np.asarray(np.isfinite(system.A).all(axis=(1, 2)))
    runs, A = system.runs[finite], system.A[finite]
    scale = system.scale[finite]
    values, vectors = eigenvectors(A, scale) if shapes else (eigenvalues(A, scale), None)
    zero = values == 0.0
    upper = (values.imag >= 0.0) & ~(zero & (np.cumsum(zero, axis=1) % 2 == 0))
    order = np.lexsort((-values.real, np.where(upper, values.imag, np.inf)), axis=1)
    order = order[:, : int(upper.sum(axis=1).max(initial=0))]
    values = np.take_along_axis(np.where(upper, values, NONE), order, axis=1)
    if vectors is None:
        return runs, values, None
    moved = system.bodies[finite] @ np.take_along_axis(vectors, order[:, None, :], axis=2)
    shapes_of = _by_largest(moved.mT)
    shapes_of[np.isnan(values)] = NONE
    return runs, values, shapes_of


def _by_largest(shapes: Array) -> Array:
    """Complex shapes (runs, modes, 6 k) whose largest component is 1."""
    best = np.abs(shapes).argmax(axis=2)[:, :, None]
    largest = np.take_along_axis(shapes, best, axis=2)
    return shapes / np.where(largest == 0.0, 1.0, largest)


def _dataset(
    asked: Asked, model: Model, tracks: Sequence[Tracked], poses: Sequence[Array], origin: Mapping[str, Any],
    rotation: Sequence[float],
) -> "xr.Dataset":  # fmt: skip
    most = max(x.values.shape[1] for x in tracks)

    def whole(parts: Sequence[Array], fill: Any = np.nan) -> Array:
        padded = [
            np.pad(x, [(0, 0), (0, most - x.shape[1]), *[(0, 0)] * (x.ndim - 2)], constant_values=fill) for x in parts
        ]
        return np.stack(padded, axis=1)

    values, dims = whole([x.values for x in tracks], NONE), MODE
    sizes = np.abs(values)
    growing = grows(values.reshape(-1, most)).reshape(values.shape)
    with np.errstate(all="ignore"):
        damping = np.where(sizes > 0.0, (0.0 - values.real) / sizes, np.where(np.isnan(sizes), np.nan, 0.0))
        frequency = values.imag / (2.0 * np.pi)
    there = np.isfinite(values.real).any(axis=2)
    sampled = np.asarray(asked.labels) != NOMINAL_RUN
    counted = sampled if sampled.any() else ~sampled
    weights = asked.weights()
    over, own = ("quantile", *dims[1:]), None if weights is None else weights[counted]
    variables: dict[str, Any] = {
        "growth": (dims, values.real, {"units": "s-1", "long_name": "real part of the eigenvalue"}),
        "angular_frequency": (dims, values.imag, {"units": "rad s-1", "long_name": "imaginary part"}),
        "frequency": (dims, frequency, {"units": "Hz"}),
        "damping_ratio": (dims, damping, {"units": "1", "long_name": "-real part / |eigenvalue|"}),
        "grows": (dims, growing, {"long_name": "whether the mode grows, beyond rounding"}),
        "stable": (dims[:2], there & ~growing.any(axis=2), {"long_name": "no mode grows"}),
        "status": (dims[:2], np.where(there, 0, 1).astype(np.int8), {"long_name": STATUS}),
        "frequency_quantiles": (over, _quantiles(frequency[counted], own), {"units": "Hz"}),
        "damping_ratio_quantiles": (over, _quantiles(damping[counted], own), {"units": "1"}),
    }
    variables |= origin
    if weights is not None:
        variables[WEIGHT] = (RUN, weights, texts(VARIABLES[WEIGHT].units, VARIABLES[WEIGHT].long_name))
    coordinates: dict[str, Any] = {
        "time": asked.times, "mode": np.arange(1, most + 1), "quantile": list(QUANTILES),
    }  # fmt: skip
    if poses:
        shape = whole([x.shapes for x in tracks])
        parts = np.stack([shape.real, shape.imag], axis=-1).reshape(*shape.shape[:3], -1, 2, 3, 2)
        variables["translation"] = (SHAPE, parts[:, :, :, :, 0], {"units": "m", "frame": "global"})
        variables["turn"] = (SHAPE, parts[:, :, :, :, 1], {"units": "rad", "frame": "global"})
        likeness = "likeness to the shape it was compared with"
        variables["mac"] = (dims, whole([x.mac for x in tracks]), {"units": "1", "long_name": likeness})
        crossed = np.stack([crossings(x) for x in values.swapaxes(0, 1)], axis=1)
        variables["crossed"] = (dims, crossed, {"long_name": "stands elsewhere among the frequencies of its run"})
        for prefix, pose in (("start_", poses[0]), ("", np.stack(poses[1:], axis=1))):
            position, turned = prefix + "position", prefix + "rotation"
            axes = pose[..., 3:].reshape(*pose.shape[:-1], 3, 3)
            variables[position] = (SHAPES[position], pose[..., :3], {"units": "m", "frame": "global"})
            variables[turned] = (SHAPES[turned], axes, {"units": "1", "frame": "body to global"})
        coordinates |= {"body": [body.name for body in model.bodies], "axis": list("xyz"), "part": list(PARTS)}
        coordinates["body_axis"] = list("xyz")
    return asked.dataset(MODES, variables, coordinates, rotation=list(rotation))


def _quantiles(x: Array, weights: Array | None) -> Array:
    """Over the runs that have the mode (quantiles, time, mode); weights: of runs, if they have some."""
    quantiles = np.full((len(QUANTILES), *x.shape[1:]), np.nan)
    for place in np.ndindex(x.shape[1:]):
        own = x[(slice(None), *place)]
        there = np.isfinite(own)
        if there.any():
            few = None if weights is None else weights[there]
            quantiles[(slice(None), *place)] = weighted.quantiles(own[there], few, QUANTILES)
    return quantiles
