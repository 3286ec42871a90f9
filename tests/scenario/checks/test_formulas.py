"""Wrong formulas of quantities, parameters and tables: one clear message each, the same from both commands.

Each case: the text, then its message or messages: key, value, rule; remedy.
"""

from pathlib import Path

import pytest

from tests.scenario.checks.refusal import driver, force, refused_by_both, rig

POINTED = 'joint = "pivot"'
SORTED = (
    '"abs", "acos", "asin", "atan", "atan2", "ceil", "clip", "cos", "cosh", "exp", "floor", "hypot", "log", "max", '
    '"min", "mod", "sign", "sin", "sinc", "sinh", "sqrt", "tan", "tanh", "where"'
)


def seen(name: str, kind: str, *lines: str) -> str:
    return "\n".join(["[[quantities]]", f'name = "{name}"', f'type = "{kind}"', *lines]) + "\n"


def point(*lines: str, name: str = "tip") -> str:
    return seen(name, "point", *(lines or ['body = "arm"']))


def expression(name: str, text: str) -> str:
    return seen(name, "expression", f'value = "{text}"')


def torque(text: str) -> str:
    return force('type = "torque"', 'body = "arm"', f'value = [0, "{text}", 0]')


def slide(text: str, key: str = "value") -> str:
    return driver('joint = "rail"', f'{key} = "{text}"')


def table(*lines: str) -> str:
    return "\n".join(["[tables.push]", *(lines or ["times = [0, 1]", "values = [1, 2]"])]) + "\n"


POINTING = seen("pointing", "rotation_error", 'body = "arm"')
SPIN = seen("spin", "angular_velocity", 'body = "arm"')
SWING = seen("swing", "joint", POINTED)
LOAD = seen("load", "reaction", POINTED)
BUMP = point('body = "arm"', "derivative = 2", name="bump")
PARAMETERS = "[parameters]\nkp = 40\n"
AT = "model.forces.push.value[1] = "
FOLLOWS = (
    "which follows from the forces themselves (an acceleration, a reaction or an effort), so no force or driver may "
    "depend on it; read positions and velocities"
)
DRIVEN = "a velocity, but what a driver prescribes is differentiated; read positions only"
STORED = "a velocity, but {} belongs to a potential energy, which is differentiated; read positions only"
ONE_NUMBER = "is one number for the whole run; use parameters only, or put it into a force"

