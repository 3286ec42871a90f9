"""Vibration modes of every run: eigenvalues of its linear system, shapes, and which mode is which over the runs.

A mode keeps its number over the runs by its shape: the modal assurance criterion |a^H W b|^2 / (a^H W a)(b^H W b),
W the masses and mean moments of inertia of the bodies, and pairs that give the largest sum (Allemang 2003, The modal
assurance criterion, Sound and Vibration). Where one number is swept each run is compared with its neighbour, else with
the first run.
"""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from lienumba.engine.linear.linearise import STILL, check_states, turning
from lienumba.engine.linear.looked import Looked
from lienumba.engine.linear.states import Asked, At
from lienumba.engine.linear.systems import Recorded
from lienumba.errors import ScenarioError
from lienumba.integrators.tracing.linear.freedoms import FreedomTracer
from lienumba.mechanics.mechanism.model import Model

if TYPE_CHECKING:
    import os

    import xarray as xr

Array = npt.NDArray[Any]
QUANTILES = (0.05, 0.5, 0.95)
ROUNDING = 1e-7  # of the largest eigenvalue: what grows more slowly may be rounding of a double zero
PARTS = ("real", "imag")
STATUS = "0: linearised, 1: the run is not there at this time, or has no linear equations"
NONE = complex(np.nan, np.nan)


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
        `mac`: how alike a shape is to that of the run it was compared with; `crossed`: whether a mode stands elsewhere
        in the order of frequencies than in the first run. `frequency_quantiles` over the runs. NaN where a run has
        fewer modes, or is not there.

    Raises
    ------
    ScenarioError
        For bad input, with a sentence for each problem.
    """
    asked = Asked.of(scenario, at, runs, overrides, allow_code)
    prepared = asked.prepared()
    tracer, model = FreedomTracer.of(prepared.model), prepared.nominal.model
    recorded = Recorded.of(tracer, Looked((), ()))
    weights, found = weights_of(model), []
    for states in asked.states(tracer, prepared):
        check_states(tracer, states)
        values, moved = _eigenvalues(recorded, states, turning(rotation), shapes)
        found.append((values,) if moved is None else _tracked(values, moved, weights, _order(asked)))
    if not any(np.isfinite(values).any() for values, *_ in found):
        raise ScenarioError("no run has modes at these times: it fails before, or nothing of it can move")
    return _dataset(asked, model, found)


def _eigenvalues(recorded: Recorded, states: Any, rotation: Any, shapes: bool) -> tuple[Array, Array | None]:
    """Eigenvalues (runs, modes) with an imaginary part of at least 0, ascending; and shapes (runs, modes, 6 k)."""
    pieces = []
    for system in recorded.systems(states, rotation):
        if not shapes:
            pieces.append((system.runs, np.linalg.eigvals(system.A).astype(complex), None))
            continue
        values, vectors = np.linalg.eig(system.A)
        pieces.append((system.runs, values.astype(complex), (system.bodies @ vectors).transpose(0, 2, 1)))
    widest, kept = 0, []
    for runs, values, moved in pieces:
        upper = values.imag >= 0.0
        order = np.lexsort((values.real, np.where(upper, values.imag, np.inf)), axis=1)
        count = int(upper.sum(axis=1).max(initial=0))
        order, widest = order[:, :count], max(widest, count)
        values = np.take_along_axis(np.where(upper, values, NONE), order, axis=1)
        moved = None if moved is None else np.take_along_axis(moved, order[:, :, None], axis=1)
        kept.append((runs, values, moved))
    total = np.full((len(states.labels), widest), NONE)
    bodies = 6 * len(recorded.tracer.graph()[1].bodies)
    every = np.full((len(total), widest, bodies), np.nan, complex) if shapes else None
    for runs, values, moved in kept:
        total[runs, : values.shape[1]] = values
        if every is not None and moved is not None:
            moved[np.isnan(values)] = np.nan
            every[runs, : values.shape[1]] = moved
    return total, every


def weights_of(model: Model) -> Array:
    """Of the shift and turn of each body (6 k): its mass and mean moment of inertia."""
    found: list[float] = []
    for body in model.bodies:
        found += [float(body.mass)] * 3 + [float(sum(body.inertia[:3])) / 3.0] * 3
    return np.array(found)


def _order(asked: Asked) -> list[tuple[int, int]]:
    """Pairs of runs (indices): one, and that with which it is compared; the first run first."""
    runs = range(len(asked.labels))
    if len(asked.samples) == 1:
        sorted_runs = np.argsort(next(iter(asked.samples.values())), kind="stable").tolist()
        return [(run, sorted_runs[max(n - 1, 0)]) for n, run in enumerate(sorted_runs)]
    return [(run, 0) for run in runs]


def _tracked(values: Array, moved: Array, weights: Array, order: list[tuple[int, int]]) -> tuple[Array, ...]:
    """Eigenvalues, shapes, MAC and where each mode stands among the frequencies of its run, with modes where those of
    the run stand to which each is compared."""
    from scipy.optimize import linear_sum_assignment

    sizes = np.sqrt((np.abs(moved) ** 2 * weights).sum(axis=2, keepdims=True))
    unit = np.nan_to_num(moved / np.where(sizes > 0.0, sizes, 1.0))
    mac, place = np.ones(values.shape), np.tile(np.arange(values.shape[1]), (len(values), 1))
    for run, other in order:
        if run == other:
            continue
        alike = np.abs(unit[other].conj() @ (weights * unit[run]).T) ** 2
        nearness = 1.0 / (1.0 + np.abs(values[other][:, None] - values[run]) / (1e-30 + np.abs(values[other][:, None])))
        score = alike + 1e-3 * np.nan_to_num(nearness)  # of equal shapes, such as grow and decay, the nearer value
        rows, columns = linear_sum_assignment(-score)
        where = columns[np.argsort(rows)]
        values[run], moved[run], unit[run] = values[run][where], moved[run][where], unit[run][where]
        mac[run], place[run] = alike[np.arange(len(where)), where], where
    largest = np.take_along_axis(moved, np.abs(np.nan_to_num(moved)).argmax(axis=2)[:, :, None], axis=2)
    shape = moved / np.where(np.abs(largest) > 0.0, largest, 1.0)
    return values, shape, np.where(np.isnan(values), np.nan, mac), place


def _dataset(asked: Asked, model: Model, found: Sequence[tuple[Any, ...]]) -> "xr.Dataset":
    import xarray as xr

    most = max(values.shape[1] for values, *_ in found)

    def whole(n: int, fill: Any = np.nan) -> Array:
        parts = []
        for x in (own[n] for own in found):
            padding = [(0, 0), (0, most - x.shape[1]), *[(0, 0)] * (x.ndim - 2)]
            parts.append(np.pad(x, padding, constant_values=fill))
        return np.stack(parts, axis=1)

    values, dims = whole(0, NONE), ("run", "time", "mode")
    sizes = np.abs(values)
    limit = ROUNDING * np.nanmax(np.where(np.isnan(values), 0.0, sizes), axis=2)
    growing = np.nan_to_num(values.real, nan=-1.0) > limit[:, :, None]
    with np.errstate(all="ignore"):
        damping = np.where(sizes > 0.0, -values.real / sizes, np.nan)
        frequency = values.imag / (2.0 * np.pi)
        quantiles = np.stack([_quantile(frequency, q) for q in QUANTILES])
    there = np.isfinite(values.real).any(axis=2)
    variables: dict[str, Any] = {
        "growth": (dims, values.real, {"units": "s-1", "long_name": "real part of the eigenvalue"}),
        "angular_frequency": (dims, values.imag, {"units": "rad s-1", "long_name": "imaginary part"}),
        "frequency": (dims, frequency, {"units": "Hz"}),
        "damping_ratio": (dims, damping, {"units": "1", "long_name": "-real part / |eigenvalue|"}),
        "grows": (dims, growing, {"long_name": "whether the mode grows, beyond rounding"}),
        "stable": (dims[:2], there & ~growing.any(axis=2), {"long_name": "no mode grows"}),
        "status": (dims[:2], np.where(there, 0, 1).astype(np.int8), {"long_name": STATUS}),
        "frequency_quantiles": (("quantile", *dims[1:]), quantiles, {"units": "Hz"}),
    }
    coordinates: dict[str, Any] = {
        "run": asked.labels, "time": ("time", asked.times, {"units": "s"}), "mode": np.arange(1, most + 1),
        "quantile": list(QUANTILES), **{name: ("run", x, {"role": "input"}) for name, x in asked.samples.items()},
    }  # fmt: skip
    if len(found[0]) > 1:
        shape = whole(1)
        parts = np.stack([shape.real, shape.imag], axis=-1).reshape(*shape.shape[:3], -1, 2, 3, 2)
        own = (*dims, "body", "axis", "part")
        variables["translation"] = (own, parts[:, :, :, :, 0], {"units": "m", "frame": "global"})
        variables["turn"] = (own, parts[:, :, :, :, 1], {"units": "rad", "frame": "global"})
        variables["mac"] = (dims, whole(2), {"units": "1", "long_name": "likeness to the shape it was compared with"})
        place = whole(3, 0)
        crossed = (place != place[:1]) & np.isfinite(values.real)
        variables["crossed"] = (dims, crossed, {"long_name": "stands elsewhere among the frequencies of its run"})
        coordinates |= {"body": [body.name for body in model.bodies], "axis": list("xyz"), "part": list(PARTS)}
    return xr.Dataset(variables, coordinates, asked.attributes("vibration modes"))


def _quantile(frequency: Array, q: float) -> Array:
    """Over the runs that have the mode (time, mode)."""
    found = np.full(frequency.shape[1:], np.nan)
    for place in np.ndindex(found.shape):
        own = frequency[(slice(None), *place)]
        if np.isfinite(own).any():
            found[place] = np.quantile(own[np.isfinite(own)], q)
    return found
