"""What friction jams: a rod on a hinge whose tip comes down on a floor that friction does not let it leave."""

from typing import Any

import numpy as np
import pytest

import lienumba
from tests.rigs import parts

HEIGHT, ASIDE = 1.0, 0.1  # of the hinge over the floor, of the tip from below the hinge


def rod(friction: float, restitution: float) -> dict[str, Any]:
    """It turns at -1 rad/s, weightless, and comes down 0.1 s from the start."""
    turns = parts.frames(parts.Y, second=[0, 0, 0.5]) | {"rate": -1.0, "angle": np.arctan(ASIDE / HEIGHT) + 0.1}
    hinge = parts.joint("h", "revolute", "b", **turns)
    tip = parts.foot("f", "b", [0, 0, 0.5 - np.hypot(HEIGHT, ASIDE)], [0, 0, -HEIGHT], restitution=restitution)
    tip |= {"normal": [0, 0, 1], "friction": friction}
    rate = parts.observed("joint", "h")
    bodies = [parts.body("b", 1.0, 0.05)]
    return {"gravity": [0, 0, 0], "bodies": bodies, "joints": [hinge], "contacts": [tip], "quantities": rate}


@pytest.mark.parametrize("coordinates", ["lie", "joint"])
@pytest.mark.parametrize("settings", [{"tolerance": 1e-9}, {"method": "rk4", "step": 1e-3}])
@pytest.mark.parametrize("restitution", [0.0, 0.3, 0.9])
@pytest.mark.parametrize(("friction", "jams"), [(0.05, False), (0.0999, False), (0.11, True), (0.8, True)])
def test_what_friction_jams_does_not_come_back(
    friction: float, jams: bool, restitution: float, settings: dict[str, Any], coordinates: str
) -> None:
    """Newton's restitution has no impulses where mu > x/H: then the rod stays. They were not found, or were 1e12 N s
    large and none."""
    integrator = settings | {"coordinates": coordinates, "end_time": 0.2}
    scenario = {"model": rod(friction, restitution), "integrator": integrator, "output": {"every": 0.1}}
    ds = lienumba.run(scenario, progress=False).isel(run=0)
    assert ds.status == 0
    assert ds["h.rate"].values[-1] == pytest.approx(0.0 if jams else restitution, abs=1e-9)
    after = 0.0 if jams else restitution
    assert float(ds.energy_lost) == pytest.approx(0.5 * 0.3 * (1 - after**2), rel=1e-7)
    assert abs(float(ds.energy_residual[-1])) < 1e-7
    assert 0 < float(ds.change_impulse[0]) < 1e4


@pytest.mark.parametrize("coordinates", ["lie", "joint"])
def test_what_an_impact_has_jammed_rests_where_nothing_acts(coordinates: str) -> None:
    """A weightless double pendulum whose tip and first link meet walls, and its elbow its stop, all at once: forces are
    rounding behind that, and were taken for those with which something slips (`friction_paradox`)."""
    bodies = [
        {"name": "a", "mass": 0.6385528825033886, "inertia": [0.0273, 0.030340371343830733, 0.0319]},
        {"name": "b", "mass": 1.5722303243460332, "inertia": [0.0475, 0.052759579740170565, 0.0554]},
    ]
    shoulder = parts.joint("s", "revolute", "a", **parts.frames(parts.Y, second=[-0.3, 0, 0]))
    elbow = parts.joint("e", "revolute", "b", "a", **parts.frames(parts.Y, [0.31, 0, 0], [-0.32, 0, 0]))
    shoulder |= {"angle": -2.7163803467379726, "rate": 2.3035367485602327}
    elbow |= {"angle": -1.2764487580025126, "rate": -6.052640761139412}
    wall = {"type": "point_plane", "restitution": 0.7, "rest_speed": 1e-9}
    tip = wall | {"name": "tip", "bodies": ["b", "ground"], "normal": [-0.30708960784762934, 0, 0.9516806043794258]}
    tip |= {"friction": {"static": 5.0640443264583235, "kinetic": 4.220036938715269}}
    tip["points"] = [[0.3854386437571499, 0, 0.07195337577767219], [-0.9664863419704002, 0, -0.3263449715230573]]
    link = wall | {"name": "link", "bodies": ["a", "ground"], "normal": [-0.9805060324876543, 0, 0.1964889825290951]}
    link |= {"friction": {"static": 1.6187339238250518, "kinetic": 1.3489449365208765}}
    link["points"] = [[-0.046992432283531616, 0, -0.09221991929557138], [-0.19243551530141803, 0, 0.18837705615961498]]
    stop = {"joint": "e", "low": -2.7764487580025126, "restitution": 1.0, "rest_speed": 1e-9}
    model = {"gravity": [0, 0, 0], "bodies": bodies, "joints": [shoulder, elbow], "contacts": [tip, link]}
    integrator = {"step": 1e-3, "end_time": 0.01, "coordinates": coordinates}
    scenario = {"model": model | {"limits": [stop]}, "integrator": integrator, "output": {"every": 0.01}}
    ds = lienumba.run(scenario, progress=False).isel(run=0)
    assert ds.status == 0
    assert abs(ds.angular_velocity.values[-1]).max() < 1e-12
    assert abs(float(ds.energy_residual[-1])) < 1e-12
