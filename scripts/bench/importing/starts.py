"""An imported scenario that starts wherever MuJoCo's coordinates say."""

import re
from collections.abc import Iterable, Mapping
from copy import deepcopy
from typing import Any

import mujoco
import numpy as np

from bench.importing.reference import Reference, States

Array = np.ndarray
FREE, BALL, SLIDE, HINGE = (int(x) for x in (
    mujoco.mjtJoint.mjJNT_FREE, mujoco.mjtJoint.mjJNT_BALL, mujoco.mjtJoint.mjJNT_SLIDE, mujoco.mjtJoint.mjJNT_HINGE
))  # fmt: skip
KEYS = {SLIDE: ("displacement", "speed"), HINGE: ("angle", "rate")}
START = ("position", "rotation", "velocity", "angular_velocity", "relative_to", "guess")
RENAMED = re.compile(r'(\w+) "(.*)" is (\w+) here')


class Starts:
    """data: the scenario, every coordinate of the tree given, nothing that is smoothed. It has MuJoCo's names, and
    joints of ground and bodies in MuJoCo's order."""

    def __init__(self, data: Mapping[str, Any], reference: Reference, notes: Iterable[Any]) -> None:
        self.data, self.reference, self.model = deepcopy(dict(data)), reference, reference.model
        places = [place for note in notes for place in note.places]
        self.renamed = {(x[1], x[2]): x[3] for place in places if (x := RENAMED.fullmatch(place))}
        section = self.data["model"]
        section["forces"] = [x for x in map(_without_dry_friction, section.get("forces", [])) if x is not None]
        self.bodies = {body["name"]: body for body in section["bodies"]}
        self.joints = {joint["name"]: joint for joint in section["joints"]}
        for j in range(self.model.njnt):
            self._give(j)
        self.inputs = [self._name("input", "ACTUATOR", a) for a in range(self.model.nu)]

    def _name(self, kind: str, of: str, i: int) -> str:
        name = mujoco.mj_id2name(self.model, getattr(mujoco.mjtObj, f"mjOBJ_{of}"), i) or f"{of.lower()}_{i}"
        return self.renamed.get((kind, name), name)

    def _give(self, j: int) -> None:
        """Room for the coordinate of a joint in the scenario."""
        kind = int(self.model.jnt_type[j])
        if kind in KEYS:
            joint = self.joints[self._name("joint", "JOINT", j)]
            joint |= dict.fromkeys(KEYS[kind], 0.0)
            child = self.bodies[joint["bodies"][1]]
            for key in START:
                child.pop(key, None)
            return
        body = self._body(j)
        keep = {"position": [0.0] * 3, "velocity": [0.0] * 3} if kind == FREE else {}
        above = None if kind == FREE else self.joints[self._name("joint", "JOINT", j)]["bodies"][0]
        for key in START:
            body.pop(key, None)
        body |= keep | {"rotation": [1.0, 0.0, 0.0, 0.0], "angular_velocity": [0.0] * 3}
        if above not in (None, "ground"):
            body["relative_to"] = above

    def _body(self, j: int) -> dict[str, Any]:
        """That carries the last of a link's joints, or stands between."""
        if int(self.model.jnt_type[j]) == FREE:
            return self.bodies[self._name("body", "BODY", int(self.model.jnt_bodyid[j]))]
        return self.bodies[self.joints[self._name("joint", "JOINT", j)]["bodies"][1]]

    def at(self, states: States) -> dict[str, Any]:
        """The scenario at the first of these states."""
        data = deepcopy(self.data)
        for path, x in self.columns(states).items():
            set_number(data, path, float(x[0]))
        return data

    def columns(self, states: States) -> dict[str, Array]:
        """A table of starts."""
        found: dict[str, Array] = {}
        for j in range(self.model.njnt):
            kind, m = int(self.model.jnt_type[j]), self.model
            q, v = states.q[:, m.jnt_qposadr[j] :], states.v[:, m.jnt_dofadr[j] :]
            if kind in KEYS:
                name = self._name("joint", "JOINT", j)
                found |= {f"joints.{name}.{key}": x[:, 0] for key, x in zip(KEYS[kind], (q, v), strict=True)}
                continue
            body = f"bodies.{self._body(j)['name']}"
            if kind == FREE:
                R, c = _rotations(q[:, 3:7]), self._centre(int(m.jnt_bodyid[j]))
                found |= _columns(f"{body}.position", q[:, :3] + R @ c)
                carried = np.einsum("nij,nj->ni", R, np.cross(v[:, 3:6], c))
                found |= _columns(f"{body}.velocity", v[:, :3] + carried)
                found |= _columns(f"{body}.rotation", q[:, 3:7]) | _columns(f"{body}.angular_velocity", v[:, 3:6])
            else:
                found |= _columns(f"{body}.rotation", self._turned(j, q[:, :4]))
                found |= _columns(f"{body}.angular_velocity", v[:, :3])
        for name, x in zip(self.inputs, states.ctrl.T, strict=True):
            if name in self.data.get("inputs", {}):
                found[f"inputs.{name}"] = x
        return found

    def _centre(self, link: int) -> Array:
        """The mass centre of a link in its axes."""
        m, d = self.model, self.reference.data
        d.qpos[:] = m.qpos0
        mujoco.mj_kinematics(m, d)
        own = self.reference.links[link]
        mean = m.body_mass[own] @ d.xipos[own] / m.body_mass[own].sum()
        centre: Array = d.xmat[link].reshape(3, 3).T @ (mean - d.xpos[link])
        return centre

    def _turned(self, j: int, q: Array) -> Array:
        """The quaternion of a ball from the child to what carries the joint: of a body's first joint, the link above
        where MuJoCo welds the body's frame to it."""
        m, d = self.model, self.reference.data
        body = int(m.jnt_bodyid[j])
        if j != m.body_jntadr[body]:
            return q
        d.qpos[:] = m.qpos0
        mujoco.mj_kinematics(m, d)
        link, own, found = int(m.body_weldid[m.body_parentid[body]]), np.zeros(4), np.empty_like(q)
        conjugate = d.xquat[link] * [1, -1, -1, -1] if link else np.array([1.0, 0.0, 0.0, 0.0])
        mujoco.mju_mulQuat(own, conjugate, _before(m, d, body))
        for n, x in enumerate(q):
            mujoco.mju_mulQuat(found[n], own, x)
        return found


def _before(m: Any, d: Any, body: int) -> Array:
    """The global rotation of a body in front of its joints."""
    found = np.zeros(4)
    mujoco.mju_mulQuat(found, d.xquat[m.body_parentid[body]], m.body_quat[body])
    return found


def set_number(data: dict[str, Any], path: str, x: float) -> None:
    """At a path of a sweep."""
    section, name, *rest = path.split(".")
    if not rest:
        data[section][name] = x
        return
    (item,) = [item for item in data["model"][section] if item["name"] == name]
    key, _, index = rest[0].partition("[")
    if index:
        item[key][int(index.removesuffix("]"))] = x
    else:
        item[key] = x


def _columns(name: str, x: Array) -> dict[str, Array]:
    return {f"{name}[{n}]": column for n, column in enumerate(x.T)}


def _rotations(q: Array) -> Array:
    found = np.zeros((len(q), 9))
    for n, x in enumerate(q):
        mujoco.mju_quat2Mat(found[n], x)
    return found.reshape(-1, 3, 3)


def _without_dry_friction(force: dict[str, Any]) -> dict[str, Any] | None:
    if force["type"] != "friction":
        return force
    return {key: x for key, x in force.items() if key not in ("coulomb", "velocity")} if force.get("viscous") else None
