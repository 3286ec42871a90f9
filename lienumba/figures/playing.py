"""When each frame of an animation is, and where the bodies are then."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from lienumba.errors import ScenarioError
from lienumba.groups import so3
from lienumba.scene import MovingRun
from lienumba.words import Written, option

SHORTEST, LONGEST = 4.0, 8.0  # s, unless a duration is asked for
MOST_FRAMES = 3000
FPS, MOST_FPS = 20, 50  # what a GIF can do in hundredths of a second


@dataclass(frozen=True)
class Film:
    """times (frames,) in s of the simulation; speed: how much faster than these it is shown."""

    times: np.ndarray
    fps: int
    speed: float


def film(runs: Sequence[MovingRun], fps: int, duration: float | None) -> Film:
    """Frames from the start to the end of the longest run, in real time where that takes not too long."""
    end = max(float(run.times[-1]) for run in runs)
    seconds = min(max(end, SHORTEST), LONGEST) if duration is None else duration
    if not 1 <= fps <= MOST_FPS:
        raise ScenarioError(
            f"{option('fps', fps)}: is not between 1 and {MOST_FPS} frames per second; give a number such as {FPS}"
        )
    if not 1.0 <= seconds * fps < MOST_FRAMES:
        given = option("duration", Written(f"{seconds:g}"))
        raise ScenarioError(
            f"{given}: is not between {1 / fps:g} and {MOST_FRAMES / fps:g} s, which is what "
            f"{MOST_FRAMES:,} frames at {fps} per second take; give a number such as {LONGEST:g}"
        )
    frames = round(seconds * fps) + 1
    return Film(np.linspace(0.0, end, frames), fps, end / seconds)


def played(run: MovingRun, times: np.ndarray) -> MovingRun:
    """The run at these times (s): between those that it has, positions on straight lines and rotations about one axis;
    after its end it stays where it is."""
    if len(run.times) == 1:
        return replace(
            run, times=times, positions=run.positions[[0] * len(times)], rotations=run.rotations[[0] * len(times)]
        )
    before = np.clip(np.searchsorted(run.times, times, side="right") - 1, 0, len(run.times) - 2)
    share = (times - run.times[before]) / (run.times[before + 1] - run.times[before])
    share = np.clip(share, 0.0, 1.0)[:, None]
    r, R, R_next = run.positions[before], run.rotations[before], run.rotations[before + 1]
    turn = so3.log(_elements(np.swapaxes(R, -1, -2) @ R_next))
    part = np.stack(so3.exp(tuple(share * u for u in turn)), axis=-1).reshape(R.shape)
    return replace(
        run,
        times=times,
        positions=r + share[..., None] * (run.positions[before + 1] - r),
        rotations=R @ part,
    )


def _elements(R: np.ndarray) -> tuple[np.ndarray, ...]:
    """The nine elements of rotations (..., 3, 3)."""
    return tuple(R[..., i, j] for i in range(3) for j in range(3))
