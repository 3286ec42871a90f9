"""Changes at the very end of a step, up to rounding, which leaves a rest of the step that is rounding, too."""

import numpy as np
import pytest

import lienumba
from tests.oracles.changing import scenarios
from tests.rigs import parts

STEP, E, END = 1e-3, 0.5, 0.4
BODY = parts.resting("body", 1, 0.01)
STEPS, SPEEDS = (np.random.default_rng(3).choice(x, 200) for x in (np.arange(3, 350), np.array([0.3, 0.5, 1.0, 1.7])))
TYPES = {
    "point_plane": ({}, 0.0),
    "sphere_plane": ({"radius": 0.1}, 0.1),
    "sphere_sphere": ({"radii": [0.1, 0.2]}, 0.3),
}


@pytest.mark.parametrize("kind", TYPES)
@pytest.mark.parametrize("method", ["rk4", "dop853"])
def test_a_contact_is_hit_once(kind: str, method: str) -> None:
    given, gap = TYPES[kind]
    contact = {"name": "wall", "type": kind, "bodies": ["body", "ground"], "restitution": E} | given
    start = {"bodies.body.velocity[2]": -SPEEDS, "bodies.body.position[2]": gap + SPEEDS * STEPS * STEP}
    ds = lienumba.run({
        "title": "Hits",
        "model": {"gravity": [0, 0, 0], "bodies": [BODY | {"position": [0, 0, 1]}], "contacts": [contact]},
        "integrator": {"method": method, "step": STEP, "end_time": END}, "output": {"times": [0, END]},
        "sweep": scenarios.table({name: x.tolist() for name, x in start.items()}),
    })  # fmt: skip
    assert (ds.status == 0).all()
    assert (ds.changes == 1).all()
    np.testing.assert_allclose(ds.change_time[:, 0], STEPS * STEP, rtol=0, atol=1e-13)
    np.testing.assert_allclose(ds.last_velocity.values[:, 0, 2], E * SPEEDS, rtol=0, atol=1e-14)


def test_two_balls_that_part_sideways_are_not_hit_again() -> None:
    """Without restitution nothing is left of their approach, and they part by the tangential speed alone."""

    contact = {"name": "balls", "type": "sphere_sphere", "bodies": ["first", "second"], "radii": [0.1, 0.2]}
    first = parts.resting("first", 1.0, 0.01, [0, 0.18, 0], velocity=[2.0, 0, 0])  # they touch at 0.18 s
    second = parts.resting("second", 3.0, 0.01, [0.6, 0, 0])
    ds = lienumba.run({
        "title": "Balls",
        "model": {"gravity": [0, 0, 0], "bodies": [first, second], "contacts": [contact]},
        "integrator": {"method": "rk4", "step": STEP, "end_time": 0.5}, "output": {"times": [0, 0.5]},
    })  # fmt: skip
    normal = np.array([-0.8, 0.6, 0])
    lost = (normal @ [2.0, 0, 0]) * normal  # of the velocity, all along the normal
    assert int(ds.status[0]) == 0
    np.testing.assert_allclose(ds.velocity[0, -1, 0], [2.0, 0, 0] - 0.75 * lost, rtol=0, atol=1e-13)
    np.testing.assert_allclose(ds.velocity[0, -1, 1], 0.25 * lost, rtol=0, atol=1e-13)
