"""The exact motion of the heavy top, against stored references, invariants, an independent integration."""

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tests.oracles.reference import lagrange_top
from tests.oracles.reference.lagrange_top import Top, motion

REFERENCE = json.loads((Path(__file__).parents[1] / "paper" / "references" / "heavy_top.json").read_text())
TIMES = [state["t"] for state in REFERENCE["states"]]
OTHER = Top(2.0, 0.4, 0.15, 0.7, (1.0, 0.0, -9.0), (1.5, -12.0, 0.5))


@pytest.fixture(scope="module")
def states():
    return motion(TIMES)


def test_agrees_with_the_closed_form_in_elliptic_functions(states):
    for expected, state in zip(REFERENCE["states"], states, strict=True):
        for name in ("r", "R", "v", "omega"):
            difference = np.abs(getattr(state, name) - np.array(expected[name])).max()
            assert difference < REFERENCE["uncertainty_abs"] < REFERENCE["accept_abs"], (state.time, name)


def test_agrees_with_published_numbers():
    published = {entry["t"]: entry["published"] for entry in REFERENCE["external"]["values"]}
    for state in motion(sorted(published)):
        assert (state.R @ state.omega)[1] == pytest.approx(published[state.time], abs=4e-9)


def test_the_result_does_not_depend_on_step_or_order(states, monkeypatch):
    monkeypatch.setattr(lagrange_top, "STEP", 0.023)
    monkeypatch.setattr(lagrange_top, "ORDER", 28)
    for state, other in zip(states, motion(TIMES), strict=True):
        for name in ("r", "R", "v", "omega"):
            np.testing.assert_allclose(getattr(other, name), getattr(state, name), rtol=0, atol=1e-15)


@pytest.mark.parametrize("top", [Top(), OTHER])
def test_invariants(top):
    J = np.diag([top.across, top.axial, top.across])
    found = []
    for s in motion([0.0, 0.3, 1.1, 2.0], top):
        np.testing.assert_allclose(s.R @ s.R.T, np.eye(3), atol=1e-15)
        assert np.linalg.det(s.R) == pytest.approx(1.0)
        np.testing.assert_allclose(s.r, s.R @ [0, top.arm, 0], atol=1e-15)
        np.testing.assert_allclose(s.v, s.R @ np.cross(s.omega, [0, top.arm, 0]), atol=1e-14)
        energy = (top.mass * s.v @ s.v + s.omega @ J @ s.omega) / 2 - top.mass * np.dot(top.gravity, s.r)
        momentum = top.mass * np.cross(s.r, s.v) + s.R @ J @ s.omega
        found.append([energy, momentum @ top.gravity, s.omega[1]])
    np.testing.assert_allclose(found, [found[0]] * 4, rtol=1e-14)


def test_agrees_with_eulers_equations_about_the_pivot():
    top = OTHER
    A, C = top.across + top.mass * top.arm**2, top.axial
    J = np.diag([A, C, A])

    def rate(_, y):
        R, w = y[:9].reshape(3, 3), y[9:]
        torque = np.cross([0, top.mass * top.arm, 0], R.T @ top.gravity)
        hat = np.cross(np.eye(3), w)  # x @ hat = x cross w, so the rows of R w~
        return np.concatenate([(R @ hat).ravel(), np.linalg.solve(J, torque - np.cross(w, J @ w))])

    start = np.concatenate([np.eye(3).ravel(), top.angular_velocity])
    times = [0.4, 1.3]
    y = solve_ivp(rate, (0, 1.3), start, "DOP853", times, rtol=1e-13, atol=1e-13).y
    for state, found in zip(motion(times, top), y.T, strict=True):
        np.testing.assert_allclose(state.R, found[:9].reshape(3, 3), atol=1e-11)
        np.testing.assert_allclose(state.omega, found[9:], atol=1e-10)


def test_the_start():
    (state,) = motion([0.0])
    np.testing.assert_array_equal(state.r, [0, 1, 0])
    np.testing.assert_array_equal(state.R, np.eye(3))
    np.testing.assert_array_equal(state.v, [4.61538, 0, 0])
    np.testing.assert_allclose(state.omega, [0, 150, -4.61538], rtol=1e-15)
