"""Coordinates, rates and efforts of a whole tree against MuJoCo: the same joints there, one or more for each of ours.

MuJoCo gets coordinates and rates, and says where bodies are, how they move, and by inverse dynamics what drives them.
"""

from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lienumba
from tests.rigs import all_joints

mujoco = pytest.importorskip("mujoco")

STENCIL = np.array([3, -32, 168, -672, 0, 672, -168, 32, -3]) / 840  # of the first derivative, error of order 8
H, MIDDLE = 1e-3, 0.15
START = {
    "crank": 0.4, "slide": -0.1, "ball": [0.3, -0.2, 0.5], "piston.angle": 9.0, "piston.displacement": 0.2,
    "cross": [0.5, -0.7], "puck": [0.1, -0.2, -4.0],
}  # fmt: skip
RATES = {
    "crank": 1.5, "slide": -0.3, "ball": [1.3, -0.7, 0.9], "piston": [-2.0, 0.4], "cross": [0.8, 1.1],
    "puck": [0.5, 0.3, -1.2],
}  # fmt: skip
# The joints of MuJoCo for each coordinate of ours: kind, and the axis of the second body's frame at 0.
MADE_OF = {
    "revolute": [("hinge", 2)], "prismatic": [("slide", 2)], "spherical": [("ball", 2)],
    "cylindrical": [("slide", 2), ("hinge", 2)], "universal": [("hinge", 0), ("hinge", 2)],
    "planar": [("slide", 0), ("slide", 1), ("hinge", 2)],
}  # fmt: skip
CROSSED = np.array([[0, 0, 1], [0, -1, 0], [1, 0, 0.0]])  # of a universal joint at 0


def scenario() -> dict[str, Any]:
    """Without the screw, which MuJoCo does not have."""
    data = all_joints.scenario("joint", joint_coordinates=True)
    data["model"]["bodies"] = [x for x in data["model"]["bodies"] if x["name"] != "g"]
    data["model"]["joints"] = [x for x in data["model"]["joints"] if x["name"] != "nut"]
    data["model"]["forces"] = [x for x in data["model"]["forces"] if x["joint"] != "nut"]
    del data["quantities"]
    times = [0.0, *(round(MIDDLE + n * H, 6) for n in range(-4, 5))]
    data["output"] = {"times": times, "joint_coordinates": True, "variables": ["position", "velocity"]}
    data["integrator"] |= {"method": "dop853", "step": H, "end_time": times[-1]}
    return data | {"start": {"q": START, "qd": RATES}}


def frames(joint: dict[str, Any]) -> list[np.ndarray]:
    if "axes" not in joint:
        return [np.eye(3)] * 2
    return [
        np.stack([x, np.cross(z, x), z], axis=1)
        for x, z in zip(np.array(joint["references"]), np.array(joint["axes"]), strict=True)
    ]


def text(x: Any) -> str:
    return " ".join(map(repr, np.ravel(x).tolist()))


def mjcf(data: dict[str, Any]) -> str:
    """Body frames are ours: their origins are the mass centres."""
    masses = {x["name"]: x for x in data["model"]["bodies"]}

    def bodies(parent: str) -> str:
        return "".join(body(x) for x in data["model"]["joints"] if x["bodies"][0] == parent)

    def body(joint: dict[str, Any]) -> str:
        name, (a, b), (p, q) = joint["bodies"][1], frames(joint), np.array(joint["points"])
        R = a @ (CROSSED if joint["type"] == "universal" else np.eye(3)) @ b.T
        made = "".join(
            f'<joint name="{joint["name"]}{n}" type="{kind}" pos="{text(q)}" axis="{text(b[:, axis])}" '
            f'armature="{joint.get("armature", 0.0)}"/>'
            for n, (kind, axis) in enumerate(MADE_OF[joint["type"]])
        )
        quat = Rotation.from_matrix(R).as_quat(scalar_first=True)
        return (
            f'<body name="{name}" pos="{text(p - R @ q)}" quat="{text(quat)}">{made}<inertial pos="0 0 0" '
            f'mass="{masses[name]["mass"]}" fullinertia="{text(masses[name]["inertia"])}"/>{bodies(name)}</body>'
        )

    return (
        '<mujoco><option gravity="0 0 -9.81"><flag constraint="disable" contact="disable"/></option><worldbody>'
        f"{bodies('ground')}</worldbody></mujoco>"
    )


