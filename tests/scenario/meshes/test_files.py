"""STL and OBJ: what is written is read, in all dialects; what is wrong is said in one sentence."""

import re

import numpy as np
import pytest

from lienumba.errors import BadValueError
from lienumba.scenario.meshes import surfaces
from lienumba.scenario.meshes.files import FACET, read_mesh, write_stl

BALL = surfaces.ellipsoid([0.5, 1.0, 2.0])
CORNERS = BALL[0][BALL[1]]
ASCII = "solid ball of steel\n" + "".join(
    "facet normal 0 0 0\n outer loop\n" + "".join(f"  vertex {x:.9g} {y:.9g} {z:.9g}\n" for x, y, z in corners)
    + " endloop\nendfacet\n" for corners in CORNERS
) + "endsolid\n"  # fmt: skip
OBJ = """# a pyramid of a square and, in another group, two triangles; one counts from behind
o pyramid
v 0 0 0
v 1 0 0 1.0
v 1 1 0
v 0 1 0
vn 0 0 1
vt 0.5 0.5
f 4//1 3//1 2//1 1//1
g roof
usemtl red
v 0.5 0.5 1
f 1/1 2/1/1 5
f -4 -3 \\
  -1
"""


def test_binary_stl(tmp_path):
    write_stl(tmp_path / "deep" / "a.stl", *BALL)
    vertices, faces = read_mesh(tmp_path / "deep" / "a.stl")
    assert vertices[faces] == pytest.approx(CORNERS, abs=1e-6)
    facets = np.frombuffer((tmp_path / "deep" / "a.stl").read_bytes()[84:], FACET)
    assert ((facets["normal"] * facets["corners"].mean(axis=1)).sum(axis=1) > 0).all()  # outwards


def test_a_binary_stl_may_begin_as_text_does(tmp_path):
    write_stl(tmp_path / "a.stl", *BALL)
    content = (tmp_path / "a.stl").read_bytes()
    (tmp_path / "a.stl").write_bytes(b"solid facet".ljust(80) + content[80:])
    vertices, faces = read_mesh(tmp_path / "a.stl")
    assert vertices[faces] == pytest.approx(CORNERS, abs=1e-6)


@pytest.mark.parametrize("change", [str, str.upper, lambda text: text.replace("\n", "\r\n")])
def test_ascii_stl(tmp_path, change):
    (tmp_path / "a.STL").write_bytes(change(ASCII).encode())
    vertices, faces = read_mesh(tmp_path / "a.STL")
    assert vertices[faces] == pytest.approx(CORNERS, abs=1e-6)


def test_obj(tmp_path):
    (tmp_path / "a.obj").write_text(OBJ)
    vertices, faces = read_mesh(tmp_path / "a.obj")
    assert vertices.tolist() == [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 0.5, 1]]
    assert faces.tolist() == [[3, 2, 1], [3, 1, 0], [0, 1, 4], [1, 2, 4]]


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("a.dae", b"", "is neither .stl nor .obj"),
        ("a.stl", b"", "is no STL"),
        ("a.stl", b"hello" * 40, "is no STL"),
        ("a.stl", bytes(84), "has no triangles"),
        ("a.stl", bytes(80) + b"\2\0\0\0" + bytes(60), "it has 60 bytes where 2 triangles take 100"),
        ("a.stl", bytes(80) + b"\1\0\0\0" + bytes(50), "has no triangle with an area"),
        ("a.stl", bytes(80) + b"\1\0\0\0" + np.full(12, np.nan, "<f4").tobytes() + b"\0\0", "corner that is no finite"),
        ("a.stl", b"solid a\nfacet normal 0 0 0\nvertex 1 2 x\nendfacet\n", "has a vertex that is no number"),
        ("a.stl", b"solid a\nfacet normal 0 0 0\nvertex 1 2 3\nendfacet\n", "has facets that are no triangles"),
        ("a.obj", b"# nothing", "is no OBJ, it has no vertices"),
        ("a.obj", b"v 0 0 0\nv 1 0 0", "has no triangles"),
        ("a.obj", b"v 0 0 0\nf 1 2 3", "line 2, `f 1 2 3`, is no vertex or face"),
        ("a.obj", b"v 0 0\n", "line 1, `v 0 0`, is no vertex or face"),
    ],
)  # fmt: skip
def test_what_is_wrong(tmp_path, name, content, said):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(BadValueError, match=re.escape(said)):
        read_mesh(tmp_path / name)
