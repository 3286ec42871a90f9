"""Gears and couplers: minimal coordinates in which one joint's coordinate is written by the other's."""

from typing import Any

import numpy as np
import pytest

from tests.oracles.trees.dense import Array, Motion, motion, simulate
from tests.oracles.trees.trees import TIMES, Link, Random, Tree, compare, run, same, scenario
from tests.rigs import parts
from tests.rigs.scenarios import start_of


def train(kinds: tuple[str, str], order: str, ratio: float, offset: float, planet: bool) -> tuple[Tree, Random]:
    """Two coupled joints: both on a carrier that swings on a ball, or (planet) from the ground to a and from a to b."""
    draw = Random(kinds, order, planet)
    bases = ("ground", "a") if planet else ("carrier", "carrier")
    links = [] if planet else [Link("carrier", draw.body(), draw.joint("ball", "spherical", ("ground", "carrier")))]
    for name, kind, base, sign in zip("ab", kinds, bases, order, strict=True):
        ends = (base, name) if sign == "+" else (name, base)
        links.append(Link(name, draw.body(), draw.joint(f"joint_{name}", kind, ends), base))
    gear = {"name": "tie", "type": "gear", "joints": ["joint_a", "joint_b"], "ratio": ratio, "offset": offset}
    if kinds != ("revolute", "revolute"):
        gear["type"] = "coupler"

    def reduced(q: list[Array], t: Any) -> list[Array]:
        return [*q, ratio * q[-1] + offset]

    return Tree(links, joints=[gear], reduced=reduced), draw


def coupled(tree: Tree, here: Motion, link: Link) -> tuple[Array, Array, float]:
    """A joint's own reaction, and what the coupling exerts along its coordinate."""
    force, torque = tree.load(here, link)
    first = link.joint.bodies[0]
    axis = link.joint.frames[0][:, 2]
    if first != "ground":
        axis = here.R[tree.names.index(first)] @ axis
    if link.joint.type == "revolute":
        return force, torque - (torque @ axis) * axis, float(torque @ axis)
    return force - (force @ axis) * axis, torque, float(force @ axis)


@pytest.mark.parametrize(
    ("kinds", "order", "ratio", "offset", "planet"),
    [
        (("revolute", "revolute"), "-+", 1.7, -8.0, True),
        (("revolute", "prismatic"), "+-", 0.4, 0.1, False),
        (("prismatic", "revolute"), "--", 3.0, 1.0, True),
    ],
)
def test_two_coordinates_go_together(
    kinds: tuple[str, str], order: str, ratio: float, offset: float, planet: bool
) -> None:
    tree, draw = train(kinds, order, ratio, offset, planet)
    n = 1 if planet else 4
    q, qd = draw.start(tree, count=n)
    history = simulate(tree.mechanism, q, qd, TIMES)
    data = scenario(tree, history[0])
    if abs(offset) > np.pi:  # the poses alone do not say in which turn the second angle is
        data["model"]["joints"][-2]["angle"] = ratio * q[-1] + offset
    ds = run(data)
    compare(tree, ds, history)
    first, second = tree.links[-2:]
    for time, here in enumerate(history):
        now = ds.isel(time=time)
        efforts = []
        for link in (first, second):
            force, torque, effort = coupled(tree, here, link)
            same(now["joint_force"].sel(joint=link.joint.name), force, 1e-7, f"force of {link.joint.name}")
            same(now["joint_torque"].sel(joint=link.joint.name), torque, 1e-7, f"torque of {link.joint.name}")
            efforts.append(effort)
        assert efforts[0] == pytest.approx(-ratio * efforts[1], abs=1e-9 * max(map(abs, efforts)))  # it does no work
        assert abs(efforts[1]) > 1e-3
        same(now["multiplier"].sel(constraint="tie[0]"), -efforts[1], 1e-7, "multiplier of the coupling")