class Tree:
    """MuJoCo's tree; coordinates by the names that they have in the dataset."""

    def __init__(self, data: dict[str, Any]) -> None:
        self.model = mujoco.MjModel.from_xml_string(mjcf(data))
        self.data = mujoco.MjData(self.model)
        self.kinds = {x["name"]: x["type"] for x in data["model"]["joints"]}

    def place(self, label: str) -> tuple[int, int]:
        """Of a coordinate in qpos and in qvel."""
        name, _, own = label.partition(".")
        order = {
            "cylindrical": ["displacement", "angle"], "planar": ["x", "y", "angle"],
            "universal": ["first_angle", "second_angle"],
        }.get(self.kinds[name], [own])  # fmt: skip
        part = ["rx", "ry", "rz"].index(own) if own[:1] == "r" else 0
        joint = self.model.joint(f"{name}{0 if part else order.index(own)}")
        return joint.qposadr[0] + part, joint.dofadr[0] + part

    def put(self, labels: list[str], q: np.ndarray, qd: np.ndarray, qdd: np.ndarray) -> None:
        places = [self.place(label) for label in labels]
        for (at, v_at), label, x, dx, ddx in zip(places, labels, q, qd, qdd, strict=True):
            self.data.qvel[v_at], self.data.qacc[v_at] = dx, ddx
            if label.endswith(".rx"):
                turned = Rotation.from_rotvec(q[labels.index(label) :][:3])
                self.data.qpos[at : at + 4] = turned.as_quat(scalar_first=True)
            elif not label.endswith((".ry", ".rz")):
                self.data.qpos[at] = x

    def efforts(self, labels: list[str]) -> np.ndarray:
        mujoco.mj_inverse(self.model, self.data)
        return np.array([self.data.qfrc_inverse[self.place(label)[1]] for label in labels])


def test_a_tree_in_mujoco() -> None:
    data = scenario()
    ds, tree = lienumba.run(data).isel(run=0), Tree(data)
    labels = [str(x) for x in ds.coordinate.values]
    assert set(labels) == {*all_joints.COORDINATES} - {"nut"}
    given = {label: x for key, each in START.items() for label, x in named(key, each, labels)}
    np.testing.assert_allclose([ds.q.sel(coordinate=x)[0] for x in given], [*given.values()], rtol=0, atol=1e-13)
    qdd = STENCIL @ ds.qd.values[1:] / H
    for at, accelerations in ((0, np.zeros(len(labels))), (5, qdd)):
        tree.put(labels, ds.q.values[at], ds.qd.values[at], accelerations)
        mujoco.mj_kinematics(tree.model, tree.data)
        mujoco.mj_comPos(tree.model, tree.data)
        mujoco.mj_comVel(tree.model, tree.data)
        for body in ds.body.values:
            found, v = tree.data.body(str(body)), np.zeros(6)
            np.testing.assert_allclose(ds.position.sel(body=body)[at], found.xipos, rtol=0, atol=1e-12)
            mujoco.mj_objectVelocity(tree.model, tree.data, mujoco.mjtObj.mjOBJ_BODY, found.id, v, 0)
            np.testing.assert_allclose(ds.velocity.sel(body=body)[at], v[3:], rtol=0, atol=1e-11)
    tree.put(labels, ds.q.values[5], ds.qd.values[5], qdd)
    expected = tree.efforts(labels)
    assert np.abs(ds.tau.sel(coordinate=["crank", "slide", "piston.angle", "wheel"])[5]).min() > 0.1
    np.testing.assert_allclose(ds.tau.values[5], expected, rtol=0, atol=1e-8 * np.abs(expected).max())


def named(key: str, given: Any, labels: list[str]) -> list[tuple[str, float]]:
    if not isinstance(given, list):
        return [(key, given)]
    return list(zip([x for x in labels if x.startswith(f"{key}.")], given, strict=True))
