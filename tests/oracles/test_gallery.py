"""What the gallery's scenarios say one should look at, against closed forms."""

import math
from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import lienumba
from tests.rigs.places import SCENARIOS

G = 9.81
# The largest energy residual in J: of one step's error where the motion is smooth, of a contact where it is not.
ENERGY = {
    "slider_crank": 1e-6, "four_bar": 1e-7, "bricard": 1e-10, "bennett": 1e-6, "sarrus": 1e-8, "n_four_bar": 1e-7,
    "flyball_governor": 2e-4, "gyroscope_in_gimbals": 1e-5, "double_pendulum": 1e-5, "dzhanibekov": 1e-11,
    "belt_drive": 1e-5, "door_on_two_hinges": 2e-4, "screw_press": 1e-5,
}  # fmt: skip


@cache
def dataset(name: str) -> Any:
    return lienumba.run(SCENARIOS / f"{name}.toml")


def single(name: str) -> Any:
    return dataset(name).isel(run=0)


def angle(ds: Any, body: str, x: int = 0, y: int = 1) -> np.ndarray:
    """How far a body has turned in the plane of two global axes, over all turns (time,) rad."""
    R = ds.rotation.sel(body=body).values
    return np.unwrap(np.arctan2(R[:, y, x], R[:, x, x]))


def directions(ds: Any, links: list[tuple[str, tuple[float, float, float]]]) -> list[np.ndarray]:
    """Unit vectors (time, 3) of rods, from their directions at the start; all rotations begin as the identity."""
    fixed = np.broadcast_to(np.eye(3), (ds.sizes["time"], 3, 3))
    rotations = [fixed if name == "ground" else ds.rotation.sel(body=name).values for name, _ in links]
    return [R @ (np.array(u) / np.linalg.norm(u)) for R, (_, u) in zip(rotations, links, strict=True)]


@pytest.mark.parametrize("name", ENERGY)
def test_runs_to_the_end_on_its_constraints(name: str) -> None:
    ds = dataset(name)
    assert np.all(ds.status == 0)
    assert float(ds.max_position_violation.max()) <= 1e-11
    assert float(ds.max_velocity_violation.max()) <= 1e-11
    assert float(ds.max_energy_drift.max()) < ENERGY[name]


@pytest.mark.parametrize("name", ENERGY)
def test_says_in_three_lines_what_to_look_at(name: str) -> None:
    header = (SCENARIOS / f"{name}.toml").read_text(encoding="utf-8").split("\n\n")[0]
    lines = header.split("# What to look at:\n")[1].split("\n")
    assert len(lines) == 3
    assert all(line.startswith("#   ") and len(line) <= 120 for line in lines)


def test_slider_crank() -> None:
    ds, r, length, rate = single("slider_crank"), 0.05, 0.2, 20 * np.pi
    phi = rate * ds.time.values
    x = ds.position.sel(body="piston", axis="x").values
    np.testing.assert_allclose(x, r * np.cos(phi) + np.sqrt(length**2 - (r * np.sin(phi)) ** 2), atol=1e-12)
    effort, energy = ds.driver_effort.values[:-1, 0], ds.energy.values[:-1]  # ten whole periods
    frequencies = 2j * np.pi * np.fft.rfftfreq(energy.size, 1e-3)
    power = np.fft.irfft(frequencies * np.fft.rfft(energy), energy.size)
    np.testing.assert_allclose(effort * rate, power, atol=1e-6)
    assert effort.max() == pytest.approx(4.86, abs=0.01)
    assert abs(effort.mean()) < 1e-9


def test_four_bar() -> None:
    ds, a, b, c, d = single("four_bar"), 0.3, 1.0, 1.02, 1.28
    phi, psi = angle(ds, "crank"), angle(ds, "rocker")
    freudenstein = d / a * np.cos(psi) - d / c * np.cos(phi) + (a**2 - b**2 + c**2 + d**2) / (2 * a * c)
    np.testing.assert_allclose(freudenstein, np.cos(phi - psi), atol=1e-12)
    assert (phi[-1] - phi[0]) / (2 * np.pi) == pytest.approx(10.92, abs=0.01)
    assert np.degrees(np.ptp(psi)) == pytest.approx(34.7, abs=0.1)
    rates = ds.angular_velocity.sel(body="crank", axis="z").values
    assert (rates.min(), rates.max()) == pytest.approx((13.3, 24.1), abs=0.1)
    assert ds.joint_force.attrs["not_unique"] == "crank_bearing, crank_end, rocker_end, rocker_bearing"


