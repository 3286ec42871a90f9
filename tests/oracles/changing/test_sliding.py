"""A body that slides and turns on three feet until one sticks, and about that one until it rests: against an
integration of its own in the plane, with friction that is not rounded off either."""

from typing import Any

import numpy as np

import lienumba
from tests.oracles.changing.scenarios import G, kinds, scenario, table
from tests.oracles.changing.sliding import Tripod
from tests.rigs import parts

ANGLES = 2 * np.pi / 3 * np.arange(3)
FEET = 0.1 * np.stack([np.cos(ANGLES), np.sin(ANGLES)], axis=1) + [0.01, 0.0]
BODY = Tripod(1.0, 0.007, 0.05, FEET, 0.3, G)
STARTS = np.array(
    [[1.5, 0.0, 6.0], [1.5, 0.0, 3.0], [0.5, 0.7, -9.0], [-0.8, 1.1, 2.0], [0.02, -0.01, 12.0]]
)  # vx, vy, w
END = 1.0


def tripod() -> dict[str, Any]:
    body = parts.resting("body", BODY.mass, [0.004, 0.004, BODY.inertia], [0, 0, BODY.height])
    places = [[*foot, -BODY.height] for foot in FEET.tolist()]
    feet = parts.feet("body", places, friction=BODY.friction, normal=[0, 0, 1])
    paths = ["bodies.body.velocity[0]", "bodies.body.velocity[1]", "bodies.body.angular_velocity[2]"]
    data = scenario("A tripod that turns", {"gravity": [0, 0, -G], "bodies": [body], "contacts": feet}, END, 1e-11)
    return data | {"sweep": table({path: STARTS[:, n] for n, path in enumerate(paths)})}


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
