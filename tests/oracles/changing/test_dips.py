"""Gaps that open, close and open again within one step: a free cubic motion from a floor, or from above it, that dips
below it between two of its roots."""

from typing import Any

import numpy as np
import pytest

import lienumba
from tests.oracles.changing import scenarios

RUNS = 200
WAYS: list[dict[str, Any]] = [
    {"method": "dop853", "tolerance": 1e-9}, {"method": "dp54", "tolerance": 1e-8}, {"method": "rk4", "step": 0.1},
    {"method": "taylor", "tolerance": 1e-9}, {"method": "radau5", "step": 0.2}, {"method": "dop853", "step": 1.0},
]  # fmt: skip


@pytest.mark.parametrize("height", [0.0, 1e-4])
@pytest.mark.parametrize("stop", ["contact", "limit"])
@pytest.mark.parametrize("way", WAYS, ids=str)
def test_what_dips_within_a_step_hits(way: dict[str, Any], stop: str, height: float) -> None:
    """Such steps ended as a success behind dips of millimetres, with gaps below 0 stored."""
    rng = np.random.default_rng(3)
    depth, width = 10 ** rng.uniform(-3.5, -2, RUNS), 10 ** rng.uniform(-1.5, -0.3, RUNS)
    r1 = 10 ** rng.uniform(-2, -0.5, RUNS)
    r2 = r1 + width
    s = r1 + width * np.linspace(0, 1, 1001)[:, None]
    c = depth / np.max(s * (s - r1) * (r2 - s), axis=0)  # of z = height + c t (t - r1) (t - r2)
    body = {"name": "b", "mass": 1.0, "inertia": [0.01, 0.01, 0.01]}
    rail = {"name": "r", "type": "prismatic", "bodies": ["ground", "b"], "points": [[0, 0, 0.1], [0, 0, 0]]}
    rail |= {"axes": [[0, 0, 1]] * 2, "references": [[1, 0, 0]] * 2, "displacement": height, "speed": "v0"}
    floor = {"name": "c", "type": "sphere_plane", "bodies": ["b", "ground"], "points": [[0, 0, 0]] * 2, "radius": 0.1}
    low = {"name": "l", "joint": "r", "low": 0.0, "restitution": 0.5}
    stops = {"contacts": [floor | {"restitution": 0.5}]} if stop == "contact" else {"limits": [low]}
    push = {"name": "f", "type": "force", "body": "b", "value": [0, 0, "a2 + a3*t"]}
    columns = {"v0": c * r1 * r2, "a2": -2 * c * (r1 + r2), "a3": 6 * c}
    ds = lienumba.run(
        {
            "parameters": {"v0": 1.0, "a2": -1.0, "a3": 1.0},
            "model": {"gravity": [0, 0, 0], "bodies": [body], "joints": [rail], "forces": [push]} | stops,
            "integrator": way | {"end_time": 1.0, "coordinates": "joint"},
            "output": {"every": 1.0},
            "sweep": scenarios.table({f"parameters.{name}": x.tolist() for name, x in columns.items()}),
        },
        progress=False,
    )
    roots = np.array([np.roots([k, -k * (p + q), k * p * q, height]) for k, p, q in zip(c, r1, r2, strict=True)])
    hits = np.where((abs(roots.imag) < 1e-12) & (roots.real > 1e-9), roots.real, np.inf).min(axis=1)
    asked = hits < 1 - 1e-6
    assert asked.all()
    assert (ds.status == 0).all()
    np.testing.assert_allclose(ds.change_time.values[asked, 0], hits[asked], rtol=0, atol=1e-8)
