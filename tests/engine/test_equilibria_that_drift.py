"""Steady equilibria that nothing holds in some way, at any rate, in scenes turned in space."""

from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lienumba
from tests.rigs.parts import numbers, quaternion

G = 9.81
SHORT = {"integrator": {"method": "dop853", "tolerance": 1e-10, "end_time": 0.1}}
TURNS = [Rotation.identity(), Rotation.random(random_state=4)]
UP = np.array([0.0, 0.0, 1.0])


@pytest.mark.parametrize("turn", TURNS)
@pytest.mark.parametrize("inertia", [(0.15, 0.15, 0.2), (0.004, 0.004, 0.002)])
def test_a_conical_pendulum_that_may_spin_is_found_at_every_rate(inertia: tuple[float, ...], turn: Rotation) -> None:
    """cos(angle) = m g l / (I w^2), I = m l^2 + A - C."""
    mass, length = 1.3, 0.5
    whole = mass * length**2 + inertia[0] - inertia[2]
    least = np.sqrt(mass * G * length / whole)
    rates = least * np.linspace(1.02, 3.0, 120)
    start = (turn * Rotation.from_rotvec([0.1, 0.2, 0.0])).as_rotvec()
    ball = {"name": "ball", "type": "spherical", "bodies": ["ground", "bob"], "points": [[0, 0, 0], [0, 0, length]],
            "rotation_vector": numbers(start)}  # fmt: skip
    bob = {"name": "bob", "mass": mass, "inertia": list(inertia)}
    axes = rates[:, None] * turn.apply(UP)
    found = lienumba.equilibrium({
        "model": {"gravity": numbers(turn.apply(-G * UP)), "bodies": [bob], "joints": [ball]}, **SHORT,
        "start": {"from": "equilibrium", "rotation": [0.0, 0.0, 1.0]},
        "sweep": {"sampler": "table", "table": {"columns": {
            f"start.rotation[{n}]": numbers(axes[:, n]) for n in range(3)}}},
    })  # fmt: skip
    assert (found.status == 0).all()  # it may spin about itself
    down = -found.position.values[:, 0] @ turn.apply(UP) / length
    np.testing.assert_allclose(down, (least / rates) ** 2, rtol=1e-11)


def ring(bodies: int, turn: Rotation, k: float, free: float) -> dict[str, Any]:
    """Bodies in a circle of radius 1, each held by a spring to the next (two by one)."""
    places = [turn.apply([np.cos(x), np.sin(x), 0.2]) for x in 2 * np.pi * np.arange(bodies) / bodies]
    springs = [(n, (n + 1) % bodies) for n in range(bodies if bodies > 2 else 1)]
    return {
        "gravity": [0, 0, 0],
        "bodies": [
            {"name": f"b{n}", "mass": 1.0, "inertia": [0.1, 0.12, 0.15], "position": numbers(x),
             "rotation": quaternion(turn)} for n, x in enumerate(places)
        ],
        "forces": [
            {"type": "spring_damper", "bodies": [f"b{a}", f"b{b}"], "points": [[0, 0, 0]] * 2, "stiffness": k,
             "free_length": free} for a, b in springs
        ],
    }  # fmt: skip


@pytest.mark.parametrize("turn", TURNS)
@pytest.mark.parametrize("bodies", [2, 3])
@pytest.mark.parametrize("w", [1e-3, 0.3, 2.0])
def test_free_bodies_that_hold_each_other_turn_about_their_centre(bodies: int, w: float, turn: Rotation) -> None:
    """Shifted together they drift, which neither falls nor grows: m w^2 r = 2 k sin(pi / n) (2 r sin(pi / n) - l)."""
    k, free = 50.0, 1.6
    found = lienumba.equilibrium(
        {"model": ring(bodies, turn, k, free), **SHORT}, rotation=tuple(numbers(w * turn.apply(UP)))
    )
    assert found.status.item() == 0
    half, springs = np.sin(np.pi / bodies), 1.0 if bodies == 2 else 2.0
    radius = springs * half * k * free / (springs * half * k * 2.0 * half - w**2)
    places = found.position.values[0]
    across = places - np.outer(places @ turn.apply(UP), turn.apply(UP))
    np.testing.assert_allclose(np.linalg.norm(across, axis=1), radius, rtol=1e-10)
    assert np.linalg.norm(across.sum(axis=0)) < 1e-10


