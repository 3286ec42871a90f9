"""Runs of a dataset in motion, as an animation or a still."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

import numpy as np

from lienumba.errors import ScenarioError
from lienumba.figures import canvas
from lienumba.figures.movies import GIF, MP4, ffmpeg, write_gif, write_mp4
from lienumba.figures.picture import Picture
from lienumba.figures.playing import FPS, film
from lienumba.scenario.base.arguments import parse_ranges
from lienumba.store.outputs import Output, whole
from lienumba.store.targets import claimed
from lienumba.words import Written, option

if TYPE_CHECKING:
    from lienumba.scene import Scene

MOVIES = {GIF: write_gif, MP4: write_mp4}
DPI = {GIF: 100.0, MP4: 200.0}
MOST_RUNS = len(canvas.COLORS)
FORMATS = (*MOVIES, *canvas.STILLS)


def runs_of(text: str | None, worst: str | None) -> list[int]:
    """The labels that are asked for, none if they are to be chosen."""
    if text is None:
        return []
    if worst is not None:
        named, chosen = option("run", Written("N")), option("worst", Written("NAME"))
        raise ScenarioError(f"{named} names runs, and {chosen} chooses one; give one of them")
    ranges = parse_ranges(text, option("run", text))
    if sum(map(len, ranges)) > MOST_RUNS:
        raise ScenarioError(f"{option('run', text)}: names more runs than can be told apart; give at most {MOST_RUNS}")
    return list(dict.fromkeys(label for part in ranges for label in part))


def one_run(labels: list[int], worst: str | None) -> int | None:
    """The run whose mode is asked for, if it is named."""
    if worst is not None or len(labels) > 1:
        given = option("worst", worst) if worst is not None else option("run", ",".join(map(str, labels)))
        raise ScenarioError(f"{given}: a mode is that of one run; give one label with {option('run', Written('N'))}")
    return labels[0] if labels else None


@contextmanager
def claimed_film(target: str | os.PathLike[str]) -> Iterator[Output]:
    """Own a film, from before anything is drawn."""
    with claimed(target, "animation or picture", FORMATS) as output:
        if output.path.suffix.lower() == MP4:
            ffmpeg()
        yield output


def animate(
    scene: Scene,
    target: str | os.PathLike[str],
    *,
    title: str = "",
    fps: int = FPS,
    duration: float | None = None,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> None:
    """Write a scene as GIF or MP4, or, as PNG, SVG or PDF, how it ends.

    Parameters
    ----------
    scene : Scene
        What `lienumba.scene.scene` made of a dataset.
    target : path
        The file; its suffix says which kind.
    title : str
        Stands above the picture.
    fps : int
        Frames per second.
    duration : float, optional
        How long it takes to watch, in s; by default the time of the simulation, but between 4 and 8 s.
    progress : callable
        Told how many frames of how many are drawn.
    """
    with claimed_film(target) as output:
        draw(scene, output, title, fps, duration, progress)


def draw(
    scene: Scene,
    output: Output,
    title: str,
    fps: int,
    duration: float | None,
    progress: Callable[[int, int], None],
) -> None:
    """As `animate`, into a file that is owned already."""
    times = film(scene.runs, fps, duration)
    kind = output.path.suffix.lower()
    picture = Picture(scene, times, title, DPI.get(kind, canvas.DPI))
    if kind not in MOVIES:
        canvas.save(picture.figure, output)
        return
    with whole(output) as partial:
        MOVIES[kind](_frames(picture, progress), fps, partial)


def _frames(picture: Picture, progress: Callable[[int, int], None]) -> Iterator[np.ndarray]:
    """Each frame (height, width, 3) as bytes."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    drawn, total = FigureCanvasAgg(picture.figure), len(picture.film.times)
    for frame in range(total):
        picture.show(frame)
        drawn.draw()
        yield np.asarray(drawn.buffer_rgba())[..., :3].copy()
        progress(frame + 1, total)
