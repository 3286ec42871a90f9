"""Contacts and stops that yield come to rigid ones as they get stiffer: by the time that an impact takes, which is
1/sqrt(k)."""

import math

import numpy as np
from scipy.optimize import brentq

import lienumba
from tests.oracles.changing import scenarios
from tests.rigs import parts

G, HEIGHT, END, DISSIPATION = 9.81, 0.5, 0.7, 0.1


def restitution(speed: float) -> float:
    """Of Hunt and Crossley's law with a linear spring, whatever its stiffness:
    D (v + e v) = ln((1 + D v) / (1 - D e v))."""
    v = speed * DISSIPATION
    return float(brentq(lambda e: v + e * v - math.log((1 + v) / (1 - e * v)), 1e-6, 1.0, xtol=1e-15))


def test_a_contact_that_yields_comes_to_the_rigid_one() -> None:
    speed = math.sqrt(2 * G * HEIGHT)
    e, fall = restitution(speed), speed / G
    body = parts.resting("stone", 2, 0.1, [0, 0, HEIGHT])
    floor = {"name": "floor", "type": "point_plane", "bodies": ["stone", "ground"]}
    model = {"gravity": [0, 0, -G], "bodies": [body]}
    data = scenarios.scenario("Stiff", model, END, 1e-11)
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


def test_an_end_stop_comes_to_the_rigid_one() -> None:
    """A slide against a spring with a damper of the same damping ratio D: what leaves it, by a force that never pulls,
    is slower by exp(-D w t) (cos + ...), whatever the stiffness; without damping, as fast as it came."""
    slide = parts.slide("rail", "cart", displacement=0, speed=1.0)
    model = {"gravity": [0, 0, 0], "bodies": [parts.body("cart", 2, 0.1)], "joints": [slide]}
    data = scenarios.scenario("A buffer", model, 1.0, 1e-11)
    ratio, stiffness = 0.2, np.array([1e5, 1e7, 1e9])
    # until the force would pull: k x + d v = 0, of x = exp(-a t) sin(w t) / w
    decay, pulsation = ratio, math.sqrt(1 - ratio**2)
    fraction = lambda t: (  # noqa: E731
        math.sin(pulsation * t) + 2 * ratio * (pulsation * math.cos(pulsation * t) - decay * math.sin(pulsation * t))
    )
    t = brentq(fraction, 1.0, math.pi / pulsation, xtol=1e-15)
    speed = math.exp(-decay * t) * (pulsation * math.cos(pulsation * t) - decay * math.sin(pulsation * t)) / pulsation
    e = -speed
    # from there on the damper keeps it from pulling: nothing acts, and the cart goes on as it is
    assert 0.4 < e < 0.6
    stop = {"name": "end", "joint": "rail", "high": 0.5, "restitution": e}
    rigid = lienumba.run(data | {"model": model | {"limits": [stop]}}).isel(run=0, time=-1, body=0)
    np.testing.assert_allclose([rigid.position[0], rigid.velocity[0]], [0.5 - 0.5 * e, -e], rtol=0, atol=1e-11)

    buffer = {"name": "end", "type": "end_stop", "joint": "rail", "upper": 0.5, "stiffness": 1e5, "damping": 1.0}
    damping = 2 * ratio * np.sqrt(2.0 * stiffness)
    columns = {"forces.end.stiffness": stiffness, "forces.end.damping": damping}
    soft = lienumba.run(data | {"model": model | {"forces": [buffer]}, "sweep": scenarios.table(columns)})
    error = abs(soft.position.values[:, -1, 0, 0] - (0.5 - 0.5 * e))
    assert error[0] < 1e-2
    np.testing.assert_allclose(error[:-1] / error[1:], 10.0, rtol=0.05)
