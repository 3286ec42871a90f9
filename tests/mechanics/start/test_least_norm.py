"""Reactions that are not unique: of all multipliers with the same effect the least, by NumPy's pseudo-inverse."""

import copy
from typing import Any

import numpy as np
import pytest

import lienumba
from lienumba.mechanics.system import constraints
from lienumba.scenario.start.prepare import check_initial
from tests.facade import Instant, resolve

BODY = {"mass": 2.0, "inertia": [0.3, 0.5, 0.4, 0.02, -0.03, 0.01]}


def scenario(bodies: list[dict[str, Any]], joints: list[dict[str, Any]]) -> dict[str, Any]:
    return {
        "model": {"gravity": [1.0, -2.0, -9.0], "bodies": [BODY | body for body in bodies], "joints": joints},
        "integrator": {"step": 1e-3, "end_time": 0.5},
        "output": {"times": [0.0, 0.25, 0.5]},
    }


def hinge(name: str, a: str, b: str, at: list[float], axis: list[float], **more: Any) -> dict[str, Any]:
    return {"name": name, "type": "revolute", "bodies": [a, b], "at": at, "axis": axis, **more}


SKEW = [0.3, 0.2, 1.0]
DOOR = scenario(
    [{"name": "door", "position": [0.4, 0.1, 0], "rotation": [1, 0, 0, 0]}],
    [hinge("low", "ground", "door", [0, 0, 0], SKEW, rate=2.0), hinge("high", "ground", "door", SKEW, SKEW)],
)
LOOP = scenario(
    [
        {"name": "crank", "position": [0, 0, 0.25], "rotation": [1, 0, 0, 0]},
        {"name": "rod", "position": [0.5, 0, 0.6], "rotation": [1, 0, 0, 0]},
        {"name": "rocker", "position": [1, 0, 0.4], "rotation": [1, 0, 0, 0]},
    ],
    [
        hinge("A", "ground", "crank", [0, 0, 0], [0, 1, 0], rate=3.0),
        hinge("B", "crank", "rod", [0, 0, 0.5], [0, 1, 0]),
        hinge("C", "rod", "rocker", [1, 0, 0.7], [0, 1, 0]),
        hinge("D", "rocker", "ground", [1, 0, 0], [0, 1, 0]),
    ],
)


@pytest.mark.parametrize(("data", "spare"), [(DOOR, 5), (LOOP, 3)], ids=["door", "four-bar"])
def test_multipliers_have_the_least_norm(data: dict[str, Any], spare: int) -> None:
    nominal = check_initial(resolve(data))
    assert nominal.rank.rows - nominal.rank.rank == spare
    dataset = lienumba.run(data, overrides={"output.also": ["multiplier"]}).isel(run=0)
    assert dataset.multiplier.attrs["not_unique"] == ", ".join(nominal.rank.shared)
    for time in range(dataset.sizes["time"]):
        now = dataset.isel(time=time)
        state = np.concatenate(
            [now.position, now.rotation.values.reshape(-1, 9), now.velocity, now.angular_velocity], 1
        )
        C = np.zeros((nominal.rank.rows, 6 * len(state)))
        at = Instant(tuple(tuple(body) for body in state.tolist()), 0.0)
        for key, value in constraints.jacobian(nominal.model, at).items():
            C[key] = value
        mu = now.multiplier.values
        assert np.linalg.norm(mu) > 1.0
        np.testing.assert_allclose(mu, np.linalg.pinv(C.T, rcond=1e-9) @ (C.T @ mu), atol=1e-8 * np.abs(mu).max())


def test_the_forces_of_both_hinges_carry_the_door() -> None:
    dataset = lienumba.run(DOOR).isel(run=0)
    fine = lienumba.run(DOOR | {"output": {"every": 1e-3}}).isel(run=0)
    acceleration = (fine.velocity[251] - fine.velocity[249]) / 2e-3
    force = dataset.joint_force.isel(time=1).sum("joint")
    np.testing.assert_allclose(force, 2.0 * (acceleration[0] - np.array([1.0, -2.0, -9.0])), atol=1e-3)


def scaled(size: float) -> dict[str, Any]:
    """The four-bar in another size, gravity too, so that it moves alike."""
    data = copy.deepcopy(LOOP)
    model = data["model"]
    model["gravity"] = [size * g for g in model["gravity"]]
    for body in model["bodies"]:
        body["inertia"] = [size**2 * x for x in body["inertia"]]
        body["position"] = [size * x for x in body["position"]]
    for joint in model["joints"]:
        joint["at"] = [size * x for x in joint["at"]]
    return data


@pytest.mark.parametrize("size", [1e-3, 50.0])
def test_forces_in_the_plane_grow_with_the_size(size: float) -> None:
    """They are unique, however small the lever arms are beside the 1 rad of the rows that say the same."""
    small, normal = (lienumba.run(scaled(s)).isel(run=0).joint_force.sel(axis=["x", "z"]) for s in (size, 1.0))
    np.testing.assert_allclose(small / size, normal, rtol=1e-8, atol=1e-8 * np.abs(normal).max())


def test_the_effort_near_a_singular_position() -> None:
    """A Scott-Russell mechanism is driven through the position where crank and rod stand upright: the torque on the
    crank by virtual power, T = d/dt(dK/dw) + dV/dth."""
    r, rate, start, m, block = 0.25, 5.0, 0.4, 1.0, 0.5
    c, s = np.cos(start), np.sin(start)
    bar = {"mass": m, "inertia": [1e-4, m * r**2 / 12, m * r**2 / 12]}
    rod = {"mass": m, "inertia": [1e-4, m * r**2 / 3, m * r**2 / 3]}
    poses = [([r * c / 2, r * s / 2, 0], start), ([r * c, r * s, 0], -start), ([2 * r * c, 0, 0], 0.0)]
    bodies = [
        {**body, "name": name, "position": at, "rotation": {"axis": [0, 0, 1], "angle": angle}}
        for name, body, (at, angle) in zip(
            ("crank", "rod", "block"), (bar, rod, BODY | {"mass": block}), poses, strict=True
        )
    ]
    joints = [
        hinge("O", "ground", "crank", [0, 0, 0], [0, 0, 1]),
        hinge("A", "crank", "rod", [r * c, r * s, 0], [0, 0, 1]),
        hinge("S", "rod", "block", [2 * r * c, 0, 0], [0, 0, 1]),
        {"name": "G", "type": "prismatic", "bodies": ["ground", "block"], "at": [0, 0, 0], "axis": [1, 0, 0]},
    ]
    data = scenario([], joints)
    data["model"] |= {"bodies": bodies, "gravity": [0, -9.81, 0], "drivers": [{"joint": "O", "value": f"{rate}*t"}]}
    data |= {"output": {"every": 1e-3}}
    dataset = lienumba.run(data).isel(run=0)
    angle = start + rate * dataset.time.values
    torque = 2 * block * (r * rate) ** 2 * np.sin(2 * angle) + 9.81 * m * 1.5 * r * np.cos(angle)
    regular = np.abs(np.cos(angle)) > 0.005
    assert 0 < (~regular).sum() < 10
    np.testing.assert_allclose(dataset.driver_effort.values[regular, 0], torque[regular], atol=1e-6)
