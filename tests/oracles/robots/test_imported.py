"""What the gallery's imported mechanisms do, against MuJoCo and against equations written down here.

Controllers, friction and contact are programmed anew; MuJoCo has the masses.
"""

from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import lienumba
from tests.rigs.places import SCENARIOS, scripts_on_path

NAMES = ("leg_test", "gripper", "five_bar_leg")
FEW = {"sweep.runs": 12}


@cache
def dataset(name: str, way: str = "joint") -> Any:
    return lienumba.run(SCENARIOS / f"{name}.toml", overrides={**FEW, "integrator.coordinates": way})


def bench(module: str) -> Any:
    """A helper module of the scripts."""
    with scripts_on_path():
        return __import__(f"bench.{module}", fromlist=["*"])


def keys_of(name: str) -> Any:
    return lienumba.System.from_toml(SCENARIOS / f"{name}.toml").to_dict()


@pytest.mark.parametrize("name", NAMES)
def test_runs_to_the_end_in_both_kinds_of_coordinates(name: str) -> None:
    ds, other = dataset(name), dataset(name, "lie")
    assert not ds.status.any()
    assert float(ds.max_position_violation.max()) <= 1e-11
    assert float(ds.energy_residual.max()) < 1e-4
    np.testing.assert_allclose(ds.position, other.position, rtol=0, atol=1e-8)
    np.testing.assert_allclose(ds.rotation, other.rotation, rtol=0, atol=1e-7)


def test_the_leg_has_the_numbers_of_the_quadruped() -> None:
    whole, leg = keys_of("solo12")["model"], keys_of("leg_test")["model"]
    bodies = {body["name"]: body for body in whole["bodies"]}
    joints = {joint["name"]: joint for joint in whole["joints"]}
    for body in leg["bodies"]:
        assert body["mass"] == bodies[body["name"]]["mass"]
        np.testing.assert_allclose(body["inertia"], bodies[body["name"]]["inertia"], rtol=0, atol=1e-13)
    for joint in leg["joints"]:
        np.testing.assert_allclose(joint["points"], joints[joint["name"]]["points"], rtol=0, atol=1e-11)


def step_of_the_foot(t: float) -> tuple[np.ndarray, np.ndarray]:
    """Angles (hip abduction, hip, knee) and their rates: two links of 0.16 m reach for a point of the path."""
    w, s, h = 2 * np.pi / 0.5, 0.14, 0.24
    rise = max(0.0, np.sin(w * t))
    x, z = -0.5 * s * np.cos(w * t), 0.06 * rise**2 - h
    speed = np.array([0.5 * s * w * np.sin(w * t), 0.12 * w * rise * np.cos(w * t)])
    knee = -np.arccos((x * x + z * z) / (2 * 0.16**2) - 1)
    hip = np.arctan2(-x, -z) - np.arctan2(0.16 * np.sin(knee), 0.16 + 0.16 * np.cos(knee))
    both = hip + knee
    upper, lower = -0.16 * np.array([np.cos(hip), -np.sin(hip)]), -0.16 * np.array([np.cos(both), -np.sin(both)])
    return np.array([0, hip, knee]), np.array([0, *np.linalg.solve(np.column_stack([upper + lower, lower]), speed)])


