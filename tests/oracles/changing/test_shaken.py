"""What stands on a table that is shaken leaves it, on all feet at once, and comes back."""

from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

import lienumba
from tests.oracles.changing import scenarios
from tests.rigs import parts

G, W = scenarios.G, 10.0


def flight(k: float) -> tuple[float, float]:
    """When what lies on the table of `shaken` leaves it, and comes back (s): its acceleration is k g sin(w t)."""
    leaves = (np.pi + np.arcsin(1 / k)) / W

    def table(t: float) -> float:
        return k * G / W**2 * (W * t - np.sin(W * t))

    rate = k * G / W * (1 - np.cos(W * leaves))

    def above(t: float) -> float:
        return table(leaves) + rate * (t - leaves) - G / 2 * (t - leaves) ** 2 - table(t)

    return leaves, float(brentq(above, leaves + 0.03, leaves + 0.5, xtol=1e-15))


@pytest.mark.parametrize(("feet", "friction"), [(2, 0.4), (3, 0.4), (4, 0.0), (4, 0.4), (6, 0.2)])
@pytest.mark.parametrize("integrator", [{"tolerance": 1e-9}, {"step": 0.005}], ids=str)
def test_all_feet_of_what_is_shaken_let_go_at_once(integrator: dict[str, Any], feet: int, friction: float) -> None:
    """All their forces come to 0 at one time, which each of them has by rounding: those that were left, or touched
    anew, pulled, so that 13 of 20 ended as `contact_law_violated`."""
    angles = 0.3 + 2 * np.pi * np.arange(feet) / feet
    places = [[0.1 * np.cos(a), 0.1 * np.sin(a), -0.1] for a in angles]
    rough = {"friction": friction} if friction else {}
    contacts = parts.feet("box", places, "f", to="table", restitution=0, **rough)
    model = {
        "gravity": [0, 0, -G],
        "bodies": [parts.body(name, 1.5, 0.01, position=[0, 0, z]) for name, z in (("table", 0), ("box", 0.1))],
        "joints": [parts.joint("rail", "prismatic", "table", at=[0, 0, 0], axis=[0, 0, 1])],
        "drivers": [{"name": "shaker", "joint": "rail", "value": f"k*{G / W**2}*({W}*t - sin({W}*t))"}],
        "contacts": contacts,
    }  # fmt: skip
    k = np.linspace(1.02, 1.3, 24)
    ds = lienumba.run(
        {
            "title": "Shaken", "parameters": {"k": 1}, "model": model, "output": {"every": 0.75},
            "integrator": {"method": "dop853", "end_time": 0.75} | integrator,
            "sweep": scenarios.table({"parameters.k": k.tolist()}),
        },
        progress=False,
    )  # fmt: skip
    assert (ds.status == 0).all()
    leaves, back = np.transpose([flight(x) for x in k])
    opened = scenarios.kinds(ds, "opened")
    assert (opened.sum(axis=1) == feet).all()
    times = ds.change_time.values[opened].reshape(len(k), feet)
    np.testing.assert_allclose(times, np.repeat(leaves[:, None], feet, axis=1), rtol=1e-6)
    hit = np.where(scenarios.kinds(ds, "impact"), ds.change_time.values, np.inf).min(axis=1)
    np.testing.assert_allclose(hit, back, rtol=1e-5)
