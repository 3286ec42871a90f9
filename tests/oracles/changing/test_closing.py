"""Joints that are engaged: what moving bodies together takes, how far apart they may be, and what never closes."""

from typing import Any

import numpy as np
import pytest

import lienumba
from tests.oracles.changing import scenarios
from tests.oracles.changing.scenarios import statuses
from tests.rigs import parts

G, WHEN, GAP = 9.81, 0.1, 0.01
SPIN = [1.0, 2.0, 3.0]


def test_what_closing_takes_is_in_the_books_and_what_does_not_close_is_not() -> None:
    """A falling body is caught at its mass centre, the gap away from where it is to be: by impulse it loses its speed,
    by being moved the height of the gap."""
    start = [0, 0, GAP + 0.5 * G * WHEN**2]
    body = parts.resting("probe", 2.0, [0.1, 0.2, 0.3], start, angular_velocity=SPIN)
    ball = parts.joint("catch", "spherical", "probe", points=[[0, 0, 0]] * 2, active=False)
    capture = {"name": "capture", "when": f"t > {WHEN}", "action": "engage", "joint": "catch", "closing": 0.02}
    model = {"gravity": [0, 0, -G], "bodies": [body], "joints": [ball]}
    data = scenarios.scenario("A probe", model, 0.3) | {
        "events": [capture],
        "sweep": scenarios.table({"events.capture.closing": np.array([0.5, 1.5, 0.9]) * GAP}),
    }
    ds = lienumba.run(data)
    assert statuses(ds) == ["capture_failed", "success", "capture_failed"]
    lost = 2.0 * G * GAP + (G * WHEN) ** 2
    np.testing.assert_allclose(ds.energy_lost, [0.0, lost, 0.0], rtol=0, atol=1e-12)
    np.testing.assert_allclose(ds.change_energy[1, 0], lost, rtol=0, atol=1e-12)
    np.testing.assert_array_equal(ds.changes, [0, 1, 0])
    np.testing.assert_array_equal(ds.last_mode[:, 0], [0, 1, 0])
    np.testing.assert_allclose(ds.event_time[:, 0], WHEN, rtol=0, atol=1e-15)
    assert abs(ds.energy_residual).max() < 1e-11
    np.testing.assert_allclose(ds.position[1, -1, 0], 0.0, rtol=0, atol=1e-12)


@pytest.mark.parametrize("coordinates", ["lie", "joint"])
def test_moving_a_loop_together_keeps_the_energy_residual(coordinates: str) -> None:
    """Two bars on hinges, that swing against a spring, are pinned together a hand's width apart. In one run the pin is
    out of their plane: nothing can close it, though its row says nothing beyond the hinges."""
    bars, hinges = [], []
    for name, x, angle in ("left", 0.0, -0.6), ("right", 1.0, -2.5):
        place = parts.frames(parts.Y, [x, 0, 0], [-0.3, 0, 0]) | {"angle": angle, "rate": 0.5}
        bars.append(parts.body(name, 1.0, [0.01, 0.03, 0.03]))
        hinges.append(parts.joint(f"{name}_hinge", "revolute", name, **place))
    pin = parts.joint("pin", "spherical", "right", "left", points=[[0.3, 0, 0]] * 2, active=False)
    spring = {"name": "spring", "type": "spring_damper", "bodies": ["left", "right"], "stiffness": 200, "damping": 0}
    spring |= {"points": [[0.3, 0, 0]] * 2, "free_length": 0.05}
    model = {"gravity": [0, 0, -G], "bodies": bars, "joints": [*hinges, pin], "forces": [spring]}
    data = scenarios.scenario("A loop that closes", model, 0.5, coordinates=coordinates) | {
        "events": [{"name": "shut", "when": "t > 0.05", "action": "engage", "joint": "pin", "closing": 0.1}],
        "projection": {"max_iterations": 3},  # of steps; what closes has no need to be next to where it is
        "sweep": scenarios.table({"joints.pin.points[0][1]": [0.0, 0.001]}),
    }
    ds = lienumba.run(data)
    assert statuses(ds) == ["success", "capture_failed"]
    np.testing.assert_array_equal(ds.changes, [1, 0])
    assert abs(ds.change_energy[0, 0]) > 0.01
    assert abs(ds.energy_residual[0]).max() < 1e-10
    assert float(ds.max_position_violation[0]) < 1e-11


