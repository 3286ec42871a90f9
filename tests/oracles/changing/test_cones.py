"""Bodies on a sphere and on points, whose contacts say the same along the line between them, slide until they roll."""

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import lienumba
from tests.rigs import parts

G, MASS, INERTIA, RADIUS, MU = 9.81, 3.7, np.diag([0.08, 0.15, 0.17]), 0.15, 0.3
BALL, TIP = np.array([-0.1, 0, 0]), np.array([0.5, 0, -RADIUS])
UP = np.array([0, 0, 1.0])
BODY = parts.body("b", MASS, [0.08, 0.15, 0.17], position=[0, 0, RADIUS])
ROUGH: dict[str, Any] = {"normal": [0, 0, 1], "friction": MU}
CONTACTS = [parts.sphere("ball", "b", RADIUS, BALL.tolist(), **ROUGH), parts.foot("tip", "b", TIP.tolist(), **ROUGH)]


def rows(y: np.ndarray) -> np.ndarray:
    """The normal and both tangents of the ball, then of the tip."""
    R = y[3:12].reshape(3, 3)
    arms = (R @ BALL - RADIUS * UP, R @ TIP)
    return np.array([np.concatenate([e, np.cross(arm, e)]) for arm in arms for e in np.eye(3)[[2, 0, 1]]])


def slips(y: np.ndarray) -> np.ndarray:
    return (rows(y) @ y[12:]).reshape(2, 3)[:, 1:]


def inverse_of_mass(y: np.ndarray) -> np.ndarray:
    R, inverse = y[3:12].reshape(3, 3), np.eye(6) / MASS
    inverse[3:, 3:] = R @ np.linalg.inv(INERTIA) @ R.T
    return inverse


def slope(_: float, y: np.ndarray, sticks: tuple[bool, ...]) -> np.ndarray:
    """Of the position, the rotation, and both velocities (global), with both contacts closed."""
    R, v, W, J = y[3:12].reshape(3, 3), y[12:15], y[15:], rows(y)
    bias = np.concatenate([np.cross(W, np.cross(W, R @ point))[[2, 0, 1]] for point in (BALL, TIP)])
    inertia, inverse = R @ INERTIA @ R.T, inverse_of_mass(y)
    push, used = J.T.copy(), []
    for n, slip in enumerate(slips(y)):  # of what slides, forces along normals bring friction with them
        used += [3 * n, 3 * n + 1, 3 * n + 2] if sticks[n] else [3 * n]
        push[:, 3 * n] -= 0 if sticks[n] else MU * push[:, 3 * n + 1 : 3 * n + 3] @ slip / np.linalg.norm(slip)
    J, push, bias = J[used], push[:, used], bias[used]
    free = np.concatenate([-G * UP, inverse[3:, 3:] @ -np.cross(W, inertia @ W)])
    x = np.linalg.lstsq(J @ inverse @ push, -(J @ free + bias), rcond=1e-10)[0]
    return np.concatenate([v, np.cross(W, R.T).T.ravel(), free + inverse @ push @ x])


def moved(v: tuple[float, float], end: float) -> np.ndarray:
    """Where the body is at the end, with SciPy: each contact slides until it slips by less than 1e-5 m/s."""

    def ends(_: float, y: np.ndarray, sticks: tuple[bool, ...]) -> float:
        return (
            float(min(s for s, stuck in zip(np.linalg.norm(slips(y), axis=1), sticks, strict=True) if not stuck)) - 1e-5
        )

    ends.terminal = True  # type: ignore[attr-defined]
    t, y, sticks = 0.0, np.concatenate([[0, 0, RADIUS], np.eye(3).ravel(), v, [0.0] * 4]), (False, False)
    while t < end:
        events = None if all(sticks) else ends
        found = solve_ivp(slope, (t, end), y, args=(sticks,), events=events, rtol=1e-9, atol=1e-10, method="DOP853")
        t, y = found.t[-1], found.y[:, -1]
        sticks = tuple(bool(x) for x in np.linalg.norm(slips(y), axis=1) < 2e-5)
        J, inverse = rows(y)[[True, sticks[0], sticks[0], True, sticks[1], sticks[1]]], inverse_of_mass(y)
        y[12:] -= inverse @ J.T @ np.linalg.lstsq(J @ inverse @ J.T, J @ y[12:], rcond=1e-10)[0]
    return y


@pytest.mark.parametrize("v", [(0.3, 0.5), (-0.2, 0.7), (0.1, -0.9), (0.6, -0.2)])
@pytest.mark.parametrize(("integrator", "atol"), [({"tolerance": 1e-10}, 1e-6), ({"step": 1e-3}, 1e-4)])
def test_a_body_on_a_sphere_and_a_point_rolls_like_a_cone(v, integrator, atol):
    """Its sticking forces are 0.07 of what presses; what is left of slips would be accelerations that none give."""
    model = {"gravity": [0, 0, -G], "bodies": [BODY | {"velocity": [*v, 0]}], "contacts": CONTACTS}
    scenario = {"model": model, "integrator": {"method": "dop853", "end_time": 0.9} | integrator}
    found = lienumba.run(scenario | {"output": {"every": 0.9}}).isel(run=0)
    assert found.status.item() == 0
    y = moved(v, 0.9)
    np.testing.assert_allclose(found.last_position.values.ravel(), y[:3], atol=atol)
    R = found.last_rotation.values.reshape(3, 3)
    np.testing.assert_allclose(R, y[3:12].reshape(3, 3), atol=4 * atol)
    assert found.last_mode.values.tolist() == [1, 1]


def thrown(seed: int) -> dict[str, Any]:
    """A body on two or three spheres and points at random places, thrown along the floor with a spin."""
    random = np.random.default_rng(seed)
    a, b, c = random.uniform(0.05, 0.15, 3)
    contacts, count = [], int(random.integers(2, 4))
    for n in range(count):
        turn, arm = 2 * np.pi * (n + random.uniform(-0.3, 0.3)) / count, random.uniform(0.1, 0.6)
        radius = float(random.choice([0.0, 0.05, 0.15]) if n else random.choice([0.05, 0.15, 0.25]))
        where = [arm * np.cos(turn), arm * np.sin(turn), radius - 0.3]
        kind = {"type": "sphere_plane", "radius": radius} if radius > 0 else {}
        contacts.append(parts.foot(f"c{n}", "b", where) | kind | ROUGH)
    body = parts.body("b", MASS, [a + b, b + c, c + a], position=[0, 0, 0.3]) | parts.AT_REST
    vary = {f"bodies.b.velocity[{n}]": (-1, 1) for n in (0, 1)} | {"bodies.b.angular_velocity[2]": (-2, 2)}
    return {
        "model": {"gravity": [0, 0, -G], "bodies": [body], "contacts": contacts},
        "integrator": {"method": "dop853", "tolerance": 1e-8, "end_time": 1.0},
        "output": {"every": 1.0},
        "sweep": parts.sweep(32, vary, seed=seed),
    }


@pytest.mark.parametrize("seed", [3, 8, 14, 17, 18])
def test_bodies_on_spheres_and_points_come_to_rest_or_roll(seed):
    found = lienumba.run(thrown(seed))
    np.testing.assert_array_equal(found.status.values, 0)
    assert float(abs(found.energy_residual).max()) < 1e-7
