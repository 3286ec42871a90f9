"""A universal joint between two shafts, with every point at the origin, where the joints have no length."""

from typing import Any

import numpy as np
import pytest

import lienumba

BEND = 1.0  # rad


def shafts(coordinates: str) -> dict[str, Any]:
    c, s = np.cos(BEND), np.sin(BEND)
    body = {"mass": 1, "inertia": [0.2, 0.2, 0.3], "position": [0, 0, 0]}
    turned = {"axis": [0, 1, 0], "angle": BEND}
    bodies = [body | {"name": "i", "rotation": [1, 0, 0, 0]}, body | {"name": "o", "rotation": turned}]
    at = {"points": [[0, 0, 0], [0, 0, 0]]}
    joints = [
        {"name": "in", "type": "revolute", "bodies": ["ground", "i"], "axes": [[0, 0, 1]] * 2,
         "references": [[1, 0, 0]] * 2, **at},
        {"name": "out", "type": "revolute", "bodies": ["ground", "o"], "axes": [[s, 0, c], [0, 0, 1]],
         "references": [[0, 1, 0]] * 2, **at},
        {"name": "cross", "type": "universal", "bodies": ["i", "o"], "axes": [[1, 0, 0], [0, 1, 0]], **at},
    ]  # fmt: skip
    drivers = [{"name": "motor", "joint": "in", "value": "20*t"}]
    return {
        "model": {"gravity": [0, 0, 0], "bodies": bodies, "joints": joints, "drivers": drivers},
        "quantities": [{"name": "out_at", "type": "joint", "joint": "out"}],
        "integrator": {"method": "dop853", "tolerance": 1e-9, "end_time": 0.3, "coordinates": coordinates},
        "output": {"every": 0.01},
    }


@pytest.mark.parametrize("coordinates", ["lie", "joint"])
def test_the_bent_shaft_follows_its_closed_form(coordinates: str) -> None:
    """tan(out) = tan(in)/cos(bend)."""
    ds = lienumba.run(shafts(coordinates)).isel(run=0)
    x = 20.0 * ds.time.values
    wanted = np.unwrap(np.arctan2(np.sin(x), np.cos(x) * np.cos(BEND)))
    angle = ds["out_at.angle"].values
    assert int(ds.status) == 0
    np.testing.assert_allclose(angle - angle[0], wanted, rtol=0, atol=1e-11)
