"""Gaps that open, close and open again within one step: a free cubic motion from a floor, or from above it, that dips
below it between two of its roots."""

from typing import Any

import numpy as np
import pytest

import lienumba
from tests.oracles.changing import scenarios
from tests.rigs import parts

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
    body = parts.body("b", 1.0, 0.01)
    rail = parts.slide("r", "b", parts.Z, points=[[0, 0, 0.1], [0, 0, 0]], displacement=height, speed="v0")
    floor = parts.sphere("c", "b", 0.1, restitution=0.5)
    low = {"name": "l", "joint": "r", "low": 0.0, "restitution": 0.5}
    stops = {"contacts": [floor]} if stop == "contact" else {"limits": [low]}
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


@pytest.mark.parametrize("tolerance", [1e-5, 1e-6, 1e-9])
def test_what_bounces_by_long_steps_does_not_pass_the_floor(tolerance: float) -> None:
    """A step that was cut a little behind an impact left the tip below the floor by more than what touches, and nothing
    looked for the next one: a run in twenty ended as `contact_law_violated`."""
    upper = parts.resting("b", 1.7, [0.02, 0.05, 0.06], [0, 0, 0.75], velocity=[0.8, 0, 0])
    lower = parts.body("d", 0.6, [0.002, 0.008, 0.008], rotation=[1, 0, 0, 0], angular_velocity=[0, 1, 2])
    ball = parts.joint("j", "spherical", "d", "b", points=[[0.15, 0, 0.15], [-0.25, 0, 0]])
    places = [("d", [0.25, 0, 0]), ("b", [0.2, 0, 0]), ("b", [-0.2, 0.05, 0]), ("b", [0, 0.1, 0.18])]
    tips = [parts.sphere(f"c{n}", body, 0.03, p, restitution=0.5) for n, (body, p) in enumerate(places)]
    normal = {"distribution": "normal", "std": 4.0}
    ds = lienumba.run(
        {
            "model": {"bodies": [upper, lower], "joints": [ball], "contacts": tips},
            "quantities": [{"name": f"q{n}", "type": "contact", "contact": f"c{n}"} for n in range(len(tips))],
            "integrator": {"method": "dop853", "tolerance": tolerance, "end_time": 1.0},
            "output": {"every": 0.005},
            "sweep": {
                "runs": 200,
                "vary": {f"bodies.b.angular_velocity[{n}]": normal for n in range(3)}
                | {"bodies.b.rotation": {"distribution": "rotation_uniform"}},
            },
        },
        progress=False,
    )
    assert (ds.status == 0).all(), np.unique(ds.status.values, return_counts=True)
    gaps = [float(ds[f"q{n}.gap"].min()) for n in range(len(tips))]
    assert min(gaps) > -1e-6 * 0.1, gaps
