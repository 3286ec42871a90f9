"""Free bodies that become one and part again, against momenta in closed form."""

import math
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lienumba
from tests.oracles.changing import scenarios
from tests.oracles.changing.closed_forms import together, topples
from tests.rigs import parts

M = (3.0, 7.0)
J = (np.diag([0.3, 0.5, 0.6]), np.array([[1.0, 0.1, 0.05], [0.1, 1.4, -0.1], [0.05, -0.1, 1.7]]))
V = (np.array([1.0, 0.2, -0.1]), np.array([0.1, 0.0, 0.3]))
W = (np.array([0.3, -0.5, 0.8]), np.array([-0.2, 0.4, 0.1]))
TURN = (Rotation.from_rotvec([0.4, -0.2, 0.3]), Rotation.from_rotvec([-0.1, 0.5, 0.2]))
POINTS = (np.array([0.5, 0.1, -0.2]), np.array([-0.6, 0.2, 0.1]))


def body(i: int, place: np.ndarray) -> dict[str, Any]:
    x, y, z, w = TURN[i].as_quat()
    six = [*np.diag(J[i]), J[i][0, 1], J[i][0, 2], J[i][1, 2]]
    return {
        "name": f"b{i}", "mass": M[i], "inertia": six, "position": [*place], "rotation": [w, x, y, z],
        "velocity": [*V[i]], "angular_velocity": [*W[i]],
    }  # fmt: skip


def test_two_bodies_that_turn_become_one_and_part_again() -> None:
    """A weld engages at t = 0.1 where both are, and is released at t = 0.3."""
    t = 0.1
    places = [np.zeros(3), TURN[0].apply(POINTS[0]) - TURN[1].apply(POINTS[1])]
    assert np.linalg.norm(places[1]) > 0.1
    data = {
        "title": "Two become one",
        "model": {
            "gravity": [0, 0, 0], "bodies": [body(i, places[i]) for i in range(2)],
            "joints": [{"name": "weld", "type": "fixed", "bodies": ["b0", "b1"], "active": False}
                       | {"at": [*TURN[0].apply(POINTS[0])]}],
        },
        "events": [
            {"name": "dock", "when": "t >= 0", "action": "engage", "joint": "weld"},
            {"name": "part", "when": f"t > {t}", "action": "release", "joint": "weld"},
        ],
        "integrator": scenarios.settings(0.2), "output": {"times": [0, 0.05, 0.2]},
        "quantities": [{"name": "momentum", "type": "momentum"}],
    }  # fmt: skip
    ds = lienumba.run(data).isel(run=0)
    seen = [R.as_matrix() @ own @ R.as_matrix().T for R, own in zip(TURN, J, strict=True)]
    spins = [R.apply(w) for R, w in zip(TURN, W, strict=True)]
    _, turn, lost = together(M, seen, places, V, spins)
    assert float(ds.energy_lost) == pytest.approx(lost, rel=1e-12)
    for kind in ("linear", "angular"):
        p = ds[f"momentum.{kind}"].values
        np.testing.assert_allclose(p, np.broadcast_to(p[0], p.shape), rtol=0, atol=1e-13 * abs(p[0]).max())
    w = [ds.rotation.values[1, i] @ ds.angular_velocity.values[1, i] for i in range(2)]
    np.testing.assert_allclose(w[0], w[1], rtol=0, atol=1e-13)
    assert np.linalg.norm(w[0] - turn) < 0.2 * np.linalg.norm(turn)  # it turns on for 0.05 s
    np.testing.assert_allclose(ds.energy_residual, ds.energy_residual[0], rtol=0, atol=1e-12)
    assert [*ds.mode.values[:, 0]] == [1, 1, 0]


def test_a_rod_topples_on_a_hinge_that_lets_go() -> None:
    """The tip-off rate is that at the release, and the rod flies on as a free body."""
    length, start, end = 2.0, 0.05, 0.8
    when, rate = topples(length, start, end)
    data = {
        "title": "A rod that is let go",
        "quantities": [{"name": "lean", "type": "joint", "joint": "hinge"}],
        "events": [{"name": "free", "when": f"lean.angle > {end}", "action": "release", "joint": "hinge"}],
        "model": {
            "gravity": [0, 0, -9.81],
            "bodies": [parts.body("rod", 3, [length**2 / 4, length**2 / 4, 0.01])],
            "joints": [
                parts.joint("hinge", "revolute", "rod", **parts.frames(parts.Y, second=[0, 0, -0.5 * length]))
                | {"references": [[0, 0, 1]] * 2, "angle": start, "rate": 0}
            ],
        },
        "integrator": scenarios.settings(when + 0.3), "output": {"times": [0, when + 0.3]},
    }  # fmt: skip
    ds = lienumba.run(data).isel(run=0)
    assert float(ds.event_time[0]) == pytest.approx(when, abs=1e-10)
    assert float(ds.angular_velocity[-1, 0, 1]) == pytest.approx(rate, abs=1e-10)
    half = 0.5 * length
    x = half * math.sin(end) + half * math.cos(end) * rate * 0.3
    z = half * math.cos(end) - half * math.sin(end) * rate * 0.3 - 0.5 * 9.81 * 0.3**2
    np.testing.assert_allclose(ds.position.values[-1, 0], [x, 0, z], rtol=0, atol=1e-9)
    assert float(ds.energy_lost) == 0.0