def test_bricard() -> None:
    ds = single("bricard")
    edges = [(1, 0, 0), (0, -1, 0), (0, 0, 1), (-1, 0, 0), (0, 1, 0), (0, 0, -1)]
    rods = directions(ds, [*((f"rod{i + 1}", u) for i, u in enumerate(edges[:5])), ("ground", edges[5])])
    cosines = np.array([np.sum(rods[i - 1] * rods[i], axis=1) for i in range(6)])
    np.testing.assert_allclose(cosines[2::2], np.broadcast_to(cosines[0], (2, cosines.shape[1])), atol=1e-11)
    np.testing.assert_allclose(cosines[3::2], np.broadcast_to(cosines[1], (2, cosines.shape[1])), atol=1e-11)
    a, b = cosines[:2]
    np.testing.assert_allclose(a + b + a * b, 0.0, atol=1e-11)
    assert a.max() > 0.99  # it passes the flat position
    start, middle = ds.position.sel(body="rod3").values[0], ds.position.sel(body="rod3").values
    gone = np.linalg.norm(middle - start, axis=1)
    assert gone.max() > 1.5
    assert gone[200:300].min() < 0.01  # it comes back after 5 s


def test_bennett() -> None:
    ds = single("bennett")
    edges = [(-0.3, 0.4, -0.3), (-0.7, -0.4, 0.3), (0.3, -0.4, -0.3), (0.7, 0.4, 0.3)]
    rods = directions(ds, [("rod1", edges[0]), ("rod2", edges[1]), ("rod3", edges[2]), ("ground", edges[3])])
    axes = directions(ds, [("rod1", (-6, 3, 10)), ("rod2", (0, 3, 4))])
    halves = []
    for i in (0, 1):
        u, v = rods[i - 1], rods[i]
        sine, cosine = np.sum(axes[i] * np.cross(u, v), axis=1), np.sum(u * v, axis=1)
        halves.append(np.unwrap(np.arctan2(sine, cosine)) / 2)
    first, second = halves
    # The twists of the two kinds of rod follow from the axes at the start; without the poles of
    # tan(a/2) tan(b/2) = cos((alpha - beta)/2) / cos((alpha + beta)/2).
    alpha, beta = math.acos(49 / math.sqrt(145 * 25)), math.acos(31 / math.sqrt(145 * 25))
    left = np.sin(first) * np.sin(second) * math.cos((alpha + beta) / 2)
    right = np.cos(first) * np.cos(second) * math.cos((alpha - beta) / 2)
    np.testing.assert_allclose(left, right, atol=1e-11)
    assert abs(first[-1] - first[0]) > 2 * np.pi  # more than two turns


def test_sarrus() -> None:
    ds = single("sarrus")
    place = ds.position.sel(body="plate").values
    np.testing.assert_allclose(place[:, :2], 0.0, atol=1e-12)
    np.testing.assert_allclose(
        ds.rotation.sel(body="plate").values, np.broadcast_to(np.eye(3), (401, 3, 3)), atol=1e-12
    )
    assert place[:, 2].max() == pytest.approx(0.8, abs=1e-4)
    assert place[:, 2].min() == pytest.approx(0.8 - 2 * 7 * G / 500, abs=1e-4)


def test_n_four_bar() -> None:
    ds = single("n_four_bar")
    theta, rate = angle(ds, "bar1"), ds.angular_velocity.sel(body="bar1", axis="z").values
    for body in ("bar2", "bar3"):
        np.testing.assert_allclose(angle(ds, body), theta, atol=1e-9)
    for body in ("across1", "across2"):
        np.testing.assert_allclose(angle(ds, body), 0.0, atol=1e-9)
    # One degree of freedom: 3/2 rate^2 + 7/2 g cos(theta) stays the same.
    np.testing.assert_allclose(rate**2, 1 + 7 / 3 * G * (1 - np.cos(theta)), rtol=1e-6)
    level = np.diff(np.floor(theta / np.pi - 0.5))
    assert np.count_nonzero(level) >= 10  # so often all bars were in one line


