"""Wrong drivers and formulas: one clear message each, the same from both commands.

Each case: the text, then its message or messages: key, value, rule; remedy.
"""

from pathlib import Path

import pytest

from tests.scenario.checks.refusal import FREE, check_refused, driver, force, joint, rig

PIVOTED = 'joint = "pivot"'
BALL = joint('type = "spherical"', "at = [0, 0, -0.3]", name="ball")
TUBE = joint('type = "cylindrical"', "at = [0, 0, -0.3]", "axis = [0, 1, 0]", name="tube")


def value(formula: str) -> str:
    return rig(driver(PIVOTED, f'value = "{formula}"'))


DRIVERS = {
    "of a coordinate that is not there": (
        rig(driver('joint = "pivot"', 'coordinate = "displacement"', "value = 0")),
        'model.drivers.drive.coordinate = "displacement": pivot is a revolute joint, which has no '
        'displacement; give "angle"',
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
    "empty, unnamed": (
        rig(driver(name="")),
        "model.drivers.driver_1: drives nothing; give joint = ..., or body = ... with motion = one of "
        "point, orientation, angular_velocity",
    ),
    "of a number": (
        rig(driver("joint = 3", "value = 0")),
        "model.drivers.drive.joint = 3: must be a text in quotes; give the name of the joint",
    ),
    "of a body, without motion": (
        rig(driver('body = "arm"', "value = [0, 0, 0]")),
        "model.drivers.drive.motion is missing; give one of point, orientation, angular_velocity",
    ),
    "of an unknown motion": (
        rig(driver('body = "arm"', 'motion = "pont"', "value = [0, 0, 0]")),
        'model.drivers.drive.motion = "pont": is not known; the nearest known name is "point"',
    ),
    "two of one coordinate": (
        rig(driver(PIVOTED, "value = 0", name='name = "a"'), driver(PIVOTED, "value = 0", name='name = "b"')),
        "model.drivers.b: drives the angle of pivot, which a drives already; remove one of the two",
    ),
}
FORMULAS = {
    "unknown function, upper case": (
        value("Sin(t)"),
        'model.drivers.drive.value = "Sin(t)": calls the unknown function "Sin"; the nearest known name is "sin"',
    ),
    "wrong number of arguments": (
        value("atan2(t)"),
        'model.drivers.drive.value = "atan2(t)": gives atan2 1 argument, it takes 2; correct it',
    ),
    "an index": (
        value("t[0]"),
        'model.drivers.drive.value = "t[0]": contains "t[0]", which is not allowed; use numbers, + - * / **, '
        "comparisons, t, pi, deg, rpm and the functions sin, cos, tan, asin, acos, atan, atan2, exp, log, sqrt, tanh, "
        "abs, sign, min, max, clip, floor, ceil, mod, sinc, sinh, cosh, hypot, where",
    ),
    "a condition": (
        value("t > 1"),
        'model.drivers.drive.value = "t > 1": is a condition, not a number; write where(condition, '
        "number, other number)",
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
    "infinite second derivative at the start": (value("t*sqrt(t)"), "model.drivers.drive.value: its rate at t"),
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
        'model.drivers.drive.value = "t+t+t+t+t+t+t+t+t+t+t+t+t+t+t+t+t+t+t+t+t+t+t+t+t+t+t+t+t+t+t+t+t+t+t+t+t+t '
        "...: is 2001 characters long, at most 2000 are allowed; shorten it",
    ),
}

# More of these rules: the place, and words of the rule.
MORE = {
    "model.drivers.drive: has both value and rate": rig(driver('joint = "pivot"', "value = 0", "rate = 0")),
    "model.drivers.drive.joint: is a spherical joint, which has no coordinate": rig(
        BALL, driver('joint = "ball"', "value = 1")
    ),
    "model.drivers.drive.body: the ground does not move": rig(
        driver('body = "ground"', 'motion = "orientation"', "value = [0, 0, 0]")
    ),
    "model.drivers.driver_2: drives the angle of pivot, which driver_": rig(
        driver(PIVOTED, "value = 0", name=""), driver(PIVOTED, 'coordinate = "angle"', "rate = 0", name="")
    ),
    "model.drivers.driver_2: drives the rotation of free, which driver_": rig(
        FREE,
        driver('body = "free"', 'motion = "orientation"', "value = [0, 0, 0]", name=""),
        driver('body = "free"', 'motion = "angular_velocity"', "value = [0, 0, 0]", name=""),
    ),
    "model.drivers.driver_2: drives the point [0.0, 0.0, 0.0] of free": rig(
        FREE, *2 * [driver('body = "free"', 'motion = "point"', "value = [0, 0, 0]", name="")]
    ),
    "model.drivers.drive.value: has the unknown name": value("0.1*sin(om*t)"),
    "model.drivers.drive.value: calls the unknown function": value("__import__('os')"),
    "model.drivers.drive.value: has an equals sign": value("x = 2*t"),
    "model.drivers.drive.value: its value at t": value("1/t"),
    "model.drivers.drive.value: its rate at t": value("sqrt(t)"),
    "model.drivers.drive.rate: its value at t": rig(driver(PIVOTED, 'rate = "log(t)"')),
    "model.drivers.drive.value[1]: has the unknown name": rig(
        driver('body = "arm"', 'motion = "point"', 'value = [0, "2*x", 0]')
    ),
    "model.forces.push.value[1]: its value at t": rig(force('type = "force"', 'body = "arm"', 'value = [0, "1/t", 0]')),
    "model.forces.push.target: its rate at t": rig(
        force('type = "actuator"', PIVOTED, "stiffness = 1", "damping = 1", 'target = "sqrt(t)"')
    ),
    "model.forces.push.free_angle: its rate at t": rig(
        force('type = "torsion_spring"', PIVOTED, "stiffness = 1", 'free_angle = "sqrt(t)"')
    ),
    "model.forces.push.value[1]: its value is nan at t": rig(
        force('type = "force"', 'body = "arm"', 'value = [0, "sqrt(0.0022 - t)", 0]')
    ),
}
CASES = DRIVERS | {f"formula: {name}": case for name, case in FORMULAS.items()}
CASES |= {wanted: (text, wanted) for wanted, text in MORE.items()}


@pytest.mark.parametrize("case", CASES.values(), ids=CASES)
def test_wrong_argument(tmp_path: Path, case: tuple[str, ...]) -> None:
    check_refused(tmp_path, *case)
