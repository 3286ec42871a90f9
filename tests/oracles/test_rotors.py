"""Rotors of joints in whole runs: a physical pendulum, a wheel behind a gear, a loop, a sweep, MuJoCo."""

import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import lienumba
from tests.facade import ScenarioError

SCENARIOS = Path(__file__).parents[2] / "scenarios"
N_FOUR_BAR = SCENARIOS / "n_four_bar.toml"
EXACT = {"method": "dop853", "step": 0.005, "end_time": 1.0}


def run(model: dict[str, Any], **more: Any) -> Any:
    ds = lienumba.run({"model": model, "integrator": EXACT} | more)
    assert (ds["status"] == 0).all()
    return ds


def link(name: str, position: list[float], inertia: float = 0.02) -> dict[str, Any]:
    return {"name": name, "mass": 1.2, "inertia": [0.01, inertia, 0.03], "position": position}


def hinge(name: str, bodies: list[str], at: list[float], **more: Any) -> dict[str, Any]:
    return {"name": name, "type": "revolute", "bodies": bodies, "at": at, "axis": [0, 1, 0], **more}


def test_a_pendulum_with_a_rotor_is_one_of_more_inertia() -> None:
    base = hinge("base", ["ground", "a"], [0, 0, 0], rate=1.5)
    rotor = run({"bodies": [link("a", [0.4, 0, -0.2])], "joints": [base | {"armature": 0.02}]})
    heavy = run({"bodies": [link("a", [0.4, 0, -0.2], 0.04)], "joints": [base]})
    for name in ("position", "angular_velocity", "joint_force", "kinetic_energy", "potential_energy"):
        np.testing.assert_allclose(rotor[name], heavy[name], atol=1e-13)


@pytest.mark.parametrize("ratio", [-7.0, 12.0])
def test_in_a_plane_a_rotor_is_a_wheel_behind_a_gear(ratio: float) -> None:
    """At the base of an arm of two links; the inertia is felt with the square of the gear."""
    bodies = [link("a", [0.3, 0, 0]), link("b", [0.6, 0, -0.3])]
    base, elbow = hinge("base", ["ground", "a"], [0, 0, 0], rate=-1.0), hinge("elbow", ["a", "b"], [0.6, 0, 0])
    rotor = run({"bodies": bodies, "joints": [base | {"armature": 2e-4 * ratio**2}, elbow]})
    wheel = {"name": "wheel", "mass": 0.1, "inertia": [2e-4, 2e-4, 2e-4], "position": [0, 0, 0]}
    bearing = hinge("bearing", ["ground", "wheel"], [0, 0, 0])
    gear = {"name": "gear", "type": "gear", "joints": ["base", "bearing"], "ratio": ratio}
    geared = run({"bodies": [*bodies, wheel], "joints": [base, elbow, bearing, gear]})
    for name in ("position", "velocity", "rotation"):
        np.testing.assert_allclose(rotor[name], geared[name].isel(body=slice(0, 2)), atol=1e-11)
    np.testing.assert_allclose(rotor["kinetic_energy"], geared["kinetic_energy"], atol=1e-11)
    still = run({"bodies": bodies, "joints": [base, elbow]})
    assert float(np.abs(still["position"] - rotor["position"]).max()) > 1e-3


def test_a_loop_with_rotors_keeps_the_energy_of_bodies_and_rotors() -> None:
    """A planar four-bar has one freedom, so that its energy says all; rotors at a bearing and between two bodies."""
    rotors = {"model.joints.crank_bearing.armature": 0.4, "model.joints.crank_end.armature": 0.9}
    change = {**rotors, "integrator": {"method": "dop853", "step": 2.5e-3, "end_time": 1.0}}
    ds = lienumba.run(SCENARIOS / "four_bar.toml", overrides=change).isel(run=0)
    assert int(ds["status"]) == 0
    w = ds["angular_velocity"][:, :, 2]
    mass = np.array([2.0, 1.0, 1.0])
    J = np.array([0.015, 0.08333333, 0.0867])
    kinetic = 0.5 * ((mass * (ds["velocity"] ** 2).sum("axis")).sum("body") + (J * w**2).sum("body"))
    kinetic = kinetic + 0.2 * w[:, 0] ** 2 + 0.45 * (w[:, 1] - w[:, 0]) ** 2
    np.testing.assert_allclose(ds["kinetic_energy"], kinetic, rtol=1e-12)
    energy = kinetic + 9.81 * (mass * ds["position"][:, :, 1]).sum("body")
    np.testing.assert_allclose(energy, energy[0], rtol=1e-9)
    assert float(w.std()) > 1.0


@pytest.mark.parametrize("inertia", [1e-9, 1e-3, 10.0])
def test_a_loop_passes_singular_positions_with_rotors_of_any_weight(inertia: float) -> None:
    joints = tomllib.loads(N_FOUR_BAR.read_text())["model"]["joints"]
    change = {f"model.joints.{x['name']}.armature": inertia for x in joints if x["type"] == "revolute"}
    ds = lienumba.run(N_FOUR_BAR, overrides=change).isel(run=0)
    assert int(ds["status"]) == 0
    assert float(abs(ds["energy_residual"]).max()) < 1e-6 * float(ds["kinetic_energy"].max())