@pytest.mark.parametrize("ratio", [0.25, -3.0])
def test_wheels_on_fixed_axles_turn_as_one(ratio: float) -> None:
    """Closed form: balanced wheels, a constant torque on the first, many turns of the second."""
    axes, inertias = np.array([[0.6, 0.0, 0.8], [0.0, -0.28, 0.96]]), (0.5, 0.2)
    wheels = [
        parts.body(name, 3.0, (J * np.outer(z, z) + 0.4 * (np.eye(3) - np.outer(z, z))).tolist(), position=[i, 0, 0],
                   rotation=[1, 0, 0, 0])
        for i, (name, z, J) in enumerate(zip("ab", axes, inertias, strict=True))
    ]  # fmt: skip
    joints = [
        parts.hinge(name, body, [i, 0, 0], z.tolist())
        for i, (name, body, z) in enumerate(zip(("one", "two"), "ab", axes, strict=True))
    ]
    joints[0]["rate"] = 2.0
    joints.append({"name": "tie", "type": "gear", "joints": ["one", "two"], "ratio": ratio})
    push = {"type": "torque", "body": "a", "value": (7.0 * axes[0]).tolist()}
    data = {
        "model": {"bodies": wheels, "joints": joints, "forces": [push]},
        "integrator": {"step": 1e-3, "end_time": 2.0},
        "output": {"times": [0, 2.0]},
    }
    ds = run(data).isel(time=-1)
    rate = 7.0 / (inertias[0] + ratio**2 * inertias[1])
    angle, speed = 2.0 * 2.0 + 0.5 * rate * 4.0, 2.0 + 2.0 * rate
    for i, factor in enumerate((1.0, ratio)):
        R, z = ds["rotation"][i].values, axes[i]
        same(ds["angular_velocity"][i], factor * speed * z, 1e-9, "angular velocity")
        same(np.trace(R), 1 + 2 * np.cos(factor * angle), 1e-8, "angle")
        turning = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
        same(turning, 2 * np.sin(factor * angle) * z, 1e-8, "direction of the angle")
    assert abs(ratio * angle) > 2 * np.pi or abs(angle) > 4 * np.pi
    torque = ratio * inertias[1] * rate
    same(ds["joint_torque"].sel(joint="tie"), torque * axes[1], 1e-9, "torque of the gear on its last wheel")
    same(ds["joint_torque"].sel(joint="one"), [0, 0, 0], 1e-9, "torque of a balanced axle")


def test_a_screw_of_many_turns_falls() -> None:
    """Closed form: a nut on a tilted spindle, s = pitch*angle/turn, falls with a constant acceleration."""
    axis, pitch, g = np.array([2.0, -1.0, 2.0]) / 3.0, 0.05, 9.81
    turn = 2 * np.pi
    J = 0.03 * np.outer(axis, axis) + 0.05 * (np.eye(3) - np.outer(axis, axis))
    nut = parts.body("nut", 1.2, J.tolist(), position=[0, 0, 0], rotation=[1, 0, 0, 0])
    screw = parts.joint("thread", "screw", "ground", "nut", at=[0, 0, 0], axis=axis.tolist(), pitch=pitch, rate=20.0)
    data = {
        "model": {"bodies": [nut], "joints": [screw]},
        "integrator": {"step": 1e-3, "end_time": 2.0},
        "output": {"times": [0, 2.0]},
    }
    ds = run(data).isel(time=-1, body=0)
    # the ground is the second body: with the angle of the nut u = -angle, its way along the axis is -s = pitch*u/turn
    lead = pitch / turn
    accel = -1.2 * g * axis[2] * lead / (0.03 + 1.2 * lead**2)
    u, rate = -20.0 * 2.0 + 0.5 * accel * 4.0, -20.0 + accel * 2.0
    same(ds["position"], lead * u * axis, 1e-9, "position")
    same(ds["velocity"], lead * rate * axis, 1e-9, "velocity")
    same(ds["angular_velocity"], rate * axis, 1e-9, "angular velocity")
    assert abs(u) > 6 * turn
    on_nut = 1.2 * lead * accel * axis + np.array([0, 0, 1.2 * g])
    same(ds["joint_force"].sel(joint="thread"), -on_nut, 1e-8, "force on the second body, the ground")
    # about the ground's point; the thread's line of action is the axis of the nut
    about = 0.03 * accel * axis + np.cross(lead * u * axis, on_nut)
    same(ds["joint_torque"].sel(joint="thread"), -about, 1e-8, "torque on the ground")


def test_an_offset_decides_where_a_body_without_a_pose_is() -> None:
    tree, draw = train(("revolute", "revolute"), "++", 2.0, 0.5, False)
    q, qd = draw.start(tree, count=4)
    here = motion(tree.mechanism, 0.0, q, qd)
    data = scenario(tree, here)
    b = next(body for body in data["model"]["bodies"] if body["name"] == "b")
    for key in ("position", "rotation", "velocity", "angular_velocity"):
        del b[key]
    _, states = start_of(data)
    index = tree.names.index("b")
    same(states[index, 0:3], here.r[index], 1e-10, "position")
    same(states[index, 3:12].reshape(3, 3), here.R[index], 1e-10, "rotation")
    same(states[index, 12:15], here.v[index], 1e-10, "velocity")
