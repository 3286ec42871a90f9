"""What holds at once and cannot: joints that are engaged against drivers, and locks in a dead point, say so; what only
seems to say something new beside others does not."""

from typing import Any

import numpy as np
import pytest

import lienumba
from tests.oracles.changing import scenarios
from tests.oracles.changing.scenarios import statuses
from tests.rigs import parts

DEPTH = 0.05  # m
THERE = f"-{DEPTH}*min(t, 1)**2*(3 - 2*min(t, 1))"  # from 0, in 1 s


def sliding(axis: list[float], **settings: Any) -> dict[str, Any]:
    """A body on a slide, which a fixed joint is to catch below where it starts."""
    slide = parts.joint("slide", "prismatic", "block", at=[0.02, 0.01, 0.3], axis=axis)
    catch = parts.joint("catch", "fixed", "block", points=[[0, 0, -DEPTH], [0, 0, 0]], active=False)
    block = parts.body("block", 1.3, [0.1, 0.2, 0.25], position=[0, 0, 0])
    model = {"gravity": [0, 0, -9.81], "bodies": [block], "joints": [slide, catch]}
    return scenarios.scenario("A block that is caught", model, 2.0, **settings) | {
        "quantities": [{"name": "block", "type": "point", "body": "block", "point": [0, 0, 0]}],
        "events": [{"name": "caught", "when": f"block.z < -{DEPTH}", "action": "engage", "joint": "catch"}],
    }


@pytest.mark.parametrize("coordinates", ["lie", "joint"])
@pytest.mark.parametrize(
    ("value", "when", "status", "end"),
    [
        (f"-{DEPTH}*t**2", f"block.z < -{DEPTH}", "inconsistent_constraints", 1.0),
        (THERE, "t > 1.2", "success", 2.0),
        (f"{THERE} - max(t - 1.5, 0)**3", "t > 1.2", "inconsistent_constraints", 1.5),
        (f"-{DEPTH}*sin(t*pi/2)", "t > 1", "inconsistent_constraints", 1.0),
    ],
    ids=["it moves", "it stands", "it moves later", "it turns round"],
)
def test_a_joint_that_is_engaged_against_a_driver(
    coordinates: str, value: str, when: str, status: str, end: float
) -> None:
    data = sliding([0, 0, 1], coordinates=coordinates)
    data["model"]["drivers"] = [{"name": "drive", "joint": "slide", "value": value}]
    data["events"][0]["when"] = when
    ds = lienumba.run(data)
    assert statuses(ds) == [status]
    assert end <= float(ds.end_time[0]) + 1e-6
    assert float(ds.end_time[0]) < end + 0.3


def test_a_lock_in_a_dead_point_does_not_let_the_crank_through() -> None:
    """A slider that is locked as it stands still: the crank that turns there could not move it, and moves it next."""
    places = {
        "base": ("ground", "crank", [0, 0, 0], [-0.25, 0, 0]),
        "pin": ("crank", "rod", [0.25, 0, 0], [-0.5, 0, 0]),
        "wrist": ("rod", "block", [0.5, 0, 0], [0, 0, 0]),
    }
    joints = [
        parts.joint(name, "revolute", body, to, **parts.frames(parts.Y, *points))
        for name, (to, body, *points) in places.items()
    ]
    slide = parts.joint("slide", "prismatic", "block", points=[[0, 0, 0]] * 2, axes=[[1, 0, 0]] * 2)
    model = {
        "gravity": [0, 0, 0],
        "bodies": [parts.body(x, 1.0, [0.01, 0.05, 0.05]) for x in ("crank", "rod", "block")],
        "joints": [joints[0] | {"angle": "60*deg", "rate": -3.0}, *joints[1:], slide],
    }
    data = scenarios.scenario("A crank that jams", model, 1.0) | {
        "quantities": parts.observed("joint", "slide"),
        "events": [{"name": "jam", "when": "slide.speed < 0", "action": "lock", "joint": "slide"}],
    }
    ds = lienumba.run(data)
    assert statuses(ds) == ["inconsistent_constraints"]
    assert 0 < float(ds.end_time[0] - ds.event_time[0, 0]) < 0.02


@pytest.mark.parametrize("coordinates", ["lie", "joint"])
def test_rows_that_a_slide_leaves_little_of(coordinates: str) -> None:
    """A slide that is askew by a little leaves the rows across of a joint that catches it a little to say: of what the
    row along leaves of that, rounding is no small part."""
    askew = np.geomspace(1e-9, 1e-1, 33)
    data = sliding([1e-4, 3e-5, 1.0], coordinates=coordinates)
    data["model"]["joints"][1]["points"][0] = [0, 0, 0]
    data["model"]["joints"][0] |= {"displacement": 0.0, "speed": -0.1}
    data["events"][0] |= {"closing": 0.2}
    data["sweep"] = scenarios.table({"joints.slide.axis[0]": askew, "joints.slide.axis[1]": 0.4 * askew[::-1]})
    ds = lienumba.run(data)
    assert statuses(ds) == ["success"] * len(askew)
    assert abs(ds.position[:, -1]).max() < 1e-12
    np.testing.assert_allclose(ds.energy_residual[:, -1], 0.0, rtol=0, atol=1e-12)
