"""Dry friction that sticks, along a joint: a block on a belt, and on an incline."""

import math
from typing import Any

import numpy as np
import pytest

import lienumba
from tests.oracles.changing import scenarios
from tests.oracles.changing.closed_forms import Belt, up_an_incline

G = 9.81
BELT = Belt(1.0, 60.0, 0.3, 0.5, 0.35)


@pytest.fixture(scope="module")
def belt() -> Any:
    """The frame moves with the belt: there the end of the spring leaves with the speed of the belt."""
    spring = {"name": "spring", "type": "actuator", "joint": "slide", "stiffness": 60.0, "target": "-0.3*t"}
    data = scenarios.block(6.0, static=BELT.static * G, coulomb=BELT.kinetic * G)
    data["model"]["forces"].append(spring)
    data["output"]["max_changes"] = 40
    return lienumba.run(data).isel(run=0)


def test_a_block_on_a_belt_sticks_and_slips_in_time(belt: Any) -> None:
    for column, kind in enumerate(("slid", "stuck")):
        found = belt.change_time.values[scenarios.kinds(belt, kind)]
        known = BELT.times(12)[:, column]
        known = known[known < 6.0]
        found = found[found > 0]  # it may be written down that it sticks at the start
        assert len(found) == len(known) > 5
        np.testing.assert_allclose(found, known, rtol=0, atol=1e-9)
    assert abs(belt.energy_residual).max() < 1e-11


def test_a_block_sent_up_an_incline_stays_or_comes_back() -> None:
    angle, v = 0.4, 3.0
    c = math.cos(angle)
    static, kinetic = np.array([0.5, 0.3]), np.array([0.3, 0.25])
    data = scenarios.block(2.0)
    data["model"]["gravity"] = [-G * math.sin(angle), 0, -G * c]
    data["model"]["joints"][0]["speed"] = v
    columns = {"forces.dry.static": static * G * c, "forces.dry.coulomb": kinetic * G * c}
    ds = lienumba.run(data | {"sweep": scenarios.table(columns)})
    for i in range(2):
        stop, _, place = up_an_incline(v, angle, static[i], kinetic[i], 2.0)
        if i == 0:  # the other one comes back at once, sliding as before
            assert ds.change_time.values[i, 0] == pytest.approx(stop, abs=1e-11)
        assert ds.position.values[i, -1, 0, 0] == pytest.approx(place, abs=1e-11)
    assert ds.velocity.values[0, -1, 0, 0] == 0.0
