"""A rotor with dry friction beside a stop, on which a torque swings: both may hold it where it stands, one of them is
used, and the stop only pushes. Against the motion piece by piece, each in closed form."""

from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

import lienumba
from tests.rigs import parts

RUNS, END, FREQUENCY, INERTIA = 48, 6.0, 2.0, 0.2 + 0.3**2  # the last about the axis, kg m^2
KINETIC, RESTITUTION = 1.0, 0.3  # N m, and of its speed
FINE = 4000


def scenario(static: float, integrator: dict[str, Any]) -> dict[str, Any]:
    rotor = parts.body("rotor", 1.0, [0.1, 0.2, 0.3], position=[0.3, 0, 0])
    return {
        "parameters": {"strength": 2.0},
        "model": {
            "gravity": [0, 0, 0],
            "bodies": [rotor],
            "joints": [parts.hinge("pivot", "rotor")],
            "limits": [{"name": "stop", "joint": "pivot", "low": 0, "restitution": RESTITUTION}],
            "forces": [
                parts.dry("pivot", KINETIC, static),
                {"name": "load", "type": "actuator", "joint": "pivot", "value": f"strength*sin({FREQUENCY}*t)"},
            ],
            "quantities": [
                {"name": "turn", "type": "joint", "joint": "pivot"},
                {"name": "stop_at", "type": "limit", "limit": "stop"},
            ],
        },
        "integrator": {"end_time": END, **integrator, **({"max_step": 0.05} if "tolerance" in integrator else {})},
        "output": {"every": 0.05},
        "sweep": parts.sweep(RUNS, {"parameters.strength": (1.0, 4.0)}),
    }


def first(f, low: float, high: float) -> float | None:
    """The first time in (low, high) at which f passes 0 from below."""
    times = np.linspace(low, high, FINE)
    above = np.array([f(t) for t in times]) > 0.0
    n = np.flatnonzero(above[1:] & ~above[:-1])
    return float(brentq(f, times[n[0]], times[n[0] + 1], xtol=1e-14)) if n.size else None


@cache
def motion(strength: float, static: float, times: tuple[float, ...]) -> np.ndarray:
    """The angle at these times; methods are compared with the same motions."""
    t, q, v, direction = 0.0, 0.0, 0.0, 0.0
    pieces = []

    def load(t: float) -> float:
        return strength * np.sin(FREQUENCY * t)

    while t < END:
        if direction == 0.0:
            leaves = [first(lambda s: load(s) - static, t, END)]
            if q > 0.0:
                leaves.append(first(lambda s: -load(s) - static, t, END))
            until = min((x for x in leaves if x is not None), default=END)
            pieces.append((t, lambda s, q=q: q))
            t, v, direction = until, 0.0, np.sign(load(until))
            continue

        def rate(s: float, t=t, v=v, d=direction) -> float:
            swung = strength / FREQUENCY * (np.cos(FREQUENCY * t) - np.cos(FREQUENCY * s))
            return v + (swung - d * KINETIC * (s - t)) / INERTIA

        def angle(s: float, t=t, q=q, v=v, d=direction) -> float:
            swung = strength / FREQUENCY * (np.cos(FREQUENCY * t) * (s - t))
            swung -= strength / FREQUENCY**2 * (np.sin(FREQUENCY * s) - np.sin(FREQUENCY * t))
            return q + v * (s - t) + (swung - d * KINETIC * (s - t) ** 2 / 2) / INERTIA

        pieces.append((t, angle))
        begins = t + 1e-9
        stops = first(lambda s, d=direction: -d * rate(s), begins, END)
        hits = first(lambda s: -angle(s), begins, END) if direction < 0.0 else None
        until = min((x for x in (stops, hits) if x is not None), default=END)
        if until == END:
            break
        if until == hits:
            q, v = 0.0, -RESTITUTION * rate(until)
            direction = 1.0
        else:
            q, v = angle(until), 0.0
            direction = np.sign(load(until)) if abs(load(until)) > static and q > 0.0 else 0.0
        t = until
    starts = np.array([piece[0] for piece in pieces])
    return np.array([pieces[np.searchsorted(starts, s, side="right") - 1][1](s) for s in times])


@pytest.mark.parametrize(
    ("integrator", "coordinates"),
    [({"method": "dop853", "tolerance": 1e-10}, "lie"), ({"method": "dop853", "tolerance": 1e-10}, "joint"),
     ({"method": "rk4", "step": 1e-3}, "joint"), ({"method": "radau5", "tolerance": 1e-9}, "joint")],
)  # fmt: skip
@pytest.mark.parametrize("static", [1.5, KINETIC])
def test_the_stop_only_pushes(static: float, integrator: dict[str, Any], coordinates: str) -> None:
    ds = lienumba.run(scenario(static, {**integrator, "coordinates": coordinates}), progress=False)
    assert (ds.status == 0).all()
    assert float(ds["stop_at.effort"].min()) >= 0.0
    times = tuple(ds.time.values.tolist())
    for run, strength in enumerate(ds["parameters.strength"].values):
        expected = motion(float(strength), static, times)
        np.testing.assert_allclose(ds["turn.angle"].values[run], expected, atol=1e-7, err_msg=str(strength))
