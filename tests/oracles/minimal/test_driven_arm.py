"""Every driver against minimal coordinates in which its motion is a function of time: motion and effort."""

import numpy as np
import pytest

from tests.oracles.minimal.arm import (
    BASE,
    F_B,
    GRAVITY,
    HINGE,
    HINGE_JOINT,
    INERTIAS,
    MASSES,
    Z_B,
    F,
    P,
    S,
    Z,
    arm,
    assert_same,
    place_b,
    run,
    scenario,
)  # fmt: skip
from tests.oracles.minimal.coordinates import Minimal, euler, frame, turn

END = 0.6
NONE = np.zeros(3)
SHOULDER = {"name": "j", "type": "revolute", "bodies": ["a", "b"], "points": [P, S], "axes": [Z, Z_B]}
BALL = {"name": "j", "type": "spherical", "bodies": ["a", "b"], "points": [P, S]}
TURNS = ("25*t + 0.7*sin(5*t)", lambda t: 25 * t + 0.7 * np.sin(5 * t))  # two turns and a half
WAVE = ("0.3*sin(4*t) + 0.5*t**2", lambda t: 0.3 * np.sin(4 * t) + 0.5 * t**2)


def turned(angle):
    return F @ turn((0, 0, 1), angle) @ F_B.T


def effort(dataset):
    return dataset.driver_effort.isel(time=-1).values


def check(oracle, q, dq, joints, driver, references=None, step=5e-4):
    data = scenario(oracle, q, dq, joints, END, step, drivers=[driver])
    dataset = run(data)
    q, dq = oracle.run(q, dq, END)
    assert_same(dataset, oracle, q, dq, END)
    assert abs(float(dataset.energy_residual[-1])) < 1e-7
    assert abs(float(dataset.work[-1])) > 1e-3
    return dataset, q, dq


@pytest.mark.parametrize("how", ["value", "rate"])
def test_the_angle_of_a_revolute_joint_over_turns(how):
    text, f = TURNS
    oracle = arm(lambda q, t: (NONE, turned(f(t))))
    driver = {"name": "d", "joint": "j", how: text if how == "value" else "25 + 3.5*cos(5*t)"}
    dataset, q, dq = check(oracle, np.array([0.3]), np.array([1.0]), [HINGE_JOINT, SHOULDER], driver)
    _, R = oracle.places(q, END)[0]
    r_b, R_b = oracle.places(q, END)[1]
    _, torque = oracle.held_by(q, dq, END, [1], r_b + R_b @ S)
    np.testing.assert_allclose(effort(dataset), [torque @ (R @ F[:, 2])], rtol=1e-8)
    joint = dataset.joint_torque.isel(time=-1).sel(joint="j").values
    np.testing.assert_allclose(joint, torque - (torque @ (R @ F[:, 2])) * (R @ F[:, 2]), atol=1e-6)


@pytest.mark.parametrize("coordinate", ["angle", "displacement"])
def test_a_coordinate_of_a_cylindrical_joint(coordinate):
    text, f = TURNS if coordinate == "angle" else WAVE
    if coordinate == "angle":
        oracle = arm(lambda q, t: (q[1] * F[:, 2], turned(f(t))))
    else:
        oracle = arm(lambda q, t: (f(t) * F[:, 2], turned(q[1])))
    joint = SHOULDER | {"type": "cylindrical"}
    driver = {"joint": "j", "coordinate": coordinate, "value": text}
    dataset, q, dq = check(oracle, np.array([0.3, 0.0]), np.array([1.0, 0.4]), [HINGE_JOINT, joint], driver)
    _, R = oracle.places(q, END)[0]
    r_b, R_b = oracle.places(q, END)[1]
    force, torque = oracle.held_by(q, dq, END, [1], r_b + R_b @ S)
    wanted = torque if coordinate == "angle" else force
    np.testing.assert_allclose(effort(dataset), [wanted @ (R @ F[:, 2])], rtol=1e-8)


@pytest.mark.parametrize("how", ["value", "rate"])
def test_the_displacement_of_a_prismatic_joint(how):
    text, f = WAVE
    oracle = arm(lambda q, t: (f(t) * F[:, 2], turned(0.0)))
    driver = {"joint": "j", how: text if how == "value" else "1.2*cos(4*t) + t"}
    joint = SHOULDER | {"type": "prismatic"}
    dataset, q, dq = check(oracle, np.array([0.3]), np.array([1.0]), [HINGE_JOINT, joint], driver)
    _, R = oracle.places(q, END)[0]
    force, _ = oracle.held_by(q, dq, END, [1], NONE)
    np.testing.assert_allclose(effort(dataset), [force @ (R @ F[:, 2])], rtol=1e-8)


def test_the_hinge_itself_counts_from_its_references():
    oracle = arm(lambda q, t: (NONE, euler(*q)), hinge=lambda q, t: 1.2 + 11 * t)
    driver = {"joint": "hinge", "value": "1.2 + 11*t"}
    q, dq = np.array([0.3, -0.2, 0.5]), np.array([0.5, 1.0, -0.4])
    dataset, q, dq = check(oracle, q, dq, [HINGE_JOINT, BALL], driver)
    _, torque = oracle.held_by(q, dq, END, [0, 1], BASE)
    np.testing.assert_allclose(effort(dataset), [torque @ HINGE[:, 2]], rtol=1e-8)


def led(place):
    """Body a goes as place(q, t) says; body b hangs on it by a ball."""

    def places(q, t):
        a = place(q, t)
        return [a, place_b(a, NONE, euler(*q[-3:]))]

    return Minimal(MASSES, INERTIAS, places, GRAVITY)


