"""Files of meshes: STL, binary or text, and OBJ."""

import os
import re
from itertools import pairwise
from pathlib import Path

import numpy as np

from lienumba.errors import BadValueError

FACET = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("more", "<u2")])
HEADER = 80  # bytes of a binary STL before the number of its triangles
SUFFIXES = (".stl", ".obj")
NUMBER = rb"[-+.\w]+"
VERTEX = re.compile(rb"^\s*vertex\s+(%b)\s+(%b)\s+(%b)\s*$" % (NUMBER, NUMBER, NUMBER), re.MULTILINE | re.IGNORECASE)
CONVERT = "save the mesh as STL or OBJ"


def read_mesh(path: str | os.PathLike[str]) -> tuple[np.ndarray, np.ndarray]:
    """The mesh of a file: vertices (n, 3) in its own units, triangles (m, 3) of their indices; a BadValueError for a
    file that is no such mesh."""
    path = Path(path)
    kind = path.suffix.lower()
    if kind not in SUFFIXES:
        raise BadValueError("is neither .stl nor .obj", CONVERT)
    vertices, faces = (_stl if kind == ".stl" else _obj)(path.read_bytes())
    if not len(faces):
        raise BadValueError("has no triangles", "check the file")
    bad = ~np.isfinite(vertices[faces]).all(axis=(1, 2))
    if bad.any():
        raise BadValueError(f"triangle {int(bad.argmax())} has a corner that is no finite number", "correct the file")
    if not np.linalg.norm(_areas(vertices[faces])) > 0.0:
        raise BadValueError("has no triangle with an area", "check the file")
    return vertices, faces


def write_stl(path: str | os.PathLike[str], vertices: np.ndarray, faces: np.ndarray) -> None:
    """Write a mesh as a binary STL.

    Parameters
    ----------
    path : path
        The file, replaced if it exists; its folder is made if there is none.
    vertices : array
        (n, 3) in any unit.
    faces : array
        (m, 3): indices of vertices, counterclockwise from outside.
    """
    corners = np.asarray(vertices, float)[np.asarray(faces)]
    across = _areas(corners)
    facets = np.zeros(len(corners), FACET)
    facets["normal"] = across / np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-300)
    facets["corners"] = corners
    target = Path(path)
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_bytes(b"lienumba".ljust(HEADER) + len(facets).to_bytes(4, "little") + facets.tobytes())


def _areas(corners: np.ndarray) -> np.ndarray:
    """Across triangles (n, 3, 3), twice their areas long."""
    found: np.ndarray = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return found


def _stl(content: bytes) -> tuple[np.ndarray, np.ndarray]:
    count = int.from_bytes(content[HEADER : HEADER + 4], "little")
    size = len(content) - HEADER - 4
    if size >= 0 and size == count * FACET.itemsize:
        corners = np.frombuffer(content, FACET, count, HEADER + 4)["corners"]
    elif re.match(rb"\s*solid\b", content[:HEADER], re.IGNORECASE) and b"facet" in content.lower():
        corners = _ascii(content)
    elif size > 0 and count and abs(size - count * FACET.itemsize) < size:
        rule = f"is cut off or no STL, it has {size:,} bytes where {count:,} triangles take {count * FACET.itemsize:,}"
        raise BadValueError(rule, "save it anew")
    else:
        raise BadValueError("is no STL", CONVERT)
    return corners.reshape(-1, 3).astype(float), np.arange(3 * len(corners)).reshape(-1, 3)


def _ascii(content: bytes) -> np.ndarray:
    try:
        corners = np.array([x for match in VERTEX.finditer(content) for x in match.groups()], dtype="S32").astype(float)
    except ValueError:
        raise BadValueError("has a vertex that is no number", "correct the file") from None
    if len(corners) % 9 or len(corners) != 9 * len(re.findall(rb"\bendfacet\b", content, re.IGNORECASE)):
        raise BadValueError("has facets that are no triangles", "save the mesh as triangles")
    return corners.reshape(-1, 3, 3)


def _obj(content: bytes) -> tuple[np.ndarray, np.ndarray]:
    """Faces of any groups and objects; more than three corners are cut into triangles from the first one."""
    vertices: list[list[float]] = []
    faces: list[tuple[int, int, int]] = []
    lines = content.replace(b"\\\r\n", b" ").replace(b"\\\n", b" ").splitlines()
    for number, line in enumerate(lines, 1):
        key, *words = line.split() or [b""]
        try:
            if key == b"v":
                x, y, z = map(float, words[:3])
                vertices.append([x, y, z])
            elif key == b"f":
                corners = [_place(int(word.partition(b"/")[0]), len(vertices)) for word in words]
                faces += [(corners[0], b, c) for b, c in pairwise(corners[1:])]
        except (ValueError, IndexError):
            shown = line.strip().decode("utf-8", "replace")[:60]
            raise BadValueError(f"line {number}, `{shown}`, is no vertex or face", "correct the file") from None
    if not vertices:
        raise BadValueError("is no OBJ, it has no vertices", CONVERT)
    return np.array(vertices), np.array(faces, np.int64).reshape(-1, 3)


def _place(index: int, count: int) -> int:
    """From 1 on, or from the last one backwards below 0, to a place from 0 on."""
    place = index - 1 if index > 0 else count + index
    if not 0 <= place < count:
        raise IndexError(index)
    return place
