"""Equilibria and modes of mechanisms that are turned in space, of states of laws, and near places that do not last."""

from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

import lienumba
from tests.rigs import parts

G = 9.81
SHORT = {"integrator": {"step": 1e-3, "end_time": 0.1}}
TURNS = [[0.0, 0.0, 1.0], [0.2, 0.0, 0.0], [0.2, 0.1, 0.3], [0.3, 0.7, -1.1]]


def door(turn: list[float], hinges: int) -> dict[str, Any]:
    """Of 20 kg on as many hinges along one axis, all of it turned, with a coil spring that shuts it."""
    R = Rotation.from_rotvec(turn)
    lie = np.roll(R.as_quat(), 1).tolist()
    leaf = parts.body("leaf", 20, [2, 3, 1], position=R.apply([0.4, 0, 0.9]).tolist(), rotation=lie)
    axis = R.apply([0, 0, 1]).tolist()
    joints = [
        parts.hinge(f"h{n}", "leaf", R.apply([0, 0, z]).tolist(), axis) for n, z in enumerate((0.2, 1.6, 1.1)[:hinges])
    ]
    coil = {"type": "torsion_spring", "joint": "h0", "stiffness": 30, "damping": 5, "free_angle": 0.1}
    model = {"gravity": [0, 0, -G], "bodies": [leaf], "joints": joints, "forces": [coil]}
    return {"model": model, "quantities": [{"name": "hinge", "type": "joint", "joint": "h0"}], **SHORT}


@pytest.mark.parametrize("hinges", [2, 3])
@pytest.mark.parametrize("turn", TURNS)
def test_more_hinges_than_it_takes_say_the_same(turn: list[float], hinges: int) -> None:
    """All rows of the other hinges are redundant, and where nothing lies along an axis they are rounding."""
    one, more = door(turn, 1), door(turn, hinges)
    found, expected = lienumba.equilibrium(more), lienumba.equilibrium(one)
    assert found.status.item() == expected.status.item() == 0
    assert found["hinge.angle"].item() == pytest.approx(expected["hinge.angle"].item(), abs=1e-12)
    of_one, of_more = lienumba.modes(one), lienumba.modes(more)
    for name in ("growth", "angular_frequency"):
        np.testing.assert_allclose(of_more[name].values, of_one[name].values, rtol=1e-9, atol=1e-9)
    linear = lienumba.linearise(more)
    assert np.sort_complex(np.linalg.eigvals(linear.A.values[0, 0])) == pytest.approx(
        np.sort_complex(np.linalg.eigvals(lienumba.linearise(one).A.values[0, 0])), rel=1e-9
    )


def driven(forces: list[dict[str, Any]], inputs: dict[str, Any], gravity: float = 0.0) -> dict[str, Any]:
    """A wheel on a hinge, or with gravity a pendulum."""
    wheel = parts.body("w", position=[0, 0, -0.5 * (gravity > 0)], rotation=[1, 0, 0, 0])
    seen = [{"name": "turn", "type": "joint", "joint": "j"}]
    seen += [
        {"name": "s" if len(inputs) == 1 else name, "type": "expression", "value": f"inputs.{name}"} for name in inputs
    ]
    model = {"gravity": [0, 0, -gravity], "bodies": [wheel], "joints": [parts.hinge("j", "w")], "forces": forces}
    return {"model": model, "quantities": seen, "inputs": inputs, **SHORT}


@pytest.mark.parametrize(
    ("torque", "rest"),
    [
        ({"value": 1.5, "filter": 0.1}, np.arcsin(1.5 / (0.5 * G))),
        ({"value": 1.5, "filter": 0.01, "start": 1.4}, np.arcsin(1.5 / (0.5 * G))),
        ({"rate": "0.1*(0.2 - turn.angle)"}, 0.2),
    ],
)
def test_what_follows_slowly_moves_against_the_forces_that_there_are(torque: dict[str, Any], rest: float) -> None:
    """A pendulum that begins a little below, or above, where its motor will hold it."""
    motor = {"name": "m", "type": "actuator", "joint": "j", "value": "inputs.T"}
    friction = {"name": "f", "type": "friction", "joint": "j", "viscous": 0.5}
    for below in (0.05, -0.05):
        held = driven([motor, friction], {"T": torque}, G)
        body, angle = held["model"]["bodies"][0], rest - below
        body["position"] = [-0.5 * np.sin(angle), 0, -0.5 * np.cos(angle)]
        del body["rotation"]
        held["model"]["joints"] = [parts.pivot("j", "w", second=[0, 0, 0.5], angle=angle)]
        found = lienumba.equilibrium(held)
        assert found.status.item() == 0
        assert found["turn.angle"].item() == pytest.approx(rest, abs=1e-9)


