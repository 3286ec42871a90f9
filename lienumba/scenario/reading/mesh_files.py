"""Meshes that shapes name by their files: read, and kept with the scenario."""

from pathlib import Path
from typing import Any

from lienumba.scenario.base.problems import each
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

    def shapes(at: str, items: list[Any]) -> list[Any]:
        return each(lambda n, shape: _read(f"{at}[{n}]", shape, folder), range(len(items)), items)

    def with_shapes(body: Any) -> Any:
        if not isinstance(body, dict) or not isinstance(body.get("shapes"), list):
            return body
        return {**body, "shapes": shapes(f"model.bodies.{body.get('name')}.shapes", body["shapes"])}

    def read(key: str, value: Any) -> Any:
        if key == GROUND and isinstance(value, list):
            return shapes(f"model.{GROUND}", value)
        return each(with_shapes, value) if key == "bodies" and isinstance(value, list) else value

    return {**raw, "model": dict(zip(model, each(read, model, model.values()), strict=True))}


def _read(at: str, shape: Any, folder: Path) -> Any:
    if not isinstance(shape, dict) or shape.get("type") != "mesh":
        return shape
    if "file" not in shape or shape.get("data") is not None:
        return shape
    path = folder / str(shape["file"])
    with reading(at, shape["file"], path):
        return {**shape, **packed_mesh(*read_mesh(path))}
