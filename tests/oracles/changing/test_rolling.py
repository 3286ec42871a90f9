"""A rod that rolls on its ends with an arm that rubs: where sliding ends in a posture in which nothing could have
changed it, and where one foot is held by less than rounding."""

from typing import Any

import numpy as np
import pytest

import lienumba
from tests.oracles.changing import scenarios

ROD: dict[str, Any] = {
    "name": "rod", "mass": 1, "inertia": [0.02, 0.02, 0.004], "position": [0, 0, 0.6], "velocity": [0.5, 0.1, 0],
    "rotation": {"axis": [0, 1, 0], "angle": 0.9}, "angular_velocity": [0.2, 1.5, 0.3],
}  # fmt: skip
ELBOW: dict[str, Any] = {
    "name": "elbow", "type": "universal", "bodies": ["rod", "arm"], "points": [[0, 0, 0.25], [0, 0, -0.15]],
    "axes": [[1, 0, 0], [0, 1, 0]], "references": [[0, 1, 0], [1, 0, 0]], "first_angle": 0.2, "second_angle": 0.1,
    "first_rate": 1, "second_rate": -1,
}  # fmt: skip
STOPS = [
    {"name": "l1", "joint": "elbow", "coordinate": "first_angle", "low": -0.5, "high": 0.6, "restitution": "e"},
    {"name": "l2", "joint": "elbow", "coordinate": "second_angle", "low": -0.4, "high": 0.4, "restitution": 0.2},
]
FOOT = {
    "name": "foot", "type": "capsule_plane", "bodies": ["rod", "ground"], "axis": [0, 0, 1], "length": 0.4,
    "radius": 0.05, "restitution": "e", "friction": "mu", "rest_speed": 0.05,
}  # fmt: skip
HAND = {
    "name": "hand", "type": "sphere_plane", "bodies": ["arm", "ground"], "points": [[0, 0, 0.15], [0, 0, 0]],
    "radius": 0.04, "restitution": 0.1, "friction": "mu", "rest_speed": 0.05,
}  # fmt: skip
EVENTS = [
    {"name": "hold", "when": "t > 0.35", "action": "lock", "joint": "elbow", "coordinate": "first_angle", "once": True},
    {"name": "free", "when": "tip.z < 0.06 and t > 0.4", "action": "unlock", "joint": "elbow"},
]
TIP = {"name": "tip", "type": "point", "body": "arm", "point": [0, 0, 0.15]}
KEYS = ("parameters.e", "parameters.mu", "bodies.rod.rotation.angle", "bodies.rod.angular_velocity[2]")
THROWN = np.array(
    [
        # of four feet that roll one has all that it may hold, to 6e-9 of it: `chattering`
        [0.30637652101761054, 0.36851226287116307, 2.0374283253220455, 1.0764550836635587],
        [0.2503338484116528, 0.3383666616711373, 2.137434558661034, 1.4557001735885844],
        # the hand's sliding along the rod passes 0 where arm and rod are in line: `friction_energy_gain`
        [0.16439424325494284, 0.21894258700088476, 1.817108406832077, -6.802165517783085],
        # both feet begin to slide, one of them at a tenth of the other's speed: `friction_energy_gain`
        [0.12845704779524833, 0.6310463695453485, 2.3143288610346255, -2.428200541543731],
    ]
)


@pytest.mark.usefixtures("vectors")
@pytest.mark.parametrize("method", [{"tolerance": 1e-9}, {"tolerance": 1e-10, "method": "dp54"}])
def test_rods_roll_to_the_end_and_gain_nothing(method: dict[str, Any]) -> None:
    ds = lienumba.run(
        {
            "parameters": {"e": 0.5, "mu": 0.4},
            "model": {"bodies": [ROD, {"name": "arm", "mass": 0.4, "inertia": [0.004, 0.004, 0.001]}],
                      "joints": [ELBOW], "limits": STOPS, "contacts": [FOOT, HAND]},
            "quantities": [TIP], "events": EVENTS, "integrator": method | {"end_time": 1.2},
            "output": {"every": 0.005},
            "sweep": scenarios.table({key: column.tolist() for key, column in zip(KEYS, THROWN.T, strict=True)}),
        },
        progress=False,
    )  # fmt: skip
    assert (ds.status == 0).all()
    assert np.diff(ds.energy.values, axis=1).max() < 1e-8
    ends = np.einsum("rtij,jk->rtik", ds.rotation.values[:, :, 0], np.array([[0, 0], [0, 0], [0.2, -0.2]]))[:, :, 2]
    heights = [ds.position.values[:, :, 0, 2, None] + ends - 0.05, ds["tip"].values[..., 2:] - 0.04]
    assert min(x.min() for x in heights) > -1e-9
