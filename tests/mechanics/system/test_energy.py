"""Energy: its value, and that ideal joints never change it."""

import numpy as np
import pytest

from lienumba.groups import so3
from lienumba.mechanics.system import constraints, dynamics, kkt
from lienumba.mechanics.system.projection import MASS, velocity_correction
from lienumba.numerics.jets import Jet, lift
from tests.facade import Body, Instant, Model
from tests.oracles.reference import naive
from tests.rigs.mechanisms import GRAVITY, TOPOLOGIES, arrays, model, rows, state
from tests.rigs.scenarios import start_of

MOVABLE = ["top", "chain", "star on the ground", "hexapod", "ladder", "two rings", "rod between", "free body"]


@pytest.mark.parametrize("name", TOPOLOGIES)
def test_energies_are_those_of_the_naive_twin(name):
    k, ends = TOPOLOGIES[name]
    m, x = model(k, ends, 4), state(k, 4)
    r, _, v, w = arrays(x)
    assert dynamics.energies(m, Instant(x)) == pytest.approx(naive.energies(m.bodies, m.gravity, r, v, w), rel=1e-12)


def test_a_known_case():
    body = Body("b", 2.0, (1.0, 2.0, 3.0, 0.1, 0.2, 0.3))
    x = ((1.0, 2.0, 3.0, *so3.IDENTITY, 1.0, 0.0, 2.0, 1.0, 1.0, 1.0),)
    kinetic, potential = dynamics.energies(Model((0.0, 0.0, -10.0), (body,), ()), Instant(x))
    assert kinetic == pytest.approx(0.5 * 2.0 * 5.0 + 0.5 * (1 + 2 + 3 + 2 * (0.1 + 0.2 + 0.3)), rel=1e-15)
    assert potential == pytest.approx(2.0 * 10.0 * 3.0, rel=1e-15)


def test_kinetic_energy_is_half_the_mass_matrix():
    m, x = model(3, [], 6), state(3, 6)
    full = np.zeros((18, 18))
    for (i, j), value in dynamics.mass_matrix(m, Instant(x)).items():
        full[i, j] = full[j, i] = value
    np.testing.assert_allclose(full, naive.mass_matrix(m.bodies), atol=0.0)
    _, _, v, w = arrays(x)
    u = np.hstack([v, w]).ravel()
    assert dynamics.energies(m, Instant(x))[0] == pytest.approx(0.5 * u @ full @ u, rel=1e-13)


def test_zero_products_of_inertia_leave_no_entry():
    body = Body("b", 2.0, (1.0, 2.0, 3.0, 0.0, 0.0, 0.5))
    entries = dynamics.mass_matrix(Model(GRAVITY, (body, body), ()), Instant(()))
    assert (5, 4) in entries
    assert (4, 3) not in entries
    assert (5, 3) not in entries
    assert entries[11, 10] == 0.5


def compatible(m, x):
    """The state with the velocities nearest to its own that the joints allow."""
    change = velocity_correction(m, kkt.Structure.of(m), Instant(x), MASS, [1.0] * rows(m)).x
    return tuple(
        body[:12] + tuple(v + c for v, c in zip(body[12:], change[6 * i : 6 * i + 6], strict=True))
        for i, body in enumerate(x)
    )


@pytest.mark.parametrize("name", MOVABLE)
def test_the_motion_of_ideal_joints_conserves_energy(name):
    """The rate of energy along the computed accelerations; velocities as the joints allow them."""
    k, ends = TOPOLOGIES[name]
    m = model(k, ends, 5)
    x = compatible(m, state(k, 5))
    assert np.abs(constraints.rate_and_bias(m, Instant(x))[0] or [0.0]).max() < 1e-10
    kinetic, potential = energy_rates(m, x, dynamics.accelerations(m, kkt.Structure.of(m), Instant(x)).x)
    assert abs(kinetic + potential) < 1e-9 * (1.0 + abs(kinetic))
    assert abs(kinetic) > 1e-3  # weight does work: there is something to balance


