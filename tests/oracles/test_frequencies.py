"""Eigenvalues to 1e-10 against closed forms and minimal coordinates with many digits."""

from typing import Any

import mpmath as mp
import numpy as np
import pytest

import lienumba
from tests.rigs import parts

G = 9.81
SHORT = {"integrator": {"step": 1e-3, "end_time": 0.1}}


def eigenvalues(model: dict[str, Any], **keywords: Any) -> np.ndarray:
    """Those of the moving modes with an imaginary part of at least 0, sorted."""
    own = lienumba.modes({"model": model, **SHORT}, **keywords).isel(run=0, time=0)
    values = (own.growth + 1j * own.angular_frequency).values
    return sorted_values(values[values != 0.0])


def sorted_values(values: np.ndarray) -> np.ndarray:
    """By real parts, which may be rounding, then by imaginary ones."""
    return values[np.lexsort((values.imag, np.round(values.real, 8)))]


def close(found: np.ndarray, expected: Any) -> None:
    """Each to 1e-10 of its size."""
    expected = sorted_values(np.array(expected, complex))
    assert found.shape == expected.shape
    assert (abs(found - expected) / abs(expected)).max() < 1e-10


@pytest.mark.parametrize("ways", [(1, 1), (1, -1), (-1, 1), (-1, -1)])
def test_a_double_pendulum_about_its_four_equilibria(ways: tuple[int, int]) -> None:
    """M w^2 = K in the angles from the vertical."""
    m, a, J, length = (1.3, 0.8), (0.3, 0.45), (0.02, 0.015), 0.7
    down, then = ways
    bodies = [
        parts.body("upper", m[0], [J[0], J[0], 0.003], position=[0, 0, -down * a[0]]),
        parts.body("lower", m[1], [J[1], J[1], 0.002], position=[0, 0, -down * length - then * a[1]]),
    ]
    joints = [parts.hinge("hook", "upper"), parts.hinge("elbow", "lower", [0, 0, -down * length], to="upper")]
    mixed = m[1] * length * a[1] * down * then
    M = mp.matrix([[J[0] + m[0] * a[0] ** 2 + m[1] * length**2, mixed], [mixed, J[1] + m[1] * a[1] ** 2]])
    K = mp.diag([G * (m[0] * a[0] + m[1] * length) * down, G * m[1] * a[1] * then])
    squares, _ = mp.eig(mp.inverse(M) * K)
    expected: list[complex] = []
    for square in map(mp.re, squares):
        w = float(mp.sqrt(abs(square)))
        expected += [1j * w] if square > 0 else [w, -w]
    close(eigenvalues({"bodies": bodies, "joints": joints}), expected)


