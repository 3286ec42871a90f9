"""Shapes of a robot's links as MuJoCo's geoms: drawn ones in group 1, those that collide in group 0; none has mass."""

import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lienumba.errors import BadValueError, ScenarioError
from lienumba.importing.base import delete
from lienumba.importing.mujoco_words import said
from lienumba.importing.notes import Note
from lienumba.importing.urdf.mesh_files import READ, find
from lienumba.importing.urdf.robot import Link, Robot, Shape
from lienumba.scenario.meshes.files import read_mesh

if TYPE_CHECKING:
    import mujoco

DRAWN, COLLIDING = 1, 0  # groups, as MuJoCo has them for URDF


class Shapes:
    """Adds geoms and meshes to a model that is being made, and leaves out those that cannot be read."""

    def __init__(self, spec: Any, robot: Robot, file: Path, notes: list[Note]) -> None:
        self.spec, self.robot, self.file, self.notes = spec, robot, file, notes
        self.found: dict[str, Path | None] = {}  # by the name in the file
        self.meshes: dict[tuple[Path, tuple[float, ...]], str] = {}  # names

    def add(self, body: Any, link: Link) -> None:
        """Those of a link."""
        import mujoco

        kinds = {
            "box": mujoco.mjtGeom.mjGEOM_BOX, "sphere": mujoco.mjtGeom.mjGEOM_SPHERE,
            "cylinder": mujoco.mjtGeom.mjGEOM_CYLINDER, "capsule": mujoco.mjtGeom.mjGEOM_CAPSULE,
            "mesh": mujoco.mjtGeom.mjGEOM_MESH,
        }  # fmt: skip
        for shape in link.shapes:
            place = f'link "{link.name}"'
            mesh = self.mesh(shape, place) if shape.kind == "mesh" else ""
            if mesh is None:
                continue
            if not all(x > 0 for x in shape.size):
                self.notes.append(Note(f"a {shape.kind} without extent, left out", (place,), lost=False))
                continue
            geom = body.add_geom(type=kinds[shape.kind], pos=shape.pose.at, quat=shape.pose.quaternion, mass=0.0)
            geom.group = DRAWN if shape.drawn else COLLIDING
            geom.contype = geom.conaffinity = 0 if shape.drawn else 1
            if shape.kind == "mesh":
                geom.meshname = mesh
            else:
                geom.size = [*shape.size, 0.0, 0.0][:3]
            if shape.rgba is not None:
                geom.rgba = shape.rgba

    def mesh(self, shape: Shape, place: str) -> str | None:
        """The name of a shape's mesh in the model; None where it is left out."""
        import mujoco

        name = shape.file
        if name not in self.found:
            self.found[name] = find(name, self.file, self.robot.mesh_folder)
        path = self.found[name]
        if path is None:
            self.notes.append(Note("mesh not found, left out", (f"{place}: {name}",), lost=False))
            return None
        if path.suffix.lower() not in READ:
            what = f"mesh of a format that MuJoCo does not read ({path.suffix or 'no ending'}), left out"
            self.notes.append(Note(what, (f"{place}: {path.name}",), lost=False))
            return None
        known = self.meshes.get((path, shape.scale))
        if known is not None:
            return known
        taken, stem = set(self.meshes.values()), re.sub(r"\s", "_", path.stem)
        unused = next(x for x in (stem, *(f"{stem}_{n}" for n in range(2, len(taken) + 3))) if x not in taken)
        # moments of a mesh are not asked for, and those of a surface exist for every one
        self.spec.add_mesh(
            name=unused, file=str(path), scale=shape.scale, inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL
        )
        self.meshes[path, shape.scale] = unused
        return unused

    def compiled(self) -> "mujoco.MjModel":
        """The model, without the meshes that MuJoCo refuses."""
        while True:
            try:
                return self.spec.compile()
            except ValueError as error:
                self._without(error)

    def _without(self, error: ValueError) -> None:
        """Reads the mesh of which an error speaks by our own reader, or leaves it out."""
        text = str(error)
        for key, name in self.meshes.items():
            if f"'{name}'" not in text and str(key[0]) not in text:
                continue
            mesh = next(x for x in self.spec.meshes if x.name == name)
            if mesh.file and _embedded(mesh, key[0]):
                return
            del self.meshes[key]
            what = f"mesh that MuJoCo does not read ({said(text).what}), left out"
            self.notes.append(Note(what, (str(key[0]),), lost=False))
            for x in (*(geom for geom in self.spec.geoms if geom.meshname == name), mesh):
                delete(self.spec, x)
            return
        found = said(text)
        raise ScenarioError.at(f"{self.file}: {found.where}".rstrip(": "), found.what, found.remedy) from None


def _embedded(mesh: Any, path: Path) -> bool:
    """Whether a mesh has its vertices and triangles now, such as those of an STL that is text."""
    try:
        vertices, faces = read_mesh(path)
    except (BadValueError, OSError):
        return False
    mesh.file, mesh.uservert, mesh.userface = "", vertices.ravel().tolist(), faces.ravel().tolist()
    return True
