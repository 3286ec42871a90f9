"""Wrong joints, names and references to them: each wrong argument gives one clear message, the same from both commands.

Each case: the text, then its message or messages: key, value, rule; remedy.
"""

from pathlib import Path

import pytest

from tests.scenario.checks.refusal import (
    ARM,
    BLOCK,
    PIVOT,
    accepted,
    check_refused,
    driver,
    force,
    joint,
    refused_by_both,
    rig,
)

POINTS = "points = [[0, 0, -0.3], [0, 0, 0]]"
COUPLED = 'joints = ["pivot", "rail"]'
BALL = joint('type = "spherical"', "at = [0, 0, -0.3]", name="ball")
TUBE = joint('type = "cylindrical"', "at = [0, 0, -0.3]", "axis = [0, 1, 0]", name="tube")

JOINTS = {
    "opposite directions, to be perpendicular": (
        rig(joint('type = "perpendicular_axes"', "axis = [[1, 0, 0], [-1, 0, 0]]")),
        "model.joints.extra.axis = [[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]]: the two directions are parallel "
        "and must be perpendicular; give the direction in each of the two bodies",
    ),
    "gear of one joint": (
        rig(joint('type = "gear"', "ratio = 2", ends='joints = ["pivot"]')),
        'model.joints.extra.joints = ["pivot"]: has 1 entry and must have 2; give the names of the two '
        "joints whose coordinates it couples",
    ),
    "gear of itself": (
        rig(joint('type = "gear"', "ratio = 2", ends='joints = ["extra", "rail"]')),
        'model.joints.extra.joints[0] = "extra": is a gear joint, which has no coordinate; joints with '
        "an angle or a displacement are revolute, cylindrical, prismatic, point_on_line, screw",
    ),
    "gear of one coordinate twice": (
        rig(joint('type = "gear"', "ratio = 2", ends='joints = ["rail", "rail"]')),
        'model.joints.extra.joints = ["rail", "rail"]: couples a coordinate to itself; name two different coordinates',
    ),
}


TABLES = {
    "forces as a table": (
        rig("[model.forces]", 'type = "drag"', 'body = "arm"'),
        'model.forces = {type = "drag", body = "arm"}: must be a list (a list of tables is written with '
        "double brackets); give force laws, each as [[model.forces]]",
    ),
    "drivers as a text": (
        rig(model='[model]\ndrivers = "pivot"\n'),
        'model.drivers = "pivot": must be a list; give prescribed motions, each as [[model.drivers]]',
    ),
    "a list for a joint": (
        rig(model="[model]\ndrivers = [[]]\n"),
        "model.drivers[0] = []: must be a table of keys and values; write it as [[model.drivers]]",
    ),
    "a force called ground": (
        rig(force('type = "drag"', 'body = "arm"', name='name = "ground"')),
        'model.forces[0].name = "ground": is reserved for the fixed world; give another name',
    ),
    "a name with a point": (
        rig(force('type = "drag"', 'body = "arm"', name='name = "a.b"')),
        'model.forces.a.b.name = "a.b": is no valid name; give the name: a letter, then letters, digits or "_"',
    ),
    "guess and given": (
        rig(block=BLOCK + "guess = { position = [1, 0, 0] }\n"),
        "model.bodies.block.guess.position: the body has a position already, which is held; leave one of the two out",
    ),
    "a guess that is a list": (
        rig(block="guess = [1, 0, 0]\n"),
        "model.bodies.block.guess = [1, 0, 0]: must be a table of keys and values; give where to start "
        "for what is omitted: position, rotation, velocity, angular_velocity, not held",
    ),
    "relative to nothing known": (
        rig(block=BLOCK + 'relative_to = "amr"\n'),
        'model.bodies.block.relative_to = "amr": is not a body of the model; the nearest known name is "arm"',
    ),
    "relative to itself": (
        rig(block=BLOCK + 'relative_to = "block"\n'),
        'model.bodies.block.relative_to = "block": goes around in a circle, block -> block; give one of '
        "these bodies relative to the ground",
    ),
    "gravity with a formula of x": (
        rig(model='[model]\ngravity = [0, 0, "-9.81*x"]\n'),
        'model.gravity[2] = "-9.81*x": has the unknown name "x"; known here are "deg", "pi", "rpm", "t"',
    ),
    "gravity that begins infinite": (
        rig(model='[model]\ngravity = [0, 0, "1/t"]\n'),
        'model.gravity[2] = "1/t": its value at t = 0 is inf; give a formula that begins smoothly with '
        "finite numbers, such as t**2, or sqrt(t + 0.001)",
    ),
}