@pytest.mark.parametrize(
    ("rate", "start", "rest"),
    [("8 - inputs.T**3", 5.0, 2.0), ("8 - inputs.T**3", 0.5, 2.0), ("1 - exp(inputs.T - 2)", -3.0, 2.0)],
)
def test_states_of_laws_come_to_rest_beside_what_hangs_still(rate: str, start: float, rest: float) -> None:
    found = lienumba.equilibrium(driven([], {"T": {"rate": rate, "start": start}}, G))
    assert found.status.item() == 0
    assert found["s"].item() == pytest.approx(rest, rel=1e-12)


def test_a_state_that_never_rests_is_no_equilibrium() -> None:
    assert lienumba.equilibrium(driven([], {"T": {"rate": "1 + 0*inputs.T", "start": 0.0}}, G)).status.item() == 1


@pytest.mark.parametrize("lag", [0.001, 0.01, 0.08])
@pytest.mark.parametrize("integral", [0.1, 1.0, 9.0])
@pytest.mark.parametrize("gravity", [0.0, G])
def test_an_integral_behind_a_lag_comes_to_rest(lag: float, integral: float, gravity: float) -> None:
    """Forces vanish long before the integral has come to where the place is right, and nothing else is stiff."""
    motor = {"name": "motor", "type": "actuator", "joint": "j", "value": "inputs.u"}
    damper = {"name": "damper", "type": "friction", "joint": "j", "viscous": 3.0}
    inputs = {"error": {"rate": "0.4 - turn.angle"}}
    inputs |= {"u": {"value": f"20*(0.4 - turn.angle) + {integral}*inputs.error", "filter": lag}}
    found = lienumba.equilibrium(driven([motor, damper], inputs, gravity))
    assert found.status.item() == 0
    assert found["turn.angle"].item() == pytest.approx(0.4, abs=1e-10)


@pytest.mark.parametrize("load", [0.0, 0.7])
@pytest.mark.parametrize("start", [0.0, 0.2])
def test_a_servo_behind_a_filter_finds_its_place(start: float, load: float) -> None:
    """Nothing but the filter's state holds the wheel: its place is 0.3 + load/kp, wherever the state begins."""
    forces = [
        {"name": "motor", "type": "actuator", "joint": "j", "value": "inputs.command"},
        {"name": "load", "type": "actuator", "joint": "j", "value": load},
    ]
    inputs = {"command": {"value": "4*(0.3 - turn.angle) - turn.rate", "filter": 0.05, "start": start}}
    found = lienumba.equilibrium(driven(forces, inputs))
    assert found.status.item() == 0
    assert found["turn.angle"].item() == pytest.approx(0.3 + load / 4, abs=1e-10)


@pytest.mark.parametrize("kp", [50.0, 500.0, 1e4, 1e6])
@pytest.mark.parametrize("angle", [0.0, -0.25, 0.5])
def test_a_servo_at_its_limit_comes_to_where_it_holds(kp: float, angle: float) -> None:
    """30 N m to either side, and stiff within 30/kp alone: a step from one limit to the other is too long."""
    hinge = parts.pivot("j", "w", second=[-0.5, 0, 0], angle=angle)
    motor = {"type": "actuator", "joint": "j", "value": "inputs.hold"}
    scenario = {
        "model": {"gravity": [0, 0, -G], "bodies": [parts.body("w")], "joints": [hinge], "forces": [motor]},
        "inputs": {"hold": {"joint": "j", "kp": kp, "kd": 0.05 * kp, "target": -0.3, "limit": 30}},
        "quantities": [{"name": "turn", "type": "joint", "joint": "j"}],
    } | SHORT
    found, held = lienumba.equilibrium(scenario), brentq(lambda x: kp * (-0.3 - x) + G * 0.5 * np.cos(x), -0.35, 0)
    assert found.status.item() == 0
    assert found["turn.angle"].item() == pytest.approx(held, abs=1e-10)


