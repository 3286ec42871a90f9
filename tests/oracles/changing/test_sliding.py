"""A body that slides and turns on three feet until one sticks, and about that one until it rests: against an
integration of its own in the plane, with friction that is not rounded off either."""

from typing import Any

import numpy as np

import lienumba
from tests.oracles.changing.scenarios import AT_REST, G, kinds, settings, table
from tests.oracles.changing.sliding import Tripod

ANGLES = 2 * np.pi / 3 * np.arange(3)
FEET = 0.1 * np.stack([np.cos(ANGLES), np.sin(ANGLES)], axis=1) + [0.01, 0.0]
BODY = Tripod(1.0, 0.007, 0.05, FEET, 0.3, G)
STARTS = np.array(
    [[1.5, 0.0, 6.0], [1.5, 0.0, 3.0], [0.5, 0.7, -9.0], [-0.8, 1.1, 2.0], [0.02, -0.01, 12.0]]
)  # vx, vy, w
END = 1.0


def tripod() -> dict[str, Any]:
    body = {"name": "body", "mass": BODY.mass, "inertia": [0.004, 0.004, BODY.inertia], "position": [0, 0, BODY.height]}
    feet = [
        {
            "name": f"foot_{n}", "type": "point_plane", "bodies": ["body", "ground"], "friction": BODY.friction,
            "points": [[*foot, -BODY.height], [0, 0, 0]], "normal": [0, 0, 1],
        }
        for n, foot in enumerate(FEET.tolist())
    ]  # fmt: skip
    paths = ["bodies.body.velocity[0]", "bodies.body.velocity[1]", "bodies.body.angular_velocity[2]"]
    return {
        "title": "A tripod that turns",
        "model": {"gravity": [0, 0, -G], "bodies": [body | AT_REST | {"rotation": [1, 0, 0, 0]}], "contacts": feet},
        "integrator": settings(END, 1e-11), "output": {"times": [0, END]},
        "sweep": table({path: STARTS[:, n] for n, path in enumerate(paths)}),
    }  # fmt: skip


def test_it_sticks_where_and_rests_when_it_should() -> None:
    ds = lienumba.run(tripod(), progress=False)
    assert (ds.status == 0).all()
    stuck = kinds(ds, "stuck")
    for n, (vx, vy, w) in enumerate(STARTS):
        sticks, foot, rests, (x, y, angle) = BODY.come_to_rest((vx, vy), w)
        times, what = ds.change_time.values[n][stuck[n]], ds.change_what.values[n][stuck[n]]
        assert what[0] == foot
        np.testing.assert_allclose([times[0], times[-1]], [sticks, rests], rtol=0, atol=1e-8)
        np.testing.assert_allclose(ds.position.values[n, -1, 0, :2], [x, y], rtol=0, atol=1e-9)
        R = ds.rotation.values[n, -1, 0]
        np.testing.assert_allclose([R[0, 0], R[1, 0]], [np.cos(angle), np.sin(angle)], rtol=0, atol=1e-8)
