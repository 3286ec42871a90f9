"""Modes as the eye sees them: bodies that move along a shape, over one period."""

from __future__ import annotations

import os
from dataclasses import replace
from math import degrees
from typing import Any

import numpy as np
import xarray as xr

from lienumba.analysis.text_table import number_text
from lienumba.engine.linear.modes import modes as found_modes
from lienumba.engine.replay import scenario_of
from lienumba.errors import ScenarioError
from lienumba.groups import se3
from lienumba.scenario.resolve import resolve
from lienumba.scene.mechanism import mechanism
from lienumba.scene.runs import NOMINAL, ShownRun, has_bodies, usual
from lienumba.scene.scene import MovingRun, Scene, box, framed
from lienumba.store.files import reading
from lienumba.store.linear_layout import MODES, has_shapes, is_modes
from lienumba.sweep.design import NOMINAL_RUN
from lienumba.words import listed, plural

FRAMES = 48  # of a period, which cubics and arcs through them cannot be told from
FARTHEST = 0.1  # of the size of the mechanism: what moves farthest of bodies and their edges
LARGEST = 0.35  # rad: what turns most
FADED = 4.0  # a real mode is seen until it has changed by a factor of exp of this
LEAST = 1e-300
DRIFTING = 1.0  # s: what has neither a frequency nor a growth is seen over this time


def mode_scene(
    source: Any,
    *,
    modes: int | range = 1,
    run: int | None = None,
    allow_code: bool = False,
) -> Scene:
    """Modes of one run in motion, for whoever draws them.

    Each moves from where the bodies are over one period, along Re(a shape exp(i w t)) through exp on SE(3). The
    amplitude a is for the eye: nothing moves farther than a tenth of the size of the mechanism, or turns by more than
    0.35 rad. A real mode fades, or grows, by a factor of exp(4).

    Parameters
    ----------
    source : xarray.Dataset, path, dict or System
        What `lienumba.modes` returned, with shapes, or its file, whose first time is looked at; or what has modes: a
        scenario, or what `lienumba.run` returned, which is looked at at its start.
    modes : int or range
        The number of one; or those of a range that the run has.
    run : int, optional
        The label of the run; the nominal or a typical one if omitted.
    allow_code : bool
        Run Python code that a file brings, where modes are yet to be found.

    Returns
    -------
    Scene
        Of each mode one "run".

    Raises
    ------
    ScenarioError
        Where there is no such run or mode, or no shapes.
    """
    if not isinstance(source, xr.Dataset) and not (_is_path(source) and os.fspath(source).endswith(".nc")):
        scenario = resolve(source, allow_code=allow_code)
        label = NOMINAL_RUN if scenario.data.sweep.runs > 1 else 0
        return _seen(found_modes(scenario, runs=[label if run is None else run]), "the modes", modes, None)
    with reading(source, (MODES,)) as (ds, where):
        if is_modes(ds):
            return _seen(ds, where, modes, run)
        first = usual(ds, np.ones(ds.sizes["run"], bool)) if run is None else ShownRun(run, "")
        assert first is not None, "a dataset has a run"
    # HDF5 may end the process where a file that is open is opened again
    return _seen(found_modes(source, runs=[first.run], allow_code=allow_code), where, modes, None)


def _is_path(source: object) -> bool:
    return isinstance(source, str | os.PathLike)