# More of these rules: the place, and words of the rule.
MORE = {
    "model.joints.extra.points[0][0]: must be a number, not a formula, because it": rig(
        joint('type = "spherical"', 'points = [["0.1*t", 0, 0], [0, 0, 0]]')
    ),
    "model.joints.extra.pitch: must not be": rig(joint('type = "screw"', POINTS, PIVOT, "pitch = 0")),
    "model.joints.extra.ratio: must not be": rig(joint('type = "gear"', "ratio = 0", ends=COUPLED)),
    "model.joints.extra.joints[0]: is a spherical joint, which has no coordinate": rig(
        BALL, joint('type = "gear"', "ratio = 2", ends='joints = ["ball", "rail"]')
    ),
    "model.joints.extra.coordinates[0]: is missing: tube is a cylindrical joint, which": rig(
        TUBE, joint('type = "gear"', "ratio = 2", ends='joints = ["tube", "rail"]')
    ),
    "model.joints.extra.coordinates[0]: pivot is a revolute joint, which has no": rig(
        joint('type = "gear"', "ratio = 2", 'coordinates = ["displacement", "displacement"]', ends=COUPLED)
    ),
    "model.bodies.block.guess.rotation: is a quaternion of length": rig(block="guess = { rotation = [0, 0, 0, 0] }\n"),
    "model.bodies.arm.relative_to: goes around in a circle, arm -> block -> arm": rig(
        arm=ARM + 'relative_to = "block"\n', block=BLOCK + 'relative_to = "arm"\n'
    ),
}

CASES = JOINTS | TABLES
CASES |= {wanted: (text, wanted) for wanted, text in MORE.items()}


@pytest.mark.parametrize("case", CASES.values(), ids=CASES)
def test_wrong_argument(tmp_path: Path, case: tuple[str, ...]) -> None:
    check_refused(tmp_path, *case)


def test_default_names_avoid_given_ones(tmp_path: Path) -> None:
    drag = ['type = "drag"', 'body = "arm"', "quadratic = 1"]
    text = rig(force(*drag, name='name = "drag_2"'), force(*drag, name=""), force(*drag, "linear = -1", name=""))
    (warning,) = accepted(tmp_path, text)
    assert warning.startswith("model.forces.drag_4.linear = -1.0: is negative")


def test_as_many_of_a_thousand_errors_as_somebody_reads(tmp_path: Path) -> None:
    rods = [
        joint('type = "distance"', "points = [[0, 0, 0], [0, 0]]", f"length = {-i}", name=f"rod_{i}")
        for i in range(500)
    ]
    messages = refused_by_both(tmp_path, rig(*rods))
    assert len(set(messages)) == len(messages) == 41
    assert messages[39].startswith("model.joints.rod_19.length = -19: must be above 0")
    assert messages[40] == "960 more problems like these; correct these first"


def test_a_force_without_a_coefficient_is_a_warning(tmp_path: Path) -> None:
    (warning,) = accepted(tmp_path, rig(force('type = "drag"', 'body = "arm"', name="")))
    assert warning.startswith("model.forces.drag_1: has neither linear nor quadratic, so it does nothing; give one of")


def test_a_speed_that_jumps_is_a_warning(tmp_path: Path) -> None:
    (warning,) = accepted(tmp_path, rig(driver('joint = "pivot"', 'rate = "where(t < 0.0047, 0, 1)"')))
    assert "the speed that it prescribes jumps by 1 at t = 0.005, an impact whose work nobody counts" in warning