FORMULAS = {
    "unknown quantity": (
        rig(POINTING, torque("-2*pointin.y")),
        f'{AT}"-2*pointin.y": has the unknown name "pointin.y"; the nearest known name is "pointing.y"',
    ),
    "unknown component": (
        rig(POINTING, torque("pointing.w")),
        f'{AT}"pointing.w": has the unknown name "pointing.w"; the nearest known name is "pointing.z"',
    ),
    "a coordinate that the joint has not": (
        rig(SWING, torque("swing.displacement")),
        f'{AT}"swing.displacement": has the unknown name "swing.displacement"; '
        'known here are "deg", "pi", "rpm", "swing.angle", "swing.rate", "t"',
    ),
    "no component": (
        rig(POINTING, torque("-2*pointing")),
        f'{AT}"-2*pointing": uses "pointing", which has several numbers; write pointing.angle or pointing.x or '
        "pointing.y or pointing.z",
    ),
    "unknown function": (
        rig(POINTING, torque("sine(pointing.y)")),
        f'{AT}"sine(pointing.y)": calls the unknown function "sine"; the nearest known name is "sin"',
    ),
    "a quantity as a function": (
        rig(POINTING, torque("pointing(t)")),
        f'{AT}"pointing(t)": calls the unknown function "pointing"; known here are {SORTED}',
    ),
    "unknown parameter": (
        rig(PARAMETERS, POINTING, torque("-kq*pointing.y*kp")),
        f'{AT}"-kq*pointing.y*kp": has the unknown name "kq"; known here are "deg", "kp", "pi", '
        '"pointing.angle", "pointing.x", "pointing.y", "pointing.z", "rpm", "t"',
    ),
    "two in a circle": (
        rig(expression("a", "b + 1"), expression("b", "2*a"), torque("a")),
        "quantities: a and b depend on one another in a circle; give a number for a",
    ),
    "three in a circle": (
        rig(*(expression(x, y) for x, y in ("ab", "bc", "ca", "da"))),
        "quantities: a, b and c depend on one another in a circle; give a number for a",
    ),
    "itself": (
        rig(expression("a", "a + 1")),
        "quantities: a depends on itself in a circle; give a number for a",
    ),
    "an attribute of Python": (
        rig(POINTING, torque("pointing.__class__")),
        f'{AT}"pointing.__class__": has the unknown name "pointing.__class__"; the nearest known name is "pointing.z"',
    ),
    "an attribute of a component": (
        rig(POINTING, torque("pointing.y.real")),
        f'{AT}"pointing.y.real": has the unknown name "pointing.y.real"; the nearest known name is "pointing.y"',
    ),
    "a force reads a reaction": (
        rig(LOAD, torque("load.force.x")),
        f'{AT}"load.force.x": reads load.force.x, {FOLLOWS}',
    ),
    "a force reads an acceleration": (rig(BUMP, torque("bump.z")), f'{AT}"bump.z": reads bump.z, {FOLLOWS}'),
    "a force reads an effort": (
        rig(slide("t"), seen("pull", "driver_effort", 'driver = "drive"'), torque("pull")),
        f'{AT}"pull": reads pull, {FOLLOWS}',
    ),
    "a force reads a reaction in an expression": (
        rig(LOAD, expression("half", "load.torque.y/2"), expression("more", "half + t"), torque("more")),
        f'{AT}"more": reads more, {FOLLOWS}',
    ),
    "a driver reads an acceleration": (
        rig(BUMP, slide("bump.z")),
        f'model.drivers.drive.value = "bump.z": reads bump.z, {FOLLOWS}',
    ),
    **{
        f"the {key} of a driver reads a velocity": (
            rig(SWING, slide("swing.rate", key)),
            f'model.drivers.drive.{key} = "swing.rate": reads swing.rate, {DRIVEN}',
        )
        for key in ("value", "rate")
    },
    "a driver reads a velocity in an expression": (
        rig(SWING, expression("fast", "2*swing.rate"), slide("fast")),
        f'model.drivers.drive.value = "fast": reads fast, {DRIVEN}',
    ),
    "the driver of a point reads a velocity": (
        rig(SPIN, driver('body = "block"', 'motion = "point"', 'value = ["spin.x", 0, 0]')),
        f'model.drivers.drive.value[0] = "spin.x": reads spin.x, {DRIVEN}',
    ),
    **{
        f"{key} of a {kind} reads a velocity": (
            rig(SPIN, force(f'type = "{kind}"', *lines, f'{key} = "spin.y"')),
            f'model.forces.push.{key} = "spin.y": reads spin.y, {STORED.format(key)}',
        )
        for kind, key, *lines in (
            ("torsion_spring", "stiffness", POINTED),
            ("torsion_spring", "free_angle", POINTED, "stiffness = 1"),
            ("end_stop", "lower", POINTED, "stiffness = 1"),
            ("spring_damper", "stiffness", 'bodies = ["ground", "arm"]', "points = [[0, 0, 1], [0, 0, 0]]"),
        )
    },
    "a target with damping reads a velocity": (
        rig(SPIN, force('type = "actuator"', POINTED, "damping = 1", 'target = "spin.y"')),
        'model.forces.push.target = "spin.y": reads spin.y, a velocity, but the damping needs the rate of the target; '
        "read positions only",
    ),
    "a mass reads a quantity": (
        rig(POINTING).replace("mass = 2", 'mass = "1 + pointing.y"'),
        f'model.bodies.arm.mass = "1 + pointing.y": reads pointing.y, but {ONE_NUMBER}',
    ),
    "a mass with an unknown name": (
        rig(PARAMETERS, POINTING, table()).replace("mass = 2", 'mass = "kq"'),
        'model.bodies.arm.mass = "kq": has the unknown name "kq"; known here are "deg", "kp", "pi", "rpm"',
    ),
    "a mass with a quantity of several numbers": (
        rig(PARAMETERS, POINTING).replace("mass = 2", 'mass = "pointing"'),
        'model.bodies.arm.mass = "pointing": has the unknown name "pointing"; known here are "deg", "kp", "pi", "rpm"',
    ),
    "a mass with an unknown function": (
        rig(table()).replace("mass = 2", 'mass = "pus(2)"'),
        f'model.bodies.arm.mass = "pus(2)": calls the unknown function "pus"; known here are {SORTED}',
    ),
    "a parameter with an unknown name": (
        rig("[parameters]\nkp = 40\nb = '2*kq'\n", POINTING),
        'parameters.b = "2*kq": has the unknown name "kq"; known here are "deg", "kp", "pi", "rpm"',
    ),
    "gravity with an unknown name": (
        rig(PARAMETERS, POINTING, table(), model='[model]\ngravity = [0, 0, "kq"]\n'),
        'model.gravity[2] = "kq": has the unknown name "kq"; known here are "deg", "kp", "pi", "rpm", "t"',
    ),
    "a mass reads a table": (
        rig(table()).replace("mass = 2", 'mass = "push(t)"'),
        f'model.bodies.arm.mass = "push(t)": reads push, but {ONE_NUMBER}',
    ),
    "a table without arguments": (
        rig(table(), torque("2*push")),
        f'{AT}"2*push": uses the table "push" without arguments; write push(...)',
    ),
    "a table of two arguments": (
        rig(table(), torque("push(t, 1)")),
        f'{AT}"push(t, 1)": gives the table push 2 arguments, it takes 1; write push(t)',
    ),
    "unknown table": (
        rig(table(), torque("psh(t)")),
        f'{AT}"psh(t)": calls the unknown function "psh"; the nearest known name is "push"',
    ),
}
TRICKS = [
    "__import__('os').getcwd()", "t.__class__", "sin.__globals__", "push.data", "(pointing.y).__class__.__bases__",
    "pointing[1]", "(lambda: 1)()", "pointing.y(t)", "f'{t}'", "[t][0]", "pointing.__init__(t)", "eval('1')",
    "push.__call__(t)", "push(t).a", "(x := 1)", "push(*[t])", "push(t=1)", "sin(**pointing)", "pi.real",
]  # fmt: skip


@pytest.mark.parametrize("case", FORMULAS)
def test_wrong_formula(tmp_path: Path, case: str) -> None:
    text, *messages = FORMULAS[case]
    assert refused_by_both(tmp_path, text) == messages


@pytest.mark.parametrize("trick", TRICKS)
def test_nothing_of_python_is_reached(tmp_path: Path, trick: str) -> None:
    (message,) = refused_by_both(tmp_path, rig(POINTING, table(), torque(trick)))
    assert message.startswith(f'{AT}"{trick}": ')


@pytest.mark.parametrize("trick", TRICKS[:1])
def test_a_call_of_an_attribute_is_no_missing_star(tmp_path: Path, trick: str) -> None:
    (message,) = refused_by_both(tmp_path, rig(torque(trick)))
    assert "star" not in message
