"""Chains, loops and full inertia tensors against the naive NumPy twin, and joint forces against Newton's law."""

from typing import Any

import numpy as np
import pytest

from tests.facade import METHODS
from tests.oracles.reference import naive
from tests.rigs.scenarios import LOOP, PENDULUM, chain, scenario, simulate, state_at, twin_of

STEP, STEPS = 2e-3, 60
MECHANISMS = {"pendulum": PENDULUM, "chain of 5": chain(5), "loop": LOOP}


def twin_run(data: dict[str, Any], projection: tuple[str, str]) -> Any:
    """The twin's state after STEPS steps of RK4."""
    (bodies, joints, gravity), state = twin_of(data)
    tableau = METHODS["rk4"]
    for _ in range(STEPS):
        r, R, v, w = naive.step(bodies, joints, gravity, state, STEP, tableau.A, tableau.b, truncation=2)
        if projection[0] != "none":
            r, R, _ = naive.project_positions(joints, r, R, tolerance=1e-14)
        if projection[1] != "none":
            v, w = naive.project_velocities(bodies, joints, r, R, v, w, projection[1])
        state = (r, R, v, w)
    return state


@pytest.mark.parametrize("projection", [("none", "none"), ("local", "mass")], ids="+".join)
@pytest.mark.parametrize("name", MECHANISMS)
def test_the_same_motion_as_the_twin(name: str, projection: tuple[str, str]) -> None:
    data = scenario(MECHANISMS[name], STEP, STEPS * STEP, projection=projection)
    there = twin_run(data, projection)
    here = simulate(MECHANISMS[name], STEP, STEPS * STEP, projection=projection)
    for part, expected, start in zip(state_at(here), there, state_at(here, 0), strict=True):
        np.testing.assert_allclose(part, expected, rtol=0, atol=2e-11)
        assert np.abs(part - start).max() > 0.02


@pytest.mark.parametrize("name", MECHANISMS)
def test_the_start_fulfils_the_joints(name: str) -> None:
    (bodies, joints, _), (r, R, v, w) = twin_of(scenario(MECHANISMS[name], STEP, STEP))
    assert np.abs(naive.residual(joints, r, R)).max() < 1e-14
    assert np.abs(naive.jacobian(joints, r, R) @ np.hstack([v, w]).ravel()).max() < 1e-14
    assert np.linalg.matrix_rank(naive.jacobian(joints, r, R)) == sum(naive.rows_of(joint) for joint in joints)
    assert len(bodies) > 1


@pytest.mark.parametrize("name", MECHANISMS)
def test_what_is_observed_is_what_the_twin_computes_there(name: str) -> None:
    data = scenario(MECHANISMS[name], STEP, STEPS * STEP)
    (bodies, joints, gravity), _ = twin_of(data)
    here = simulate(MECHANISMS[name], STEP, STEPS * STEP, method="heun", projection=("none", "none"))
    r, R, v, w = state_at(here)
    end = here.isel(time=-1)
    _, multipliers = naive.accelerations(bodies, joints, gravity, r, R, v, w)
    np.testing.assert_allclose(end["multiplier"], multipliers, rtol=1e-10, atol=1e-10)
    kinetic, potential = naive.energies(bodies, gravity, r, v, w)
    np.testing.assert_allclose(end["kinetic_energy"], kinetic, rtol=1e-14)
    np.testing.assert_allclose(end["potential_energy"], potential, rtol=1e-13)
    np.testing.assert_allclose(end["energy"], kinetic + potential, rtol=1e-13)
    residual = np.abs(naive.residual(joints, r, R)).max()
    rate = np.abs(naive.jacobian(joints, r, R) @ np.hstack([v, w]).ravel()).max()
    assert min(residual, rate) > 1e-8
    np.testing.assert_allclose(end["position_violation"], residual, rtol=1e-6)
    np.testing.assert_allclose(end["velocity_violation"], rate, rtol=1e-6)


@pytest.mark.parametrize("name", MECHANISMS)
def test_joint_forces_and_torques_move_every_body_by_newtons_law(name: str) -> None:
    """Force and torque act on the second body at its point there, and opposite on the first at that same point."""
    data = scenario(MECHANISMS[name], STEP, STEPS * STEP)
    (bodies, joints, gravity), _ = twin_of(data)
    here = simulate(MECHANISMS[name], STEP, STEPS * STEP)
    r, R, v, w = state_at(here)
    end = here.isel(time=-1)
    accelerations, _ = naive.accelerations(bodies, joints, gravity, r, R, v, w)
    force = np.array([body.mass * gravity for body in bodies])
    torque = np.zeros_like(force)  # about the mass centres, global
    for j, joint in enumerate(joints):
        f, t = end["joint_force"].values[j], end["joint_torque"].values[j]
        np.testing.assert_allclose(t, 0, atol=1e-12 * (1 + np.abs(f).max()))
        (rb, Rb) = naive.placement(r, R, joint.bodies[1])
        here_it_acts = rb + Rb @ joint.points[1]
        for body, sign in zip(joint.bodies, (-1.0, 1.0), strict=True):
            if body != naive.GROUND:
                force[body] += sign * f
                torque[body] += sign * (t + np.cross(here_it_acts - r[body], f))
    for i, body in enumerate(bodies):
        np.testing.assert_allclose(force[i], body.mass * accelerations[i, :3], atol=1e-9)
        J = naive.inertia(body)
        turning = J @ accelerations[i, 3:] + np.cross(w[i], J @ w[i])
        np.testing.assert_allclose(R[i].T @ torque[i], turning, atol=1e-9)
    assert np.abs(end["joint_force"]).max() > 1.0


def test_a_rod_pulls_along_itself() -> None:
    data = scenario(LOOP, STEP, STEPS * STEP)
    (_, joints, _), _ = twin_of(data)
    here = simulate(LOOP, STEP, STEPS * STEP)
    r, R, _, _ = state_at(here)
    for j, joint in enumerate(joints):
        if joint.type == "distance":
            d, f = naive.separation(joint, r, R), here["joint_force"].values[-1, j]
            np.testing.assert_allclose(np.cross(d, f), 0, atol=1e-11)
            multiplier = float(here["multiplier"].isel(time=-1).sel(constraint=f"{joint.name}[0]"))
            np.testing.assert_allclose(f, multiplier * d / np.linalg.norm(d), atol=1e-11)
            assert np.linalg.norm(d) == pytest.approx(joint.numbers["length"], abs=1e-13)