@pytest.mark.parametrize("angle", [3.1415, 3.141592, 3.14159265, 3.1415926535])
def test_what_is_hardly_beside_an_unstable_place_comes_to_a_stable_one(angle: float) -> None:
    hinge = parts.pivot("j", "w", second=[0, 0, 0.5], angle=angle)
    seen = {"name": "turn", "type": "joint", "joint": "j"}
    model = {"bodies": [parts.body("w")], "joints": [hinge]}
    found = lienumba.equilibrium({"model": model, "quantities": [seen], **SHORT})
    assert found.status.item() == 0
    assert found["turn.angle"].item() == pytest.approx(0.0, abs=1e-10)


def arm(**more: Any) -> dict[str, Any]:
    """Of half a metre on a hinge, along x, with a weak coil spring."""
    body = parts.body("w", position=[0.5, 0, 0])
    coil = {"type": "torsion_spring", "joint": "j", "stiffness": 1.0, "damping": 0.3, "free_angle": 0.0}
    model = {"gravity": [0, 0, -G], "bodies": [body], "joints": [parts.hinge("j", "w")], "forces": [coil]}
    return {"model": model | more, "quantities": [{"name": "turn", "type": "joint", "joint": "j"}], **SHORT}


@pytest.mark.parametrize("at", [0, 1e-3])
def test_what_touches_or_sticks_at_the_start_does_so_in_its_modes(at: float) -> None:
    """An arm that lies on its stop, or that friction holds, has none, at 0 as later; a ball on a floor rolls."""
    sticks = arm(forces=[{"type": "friction", "name": "f", "joint": "j", "coulomb": 30, "static": 40}])
    for held in (arm(limits=[{"joint": "j", "low": -0.5, "high": 0.0}]), sticks):
        with pytest.raises(lienumba.ScenarioError, match="nothing of it can move"):
            lienumba.modes(held, at=at)
    free = lienumba.modes(arm(), at=at)
    assert np.isfinite(free.growth.values).any()


def test_what_sampled_laws_hold_is_no_mode() -> None:
    def pd(j: Any, *, k: float, d: float) -> Any:
        return j.effort(-k * j.angle - d * j.rate)

    held = arm()
    law = {"type": "python", "name": "law", "function": pd, "joints": ["j"], "every": 0.05}
    held["model"]["forces"] = [law | {"parameters": {"k": 5.0, "d": 1.0}}]
    held["model"]["bodies"][0]["position"] = [0, 0, -0.5]
    found = lienumba.modes(held)
    assert found.sizes["mode"] == 1
    assert found.angular_frequency.item() == pytest.approx(np.sqrt(G * 0.5 / (0.1 + 0.25)), rel=1e-9)
    assert lienumba.equilibrium(held).status.item() == 0


def p(j: Any, *, kp: Any, target: Any) -> Any:
    return j.effort(kp * (target - j.angle))


def pi(j: Any, *, kp: Any, target: Any, states: Any, interval: Any) -> Any:
    error = target - j.angle
    return j.effort(kp * error + 3.0 * states.sum), {"sum": states.sum + interval * error}


def late(j: Any, *, kp: Any, target: Any, states: Any) -> Any:
    return j.effort(states.held), {"held": kp * (target - j.angle)}


@pytest.mark.parametrize(("law", "states"), [(p, {}), (pi, {"sum": 0.0}), (late, {"held": 0.0})])
def test_sampled_laws_rest_where_samples_change_nothing(law: Any, states: dict[str, float]) -> None:
    """They held nothing, so that their pendulum hung straight down, and moved by 0.3 rad as it began there."""
    bob = parts.body("a", 1.0, [0.02, 0.02, 0.01])
    hinge = parts.pivot("h", "a", second=[0, 0, 0.3], references=[[0, 0, 1]] * 2, angle=0.1, rate=0.0)
    control = {"name": "c", "type": "python", "function": law, "joints": ["h"], "every": 0.02}
    control |= {"parameters": {"kp": 5.0, "target": 0.5}} | ({"states": states} if states else {})
    damper = {"type": "torsion_spring", "joint": "h", "stiffness": 0, "damping": 1.0}
    scenario = {
        "model": {"gravity": [0, 0, -G], "bodies": [bob], "joints": [hinge], "forces": [control, damper]},
        "quantities": parts.observed("joint", "h"),
        "integrator": {"tolerance": 1e-9, "end_time": 1.0},
    }
    rest = 0.5 if law is pi else brentq(lambda x: 5.0 * (0.5 - x) - G * 0.3 * np.sin(x), 0, 1)
    found = lienumba.equilibrium(scenario)
    assert found.status.item() == 0
    np.testing.assert_allclose(found["h.angle"], rest, rtol=1e-9)
    ds = lienumba.run(scenario | {"start": {"from": "equilibrium"}})
    np.testing.assert_allclose(ds["h.angle"], rest, rtol=1e-9)


