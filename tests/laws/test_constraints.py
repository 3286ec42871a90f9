"""Joints of the user's own, of positions or velocities, against closed forms, minimal coordinates and built-in ones."""

import copy
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import lienumba
from tests.laws.rigs import FUNCTIONS, close, order, run
from tests.rigs import parts
from tests.rigs.scenarios import PENDULUM, chain

G = 9.81


def joint(function: str, bodies: list[str], name: str = "own", **keys: Any) -> dict[str, Any]:
    return {"name": name, "type": "python", "function": f"{FUNCTIONS}:{function}", "bodies": bodies, **keys}


def scenario(
    bodies: list[dict[str, Any]], joints: list[dict[str, Any]], step: float, end: float, **more: Any
) -> dict[str, Any]:
    return {
        "model": {"bodies": bodies, "joints": joints, **more},
        "integrator": {"step": step, "end_time": end},
        "output": {"every": end / 10, "also": ["multiplier"]},
    }


# ---------------------------------------------------------------- a rolling disc
MASS, RADIUS, ACROSS, ALONG = 1.2, 0.5, 0.08, 0.15  # ALONG: its inertia about its axis
LEAN, CIRCLE = 0.3, 1.5  # from the vertical (rad), and the radius on which its mass centre goes round
# Steady, W about the vertical: with the axis n = (cos, 0, sin) the contact is at rest where the spin about it is
# -W (CIRCLE + RADIUS sin)/RADIUS, so w.n = -W CIRCLE/RADIUS; W x H is the moment of the ground's force.
ROUND = np.sqrt(
    MASS * G * RADIUS * np.sin(LEAN)
    / (np.cos(LEAN) * ((ALONG / RADIUS + MASS * RADIUS) * CIRCLE + ACROSS * np.sin(LEAN)))
)  # fmt: skip


def disc(spin: list[float], step: float, end: float, **more: Any) -> dict[str, Any]:
    body = parts.body("disc", MASS, [ACROSS, ACROSS, ALONG], angular_velocity=spin)
    body |= {"position": [CIRCLE, 0, RADIUS * np.cos(LEAN)], "rotation": {"axis": [0, 1, 0], "angle": np.pi / 2 - LEAN}}
    return scenario([body], [joint("rolling", ["disc"], level="velocity", parameters={"radius": RADIUS})], step, end,
                    **more)  # fmt: skip


STEADY = [-ROUND * np.cos(LEAN), 0, -ROUND * CIRCLE / RADIUS]


def test_a_disc_rolls_around_a_circle():
    period = 2 * np.pi / ROUND
    ds = run(disc(STEADY, period / 2000, period)).isel(run=0)
    r, n = ds.position.values[:, 0], ds.rotation.values[:, 0, :, 2]
    t = ds.time.values
    np.testing.assert_allclose(r[:, 0], CIRCLE * np.cos(ROUND * t), rtol=0, atol=1e-8)
    np.testing.assert_allclose(r[:, 1], CIRCLE * np.sin(ROUND * t), rtol=0, atol=1e-8)
    np.testing.assert_allclose(r[:, 2], RADIUS * np.cos(LEAN), rtol=0, atol=1e-9)
    np.testing.assert_allclose(n[:, 2], np.sin(LEAN), rtol=0, atol=1e-9)
    outward = np.stack([np.cos(ROUND * t), np.sin(ROUND * t), 0 * t], axis=1)
    push = -MASS * ROUND**2 * CIRCLE * outward + [0, 0, MASS * G]
    np.testing.assert_allclose(ds.joint_force[:, 0], push, rtol=0, atol=1e-6)
    np.testing.assert_allclose(np.abs(ds.multiplier), np.abs(push), rtol=0, atol=1e-6)