@pytest.mark.parametrize("turn", TURNS)
def test_what_stands_on_its_head_does_not_fall_while_others_come_to_rest(turn: Rotation) -> None:
    slide = {"name": "slide", "type": "prismatic", "bodies": ["ground", "cart"], "at": [0, 0, 0],
             "axis": numbers(turn.apply([1, 0, 0]))}  # fmt: skip
    hinge = {"name": "hinge", "type": "revolute", "bodies": ["cart", "rod"], "at": [0, 0, 0],
             "axis": numbers(turn.apply([0, 1, 0]))}  # fmt: skip
    body = {"mass": 1.0, "inertia": [0.01, 0.02, 0.03], "rotation": quaternion(turn)}
    scenario = {
        "model": {
            "gravity": numbers(turn.apply(-G * UP)),
            "bodies": [{"name": "cart", **body, "position": [0, 0, 0]},
                       {"name": "rod", **body, "position": numbers(turn.apply(0.5 * UP))}],
            "joints": [slide, hinge],
            "quantities": [{"name": "slide", "type": "joint", "joint": "slide"}],
            "forces": [{"type": "actuator", "joint": "slide", "value": "-40*(slide.displacement - 0.7)"}],
        },
        **SHORT,
    }  # fmt: skip
    found = lienumba.equilibrium(scenario)
    assert found.status.item() == 2
    np.testing.assert_allclose(found.position.values[0, 1], turn.apply([0.7, 0.0, 0.5]), atol=1e-12)
    whole, lever = 0.02 + 0.25, 0.5  # (m + M) s'' + m l a'' = -k s, m l s'' + J a'' = m g l a
    growths = np.linalg.eigvals(np.linalg.solve([[2.0, lever], [lever, whole]], [[-40.0, 0.0], [0.0, G * lever]]))
    assert found.growth.item() == pytest.approx(np.sqrt(growths.max()), rel=1e-9)


@pytest.mark.parametrize("turn", TURNS)
@pytest.mark.parametrize("start", [0.0, 0.6, -2.0])
def test_the_integral_of_a_motor_is_what_its_bearing_takes(turn: Rotation, start: float) -> None:
    """Its rate is 0 at its speed, whatever it is: it holds 0.1 N m s at 6 rad/s."""
    w = 6.0
    axis = numbers(turn.apply(UP))
    arm = {"name": "arm", "type": "revolute", "bodies": ["shaft", "weight"], "at": numbers(turn.apply([0.1, 0, 0])),
           "axis": numbers(turn.apply([0, 1, 0]))}  # fmt: skip
    bearing = {"name": "bearing", "type": "revolute", "bodies": ["ground", "shaft"], "at": [0, 0, 0], "axis": axis}
    body = {"mass": 2.0, "inertia": [0.03, 0.04, 0.02], "rotation": quaternion(turn)}
    scenario = {
        "model": {
            "gravity": numbers(turn.apply(-G * UP)),
            "bodies": [{"name": "shaft", **body, "position": [0, 0, 0]},
                       {"name": "weight", **body, "position": numbers(turn.apply([0.3, 0, -0.35]))}],
            "joints": [bearing, arm],
            "quantities": [{"name": "shaft", "type": "joint", "joint": "bearing"}],
            "inputs": {"i": {"rate": f"5*({w} - shaft.rate)", "start": start}},
            "forces": [{"type": "actuator", "joint": "bearing", "value": f"inputs.i + 2*({w} - shaft.rate)"},
                       {"type": "friction", "joint": "bearing", "viscous": 0.1}],
        },
        "start": {"from": "equilibrium", "rotation": numbers(w * turn.apply(UP))},
        "integrator": {"method": "dop853", "tolerance": 1e-11, "end_time": 1.0},
        "output": {"every": 0.5},
    }  # fmt: skip
    assert lienumba.equilibrium(scenario).status.item() == 0
    ds = lienumba.run(scenario, progress=False)
    np.testing.assert_allclose(ds["inputs.i"], 0.1 * w, atol=1e-9)
    np.testing.assert_allclose(ds["shaft.rate"], w, atol=1e-9)
    height = ds.position.values[0, :, 1] @ turn.apply(UP)
    np.testing.assert_allclose(height, height[0], atol=1e-9)
