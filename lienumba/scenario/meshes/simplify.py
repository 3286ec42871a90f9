"""Meshes of fewer triangles, by quadrics (Garland and Heckbert, 1997), as fast-simplification collapses their edges."""

import numpy as np

from lienumba.errors import ScenarioError

FINE, LOOSE = 10, 2  # times as many triangles as are wanted: what has more is merged in a grid first; with many borders
FEW = 10_000  # triangles that need no grid, if they have few borders
CELLS = 64  # along the longest edge of the box, of the first grid in which vertices are merged
COARSER = 0.7  # is each grid than the one before


def simplified(vertices: np.ndarray, faces: np.ndarray, most: int) -> tuple[np.ndarray, np.ndarray]:
    """A mesh of at most so many triangles; vertices (n, 3), faces (m, 3) of indices, both of the result as well.

    Vertices at the same place become one, triangles without area go. Edges of borders do not collapse: where a mesh of
    many pieces has too many of them, its vertices are merged in cells of a grid, as coarse as need be.
    """
    whole = merged(np.asarray(vertices, float), np.asarray(faces, np.int64))
    enough = max(FINE * most, FEW) if _borders(whole[1]) < most // 2 else LOOSE * most
    cells, found = CELLS / COARSER, whole
    while len(found[1]) > enough:
        cells *= COARSER
        found = _clustered(*whole, cells)
    found = _collapsed(*found, most)
    while len(found[1]) > most:
        cells *= COARSER
        found = _collapsed(*_clustered(*whole, cells), most)
    return found


def _borders(faces: np.ndarray) -> int:
    """How many edges do not lie between two triangles."""
    ends = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    counts = np.unique(ends[:, 0] * (faces.max(initial=0) + 1) + ends[:, 1], return_counts=True)[1]
    return int((counts != 2).sum())


def _collapsed(vertices: np.ndarray, faces: np.ndarray, most: int) -> tuple[np.ndarray, np.ndarray]:
    if len(faces) <= most:
        return vertices, faces
    try:
        import fast_simplification
    except ImportError:
        rule = f"a mesh of {len(faces):,} triangles is simplified to {most:,} by fast-simplification, which is missing"
        raise ScenarioError(f'{rule}; pip install "lienumba[shapes]"') from None
    points, triangles = vertices.astype(np.float32), faces.astype(np.int32)
    points, triangles = fast_simplification.simplify(points, triangles, target_count=most)
    return merged(np.asarray(points, float), np.asarray(triangles, np.int64))


def _clustered(vertices: np.ndarray, faces: np.ndarray, cells: float) -> tuple[np.ndarray, np.ndarray]:
    """The same mesh, all vertices in a cell of the grid being one, in their middle."""
    low, extent = vertices.min(axis=0), max(float(np.ptp(vertices, axis=0).max()), 1e-300)
    keys = np.floor((vertices - low) * (cells / extent)).astype(np.int64) @ np.array([1 << 42, 1 << 21, 1])
    place = np.unique(keys, return_inverse=True)[1].ravel()
    counts = np.bincount(place)[:, None]
    middles = np.column_stack([np.bincount(place, x) for x in vertices.T]) / counts
    return _compact(middles, place[faces])


def merged(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The same mesh, each vertex once, without triangles that have no area."""
    low, extent = vertices.min(axis=0), max(float(np.ptp(vertices, axis=0).max()), 1e-300)
    keys = np.rint((vertices - low) * (2.0**20 / extent)).astype(np.int64)
    _, first, place = np.unique(keys @ np.array([1 << 42, 1 << 21, 1]), return_index=True, return_inverse=True)
    return _compact(vertices[first], place[faces])


def _compact(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Without triangles that have two corners in one, without those that are there twice, without lone vertices."""
    a, b, c = faces.T
    faces = faces[(a != b) & (b != c) & (c != a)]
    _, first = np.unique(_keys(np.sort(faces, axis=1), len(vertices)), return_index=True)
    faces = faces[np.sort(first)]
    used, place = np.unique(faces, return_inverse=True)
    return vertices[used], place.reshape(-1, 3)


def _keys(rows: np.ndarray, count: int) -> np.ndarray:
    """One number for each row of indices below count."""
    key = np.zeros(len(rows), np.int64)
    for column in rows.T:
        key = key * count + column
    return key