def test_a_disc_that_wobbles_keeps_its_energy_and_its_height():
    """The ground does no work; and the height, which no equation holds, follows from the rolling."""
    spin = [0.4, -0.7, -6.0]
    drifts, gaps = [], []
    for step in (0.01, 0.005):
        ds = run(disc(spin, step, 2.0)).isel(run=0)
        drifts.append(float(np.abs(ds.energy_residual).max()))
        lean = ds.rotation.values[:, 0, 2, 2]
        gaps.append(np.abs(ds.position[:, 0, 2].values - RADIUS * np.sqrt(1 - lean**2)).max())
        assert float(ds.max_velocity_violation) < 1e-10
    assert np.ptp(lean) > 0.02
    assert order(drifts) > 3.7, drifts
    assert order(gaps) > 3.7, gaps
    assert not ds.work.any()


# ---------------------------------------------------------------- a knife edge
def sleigh(step: float, end: float) -> dict[str, Any]:
    body = parts.body("sleigh", 2.0, [0.2, 0.2, 0.3], position=[0.4, 0, 0], rotation=[1, 0, 0, 0])
    body |= {"angular_velocity": [0, 0, 3.0], "velocity": [-1.0, 0.4 * 3.0, 0]}
    plane = parts.joint("ice", "planar", "sleigh", at=[0, 0, 0], axis=[0, 0, 1])
    return scenario(
        [body], [plane, joint("knife", ["sleigh"], level="velocity", parameters={"behind": 0.4})], step, end
    )


def test_a_sleigh_turns_around_and_goes_straight():
    """Chaplygin's: u' = a w^2, w' = -u w a/k^2, so u = c tanh, w = c/k sech; it begins backwards, and ends forwards."""
    m, inertia, a, u0, w0 = 2.0, 0.3, 0.4, -1.0, 3.0
    k = np.sqrt((inertia + m * a * a) / m)
    c = np.hypot(u0, k * w0)
    errors = []
    for step in (0.01, 0.005):
        ds = run(sleigh(step, 1.5)).isel(run=0)
        tau = np.arctanh(u0 / c) + a * c / k**2 * ds.time.values
        u, w = c * np.tanh(tau), c / k / np.cosh(tau)
        turned = k / a * 2 * (np.arctan(np.tanh(tau / 2)) - np.arctan(np.tanh(tau[0] / 2)))
        R = ds.rotation.values[:, 0]
        ahead = np.einsum("tij,ti->tj", R, ds.velocity.values[:, 0])  # along the body's axes
        found = np.stack([ahead[:, 0], ahead[:, 1], ds.angular_velocity.values[:, 0, 2], R[:, 1, 0], R[:, 0, 0]])
        errors.append(np.abs(found - np.stack([u, a * w, w, np.sin(turned), np.cos(turned)])).max())
    assert u[-1] > 0.9 * c
    assert order(errors) == pytest.approx([4], abs=0.2), errors
    assert errors[-1] < 1e-6
    blade = ds.multiplier.sel(constraint=[str(x) for x in ds.constraint.values if "own" in str(x)])
    side = m * (u * w + a * (-u * w * a / k**2))  # what pushes the mass centre sideways
    np.testing.assert_allclose(np.abs(blade[:, 0]), np.abs(side), rtol=0, atol=1e-5)
    np.testing.assert_allclose(np.hypot(*ds.joint_force[:, 1, :2].T), np.abs(side), rtol=0, atol=1e-5)


# ---------------------------------------------------------------- a cam
E, SUM, M_CAM, J_CAM, M_F = 0.1, 0.35, 1.5, 0.05, 0.6


def cam(step: float, end: float, **follower: Any) -> dict[str, Any]:
    bodies = [
        parts.body("cam", M_CAM, J_CAM),
        parts.body("follower", M_F, 0.01, rotation=[1, 0, 0, 0], **follower),
    ]
    shaft = parts.pivot("shaft", "cam", second=[0, 0, -E], angle=1.0, rate=8.0)
    guide = parts.joint("guide", "prismatic", "follower", points=[[0, 0, 0]] * 2, axes=[[0, 0, 1]] * 2)
    contact = joint("roller", ["cam", "follower"], name="contact", parameters={"distance": SUM})
    return scenario(bodies, [shaft, guide, contact], step, end)