def test_the_leg_against_mujoco() -> None:
    pytest.importorskip("mujoco", reason="mujoco is not installed (extra bench)")
    import mujoco

    tree = bench("robots").Robot("leg_test", 1).tree
    model = mujoco.MjModel.from_xml_string(bench("robot_rivals").mjcf(tree, 1e-3))
    data = mujoco.MjData(model)

    def acceleration(t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        target, rate = step_of_the_foot(t)
        friction = np.array([0, 1, 1]) * (0.01 * v + 0.04 * np.tanh(v / 0.1))
        data.qpos[:], data.qvel[:] = q, v
        data.qfrc_applied[:] = np.clip(5.0 * (target - q) + 0.1 * (rate - v), -2.7, 2.7) - friction
        mujoco.mj_forward(model, data)
        return data.qacc.copy()

    ds, h = dataset("leg_test").isel(run=0), 1e-3
    q, v = step_of_the_foot(0.0)
    for n in range(400):
        t, a = n * h, [np.zeros(3)]
        speeds = []
        for part in (0.0, 0.5, 0.5, 1.0):
            place = q + part * h * (speeds[-1] if speeds else v)
            speeds.append(v + part * h * a[-1])
            a.append(acceleration(t + part * h, place, speeds[-1]))
        q = q + h / 6 * (speeds[0] + 2 * speeds[1] + 2 * speeds[2] + speeds[3])
        v = v + h / 6 * (a[1] + 2 * a[2] + 2 * a[3] + a[4])
    data.qpos[:], data.qvel[:] = q, v
    mujoco.mj_kinematics(model, data)
    then = ds.sel(time=0.4, method="nearest")
    np.testing.assert_allclose(then.position, data.xipos[1:], rtol=0, atol=1e-9)
    torque = 5.0 * (step_of_the_foot(0.4)[0] - q) + 0.1 * (step_of_the_foot(0.4)[1] - v)
    found = [float(then[f"inputs.{name}"]) for name in ("FL_HAA", "FL_HFE", "FL_KFE")]
    np.testing.assert_allclose(found, torque, rtol=0, atol=1e-7)


def test_the_foot_of_the_leg_swings_through_its_step() -> None:
    ds = dataset("leg_test").isel(run=0)
    assert float(ds.miss[0]) < 2e-6  # the point of the foot is rounded
    assert 0.005 < float(ds.miss.max()) < 0.02
    assert float(ds.foot.sel(axis="z").max()) > -0.24 + 0.045


def test_the_gripper_against_its_equations() -> None:
    """Two coordinates: of the fingers, which move as one, and of the block."""
    half, pad = 0.02, 1e4

    def motion(t: float, x: np.ndarray) -> list[float]:
        q, b, v, w = x
        slides = 0.04 - 0.2 * t > 0
        motor = np.clip(2000 * (max(0.04 - 0.2 * t, 0) - q) + 20 * (-0.2 * slides - v), -100, 100)
        gaps = (q + b, v + w), (q - b, v - w)
        left, right = ((pad * (half - gap) - 10 * rate) * (gap < half) for gap, rate in gaps)
        on_fingers = motor + left + right - 2 * (0.3 * v + np.tanh(v / 0.005))
        return [v, w, on_fingers / 0.13, (left - right - np.tanh(w / 0.005)) / 0.2]

    ds = dataset("gripper").isel(run=0)
    times, found = ds.time.values, []
    start = np.array([0.04, 0.01, 0, 0])
    for first, last in ((0.0, 0.2), (0.2, 0.4)):  # the target stops at 0.2 s
        at = times[(times >= first - 1e-9) & (times <= last + 1e-9)].clip(first, last)
        solved = solve_ivp(motion, (first, last), start, "LSODA", at, rtol=1e-9, atol=1e-11, max_step=1e-4)
        start = solved.y[:, -1]
        found.append(solved.y[:2, len(found) :])
    q, b = np.concatenate(found, axis=1)
    np.testing.assert_allclose(ds["fingers.displacement"], q, rtol=0, atol=2e-6)
    np.testing.assert_allclose(ds["block.displacement"], b, rtol=0, atol=2e-6)


def test_the_gripper_holds_what_its_gain_says() -> None:
    """At rest the motor, which wants to the middle, holds both pads: kp q = 2 pad (half - q)."""
    ds = dataset("gripper")
    pad = ds["parameters.pad"]
    kp = 2000 * ds["parameters.gain"]
    np.testing.assert_allclose(ds.grip_final, kp * pad * 0.02 / (kp + 2 * pad), rtol=2e-3)
    assert float(abs(ds["block.displacement"][:, -1]).max()) < 1e-6
    assert 0.1 < float(ds.event_time.min()) < float(ds.event_time.max()) < 0.15


def test_the_five_bar_leg_is_the_file_beside_it() -> None:
    """What was finished by hand moved none of its bodies and joints."""
    pytest.importorskip("mujoco", reason="mujoco is not installed (extra import)")
    from lienumba.importing import from_file

    model, own = from_file(SCENARIOS / "five_bar_leg.xml").to_dict()["model"], keys_of("five_bar_leg")["model"]
    for body, written in zip(model["bodies"], own["bodies"], strict=True):
        np.testing.assert_allclose(written["mass"], body["mass"], rtol=1e-14)
        np.testing.assert_allclose(written["inertia"], body["inertia"], rtol=0, atol=1e-14)
    for joint, written in zip(model["joints"], own["joints"], strict=True):
        assert written["type"] == joint["type"]
        assert written.get("armature") == joint.get("armature")
        np.testing.assert_allclose(written["points"], joint["points"], rtol=0, atol=1e-14)


def test_the_five_bar_leg_against_mujoco() -> None:
    """Its fall, and how it catches itself: the rigid limit of the file that was imported."""
    pytest.importorskip("mujoco", reason="mujoco is not installed (extra import)")
    import mujoco

    reference = bench("importing.reference")

    class OnPad(reference.Reference):  # type: ignore[misc]
        """With the force of the ground and the friction of the hips."""

        def put(self, q: np.ndarray, v: np.ndarray, ctrl: Any = None) -> Any:
            m, d = self.model, self.data
            d.qfrc_applied[:] = 0.0
            super().put(q, v, ctrl)
            foot, J = m.geom("foot").id, np.zeros((3, m.nv))
            place = d.geom_xpos[foot]
            mujoco.mj_jac(m, d, J, None, place, m.geom_bodyid[foot])
            x, _, z = J @ v
            press = 2e4 * max(0.0, 0.015 - place[2]) * max(0.0, 1 - 2 * z)
            d.qfrc_applied[:] = J.T @ [-0.8 * press * np.tanh(x / 0.2), 0, press]
            for name in ("front_hip", "back_hip"):
                at = m.joint(name).dofadr[0]
                d.qfrc_applied[at] -= 0.05 * np.tanh(v[at] / 0.01)
            return super().put(q, v, ctrl)

    own = OnPad(mujoco.MjModel.from_xml_path(str(SCENARIOS / "five_bar_leg.xml")))
    zero = np.zeros((1, own.model.nv))
    times = np.array([0.05, 0.1, 0.15])
    moved = own.motion(reference.States(zero, zero, np.zeros((1, 2))), 2e-4, times)
    places = own.centres(moved)[0]
    ds = dataset("five_bar_leg").isel(run=0).sel(time=times, method="nearest")
    np.testing.assert_allclose(ds.position, places, rtol=0, atol=1e-8)


def test_the_five_bar_leg_flies_on_a_parabola() -> None:
    ds = dataset("five_bar_leg").isel(run=0)
    masses = np.array([body["mass"] for body in keys_of("five_bar_leg")["model"]["bodies"]])
    in_the_air = ds.sel(time=slice(0.6, 0.75))
    assert float(in_the_air.press.max()) == 0.0
    height = in_the_air.position.sel(axis="z").values @ masses / masses.sum()
    np.testing.assert_allclose(np.diff(height, 2), -9.81 * 5e-3**2, rtol=0, atol=1e-9)
    assert 0.07 < float(ds["rail.displacement"].max()) < 0.1