@pytest.mark.parametrize("coordinates", ["lie", "joint"])
def test_a_gear_that_is_engaged(coordinates: str) -> None:
    """A clutch of two wheels: the impulse leaves a (J_a + J_b/16) = J_a a_0 and b = -a/4."""
    wheels = [parts.body(n, 1, [0.1, 0.1, i], position=[x, 0, 0]) for n, i, x in (("a", 0.02, 0.0), ("b", 0.1, 0.4))]
    shafts = [
        parts.hinge("A", "a", axis=parts.Z, angle=0, rate=2),
        parts.hinge("B", "b", [0.4, 0, 0], parts.Z, angle=0),
    ]
    gear = {"name": "G", "type": "gear", "joints": ["A", "B"], "ratio": -0.25, "active": False}
    found = lienumba.run(
        {
            "model": {"gravity": [0, 0, 0], "bodies": wheels, "joints": [*shafts, gear]},
            "quantities": parts.observed("joint", *"AB"),
            "events": [{"name": "e", "when": "t > 0.5", "action": "engage", "joint": "G", "closing": 10}],
            "integrator": {"tolerance": 1e-11, "end_time": 1.0, "coordinates": coordinates},
            "output": {"every": 0.5},
        }
    )
    after = 2 * 0.02 / (0.02 + 0.1 / 16)
    np.testing.assert_allclose(found["A.rate"].values[0], [2, 2, after], rtol=1e-10)
    np.testing.assert_allclose(found["B.rate"].values[0, 1:], [0, -after / 4], atol=1e-10)


@pytest.mark.parametrize("coordinates", ["lie", "joint"])
def test_a_gap_closes_alike_in_any_size_and_the_mass_centre_stays(coordinates: str) -> None:
    """Two free bodies meet askew, from a millimetre to a kilometre across. Moved least in m and rad the large ones did
    not close, each size closed otherwise, and all leapt."""
    found = []
    for size in (1e-3, 1.0, 1e3):
        place = [-1.5 * size, 0.007 * size, 0.002 * size]
        chaser = parts.resting("a", 9.0, [4.2 * size**2, 6.1 * size**2, 6.4 * size**2], place)
        chaser |= {"velocity": [0.6 * size, 0, 0], "angular_velocity": [0.003, 0, 0.008]}
        target = parts.resting("b", 26.0, [21 * size**2, 39 * size**2, 37 * size**2], [1.2 * size, 0, 0])
        ends = [[-1.2 * size, 0, 0], [size, 0, 0]]
        probe = parts.joint("p", "spherical", "a", "b", points=ends, active=False)
        tip = {"name": "tip", "type": "point", "body": "a", "point": [size, 0, 0], "relative_to": "b"}
        near = f"(tip.x + {1.2 * size})**2 + tip.y**2 + tip.z**2 < {(0.02 * size) ** 2}"
        capture = {"name": "c", "when": near, "action": "engage", "joint": "p", "closing": 0.03 * size, "once": True}
        scenario = {
            "model": {"gravity": [0, 0, 0], "bodies": [chaser, target], "joints": [probe]},
            "quantities": [tip, {"name": "momentum", "type": "momentum"}], "events": [capture],
            "integrator": {"method": "rk4", "step": 0.01, "end_time": 3.0, "coordinates": coordinates},
            "output": {"times": [0.0, 1.0, 2.0, 3.0]},
        }  # fmt: skip
        ds = lienumba.run(scenario).isel(run=0)
        assert statuses(ds.expand_dims("run")) == ["success"]
        assert int(ds.event_count[0]) == 1
        mass = np.array([9.0, 26.0])
        centre = np.tensordot(mass, ds.position.values, (0, 1)) / mass.sum()
        straight = centre[0] + np.outer(ds.time.values, [9 * 0.6 * size / 35, 0, 0])
        np.testing.assert_allclose(centre, straight, rtol=0, atol=1e-9 * size)
        found.append(np.concatenate([ds.position.values / size, ds.angular_velocity.values], axis=-1))
    np.testing.assert_allclose(found[0], found[1], rtol=0, atol=2e-6)
    np.testing.assert_allclose(found[2], found[1], rtol=0, atol=1e-8)


