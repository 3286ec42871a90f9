"""Wrong inputs: one sentence each."""

from typing import Any

import pytest

from lienumba import ScenarioError, System
from lienumba.scenario.start.prepare import check_initial
from tests.facade import resolve
from tests.rigs.inputs import at_hinge, wheel

REFUSED: dict[str, tuple[dict[str, Any], str]] = {
    "unknown": (
        {"a": "inputs.bb", "b": 1},
        'inputs.a = "inputs.bb": has the unknown name "inputs.bb"; the nearest known name is "inputs.b"',
    ),
    "in a circle": (
        {"a": "inputs.b", "b": "2*inputs.a"},
        "inputs: inputs.a and inputs.b depend on one another in a circle; give a number for inputs.a",
    ),
    "of a quantity in a circle": (
        {"a": "twice", "b": 1},
        "inputs: twice and inputs.a depend on one another in a circle; give a number for twice",
    ),
    "an acceleration": (
        {"a": "pull.torque.y", "b": 1},
        'inputs.a = "pull.torque.y": reads pull.torque.y, which follows from the forces themselves (an acceleration, a '
        "reaction or an effort), so no force or driver may depend on it; read positions and velocities",
    ),
    "times that do not ascend": (
        {"a": {"times": [0, 1, 1], "values": [1, 2, 3]}, "b": 1},
        "inputs.a.times[2] = 1: does not come after 1; the times must increase",
    ),
    "too short": (
        {"a": {"times": [0, 1.5], "values": [1, 2]}, "b": 1},
        "inputs.a: ends at 1.5, but the run reads it until 2; add a point there, end the run earlier, or give "
        'outside = "hold" or 0',
    ),
    "too late": (
        {"a": {"times": [0.5, 3], "values": [1, 2], "outside": "error"}, "b": 1},
        'inputs.a: begins at 0.5, but the run reads it from 0 on; add a point there, or give outside = "hold" or 0',
    ),
    "a delay of a formula": (
        {"a": {"value": "t", "delay": 0.1}, "b": 1},
        "inputs.a.delay has no meaning for an input with value; leave it out (it belongs to an input with file: by how "
        "much later in s it is played; a delayed feedback is a law in Python with every and memory)",
    ),
    "follows nothing": (
        {"a": {"joint": "hinge", "target": 0}, "b": 1},
        "inputs.a: has neither kp nor kd, so it follows nothing; give one of them",
    ),
    "no such joint": (
        {"a": {"joint": "hing", "kp": 1, "target": 0}, "b": 1},
        'inputs.a.joint = "hing": is not a joint of the model; the nearest known name is "hinge"',
    ),
    "a target without a rate": (
        {"a": {"joint": "hinge", "kp": 1, "kd": 1, "target": "inputs.b"}, "b": "hinge_at.rate"},
        'inputs.a.target = "inputs.b": reads inputs.b, which depends on velocities, but kd needs the rate of the '
        "target, unless rate is given; read positions only",
    ),
    "two kinds of limits": (
        {"a": {"value": 1, "limit": 1, "limits": [0, 1]}, "b": 1},
        "inputs.a: has both limit and limits; leave one of them out",
    ),
    "the larger limit first": (
        {"a": {"value": 1, "limits": [1, 0]}, "b": 1},
        "inputs.a.limits = [1.0, 0.0]: has the larger number first; give the least value first",
    ),
    "a start without a state": (
        {"a": {"value": 1, "start": 1}, "b": 1},
        "inputs.a.start = 1.0: has no effect without filter; give filter, or leave it out",
    ),
    "no valid name": (
        {"a": 1, "b": 1, "c d": 1},
        'inputs.c d: is no valid name; give the name: a letter, then letters, digits or "_"',
    ),
}  # fmt: skip


def system(inputs: dict[str, Any]) -> System:
    made = at_hinge("inputs.a + inputs.b").quantity("pull", "reaction", joint="hinge")
    made.quantity("twice", "expression", value="2*inputs.a")
    for name, x in inputs.items():
        made = made.input(name, **x) if isinstance(x, dict) else made.input(name, x)
    return made


def said(made: System, **overrides: Any) -> str:
    with pytest.raises(ScenarioError) as caught:
        check_initial(resolve(made, overrides=overrides))
    return str(caught.value)


@pytest.mark.parametrize(("inputs", "sentence"), REFUSED.values(), ids=REFUSED.keys())
def test_one_sentence(inputs: dict[str, Any], sentence: str) -> None:
    assert said(system(inputs)).splitlines()[-1] == sentence


def test_a_driver_reads_no_velocities_through_an_input() -> None:
    driven = wheel().driver("crank", joint="hinge", value="inputs.a").input("a", "hinge_at.rate")
    assert said(driven) == (
        'model.drivers.crank.value = "inputs.a": reads inputs.a, which depends on velocities, but what a driver '
        "prescribes is differentiated; read positions only"
    )
    driven = wheel().driver("crank", joint="hinge", value="inputs.a").input("a", value="t", filter=0.1)
    assert "reads inputs.a, which is a state, but" in said(driven)


def test_a_driver_plays_nothing_that_jumps() -> None:
    driven = wheel().driver("crank", joint="hinge", value="inputs.a")
    driven.input("a", times=[0, 1, 2], values=[0, 0.1, 0], interpolation="hold")
    assert said(driven).startswith('model.drivers.crank = "inputs.a": jumps by 0.1 at t = 1, and nothing can move')
    check_initial(resolve(driven, overrides={"inputs.a.interpolation": "cubic"}))


def test_names_that_clash() -> None:
    named = at_hinge("inputs.a").input("a", 1)
    assert said(named.parameter("inputs", 3)) == (
        "parameters.inputs: has a meaning in formulas already; give another name; reserved are t, inputs, pi, deg, rpm "
        "and the keywords of Python"
    )
    named = at_hinge("inputs.a").input("a", 1).quantity("inputs", "joint", joint="hinge")
    assert "quantities.inputs: its name has a meaning in formulas already" in said(named)


def test_paths_that_lead_nowhere() -> None:
    named = at_hinge("inputs.a").input("a", 1)
    assert said(named, **{"inputs.b": 2}) == (
        '{"inputs.b": 2}: the path inputs.b is no input of the scenario; known here are "a"'
    )
    assert "too deep" in said(named, **{"inputs.a.kp": 2})
    vary = {"sweep.runs": 2, "sweep.vary": {"inputs.b": {"distribution": "normal", "std": 1}}}
    assert said(named, **vary) == (
        'sweep.vary."inputs.b": the path inputs.b does not exist; the nearest numeric path is "inputs.a"'
    )


def test_what_nothing_reads_is_told() -> None:
    warnings = resolve(at_hinge("inputs.a").input("a", 1).input("b", 1)).warnings
    assert [str(x) for x in warnings] == ["inputs.b: nothing reads it; write inputs.b in a formula, or remove it"]
