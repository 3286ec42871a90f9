"""Runs that diverge, as far as a drawing of the others can show them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from lienumba.errors import ScenarioError
from lienumba.scene import MovingRun, Scene, box
from lienumba.scene.scene import framed
from lienumba.words import listed

FAR = 1e3  # sizes of the mechanism from where it started


def within(found: Scene) -> Scene:
    """The scene with each run up to where one of its bodies is FAR away, and a remark on those that are cut."""
    starts = [box([replace(run, positions=run.positions[:1])]) for run in found.runs]
    low, high = np.median(starts, axis=0)
    middle, most = 0.5 * (low + high), FAR * float((high - low).max())
    kept = [_near(run, middle, most) for run in found.runs]
    cut = [str(one.run) for run, one in zip(found.runs, kept, strict=True) if len(one.times) < len(run.times)]
    if not cut:
        return found
    left = [run for run in kept if len(run.times)]
    if not left:
        raise ScenarioError("the bodies of no run start where a drawing could hold them")
    which = f"run {cut[0]} is" if len(cut) == 1 else f"runs {listed(cut)} are"
    remark = f"{which} shown up to where a body is {FAR:,.0f} times the size of the mechanism away from the start"
    return framed(left, [*found.remarks, remark], found.cycles)


def _near(run: MovingRun, middle: np.ndarray, most: float) -> MovingRun:
    """The run before a body is farther than `most` (m) along an axis from the middle, or its attitude unknown."""
    near = (abs(run.positions - middle).max(axis=(1, 2)) <= most) & np.isfinite(run.rotations).all(axis=(1, 2, 3))
    count = len(near) if near.all() else int(near.argmin())
    return replace(run, times=run.times[:count], positions=run.positions[:count], rotations=run.rotations[:count])
