"""An arm to try joints with: body a turns about a skew axis of the ground, body b hangs on it by the joint."""

from typing import Any

import numpy as np

import lienumba
from tests.oracles.minimal.coordinates import Minimal, frame, turn

GRAVITY = np.array([0.7, -1.1, -9.5])
MASSES = np.array([1.3, 0.8])
INERTIAS = np.array(
    [
        [[0.30, 0.02, -0.01], [0.02, 0.25, 0.03], [-0.01, 0.03, 0.35]],
        [[0.12, -0.01, 0.02], [-0.01, 0.15, 0.01], [0.02, 0.01, 0.10]],
    ]
)
BASE, ON_A = np.array([0.2, -0.1, 0.4]), np.array([-0.3, 0.1, 0.2])  # where a hangs
AXIS, AXIS_A = np.array([0.3, 1.0, 0.4]), np.array([1.0, 0.2, -0.3])
HINGE, HINGE_A = frame(AXIS, np.array([1.0, 0, 0])), frame(AXIS_A, np.array([0, 0, 1.0]))
P, S = np.array([0.4, 0.2, -0.1]), np.array([-0.2, 0.3, 0.25])  # the joint's points on a and on b
Z, Z_B = np.array([0.5, -0.4, 1.0]), np.array([-0.2, 1.0, 0.6])
X, X_B = np.array([1.0, 0.3, 0.0]), np.array([0.0, 0.4, 1.0])
F, F_B = frame(Z, X), frame(Z_B, X_B)


def place_a(angle):
    R = HINGE @ turn((0, 0, 1), angle) @ HINGE_A.T
    return BASE - R @ ON_A, R


def place_b(a, d, Q):
    """b whose point is displaced by d from that of a, and turned by Q, both in a's frame."""
    r, R = a
    return r + R @ (P + d - Q @ S), R @ Q


def arm(relative, hinge=lambda q, t: q[0], forces=None):
    """relative(q, t) -> d, Q; hinge(q, t): the angle of a."""

    def places(q, t):
        a = place_a(hinge(q, t))
        return [a, place_b(a, *relative(q, t))]

    return Minimal(MASSES, INERTIAS, places, GRAVITY, forces)


HINGE_JOINT: dict[str, Any] = {
    "name": "hinge",
    "type": "revolute",
    "bodies": ["ground", "a"],
    "points": [BASE, ON_A],
    "axes": [AXIS, AXIS_A],
    "references": [HINGE[:, 0], HINGE_A[:, 0]],
}


def scenario(oracle, q, dq, joints, end, step=1e-3, **model):
    """A scenario that starts where the oracle does."""
    keys = ("position", "rotation", "velocity", "angular_velocity")
    start = [dict(zip(keys, state, strict=True)) for state in oracle.state(q, dq, 0.0)]
    bodies = [
        {"name": name, "mass": m, "inertia": inertia, **state}
        for name, m, inertia, state in zip("ab", oracle.masses, oracle.inertias, start, strict=False)
    ]
    return {
        "model": {"gravity": oracle.gravity, "bodies": bodies, "joints": joints, **model},
        "integrator": {"step": step, "end_time": end},
        "output": {"times": [0.0, end]},
    }


def run(data):
    """The dataset of the only run, which must be good and hold its constraints."""
    dataset = lienumba.run(data).isel(run=0)
    assert int(dataset.status) == 0
    assert float(dataset.max_position_violation) < 1e-11
    assert float(dataset.max_velocity_violation) < 1e-10
    return dataset


def assert_same(dataset, oracle, q, dq, end, tolerance=1e-9):
    """The last state is the oracle's."""
    last = dataset.isel(time=-1)
    for i, (r, R, v, w) in enumerate(oracle.state(q, dq, end)):
        np.testing.assert_allclose(last.position[i], r, rtol=0, atol=tolerance)
        np.testing.assert_allclose(last.rotation[i], R, rtol=0, atol=tolerance)
        np.testing.assert_allclose(last.velocity[i], v, rtol=0, atol=10 * tolerance)
        np.testing.assert_allclose(last.angular_velocity[i], w, rtol=0, atol=10 * tolerance)
