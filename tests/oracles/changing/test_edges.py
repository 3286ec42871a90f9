"""A box that tips over an edge on a slope along it: friction at both ends of the edge, until these slip. How they share
what holds them along the edge nothing rigid says; when no forces hold them any more is known in closed form."""

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import lienumba
from tests.oracles.changing import scenarios
from tests.rigs import parts

G, HALF, HEIGHT, INERTIA, END = scenarios.G, 0.15, 0.2, (0.01, 0.012, 0.015), 0.6


def slips(friction: float, along: float, tilt: float) -> float:
    """When an end of the edge begins to slip (s), of a box of 1 kg that is let go at a tilt (rad), with a gravity along
    the edge (m/s^2): where one has all its friction across the edge, or both together too little left along it."""
    swing = G * HEIGHT / (INERTIA[0] + HEIGHT**2)

    def left(t: float, state: Any) -> float:
        rate, sine, cosine = state[1], np.sin(state[0]), np.cos(state[0])
        across = HEIGHT * (cosine * swing * sine - sine * rate**2)
        pressure = G - HEIGHT * (sine * swing * sine + cosine * rate**2)
        ends = [
            (pressure + side * along * HEIGHT * cosine / HALF, across + side * along * HEIGHT * sine / HALF)
            for side in (1, -1)
        ]
        rests = [friction * 0.5 * n - abs(0.5 * f) for n, f in ends]
        if min(rests) < 0.0:
            return min(rests)
        return min(*rests, sum(np.sqrt((friction * 0.5 * n) ** 2 - (0.5 * f) ** 2) for n, f in ends) - along)

    left.terminal = True  # type: ignore[attr-defined]
    falling = lambda t, state: [state[1], swing * np.sin(state[0])]  # noqa: E731
    found = solve_ivp(falling, (0, END), [tilt, 0], events=left, rtol=1e-12, atol=1e-13)
    return float(found.t_events[0][0])


@pytest.mark.parametrize("method", ["dop853", "rk4"])
def test_the_ends_of_an_edge_hold_it_as_long_as_they_can(method: str) -> None:
    """Next to the limit Newton's method stood still where forces were right to 4e-8, and the change was asked for a
    thousand times (`chattering`): of these 24 runs in 9 by `rk4`."""
    rng, runs = np.random.default_rng(5), 24
    friction = rng.uniform(0.25, 0.8, runs)
    along, tilt = rng.uniform(0.0, 0.09, runs) * friction * G, rng.uniform(0.05, 0.3, runs)
    rotation = {"rotation_vector": ["tilt", 0, 0]}
    body = parts.resting("box", 1, INERTIA, [0, f"-{HEIGHT}*sin(tilt)", f"{HEIGHT}*cos(tilt)"], rotation=rotation)
    rough: Any = {"restitution": 0, "friction": {"static": "friction", "kinetic": "friction"}}
    contacts = parts.feet("box", [[x, 0, -HEIGHT] for x in (-HALF, HALF)], "end_", **rough)
    columns = {"parameters.friction": friction, "parameters.along": along, "parameters.tilt": tilt}
    data = {
        "title": "An edge", "parameters": {"friction": 0.5, "along": 0.1, "tilt": 0.1},
        "model": {"gravity": ["along", 0, -G], "bodies": [body], "contacts": contacts},
        "integrator": scenarios.settings(END, 1e-10) if method == "dop853" else {"method": "rk4", "step": 1e-3},
        "output": {"every": 0.1}, "sweep": scenarios.table({k: x.tolist() for k, x in columns.items()}),
    }  # fmt: skip
    data["integrator"]["end_time"] = END
    ds = lienumba.run(data, progress=False)
    assert (ds.status == 0).all()
    first = np.nanmin(np.where(scenarios.kinds(ds, "slid"), ds.change_time.values, np.nan), axis=1)
    expected = [slips(*x) for x in zip(friction, along, tilt, strict=True)]
    np.testing.assert_allclose(first, expected, atol=1e-7)  # within 5e-9 of a limit forces are at it
