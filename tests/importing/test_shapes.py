"""Shapes of an imported robot lie where its file has them."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from lienumba.scenario.meshes.files import write_stl
from lienumba.scenario.meshes.packing import unpacked

pytest.importorskip("mujoco")
CORNERS = np.array([[1.0, 0, 0], [1.3, 0, 0], [1, 0.2, 0], [1, 0, 0.1]])
FACES = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])


def model_of(folder: Path, ground: str = "", arm: str = "") -> Any:
    """Of a base, which stands on the ground, and an arm whose mass centre is at (0, 0, 0.5)."""
    from lienumba.importing import from_urdf

    write_stl(folder / "wedge.stl", CORNERS, FACES)
    inertia = '<mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>'
    (folder / "robot.urdf").write_text(
        f'<robot name="r"><link name="base">{ground}</link>'
        f'<link name="arm"><inertial><origin xyz="0 0 0.5"/>{inertia}</inertial>{arm}</link>'
        '<joint name="hinge" type="continuous"><parent link="base"/><child link="arm"/><axis xyz="0 1 0"/></joint>'
        "</robot>"
    )
    return from_urdf(folder / "robot.urdf").to_dict()["model"]


def drawn(geometry: str, kind: str = "visual", origin: str = "") -> str:
    return f"<{kind}>{origin}<geometry>{geometry}</geometry></{kind}>"


MESH = '<mesh filename="wedge.stl"/>'


def test_a_mesh_keeps_the_frame_of_its_file(tmp_path: Path) -> None:
    model = model_of(tmp_path, arm=drawn(MESH, origin='<origin xyz="0 0 0.1"/>'))
    (shape,) = model["bodies"][0]["shapes"]
    assert shape["position"] == [0, 0, -0.4]
    assert "rotation" not in shape
    vertices, _ = unpacked(shape["data"])
    found = vertices[np.lexsort(vertices.T)]
    np.testing.assert_allclose(found, CORNERS[np.lexsort(CORNERS.T)], rtol=0, atol=1e-4)


def test_what_collides_is_drawn_where_there_is_nothing_else(tmp_path: Path) -> None:
    box = '<box size="1 2 3"/>'
    model = model_of(tmp_path, ground=drawn(MESH) + drawn(box, "collision"), arm=drawn(box, "collision"))
    assert [shape["type"] for shape in model["ground_shapes"]] == ["mesh"]
    assert [shape["type"] for shape in model["bodies"][0]["shapes"]] == ["box"]


def test_a_mesh_with_a_name_that_no_file_can_have_is_left_out(tmp_path: Path) -> None:
    model = model_of(tmp_path, arm=drawn(f'<mesh filename="{"m" * 300}.stl"/>') + drawn('<box size="1 2 3"/>'))
    assert [shape["type"] for shape in model["bodies"][0]["shapes"]] == ["box"]


def test_a_mesh_of_too_many_triangles_is_left_out(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from lienumba.importing import from_urdf

    model_of(tmp_path, arm=drawn(MESH) + drawn('<box size="1 2 3"/>'))
    monkeypatch.setattr("lienumba.scenario.meshes.packing.MOST", 3)
    found = from_urdf(tmp_path / "robot.urdf")
    assert [shape["type"] for shape in found.to_dict()["model"]["bodies"][0]["shapes"]] == ["box"]
    (note,) = (note for note in found.notes if "triangles" in note.what)
    assert note.places == ('mesh "wedge" has 4 triangles, of which a shape takes 3 at most',)
    assert not note.lost