POINT = np.array([0.2, -0.3, 0.1])
PATH = (["0.4*sin(3*t)", "0.2*t**2 - 0.1", "0.3*cos(2*t)"],
        lambda t: np.array([0.4 * np.sin(3 * t), 0.2 * t**2 - 0.1, 0.3 * np.cos(2 * t)]))  # fmt: skip
BALLS = (np.array([0.3, -0.2, 0.5]), np.array([0.5, 1.0, -0.4]))


def test_a_point_led_along_a_path():
    def place(q, t):
        R = euler(*q[:3])
        return PATH[1](t) - R @ POINT, R

    oracle = led(place)
    driver = {"body": "a", "motion": "point", "point": POINT, "value": PATH[0]}
    q, dq = np.array([0.1, 0.2, -0.3, *BALLS[0]]), np.array([1.0, -0.5, 0.7, *BALLS[1]])
    dataset, q, dq = check(oracle, q, dq, [BALL], driver)
    force, _ = oracle.held_by(q, dq, END, [0, 1], NONE)
    np.testing.assert_allclose(effort(dataset), force, atol=1e-7)


TILT = np.array([0.6, -0.3, 0.8])
AROUND = TILT / np.linalg.norm(TILT)


def test_an_orientation_that_tumbles():
    """exp of a rotation vector that changes its direction."""
    text = ["0.5*sin(3*t)", "0.8*t", "0.4*cos(2*t)"]

    def place(q, t):
        v = np.array([0.5 * np.sin(3 * t), 0.8 * t, 0.4 * np.cos(2 * t)])
        angle = np.sqrt(v @ v)
        N = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]]) / angle
        return q[:3], np.eye(3) + np.sin(angle) * N + (1 - np.cos(angle)) * N @ N

    driver = {"body": "a", "motion": "orientation", "value": text}
    check_rotating(led(place), driver)


def check_rotating(oracle, driver):
    """The power of the effort is what the torque on both bodies about a's centre does; nothing else turns a."""
    q, dq = np.array([0.1, 0.2, -0.3, *BALLS[0]]), np.array([1.0, -0.5, 0.7, *BALLS[1]])
    dataset, q, dq = check(oracle, q, dq, [BALL], driver)
    (r, R), _ = oracle.places(q, END)
    _, torque = oracle.held_by(q, dq, END, [0, 1], r)
    if driver["motion"] == "angular_velocity":
        np.testing.assert_allclose(effort(dataset), R.T @ torque if driver["frame"] == "body" else torque, atol=1e-7)


@pytest.mark.parametrize("axes", ["global", "body"])
def test_an_angular_velocity(axes):
    """About an axis that stands still in the one frame or in the other."""
    start = frame(Z, np.array([1.0, 0, 0]))
    angle = lambda t: 2 * t - 0.5 * np.cos(3 * t) + 0.5  # noqa: E731
    value = [f"{n!r}*(2 + 1.5*sin(3*t))" for n in AROUND.tolist()]
    driver = {"body": "a", "motion": "angular_velocity", "frame": axes, "value": value}

    def place(q, t):
        turning = turn(AROUND, angle(t))
        return q[:3], turning @ start if axes == "global" else start @ turning

    check_rotating(led(place), driver)


@pytest.mark.parametrize(("method", "order", "step"), [("heun", 2, 4e-3), ("rk4", 4, 2e-2)])
def test_a_driven_mechanism_keeps_the_order(method, order, step):
    _, f = WAVE
    oracle = arm(lambda q, t: (f(t) * F[:, 2], turned(0.0)))
    q, dq = np.array([0.3]), np.array([1.0])
    joints = [HINGE_JOINT, SHOULDER | {"type": "prismatic"}]
    exact = oracle.places(oracle.run(q, dq, END)[0], END)[1][0]
    errors = []
    for h in (step, step / 2, step / 4):
        data = scenario(oracle, q, dq, joints, END, h, drivers=[{"joint": "j", "value": WAVE[0]}])
        data["integrator"]["method"] = method
        errors.append(float(np.abs(run(data).position[-1, 1] - exact).max()))
    np.testing.assert_allclose(np.log2(np.array(errors[:-1]) / errors[1:]), order, atol=0.2)


RATIO = -1.7


@pytest.mark.parametrize(("kind", "of"), [("gear", "revolute"), ("coupler", "prismatic")])
def test_a_coupling_ties_two_coordinates(kind, of):
    """In one case two angles, in the other an angle and a displacement."""

    def relative(q, t):
        c = RATIO * (q[0] - 0.4)
        return (NONE, turned(c)) if of == "revolute" else (c * F[:, 2], turned(0.0))

    oracle = arm(relative)
    tie = {"name": "tie", "type": kind, "joints": ["hinge", "j"], "ratio": RATIO}
    q, dq = np.array([0.4]), np.array([2.5])
    dataset = run(scenario(oracle, q, dq, [HINGE_JOINT, SHOULDER | {"type": of}, tie], END))
    q, dq = oracle.run(q, dq, END)
    assert_same(dataset, oracle, q, dq, END)
    force, torque = oracle.held_by(q, dq, END, [0, 1], BASE)
    last, axis = dataset.isel(time=-1).sel(joint="hinge"), HINGE[:, 2]
    np.testing.assert_allclose(last.joint_force, force, atol=1e-7)
    np.testing.assert_allclose(last.joint_torque.values @ axis, 0.0, atol=1e-9)
    np.testing.assert_allclose(np.cross(last.joint_torque, axis), np.cross(torque, axis), atol=1e-7)