def test_flyball_governor() -> None:
    ds = single("flyball_governor")
    axis = np.array([0.0, 0.0, 1.0])
    momentum = np.zeros(ds.sizes["time"])
    matter = {"shaft": (0.3, 5e-6, 5e-6), "slider": (3.0, 0.005, 0.005), "arm1": (5.3, 5e-6, 0.09575974)}
    for body, (mass, along, across) in (matter | {"arm2": matter["arm1"]}).items():
        r, v, w = (ds[name].sel(body=body).values for name in ("position", "velocity", "angular_velocity"))
        J = np.diag([along, across, across])
        spin = np.einsum("tij,jk,tk->ti", ds.rotation.sel(body=body).values, J, w)
        momentum += (mass * np.cross(r, v) + spin) @ axis
    np.testing.assert_allclose(momentum, momentum[0], rtol=5e-7)

    def amended(below: float) -> float:
        """The potential energy of the arms' angle below the level, that of the rotation included; rigid couplers."""
        r, drop = 0.05 + 0.9716981132075472 * math.cos(below), math.sin(below)
        inertia = 0.005 + 5e-6 + 2 * (5.3 * r * r + 0.09575974 * math.cos(below) ** 2 + 5e-6 * drop**2)
        return momentum[0] ** 2 / (2 * inertia) - G * drop * (2 * 5.3 * 0.9716981132075472 + 3.0)

    low, high = 0.0, math.radians(20)  # the arms rise from 30 degrees below the level to where they turn back
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if amended(middle) < amended(math.radians(30)) else (middle, high)
    slider = ds.position.sel(body="slider", axis="z").values
    assert slider.min() == pytest.approx(0.5, abs=1e-3)
    assert slider.max() == pytest.approx(1 - math.sin(low), abs=1e-3)
    assert ds.angular_velocity.sel(body="shaft", axis="z").values[np.argmax(slider)] < 5.2
    assert 0.001 < float(ds.energy[0] - ds.energy[-1]) < 0.01


def test_arm_stiff() -> None:
    """kd q' = kp (target - q): the weight moves it by some 1e-5 rad, inertia by less."""
    ds = lienumba.run(SCENARIOS / "arm_stiff.toml", runs=[-1]).isel(run=0)
    for name, target in (("shoulder", -0.8), ("elbow", 1.2)):
        expected = target * (1 - np.exp(-5 * ds.time.values))
        np.testing.assert_allclose(ds[f"{name}_angle.angle"], expected, rtol=0, atol=1e-4)
    assert 0 < float(abs(ds["shoulder_angle.angle"][-1] + 0.8)) < 3e-5
    assert int(ds.steps) < 300


def test_belt_drive() -> None:
    """As one wheel of the inertia that the motor sees, but for what gives way: J w' = torque(t) - 0.2 w."""
    ds = single("belt_drive")
    inertia, t = 9 * 0.00125 + 0.034 + 0.4, ds.time.values
    right = lambda t, w: (3 * (2 * (1 - math.exp(-2 * t)) + 0.5 * math.sin(12 * t)) - 0.2 * w) / inertia  # noqa: E731
    exact = solve_ivp(right, (0, 4), [0.0], t_eval=t, rtol=1e-10, atol=1e-10).y[0]
    np.testing.assert_allclose(ds["wheel.rate"], exact, rtol=0, atol=1e-4)
    np.testing.assert_allclose(ds["motor.rate"], 3 * ds["wheel.rate"], rtol=0, atol=1e-3)
    assert 2e-6 < float(ds.slack[-1]) < 5e-6
    assert ds.steps < 300


def test_gyroscope_in_gimbals() -> None:
    ds = single("gyroscope_in_gimbals")
    rate, _ = np.polyfit(ds.time.values, angle(ds, "outer"), 1)
    momentum = 0.00125 * 300
    assert rate == pytest.approx(0.5 * G * 0.06 / momentum, rel=1e-3)
    elevation = np.degrees(np.arcsin(ds.position.sel(body="inner", axis="z").values / 0.06))
    assert -1.3 < elevation.min() < -1.2
    assert elevation.max() < 1e-3
    about_x, about_z = 0.0005 + 0.0007 + 0.0018, 0.002 + 0.0007 + 0.0007 + 0.0018
    nods = ds.angular_velocity.sel(body="inner", axis="x").values
    number = np.count_nonzero((nods[1:] > 0) & (nods[:-1] <= 0))
    assert number == pytest.approx(9.0 * momentum / math.sqrt(about_x * about_z) / (2 * math.pi), abs=1.5)


def test_double_pendulum() -> None:
    ds = dataset("double_pendulum")
    spread = np.sqrt(ds.position.sel(body="lower").var("run").sum("axis").values)
    assert spread[0] < 1e-4
    assert spread[ds.time.values <= 3.0].max() > 10 * spread[0]
    assert spread[-1] > 0.4  # of 0.75 m that it can reach
    assert np.all(ds.velocity.isel(time=0) == 0.0)


