"""Geoms as shapes of bodies, to be looked at."""

import re
from typing import Any

import numpy as np

from lienumba.errors import BadValueError
from lienumba.importing.mapping.draft import GROUND, Draft
from lienumba.importing.mapping.frames import Frame, neat, quaternion, tidy
from lienumba.importing.mapping.source import Source
from lienumba.importing.mapping.tree import Tree
from lienumba.scenario.meshes.packing import packed_mesh

PLANE, HFIELD, SPHERE, CAPSULE, ELLIPSOID, CYLINDER, BOX, MESH = range(8)  # mjtGeom
MOST_GROUP = 2  # of those that MuJoCo's viewer shows
GREY = (0.5, 0.5, 0.5, 1.0)  # of a geom without a colour
DIGITS, PLACES = 6, 8  # of what is only looked at; behind the point


def add_shapes(source: Source, draft: Draft, tree: Tree) -> None:
    """Give each body its geoms; of a body with some that touch nothing, only these, which are made to be looked at."""
    found: dict[str, list[dict[str, Any]]] = {}
    meshes: dict[int, dict[str, Any]] = {}
    for geom in _shown(source):
        name, frame = tree.on(source, int(source.model.geom_bodyid[geom]))
        try:
            shape = _shape(source, geom, meshes)
        except BadValueError as error:
            mesh = source.name("mesh", int(source.model.geom_dataid[geom]))
            draft.note("mesh of too many triangles, left out", f'mesh "{mesh}" {error.problem.rule}', lost=False)
            continue
        if shape is None:
            continue
        there = frame @ Frame.of(source.model.geom_pos[geom], source.model.geom_quat[geom])
        if shape["type"] == "mesh":
            there = there @ _moved(source, int(source.model.geom_dataid[geom])).inverse()
        if any(p := _rough(there.p)):
            shape["position"] = p
        if any((q := _rough(quaternion(there.R)))[1:]):
            shape["rotation"] = q
        if (colour := _colour(source, geom)) is not None:
            shape["colour"] = colour
        found.setdefault(name, []).append(shape)
    draft.ground_shapes += found.pop(GROUND, [])
    for body in draft.bodies:
        if body["name"] in found:
            body["shapes"] = found[body["name"]]


def _shown(source: Source) -> list[int]:
    m = source.model
    seen = [g for g in range(m.ngeom) if m.geom_group[g] <= MOST_GROUP and _rgba(source, g)[3] > 0.0]
    for_looks = [g for g in seen if not m.geom_contype[g] and not m.geom_conaffinity[g]]

    def wearer(g: int) -> tuple[int, int]:
        """Of the ground, which holds many things, each body for itself."""
        body = int(m.geom_bodyid[g])
        link = source.link_of(body)
        return link, 0 if link else body

    dressed = {wearer(g) for g in for_looks} - {(0, 0)}
    return [g for g in seen if wearer(g) not in dressed or g in set(for_looks)]


def _moved(source: Source, mesh: int) -> Frame:
    """Where MuJoCo has put the origin and axes of a mesh, in the frame of its file."""
    return Frame.of(source.model.mesh_pos[mesh], source.model.mesh_quat[mesh])


def _shape(source: Source, geom: int, meshes: dict[int, dict[str, Any]]) -> dict[str, Any] | None:
    m = source.model
    kind, (a, b, c) = int(m.geom_type[geom]), (neat(float(f"{x:.{DIGITS}g}")) for x in m.geom_size[geom])
    if kind == SPHERE:
        return {"type": "sphere", "radius": a}
    if kind in (CAPSULE, CYLINDER):
        return {"type": "capsule" if kind == CAPSULE else "cylinder", "radius": a, "length": neat(2 * b)}
    if kind == ELLIPSOID:
        return {"type": "ellipsoid", "radii": [a, b, c]}
    if kind == BOX:
        return {"type": "box", "size": [neat(2 * x) for x in (a, b, c)]}
    if kind == MESH:
        mesh = int(m.geom_dataid[geom])
        if mesh not in meshes:
            plain = re.sub(r"\W", "_", source.name("mesh", mesh), flags=re.ASCII)
            moved, vertices = _moved(source, mesh), m.mesh_vert[m.mesh_vertadr[mesh] :][: m.mesh_vertnum[mesh]]
            faces = m.mesh_face[m.mesh_faceadr[mesh] :][: m.mesh_facenum[mesh]]
            meshes[mesh] = {**packed_mesh(vertices @ moved.R.T + moved.p, faces), "file": f"{plain}.stl"}
        return dict(meshes[mesh])
    return None


def _rgba(source: Source, geom: int) -> tuple[float, ...]:
    m = source.model
    own, material = tuple(map(float, m.geom_rgba[geom])), int(m.geom_matid[geom])
    return tuple(map(float, m.mat_rgba[material])) if material >= 0 and own == GREY else own


def _colour(source: Source, geom: int) -> str | None:
    rgba = _rgba(source, geom)
    if rgba == GREY:
        return None
    return "#" + "".join(f"{round(255 * min(max(x, 0.0), 1.0)):02x}" for x in rgba[:3])


def _rough(x: np.ndarray) -> list[float]:
    return [neat(round(float(f"{v:.{DIGITS}g}"), PLACES)) for v in tidy(x)]
