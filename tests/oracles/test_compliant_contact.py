"""A ball that drops on a floor that yields, bounces, slides and rolls, against SciPy in minimal coordinates."""

import numpy as np
from scipy.integrate import solve_ivp

import lienumba

STIFFNESS, DISSIPATION, SPEED, STATIC, KINETIC = 2e3, 0.3, 0.02, 0.5, 0.3
MASS, INERTIA, RADIUS, GRAVITY = 1.2, 0.004, 0.1, 9.81


def ball() -> lienumba.System:
    system = lienumba.System("A ball on a floor that yields")
    system.body("ball", mass=MASS, inertia=[INERTIA] * 3, position=[0, 0, 0.5], rotation=[1, 0, 0, 0],
                velocity=[1, 0, 0], angular_velocity=[0, 0, 0])  # fmt: skip
    friction = {"static": STATIC, "kinetic": KINETIC}
    system.contact("floor", "sphere_plane", ["ball", system.ground], radius=RADIUS, stiffness=STIFFNESS,
                   dissipation=DISSIPATION, friction=friction, velocity=SPEED)  # fmt: skip
    system.quantity("touch", "contact", contact="floor")
    return system.integrator(method="dop853", tolerance=1e-11, max_step=0.01, end_time=1.0).output(every=0.05)


def forces(y: np.ndarray) -> tuple[float, float]:
    """Normal force, and friction along x."""
    _, z, vx, vz, w = y
    push = STIFFNESS * max(0.0, RADIUS - z) * max(0.0, 1.0 - DISSIPATION * vz)
    slip = vx - RADIUS * w
    fast = abs(slip) + 1e-300
    mu = np.tanh(fast / SPEED) * (KINETIC + (STATIC - KINETIC) * np.exp(-((fast / (10 * SPEED)) ** 2)))
    return push, -mu * push * slip / fast


def rates(t: float, y: np.ndarray) -> list[float]:
    push, friction = forces(y)
    return [y[2], y[3], friction / MASS, push / MASS - GRAVITY, -RADIUS * friction / INERTIA]


def test_motion_forces_and_energy() -> None:
    ds = lienumba.run(ball())
    times = ds.time.values
    exact = solve_ivp(rates, (0, 1), [0, 0.5, 1, 0, 0], "DOP853", times, rtol=1e-12, atol=1e-13, max_step=2e-3).y
    found = ds.position.values[0, :, 0], ds.angular_velocity.values[0, :, 0]
    np.testing.assert_allclose(found[0][:, 0], exact[0], atol=1e-9)
    np.testing.assert_allclose(found[0][:, 2], exact[1], atol=1e-9)
    np.testing.assert_allclose(found[1][:, 1], exact[4], atol=1e-8)
    wanted = np.array([forces(y) for y in exact.T])
    assert (wanted[:, 0] > 0).any()
    assert (wanted[:, 0] == 0).any()
    np.testing.assert_allclose(ds["touch.normal"].values[0], wanted[:, 0], atol=1e-6)
    np.testing.assert_allclose(ds["touch.friction"].values[0], abs(wanted[:, 1]), atol=1e-6)
    np.testing.assert_array_equal(ds["touch.on"].values[0], wanted[:, 0] > 0)
    assert abs(ds.energy_residual).max() < 1e-9
