"""The same mechanisms in two systems of units: every number scales by the exponents of the unit that it claims.

The scales are powers of 2, so that rescaling rounds nothing and every number of a motion without impacts is exact.
"""

from collections.abc import Callable, Iterator
from functools import cache
from typing import Any

import numpy as np
import pytest

import lienumba
from lienumba.mechanics.elements import quantities
from lienumba.mechanics.system.output_variables import OUTPUT_VARIABLES
from tests.rigs.units import OTHER, SEVERAL, SI, Units, changing, moving

NOISE = 1e-10  # in SI units; smaller numbers of the changing mechanism are roundoff


@cache
def runs(mechanism: Callable[[Units], dict[str, Any]]) -> tuple[Any, Any]:
    return lienumba.run(mechanism(SI), workers=1), lienumba.run(mechanism(OTHER), workers=1)


def scaled(mechanism: Callable[[Units], dict[str, Any]]) -> Iterator[tuple[str, np.ndarray, np.ndarray]]:
    """Every real variable and input by its name: in SI units, and computed in the others and converted back."""
    here, there = runs(mechanism)
    inputs = [name for name, x in here.coords.items() if x.attrs.get("role") == "input"]
    for name in (*(name for name, x in here.data_vars.items() if x.dtype.kind == "f"), *inputs):
        units = SEVERAL.get(name, [here[name].attrs["units"]])
        if units is not None:
            yield name, here[name].values, there[name].values / [OTHER.of(x) for x in units]


@pytest.mark.parametrize("mechanism", [moving, changing])
def test_as_many_steps_and_changes_with_scaled_tolerances(mechanism: Callable[[Units], dict[str, Any]]) -> None:
    """The controller of step sizes measures all kinds of errors in the units of their own tolerances."""
    here, there = runs(mechanism)
    assert (here.status == 0).all()
    assert here.steps.values.min() > 10
    for name in (name for name, x in here.data_vars.items() if x.dtype.kind == "i"):
        assert (here[name] == there[name]).all(), name


def test_every_number_of_a_smooth_motion_scales_by_its_unit() -> None:
    for name, here, there in scaled(moving):
        assert np.array_equal(here, there), name
        assert here.any() or name in ("position_iterations", "velocity_iterations"), f"{name} is 0, which shows nothing"


def test_every_number_of_a_motion_with_changes_scales_by_its_unit() -> None:
    for name, here, there in scaled(changing):
        size = np.nanmax(np.abs(here))
        assert size < NOISE or np.nanmax(np.abs(here - there)) < 1e-9 * size, name
    assert (runs(changing)[0].changes >= 3).all()


def test_the_mechanisms_show_every_output_variable_and_type_of_quantity() -> None:
    assert runs(moving)[0].data_vars.keys() >= OUTPUT_VARIABLES.keys()
    shown = {x["type"] for mechanism in (moving, changing) for x in mechanism(SI)["quantities"]}
    assert shown == quantities.QUANTITIES.keys()
