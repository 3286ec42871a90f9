"""Angles over many turns: springs, drivers, gears and screws count them, each run for itself."""

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

import lienumba
from lienumba.batch import statuses
from lienumba.integrators.tracing import step_kernels
from tests.rigs.scenarios import scenario, simulate

AXIS = np.array([2.0, -3.0, 6.0]) / 7.0  # of every hinge here, global
INERTIA = [0.5, 0.6, 0.7, 0.01, -0.02, 0.03]
ABOUT = float(AXIS @ np.array([[0.5, 0.01, -0.02], [0.01, 0.6, 0.03], [-0.02, 0.03, 0.7]]) @ AXIS)  # kg m^2
TURN = 2.0 * np.pi


def wheel(name: str, ahead: float = 0.0) -> dict[str, Any]:
    """A body whose mass centre lies on the axis."""
    return {"name": name, "mass": 2.0, "inertia": INERTIA, "position": list(ahead * AXIS), "rotation": [1, 0, 0, 0]}


def hinge(name: str, first: str, second: str, **says: Any) -> dict[str, Any]:
    return {"name": name, "type": "revolute", "bodies": [first, second], "at": [0, 0, 0], "axis": list(AXIS), **says}


def spinner(*forces: dict[str, Any], drivers: tuple[dict[str, Any], ...] = (), **says: Any) -> dict[str, Any]:
    """One wheel on the ground."""
    joints = [hinge("hinge", "ground", "wheel", **says)]
    return {"model": {"bodies": [wheel("wheel")], "joints": joints, "forces": list(forces), "drivers": list(drivers)}}


def turned(dataset: Any, body: str = "wheel", since: str | None = None) -> tuple[np.ndarray, np.ndarray]:
    """The rotation about the axis in (-pi, pi] and its rate at every output, of a body, or relative to another one."""
    R, w = dataset["rotation"].sel(body=body).values, dataset["angular_velocity"].sel(body=body).values @ AXIS
    if since is not None:
        base, rate = (
            dataset["rotation"].sel(body=since).values,
            dataset["angular_velocity"].sel(body=since).values @ AXIS,
        )
        R, w = base.transpose(0, 2, 1) @ R, w - rate
    return Rotation.from_matrix(R).as_rotvec() @ AXIS, w


def check(found: tuple[np.ndarray, np.ndarray], angle: np.ndarray, rate: np.ndarray, bound: float) -> None:
    """The same rotation and rate; the angle goes more than three turns to one side at least."""
    assert np.abs(angle).max() > 3 * TURN
    assert np.abs(np.exp(1j * found[0]) - np.exp(1j * angle)).max() < bound
    assert np.abs(found[1] - rate).max() < bound * max(1.0, np.abs(rate).max())


STEPPING = pytest.mark.parametrize("inline", [10**9, 0], ids=["in one kernel", "stage by stage"])