def _seen(ds: xr.Dataset, where: str, modes: int | range, run: int | None) -> Scene:
    """Of a dataset of modes."""
    if not has_shapes(ds):
        raise ScenarioError(f"{where}: has no shapes of modes; find them with shapes=True, and keep all variables")
    scenario = scenario_of(ds, where)
    if not has_bodies(ds, scenario):
        raise ScenarioError(f"{where}: has not all bodies and axes of its scenario; select runs, times and modes only")
    there = (ds["status"].values[:, 0] == 0) if run is None else ds["run"].values == run
    shown = usual(ds, there) if run is None else ShownRun(run, NOMINAL if run == NOMINAL_RUN else "")
    if shown is None or not there.any():
        labels = ds["run"].values
        told = f"run {run}" if run is not None else "run that has modes at its first time"
        raise ScenarioError(f"{where}: has no {told}, but {plural(len(labels), 'run', 'runs')} with labels from "
                            f"{labels.min()} to {labels.max()}; give one that has")  # fmt: skip
    own = ds.isel(time=0).sel(run=shown.run)
    samples = {str(name): x.item() for name, x in own.coords.items() if x.attrs.get("role") == "input"}
    built = mechanism(scenario, samples, own["start_position"].values, own["start_rotation"].values)
    pose = own["position"].values[None], own["rotation"].values[None]
    rest = MovingRun(shown.run, shown.why, True, built, np.zeros(1), *pose)
    has = ds["mode"].values[np.isfinite(own["growth"].values)].tolist()
    chosen = [mode for mode in has if mode in modes] if isinstance(modes, range) else [modes]
    if not chosen or not set(chosen) <= set(has):
        told = f"{plural(len(has), 'mode', 'modes')}, {listed(map(str, has))}" if has else "no modes"
        none = f"{where}: run {shown.run} has no mode {chosen[0] if chosen else modes} at t = {float(own['time']):g} s"
        raise ScenarioError(f"{none}, but {told}; give one of them")
    moving = [_moving(own.sel(mode=mode), rest) for mode in chosen]
    at = f"{rest.label} at t = {float(own['time']):g} s"
    at += f", the first of {ds.sizes['time']} times" if ds.sizes["time"] > 1 else ""
    sizes = {f"by at most {distance:.3g} m and {degrees(turn):.3g}°" for _, distance, turn in moving}
    told = sizes.pop() if len(sizes) == 1 else "as far as is well seen"
    remark = f"{at}, moving {told}: the size of a mode is chosen for the eye"
    return framed([x for x, _, _ in moving], [remark], cycles=True)


def _moving(own: xr.Dataset, rest: MovingRun) -> tuple[MovingRun, float, float]:
    """A mode over its period, about where bodies are; how far something moves (m), and turns (rad)."""
    shift, turn = (own[name].values[..., 0] + 1j * own[name].values[..., 1] for name in ("translation", "turn"))
    low, high = box([rest])
    radii = np.array([solid.radius for solid in rest.mechanism.solids])
    farthest, most = (np.linalg.norm(abs(x), axis=-1) for x in (shift, turn))
    reach, angle = float((farthest + radii * most).max()), float(most.max())
    amplitude = min(FARTHEST * float((high - low).max()) / max(reach, LEAST), LARGEST / max(angle, LEAST))
    growth, w = float(own["growth"]), float(own["angular_frequency"])
    share = np.linspace(0.0, 1.0, FRAMES + 1)
    if w > 0.0:
        end, course = 2.0 * np.pi / w, np.exp(2j * np.pi * share)
    elif growth == 0.0:
        end, course = DRIFTING, np.exp(2j * np.pi * share)
    else:
        end, course = FADED / abs(growth), np.exp(FADED * (share - 1.0 if growth > 0.0 else -share)).astype(complex)
    twist = amplitude * (course[:, None, None] * np.concatenate([shift, turn], axis=-1)).real
    moved = np.stack(se3.exp(tuple(np.moveaxis(twist, -1, 0))), axis=-1)
    positions = rest.positions + moved[..., :3]
    rotations = moved[..., 3:].reshape(*moved.shape[:2], 3, 3) @ rest.rotations
    if not (0.0 < end < np.inf and np.isfinite(positions).all() and np.isfinite(rotations).all()):
        raise ScenarioError(f"mode {int(own['mode'])} of run {rest.run} has a shape that is not finite; choose another")
    found = replace(rest, times=end * share, positions=positions, rotations=rotations, name=name_of(own))
    return found, amplitude * reach, amplitude * angle


def name_of(own: xr.Dataset) -> str:
    """What a mode of a run is called."""
    growth, frequency = float(own["growth"]), float(own["frequency"])
    if frequency > 0.0:
        what = f"{frequency:.4g} Hz, damping {number_text(float(own['damping_ratio']), '.3g', 1.0)}"
    else:
        what = f"{'grows' if growth > 0.0 else 'fades'} by {abs(growth):.3g} 1/s" if growth else "drifts"
    return f"mode {int(own['mode'])}: {what}"
