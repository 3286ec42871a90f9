"""Texts that are numbers to Python, and errors that quote what nobody should see as it is."""

import pytest

import lienumba
from lienumba.scenario.base.code import said_of

BODY = {"name": "b", "mass": 1.0, "inertia": [1.0, 1.0, 1.0], "position": [0, 0, 0]}
PUSH = {"type": "force", "body": "b", "value": ["inputs.u", 0, 0]}


def told(**more: object) -> str:
    data = {"model": {"bodies": [BODY], "forces": [PUSH]}, "integrator": {"step": 1e-2, "end_time": 0.1}}
    with pytest.raises(lienumba.ScenarioError) as error:
        lienumba.run(data | {"inputs": {"u": 1.0}} | more)
    return str(error.value)


@pytest.mark.parametrize("text", ["nan", "inf"])
def test_an_input_is_no_text_that_python_reads_as_a_number(text: str) -> None:
    known = '"deg", "pi", "rpm", "t"'
    assert told(inputs={"u": text}) == f'inputs.u = "{text}": has the unknown name "{text}"; known here are {known}'


@pytest.mark.parametrize(("key", "place"), [("times", "times[0]"), ("values", "values[0]")])
def test_points_of_a_table_are_no_texts(key: str, place: str) -> None:
    table = {"times": [0.0, 1.0], "values": [1.0, 2.0]}
    table[key] = ["inf", 1.0]  # type: ignore[list-item]
    assert told(tables={"t": table}).startswith(f'tables.t.{place} = "inf": must be a finite number')


def test_an_error_of_a_law_is_readable() -> None:
    assert said_of(ValueError("a\u202eb\x1b[2J"), "law.py") == "ValueError: a\\u202eb\\x1b[2J"
