"""Meshes as text: corners of 16 bits within their box, triangles as differences of indices, deflated, in base64."""

import struct
import zlib
from base64 import b64decode, b64encode
from binascii import Error
from typing import Any

import numpy as np

from lienumba.errors import BadValueError

MOST = 20_000  # triangles of a mesh
STEPS = 2**16 - 1  # along each edge of the box
HEAD = struct.Struct("<II6d")  # how many vertices and triangles, and two corners of the box
LARGEST = HEAD.size + 30 * MOST  # bytes of one in which every triangle has its own corners


def packed_mesh(vertices: np.ndarray, faces: np.ndarray) -> dict[str, Any]:
    """A mesh as a shape of a body: each vertex once, without triangles that have no area.

    Parameters
    ----------
    vertices : array
        (n, 3) in m, in the frame of the shape.
    faces : array
        (m, 3): indices of vertices, counterclockwise from outside; at most 20,000 triangles.

    Returns
    -------
    dict
        {"type": "mesh", "data": text}, to which position, rotation, scale, colour and the name of a file may be added.
    """
    vertices, faces = merged(np.asarray(vertices, float), np.asarray(faces, np.int64))
    if len(faces) > MOST:
        rule = f"has {len(faces):,} triangles, of which a shape takes {MOST:,} at most"
        raise BadValueError(rule, "save it with fewer, as by MeshLab or Blender")
    return {"type": "mesh", "data": packed(vertices, faces)}


def merged(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the mesh with each vertex once, without triangles that have no area or are there twice."""
    low, extent = vertices.min(axis=0), max(float(np.ptp(vertices, axis=0).max()), 1e-300)
    places = np.rint((vertices - low) * (2.0**20 / extent)).astype(np.int64)
    _, first, place = np.unique(places @ np.array([1 << 42, 1 << 21, 1]), return_index=True, return_inverse=True)
    corners = place[faces]
    a, b, c = corners.T
    corners = corners[(a != b) & (b != c) & (c != a)]
    _, kept = np.unique(np.sort(corners, axis=1), axis=0, return_index=True)
    used, place = np.unique(corners[np.sort(kept)], return_inverse=True)
    return vertices[first][used], place.reshape(-1, 3)


def packed(vertices: np.ndarray, faces: np.ndarray) -> str:
    """The text of a mesh with vertices (n, 3) and triangles (m, 3); the same mesh, the same text."""
    vertices, faces = _ordered(np.asarray(vertices, float), np.asarray(faces, np.int64))
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    steps = np.rint((vertices - low) / np.where(high > low, high - low, 1.0) * STEPS).astype("<u2")
    places = np.diff(faces.ravel(), prepend=0).astype("<i4")
    columns = [np.ascontiguousarray(x).tobytes() for x in (*_bytes(steps.T.ravel(), 2), *_bytes(places, 4))]
    head = HEAD.pack(len(vertices), len(faces), *low, *high)
    return b64encode(zlib.compress(head + b"".join(columns), 9)).decode()


def unpacked(text: str) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (n, 3) and triangles (m, 3) of a text; a BadValueError for one that is no such mesh."""
    try:
        stream = zlib.decompressobj()
        content = stream.decompress(b64decode(text, validate=True), LARGEST)
        if not stream.eof:
            raise ValueError
        n, m, *box = HEAD.unpack_from(content)
        if len(content) != HEAD.size + 6 * n + 12 * m:
            raise ValueError
        columns = np.frombuffer(content, np.uint8, offset=HEAD.size)
        steps = np.ascontiguousarray(columns[: 6 * n].reshape(2, -1).T).view("<u2").reshape(3, n).T
        places = np.ascontiguousarray(columns[6 * n :].reshape(4, -1).T).view("<i4").ravel()
        faces = np.cumsum(places, dtype=np.int64).reshape(m, 3)
        low, high = np.array(box[:3]), np.array(box[3:])
        if not np.isfinite(box).all() or not m or faces.min() < 0 or faces.max() >= n:
            raise ValueError
    except (ValueError, Error, zlib.error, struct.error):
        raise BadValueError("is no packed mesh", "give the file of a mesh instead") from None
    return low + steps * ((high - low) / STEPS), faces


def _bytes(values: np.ndarray, size: int) -> np.ndarray:
    """The first bytes of all numbers, then the second ones, and so on: alike ones side by side."""
    return np.ascontiguousarray(values).view(np.uint8).reshape(-1, size).T


def _ordered(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The same mesh with its vertices in the order in which triangles need them, and neighbours side by side."""
    middles = vertices[faces].mean(axis=1)
    along = middles[:, int(np.ptp(vertices, axis=0).argmax())]
    faces = faces[np.argsort(along, kind="stable")]
    used, first, place = np.unique(faces.ravel(), return_index=True, return_inverse=True)
    order = np.argsort(first)
    rank = np.empty(len(order), np.int64)
    rank[order] = np.arange(len(order))
    return vertices[used[order]], rank[place].reshape(-1, 3)
