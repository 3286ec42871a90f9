"""What the robots of the gallery say one should look at."""

from functools import cache
from typing import Any

import numpy as np
import pytest

import lienumba
from tests.rigs.places import SCENARIOS


@cache
def single(name: str) -> Any:
    return lienumba.run(SCENARIOS / f"{name}.toml").isel(run=0)


@pytest.mark.parametrize("name", ["ur5", "solo12"])
def test_runs_to_the_end_on_its_joints(name: str) -> None:
    ds = single(name)
    assert int(ds.status) == 0
    assert float(ds.max_position_violation) <= 1e-11
    assert float(ds.max_velocity_violation) <= 1e-11
    assert float(ds.max_energy_drift) < 1e-6


def test_a_falling_arm_gains_what_it_loses_in_height() -> None:
    ds = single("ur5")
    energy = ds.kinetic_energy + ds.potential_energy
    assert float(ds.kinetic_energy.max()) > 10.0
    np.testing.assert_allclose(energy, energy[0], atol=1e-6)


def test_a_quadruped_in_flight() -> None:
    ds = single("solo12")
    L = ds["momentum.angular"].values
    np.testing.assert_allclose(L, np.broadcast_to(L[0], L.shape), atol=1e-9)
    system = lienumba.System.from_toml(SCENARIOS / "solo12.toml").to_dict()
    masses = np.array([body["mass"] for body in system["model"]["bodies"]])
    centre = np.einsum("tbi,b->ti", ds.position.transpose("time", "body", "axis").values, masses) / masses.sum()
    t = ds.time.values
    speed = (centre[-1] - centre[0]) / t[-1] + [0, 0, 9.81 * t[-1] / 2]
    parabola = centre[0] + np.outer(t, speed) - np.outer(9.81 * t**2 / 2, [0, 0, 1])
    np.testing.assert_allclose(centre, parabola, atol=1e-9)
    turning = ds.angular_velocity.sel(body="base_link", axis="y").values
    assert np.ptp(turning) > 1.0  # the legs make it uneven
