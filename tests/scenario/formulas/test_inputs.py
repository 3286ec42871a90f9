"""Inputs by name: numbers and formulas give what the same numbers and formulas give where they are used."""

from typing import Any

import numpy as np
import pytest

import lienumba
from lienumba import System
from tests.rigs.inputs import at_hinge, wheel


def angle(system: System, **overrides: Any) -> np.ndarray:
    return lienumba.run(system, overrides=overrides)["hinge_at.angle"].values[0]


def test_numbers_and_formulas_are_what_they_say() -> None:
    system = at_hinge("3*clip(inputs.motor, -1, 1) + inputs.other")
    system.input("motor", 0.7)
    system.input("other", "2*sin(3*t) - 0.5*hinge_at.rate + inputs.motor")
    same = at_hinge("3*clip(0.7, -1, 1) + (2*sin(3*t) - 0.5*hinge_at.rate + 0.7)")
    np.testing.assert_allclose(angle(system), angle(same), rtol=0, atol=1e-13)


def test_a_formula_is_stored_with_its_units_and_a_number_is_not() -> None:
    system = at_hinge("inputs.motor + inputs.constant")
    system.input("constant", 0.1)
    system.input("motor", "2*t", units="N m")
    ds = lienumba.run(system)
    np.testing.assert_allclose(ds["inputs.motor"].values[0], 2 * ds.time.values, rtol=0, atol=1e-15)
    assert ds["inputs.motor"].attrs["units"] == "N m"
    assert "inputs.constant" not in ds
    assert "inputs.motor" not in lienumba.run(system, overrides={"output.variables": ["position"]})
    one = lienumba.run(system, overrides={"output.variables": ["inputs.motor"]})
    assert {"inputs.motor"} == {name for name in one.data_vars if "time" in one[name].dims}


def test_a_number_is_set_and_varied_by_its_path() -> None:
    system = at_hinge("inputs.motor*sin(5*t)")
    system.input("motor", 1.0)
    system.sweep(runs=4, sampler="latin_hypercube")
    system.vary("inputs.motor", distribution="uniform", low=1, high=3)
    ds = lienumba.run(system)
    for run, motor in enumerate(ds["inputs.motor"].values):
        alone = at_hinge("inputs.motor*sin(5*t)")
        alone.input("motor", float(motor))
        np.testing.assert_array_equal(ds["hinge_at.angle"].values[run], angle(alone))


def test_a_number_takes_the_place_of_a_formula() -> None:
    system = at_hinge("inputs.motor")
    system.input("motor", "5*sin(t)")
    number = at_hinge("inputs.motor")
    number.input("motor", 3)
    np.testing.assert_array_equal(angle(system, **{"inputs.motor": "3"}), angle(number))


def test_a_driver_reads_what_depends_on_time_and_positions_alone() -> None:
    system = wheel().driver("drive", joint="hinge", value="inputs.reference")
    system.input("reference", "0.3*sin(2*t)*inputs.size")
    system.input("size", 2.0)
    ds = lienumba.run(system)
    np.testing.assert_allclose(ds["hinge_at.angle"].values[0], 0.6 * np.sin(2 * ds.time.values), rtol=0, atol=1e-12)


def test_what_extends_a_scenario_changes_inputs_by_name(tmp_path: Any) -> None:
    base = at_hinge("inputs.a + inputs.b")
    base.input("a", 1.0).input("b", "sin(t)")
    (tmp_path / "base.toml").write_text(base.to_toml())
    (tmp_path / "over.toml").write_text('extends = "base.toml"\n[inputs]\nb = 2.0\n')
    expected = at_hinge("1.0 + 2.0")
    np.testing.assert_array_equal(angle(System.from_toml(tmp_path / "over.toml")), angle(expected))


@pytest.mark.parametrize("coordinates", ["lie", "joint"])
def test_results_do_not_depend_on_workers(coordinates: str) -> None:
    system = at_hinge("inputs.motor + inputs.lagging")
    system.input("motor", "2*sin(7*t) - 0.2*hinge_at.rate")
    system.input("lagging", value="inputs.motor", filter=0.1)
    system.sweep(runs=20)
    system.vary("inputs.lagging.filter", distribution="uniform", low=0.05, high=0.2)
    few, many = (lienumba.run(system, overrides={"integrator.coordinates": coordinates}, workers=n) for n in (1, 2))
    np.testing.assert_array_equal(few["hinge_at.angle"], many["hinge_at.angle"])


def test_formulas_of_parameters_alone_follow_what_a_sweep_varies() -> None:
    """Drag of size c on a mass of 1 kg leaves exp(-c t) of its speed."""
    system = {
        "model": {
            "bodies": [{"name": "b", "mass": 1, "inertia": [1, 1, 1], "velocity": [1, 0, 0]}],
            "forces": [{"name": "air", "type": "drag", "body": "b", "linear": "inputs.wind"}],
        },
        "parameters": {"k": 2.0},
        "inputs": {"wind": "0.5 + k"},
        "integrator": {"end_time": 0.1, "step": 0.01},
        "sweep": {"runs": 3, "seed": 1, "vary": {"parameters.k": {"distribution": "normal", "std": 0.1}}},
    }
    ds = lienumba.run(system)
    expected = np.exp(-0.1 * (0.5 + ds["parameters.k"].values))
    np.testing.assert_allclose(ds.velocity.values[:, -1, 0, 0], expected, rtol=1e-9)
