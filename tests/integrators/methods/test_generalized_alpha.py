"""Generalised-alpha steps: the published recurrence, order 2 also of multipliers, the damping that is asked for."""

from typing import Any

import numpy as np
import pytest

import lienumba
from lienumba.scenario.reading.loading import load
from tests.facade import ScenarioError
from tests.integrators.methods.test_radau import END, bars
from tests.rigs.places import SCENARIOS
from tests.rigs.scenarios import TOP, exact_top, scenario

WAY: dict[str, Any] = {"integrator.method": "generalized_alpha"}


def oscillator(stiffness: float, damping: float, **integrator: Any) -> lienumba.System:
    """A mass of 2 kg on a rail, on a spring that is stretched by 1 m at the start."""
    system = lienumba.System("oscillator").body("mass", mass=2.0, inertia=[1, 1, 1], position=[1, 0, 0])
    system.joint("rail", "prismatic", ["ground", "mass"], at=[0, 0, 0], axis=[1, 0, 0])
    system.force(
        "spring", type="bushing", bodies=["ground", "mass"], points=[[0, 0, 0]] * 2, stiffness=[stiffness, 0, 0],
        damping=[damping, 0, 0], rotational_stiffness=[0, 0, 0], rotational_damping=[0, 0, 0],
    )  # fmt: skip
    return system.integrator(**{"method": "generalized_alpha", "coordinates": "joint", "end_time": 1.0} | integrator)


def published(rho: float, stiffness: float, damping: float, h: float, steps: int) -> np.ndarray:
    """Places and velocities after each step: Bruels, Cardona and Arnold (2012), eq. 27 to 31, of the oscillator. The
    first a is at t + (am - af) h, with the slope of v' over the first step."""
    am, af = (2 * rho - 1) / (rho + 1), rho / (rho + 1)
    gamma = 0.5 + af - am
    beta = 0.25 * (gamma + 0.5) ** 2
    m = 2.0

    def matrix(start: bool) -> tuple[np.ndarray, np.ndarray]:
        """Of (q_1, v_1, v'_1, a_1, a_0) and of (q_0, v_0, v'_0, a as it came)."""
        left = np.array([
            [1, 0, 0, -beta * h * h, -(0.5 - beta) * h * h],
            [0, 1, 0, -gamma * h, -(1 - gamma) * h],
            [stiffness, damping, m, 0, 0],
            [0, 0, -(1 - af), 1 - am, am],
            [0, 0, -(am - af) * start, 0, 1],
        ])  # fmt: skip
        right = np.array([
            [1, h, 0, 0], [0, 1, 0, 0], [0, 0, 0, 0], [0, 0, af, 0], [0, 0, (1 - am + af) * start, 1 - start],
        ])  # fmt: skip
        return left, right

    q, v = 1.0, 0.0
    x = np.array([q, v, -stiffness / m, -stiffness / m])
    found = [x[:2]]
    for n in range(steps):
        left, right = matrix(n == 0)
        x = np.linalg.solve(left, right @ x)[:4]
        found.append(x[:2])
    return np.array(found)


@pytest.mark.parametrize(("rho", "stiffness", "damping"), [(0.8, 300.0, 4.0), (0.0, 1e8, 10.0), (1.0, 50.0, 0.0)])
def test_an_oscillator_follows_the_published_recurrence(rho: float, stiffness: float, damping: float) -> None:
    system = oscillator(stiffness, damping, step=0.02, rho_infinity=rho)
    found = lienumba.run(system, overrides={"output.every": 0.02})
    expected = published(rho, stiffness, damping, 0.02, 50)
    np.testing.assert_allclose(found.position.values[0, :, 0, 0], expected[:, 0], atol=1e-9)
    np.testing.assert_allclose(found.velocity.values[0, :, 0, 0], expected[:, 1], atol=1e-8 * np.sqrt(stiffness))


def test_what_is_left_of_a_vibration_that_steps_do_not_see_is_rho() -> None:
    """The eigenvalue at infinity is rho, three times: x_n is rho^n times a polynomial of n of order 2."""
    rho = 0.9
    system = oscillator(1e12, 0.0, step=0.02, rho_infinity=rho)
    x = abs(lienumba.run(system, overrides={"output.every": 0.02}).position.values[0, :, 0, 0]) / rho ** np.arange(51)
    ends = x[[20, 30, 40, 50]]
    assert abs(np.diff(ends, 3)[0]) < 1e-3 * abs(ends).max()


def orders(data: Any, exact: Any, ways: dict[str, Any], steps: tuple[int, ...], names: tuple[str, ...]) -> np.ndarray:
    errors = []
    for count in steps:
        found = lienumba.run(data, overrides=ways | {"integrator.step": END / count, "output.every": END})
        assert int(found.status[0]) == 0
        errors.append([abs(found[name].values[0, -1] - exact[name].values[0, -1]).max() for name in names])
    return np.log2(np.divide(errors[:-1], errors[1:]))


EVERYTHING = ("position", "velocity", "angular_velocity", "joint_force")


@pytest.mark.parametrize("coordinates", ["lie", "joint"])
def test_the_order_is_two_also_of_multipliers(coordinates: str) -> None:
    ways = {"output.every": END, "integrator.step": END / 400, "integrator.coordinates": coordinates}
    system = bars(1e3, 10.0)
    found = orders(system, lienumba.run(system, overrides=ways), ways | WAY, (64, 128, 256), EVERYTHING)
    np.testing.assert_allclose(found, 2, atol=0.2)