def four_bar(loop: str, stiffness: float) -> tuple[dict[str, Any], float]:
    """A crank, a coupler and a rocker of lengths 0.4, 0.9 and 0.7 m over a base of 1 m, and the square of its frequency
    about the angle where a coil on the crank holds it."""
    L, base, m, J = (0.4, 0.9, 0.7), 1.0, (0.7, 1.5, 0.9), (0.012, 0.11, 0.04)

    def ends(angle: Any) -> tuple[Any, Any]:
        B = (L[0] * mp.cos(angle), L[0] * mp.sin(angle))
        dx, dz = base - B[0], -B[1]
        d = mp.sqrt(dx * dx + dz * dz)
        along = (L[1] ** 2 - L[2] ** 2 + d * d) / (2 * d)
        height = mp.sqrt(L[1] ** 2 - along**2)
        return B, (B[0] + (along * dx - height * dz) / d, B[1] + (along * dz + height * dx) / d)

    def places(angle: Any) -> list[tuple[Any, Any, Any]]:
        """Middles and angles of the three."""
        B, C = ends(angle)
        middles = (B[0] / 2, B[1] / 2), ((B[0] + C[0]) / 2, (B[1] + C[1]) / 2), ((base + C[0]) / 2, C[1] / 2)
        angles = angle, mp.atan2(C[1] - B[1], C[0] - B[0]), mp.atan2(C[1], C[0] - base)
        return [(*r, turn) for r, turn in zip(middles, angles, strict=True)]

    start = mp.mpf("0.9")
    rates = [[mp.diff(lambda q, n=n, c=c: places(q)[n][c], start) for c in range(3)] for n in range(3)]
    inertia = sum(m[n] * (x * x + z * z) + J[n] * turn * turn for n, (x, z, turn) in enumerate(rates))

    def height(q: Any) -> Any:
        return sum(m[n] * G * places(q)[n][1] for n in range(3))

    square = (mp.diff(height, start, 2) + stiffness) / inertia
    bodies = [
        parts.body(name, m[n], [0.02, J[n], 0.03], position=[float(x), 0, float(z)],
                   rotation={"axis": [0, 1, 0], "angle": -float(turn)})
        for n, (name, (x, z, turn)) in enumerate(zip(("crank", "coupler", "rocker"), places(start), strict=True))
    ]  # fmt: skip
    B, C = ([float(x), 0, float(z)] for x, z in ends(start))
    kinds = {"redundant": ("revolute", "revolute"), "plain": ("spherical", "cylindrical")}[loop]
    at = [[0, 0, 0], B, C, [base, 0, 0]]
    pairs = [("ground", "crank"), ("crank", "coupler"), ("coupler", "rocker"), ("rocker", "ground")]
    joints = [
        {"name": f"pin{n}", "type": kind, "bodies": list(pair), "at": x}
        | ({} if kind == "spherical" else {"axis": [0, -1, 0]})
        for n, (kind, pair, x) in enumerate(zip(("revolute", *kinds, "revolute"), pairs, at, strict=True))
    ]  # fmt: skip
    coil = {"name": "coil", "type": "torsion_spring", "joint": "pin0", "stiffness": stiffness,
            "free_angle": float(mp.diff(height, start) / stiffness)}  # fmt: skip
    return {"bodies": bodies, "joints": joints, "forces": [coil]}, float(square)


@pytest.mark.parametrize("loop", ["redundant", "plain"])
@pytest.mark.parametrize("stiffness", [60.0, 2.0])
def test_a_four_bar_on_a_coil_spring(loop: str, stiffness: float) -> None:
    """A coil that is weak does not hold it up."""
    model, square = four_bar(loop, stiffness)
    w = np.sqrt(abs(square))
    close(eigenvalues(model), [1j * w] if square > 0 else [w, -w])


def test_a_pendulum_on_a_ball_in_turning_axes() -> None:
    """In axes that turn with Omega about the vertical it swings with w + Omega and |w - Omega|, as Foucault's."""
    turning, m, a, J = 1.7, 1.2, 0.5, 0.02
    body = parts.body("bob", m, [J, J, 0.01], position=[0, 0, -a], rotation=[1, 0, 0, 0])
    ball = parts.joint("hook", "spherical", "bob", at=[0, 0, 0])
    w = np.sqrt(m * G * a / (J + m * a * a))
    expected = [1j * (w + turning), 1j * abs(w - turning)]
    close(eigenvalues({"bodies": [body], "joints": [ball]}, rotation=[0, 0, turning]), expected)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_free_body_that_spins_about_a_principal_axis(axis: int) -> None:
    """In axes that turn with it: Euler's w^2 (J_1 - J_2)(J_1 - J_3)/(J_2 J_3), which is unstable about the middle one;
    what is at rest in space turns with w."""
    J, spin = np.array([1.0, 2.0, 3.5]), 2.3
    w = np.zeros(3)
    w[axis] = spin
    body = {"name": "book", "mass": 1.0, "inertia": J.tolist(), "position": [0, 0, 0], "rotation": [1, 0, 0, 0],
            "angular_velocity": w.tolist()}  # fmt: skip
    one, two, three = np.roll(J, -axis)
    square = spin**2 * (one - two) * (one - three) / (two * three)
    size = np.sqrt(abs(square))
    own = [1j * size] if square > 0 else [size, -size]
    found = eigenvalues({"gravity": [0, 0, 0], "bodies": [body]}, rotation=w.tolist())
    moving = found[abs(found - 1j * spin) > 1e-6]
    close(moving, own)