@pytest.mark.parametrize("coordinates", ["lie", "joint"])
@pytest.mark.parametrize("kind", ["revolute", "prismatic", "spherical"])
def test_what_is_locked_stays_where_it_begins(kind: str, coordinates: str) -> None:
    """It was held at 0: an arm whose elbow is locked at 0.5 rad hung straight."""
    begins = {
        "revolute": {"angle": 0.5, "rate": 0.0},
        "prismatic": {"displacement": 0.2, "speed": 0.0},
        "spherical": {"rotation_vector": [0.3, 0.5, -0.2], "angular_velocity": [0, 0, 0]},
    }[kind]
    axes: Any = {"axes": [[0, 1, 0]] * 2, "references": [[0, 0, 1]] * 2}
    arm = parts.body("a", 1.0, [0.02, 0.03, 0.01])
    hand = parts.body("b", 0.7, [0.01, 0.015, 0.01])
    shoulder = parts.pivot("ja", "a", second=[0, 0, 0.3], angle=0.1, rate=0.0, **axes)
    elbow = parts.joint("jb", kind, "b", "a", points=[[0.1, 0, -0.3], [0, 0, 0.2]], locked=True)
    elbow |= begins | ({} if kind == "spherical" else axes)
    spring = {"type": "torsion_spring", "joint": "ja", "stiffness": 1.0, "damping": 0.5}
    scenario = {
        "model": {"gravity": [0, 0, -G], "bodies": [arm, hand], "joints": [shoulder, elbow], "forces": [spring]},
        "quantities": [{"name": "q", "type": "joint", "joint": "ja"}],
        "integrator": {"tolerance": 1e-10, "end_time": 40.0, "coordinates": coordinates},
    }
    found, moved = lienumba.equilibrium(scenario), lienumba.run(scenario)
    assert found.status.item() == 0
    np.testing.assert_allclose(found["q.angle"], moved["q.angle"][:, -1], rtol=0, atol=1e-6)
    np.testing.assert_allclose(found["position"][0], moved["position"][0, -1], rtol=0, atol=1e-6)
    still = lienumba.run(scenario | {"start": {"from": "equilibrium"}})
    np.testing.assert_allclose(still["q.angle"], found["q.angle"].item(), rtol=0, atol=1e-9)


def plate(force: str, start: float) -> dict[str, Any]:
    """A mass of 1 kg on a slide without weight, under a force that depends on its place x."""
    law = {"type": "actuator", "joint": "s", "value": force.replace("x", "place.displacement") + "-0.5*place.speed"}
    slide = parts.slide("s", "plate", displacement=start)
    model = {"gravity": [0, 0, 0], "bodies": [parts.body("plate", 1.0)], "joints": [slide], "forces": [law]}
    return {"model": model, "quantities": [{"name": "place", "type": "joint", "joint": "s"}], **SHORT}


@pytest.mark.parametrize("a", [0.05, 0.1, 0.14, 0.148])
def test_a_plate_that_is_drawn_rests_below_its_pull_in(a: float) -> None:
    """An electrode draws by a/(1 - x)^2, a spring holds by x: up to a = 4/27 they are in balance."""
    found = lienumba.equilibrium(plate(f"{a}/(1 - x)**2 - x", 0.0))
    assert found.status.item() == 0
    assert found["place.displacement"].item() == pytest.approx(
        brentq(lambda x: a / (1 - x) ** 2 - x, 0, 1 / 3), abs=1e-12
    )


@pytest.mark.parametrize(
    ("force", "start"),
    [
        *((f"{a}/(1 - x)**2 - x", 0.0) for a in (0.1482, 0.15, 0.3, 1.0, 5.0, 50.0)),
        ("-1/x", 0.5),
        ("-1/x**2", 0.5),
    ],
)
def test_on_a_pole_of_a_force_nothing_rests(force: str, start: float) -> None:
    assert lienumba.equilibrium(plate(force, start)).status.item() == 1
