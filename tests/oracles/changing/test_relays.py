"""A relay without hysteresis, or with next to none: its line is crossed, or held, which has no end of changes."""

import numpy as np
import pytest

import lienumba
from lienumba.batch.statuses import CHATTERING, SUCCESS

METHODS = [
    ("dop853", {"tolerance": 1e-9}), ("rk4", {"step": 1e-2}), ("taylor", {"tolerance": 1e-9}),
    ("radau5", {"tolerance": 1e-7}),
]  # fmt: skip
END, RUNS = 6.0, 60


def crossed(x: float, v: float, k: float) -> tuple[float, float, bool]:
    """A mass of 1 kg under a force of 1 N against the sign of s = x + k v: where it is at the end, and whether it has
    come to where both signs drive it back to the line (|v| < k) before."""
    t, sign = 0.0, np.sign(x + k * v)
    while True:  # s = x + v t - sign t^2 / 2 + k (v - sign t)
        roots = np.roots([-sign / 2, v - sign * k, x + k * v])
        later = sorted(r.real for r in roots if abs(r.imag) < 1e-12 and r.real > 1e-9)
        left = END - t
        step = min(later[0] if later else np.inf, left)
        x, v = x + v * step - sign * step**2 / 2, v - sign * step
        t += step
        if step == left:
            return x, v, False
        if abs(v) < k:
            return x, v, True
        sign = -sign
        x = -k * v  # to the bit on the line


@pytest.mark.parametrize(("method", "integrator"), METHODS)
@pytest.mark.parametrize("band", [0.0, 1e-15, 1e-13, 1e-12, 3e-11])
def test_a_relay_crosses_its_line_or_chatters(method, integrator, band):
    """It went on for ever beside the line, as a success."""
    point = {"type": "point", "body": "m", "point": [0, 0, 0]}
    body = {"name": "m", "mass": 1.0, "inertia": [1, 1, 1], "position": ["x0", 0, 0], "velocity": ["v0", 0, 0]}
    push = {"name": "f", "type": "force", "body": "m", "value": ["F", 0, 0]}
    vary = {f"parameters.{name}": {"distribution": "uniform", "low": -2, "high": 2} for name in ("x0", "v0")}
    vary["parameters.k"] = {"distribution": "choice", "values": [0.05, 0.3, 1.0]}
    scenario = {
        "parameters": {"F": 0.0, "k": 1.0, "x0": 0.0, "v0": 0.0},
        "model": {"gravity": [0, 0, 0], "bodies": [body], "forces": [push]},
        "quantities": [{"name": "p", **point}, {"name": "w", "derivative": 1, **point}],
        "events": [
            {"name": "up", "when": f"p.x + k*w.x < -{band}", "action": "set", "parameters": {"F": 1}},
            {"name": "down", "when": f"p.x + k*w.x > {band}", "action": "set", "parameters": {"F": -1}},
        ],
        "integrator": {"method": method, "end_time": END} | integrator,
        "output": {"every": END},
        "sweep": {"runs": RUNS, "seed": 3, "vary": vary},
    }  # fmt: skip
    found = lienumba.run(scenario)
    for run in range(RUNS):
        x, v, k = (float(found[f"parameters.{name}"][run]) for name in ("x0", "v0", "k"))
        if abs(x + k * v) < 1e-3 or abs(abs(v) - k) < 1e-3:
            continue  # next to the line, or to the limit between both
        x, v, stays = crossed(x, v, k)
        assert found.status.values[run] == (CHATTERING if stays else SUCCESS), (run, x, v, k)
        np.testing.assert_allclose(found.last_position.values[run, 0, 0], x, atol=3e-6)


@pytest.mark.parametrize(("method", "integrator"), METHODS)
def test_a_ball_leaves_its_floor_at_each_bounce(method, integrator):
    """Between the fall and the rise its gap is 0: the event was missed where rounding had it above."""
    contact = {"name": "c", "type": "sphere_plane", "bodies": ["b", "ground"], "points": [[0, 0, 0]] * 2, "radius": 0.1}
    scenario = {
        "parameters": {"h": 1.0},
        "model": {
            "gravity": [0, 0, -9.81],
            "bodies": [{"name": "b", "mass": 1, "inertia": [1, 1, 1], "position": [0, 0, "h"]}],
            "contacts": [contact | {"normal": [0, 0, 1], "restitution": 0.8}],
        },
        "quantities": [{"name": "p", "type": "point", "body": "b"}],
        "events": [{"name": "off", "when": "p.z > 0.1"}, {"name": "on", "when": "p.z < 0.1"}],
        "integrator": {"method": method, "end_time": 1.5} | integrator,
        "output": {"every": 1.5},
        "sweep": {"runs": 40, "vary": {"parameters.h": {"distribution": "uniform", "low": 0.5, "high": 1}}},
    }
    found = lienumba.run(scenario)
    falls = np.sqrt(2 * (found["parameters.h"].values - 0.1) / 9.81)
    bounces = np.array(
        [sum(fall * (1 + 2 * sum(0.8**k for k in range(1, n))) < 1.5 for n in range(1, 20)) for fall in falls]
    )
    np.testing.assert_array_equal(found.event_count.sel(event="on"), bounces)
    np.testing.assert_array_equal(found.event_count.sel(event="off"), bounces + 1)  # it begins above


@pytest.mark.parametrize(("method", "integrator"), METHODS)
@pytest.mark.parametrize("when", ["t > 0.7", "p.x > 0.1"])
def test_what_follows_from_what_happens_at_the_same_place_happens_once(method, integrator, when):
    """The second event reads what the first one sets; nothing undoes anything."""
    body = {"name": "b", "mass": 1, "inertia": [1, 1, 1], "position": [0, 0, 0], "velocity": ["v", 0, 0]}
    scenario = {
        "parameters": {"v": 0.5, "n": 0.0, "m": 0.0},
        "model": {"gravity": [0, 0, 0], "bodies": [body]},
        "quantities": [
            {"name": "p", "type": "point", "body": "b"},
            {"name": "seen", "type": "expression", "value": "m + 0*p.x"},
        ],
        "events": [
            {"name": "a", "when": when, "action": "set", "parameters": {"n": 1}},
            {"name": "b", "when": f"{when} and n > 0.5", "action": "set", "parameters": {"m": 1}},
        ],
        "integrator": {"method": method, "end_time": 2.0} | integrator,
        "output": {"every": 2.0},
        "sweep": {"runs": 20, "vary": {"parameters.v": {"distribution": "uniform", "low": 0.3, "high": 1}}},
    }
    found = lienumba.run(scenario)
    np.testing.assert_array_equal(found.status, SUCCESS)
    np.testing.assert_array_equal(found.event_count, 1)
