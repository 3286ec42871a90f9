"""The quadrilaterals of a mechanism: its bodies, arms from their mass centres to their joints, rods between bodies, and
what stands still. A triangle has its last corner twice.

Round bodies have light and dark quarters, so that their spin is seen.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lienumba.mechanics.elements.joints.base import ROD
from lienumba.mechanics.mechanism.model import GROUND
from lienumba.scene import MovingRun
from lienumba.scene.mechanism import ARM
from lienumba.scene.solids import Face, Solid

THICKNESS = 0.012  # of arms and rods, of the size of the scene
LIGHT = (0.35, -0.45, 0.82)  # where it comes from
DARKEST = 0.5  # of a face that the light does not reach
DARK = 0.75  # of every second quarter of a round body
SQUARE = ((-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5))
PRISM: tuple[Face, ...] = ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))


@dataclass(frozen=True)
class Polyhedron:
    """A polyhedron that moves with a body (its index): vertices (n, 3) in m in the frame of the body; faces (m, 4) of
    their indices; tones: how bright each face is; colours: of each, empty for that of the body."""

    body: int
    vertices: np.ndarray
    faces: np.ndarray
    tones: np.ndarray
    colours: tuple[str, ...]


class Shapes:
    """The quadrilaterals of one run, frame by frame; size: of the scene in m; ground: whether with what stands still.
    body, tone, colour: of each; that of rods is the ground."""

    def __init__(self, run: MovingRun, size: float, ground: bool = True) -> None:
        self.run, self.thickness = run, THICKNESS * size
        solids = [*enumerate(run.mechanism.solids), *([(GROUND, run.mechanism.ground)] if ground else [])]
        self.parts = [_polyhedron(n, solid) for n, solid in solids if solid.faces]
        for segment in run.mechanism.segments:
            first, second = (np.array(place.point, float) for place in segment.ends)
            if segment.kind == ARM and np.linalg.norm(second - first) > self.thickness:
                bar = _prism(first, second, self.thickness)
                self.parts.append(_plain(segment.ends[0].body, bar, PRISM))
        rods = [segment for segment in run.mechanism.segments if segment.kind == ROD]
        self.rods = [(run.at([segment.ends[0]])[:, 0], run.at([segment.ends[1]])[:, 0]) for segment in rods]
        more = len(PRISM) * len(self.rods)
        self.body = [part.body for part in self.parts for _ in part.faces] + [GROUND] * more
        self.tone = np.concatenate([*(part.tones for part in self.parts), np.ones(more)])
        self.colour = [colour for part in self.parts for colour in part.colours] + [""] * more

    def at(self, frame: int) -> np.ndarray:
        """Their corners (n, 4, 3) in a frame in m."""
        found = []
        for part in self.parts:
            placed = part.vertices
            if part.body != GROUND:
                r, R = self.run.positions[frame, part.body], self.run.rotations[frame, part.body]
                placed = placed @ R.T + r
            found.append(placed[part.faces])
        for first, second in self.rods:
            found.append(_prism(first[frame], second[frame], self.thickness)[np.array(PRISM)])
        return np.concatenate(found)


def hiding(run: MovingRun) -> set[int]:
    """The bodies inside which, at the start, most of another one lies, as far as boxes around them tell."""
    found = set()
    for n, solid in enumerate(run.mechanism.solids):
        if solid.kind not in ("box", "cylinder"):
            continue  # one knows how it looks
        low, high = solid.vertices.min(axis=0), solid.vertices.max(axis=0)
        for other, inner in enumerate(run.mechanism.solids):
            place = inner.vertices @ run.rotations[0, other].T + run.positions[0, other] - run.positions[0, n]
            own = place @ run.rotations[0, n]
            if other != n and inner.faces and np.mean(((low < own) & (own < high)).all(axis=1)) > 0.5:
                found.add(n)
    return found


def normals(corners: np.ndarray) -> np.ndarray:
    """The outward unit normals (n, 3) of quadrilaterals (n, 4, 3)."""
    across = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    found: np.ndarray = across / np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-300)
    return found


def shades(normals: np.ndarray) -> np.ndarray:
    """How much light falls on what has these normals (n, 3), from DARKEST to 1."""
    found: np.ndarray = DARKEST + (1.0 - DARKEST) * np.clip(normals @ np.array(LIGHT), 0.0, 1.0)
    return found


def clipped(corners: np.ndarray, low: np.ndarray, high: np.ndarray) -> list[np.ndarray]:
    """The parts of plane polygons (n, 4, 3) in a box, one for each, without corners where nothing is left."""
    found = list(corners)
    for n in np.flatnonzero(((corners < low) | (corners > high)).any(axis=(1, 2))):
        for axis in range(3):
            found[n] = _half(found[n], high[axis] - found[n][:, axis])
            found[n] = _half(found[n], found[n][:, axis] - low[axis])
    return found


def _half(polygon: np.ndarray, inside: np.ndarray) -> np.ndarray:
    """The part of a polygon where a linear function, of which these are the values at its corners, is not negative."""
    kept = []
    for n, (here, value) in enumerate(zip(polygon, inside, strict=True)):
        before, last = polygon[n - 1], inside[n - 1]
        if (value < 0.0) != (last < 0.0):
            kept.append(before + last / (last - value) * (here - before))
        if value >= 0.0:
            kept.append(here)
    return np.reshape(kept, (-1, 3))


def _polyhedron(body: int, solid: Solid) -> Polyhedron:
    """A body; the ends of a cylinder cut from their centres."""
    if solid.kind != "cylinder":
        return _plain(body, solid.vertices, solid.faces, solid.colours)
    *sides, bottom, top = solid.faces
    count, vertices = len(sides), [solid.vertices]
    faces, tones = list(sides), [_tone(k, count) for k in range(count)]
    for n, end in enumerate((bottom, top)):
        vertices.append(solid.vertices[list(end)].mean(axis=0, keepdims=True))
        for k in range(0, count, 2):
            ring = [end[j % count] for j in range(k, k + 3)]
            faces.append((len(solid.vertices) + n, *ring))
            tones.append(_tone(ring[1] % count, count))
    return Polyhedron(body, np.concatenate(vertices), np.array(faces), np.array(tones), ("",) * len(faces))


def _plain(body: int, vertices: np.ndarray, faces: tuple[Face, ...], colours: tuple[str, ...] = ()) -> Polyhedron:
    """What has faces of one tone, of three or four corners."""
    corners = np.array([(*face, face[-1])[:4] for face in faces])
    return Polyhedron(body, vertices, corners, np.ones(len(faces)), colours or ("",) * len(faces))


def _tone(vertex: int, count: int) -> float:
    """That of the quarter of a circle of so many vertices."""
    return DARK if 4 * vertex // count % 2 else 1.0


def _prism(first: np.ndarray, second: np.ndarray, thickness: float) -> np.ndarray:
    """The vertices (8, 3) of a square bar between two points (m)."""
    along = second - first
    across = np.cross(along, np.eye(3)[abs(along).argmin()])
    across /= max(float(np.linalg.norm(across)), 1e-300)
    other = np.cross(along, across)
    other /= max(float(np.linalg.norm(other)), 1e-300)
    return np.array([end + thickness * (a * across + b * other) for end in (first, second) for a, b in SQUARE])
