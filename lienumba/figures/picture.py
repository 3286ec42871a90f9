"""A mechanism in three dimensions: bodies, joints and the paths of mass centres at one time of one or more runs."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from math import ceil, cos, log10, radians, sin
from typing import Any

import numpy as np

from lienumba.figures.canvas import COLORS, empty, lines
from lienumba.figures.playing import Film, played
from lienumba.figures.shapes import Shapes, clipped, hiding, normals, shades
from lienumba.mechanics.elements.joints.base import AXIS
from lienumba.mechanics.mechanism.model import GROUND
from lienumba.scene import MovingRun, Scene
from lienumba.scene.scene import window
from lienumba.scene.solids import SHAPES
from lienumba.scene.switching import CLOSED, LOCKED, LOOKS, OPEN, STICKING

WIDTH, HEIGHT = 6.4, 4.8  # inches
THIN = 0.3  # of the longest edge: a scene that is thinner is looked at across this edge
TALL = 1.3  # height by width, from which the labels of heights would come to lie on the box
SHORTEST_EDGE = 0.15  # of the longest edge
ROD = "#555555"
LIGHTER = 0.7  # how far from white shapes are, of the colour of their body
BESIDE, HIDING = 0.45, 0.3  # opacity of the runs beside the first, and of bodies with others inside
FILLED = (0.72, 0.72)  # of the width and the height of the figure
MOST_NAMED = 7  # in a legend
PATH, SOLID, JOINT = 1, 2, 3  # what lies in the drawing above what
MARKS: dict[bool, dict[str, Any]] = {  # of joints on bodies, and on the ground
    False: {"ls": "", "marker": "o", "ms": 3.5, "mfc": "white", "mec": "black", "mew": 0.8},
    True: {"ls": "", "marker": "s", "ms": 5.0, "mfc": "black", "mec": "black"},
}
CHANGING: dict[int, dict[str, Any]] = {  # of what is locked, open or closed, over these
    LOCKED: {"ls": "", "marker": "s", "ms": 7.0, "mfc": "#c1272d", "mec": "white", "mew": 0.8},
    OPEN: {"ls": "", "marker": "o", "ms": 8.0, "mfc": "none", "mec": "#c1272d", "mew": 1.6},
    CLOSED: {"ls": "", "marker": "^", "ms": 7.0, "mfc": "#117733", "mec": "white", "mew": 0.8},
    STICKING: {"ls": "", "marker": "D", "ms": 6.0, "mfc": "#88419d", "mec": "white", "mew": 0.8},
}
HIT: dict[str, Any] = {"ls": "", "marker": "*", "ms": 17.0, "mfc": "#ffb000", "mec": "black", "mew": 0.6}
FLASH = 0.3  # s that an impact is seen


class Picture:
    """The figure of a scene, at the times of a film; `show` turns to one of its frames."""

    def __init__(self, scene: Scene, film: Film, title: str = "", dpi: float = 100.0) -> None:
        self.film, self.scene = film, scene
        self.runs = [played(run, film.times) for run in scene.runs]
        self.low, self.high = _room(scene, self.runs)
        self.edges = self.high[0] - self.low[0]
        self.figure = empty(WIDTH, HEIGHT, layout=None, dpi=dpi)
        self.axes: Any = self.figure.add_axes(
            (-0.03, 0.0, 1.0, 0.93), projection="3d", computed_zorder=False, proj_type="ortho"
        )
        self._furnish(title)
        self.hiding = [hiding(run) for run in self.runs]
        self.shapes = [Shapes(run, float(self.edges.max()), n == 0) for n, run in enumerate(self.runs)]
        self._draw()
        self._name()
        self.show(len(film.times) - 1)

    def show(self, frame: int) -> None:
        """Turn to a frame."""
        time = self.film.times[frame]
        for name, low, high in zip("xyz", self.low[frame], self.high[frame], strict=True):
            getattr(self.axes, f"set_{name}lim")(low, high)
        corners = np.concatenate([shape.at(frame) for shape in self.shapes])
        outward = normals(corners)
        seen = outward @ self.towards > 0.0
        if self.scene.followed:
            parts = clipped(corners, self.low[frame], self.high[frame])
            seen &= [len(part) > 0 for part in parts]
            self.solids.set_verts([part for part, shown in zip(parts, seen, strict=True) if shown])
        else:
            self.solids.set_verts(corners[seen])
        colors = np.hstack([self.colors[seen] * shades(outward[seen])[:, None], self.opacity[seen]])
        self.solids.set_facecolor(colors)
        self.solids.set_edgecolor(colors)
        for run, source, paths in zip(self.runs, self.scene.runs, self.paths, strict=True):
            passed = int(source.times.searchsorted(time, side="right"))
            for body, path in paths.items():
                points = np.vstack([source.positions[:passed, body], run.positions[frame, body]])
                path.set_data_3d(*self._in_view(points, frame).T)
        self.lines.set_segments([self._in_view(ends[frame], frame) for ends in self.segments])
        for artist, points in self.marks:
            artist.set_data_3d(*self._in_view(points[frame], frame).T)
        speed = f"  ({self.film.speed:.3g} × real time)" if abs(self.film.speed - 1.0) > 1e-3 else ""
        hits = "".join(f"  {name}: impact" for name in self.hits[frame])
        self.clock.set_text(f"t = {time:.{_digits(self.film)}f} s{speed}{hits}")

    def _in_view(self, points: np.ndarray, frame: int) -> np.ndarray:
        """Points (n, 3), those outside a view that travels NaN."""
        if not self.scene.followed:
            return points
        outside = ((points < self.low[frame]) | (points > self.high[frame])).any(axis=-1)
        return np.where(outside[:, None], np.nan, points)

    def _furnish(self, title: str) -> None:
        """Axes in true proportions, and words."""
        from matplotlib.ticker import MaxNLocator

        edges, middle = self.edges, 0.5 * (self.low[0] + self.high[0])
        for n, name in enumerate("xyz"):
            getattr(self.axes, f"set_{name}lim")(self.low[0, n], self.high[0, n])
            getattr(self.axes, f"set_{name}label")(f"{name} (m)", fontsize="small")
            axis = getattr(self.axes, f"{name}axis")
            if edges[n] > THIN * edges.max():
                axis.set_major_locator(MaxNLocator(nbins=max(2, round(5 * edges[n] / edges.max()))))
            else:
                axis.set_ticks([middle[n]], [f"{middle[n] + 0.0:.2g}"])
            axis.set_pane_color((0.97, 0.97, 0.97, 1.0))
            axis._axinfo["grid"].update(color="0.88", linewidth=0.6)
        self.axes.tick_params(labelsize="x-small", pad=3)
        if edges[2] > TALL * edges[:2].max():
            self.axes.tick_params(axis="z", pad=10)
            self.axes.zaxis.labelpad = 14
        elevation, azimuth = _view(edges)
        self.axes.view_init(elevation, azimuth)
        up, turn = radians(elevation), radians(azimuth)
        self.towards = (cos(up) * cos(turn), cos(up) * sin(turn), sin(up))
        self._fill(edges)
        self.figure.text(0.5, 0.985, lines(title, WIDTH), ha="center", va="top", fontsize="medium")
        self.clock = self.figure.text(0.02, 0.02, "", ha="left", va="bottom", fontsize="small")

    def _fill(self, edges: np.ndarray) -> None:
        """Make the box as large as its corners and their labels allow."""
        from mpl_toolkits.mplot3d.proj3d import proj_transform

        self.axes.set_box_aspect(edges, zoom=1.0)
        self.axes.apply_aspect()
        corners = np.array([[x, y, z] for x, y, z in product(*zip(self.low[0], self.high[0], strict=True))])
        x, y, _ = proj_transform(*corners.T, self.axes.get_proj())
        seen = self.figure.transFigure.inverted().transform(self.axes.transData.transform(np.column_stack([x, y])))
        self.axes.set_box_aspect(edges, zoom=float(min(FILLED / np.ptp(seen, axis=0))))

    def _draw(self) -> None:
        """All that moves; where it is, `show` says."""
        from mpl_toolkits.mplot3d.art3d import Line3DCollection, Poly3DCollection

        self.solids = Poly3DCollection([], zorder=SOLID, linewidths=0.2)
        self.lines = Line3DCollection([], zorder=JOINT, linewidths=1.0, colors="0.1")
        for collection in (self.solids, self.lines):
            self.axes.add_collection3d(collection, autolim=False)
        colors = [
            self._face_color(n, body, colour)
            for n, shape in enumerate(self.shapes)
            for body, colour in zip(shape.body, shape.colour, strict=True)
        ]
        self.colors = np.array(colors) * np.concatenate([shape.tone for shape in self.shapes])[:, None]
        self.opacity = np.array(
            [[self._opacity(n, body)] for n, shape in enumerate(self.shapes) for body in shape.body]
        )
        self.paths = [
            {k: self._points(PATH, color=self._color(n, k), lw=0.9, alpha=0.8) for k in run.mechanism.seen}
            for n, run in enumerate(self.runs)
        ]
        self.segments = [run.at(x.ends) for run in self.runs for x in run.mechanism.segments if x.kind == AXIS]
        self.marks = [(self._points(JOINT, **style), self._places(ground)) for ground, style in MARKS.items()]
        self.changing: dict[str, dict[str, Any]] = {}  # the looks that occur, for the legend
        self.hits: list[list[str]] = [[] for _ in self.film.times]
        for run in self.runs:
            self._change(run)

    def _change(self, run: MovingRun) -> None:
        """Marks of what is locked, open or closed in a run, and of what is hit."""
        if run.switching is None or not run.switching.names:
            return
        places, times = run.at(run.switching.places), self.film.times
        looks, hit = run.switching.at(times), run.switching.hit(times, FLASH * self.film.speed)
        shown = [(LOOKS[look], style, looks == look) for look, style in CHANGING.items()] + [("impact", HIT, hit)]
        for name, style, here in shown:
            if here.any():
                self.changing[name] = style
                self.marks.append((self._points(JOINT, **style), np.where(here[..., None], places, np.nan)))
        for told, which in zip(self.hits, hit, strict=True):
            told += [name for name in np.array(run.switching.names)[which] if name not in told]

    def _points(self, zorder: int, **style: object) -> Any:
        """A line or points in space."""
        return self.axes.plot([], [], [], zorder=zorder, **style)[0]

    def _places(self, ground: bool) -> np.ndarray:
        """Where joints are on the ground, or on bodies (frames, n, 3)."""
        marks = [[x.place for x in run.mechanism.marks if (x.place.body == GROUND) == ground] for run in self.runs]
        return np.concatenate([run.at(places) for run, places in zip(self.runs, marks, strict=True)], axis=1)

    def _face_color(self, run: int, body: int, own: str) -> tuple[float, ...]:
        """Shapes have a colour of their own, or a lighter one, on which shadows tell more; of several runs each has
        its colour."""
        from matplotlib.colors import to_rgb

        if own and (body == GROUND or len(self.runs) == 1):
            return to_rgb(own)
        color = self._color(run, body)
        if body == GROUND or self.runs[run].mechanism.solids[body].kind != SHAPES:
            return color
        return tuple(1.0 - LIGHTER * (1.0 - part) for part in color)

    def _color(self, run: int, body: int) -> tuple[float, ...]:
        """Of one run each body has a colour, of several each run."""
        from matplotlib.colors import to_rgb

        number = run if len(self.runs) > 1 else body
        return to_rgb(ROD if number == GROUND else COLORS[number % len(COLORS)])

    def _opacity(self, run: int, body: int) -> float:
        """Less of the runs beside the first, and of bodies with others inside."""
        return (BESIDE if run else 1.0) * (HIDING if body in self.hiding[run] else 1.0)

    def _name(self) -> None:
        """A legend of the runs, or of the bodies; and one of what changes."""
        from matplotlib.lines import Line2D
        from matplotlib.patches import Patch

        named = {run.label: self._color(n, 0) for n, run in enumerate(self.runs)}
        if len(self.runs) == 1:
            mechanism = self.runs[0].mechanism
            named = {mechanism.bodies[n]: self._color(0, n) for n in mechanism.seen}
        if 1 < len(named) <= MOST_NAMED:
            patches = [Patch(color=color, label=label) for label, color in named.items()]
            self.figure.legend(
                handles=patches, loc="upper left", bbox_to_anchor=(0.0, 0.95), frameon=False, fontsize="small"
            )
        if self.changing:
            marks = [Line2D([], [], label=label, **style | {"ms": 7.0}) for label, style in self.changing.items()]
            self.figure.legend(
                handles=marks, loc="upper right", bbox_to_anchor=(1.0, 0.95), frameon=False, fontsize="small"
            )


def _room(scene: Scene, runs: Sequence[MovingRun]) -> tuple[np.ndarray, np.ndarray]:
    """Opposite corners (frames, 3) of the view: those of a cube that travels with the runs, or of the box in which they
    move, in no direction so thin that nothing could be read."""
    if scene.followed:
        middle, half = window(runs)
        return middle - half, middle + half
    edges = scene.high - scene.low
    missing = np.maximum(SHORTEST_EDGE * edges.max() - edges, 0.0)
    ends = scene.low - 0.5 * missing, scene.high + 0.5 * missing
    frames = len(runs[0].times)
    return np.tile(ends[0], (frames, 1)), np.tile(ends[1], (frames, 1))


def _view(edges: np.ndarray) -> tuple[float, float]:
    """Elevation and azimuth (degrees) of the viewer: across the thinnest edge, if one is thin."""
    thinnest = int(edges.argmin())
    if edges[thinnest] > THIN * edges.max():
        return 22.0, -60.0
    return ((15.0, -20.0), (15.0, -75.0), (50.0, -70.0))[thinnest]


def _digits(film: Film) -> int:
    """Of a time, so that frames differ."""
    return max(0, ceil(-log10(max(film.times[1], 1e-9))))
