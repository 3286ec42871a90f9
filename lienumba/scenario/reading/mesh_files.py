"""Meshes that shapes name by their files: read, and kept with the scenario."""

from pathlib import Path

from lienumba.errors import Problem, ScenarioError
from lienumba.scenario.base.toml import Keys
from lienumba.scenario.meshes.files import read_mesh
from lienumba.scenario.meshes.packing import packed_mesh
from lienumba.scenario.schema.tables import reading

GROUND = "ground_shapes"


def with_meshes(raw: Keys, folder: Path) -> Keys:
    """The scenario with the mesh of every shape that names a file, relative to this folder."""
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
    if shape.get("type") != "mesh" or "file" not in shape or shape.get("data") is not None:
        return shape
    path = folder / str(shape["file"])
    with reading(at, shape["file"], path):
        return {**shape, **packed_mesh(*read_mesh(path))}