@STEPPING
@pytest.mark.parametrize(("angle", "free"), [(0.0, 0.0), (50.0, 30.0), (-7.0, 4.5 * TURN)])
def test_a_torsion_spring_swings_over_many_turns(
    angle: float, free: float, inline: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """There and back again, harmonically, from whatever turn the start says."""
    monkeypatch.setattr(step_kernels, "INLINE", inline)
    spring = {"type": "torsion_spring", "joint": "hinge", "stiffness": 2.0, "free_angle": free}
    here = simulate(spinner(spring, angle=angle, rate=60.0), 2e-3, 5.0, output={"every": 0.05})
    t, omega = here["time"].values, np.sqrt(2.0 / ABOUT)
    x = free + (angle - free) * np.cos(omega * t) + 60.0 / omega * np.sin(omega * t)
    rate = -(angle - free) * omega * np.sin(omega * t) + 60.0 * np.cos(omega * t)
    assert np.abs(x - angle).max() > 3 * TURN
    check(turned(here), x - angle, rate, 1e-7)
    np.testing.assert_allclose(here["potential_energy"], (x - free) ** 2, rtol=0, atol=1e-4)
    assert float(here["max_energy_drift"]) < 1e-6 * float(here["energy"][0])
    assert (here["work"] == 0).all()


def test_between_two_bodies_that_both_turn() -> None:
    """Only the relative angle counts: with equal wheels it swings, while both go on turning."""
    spring = {"type": "torsion_spring", "joint": "between", "stiffness": 1.5}
    joints = [hinge("base", "ground", "first", rate=20.0), hinge("between", "first", "second", rate=45.0)]
    mechanism = {"model": {"bodies": [wheel("first"), wheel("second", 0.3)], "joints": joints, "forces": [spring]}}
    here = simulate(mechanism, 1e-3, 3.0, output={"every": 0.05})
    t, omega = here["time"].values, np.sqrt(2 * 1.5 / ABOUT)
    check(turned(here, "second", "first"), 45 / omega * np.sin(omega * t), 45 * np.cos(omega * t), 1e-7)
    middle = 42.5 * t  # momentum
    check(turned(here, "first"), middle - 22.5 / omega * np.sin(omega * t), 42.5 - 22.5 * np.cos(omega * t), 1e-7)


@STEPPING
def test_a_driven_angle_goes_where_it_is_told(inline: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Six turns forth, and back: the driver knows the turns, whichever way it came."""
    monkeypatch.setattr(step_kernels, "INLINE", inline)
    driver = {"name": "motor", "joint": "hinge", "value": "40*sin(t) + 0.5*t**2"}
    here = simulate(spinner(drivers=(driver,)), 2e-3, 5.0, output={"every": 0.05})
    t = here["time"].values
    check(turned(here), 40 * np.sin(t) + 0.5 * t**2, 40 * np.cos(t) + t, 1e-11)
    np.testing.assert_allclose(here["driver_effort"].values[:, 0], ABOUT * (1 - 40 * np.sin(t)), rtol=0, atol=1e-9)
    assert here["effort"].values.tolist() == ["motor"]
    gained = 0.5 * ABOUT * ((40 * np.cos(t) + t) ** 2 - 1600)
    np.testing.assert_allclose(here["work"], gained, rtol=0, atol=1e-8)


def test_a_driver_that_starts_in_another_turn() -> None:
    """A value of 100 rad at the start is 100 rad, not what is left of it."""
    spring = {"type": "torsion_spring", "joint": "hinge", "stiffness": 3.0, "free_angle": 90.0}
    driver = {"name": "motor", "joint": "hinge", "value": "100 - 5*t"}
    here = simulate(spinner(spring, drivers=(driver,)), 5e-3, 4.0, output={"every": 0.5})
    t = here["time"].values
    np.testing.assert_allclose(here["driver_effort"].values[:, 0], 3 * (10 - 5 * t), rtol=0, atol=1e-9)
    np.testing.assert_allclose(here["potential_energy"], 1.5 * (10 - 5 * t) ** 2, rtol=0, atol=1e-9)


def test_an_actuator_winds_up_to_its_target() -> None:
    """A controller that wants 4.3 turns gets them; SciPy integrates the angle as a number."""
    stiffness, damping, target = 3.0, 1.2, 27.0
    motor = {
        "type": "actuator",
        "joint": "hinge",
        "stiffness": stiffness,
        "damping": damping,
        "target": target,
        "limit": 9,
    }
    here = simulate(spinner(motor), 1e-3, 12.0, output={"every": 0.1})

    def rate(_: float, y: np.ndarray) -> list[float]:
        return [y[1], np.clip(stiffness * (target - y[0]) - damping * y[1], -9.0, 9.0) / ABOUT]

    t = here["time"].values
    there = solve_ivp(rate, (0, 12), [0, 0], "DOP853", t_eval=t, rtol=1e-12, atol=1e-12, max_step=1e-2).y
    check(turned(here), there[0], there[1], 1e-4)  # the limit has kinks
    assert abs(there[0, -1] - target) < 0.05


@STEPPING
def test_a_gear_keeps_its_ratio_over_many_turns(inline: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Every turn of the one is 2.4 of the other, backwards; the ratio is no whole number, so that each turn matters."""
    monkeypatch.setattr(step_kernels, "INLINE", inline)
    joints = [hinge("slow", "ground", "first", rate=12.0), hinge("fast", "ground", "second")]
    joints.append({"name": "gear", "type": "gear", "joints": ["slow", "fast"], "ratio": -2.4})
    spring = {"type": "torsion_spring", "joint": "slow", "stiffness": 0.8}
    mechanism = {"model": {"bodies": [wheel("first"), wheel("second", 0.3)], "joints": joints, "forces": [spring]}}
    here = simulate(mechanism, 2e-3, 10.0, output={"every": 0.1})
    t, omega = here["time"].values, np.sqrt(0.8 / (ABOUT * (1 + 2.4**2)))
    angle, rate = 12 / omega * np.sin(omega * t), 12 * np.cos(omega * t)
    check(turned(here, "first"), angle, rate, 1e-7)
    check(turned(here, "second"), -2.4 * angle, -2.4 * rate, 1e-7)
    assert float(here["max_position_violation"]) < 1e-10


def test_a_screw_advances_by_its_pitch_with_every_turn() -> None:
    """Its own weight turns it down: m g p / (2 pi) = (J + m (p / 2 pi)^2) times the angular acceleration."""
    pitch, mass = 0.25, 2.0
    joint = {"name": "screw", "type": "screw", "bodies": ["ground", "nut"], "at": [0, 0, 0], "axis": [0, 0, 1]}
    nut = {"name": "nut", "mass": mass, "inertia": [0.02, 0.02, 0.03], "position": [0, 0, 0], "rotation": [1, 0, 0, 0]}
    mechanism = {"model": {"bodies": [nut], "joints": [{**joint, "pitch": pitch}]}}
    here = simulate(mechanism, 2e-3, 2.0, output={"every": 0.02})
    per_radian = pitch / TURN
    angle = -0.5 * here["time"].values ** 2 * mass * 9.81 * per_radian / (0.03 + mass * per_radian**2)
    assert angle.min() < -6 * TURN
    np.testing.assert_allclose(here["position"].sel(body="nut", axis="z"), per_radian * angle, rtol=0, atol=1e-9)
    phase = Rotation.from_matrix(here["rotation"].sel(body="nut").values).as_rotvec()[:, 2]
    assert np.abs(np.exp(1j * phase) - np.exp(1j * angle)).max() < 1e-7


def test_every_run_counts_its_own_turns() -> None:
    """Neighbours in one block go to opposite sides, by different numbers of turns."""
    spring = {"type": "torsion_spring", "joint": "hinge", "stiffness": 2.0}
    data = scenario(spinner(spring, rate=1.0), 2e-3, 3.0)
    data["sweep"] = {"runs": 20, "vary": {"joints.hinge.rate": {"distribution": "uniform", "low": -90, "high": 90}}}
    here = lienumba.run(data, workers=1)
    rates, omega = here["joints.hinge.rate"].values, np.sqrt(2.0 / ABOUT)
    ends = rates / omega * np.sin(omega * 3.0)
    turns = np.round(ends / TURN)
    assert len(set(turns)) > 6
    np.testing.assert_allclose(here["potential_energy"][:, -1], ends**2, rtol=1e-6)
    np.testing.assert_allclose(here["angular_velocity"].values[:, -1, 0] @ AXIS, rates * np.cos(omega * 3.0), rtol=1e-6)


@pytest.mark.parametrize("rate", [2500.0, -3000.0, 3500.0, -5000.0])
def test_a_step_of_more_than_half_a_turn_is_counted_right_or_refused(rate: float) -> None:
    """At 1 ms; a spring too soft to matter but for its energy."""
    spring = {"type": "torsion_spring", "joint": "hinge", "stiffness": 1e-6}
    data = scenario(spinner(spring, rate=rate), 1e-3, 0.05, output={"every": 0.01})
    here = lienumba.run(data, workers=1).isel(run=0)
    if int(here["status"]) == statuses.SUCCESS:
        np.testing.assert_allclose(here["potential_energy"], 0.5e-6 * (rate * here["time"]) ** 2, rtol=1e-4, atol=1e-12)
    else:
        assert int(here["status"]) == statuses.ROTATION
