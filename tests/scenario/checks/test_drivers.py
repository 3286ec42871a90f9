"""Wrong drivers and formulas: one clear message each, the same from both commands.

Each case: the text, then its message or messages: key, value, rule; remedy.
"""

from pathlib import Path

import pytest

from tests.scenario.checks.refusal import FREE, driver, force, joint, refused_by_both, rig

PIVOTED = 'joint = "pivot"'
BALL = joint('type = "spherical"', "at = [0, 0, -0.3]", name="ball")
TUBE = joint('type = "cylindrical"', "at = [0, 0, -0.3]", "axis = [0, 1, 0]", name="tube")


def value(formula: str) -> str:
    return rig(driver(PIVOTED, f'value = "{formula}"'))


DRIVERS = {
    "of a joint without coordinate": (
        rig(BALL, driver('joint = "ball"', "value = 1")),
        'model.drivers.drive.joint = "ball": is a spherical joint, which has no coordinate; joints with '
        "an angle or a displacement are revolute, cylindrical, prismatic, point_on_line, screw",
    ),
    "of a coordinate that is not there": (
        rig(driver('joint = "pivot"', 'coordinate = "displacement"', "value = 0")),
        'model.drivers.drive.coordinate = "displacement": pivot is a revolute joint, which has no '
        'displacement; give "angle"',
    ),
    "of an unknown coordinate": (
        rig(driver('joint = "pivot"', 'coordinate = "rotation"', "value = 0")),
        'model.drivers.drive.coordinate = "rotation": must be "angle" or "displacement"; the nearest is "angle"',
    ),
    "of an ambiguous coordinate": (
        rig(TUBE, driver('joint = "tube"', "value = 1")),
        "model.drivers.drive.coordinate is missing: tube is a cylindrical joint, which has 2; give "
        '"angle" or "displacement"',
    ),
    "of an unknown joint": (
        rig(driver('joint = "pivto"', "value = 0")),
        'model.drivers.drive.joint = "pivto": is not a joint of the model; the nearest known name is "pivot"',
    ),
    "of a joint, without value": (
        rig(driver('joint = "pivot"')),
        "model.drivers.drive: has neither value nor rate; give either value (the coordinate itself) or "
        'rate (its speed) as a number or a formula of t, such as "0.3*sin(2*t)"',
    ),
    "of a joint, with value and rate": (
        rig(driver('joint = "pivot"', "value = 0", "rate = 0")),
        "model.drivers.drive: has both value and rate; give either value (the coordinate itself) or rate "
        '(its speed) as a number or a formula of t, such as "0.3*sin(2*t)"',
    ),
    "of nothing": (
        rig(driver("value = 0")),
        "model.drivers.drive: drives nothing; give joint = ..., or body = ... with motion = one of "
        "point, orientation, angular_velocity",
    ),
    "empty, unnamed": (
        rig(driver(name="")),
        "model.drivers.driver_1: drives nothing; give joint = ..., or body = ... with motion = one of "
        "point, orientation, angular_velocity",
    ),
    "of a number": (
        rig(driver("joint = 3", "value = 0")),
        "model.drivers.drive.joint = 3: must be a text in quotes; give the name of the joint",
    ),
    "a list for a number": (
        rig(driver('joint = "pivot"', "value = [1, 2, 3]")),
        "model.drivers.drive.value = [1, 2, 3]: must be a number; give the angle in rad or displacement "
        'in m (or a formula of t in quotes, such as "0.3*sin(2*t)")',
    ),
    "a table for a number": (
        rig(driver('joint = "pivot"', "value = { number = 1 }")),
        "model.drivers.drive.value = {number = 1}: must be a number; give the angle in rad or "
        'displacement in m (or a formula of t in quotes, such as "0.3*sin(2*t)")',
    ),
    "true for a number": (
        rig(driver('joint = "pivot"', "rate = true")),
        "model.drivers.drive.rate = true: must be a number; give its rate in rad/s or m/s, instead of "
        'value (or a formula of t in quotes, such as "0.3*sin(2*t)")',
    ),
    "NaN": (
        rig(driver('joint = "pivot"', "value = nan")),
        "model.drivers.drive.value = nan: must be a finite number; give the angle in rad or displacement "
        'in m (or a formula of t in quotes, such as "0.3*sin(2*t)")',
    ),
    "of a joint, with motion": (
        rig(driver('joint = "pivot"', 'motion = "point"', "value = 0")),
        "model.drivers.drive.motion has no meaning for the driver of a joint; leave it out (it belongs "
        "to point, orientation, angular_velocity)",
    ),
    "of a joint and a body": (
        rig(driver('joint = "pivot"', 'body = "arm"', "value = 0")),
        "model.drivers.drive.body has no meaning for the driver of a joint; leave it out (it belongs to "
        "point, orientation, angular_velocity)",
    ),
    "angle for value": (
        rig(driver('joint = "pivot"', "angle = 0.3")),
        'model.drivers.drive.angle is not a known key; the nearest known name is "value"',
    ),
    "speed for rate": (
        rig(driver('joint = "rail"', "speed = 0.3")),
        'model.drivers.drive.speed is not a known key; the nearest known name is "rate"',
    ),
    "with a type": (
        rig(driver('joint = "pivot"', 'type = "angle"', "value = 0")),
        'model.drivers.drive.type is not a known key here; "type" belongs in [[model.joints]]',
    ),
    "of a body, without motion": (
        rig(driver('body = "arm"', "value = [0, 0, 0]")),
        "model.drivers.drive.motion is missing; give one of point, orientation, angular_velocity",
    ),
    "of an unknown motion": (
        rig(driver('body = "arm"', 'motion = "pont"', "value = [0, 0, 0]")),
        'model.drivers.drive.motion = "pont": is not known; the nearest known name is "point"',
    ),
    "of a rotation": (
        rig(driver('body = "arm"', 'motion = "rotation"', "value = [0, 0, 0]")),
        'model.drivers.drive.motion = "rotation": is not known; the nearest known name is "orientation"',
    ),
    "of a motion of no body": (
        rig(driver('motion = "point"', "value = [0, 0, 0]")),
        "model.drivers.drive.body is missing; give the name of the body",
    ),
    "of a motion without value": (
        rig(driver('body = "arm"', 'motion = "point"')),
        "model.drivers.drive.value is missing; give the position of the point in m, global frame: 3 "
        'numbers (or a formula of t in quotes, such as "0.3*sin(2*t)")',
    ),
    "of a motion with a rate": (
        rig(driver('body = "arm"', 'motion = "point"', "value = [0, 0, 0]", "rate = 0")),
        "model.drivers.drive.rate has no meaning for the motion point; leave it out (it belongs to the "
        "driver of a joint)",
    ),
    "one number for three": (
        rig(driver('body = "arm"', 'motion = "point"', "value = 0")),
        "model.drivers.drive.value = 0: must be a list; give the position of the point in m, global "
        'frame: 3 numbers (or a formula of t in quotes, such as "0.3*sin(2*t)")',
    ),
    "two numbers for three": (
        rig(driver('body = "arm"', 'motion = "point"', "value = [0, 0]")),
        "model.drivers.drive.value = [0, 0]: has 2 entries and must have 3; give the position of the "
        'point in m, global frame: 3 numbers (or a formula of t in quotes, such as "0.3*sin(2*t)")',
    ),
    "frame of a point": (
        rig(driver('body = "arm"', 'motion = "point"', "value = [0, 0, 0]", 'frame = "body"')),
        "model.drivers.drive.frame has no meaning for the motion point; leave it out (it belongs to angular_velocity)",
    ),
    "point of an orientation": (
        rig(driver('body = "arm"', 'motion = "orientation"', "value = [0, 0, 0]", "point = [0, 0, 0]")),
        "model.drivers.drive.point has no meaning for the motion orientation; leave it out (it belongs to point)",
    ),
    "unknown frame": (
        rig(driver('body = "arm"', 'motion = "angular_velocity"', "value = [0, 0, 0]", 'frame = "local"')),
        'model.drivers.drive.frame = "local": must be "global" or "body"; the nearest is "body"',
    ),
    "of the ground": (
        rig(driver('body = "ground"', 'motion = "orientation"', "value = [0, 0, 0]")),
        'model.drivers.drive.body = "ground": the ground does not move; name a body',
    ),
    "of an unknown body": (
        rig(driver('body = "amr"', 'motion = "point"', "value = [0, 0, 0]")),
        'model.drivers.drive.body = "amr": is not a body of the model; the nearest known name is "arm"',
    ),
    "two of one coordinate": (
        rig(driver(PIVOTED, "value = 0", name='name = "a"'), driver(PIVOTED, "value = 0", name='name = "b"')),
        "model.drivers.b: drives the angle of pivot, which a drives already; remove one of the two",
    ),
    "value and rate of one coordinate, unnamed": (
        rig(driver(PIVOTED, "value = 0", name=""), driver(PIVOTED, 'coordinate = "angle"', "rate = 0", name="")),
        "model.drivers.driver_2: drives the angle of pivot, which driver_1 drives already; remove one of the two",
    ),
    "orientation and angular velocity of one body": (
        rig(
            FREE,
            driver('body = "free"', 'motion = "orientation"', "value = [0, 0, 0]", name=""),
            driver('body = "free"', 'motion = "angular_velocity"', "value = [0, 0, 0]", name=""),
        ),
        "model.drivers.driver_2: drives the rotation of free, which driver_1 drives already; remove one of the two",
    ),
    "one point twice": (
        rig(FREE, *2 * [driver('body = "free"', 'motion = "point"', "value = [0, 0, 0]", name="")]),
        "model.drivers.driver_2: drives the point [0.0, 0.0, 0.0] of free, which driver_1 drives "
        "already; remove one of the two",
    ),
}
FORMULAS = {
    "unknown name": (
        value("0.1*sin(om*t)"),
        'model.drivers.drive.value = "0.1*sin(om*t)": has the unknown name "om"; '
        'known here are "deg", "pi", "rpm", "t"',
    ),
    "unknown function": (
        value("0.1*sine(t)"),
        'model.drivers.drive.value = "0.1*sine(t)": calls the unknown function "sine"; the nearest known name is "sin"',
    ),
    "unknown function, upper case": (
        value("Sin(t)"),
        'model.drivers.drive.value = "Sin(t)": calls the unknown function "Sin"; the nearest known name is "sin"',
    ),
    "wrong number of arguments": (
        value("atan2(t)"),
        'model.drivers.drive.value = "atan2(t)": gives atan2 1 argument, it takes 2; correct it',
    ),
    "an attribute": (
        value("t.real"),
        'model.drivers.drive.value = "t.real": contains "t.real", which is not allowed; use numbers, + - '
        "* / **, comparisons, t, pi, deg, rpm and the functions sin, cos, tan, asin, acos, atan, atan2, "
        "exp, log, sqrt, tanh, abs, sign, min, max, clip, floor, ceil, mod, "
        "sinc, sinh, cosh, hypot, where",
    ),
    "an import": (
        value("__import__('os')"),
        'model.drivers.drive.value = "__import__(\'os\')": calls the unknown function "__import__"; known '
        'here are "abs", "acos", "asin", "atan", "atan2", "ceil", "clip", "cos", "cosh", "exp", "floor", "hypot", '
        '"log", "max", "min", "mod", "sign", "sin", "sinc", "sinh", "sqrt", "tan", "tanh", "where"',
    ),
    "an index": (
        value("t[0]"),
        'model.drivers.drive.value = "t[0]": contains "t[0]", which is not allowed; use numbers, + - * / '
        "**, comparisons, t, pi, deg, rpm and the functions sin, cos, tan, asin, acos, atan, atan2, exp, "
        "log, sqrt, tanh, abs, sign, min, max, clip, floor, ceil, mod, "
        "sinc, sinh, cosh, hypot, where",
    ),
    "a condition": (
        value("t > 1"),
        'model.drivers.drive.value = "t > 1": is a condition, not a number; write where(condition, '
        "number, other number)",
    ),
    "an open bracket": (
        value("sin(2*t"),
        'model.drivers.drive.value = "sin(2*t": has 1 "(" and 0 ")"; give each its other half',
    ),
    "a closed bracket": (
        value("2*t)"),
        'model.drivers.drive.value = "2*t)": has 0 "(" and 1 ")"; give each its other half',
    ),
    "a comma": (
        value("0,5*t"),
        'model.drivers.drive.value = "0,5*t": has a comma in a number; a decimal number has a point: 0.5',
    ),
    "a caret": (
        value("t^2"),
        'model.drivers.drive.value = "t^2": has a "^"; a power is written with two stars: t**2',
    ),
    "no star": (
        value("2t"),
        'model.drivers.drive.value = "2t": multiplies without a star; write 2*t, 30*deg',
    ),
    "a unit": (
        value("30 deg"),
        'model.drivers.drive.value = "30 deg": multiplies without a star; write 2*t, 30*deg',
    ),
    "an equation": (
        value("x = 2*t"),
        'model.drivers.drive.value = "x = 2*t": has an equals sign; write only what stands to its right, or compare by '
        "<, <=, > or >=",
    ),
    "empty": (
        value(""),
        'model.drivers.drive.value = "": is empty; write a number, or a formula such as "0.3*sin(2*t)"',
    ),
    "two lines": (
        value(r"t\n+ 1"),
        'model.drivers.drive.value = "t\\n+ 1": is not a formula; write one such as "0.3*sin(2*t) + 0.1*t**2"',
    ),
    "division by zero": (
        value("1/0"),
        'model.drivers.drive.value = "1/0": has the value inf; it must be a finite number',
    ),
    "root of a negative number": (
        value("sqrt(-1)"),
        'model.drivers.drive.value = "sqrt(-1)": has the value nan; it must be a finite number',
    ),
    "infinite at the start": (
        value("1/t"),
        'model.drivers.drive.value = "1/t": its value at t = 0 is inf; give a formula that begins '
        "smoothly with finite numbers, such as t**2, or sqrt(t + 0.001)",
    ),
    "infinite rate at the start": (
        value("sqrt(t)"),
        'model.drivers.drive.value = "sqrt(t)": its rate at t = 0 is inf; give a formula that begins '
        "smoothly with finite numbers, such as t**2, or sqrt(t + 0.001)",
    ),
    "infinite second derivative at the start": (
        value("t*sqrt(t)"),
        'model.drivers.drive.value = "t*sqrt(t)": its rate at t = 0 is nan; give a formula that begins '
        "smoothly with finite numbers, such as t**2, or sqrt(t + 0.001)",
    ),
    "rate infinite at the start": (
        rig(driver(PIVOTED, 'rate = "log(t)"')),
        'model.drivers.drive.rate = "log(t)": its value at t = 0 is -inf; give a formula that begins '
        "smoothly with finite numbers, such as t**2, or sqrt(t + 0.001)",
    ),
    "in a list": (
        rig(driver('body = "arm"', 'motion = "point"', 'value = [0, "2*x", 0]')),
        'model.drivers.drive.value[1] = "2*x": has the unknown name "x"; known here are "deg", "pi", "rpm", "t"',
    ),
    "in a force": (
        rig(force('type = "force"', 'body = "arm"', 'value = [0, "1/t", 0]')),
        'model.forces.push.value[1] = "1/t": its value at t = 0 is inf; give a formula that begins '
        "smoothly with finite numbers, such as t**2, or sqrt(t + 0.001)",
    ),
    "target that jumps": (
        rig(force('type = "actuator"', PIVOTED, "stiffness = 1", "damping = 1", 'target = "sqrt(t)"')),
        'model.forces.push.target = "sqrt(t)": its rate at t = 0 is inf; give a formula that begins '
        "smoothly with finite numbers, such as t**2, or sqrt(t + 0.001)",
    ),
    "rest that jumps": (
        rig(force('type = "torsion_spring"', PIVOTED, "stiffness = 1", 'free_angle = "sqrt(t)"')),
        'model.forces.push.free_angle = "sqrt(t)": its rate at t = 0 is inf; give a formula that begins '
        "smoothly with finite numbers, such as t**2, or sqrt(t + 0.001)",
    ),
    "undefined later": (
        rig(force('type = "force"', 'body = "arm"', 'value = [0, "sqrt(0.0022 - t)", 0]')),
        'model.forces.push.value[1] = "sqrt(0.0022 - t)": its value is nan at t = 0.0025; give a formula that is '
        "finite until integrator.end_time = 0.01",
    ),
    "a jump": (
        value("where(t < 0.0047, 0, 1)"),
        'model.drivers.drive.value = "where(t < 0.0047, 0, 1)": jumps by 1 at t = 0.005, and nothing can move at once; '
        "write a smooth transition, such as 0.5*(1 + tanh((t - 0.005)/0.02))",
    ),
    "an if": (
        value("1 if t > 1 else 0"),
        'model.drivers.drive.value = "1 if t > 1 else 0": has an if; write where(t < 1, number, other number)',
    ),
    "a unit behind a space": (
        value("1 rad"),
        'model.drivers.drive.value = "1 rad": has a unit; numbers are in SI units, without it',
    ),
    "too long": (
        value("t" + 1000 * "+t"),
        "model.drivers.drive.value = "
        '"t+t+t+t+t+t+t+t+t+t+t+t+t+t+t+t+t+t+t+t+t+t+t+t+t+t+t+t+t+t+t+t+t+t+t+t+t+t ...: is 2001 '
        "characters long, at most 2000 are allowed; shorten it",
    ),
}
CASES = DRIVERS | {f"formula: {name}": case for name, case in FORMULAS.items()}


@pytest.mark.parametrize("case", CASES.values(), ids=CASES)
def test_wrong_argument(tmp_path: Path, case: tuple[str, ...]) -> None:
    text, *messages = case
    assert refused_by_both(tmp_path, text) == messages
