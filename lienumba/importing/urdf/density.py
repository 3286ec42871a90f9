"""Masses and moments of inertia of links that have none, from their collision shapes and a density."""

from dataclasses import replace
from math import pi
from pathlib import Path

import numpy as np

from lienumba.errors import BadValueError
from lienumba.importing.notes import Note
from lienumba.importing.urdf.mesh_files import find
from lienumba.importing.urdf.robot import Array, Inertial, Link, Pose, Robot, Shape
from lienumba.scenario.meshes.files import read_mesh


def with_density(robot: Robot, file: Path, density: float, notes: list[Note]) -> Robot:
    """The robot whose links without <inertial> have those of their collision shapes.

    Parameters
    ----------
    robot : Robot
        As the file has it.
    file : Path
        Its file, from which the files of meshes are found.
    density : float
        In kg/m³.
    notes : list of Note
        What is noted is added.

    Returns
    -------
    Robot
        Shapes of a link that overlap count twice; a mesh counts as its convex hull.
    """
    links = {name: _filled(link, robot, file, density, notes) for name, link in robot.links.items()}
    return replace(robot, links=links)


def _filled(link: Link, robot: Robot, file: Path, density: float, notes: list[Note]) -> Link:
    if link.inertial is not None:
        return link
    solids = [x for shape in link.shapes if not shape.drawn and (x := _solid(shape, robot, file)) is not None]
    if not solids:
        return link
    volume = sum(v for v, _, _ in solids)
    centre = np.asarray(sum(v * c for v, c, _ in solids) / volume)
    tensor = sum((_about(v, c - centre) + J for v, c, J in solids), np.zeros((3, 3)))
    what = f"mass and inertia of its collision shapes at {density:g} kg/m³, as it has none"
    notes.append(Note(what, (f'link "{link.name}"',), lost=False))
    return replace(link, inertial=Inertial(density * volume, density * tensor, Pose(centre)))


def _solid(shape: Shape, robot: Robot, file: Path) -> tuple[float, Array, Array] | None:
    """Volume, centre and second moments about that (as of a density of 1), in the frame of the link."""
    found = _hull(shape, robot, file) if shape.kind == "mesh" else _plain(shape)
    if found is None or not found[0] > 0.0:
        return None
    volume, centre, tensor = found
    R = shape.pose.rotation
    return volume, shape.pose.at + R @ centre, R @ tensor @ R.T


def _plain(shape: Shape) -> tuple[float, Array, Array] | None:
    """A box, sphere, cylinder or capsule in its own frame."""
    if not all(x > 0 for x in shape.size):
        return None
    if shape.kind == "box":
        volume, squares = 8.0 * float(np.prod(shape.size)), np.square(shape.size) / 3.0
    elif shape.kind == "sphere":
        (r,) = shape.size
        volume, squares = 4.0 / 3.0 * pi * r**3, np.full(3, r**2 / 5.0)
    else:  # a cylinder, and of a capsule two half spheres at its ends
        r, h = shape.size
        middle, ends = 2.0 * pi * r**2 * h, 4.0 / 3.0 * pi * r**3 if shape.kind == "capsule" else 0.0
        along = middle * h**2 / 3.0 + ends * (h**2 + 0.75 * h * r + r**2 / 5.0)
        across = middle * r**2 / 4.0 + ends * r**2 / 5.0
        volume = middle + ends
        squares = np.array([across, across, along]) / volume
    return volume, np.zeros(3), volume * (squares.sum() * np.eye(3) - np.diag(squares))


def _hull(shape: Shape, robot: Robot, file: Path) -> tuple[float, Array, Array] | None:
    """The convex hull of a mesh, as tetrahedra from a point inside; None where it cannot be read or has no volume."""
    from scipy.spatial import ConvexHull, QhullError

    path = find(shape.file, file, robot.mesh_folder)
    if path is None:
        return None
    try:
        vertices, faces = read_mesh(path)
        points = vertices[np.unique(faces)] * np.array(shape.scale)
        hull = ConvexHull(points)
    except (BadValueError, OSError, QhullError):
        return None
    inside = points[hull.vertices].mean(axis=0)
    corners = points[hull.simplices] - inside  # (n, 3, 3)
    volumes = np.abs(np.linalg.det(corners)) / 6.0
    volume = float(volumes.sum())
    sums = corners.sum(axis=1)
    centre = volumes @ sums / (4.0 * volume)
    # of a tetrahedron with a corner at 0: V/20 (sum of a a^T over corners + s s^T), s their sum
    products = np.einsum("n,nki,nkj->ij", volumes, corners, corners) + np.einsum("n,ni,nj->ij", volumes, sums, sums)
    second = products / 20.0 - volume * np.outer(centre, centre)
    return volume, inside + centre, np.trace(second) * np.eye(3) - second


def _about(mass: float, d: Array) -> Array:
    """What a mass at a distance adds to a tensor of inertia."""
    return np.asarray(mass * (d @ d * np.eye(3) - np.outer(d, d)))