def lift(q: Any) -> tuple[Any, Any, Any]:
    """The height of the follower, its slope and its curvature."""
    root = np.sqrt(SUM**2 - (E * np.sin(q)) ** 2)
    z = E * np.cos(q) + root
    slope = -E * np.sin(q) - E**2 * np.sin(q) * np.cos(q) / root
    bend = -E * np.cos(q) - E**2 * np.cos(2 * q) / root - (E**2 * np.sin(q) * np.cos(q)) ** 2 / root**3
    return z, slope, bend


def cam_acceleration(q: Any, dq: Any) -> Any:
    _, slope, bend = lift(q)
    inertia = J_CAM + M_CAM * E**2 + M_F * slope**2
    return (M_CAM * G * E * np.sin(q) - M_F * G * slope - M_F * slope * bend * dq**2) / inertia


def test_a_follower_on_a_cam_against_one_coordinate():
    """Where it stands and how fast it goes is solved for; what presses the two together is the multiplier."""
    errors = []
    for step in (0.01, 0.005):
        ds = run(cam(step, 1.0, guess={"position": [0, 0, 0.4]})).isel(run=0)
        t = ds.time.values
        q, dq = solve_ivp(lambda t, y: [y[1], cam_acceleration(*y)], (0, 1), [1.0, 8.0], "DOP853", t_eval=t, rtol=1e-12,
                          atol=1e-12).y  # fmt: skip
        z, slope, bend = lift(q)
        found = np.stack([ds.position[:, 1, 2], ds.velocity[:, 1, 2], ds.angular_velocity[:, 0, 1]])
        errors.append(np.abs(found - [z, slope * dq, dq]).max())
        np.testing.assert_allclose(found[:, 0], [z[0], slope[0] * 8, 8], rtol=0, atol=1e-10)
    assert order(errors) == pytest.approx([4], abs=0.25), errors
    press = M_F * (G + slope * cam_acceleration(q, dq) + bend * dq**2) / ((z - E * np.cos(q)) / SUM)
    contact = ds.isel(joint=2).joint_force
    np.testing.assert_allclose(contact[:, 2], press * (z - E * np.cos(q)) / SUM, rtol=0, atol=2e-4)
    np.testing.assert_allclose(contact[:, 0], -press * E * np.sin(q) / SUM, rtol=0, atol=2e-4)
    assert float(ds.max_position_violation) < 1e-11
    assert np.abs(ds.energy_residual).max() < 1e-4


def test_its_numbers_can_be_swept():
    """Every run begins where its own numbers have it."""
    swept = parts.sweep(5, {"joints.contact.parameters.distance": (0.3, 0.4)}, seed=1)
    data = cam(0.005, 0.2, guess={"position": [0, 0, 0.4]}) | {"sweep": swept}
    ds = run(data)
    for n in range(5):
        distance = float(ds["joints.contact.parameters.distance"][n])
        apart = ds.position[n, :, 1].values - ds.position[n, :, 0].values
        np.testing.assert_allclose(np.linalg.norm(apart, axis=1), distance, rtol=0, atol=1e-11)
        one = cam(0.005, 0.2, guess={"position": [0, 0, 0.4]})
        one["model"]["joints"][2]["parameters"]["distance"] = distance
        np.testing.assert_allclose(run(one).position[0], ds.position[n], rtol=0, atol=1e-13)


# ---------------------------------------------------------------- built-in joints
MOTION = ("position", "rotation", "velocity", "angular_velocity", "energy")
BALL = joint("ball", ["link0", "link1"], name="hinge1", parameters={"reach": 0.2})


