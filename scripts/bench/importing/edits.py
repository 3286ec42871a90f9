"""What an importer says it has lost, taken from MuJoCo's model as well, so that the rest can be compared."""

import copy
import re
from collections.abc import Iterable
from typing import Any

import mujoco
import numpy as np

KINDS = {"joint": "JOINT", "body": "BODY", "actuator": "ACTUATOR", "tendon": "TENDON", "equality": "EQUALITY"}
NEVER_COMPARED = ("limits", "contact")  # off on both sides


def without_lost(model: Any, notes: Iterable[Any]) -> tuple[Any, list[str]]:
    """A copy in which what these notes name as lost is off, and in words what of it would have acted; a ValueError
    where a note says nothing that could be switched off."""
    own, words = copy.copy(model), []
    for note in notes:
        if note.lost and not note.what.startswith(NEVER_COMPARED):
            places = [_place(own, text) for text in note.places]
            _off(own, note.what, [place for place in places if place is not None])
            count = len(note.places)
            words.append(f"{note.what} ({count})" if count > 1 else note.what)
    _no_dry_friction(own)
    return own, words


def _place(m: Any, text: str) -> tuple[str, int] | None:
    found = re.match(r'(\w+) "(.*)"', text) or re.match(r"(\w+) (\d+)()", text)
    if not found or found[1] not in KINDS:
        return None
    kind, name = found[1], found[2]
    index = mujoco.mj_name2id(m, getattr(mujoco.mjtObj, f"mjOBJ_{KINDS[kind]}"), name)
    if index < 0:  # nameless: "joint_3" is the fourth
        number = re.search(r"\d+$", name)
        index = int(number[0]) if number else -1
    return (kind, index) if index >= 0 else None


def _off(m: Any, what: str, places: list[tuple[str, int]]) -> None:
    if "fluid" in what:
        m.opt.density = m.opt.viscosity = 0.0
        return
    for kind, i in places:
        if kind == "actuator":
            if what.startswith("actearly"):
                m.actuator_actearly[i] = 0
            else:
                m.actuator_gaintype[i], m.actuator_biastype[i] = 0, 0
                m.actuator_gainprm[i], m.actuator_biasprm[i] = 0.0, 0.0
        elif kind == "equality":
            m.eq_active0[i] = 0
        elif kind == "tendon":
            for field in ("stiffness", "damping", "stiffnesspoly", "dampingpoly", "armature"):
                if hasattr(m, f"tendon_{field}") and _concerns(what, field):
                    getattr(m, f"tendon_{field}")[i] = 0.0
        elif kind == "joint":
            _joint_off(m, what, i)
        else:
            raise ValueError(f"cannot switch off: {what}, {kind} {i}")
    if not places:
        raise ValueError(f"cannot switch off: {what}")


def _joint_off(m: Any, what: str, j: int) -> None:
    dofs = np.flatnonzero(m.dof_jntid == j)
    if "polynomial" in what:
        m.jnt_stiffnesspoly[j], m.dof_dampingpoly[dofs] = 0.0, 0.0
    elif "share" in what:
        m.jnt_actfrclimited[j] = 0
    else:
        for word, field, places in (
            ("stiffness", "jnt_stiffness", j), ("damping", "dof_damping", dofs), ("armature", "dof_armature", dofs),
        ):  # fmt: skip
            if word in what or (word == "stiffness" and "spring" in what):
                getattr(m, field)[places] = 0.0


def _concerns(what: str, field: str) -> bool:
    if "springs and dampers" in what or "polynomial" in what:
        return field != "armature"
    return field.removesuffix("poly") in what


def _no_dry_friction(m: Any) -> None:
    m.dof_frictionloss[:] = 0.0
    m.tendon_frictionloss[:] = 0.0
