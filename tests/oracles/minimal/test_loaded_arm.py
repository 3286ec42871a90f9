"""Every force on the arm against minimal coordinates with the force written out: its motion, and its energy."""

from functools import cache

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.oracles.minimal.arm import F_B, HINGE_JOINT, Z_B, F, P, S, Z, arm, assert_same, run, scenario
from tests.oracles.minimal.coordinates import euler, turn

END = 0.3
SHOULDER = {"name": "j", "type": "cylindrical", "bodies": ["a", "b"], "points": [P, S], "axes": [Z, Z_B]}
BALL = {"name": "j", "type": "spherical", "bodies": ["a", "b"], "points": [P, S]}
ANGLE, DISPLACEMENT = 1, 2  # the coordinates of the cylindrical joint
A_POINT, B_POINT = np.array([0.1, -0.2, 0.3]), np.array([0.3, 0.1, -0.2])
FAR = np.array([0.9, -0.7, 0.2])


def on_point(places, i, p, force):
    """The 6 rows of a force (global) at a point (body frame)."""
    R = places[i][1]
    return np.array([*force, *np.cross(p, R.T @ force)])


def pair(places, p, q, force):
    """A force on q of b and its reaction on p of a."""
    return np.array([on_point(places, 0, p, -force), on_point(places, 1, q, force)])


def point(places, u, i, p):
    """Position and velocity of a point."""
    (r, R), (v, w) = places[i], (u[i, :3], u[i, 3:])
    return r + R @ p, v + R @ np.cross(w, p)


def spring(places, u, t):
    (x, dx), (y, dy) = point(places, u, 0, A_POINT), point(places, u, 1, B_POINT)
    d, length = y - x, np.linalg.norm(y - x)
    rate = d @ (dy - dx) / length
    return pair(places, A_POINT, B_POINT, -(40 * (length - 0.2 - 0.1 * t) + 3 * rate) * d / length)


def pushed(places, u, t):
    force = np.array([3.0, -2 * np.sin(5 * t), 1.0])
    return np.array([np.zeros(6), on_point(places, 1, B_POINT, force)])


def thrust(places, u, t):
    return np.array(
        [np.zeros(6), on_point(places, 1, B_POINT, places[1][1] @ np.array([3.0, -2 * np.sin(5 * t), 1.0]))]
    )


def twisted(places, u, t):
    R = places[0][1]
    return np.array([[0, 0, 0, *(R.T @ [1.0, 2.0, -0.5 * t])], np.zeros(6)])


def twisted_along(places, u, t):
    return np.array([[0, 0, 0, 1.0, 2.0, -0.5 * t], np.zeros(6)])


def drag(places, u, t):
    v = point(places, u, 1, B_POINT)[1]
    return np.array([np.zeros(6), on_point(places, 1, B_POINT, -(0.8 + 0.3 * np.linalg.norm(v)) * v)])


def attraction(places, u, t):
    d = places[1][0] - places[0][0]
    return pair(places, np.zeros(3), np.zeros(3), -5.0 * 0.8 * d / np.linalg.norm(d) ** 3)


def bushing(places, u, t):
    """From the ground to b: displacement and rotation since the start, both along global axes."""
    x, dx = point(places, u, 1, B_POINT)
    R, w = places[1][1], u[1, 3:]
    theta = Rotation.from_matrix(R @ START_B.T).as_rotvec()
    K, D = np.array([3.0, 2.0, 1.0]), np.array([3.0, 2.0, 1.0])
    k, d = np.array([9.0, 8.0, 7.0]), np.array([0.3, 0.2, 0.1])
    right = right_jacobian(theta)  # rates of theta: right^-1 w with w seen from before the rotation
    dtheta = np.linalg.solve(right, (R @ START_B.T).T @ (R @ w))
    generalized = -(k * theta + d * dtheta)
    torque = (R @ START_B.T) @ np.linalg.solve(right.T, generalized)  # global
    b = on_point(places, 1, B_POINT, -(K * (x - FAR) + D * dx))
    b[3:] += R.T @ torque
    return np.array([np.zeros(6), b])


def right_jacobian(v):
    angle = np.linalg.norm(v)
    N = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
    if angle < 1e-6:
        return np.eye(3) - 0.5 * N
    return np.eye(3) - (1 - np.cos(angle)) / angle**2 * N + (angle - np.sin(angle)) / angle**3 * N @ N


def of_joint(which, effort):
    """A law effort(c, dc, t) on a coordinate of the cylindrical joint."""

    def forces(places, u, t):
        (_, R_a), (_, R_b) = places
        axis = R_a @ F[:, 2]
        (x, dx), (y, dy) = point(places, u, 0, P), point(places, u, 1, S)
        if which == DISPLACEMENT:
            turning = np.cross(R_a @ u[0, 3:], axis)
            f = effort(axis @ (y - x), axis @ (dy - dx) + turning @ (y - x), t) * axis
            force = np.array([on_point(places, 0, P, -f), on_point(places, 1, S, f)])
            force[0, 3:] -= R_a.T @ np.cross(y - x, f)  # it acts where b's point is
            return force
        near, far = R_a @ F[:, 0], R_b @ F_B[:, 0]
        angle = np.arctan2(np.cross(near, far) @ axis, near @ far)
        f = effort(angle, axis @ (R_b @ u[1, 3:] - R_a @ u[0, 3:]), t) * axis
        return np.array([[0, 0, 0, *(R_a.T @ -f)], [0, 0, 0, *(R_b.T @ f)]])

    return forces


