"""What every output variable promises: one way in which it comes about, dimensions that the dataset has."""

import numpy as np
import pytest

from lienumba.mechanics.elements import quantities
from lienumba.mechanics.system import constraints, dynamics, kkt
from lienumba.mechanics.system.output_variables import (
    OUTPUT_VARIABLES,
    Observation,
    OutputVariable,
    kept_at_end,
    kept_largest,
)
from lienumba.store.layout import COORDINATES, RUN, SERIES, VARIABLES
from tests.facade import Instant
from tests.rigs.scenarios import start_of
from tests.rigs.units import OTHER, SEVERAL, SI, Units, moving


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


def at_the_start(u: Units) -> dict[str, tuple[list[str], np.ndarray]]:
    """Units and numbers of what is computed of a state and its accelerations, by plain Python."""
    model, states = start_of(moving(u))
    now = Instant(tuple(map(tuple, states.tolist())))
    solution = dynamics.accelerations(model, kkt.Structure.of(model), now)
    efforts = [[-x for x in solution.mu[rows]] for rows in constraints.rows_of(model)[len(model.joints) :]]
    observed = quantities.Observed(list(solution.x), *constraints.loads(model, now, solution.mu), efforts)
    seen = Observation(model, now, lambda: (observed, solution.mu))
    found = {
        name: (SEVERAL.get(name, [x.units]), np.array(x.rows(seen)))
        for name, x in OUTPUT_VARIABLES.items()
        if x.rows is not None
    }
    own = {
        quantities.joined(q.name, part.name): part.units
        for q in model.quantities
        for part in quantities.parts(model, q)
    }
    return found | {name: ([own[name]], np.array(x)) for name, x in quantities.observe(model, now, observed)}


def test_what_is_computed_of_one_state_scales_by_its_unit() -> None:
    here, there = at_the_start(SI), at_the_start(OTHER)
    for name, (units, numbers) in here.items():
        converted = there[name][1] / [OTHER.of(x) for x in units]
        assert np.allclose(numbers, converted, rtol=1e-12, atol=1e-12), name