@pytest.mark.parametrize("motion", [{"value": "0.3 + 2*t + t*t"}, {"rate": "2 + 2*t"}], ids=["value", "rate"])
def test_the_power_of_a_driver_is_the_rate_of_energy(motion):
    hinge = {
        "name": "hinge", "type": "revolute", "bodies": ["ground", "arm"], "points": [[0, 0, 0], [-0.5, 0, 0.1]],
        "axes": [[0, 1, 0.2]] * 2, "references": [[1, 0, 0]] * 2, **({} if "value" in motion else {"angle": 0.3}),
    }  # fmt: skip
    arm = {"name": "arm", "mass": 1.5, "inertia": [0.1, 0.2, 0.15, 0.01, 0.02, -0.01]}
    moves = {"bodies": [arm], "joints": [hinge], "drivers": [{"joint": "hinge", **motion}]}
    m, states = start_of({"model": moves, "integrator": {"step": 0.01, "end_time": 1.0}})
    x = tuple(map(tuple, states.tolist()))
    solution = dynamics.accelerations(m, kkt.Structure.of(m), Instant(x))
    rate = sum(energy_rates(m, x, solution.x))
    assert dynamics.power(m, Instant(x), solution.mu) == pytest.approx(rate, rel=1e-12)
    assert abs(rate) > 1.0


def energy_rates(m, x, a):
    """Of the kinetic and the potential energy along accelerations, by jets."""
    moving = tuple(
        tuple(Jet(p, v) for p, v in zip(body[:3], body[12:15], strict=True))
        + body[3:12]
        + tuple(Jet(v, dv) for v, dv in zip(body[12:], a[6 * i : 6 * i + 6], strict=True))
        for i, body in enumerate(x)
    )
    return [lift(energy).b for energy in dynamics.energies(m, Instant(moving))]


def test_without_joints_angular_momentum_stays():
    """Euler's equation: d/dt (R J w) = 0."""
    m, x = model(1, [], 7), state(1, 7)
    _, (R,), _, (w,) = arrays(x)
    J = naive.inertia(m.bodies[0])
    a = np.array(dynamics.accelerations(m, kkt.Structure.of(m), Instant(x)).x)
    np.testing.assert_allclose(R @ (naive.hat(w) @ J @ w + J @ a[3:]), 0.0, atol=1e-12)
    np.testing.assert_allclose(a[:3], m.gravity, atol=1e-14)


@pytest.mark.parametrize("name", ["free chain", "star", "star of rods", "ring", "tetrahedron of rods"])
def test_joint_forces_cancel_in_the_sum_over_all_bodies(name):
    """Nothing is tied to the ground, so the mass centre falls freely."""
    k, ends = TOPOLOGIES[name]
    m, x = model(k, ends, 8), state(k, 8)
    a = np.reshape(dynamics.accelerations(m, kkt.Structure.of(m), Instant(x)).x, (k, 6))
    masses = np.array([b.mass for b in m.bodies])
    np.testing.assert_allclose(masses @ a[:, :3], masses.sum() * np.array(m.gravity), atol=1e-9)


@pytest.mark.parametrize("name", ["star of rods", "tetrahedron of rods"])
def test_rods_keep_the_angular_momentum(name):
    """A rod pulls along its own line, wherever its bodies are: no moment about any point is left."""
    k, ends = TOPOLOGIES[name]
    m, x = model(k, ends, 8), state(k, 8)
    r, R, _, w = arrays(x)
    a = np.reshape(dynamics.accelerations(m, kkt.Structure.of(m), Instant(x)).x, (k, 6))
    moment = np.zeros(3)
    for i, b in enumerate(m.bodies):
        J = naive.inertia(b)
        moment += R[i] @ (J @ a[i, 3:] + np.cross(w[i], J @ w[i]))
        moment += np.cross(r[i], b.mass * (a[i, :3] - np.array(m.gravity)))
    np.testing.assert_allclose(moment, 0.0, atol=1e-8)
