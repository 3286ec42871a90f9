"""Wrong joints, names and references to them: each wrong argument gives one clear message, the same from both commands.

Each case: the text, then its message or messages: key, value, rule; remedy.
"""

from pathlib import Path

import pytest

from tests.scenario.checks.refusal import (
    ARM,
    BLOCK,
    FREE,
    PIVOT,
    REFERENCES,
    accepted,
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
    "parallel pins": (
        rig(joint('type = "universal"', "at = [0, 0, 0]", "axis = [[1, 0, 0], [2, 0, 0]]")),
        "model.joints.extra.axis = [[1.0, 0.0, 0.0], [2.0, 0.0, 0.0]]: the two directions are parallel "
        "and must be perpendicular; give the direction in each of the two bodies",
    ),
    "opposite directions, to be perpendicular": (
        rig(joint('type = "perpendicular_axes"', "axis = [[1, 0, 0], [-1, 0, 0]]")),
        "model.joints.extra.axis = [[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]]: the two directions are parallel "
        "and must be perpendicular; give the direction in each of the two bodies",
    ),
    "one axis for a universal": (
        rig(joint('type = "universal"', "at = [0, 0, 0]", "axis = [0, 0, 1]")),
        "model.joints.extra.axis = [0, 0, 1]: has 3 entries and must have 2; give two directions in the "
        "global frame at the start, instead of axes: the one of each body",
    ),
    "two axes for a revolute": (
        rig(joint('type = "revolute"', "at = [0, 0, 0]", "axis = [[0, 0, 1], [0, 0, 1]]")),
        "model.joints.extra.axis[0] = [0, 0, 1]: must be a number; give the common direction in the "
        "global frame at the start, instead of axes: 3 numbers",
        "model.joints.extra.axis[1] = [0, 0, 1]: must be a number; give the common direction in the "
        "global frame at the start, instead of axes: 3 numbers",
    ),
    "a number for an axis": (
        rig(joint('type = "revolute"', "at = [0, 0, 0]", "axis = 1")),
        "model.joints.extra.axis = 1: must be a list; give the common direction in the global frame at "
        "the start, instead of axes: 3 numbers",
    ),
    "a list for a component": (
        rig(joint('type = "revolute"', POINTS, "axes = [[[0], 1, 0], [0, 1, 0]]")),
        "model.joints.extra.axes[0][0] = [0]: must be a number; give two directions, each with 3 numbers "
        "in the frame of its own body",
    ),
    "NaN in a point": (
        rig(joint('type = "spherical"', "points = [[0, 0, nan], [0, 0, 0]]")),
        "model.joints.extra.points[0][2] = nan: must be a finite number; replace it",
    ),
    "infinity in at": (
        rig(joint('type = "spherical"', "at = [0, inf, 0]")),
        "model.joints.extra.at[1] = inf: must be a finite number; replace it",
    ),
    "a text in a point": (
        rig(joint('type = "spherical"', 'points = [["0", 0, 0], [0, 0, 0]]')),
        'model.joints.extra.points[0][0] = "0": must be a number, not a text; write it without quotes: 0',
    ),
    "a formula in a point": (
        rig(joint('type = "spherical"', 'points = [["0.1*t", 0, 0], [0, 0, 0]]')),
        'model.joints.extra.points[0][0] = "0.1*t": must be a number, not a formula, because it cannot '
        "vary in time; give two points in m, each with 3 numbers in the frame of its own body",
    ),
    "length 0": (
        rig(joint('type = "distance"', POINTS, "length = 0")),
        "model.joints.extra.length = 0: must be above 0; give the distance of the two points in m, above "
        "0 (or omit it: as at the start)",
    ),
    "negative length": (
        rig(joint('type = "distance"', POINTS, "length = -0.5")),
        "model.joints.extra.length = -0.5: must be above 0; give the distance of the two points in m, "
        "above 0 (or omit it: as at the start)",
    ),
    "a rod at one point": (
        rig(joint('type = "distance"', "at = [0, 0, 0]")),
        "model.joints.extra.at has no meaning for a distance joint; leave it out (it belongs to "
        "spherical, revolute, universal, cylindrical, prismatic, fixed, planar, point_on_line, "
        "point_in_plane, screw)",
    ),
    "pitch 0": (
        rig(joint('type = "screw"', POINTS, PIVOT, "pitch = 0")),
        "model.joints.extra.pitch = 0: must not be 0; for a joint that only turns use a revolute joint",
    ),
    "no pitch": (
        rig(joint('type = "screw"', POINTS, PIVOT)),
        "model.joints.extra.pitch is missing; give the displacement in m per turn, not 0; negative for a "
        "left-hand thread",
    ),
    "ratio 0": (
        rig(joint('type = "gear"', "ratio = 0", ends=COUPLED)),
        "model.joints.extra.ratio = 0: must not be 0; give second = ratio * first + offset",
    ),
    "no ratio": (
        rig(joint('type = "coupler"', ends=COUPLED)),
        "model.joints.extra.ratio is missing; give the ratio, not 0: second = ratio * first + offset",
    ),
    "a ratio that varies": (
        rig(joint('type = "gear"', 'ratio = "2 + t"', ends=COUPLED)),
        'model.joints.extra.ratio = "2 + t": must be a number, not a formula, because it cannot vary in '
        "time; give the ratio, not 0: second = ratio * first + offset",
    ),
    "gear of an unknown joint": (
        rig(joint('type = "gear"', "ratio = 2", ends='joints = ["pivto", "rail"]')),
        'model.joints.extra.joints[0] = "pivto": is not a joint of the model; the nearest known name is "pivot"',
    ),
    "gear of a body": (
        rig(joint('type = "gear"', "ratio = 2", ends='joints = ["arm", "rail"]')),
        'model.joints.extra.joints[0] = "arm": is not a joint of the model; known here are "pivot", "rail"',
    ),
    "gear of bodies": (
        rig(joint('type = "gear"', "ratio = 2")),
        "model.joints.extra.joints is missing; give the names of the two joints whose coordinates it couples",
        "model.joints.extra.bodies has no meaning for a gear joint; leave it out (it belongs to "
        "spherical, revolute, universal, cylindrical, prismatic, fixed, planar, point_on_line, "
        "point_in_plane, distance, parallel_axes, perpendicular_axes, screw, python)",
    ),
    "gear of one joint": (
        rig(joint('type = "gear"', "ratio = 2", ends='joints = ["pivot"]')),
        'model.joints.extra.joints = ["pivot"]: has 1 entry and must have 2; give the names of the two '
        "joints whose coordinates it couples",
    ),
    "gear of a joint without coordinate": (
        rig(BALL, joint('type = "gear"', "ratio = 2", ends='joints = ["ball", "rail"]')),
        'model.joints.extra.joints[0] = "ball": is a spherical joint, which has no coordinate; joints '
        "with an angle or a displacement are revolute, cylindrical, prismatic, point_on_line, screw",
    ),
    "gear of a gear": (
        rig(
            joint('type = "gear"', "ratio = 2", name="first", ends=COUPLED),
            joint('type = "gear"', "ratio = 2", ends='joints = ["first", "rail"]'),
        ),
        'model.joints.extra.joints[0] = "first": is a gear joint, which has no coordinate; joints with '
        "an angle or a displacement are revolute, cylindrical, prismatic, point_on_line, screw",
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
    "gear of an ambiguous coordinate": (
        rig(TUBE, joint('type = "gear"', "ratio = 2", ends='joints = ["tube", "rail"]')),
        "model.joints.extra.coordinates[0] is missing: tube is a cylindrical joint, which has 2; give "
        '"angle" or "displacement"',
    ),
    "gear of a coordinate that is not there": (
        rig(joint('type = "gear"', "ratio = 2", 'coordinates = ["displacement", "displacement"]', ends=COUPLED)),
        'model.joints.extra.coordinates[0] = "displacement": pivot is a revolute joint, which has no '
        'displacement; give "angle"',
    ),
    "gear of an unknown coordinate": (
        rig(joint('type = "gear"', "ratio = 2", 'coordinates = ["angel", "displacement"]', ends=COUPLED)),
        'model.joints.extra.coordinates[0] = "angel": must be "angle" or "displacement"; the nearest is "angle"',
    ),
    "coordinate for coordinates": (
        rig(joint('type = "gear"', "ratio = 2", 'coordinate = "angle"', ends=COUPLED)),
        'model.joints.extra.coordinate is not a known key; the nearest known name is "coordinates"',
    ),
    "no type": (
        rig(joint(POINTS)),
        "model.joints.extra.type is missing; give one of spherical, revolute, universal, cylindrical, "
        "prismatic, fixed, planar, point_on_line, point_in_plane, distance, parallel_axes, "
        "perpendicular_axes, screw, gear, coupler, python",
    ),
    "hinge": (
        rig(joint('type = "hinge"', POINTS, PIVOT)),
        'model.joints.extra.type = "hinge": is not known; the nearest known name is "revolute"',
    ),
    "upper case": (
        rig(joint('type = "Revolute"', POINTS, PIVOT)),
        'model.joints.extra.type = "Revolute": is not known; the nearest known name is "revolute"',
    ),
    "a type that is no word": (
        rig(joint("type = 3", POINTS)),
        'model.joints.extra.type = 3: is not known; known here are "spherical", "revolute", "universal", '
        '"cylindrical", "prismatic", "fixed", "planar", "point_on_line", "point_in_plane", "distance", '
        '"parallel_axes", "perpendicular_axes", "screw", "gear", "coupler", "python"',
    ),
    "a type like none": (
        rig(joint('type = "zzz"', POINTS)),
        'model.joints.extra.type = "zzz": is not known; known here are "spherical", "revolute", '
        '"universal", "cylindrical", "prismatic", "fixed", "planar", "point_on_line", "point_in_plane", '
        '"distance", "parallel_axes", "perpendicular_axes", "screw", "gear", "coupler", "python"',
    ),
    "length of a revolute": (
        rig(joint('type = "revolute"', POINTS, PIVOT, "length = 1")),
        "model.joints.extra.length has no meaning for a revolute joint; leave it out (it belongs to distance)",
    ),
    "references of a ball": (
        rig(joint('type = "spherical"', POINTS, REFERENCES)),
        "model.joints.extra.references has no meaning for a spherical joint; leave it out (it belongs to "
        "revolute, universal, cylindrical, prismatic, fixed, planar, screw)",
    ),
    "point for points": (
        rig(joint('type = "spherical"', "point = [0, 0, 0]", POINTS)),
        'model.joints.extra.point is not a known key; the nearest known name is "points"',
    ),
    "anchor for points": (
        rig(joint('type = "spherical"', "anchor = [0, 0, 0]", POINTS)),
        'model.joints.extra.anchor is not a known key; the nearest known name is "points"',
    ),
    "a key with a slip": (
        rig(joint('type = "revolute"', POINTS, PIVOT, "refrences = [[1, 0, 0], [1, 0, 0]]")),
        'model.joints.extra.refrences is not a known key; the nearest known name is "references"',
    ),
    "stiffness of a joint": (
        rig(joint('type = "revolute"', POINTS, PIVOT, "stiffness = 3")),
        'model.joints.extra.stiffness is not a known key here; "stiffness" belongs in [[model.forces]]',
    ),
    "unknown body": (
        rig(joint('type = "spherical"', POINTS, ends='bodies = ["amr", "block"]')),
        'model.joints.extra.bodies[0] = "amr": is not a body of the model; the nearest known name is "arm"',
    ),
    "the world": (
        rig(joint('type = "spherical"', POINTS, ends='bodies = ["world", "block"]')),
        'model.joints.extra.bodies[0] = "world": is not a body of the model; the nearest known name is "ground"',
    ),
    "a joint for a body": (
        rig(joint('type = "spherical"', POINTS, ends='bodies = ["pivot", "block"]')),
        'model.joints.extra.bodies[0] = "pivot": is not a body of the model; known here are "arm", "block", "ground"',
    ),
    "the ground to itself": (
        rig(joint('type = "spherical"', POINTS, ends='bodies = ["ground", "ground"]')),
        'model.joints.extra.bodies = ["ground", "ground"]: joins "ground" to itself; name two different bodies',
    ),
    "three bodies": (
        rig(joint('type = "spherical"', POINTS, ends='bodies = ["ground", "arm", "block"]')),
        'model.joints.extra.bodies = ["ground", "arm", "block"]: has 3 entries and must have 2; give the '
        'names of the two bodies it joins; the fixed world is "ground"',
    ),
    "one body": (
        rig(joint('type = "spherical"', POINTS, ends='bodies = "arm"')),
        'model.joints.extra.bodies = "arm": must be a list; give the names of the two bodies it joins; '
        'the fixed world is "ground"',
    ),
    "numbers for bodies": (
        rig(joint('type = "spherical"', POINTS, ends="bodies = [0, 0]")),
        "model.joints.extra.bodies[0] = 0: must be a text in quotes; give the names of the two bodies it "
        'joins; the fixed world is "ground"',
        "model.joints.extra.bodies[1] = 0: must be a text in quotes; give the names of the two bodies it "
        'joins; the fixed world is "ground"',
    ),
    "body for bodies": (
        rig(joint('type = "spherical"', POINTS, ends='body = "arm"')),
        'model.joints.extra.body is not a known key; the nearest known name is "bodies"',
    ),
}


TABLES = {
    "drivers as a table": (
        rig("[model.drivers]", 'joint = "pivot"', "value = 0"),
        'model.drivers = {joint = "pivot", value = 0}: must be a list (a list of tables is written with '
        "double brackets); give prescribed motions, each as [[model.drivers]]",
    ),
    "a driver by its name": (
        rig("[model.drivers.drive]", 'joint = "pivot"', "value = 0"),
        'model.drivers = {drive = {joint = "pivot", value = 0}}: must be a list (a list of tables is '
        "written with double brackets); give prescribed motions, each as [[model.drivers]]",
    ),
    "forces as a table": (
        rig("[model.forces]", 'type = "drag"', 'body = "arm"'),
        'model.forces = {type = "drag", body = "arm"}: must be a list (a list of tables is written with '
        "double brackets); give force laws, each as [[model.forces]]",
    ),
    "drivers as a text": (
        rig(model='[model]\ndrivers = "pivot"\n'),
        'model.drivers = "pivot": must be a list; give prescribed motions, each as [[model.drivers]]',
    ),
    "numbers for forces": (
        rig(model="[model]\nforces = [3, []]\n"),
        "model.forces[0] = 3: must be a table of keys and values; give force laws, each as [[model.forces]]",
        "model.forces[1] = []: must be a table of keys and values; give force laws, each as [[model.forces]]",
    ),
    "a list for a joint": (
        rig(model="[model]\ndrivers = [[]]\n"),
        "model.drivers[0] = []: must be a table of keys and values; write it as [[model.drivers]]",
    ),
    "drivers outside the model": (
        rig("[[drivers]]", 'joint = "pivot"', "value = 0"),
        'drivers is not a known key here; "drivers" belongs in [model]',
    ),
    "one driver": (
        rig("[[model.driver]]", 'joint = "pivot"', "value = 0"),
        'model.driver is not a known key; the nearest known name is "drivers"',
    ),
    "a table for a name": (
        rig(joint('type = "spherical"', "at = [0, 0, 0]").replace('"extra"', "{ a = 1 }")),
        "model.joints[2].name = {a = 1}: must be a text in quotes; give the name: a letter, then "
        'letters, digits or "_"',
    ),
    "a table for a list": (
        rig(joint('type = "spherical"', "points = { a = [0, 0, 0] }")),
        "model.joints.extra.points = {a = [0, 0, 0]}: must be a list; give two points in m, each with 3 "
        "numbers in the frame of its own body",
    ),
    "duplicate drivers": (
        rig(driver('joint = "pivot"', "value = 0"), driver('joint = "rail"', "value = 1")),
        'model.drivers[1].name = "drive": is also the name of model.drivers[0]; give each its own name',
    ),
    "duplicate forces": (
        rig(*3 * [force('type = "drag"', 'body = "arm"')]),
        'model.forces[2].name = "push": is also the name of model.forces[0] and model.forces[1]; give '
        "each its own name",
    ),
    "a driver called ground": (
        rig(driver('joint = "pivot"', "value = 0", name='name = "ground"')),
        'model.drivers[0].name = "ground": is reserved for the fixed world; give another name',
    ),
    "a force called ground": (
        rig(force('type = "drag"', 'body = "arm"', name='name = "ground"')),
        'model.forces[0].name = "ground": is reserved for the fixed world; give another name',
    ),
    "a joint called ground": (
        rig(joint('type = "spherical"', "at = [0, 0, 0]", name="ground")),
        'model.joints[2].name = "ground": is reserved for the fixed world; give another name',
    ),
    "a name that is a number": (
        rig(force('type = "drag"', 'body = "arm"', name="name = 3")),
        'model.forces[0].name = 3: must be a text in quotes; give the name: a letter, then letters, digits or "_"',
    ),
    "a name with a point": (
        rig(force('type = "drag"', 'body = "arm"', name='name = "a.b"')),
        'model.forces.a.b.name = "a.b": is no valid name; give the name: a letter, then letters, digits or "_"',
    ),
    "guess and given": (
        rig(block=BLOCK + "guess = { position = [1, 0, 0] }\n"),
        "model.bodies.block.guess.position: the body has a position already, which is held; leave one of the two out",
    ),
    "a guess of mass": (
        rig(block="guess = { mass = 1 }\n"),
        'model.bodies.block.guess.mass is not a known key here; "mass" belongs in [[model.bodies]]',
    ),
    "a guess with a slip": (
        rig(block="guess = { posiiton = [1, 0, 0] }\n"),
        'model.bodies.block.guess.posiiton is not a known key; the nearest known name is "position"',
    ),
    "a guess that is a list": (
        rig(block="guess = [1, 0, 0]\n"),
        "model.bodies.block.guess = [1, 0, 0]: must be a table of keys and values; give where to start "
        "for what is omitted: position, rotation, velocity, angular_velocity, not held",
    ),
    "a guess without direction": (
        rig(block="guess = { rotation = [0, 0, 0, 0] }\n"),
        "model.bodies.block.guess.rotation = [0.0, 0.0, 0.0, 0.0]: is a quaternion of length 0; give [w, "
        "x, y, z] of length 1, such as [1, 0, 0, 0] for no rotation",
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
    "relative in a circle": (
        rig(arm=ARM + 'relative_to = "block"\n', block=BLOCK + 'relative_to = "arm"\n'),
        'model.bodies.arm.relative_to = "block": goes around in a circle, arm -> block -> arm; give one '
        "of these bodies relative to the ground",
    ),
    "relative to a joint": (
        rig(block=BLOCK + 'relative_to = "pivot"\n'),
        'model.bodies.block.relative_to = "pivot": is not a body of the model; known here are "arm", "ground"',
    ),
    "relative to a number": (
        rig(block=BLOCK + "relative_to = 3\n"),
        "model.bodies.block.relative_to = 3: must be a text in quotes; give the name of the body in "
        "whose frame position, rotation and velocities are given; omitted velocities move with it",
    ),
    "two bases that are not there": (
        rig(arm=ARM + 'relative_to = "blck"\n', block=BLOCK + 'relative_to = "amr"\n'),
        'model.bodies.arm.relative_to = "blck": is not a body of the model; the nearest known name is "block"',
        'model.bodies.block.relative_to = "amr": is not a body of the model; the nearest known name is "arm"',
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
    "a mass that varies": (
        rig(FREE.replace("mass = 1", 'mass = "2 - t"')),
        'model.bodies.free.mass = "2 - t": must be a number, not a formula, because it cannot vary in '
        "time; give the mass in kg, above 0",
    ),
    "a mass as a word": (
        rig(FREE.replace("mass = 1", 'mass = "heavy"')),
        'model.bodies.free.mass = "heavy": must be a number; give the mass in kg, above 0',
    ),
}

CASES = JOINTS | TABLES


@pytest.mark.parametrize("case", CASES.values(), ids=CASES)
def test_wrong_argument(tmp_path: Path, case: tuple[str, ...]) -> None:
    text, *messages = case
    assert refused_by_both(tmp_path, text) == messages


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