def test_dzhanibekov() -> None:
    ds = single("dzhanibekov")
    J, w = np.array([1e-4, 2e-4, 2.5e-4]), ds.angular_velocity.sel(body="nut").values
    momentum = np.einsum("tij,tj->ti", ds.rotation.sel(body="nut").values, J * w)
    np.testing.assert_allclose(momentum, np.broadcast_to(momentum[0], momentum.shape), atol=1e-11)
    np.testing.assert_allclose(ds.kinetic_energy, 0.5 * np.sum(J * w[0] ** 2), rtol=1e-9)

    square, twice = np.sum((J * w[0]) ** 2), np.sum(J * w[0] ** 2)  # of the momentum; the energy
    fast = (J[1] - J[0]) * (twice * J[2] - square)
    slow = (J[2] - J[1]) * (square - twice * J[0])
    arithmetic, geometric = 1.0, math.sqrt(1 - slow / fast)  # of which the quarter period is made
    for _ in range(10):
        arithmetic, geometric = (arithmetic + geometric) / 2, math.sqrt(arithmetic * geometric)
    between = math.pi / arithmetic * math.sqrt(J.prod() / fast)
    t, y = ds.time.values, w[:, 1]
    before = np.flatnonzero(np.diff(np.sign(y)))
    flips = t[before] - y[before] * (t[before + 1] - t[before]) / (y[before + 1] - y[before])
    assert flips.size == 6
    np.testing.assert_allclose(np.diff(flips), between, rtol=1e-4)
    assert between == pytest.approx(3.62, abs=0.005)
    upright = ds.rotation.sel(body="nut", axis="y", body_axis="y").values
    assert upright.min() < -0.999
    assert upright[400:].max() > 0.999


def test_door_on_two_hinges() -> None:
    ds = single("door_on_two_hinges")
    t, opened = ds.time.values, angle(ds, "door")
    rate = ds.angular_velocity.sel(body="door", axis="z").values
    before = t < 1.38
    np.testing.assert_allclose(rate[before], 2.5 * np.exp(-t[before] / 6.7533) - 1.0, atol=1e-8)
    assert np.degrees(opened.max()) == pytest.approx(101.9, abs=0.1)
    assert np.degrees(opened[-1]) == pytest.approx(67.1, abs=0.1)
    assert abs(rate[-1]) < 1e-9
    np.testing.assert_allclose(ds.joint_force.sel(axis="z"), 0.5 * 25 * G, atol=1e-4)  # each hinge takes one half
    assert float(ds.work[-1]) == pytest.approx(-0.5 * 6.7533 * 1.5**2, abs=1e-4)


def test_screw_press() -> None:
    ds = single("screw_press")
    t, lead = ds.time.values, 0.005 / (8 * np.pi)  # m of the ram for one rad of the motor
    phi = 40 * np.pi * (1 - np.cos(0.5 * np.pi * t))
    rate, acceleration = 20 * np.pi**2 * np.sin(0.5 * np.pi * t), 10 * np.pi**3 * np.cos(0.5 * np.pi * t)
    ram = ds.position.sel(body="ram", axis="z").values
    np.testing.assert_allclose(ram, 0.5 - lead * phi, atol=1e-12)
    effort = (0.002 + 0.01 / 16 + 40 * lead**2) * acceleration - 40 * G * lead
    effort += 2e6 * np.maximum(lead * phi - 0.04, 0.0) * lead
    effort += (0.05 * rate / 4 + 2.0 * np.tanh(rate / 4 / 0.1)) / 4
    np.testing.assert_allclose(ds.driver_effort.values[:, 0], effort, atol=1e-6)
    assert effort.max() == pytest.approx(3.6, abs=0.05)
    rise = ds.potential_energy.sel(time=2.0, method="nearest") - ds.potential_energy[0]
    assert float(rise) == pytest.approx(100 - 40 * G * 0.05, abs=1e-6)


def test_a_top_that_is_let_go_comes_as_low_as_energy_and_angular_momentum_say() -> None:
    """(C s)^2 (u0 - u) = 2 A m g l (1 - u^2) at the lowest u, with C about the axis and A across it at the pivot."""
    ds = dataset("heavy_top_robust")
    assert ds.run.values[0] == -1
    assert ds.sizes["run"] == 2305
    assert ds.attrs["stopped"].startswith("enough after 2,304 runs: the 5 % quantile of height_min is ")
    m, s = ds["bodies.top.mass"], ds["bodies.top.angular_velocity[1]"]
    w, x, y, z = (ds[f"bodies.top.rotation[{n}]"] for n in range(4))
    u0 = 2 * (y * z + w * x)  # the height of the axis at the start
    A, L = 0.234375 + m, 0.46875 * s
    a, b = 2 * A * m * G, -(L**2)
    lowest = (-b - np.sqrt(b**2 - 4 * a * (L**2 * u0 - a))) / (2 * a)
    np.testing.assert_allclose(ds.height_min, lowest, rtol=0, atol=2e-5)
    np.testing.assert_allclose(ds.height_max, u0, rtol=0, atol=2e-4)
    np.testing.assert_array_equal(ds.height.min("time"), ds.height_min.sel(run=ds.full_run.values))
    spread = np.corrcoef(m[1:], s[1:])[0, 1]
    assert -0.66 < spread < -0.54
