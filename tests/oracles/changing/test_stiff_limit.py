"""Contacts that yield come to rigid ones as they get stiffer: by the time that an impact takes, which is 1/sqrt(k)."""

import math

import numpy as np
from scipy.optimize import brentq

import lienumba
from tests.oracles.changing import scenarios

G, HEIGHT, END, DISSIPATION = 9.81, 0.5, 0.7, 0.1


def restitution(speed: float) -> float:
    """Of Hunt and Crossley's law with a linear spring, whatever its stiffness:
    D (v + e v) = ln((1 + D v) / (1 - D e v))."""
    v = speed * DISSIPATION
    return float(brentq(lambda e: v + e * v - math.log((1 + v) / (1 - e * v)), 1e-6, 1.0, xtol=1e-15))


def test_a_contact_that_yields_comes_to_the_rigid_one() -> None:
    speed = math.sqrt(2 * G * HEIGHT)
    e, fall = restitution(speed), speed / G
    body = {"name": "stone", "mass": 2, "inertia": [0.1] * 3, "position": [0, 0, HEIGHT], "rotation": [1, 0, 0, 0]}
    floor = {"name": "floor", "type": "point_plane", "bodies": ["stone", "ground"]}
    model = {"gravity": [0, 0, -G], "bodies": [body | scenarios.AT_REST]}
    data = {"title": "Stiff", "integrator": scenarios.settings(END, 1e-11), "output": {"times": [0, END]}}
    t = END - fall
    known = np.array([e * speed * t - 0.5 * G * t**2, e * speed - G * t])
    rigid = lienumba.run(data | {"model": model | {"contacts": [floor | {"restitution": e}]}}).isel(run=0, time=-1)
    np.testing.assert_allclose([rigid.position[0, 2], rigid.velocity[0, 2]], known, rtol=0, atol=1e-11)

    stiff = floor | {"stiffness": 1e4, "dissipation": DISSIPATION}
    sweep = scenarios.table({"contacts.floor.stiffness": np.array([1e6, 1e8, 1e10])})
    soft = lienumba.run(data | {"model": model | {"contacts": [stiff]}, "sweep": sweep}).isel(time=-1, body=0, axis=2)
    error = abs(soft.position.values - known[0])
    assert error[0] < 1e-2
    np.testing.assert_allclose(error[:-1] / error[1:], 10.0, rtol=0.05)