@pytest.mark.parametrize("products", [[], [0.006, -0.004, 0.005]], ids=["along axes", "askew"])
@pytest.mark.parametrize("gap", [1e-2, 1e-4])
def test_closing_a_gap_between_chains_takes_no_momentum(gap: float, products: list[float]) -> None:
    """Arms of joints that turn are moved by turning: with rates as they were the bodies moved otherwise, by the gap."""
    chains = []
    for own, x, last in (("ab", 0.0, 0.0), ("cd", 1.0, gap)):
        first = parts.resting(own[0], 1.0 + x, [0.02, 0.03, 0.04, *products], [x, -last, 0.5 * last])
        first |= {"velocity": [0.1 - 0.3 * x, 0.2, -0.1], "angular_velocity": [0.3, 0.5, 1.0]}
        place = parts.frames([0, 0.6, 0.8], [0.2 - 0.4 * x, 0, 0.1], [-0.3, 0.1, 0]) | {"angle": 0.3, "rate": 1.5 - x}
        arm = parts.body(own[1], 0.7, [0.01, 0.02, 0.015])
        chains.append(([first, arm], parts.joint(own, "revolute", own[1], own[0], **place)))
    bodies = [body for own, _ in chains for body in own]
    probe = parts.joint("p", "spherical", "c", "a", points=[[0.5, 0, 0], [-0.5, 0, 0]], active=False)
    found = []
    for coordinates in ("lie", "joint"):
        ds = lienumba.run(
            {
                "model": {"gravity": [0, 0, 0], "bodies": bodies,
                          "joints": [*(hinge for _, hinge in chains), probe]},
                "quantities": [{"name": "m", "type": "momentum"}],
                "events": [{"name": "e", "when": "t > 1e-9", "action": "engage", "joint": "p", "closing": 0.1}],
                "integrator": {"tolerance": 1e-11, "end_time": 0.2, "coordinates": coordinates},
                "output": {"times": [0.0, 0.1, 0.2]},
            }
        ).isel(run=0)  # fmt: skip
        assert int(ds["changes"]) == 1
        np.testing.assert_allclose(ds["m.linear"], np.tile(ds["m.linear"][0], (3, 1)), rtol=0, atol=1e-12)
        assert float(abs(ds.energy_residual).max()) < 1e-11
        found.append((float(ds.energy_lost), ds.velocity.values[-1]))
    assert found[0][0] > 0.05
    assert found[1][0] == pytest.approx(found[0][0], rel=gap**2)
    np.testing.assert_allclose(found[1][1], found[0][1], rtol=0, atol=gap**2)


def test_a_body_without_mass_takes_no_part_in_what_closing_moves() -> None:
    """Masses that are lent to it, so that equations can be solved, moved the mass centre by a ten-thousandth."""
    shape: Any = [0.02, 0.03, 0.04]
    bodies = [
        parts.resting("a", 1.0, shape),
        {"name": "m", "mass": 0.0},
        parts.body("b", 1.4, shape),
        parts.resting("c", 0.8, shape, [1.21, 0.01, 0.12]),
    ]
    first = parts.frames(parts.Y, [0.3, 0, 0]) | {"angle": 0.2, "rate": 1.0}
    second = parts.frames(parts.Z, second=[-0.3, 0, 0]) | {"angle": 0.2, "rate": 0.3}
    joints = [
        parts.joint("h", "revolute", "m", "a", **first),
        parts.joint("k", "revolute", "b", "m", **second),
        parts.joint("p", "spherical", "c", "b", points=[[0.3, 0, 0], [-0.3, 0, 0]], active=False),
    ]
    ds = lienumba.run(
        {
            "model": {"gravity": [0, 0, 0], "bodies": bodies, "joints": joints},
            "quantities": [{"name": "m_all", "type": "momentum"}],
            "events": [{"name": "e", "when": "t > 1e-9", "action": "engage", "joint": "p", "closing": 1.0}],
            "integrator": {"tolerance": 1e-11, "end_time": 0.2, "coordinates": "joint"},
            "output": {"times": [0.0, 0.2]},
        }
    ).isel(run=0)  # fmt: skip
    assert int(ds["changes"]) == 1
    mass = np.array([1.0, 0.0, 1.4, 0.8])
    centre = mass @ ds.position.values / mass.sum()
    straight = centre[0] + 0.2 * ds["m_all.linear"].values[0] / mass.sum()
    np.testing.assert_allclose(centre[1], straight, rtol=0, atol=1e-7)
    np.testing.assert_allclose(ds["m_all.linear"][1], ds["m_all.linear"][0], rtol=0, atol=1e-12)
