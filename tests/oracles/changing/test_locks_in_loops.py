"""What is locked in a loop leaves the loop's own rows nothing to say, and all other bodies as they move."""

import numpy as np
import pytest

import lienumba
from tests.rigs import parts


@pytest.mark.parametrize("coordinates", ["lie", "joint"])
def test_a_lock_in_a_loop_leaves_other_bodies_alone(coordinates: str) -> None:
    """A row whose freedoms are locked was taken for a singular position, and a body that is thrown coasted: 0.07 J."""
    arm = parts.body("a", 1.0, [0.02, 0.03, 0.01], position=[0.3, 0.1, -0.2], rotation=[1, 0, 0, 0])
    thrown = parts.resting("b", 0.7, [0.01, 0.015, 0.02], [2, 0, 0], velocity=[0.3, 0.2, 1.0])
    thrown |= {"angular_velocity": [3.0, 5.0, 1.0]}
    cross = parts.joint("u", "universal", "a", points=[[0, 0, 0], [-0.3, -0.1, 0.2]], axes=[[1, 0, 0], [0, 1, 0]])
    rod = parts.joint("rod", "distance", "a", points=[[0.4, 0.5, 0.6], [0.1, 0.2, 0.05]])
    ds = lienumba.run({
        "model": {"bodies": [arm, thrown], "joints": [cross, rod]},
        "events": [{"name": "holds", "when": "t > 0.1", "action": "lock", "joint": "u"}],
        "integrator": {"method": "dop853", "tolerance": 1e-10, "end_time": 0.5, "coordinates": coordinates},
        "output": {"every": 0.05},
    }, progress=False)  # fmt: skip
    t = ds["time"].values
    known = np.outer(t, [0.3, 0.2, 1.0]) + [2, 0, 0] - 0.5 * 9.81 * np.outer(t**2, [0, 0, 1])
    assert ds["status"].item() == 0
    np.testing.assert_allclose(ds["position"].values[0, :, 1], known, rtol=0, atol=1e-9)
    np.testing.assert_allclose(ds["angular_velocity"].values[0, t > 0.11, 0], 0.0, atol=1e-12)
    assert abs(ds["energy_residual"]).max() < 1e-8
