"""Linkages as a user enters them: points and axes at the start, in global coordinates."""

import numpy as np

from lienumba.mechanics.mechanism.model import JointStart, Pose, Start
from tests.facade import GROUND, Body, Joint, Model

GRAVITY = (0.0, 0.0, -9.81)


def unit_body(name):
    return Body(name, 1.0, (0.1, 0.12, 0.14, 0.0, 0.0, 0.0))


def triple(x):
    return tuple(float(y) for y in x)


def closed_chain(points, axes):
    """One revolute joint at each point about each axis; the first link is the ground, the others lie between."""
    k = len(points) - 1
    ends = [(GROUND, 0), *((i, i + 1) for i in range(k - 1)), (k - 1, GROUND)]
    joints = tuple(Joint(f"j{i}", "revolute", e) for i, e in enumerate(ends))
    middle = [0.5 * (np.array(points[i]) + np.array(points[i + 1])) for i in range(k)]
    poses = tuple(Pose(position=triple(m), rotation=(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)) for m in middle)
    says = tuple(JointStart(at=triple(p), axis=(triple(z),)) for p, z in zip(points, axes, strict=True))
    return Model(GRAVITY, tuple(unit_body(f"b{i}") for i in range(k)), joints), Start(poses, says)


def denavit_hartenberg(lengths, twists, angles):
    """Points and axes of a chain without offsets, and where it ends: T = Rz(angle) Tx(length) Rx(twist)."""
    T, points, axes = np.eye(4), [], []
    for a, alpha, theta in zip(lengths, twists, angles, strict=True):
        points.append(T[:3, 3])
        axes.append(T[:3, 2])
        c, s, ca, sa = np.cos(theta), np.sin(theta), np.cos(alpha), np.sin(alpha)
        T = T @ [[c, -s * ca, s * sa, a * c], [s, c * ca, -c * sa, a * s], [0, sa, ca, 0], [0, 0, 0, 1]]
    return points, axes, T


def bennett(angle=1.0):
    """Opposite links are equal, and sin(twist)/length is the same for all four."""
    a, b, alpha = 1.0, 0.7, 0.6
    beta = np.arcsin(np.sin(alpha) * b / a)
    ratio = np.sin(0.5 * (beta + alpha)) / np.sin(0.5 * (beta - alpha))
    other = 2.0 * np.arctan2(ratio, np.tan(0.5 * angle))
    points, axes, T = denavit_hartenberg((a, b, a, b), (alpha, beta, alpha, beta), (angle, other, -angle, -other))
    np.testing.assert_allclose(T, np.eye(4), atol=1e-12)
    return closed_chain(points, axes)


def planar_four_bar():
    return closed_chain([(0, 0, 0), (0.3, 0.8, 0), (1.6, 1.1, 0), (2, 0, 0)], [(0, 0, 1)] * 4)


def door():
    """Two hinges on one line."""
    says = tuple(JointStart(at=(0.0, 0.0, z), axis=((0.0, 0.0, 1.0),)) for z in (0.3, 1.7))
    joints = (Joint("low", "revolute", (GROUND, 0)), Joint("high", "revolute", (GROUND, 0)))
    pose = Pose(position=(0.4, 0.0, 1.0), rotation=(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0))
    return Model(GRAVITY, (unit_body("door"),), joints), Start((pose,), says)