def links(number: int, **change: Any) -> dict[str, Any]:
    """A chain whose second joint is a function, or another joint."""
    model = copy.deepcopy(chain(number)["model"])
    for n, new in change.items():
        model["joints"][int(n.removeprefix("joint"))] = new
    return scenario(model["bodies"], model["joints"], 1e-3, 0.1)


@pytest.mark.parametrize("number", [2, 6])
def test_a_ball_of_ones_own_is_the_spherical_joint(number):
    """Bodies, multipliers and violations; also in a mechanism that is stepped stage by stage. The initial positions
    follow from the function."""
    built_in, written = run(links(number)), run(links(number, joint1=BALL))
    close(written, built_in, *MOTION, "joint_force", atol=1e-9)
    np.testing.assert_allclose(np.abs(written.multiplier), np.abs(built_in.multiplier), rtol=0, atol=1e-9)
    R, at = built_in.rotation.values[0, :, 1], np.array([0.02, 0, 0.2])
    lever = np.cross(R @ at, built_in.joint_force.values[0, :, 1])  # about the mass centre, for it has no point
    np.testing.assert_allclose(written.joint_torque[0, :, 1], lever, rtol=0, atol=1e-9)


@pytest.mark.parametrize("rows", [["m", "rad"], None])
def test_rows_have_units(rows):
    """An equation of an angle and one of a length: the same as two built-in joints."""
    hinge, height = chain(2)["model"]["joints"][0], 0.05
    keys = {"bodies": ["link0", "link1"]}
    plane = {"name": "pin", "type": "point_in_plane", "points": [[0, 0, height], [0.1, 0, 0.2]], "axes": [[0, 0, 1]]}
    square = {"name": "square", "type": "perpendicular_axes", "axes": [[0, 0, 1], [1, 0, 0]]}
    bodies = copy.deepcopy(chain(2)["model"]["bodies"])
    del bodies[1]["angular_velocity"]
    bodies[1] |= {"guess": {"position": [0.1, 0, -0.4], "rotation": bodies[1].pop("rotation")}}
    own = joint("pin_in_plane", ["link0", "link1"], parameters={"height": height}, **({"rows": rows} if rows else {}))
    a = run(scenario(bodies, [hinge, keys | plane, keys | square], 1e-3, 0.05))
    for n, body in enumerate(bodies):
        body.pop("guess", None)
        for name in ("position", "rotation", "velocity", "angular_velocity"):
            body[name] = a[name].values[0, 0, n]
    b = run(scenario(bodies, [hinge, own], 1e-3, 0.05))
    if rows is not None:
        close(b, a, *MOTION, "max_position_violation", atol=1e-8)
        np.testing.assert_allclose(np.abs(b.multiplier), np.abs(a.multiplier), rtol=0, atol=1e-6)
    else:
        up, across = b.rotation.values[0, :, 0, :, 2], b.rotation.values[0, :, 1, :, 0]
        np.testing.assert_allclose((up * across).sum(axis=-1), 0, atol=1e-11)


def double(extra: dict[str, Any]) -> dict[str, Any]:
    model = copy.deepcopy(PENDULUM["model"])
    return scenario(model["bodies"], [*model["joints"], extra], 1e-3, 0.2)


def test_a_joint_that_says_again_what_a_built_in_one_says():
    """Of positions: as many rows of the two are used as are independent; the motion is the same."""
    again = BALL | {"name": "again", "parameters": {"reach": 0.2}}
    data = links(2)
    free = run(data)
    data["model"]["joints"].append(again)
    ds = run(data)
    close(ds, free, *MOTION, atol=1e-9)
    both = ds.joint_force[0, :, 1] + ds.joint_force[0, :, 2].values
    np.testing.assert_allclose(both, free.joint_force[0, :, 1], rtol=0, atol=1e-8)


