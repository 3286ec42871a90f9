"""A ball joint that is locked turns no further, wherever that is, and again after it has been free."""

from typing import Any

import numpy as np
import pytest

import lienumba
from tests.oracles.changing import scenarios

J, SPIN, RATE = np.array([0.2, 0.3, 0.4]), np.array([0.0, 0.0, 2.0]), 1.5
TIMES = [0.0, 0.5, 1.0, 1.5, 2.0]
FLY = 1e8  # so heavy that the frame does not feel the body


def spinning(coordinates: str, **ball: Any) -> dict[str, Any]:
    """A body on a ball joint at its mass centre, on a frame that turns about z; nothing acts on it."""
    still = {"position": [0, 0, 0], "rotation": [1, 0, 0, 0]}
    frame = {"name": "frame", "mass": 1, "inertia": [FLY] * 3} | still
    body = {"name": "body", "mass": 2.0, "inertia": J.tolist()} | still
    hinge = {"name": "hinge", "type": "revolute", "bodies": ["ground", "frame"], "at": [0, 0, 0], "axis": [0, 0, 1]}
    joint = {"name": "ball", "type": "spherical", "bodies": ["frame", "body"], "at": [0, 0, 0]}
    return {
        "title": "A body in a frame",
        "model": {"gravity": [0, 0, 0], "bodies": [frame, body], "joints": [hinge | {"rate": RATE}, joint | ball]},
        "events": [],
        "integrator": scenarios.settings(2.0, coordinates=coordinates),
        "output": {"times": TIMES},
    }


def event(name: str, t: float, action: str) -> dict[str, Any]:
    return {"name": name, "when": f"t > {t}", "action": action, "joint": "ball"}


def about_z(angle: float) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])


@pytest.mark.parametrize("coordinates", ["lie", "joint"])
def test_it_turns_with_what_it_is_locked_to_and_is_freed_and_locked_again(coordinates: str) -> None:
    """The frame turns at its rate; the body at its own until it is locked, by 1.6 rad against the frame, and from then
    on with the frame. Its spin about x is gone at once, for what it turns about is z."""
    data = spinning(coordinates, angular_velocity=(SPIN - [0, 0, RATE]).tolist())
    data["events"] = [event("hold", 0.8, "lock"), event("free", 1.2, "unlock"), event("again", 1.6, "lock")]
    ds = lienumba.run(data).isel(run=0)
    own = np.interp(TIMES, [0, 0.8, 2.0], [0, 0.8 * SPIN[2], 0.8 * SPIN[2] + 1.2 * RATE])
    for t, angle in enumerate(own):
        np.testing.assert_allclose(ds.rotation[t, 1], about_z(angle), rtol=0, atol=1e-7)
    lost = 0.5 * J[2] * (SPIN[2] - RATE) ** 2
    np.testing.assert_allclose(ds.change_energy[:3], [lost, 0, 0], rtol=0, atol=1e-6)
    assert abs(ds.energy_residual).max() < 1e-11 * FLY


@pytest.mark.parametrize("coordinates", ["lie", "joint"])
def test_what_begins_locked_is_held_as_it_begins_and_locked_again_where_it_has_got_to(coordinates: str) -> None:
    """A pendulum that hangs askew is held, falls, and is caught: with what it falls it stops, at any angle."""
    begins = {"name": "bob", "mass": 2.0, "inertia": [0.1, 0.2, 0.3], "rotation": {"axis": [0, 0, 1], "angle": 2.0}}
    ball = {"name": "ball", "type": "spherical", "bodies": ["ground", "bob"], "at": [0, 0, 0], "locked": True}
    data = {
        "title": "A pendulum",
        "model": {"gravity": [0, 0, -9.81], "bodies": [begins | {"position": [0.5, 0, 0]}], "joints": [ball]},
        "events": [event("free", 0.5, "unlock"), event("hold", 1.0, "lock")],
        "integrator": scenarios.settings(2.0, coordinates=coordinates),
        "output": {"times": TIMES},
    }
    ds = lienumba.run(data).isel(run=0)
    np.testing.assert_allclose(ds.position[1, 0], [0.5, 0, 0], rtol=0, atol=1e-12)
    fallen = -float(ds.position[2, 0, 2])
    assert fallen > 0.3
    np.testing.assert_allclose(ds.position[3:, 0], ds.position[[2, 2], 0], rtol=0, atol=1e-12)
    np.testing.assert_allclose(ds.change_energy[:2], [0, 2.0 * 9.81 * fallen], rtol=0, atol=1e-10)
    assert abs(ds.energy_residual).max() < 1e-10


@pytest.mark.parametrize("coordinates", ["lie", "joint"])
def test_a_ball_that_a_rod_holds_too_is_locked_by_what_is_left_to_hold(coordinates: str) -> None:
    """Of the three rows of the lock one says nothing new: the rod, which closes a loop, has said it before."""
    body = {"name": "bob", "mass": 2.0, "inertia": [0.1, 0.2, 0.3], "rotation": [1, 0, 0, 0], "position": [0.5, 0, 0]}
    ball = {"name": "ball", "type": "spherical", "bodies": ["ground", "bob"], "at": [0, 0, 0]}
    rod = {"name": "rod", "type": "distance", "bodies": ["ground", "bob"], "points": [[0.5, 0.7, 0.1], [0, 0.1, 0.2]]}
    data = {
        "title": "A pendulum with a rod",
        "model": {"gravity": [0, 0, -9.81], "bodies": [body], "joints": [ball, rod]},
        "events": [event("hold", 0.3, "lock"), event("free", 1.2, "unlock")],
        "integrator": scenarios.settings(2.0, coordinates=coordinates),
        "output": {"times": TIMES, "at_events": ["place"]},
        "quantities": [{"name": "place", "type": "point", "body": "bob", "point": [0, 0, 0]}],
    }
    ds = lienumba.run(data).isel(run=0)
    held, fallen = ds.event_place.sel(event="hold"), -float(ds.event_place.sel(event="hold", axis="z"))
    assert fallen > 0.1
    np.testing.assert_allclose(ds.position[1:3, 0], [held, held], rtol=0, atol=1e-12)
    assert float(ds.change_energy[0]) == pytest.approx(2.0 * 9.81 * fallen, abs=1e-10)
    assert float(abs(ds.position[3, 0] - held).max()) > 0.01
    assert abs(ds.energy_residual).max() < 1e-10