@pytest.mark.parametrize(("stiffness", "damping"), [(0.0, 1e6), (1e10, 1e5)])
def test_it_is_two_however_stiff_it_is_also_where_joints_are_rows(stiffness: float, damping: float) -> None:
    """A projection behind a step would move what the bushing holds, and the reactions are then its stiffness times
    that."""
    system = bars(stiffness, damping)
    exact = lienumba.run(system, overrides={"output.every": END, "integrator.step": END / 400})
    ways = WAY | {"integrator.coordinates": "lie"}
    np.testing.assert_allclose(orders(system, exact, ways, (96, 192, 384), EVERYTHING), 2, atol=0.2)


def test_and_of_loops_with_redundant_rows() -> None:
    data = load(SCENARIOS / "four_bar.toml")
    data["integrator"] = {"method": "rk4", "step": END / 400, "end_time": END, "coordinates": "joint"}
    data["output"] = {"every": END}
    found = orders(data, lienumba.run(data), WAY, (64, 128, 256), EVERYTHING)
    np.testing.assert_allclose(found, 2, atol=0.2)


def test_the_energy_that_works_is_followed_with_the_same_order() -> None:
    found = []
    for step in (0.02, 0.01, 0.005):
        ds = lienumba.run(oscillator(50.0, 3.0, step=step))
        assert abs(ds["work"]).max() > 5.0
        found.append(float(abs(ds["energy_residual"]).max()))
    np.testing.assert_allclose(np.log2(np.divide(found[:-1], found[1:])), 2, atol=0.2)


def test_steps_of_other_lengths_and_events_keep_the_order() -> None:
    """A force that jumps within a step cuts it there, and what was carried on is begun anew."""
    system = lienumba.System("pushed").body("mass", mass=2.0, inertia=[1, 1, 1], position=[0, 0, 0])
    system.joint("rail", "prismatic", ["ground", "mass"], at=[0, 0, 0], axis=[1, 0, 0])
    system.force("push", type="actuator", joint="rail", value="where(t < 0.123, 30*t, -50*t*t)")
    errors = []
    for step in (0.02, 0.01, 0.005):
        system.integrator(method="generalized_alpha", coordinates="joint", step=step, end_time=0.4)
        found = lienumba.run(system, overrides={"output.every": 0.4}).position.values[0, -1, 0, 0]
        a, b = 0.123, 0.4
        rate, place = 15 * a**2 / 2, 5 * a**3 / 2
        expected = place + (rate + 25 * a**3 / 3) * (b - a) - 25 * (b**4 - a**4) / 12
        errors.append(abs(found - expected))
    assert errors[-1] < 2e-5
    assert errors[-1] < 0.4 * errors[-2]


def test_on_se3_joints_to_ground_need_no_projection() -> None:
    ways = {"integrator.method": "generalized_alpha", "integrator.group": "SE3", "projection.position": "none"}
    found = lienumba.run(scenario(TOP, 2e-4, 0.1), overrides=ways | {"projection.velocity": "none"})
    assert float(found.max_position_violation[0]) < 1e-14
    assert abs(found.position.values[0, -1, 0] - exact_top(0.1).r).max() < 3e-4


@pytest.mark.parametrize(("name", "end", "error"), [("falling_rod", 1.0, 5e-5), ("door_closer", 2.0, 5e-5)])
def test_constraints_that_come_and_go(name: str, end: float, error: float) -> None:
    """A rod that slips and strikes the floor; a door with friction that runs into its stop."""
    data = load(SCENARIOS / f"{name}.toml")
    data["integrator"] = {"method": "dop853", "tolerance": 1e-9, "end_time": end, "coordinates": "joint"}
    data["output"] = {"every": end}
    given = {"integrator.tolerance": None, "integrator.step": end / 200}
    exact, found = lienumba.run(data), lienumba.run(data, overrides=WAY | given)
    assert int(found.status[0]) == int(exact.status[0])
    assert abs(found.position - exact.position).max() < error


def test_neighbours_change_no_bit() -> None:
    vary = {"forces.bush.stiffness[0]": {"distribution": "uniform", "low": 1e2, "high": 1e6}}
    ways = WAY | {"output.every": END / 8, "sweep": {"runs": 11, "seed": 3, "vary": vary}, "integrator.step": END / 64}
    system = bars(1e3, 10.0)
    every = lienumba.run(system, overrides=ways)
    assert (every.status == 0).all()
    alone = lienumba.run(system, overrides=ways, runs=[4])
    np.testing.assert_array_equal(every.position.values[4], alone.position.values[0])


def test_what_it_cannot_do_is_refused() -> None:
    top = scenario(TOP, 5e-4, 0.1)
    for ways, text in (
        ({"integrator.rho_infinity": 1.2}, r"integrator\.rho_infinity"),
        ({"integrator.method": "rk4", "integrator.rho_infinity": 0.5}, 'is that of the method "generalized_alpha"'),
        ({"integrator.step": None, "integrator.tolerance": 1e-6}, "does not estimate its error"),
        ({"integrator.coordinates": "quaternion"}, r'integrator\.coordinates = "quaternion": has no implicit steps'),
    ):
        with pytest.raises(ScenarioError, match=text):
            lienumba.run(top, overrides=WAY | ways)