def test_a_velocity_that_a_built_in_joint_forbids_already():
    data = sleigh(0.01, 0.5)
    free = run(data)
    data["model"]["joints"].append(joint("no_lift", ["sleigh"], name="flat", level="velocity"))
    ds = run(data)
    close(ds, free, *MOTION, atol=1e-10)
    assert float(ds.joint_force[0, -1, 0, 2] + ds.joint_force[0, -1, 2, 2]) == pytest.approx(2 * G)


def test_a_velocity_that_positions_and_the_time_decide():
    """A belt whose speed follows a quantity: what it does is accounted for as work."""
    bodies = [
        parts.body("rod", rotation=[1, 0, 0, 0], angular_velocity=[0, 2, 0]),
        parts.body("block", 2, position=[1, 0, 0], rotation=[1, 0, 0, 0]),
    ]
    joints = [
        parts.joint("hinge", "revolute", "rod", points=[[0, 0, 0], [0, 0, 0.5]], axes=[[0, 1, 0]] * 2),
        parts.joint("rail", "prismatic", "block", points=[[0, 0, 0]] * 2, axes=[[1, 0, 0]] * 2),
        joint("belt", ["rod", "block"], level="velocity", parameters={"ratio": 0.7}),
    ]
    quantities = [{"name": "pointing", "type": "rotation_error", "body": "rod"}]
    residuals = []
    for step in (0.01, 0.005):
        ds = run(scenario(bodies, joints, step, 1.0) | {"quantities": quantities}).isel(run=0)
        speed = 0.7 * ds.pointing.values[:, 1] + 0.1 * np.sin(3 * ds.time.values)
        np.testing.assert_allclose(ds.velocity[:, 1, 0], speed, rtol=0, atol=1e-10)
        residuals.append(float(np.abs(ds.energy_residual).max()))
    assert np.ptp(speed) > 0.1
    assert np.abs(ds.work).max() > 1e-3
    assert order(residuals) > 3.7, residuals


TIE = """
def tie(first, second, *, a, b, c):
    x = first.angle
    return second.angle - (a + b * x + c * x * x)
"""


@pytest.mark.parametrize("coordinates", ["lie", "joint"])
def test_a_constraint_of_angles_counts_their_turns(coordinates):
    """Two pendulums of which one follows the other by a polynomial: Lagrange's equation of the one angle."""
    a, b, c, reach, g = 0.1, 0.5, 0.3, 0.3, 9.81
    bodies = [parts.body(name, 1.0, [0.1, 0.2, 0.3]) for name in "ab"]
    joints = [parts.pivot(name, "ab"[n], [n, 0, 0], [0, 0, -reach]) for n, name in enumerate(("first", "second"))]
    joints[0] |= {"angle": 0.5, "rate": 1.0}
    law = {"type": "python", "function": "laws.py:tie", "joints": ["first", "second"], "rows": ["rad"]}
    joints.append({"name": "tie", **law, "parameters": {"a": a, "b": b, "c": c}})
    ds = lienumba.run(
        {
            "files": {"laws.py": TIE},
            "model": {"bodies": bodies, "joints": joints},
            "quantities": parts.observed("joint", "first", "second"),
            "integrator": {"step": 1e-3, "end_time": 2.0, "coordinates": coordinates},
        }
    )
    inertia = 0.2 + reach**2

    def flow(t, y):
        x, rate = y
        follower, slope = a + b * x + c * x * x, b + 2 * c * x
        torque = g * reach * (np.sin(x) + np.sin(follower) * slope) - inertia * slope * 2 * c * rate**2
        return rate, torque / (inertia * (1 + slope**2))

    expected = solve_ivp(flow, (0, 2), (0.5, 1.0), "DOP853", ds.time.values, rtol=1e-12, atol=1e-12).y[0]
    assert expected[-1] > np.pi
    np.testing.assert_allclose(ds["first.angle"].values[0], expected, atol=2e-8)
    np.testing.assert_allclose(ds["second.angle"].values[0], a + b * expected + c * expected**2, atol=1e-7)
