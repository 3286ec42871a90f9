"""What friction jams: a rod on a hinge whose tip comes down on a floor that friction does not let it leave."""

from typing import Any

import numpy as np
import pytest

import lienumba

HEIGHT, ASIDE = 1.0, 0.1  # of the hinge over the floor, of the tip from below the hinge


def rod(friction: float, restitution: float) -> dict[str, Any]:
    """It turns at -1 rad/s, weightless, and comes down 0.1 s from the start."""
    body = {"name": "b", "mass": 1.0, "inertia": [0.05] * 3}
    hinge = {"name": "h", "type": "revolute", "bodies": ["ground", "b"], "points": [[0, 0, 0], [0, 0, 0.5]]}
    hinge |= {"axes": [[0, 1, 0]] * 2, "references": [[1, 0, 0]] * 2, "rate": -1.0}
    hinge |= {"angle": np.arctan(ASIDE / HEIGHT) + 0.1}
    tip = {"name": "f", "type": "point_plane", "bodies": ["b", "ground"], "normal": [0, 0, 1], "friction": friction}
    tip |= {"points": [[0, 0, 0.5 - np.hypot(HEIGHT, ASIDE)], [0, 0, -HEIGHT]], "restitution": restitution}
    rate = {"name": "h", "type": "joint", "joint": "h"}
    return {"gravity": [0, 0, 0], "bodies": [body], "joints": [hinge], "contacts": [tip], "quantities": [rate]}


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