def clipped(x, limit):
    return min(max(x, -limit), limit)


def stop(c, dc, t):
    if -0.05 <= c <= 0.03:
        return 0.0
    push = -500 * (c - 0.03 if c > 0.03 else c + 0.05)
    both = push - 4 * dc
    return max(both, 0.0) if push > 0 else min(both, 0.0)


ENDS = {"bodies": ["a", "b"], "points": [A_POINT, B_POINT]}
TIP = {"body": "b", "point": B_POINT}
CASES = {
    "spring_damper": (spring, {**ENDS, "stiffness": 40, "damping": 3, "free_length": "0.2 + 0.1*t"}),
    "force": (pushed, {**TIP, "value": [3, "-2*sin(5*t)", 1]}),
    "force along the body": (thrust, {**TIP, "frame": "body", "value": [3, "-2*sin(5*t)", 1]}),
    "torque": (twisted, {"body": "a", "value": [1, 2, "-0.5*t"]}),
    "torque along the body": (twisted_along, {"body": "a", "frame": "body", "value": [1, 2, "-0.5*t"]}),
    "torsion_spring": (
        of_joint(ANGLE, lambda c, dc, t: -2 * (c - 0.4 * t) - 0.1 * dc),
        {"joint": "j", "coordinate": "angle", "stiffness": 2, "damping": 0.1, "free_angle": "0.4*t"},
    ),
    "actuator": (of_joint(DISPLACEMENT, lambda c, dc, t: 6 * np.cos(4 * t)),
                 {"joint": "j", "coordinate": "displacement", "value": "6*cos(4*t)"}),
    "actuator with a target": (
        of_joint(ANGLE, lambda c, dc, t: clipped(9 * (np.sin(2 * t) - c) + 2 * (2 * np.cos(2 * t) - dc), 3.0)),
        {"joint": "j", "coordinate": "angle", "stiffness": 9, "damping": 2, "target": "sin(2*t)", "limit": 3},
    ),
    "friction": (
        of_joint(ANGLE, lambda c, dc, t: -0.2 * dc - 0.5 * np.tanh(dc / 0.3)),
        {"joint": "j", "coordinate": "angle", "viscous": 0.2, "coulomb": 0.5, "velocity": 0.3},
    ),
    "end_stop": (
        of_joint(DISPLACEMENT, stop),
        {"joint": "j", "coordinate": "displacement", "lower": -0.05, "upper": 0.03, "stiffness": 500, "damping": 4},
    ),
    "drag": (drag, {**TIP, "linear": 0.8, "quadratic": 0.3}),
    "point_mass_gravity": (attraction, {"bodies": ["a", "b"], "mu": 5}),
    "bushing": (
        bushing,
        {"bodies": ["ground", "b"], "points": [FAR, B_POINT], "stiffness": [3, 2, 1], "damping": [3, 2, 1],
         "rotational_stiffness": [9, 8, 7], "rotational_damping": [0.3, 0.2, 0.1]},
    ),
}  # fmt: skip
ON_BALL = ("bushing", "spring_damper", "force", "drag")
START = np.array([0.3, 0.2, 0.1, -0.3])


def on_ball(q, t):
    return np.zeros(3), euler(*q[1:])


def on_axis(q, t):
    return q[2] * F[:, 2], F @ turn((0, 0, 1), q[1]) @ F_B.T


START_B = arm(on_ball).places(START, 0.0)[1][1]


def start(ball):
    return START if ball else np.array([0.3, 0.0, 0.0])


@cache
def unloaded(ball, dq):
    """The coordinates at the end without forces."""
    return arm(on_ball if ball else on_axis).run(start(ball), np.array(dq), END)[0]


@pytest.mark.parametrize("name", CASES)
def test_a_force_moves_the_arm_as_it_must(name):
    law, keys = CASES[name]
    ball = name.split()[0] in ON_BALL
    oracle = arm(on_ball if ball else on_axis, forces=law)
    q = start(ball)
    dq = np.array([1.5, 2.0, 0.8, -0.5])[: len(q)] * (0.2 if name == "bushing" else 1.0)  # it gives way by half a turn
    force = {"name": "f", "type": name.split()[0], **keys}
    dataset = run(scenario(oracle, q, dq, [HINGE_JOINT, BALL if ball else SHOULDER], END, forces=[force]))
    free = unloaded(ball, tuple(dq))
    q, dq = oracle.run(q, dq, END)
    assert np.abs(q - free).max() > 1e-3  # the force does something
    kinked = name in ("end_stop", "actuator with a target")  # a step over the kink has its own error
    assert_same(dataset, oracle, q, dq, END, 5e-5 if kinked else 1e-9)
    assert abs(float(dataset.energy_residual[-1])) < (1e-4 if kinked else 1e-8)
