"""Meshes that shapes name by their files: read, simplified, and kept with the scenario."""

from pathlib import Path

from lienumba.errors import BadValueError, Problem, ScenarioError
from lienumba.scenario.base.toml import Keys
from lienumba.scenario.meshes.files import read_mesh
from lienumba.scenario.meshes.packing import DEFAULT, MOST, packed_mesh, unpacked
from lienumba.scenario.schema.tables import reading

GROUND = "ground_shapes"


def with_meshes(raw: Keys, folder: Path) -> Keys:
    """The scenario with the mesh of every shape that names a file, relative to this folder, and with those that have
    more triangles than they say simplified further."""
    model = raw.get("model")
    if not isinstance(model, dict):
        return raw
    changed = dict(model)
    problems: list[Problem] = []
    bodies = model.get("bodies")
    places = [(f"model.{GROUND}", model, GROUND)] if GROUND in model else []
    if isinstance(bodies, list) and any(isinstance(body, dict) and "shapes" in body for body in bodies):
        changed["bodies"] = [dict(body) if isinstance(body, dict) else body for body in bodies]
        named = [body for body in changed["bodies"] if isinstance(body, dict)]
        places += [(f"model.bodies.{body.get('name')}.shapes", body, "shapes") for body in named]
    for at, table, key in places:
        items = table.get(key)
        if not isinstance(items, list):
            continue
        found = []
        for n, shape in enumerate(items):
            try:
                found.append(_read(f"{at}[{n}]", shape, folder) if isinstance(shape, dict) else shape)
            except ScenarioError as error:
                problems += error.problems
        (changed if key == GROUND else table)[key] = found
    if problems:
        raise ScenarioError(*problems)
    return {**raw, "model": changed}


def _read(at: str, shape: Keys, folder: Path) -> Keys:
    triangles, data = shape.get("triangles", DEFAULT), shape.get("data")
    if not isinstance(triangles, int) or isinstance(triangles, bool) or not 4 <= triangles <= MOST:
        return shape  # which is told later
    if shape.get("type") != "mesh" or not ("triangles" in shape or ("file" in shape and data is None)):
        return shape
    kept = {key: item for key, item in shape.items() if key != "triangles"}
    if data is None and "file" in shape:
        path = folder / str(shape["file"])
        with reading(at, shape["file"], path):
            vertices, faces = read_mesh(path)
    elif isinstance(data, str):
        try:
            vertices, faces = unpacked(data)
        except BadValueError:
            return shape  # which is told later
        if len(faces) <= triangles:
            return kept
    else:
        return shape
    return {**kept, **packed_mesh(vertices, faces, triangles)}
