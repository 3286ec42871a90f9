"""What every output variable promises: one way in which it comes about, dimensions that the dataset has."""

import pytest

from lienumba.mechanics.system.output_variables import OUTPUT_VARIABLES, OutputVariable, kept_at_end, kept_largest
from lienumba.store.layout import COORDINATES, RUN, SERIES, VARIABLES


@pytest.mark.parametrize("variable", OUTPUT_VARIABLES.values(), ids=OUTPUT_VARIABLES)
def test_a_variable_is_computed_or_read_or_part_of_the_state(variable: OutputVariable) -> None:
    assert sum(way is not None for way in (variable.rows, variable.read, variable.state)) == 1
    assert set(variable.dims) <= COORDINATES.keys()
    spec = VARIABLES[variable.name]
    assert (spec.dims, spec.units, spec.frame) == ((*SERIES, *variable.dims), variable.units, variable.frame)


def test_what_the_dataset_keeps_of_each_run() -> None:
    assert list(kept_largest()) == ["max_position_violation", "max_velocity_violation", "max_energy_drift"]
    assert [x.name for x in kept_at_end()] == ["position", "rotation", "velocity", "angular_velocity"]
    assert VARIABLES["last_rotation"].dims == (*RUN, "body", "axis", "body_axis")
    assert VARIABLES["last_rotation"].long_name == "rotation matrix at the end of the run"


def test_a_variable_of_a_run_is_known_as_long_as_its_output_variable() -> None:
    power = OutputVariable("power", "W", "power", rows=lambda x: [0.0], largest="max_power", largest_text="most power")
    with OUTPUT_VARIABLES.temporarily(power):
        assert VARIABLES["max_power"].units == "W"
    assert "max_power" not in VARIABLES
