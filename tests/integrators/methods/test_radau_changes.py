"""Implicit steps where constraints come and go: they do what explicit ones do, which closed forms have proved."""

from typing import Any

import numpy as np
import pytest
import xarray as xr

import lienumba
from tests.rigs.places import SCENARIOS

EXPLICIT = {"integrator.method": "dop853", "integrator.tolerance": 1e-9}


def compared(model: Any, tolerance: float, **more: Any) -> tuple[xr.Dataset, xr.Dataset]:
    """Explicitly and implicitly."""
    ways = EXPLICIT | {key.replace("__", "."): value for key, value in more.items()}
    implicit = ways | {"integrator.method": "radau5", "integrator.tolerance": tolerance}
    found = tuple(lienumba.run(model, overrides=x) for x in (ways, implicit))
    for ds in found:
        assert np.isin(ds.status, (0, 10)).all(), ds.status.values
    return found[0], found[1]


@pytest.mark.parametrize(
    ("name", "coordinates", "tolerance"),
    [("bouncing_ball", "joint", 1e-6), ("brake", "joint", 1e-6), ("falling_rod", "lie", 1e-7), ("pawl", "joint", 1e-6)],
)
def test_changes_are_those_of_an_explicit_method(name: str, coordinates: str, tolerance: float) -> None:
    """Impacts, friction that slides and sticks, locks that open and close again."""
    exact, found = compared(
        SCENARIOS / f"{name}.toml", tolerance, integrator__coordinates=coordinates, sweep__runs=4
    )  # fmt: skip
    np.testing.assert_array_equal(found.change_kind, exact.change_kind)
    np.testing.assert_allclose(found.change_time, exact.change_time, rtol=0, atol=3e-7)
    np.testing.assert_allclose(found.position, exact.position, rtol=0, atol=1e-6)


def sled() -> lienumba.System:
    """A body on a slide that rises from a carriage, with two feet on the ground: they say the same, share its weight,
    and rub differently."""
    system, still = lienumba.System("sled"), {"rotation": [1.0, 0.0, 0.0, 0.0]}
    system.body("carriage", mass=1.0, inertia=[0.1, 0.1, 0.1], position=[0, 0, 0], **still)
    system.body("sled", mass=2.0, inertia=[0.1, 0.1, 0.1], position=[0, 0, 0.1], **still)
    system.joint("rail", "prismatic", ["ground", "carriage"], at=[0, 0, 0], axis=[1, 0, 0], speed=2.0)
    system.joint("mast", "prismatic", ["carriage", "sled"], at=[0, 0, 0.1], axis=[0, 0, 1], speed=0.0)
    for n, friction in enumerate((0.2, 0.4)):
        system.contact(
            f"foot{n}", "point_plane", ["sled", "ground"], points=[[0.1 * n, 0, -0.1], [0, 0, 0]], normal=[0, 0, 1],
            friction=friction, restitution=0.0,
        )  # fmt: skip
    return system.integrator(method="radau5", tolerance=1e-6, coordinates="joint", end_time=2.0).output(every=0.1)


def test_feet_that_say_the_same_share_their_load() -> None:
    found = lienumba.run(sled()).isel(run=0)
    braked = 0.3 * 2.0 * 9.81 / 3.0
    t = np.minimum(found.time.values, 2.0 / braked)
    np.testing.assert_allclose(found.position[:, 0, 0], 2.0 * t - 0.5 * braked * t**2, rtol=0, atol=1e-10)
    assert np.nanmax(found.change_time) == pytest.approx(2.0 / braked, abs=1e-9)
    assert float(abs(found.energy_residual).max()) < 1e-9


def test_a_method_that_carries_on_from_step_to_step_begins_anew_where_something_changes() -> None:
    ways = {"integrator.method": "generalized_alpha", "integrator.tolerance": None, "integrator.step": 1e-3}
    found, exact = (lienumba.run(sled(), overrides=own).isel(run=0, time=-1) for own in (ways, {}))
    assert int(found.status) == 0
    np.testing.assert_allclose(found.position, exact.position, rtol=0, atol=1e-9)
