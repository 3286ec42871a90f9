"""Wrong quantities: one clear message each, the same from both commands; nothing is written.

Each case: the text, then its message or messages: key, value, rule; remedy.
"""

from pathlib import Path

import pytest

from tests.scenario.checks.refusal import FREE, check_refused, joint, refused_by_both, rig
from tests.scenario.checks.test_formulas import PARAMETERS, expression, point, seen, table, torque

QUANTITIES = {
    "relative to itself": (
        rig(point('body = "arm"', 'relative_to = "arm"')),
        'quantities.tip.relative_to = "arm": is the body itself; name another one, or leave it out',
    ),
    "unknown body of a momentum": (
        rig(seen("swing", "momentum", 'bodies = ["arm", "blok"]')),
        'quantities.swing.bodies[1] = "blok": is not a body of the model; the nearest known name is "block"',
    ),
    "a joint without a coordinate": (
        rig(FREE, joint('type = "fixed"', "at = [0, 0, -0.3]", name="weld", ends='bodies = ["arm", "free"]'),
            seen("bend", "joint", 'joint = "weld"')),
        'quantities.bend.joint = "weld": a fixed joint has no coordinate; joints that have one are pivot and rail',
    ),
    **{
        f"the name {name}": (
            rig(point(name=name)),
            f'quantities.{name}.name = "{name}": the dataset has a variable of this name already; give another name; '
            "docs/write_a_scenario.md lists those that are reserved",
        )
        for name in ("position", "energy_residual", "status", "time", "axis", "failed")
    },
}  # fmt: skip

# More of these rules: the place, and words of the rule.
MORE = {
    "quantities.kp: its name is the name of a parameter": rig(PARAMETERS, point(name="kp"), torque("kp*t")),
    "quantities.push: its name is the name of a table": rig(table(), point(name="push"), torque("push(t)")),
    "tables.push: its name is the name of a parameter": rig("[parameters]\npush = 1\n", table(), torque("push(t)")),
    "quantities.deg: its name has a meaning in formulas already": rig(point(name="deg")),
    "quantities.tip.type: is missing": rig('[[quantities]]\nname = "tip"\n'),
    "quantities[0].name: is missing": rig('[[quantities]]\ntype = "point"\nbody = "arm"\n'),
}


QUANTITIES |= {wanted: (text, wanted) for wanted, text in MORE.items()}


@pytest.mark.parametrize("case", QUANTITIES)
def test_wrong_quantity(tmp_path: Path, case: str) -> None:
    check_refused(tmp_path, *QUANTITIES[case])


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
    from tests.facade import ScenarioError, resolve
    from tests.rigs.scenario_example import EXAMPLE

    told = {"name": "d", "type": "expression", "value": "t/t"}
    with pytest.raises(ScenarioError, match=r"quantities.d.value = \"t/t\": its value at t = 0 is nan; give a formula"):
        resolve(EXAMPLE | {"quantities": [told]})
    assert resolve(EXAMPLE | {"quantities": [told | {"value": "t*t"}]})
