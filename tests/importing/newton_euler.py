"""Inertias and forces of a URDF file by Newton and Euler, in NumPy alone: what each joint feels, link by link."""

from dataclasses import dataclass, replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from scipy.spatial.transform import Rotation


def numbers(element, key, default):
    return np.array([float(x) for x in element.get(key, default).split()])


def placement(element):
    """xyz and R of the <origin> in an element."""
    origin = element.find("origin")
    if origin is None:
        return np.zeros(3), np.eye(3)
    xyz, rpy = (numbers(origin, key, "0 0 0") for key in ("xyz", "rpy"))
    return xyz, Rotation.from_euler("xyz", rpy).as_matrix()


@dataclass(frozen=True)
class Frame:
    """Place, turning and velocities of a link, its accelerations where no rate changes, and what each rate gives to its
    velocities (3, n); all global."""

    p: np.ndarray
    R: np.ndarray
    w: np.ndarray
    a: np.ndarray
    alpha: np.ndarray
    Jv: np.ndarray
    Jw: np.ndarray

    def at(self, r):
        """The same of a point r from here, that moves along."""
        a = self.a + np.cross(self.alpha, r) + np.cross(self.w, np.cross(self.w, r))
        return replace(self, p=self.p + r, a=a, Jv=self.Jv + np.cross(self.Jw, r, axisa=0, axisc=0))


def moved(frame, joint, q, rate, column):
    """The frame of a joint's child."""
    xyz, turn = placement(joint)
    R = frame.R @ turn
    own = numbers(joint.find("axis"), "xyz", "1 0 0")
    axis = R @ own / np.linalg.norm(own)
    if joint.get("type") == "fixed":
        return replace(frame.at(frame.R @ xyz), R=R)
    if joint.get("type") == "prismatic":
        there = frame.at(frame.R @ xyz + q * axis)
        there.Jv[:, column] += axis
        return replace(there, R=R, a=there.a + 2 * rate * np.cross(frame.w, axis))
    there = frame.at(frame.R @ xyz)
    Jw = there.Jw.copy()
    Jw[:, column] += axis
    R = Rotation.from_rotvec(q * axis).as_matrix() @ R
    return replace(there, R=R, w=frame.w + rate * axis, alpha=there.alpha + rate * np.cross(frame.w, axis), Jw=Jw)


def inertia_and_bias(file: Path, base: Frame, states, gravity):
    """M (n, n), and the forces (n,) that rates and weight need where no rate changes. base: of the first link; states:
    of each joint that moves its coordinate, its rate and its column."""
    robot = ElementTree.parse(file).getroot()
    links = {link.get("name"): link for link in robot.iter("link")}
    frames = {next(iter(links)): base}
    M, bias = np.zeros((base.Jv.shape[1],) * 2), np.zeros(base.Jv.shape[1])
    for joint in robot.iter("joint"):
        parent, child = (joint.find(end).get("link") for end in ("parent", "child"))
        frames[child] = moved(frames[parent], joint, *states.get(joint.get("name"), (0.0, 0.0, None)))
    for name, frame in frames.items():
        if (inertial := links[name].find("inertial")) is None:
            continue
        xyz, turn = placement(inertial)
        centre, R, given = frame.at(frame.R @ xyz), frame.R @ turn, inertial.find("inertia")
        words = [["ixx", "ixy", "ixz"], ["ixy", "iyy", "iyz"], ["ixz", "iyz", "izz"]]
        J = R @ np.array([[float(given.get(word)) for word in row] for row in words]) @ R.T
        m, w = float(inertial.find("mass").get("value")), frame.w
        M += m * centre.Jv.T @ centre.Jv + frame.Jw.T @ J @ frame.Jw
        bias += m * centre.Jv.T @ (centre.a - gravity)
        bias += frame.Jw.T @ (J @ frame.alpha + np.cross(w, J @ w))
    return M, bias
