"""Wrong quantities: one clear message each, the same from both commands; nothing is written.

Each case: the text, then its message or messages: key, value, rule; remedy.
"""

from pathlib import Path

import pytest

from tests.scenario.checks.refusal import FREE, joint, refused_by_both, rig
from tests.scenario.checks.test_formulas import PARAMETERS, expression, point, seen, slide, table, torque

QUANTITIES = {
    "unknown body": (
        rig(point('body = "arn"'), torque("tip.x")),
        'quantities.tip.body = "arn": is not a body of the model; the nearest known name is "arm"',
    ),
    "unknown base": (
        rig(point('body = "arm"', 'relative_to = "blok"')),
        'quantities.tip.relative_to = "blok": is not a body of the model; the nearest known name is "block"',
    ),
    "relative to itself": (
        rig(point('body = "arm"', 'relative_to = "arm"')),
        'quantities.tip.relative_to = "arm": is the body itself; name another one, or leave it out',
    ),
    "unknown frame": (
        rig(point('body = "arm"', 'frame = "blok"')),
        'quantities.tip.frame = "blok": is not a body of the model; the nearest known name is "block"',
    ),
    **{
        f"{kind} of an unknown joint": (
            rig(seen("swing", kind, 'joint = "pivto"')),
            'quantities.swing.joint = "pivto": is not a joint of the model; the nearest known name is "pivot"',
        )
        for kind in ("joint", "reaction")
    },
    "unknown driver": (
        rig(slide("t"), seen("pull", "driver_effort", 'driver = "driv"')),
        'quantities.pull.driver = "driv": is not a driver of the model; the nearest known name is "drive"',
    ),
    "unknown body of a momentum": (
        rig(seen("swing", "momentum", 'bodies = ["arm", "blok"]')),
        'quantities.swing.bodies[1] = "blok": is not a body of the model; the nearest known name is "block"',
    ),
    "a joint without a coordinate": (
        rig(FREE, joint('type = "fixed"', "at = [0, 0, -0.3]", name="weld", ends='bodies = ["arm", "free"]'),
            seen("bend", "joint", 'joint = "weld"')),
        'quantities.bend.joint = "weld": a fixed joint has no coordinate; joints that have '
        "one are pivot and rail",
    ),
    **{
        f"the name {name}": (
            rig(point(name=name)),
            f'quantities.{name}.name = "{name}": the dataset has a variable of this name already; give another name',
        )
        for name in ("position", "energy_residual", "status", "time", "axis", "failed")
    },
    "the name of a parameter": (
        rig(PARAMETERS, point(name="kp"), torque("kp*t")),
        "quantities.kp: its name is the name of a parameter; give another name",
    ),
    "the name of a table": (
        rig(table(), point(name="push"), torque("push(t)")),
        "quantities.push: its name is the name of a table; give another name",
    ),
    "a table with the name of a parameter": (
        rig("[parameters]\npush = 1\n", table(), torque("push(t)")),
        "tables.push: its name is the name of a parameter; give another name",
    ),
    "the name of a constant": (
        rig(point(name="deg")),
        "quantities.deg: its name has a meaning in formulas already; give another name",
    ),
    "a word of formulas": (
        rig(point(name="and")),
        "quantities.and: its name has a meaning in formulas already; give another name",
    ),
    "no type": (
        rig("[[quantities]]\nname = \"tip\"\n"),
        "quantities.tip.type is missing; give one of point, joint, rotation_error, angular_velocity, reaction, "
        "driver_effort, momentum, expression, distance, contact, limit, lock",
    ),
    "no name": (
        rig('[[quantities]]\ntype = "point"\nbody = "arm"\n'),
        'quantities[0].name is missing; give the name: a letter, then letters, digits or "_"',
    ),
    "no value": (
        rig(seen("law", "expression")),
        'quantities.law.value is missing; give a number (or a formula of t in quotes, such as "0.3*sin(2*t)"), of '
        "other quantities and of parameters",
    ),
    "twice the same name": (
        rig(point(), point()),
        'quantities[1].name = "tip": is also the name of quantities[0]; give each its own name',
    ),
    "not known, to be stored": (
        rig(point()) + '\n[output]\nvariables = ["tipp"]\n',
        'output.variables[0] = "tipp": is not known; the nearest known name is "tip"',
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", QUANTITIES)
def test_wrong_quantity(tmp_path: Path, case: str) -> None:
    text, *messages = QUANTITIES[case]
    assert refused_by_both(tmp_path, text) == messages


UNCLEAR = {
    "the place that holds something else meanwhile": (
        rig(point(), point('body = "arm"', 'point = [0, 0, "tip.x"]', name="other")),
        "1 + 0*t",
    ),
    "the model, in which no quantity stands": (rig(expression("law", "1/0")), "model.quantities"),
    "two sentences on one thing": (
        rig(seen("swing", "momentum", 'about = "center"')),
        'must be "mass_centre"; the nearest is "mass_centre"',
    ),
    "numbers in quotes": (rig(point('body = "arm"', "derivative = 3")), '"0" or "1"'),
}


@pytest.mark.parametrize("case", UNCLEAR)
def test_messages_do_not_speak_of(tmp_path: Path, case: str) -> None:
    text, words = UNCLEAR[case]
    (message,) = refused_by_both(tmp_path, text)
    assert words not in message


def test_a_body_counts_once_in_a_momentum(tmp_path: Path) -> None:
    (message,) = refused_by_both(tmp_path, rig(seen("swing", "momentum", 'bodies = ["arm", "arm"]')))
    assert message.startswith("quantities.swing.bodies")


def test_an_expression_of_the_time_has_numbers_from_the_start() -> None:
    from lienumba.errors import ScenarioError
    from lienumba.scenario.resolve import resolve
    from tests.rigs.scenario_example import EXAMPLE

    told = {"name": "d", "type": "expression", "value": "t/t"}
    with pytest.raises(ScenarioError, match=r"quantities.d.value = \"t/t\": its value at t = 0 is nan; give a formula"):
        resolve(EXAMPLE | {"quantities": [told]})
    assert resolve(EXAMPLE | {"quantities": [told | {"value": "t*t"}]})
