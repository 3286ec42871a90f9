"""A file of MJCF as MuJoCo reads it."""

import math
import re
import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from lienumba.errors import ScenarioError
from lienumba.importing.base import delete, rebased
from lienumba.importing.markup import LARGEST, Element
from lienumba.importing.mujoco_words import said
from lienumba.importing.notes import Note

if TYPE_CHECKING:
    import mujoco


def mjcf(root: Element, file: Path, base: Literal["fixed", "free"] | None) -> tuple["mujoco.MjModel", list[Note]]:
    """The model, and what was changed or left out."""
    import mujoco

    notes: list[Note] = []
    _check_finite(root, file)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            spec = mujoco.MjSpec.from_file(str(file))
        except ValueError as error:
            raise _refused(file, str(error)) from None
        if base is not None:
            rebased(spec, file, base, notes)
        model = _compiled(spec, file, notes)
    notes += [Note("MuJoCo: " + " ".join(str(x.message).split()), lost=False) for x in caught]
    _check_size(model, file)
    return model, notes


def _refused(file: Path, text: str) -> ScenarioError:
    found = said(text)
    return ScenarioError.at(f"{file}, {found.where}".rstrip(", "), found.what, found.remedy)


def _compiled(spec: Any, file: Path, notes: list[Note]) -> "mujoco.MjModel":
    """The model, without the meshes and pictures that are not there and move nothing."""
    while True:
        try:
            return spec.compile()
        except ValueError as error:
            text = str(error)
            found = re.search(r"opening file '([^'\n]*)'", text)
            if found is None or not _left_out(spec, file, found[1], notes):
                raise _refused(file, text) from None


def _left_out(spec: Any, file: Path, path: str, notes: list[Note]) -> bool:
    """Whether the model no longer asks for a file; a ScenarioError where something's inertia comes from it."""
    import mujoco

    name = Path(path).name
    for texture in spec.textures:
        if texture.file and Path(texture.file).name == name:
            texture.file, texture.builtin = "", mujoco.mjtBuiltin.mjBUILTIN_FLAT
            texture.width = texture.height = 1
            notes.append(Note("picture not found, left out", (path,), lost=False))
            return True
    for mesh in spec.meshes:
        if not mesh.file or Path(mesh.file).name != name:
            continue
        called = mesh.name or Path(mesh.file).stem
        geoms = [geom for geom in spec.geoms if geom.meshname == called]
        for geom in geoms:
            if _weighs(spec, geom):
                raise ScenarioError.at(
                    f'{file}: mesh "{called}"',
                    f'its file "{path}" is not there, and the inertia of body "{geom.parent.name}" comes from it',
                    "put it there, or give the body an <inertial>",
                )
        for x in (*geoms, mesh):
            delete(spec, x)
        notes.append(Note("mesh not found, left out", (f'mesh "{called}": {path}',), lost=False))
        return True
    return False


def _weighs(spec: Any, geom: Any) -> bool:
    """Whether the inertia of its body comes from a geom."""
    import mujoco

    rule = spec.compiler.inertiafromgeom
    asked = rule == mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_TRUE or (
        rule == mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_AUTO and not geom.parent.explicitinertial
    )
    return bool(asked and geom.mass != 0 and (geom.density != 0 or geom.mass > 0) and geom.parent.name != "world")


def _check_finite(root: Element, file: Path) -> None:
    """No number of the file is NaN or infinite."""
    for element in root.iter():
        for key, text in element.items():
            if key == "name" or not re.search(r"nan|inf", text, re.IGNORECASE):
                continue
            try:
                finite = all(math.isfinite(float(word)) for word in text.split())
            except ValueError:
                continue
            if not finite:
                at = f"{file}, line {getattr(element, 'line', 0)}: <{element.tag}> {key}"
                raise ScenarioError.at(at, "is not finite", "give numbers", text)


def _check_size(model: "mujoco.MjModel", file: Path) -> None:
    """What says how bodies move are numbers of ordinary size."""
    import mujoco

    body, joint = mujoco.mjtObj.mjOBJ_BODY, mujoco.mjtObj.mjOBJ_JOINT
    bodies, joints = range(model.nbody), range(model.njnt)
    for key, values, kind, ids in (
        ("mass", model.body_mass, body, bodies),
        ("inertia", model.body_inertia, body, bodies),
        ("pos", model.body_pos, body, bodies),
        ("mass centre", model.body_ipos, body, bodies),
        ("pos", model.jnt_pos, joint, joints),
        ("axis", model.jnt_axis, joint, joints),
        ("armature", model.dof_armature, joint, model.dof_jntid),
        ("damping", model.dof_damping, joint, model.dof_jntid),
        ("frictionloss", model.dof_frictionloss, joint, model.dof_jntid),
    ):
        bad = np.argwhere(~(np.abs(values) <= LARGEST))
        if len(bad):
            i = int(ids[int(bad[0][0])])
            words = "body" if kind == body else "joint"
            at = f'{file}: {words} "{mujoco.mj_id2name(model, kind, i) or i}" {key}'
            raise ScenarioError.at(at, f"must be at most {LARGEST:g} in SI units", "check it", float(values[*bad[0]]))
