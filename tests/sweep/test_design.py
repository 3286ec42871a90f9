"""The design table: neither another path nor more runs change a sample."""

import subprocess
import sys

import numpy as np
import pytest

from lienumba.sweep.design import design_table
from lienumba.sweep.distributions.scalar import Normal, Uniform
from tests.facade import ScenarioError

MASS, SPIN = "bodies.top.mass", "bodies.top.angular_velocity[1]"
VARY = {
    MASS: Normal(distribution="normal", std=0.01, relative=True),
    SPIN: Uniform(distribution="uniform", low=148, high=152),
}
NOMINAL = {MASS: 15.0, SPIN: 150.0}


def test_golden_table():
    table = design_table(VARY, NOMINAL, range(3), 2015)
    assert {path: [float(x).hex() for x in column] for path, column in table.items()} == {
        "bodies.top.mass": ["0x1.db7887566f40bp+3", "0x1.e315a2dd8146bp+3", "0x1.e3c0b7364174bp+3"],
        "bodies.top.angular_velocity[1]": [
            "0x1.2e0aec9ce105fp+7",
            "0x1.2936a909f706fp+7",
            "0x1.2fa308637865bp+7",
        ],
    }


def test_another_path_changes_no_sample():
    alone = design_table({MASS: VARY[MASS]}, NOMINAL, range(100), 1)
    turned = design_table({SPIN: VARY[SPIN], MASS: VARY[MASS]}, NOMINAL, range(100), 1)
    np.testing.assert_array_equal(alone[MASS], turned[MASS])


def test_more_runs_and_other_selections_change_no_sample():
    many = design_table(VARY, NOMINAL, range(1003), 1)
    thousand = design_table(VARY, NOMINAL, range(1000), 1)
    chosen = design_table(VARY, NOMINAL, [17, 42], 1)
    for path in VARY:
        np.testing.assert_array_equal(thousand[path], many[path][:1000])
        np.testing.assert_array_equal(chosen[path], many[path][[17, 42]])


def test_another_nominal_value_moves_only_its_own_column():
    before = design_table(VARY, NOMINAL, range(10), 1)
    after = design_table(VARY, NOMINAL | {MASS: 30.0}, range(10), 1)
    np.testing.assert_array_equal(after[MASS], 2 * before[MASS])
    np.testing.assert_array_equal(after[SPIN], before[SPIN])


def test_another_seed_changes_every_sample():
    one, two = (design_table(VARY, NOMINAL, range(100), seed) for seed in (1, 2))
    for path in VARY:
        assert (one[path] != two[path]).all()


def test_the_nominal_run_has_nominal_values_and_shifts_nothing():
    with_nominal = design_table(VARY, NOMINAL, [-1, 0, 1], 1)
    without = design_table(VARY, NOMINAL, [0, 1], 1)
    for path in VARY:
        assert with_nominal[path][0] == NOMINAL[path]
        np.testing.assert_array_equal(with_nominal[path][1:], without[path])


def test_a_sweep_that_varies_nothing_has_an_empty_table():
    assert design_table({}, NOMINAL, range(3), 1) == {}


def test_every_relative_path_with_nominal_value_zero_is_named():
    vary = {"gravity[0]": VARY[MASS], MASS: VARY[MASS], "gravity[1]": VARY[MASS]}
    with pytest.raises(ScenarioError) as caught:
        design_table(vary, NOMINAL | {"gravity[0]": 0.0, "gravity[1]": 0.0}, range(2), 1)
    lines = str(caught.value).splitlines()
    assert len(lines) == 2
    assert lines[0].startswith('sweep.vary."gravity[0]".relative = true: ')
    assert lines[1].startswith('sweep.vary."gravity[1]".relative = true: ')


def test_importing_the_distributions_imports_no_scipy():
    code = "import sys, lienumba.sweep.distributions.registry, lienumba.sweep.design; print('scipy' in sys.modules)"
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert result.stdout.strip() == "False"