def test_runs_of_a_sweep_have_rotors_of_their_own_also_none() -> None:
    vary = {"joints.base.armature": {"distribution": "uniform", "low": 0.0, "high": 0.5}}
    base = hinge("base", ["ground", "a"], [0, 0, 0], rate=1.5, armature=0.1)
    model = {"bodies": [link("a", [0.4, 0, -0.2])], "joints": [base]}
    swept = run(model, sweep={"runs": 3, "vary": vary})
    drawn = swept["joints.base.armature"]
    assert drawn.attrs["units"] == "kg m2"
    for n in range(3):
        alone = run(model | {"joints": [base | {"armature": float(drawn[n])}]})
        np.testing.assert_array_equal(swept["position"][n], alone["position"][0])
    none = run(model, sweep={"runs": 2, "vary": {"joints.base.armature": {"distribution": "constant", "value": 0.0}}})
    without = run(model | {"joints": [base | {"armature": 0.0}]})
    np.testing.assert_allclose(none["position"][0], without["position"][0], atol=1e-14)


def test_momentum_is_that_of_the_bodies_and_stays() -> None:
    """A rotor pushes both bodies of its joint against each other."""
    two = [link("a", [0, 0, 0]) | {"velocity": [0.3, 0, 0]}, link("b", [0.8, 0, 0.1])]
    model = {
        "gravity": [0, 0, 0],
        "bodies": two,
        "joints": [hinge("hinge", ["a", "b"], [0.4, 0, 0], rate=4.0, armature=0.6)],
        "quantities": [{"name": "momentum", "type": "momentum"}],
    }
    model_, quantities = {k: x for k, x in model.items() if k != "quantities"}, model["quantities"]
    ds = run(model_, quantities=quantities)
    for name in ("momentum.linear", "momentum.angular"):
        np.testing.assert_allclose(ds[name], np.broadcast_to(ds[name][:, :1], ds[name].shape), atol=1e-11)


@pytest.mark.parametrize(
    ("joint", "message"),
    [
        (
            {"armature": -0.1},
            r"model\.joints\.base\.armature = -0\.1: must be at least 0; give the inertia in kg m\^2 of",
        ),
        ({"armature": "heavy"}, r"model\.joints\.base\.armature"),
        ({"type": "spherical", "armature": 0.1}, r"model\.joints\.base\.armature has no meaning for a spherical joint"),
    ],
)
def test_what_is_no_rotor_is_told(joint: dict[str, Any], message: str) -> None:
    base = hinge("base", ["ground", "a"], [0, 0, 0]) | joint
    if base["type"] == "spherical":
        del base["axis"]
    with pytest.raises(ScenarioError, match=message):
        run({"bodies": [link("a", [0.4, 0, -0.2])], "joints": [base]})


def test_a_sweep_below_zero_is_told() -> None:
    base = hinge("base", ["ground", "a"], [0, 0, 0], armature=0.1)
    vary = {"joints.base.armature": {"distribution": "uniform", "low": -0.1, "high": 0.5}}
    with pytest.raises(ScenarioError, match="allows values below 0, which no rotor has; give low of 0 or above"):
        run({"bodies": [link("a", [0.4, 0, -0.2])], "joints": [base]}, sweep={"runs": 3, "vary": vary})


XML = """<mujoco><option timestep="1e-4" integrator="RK4"/><worldbody>
<body pos="0 0 0"><joint type="hinge" axis="0 1 0" armature="0.3"/>
<inertial pos="0.3 0 0.1" mass="1.2" diaginertia="0.01 0.02 0.03"/>
<body pos="0.6 0 0"><joint type="hinge" axis="1 0 0" armature="0.05"/>
<inertial pos="0.1 0.2 -0.1" mass="0.8" diaginertia="0.02 0.01 0.015"/>
<body pos="0.2 0.1 0"><joint type="slide" axis="0 0 1" armature="1.5"/>
<inertial pos="0 0.1 0" mass="0.5" diaginertia="0.003 0.002 0.001"/></body></body></body></worldbody></mujoco>"""


def test_accelerations_are_those_of_mujoco() -> None:
    mujoco = pytest.importorskip("mujoco")
    model = mujoco.MjModel.from_xml_string(XML)
    data = mujoco.MjData(model)
    data.qvel[:] = (1.0, -2.0, 0.5)
    mujoco.mj_forward(model, data)
    own = {
        "bodies": [
            {"name": "a", "mass": 1.2, "inertia": [0.01, 0.02, 0.03], "position": [0.3, 0, 0.1]},
            {"name": "b", "mass": 0.8, "inertia": [0.02, 0.01, 0.015], "position": [0.7, 0.2, -0.1]},
            {"name": "c", "mass": 0.5, "inertia": [0.003, 0.002, 0.001], "position": [0.8, 0.2, 0]},
        ],
        "joints": [
            hinge("one", ["ground", "a"], [0, 0, 0], rate=1.0, armature=0.3),
            hinge("two", ["a", "b"], [0.6, 0, 0], rate=-2.0, armature=0.05) | {"axis": [1, 0, 0]},
            {"name": "three", "type": "prismatic", "bodies": ["b", "c"], "at": [0.8, 0.1, 0], "axis": [0, 0, 1],
             "speed": 0.5, "armature": 1.5},
        ],
    }  # fmt: skip
    names = ["a", "b", "c"]
    quantities = [{"name": f"acc_{x}", "type": "point", "body": x, "derivative": 2} for x in names]
    ds = run(own, quantities=quantities)
    for i, x in enumerate(names):
        mujoco.mj_rnePostConstraint(model, data)
        acc = np.zeros(6)
        mujoco.mj_objectAcceleration(model, data, mujoco.mjtObj.mjOBJ_BODY, i + 1, acc, 0)
        acc[3:] += (0, 0, -9.81)  # it counts the ground as falling upwards
        np.testing.assert_allclose(ds[f"acc_{x}"][0, 0], acc[3:], atol=1e-11)
