"""Units of parameters: those of the numbers for which they stand."""

import pytest

import lienumba
from tests.facade import resolve
from tests.rigs.scenario_example import example

SPRING = {"type": "spring_damper", "bodies": ["ground", "top"], "points": [[0, 0, 0], [0, -1, 0]]}


def scenario():
    data = example(rotation={"axis": [0, 0, 1], "angle": 0})
    data["parameters"] = {"k": 4.0, "c": 2.0, "both": 1.0, "many": [1.0, 2.0], "inner": 3.0, "outer": "2*inner"}
    data["model"]["forces"] = [
        {**SPRING, "name": "first", "stiffness": "k", "damping": "2*c/3", "free_length": "both"},
        {**SPRING, "name": "second", "stiffness": "3*k", "damping": "k*c", "free_length": "many[0]"},
        {"name": "twist", "type": "torque", "body": "top", "value": ["both", "many[1]", "outer"]},
    ]
    data["sweep"] = {
        "runs": 2,
        "vary": {f"parameters.{name}": {"distribution": "uniform", "low": 1, "high": 2} for name in ("k", "many[0]")},
    }
    return data


@pytest.mark.parametrize(
    ("name", "units"),
    [
        ("k", "N m-1"),
        ("c", "N s m-1"),  # what it is in "k*c" says nothing
        ("both", "1"),  # a length here, a torque there
        ("many[0]", "m"),
        ("many[1]", "N m"),
        ("outer", "N m"),
        ("inner", "1"),
    ],
)
def test_a_parameter_has_the_units_of_what_it_stands_for(name, units):
    assert resolve(scenario()).units(f"parameters.{name}") == units


def test_datasets_say_them():
    ds = lienumba.run(scenario(), workers=1, progress=False)
    assert ds["parameters.k"].attrs["units"] == "N m-1"
    assert ds["parameters.many[0]"].attrs["units"] == "m"
