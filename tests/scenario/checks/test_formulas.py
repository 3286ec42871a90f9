"""Wrong formulas of quantities, parameters and tables: one clear message each, the same from both commands.

Each case: the text, then its message or messages: key, value, rule; remedy.
"""

from pathlib import Path

import pytest

from tests.scenario.checks.refusal import check_refused, driver, force, refused_by_both, rig

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
    "a coordinate that the joint has not": (
        rig(SWING, torque("swing.displacement")),
        "model.forces.push.value[1]: has the unknown name",
    ),
    "a quantity as a function": (
        rig(POINTING, torque("pointing(t)")),
        "model.forces.push.value[1]: calls the unknown function",
    ),
    "unknown parameter": (
        rig(PARAMETERS, POINTING, torque("-kq*pointing.y*kp")),
        "model.forces.push.value[1]: has the unknown name",
    ),
    **{
        f"the {key} of a driver reads a velocity": (
            rig(SWING, slide("swing.rate", key)),
            f'model.drivers.drive.{key} = "swing.rate": reads swing.rate, {DRIVEN}',
        )
        for key in ("value", "rate")
    },
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
}

# More of these rules: the place, and words of the rule.
MORE = {
    "model.forces.push.value[1]: has the unknown name": rig(POINTING, torque("-2*pointin.y")),
    "model.forces.push.value[1]: , which has several numbers": rig(POINTING, torque("-2*pointing")),
    "model.forces.push.value[1]: calls the unknown function": rig(POINTING, torque("sine(pointing.y)")),
    "quantities: a and b depend on one another in a circle": rig(
        expression("a", "b + 1"), expression("b", "2*a"), torque("a")
    ),
    "quantities: a, b and c depend on one another in a circle": rig(
        *(expression(x, y) for x, y in ("ab", "bc", "ca", "da"))
    ),
    "quantities: a depends on itself in a circle": rig(expression("a", "a + 1")),
    "model.forces.push.value[1]: reads load.force.x, which follows from the": rig(LOAD, torque("load.force.x")),
    "model.forces.push.value[1]: reads bump.z, which follows from the forces": rig(BUMP, torque("bump.z")),
    "model.forces.push.value[1]: reads pull, which follows from the forces": rig(
        slide("t"), seen("pull", "driver_effort", 'driver = "drive"'), torque("pull")
    ),
    "model.forces.push.value[1]: reads more, which follows from the forces": rig(
        LOAD, expression("half", "load.torque.y/2"), expression("more", "half + t"), torque("more")
    ),
    "model.drivers.drive.value: reads bump.z, which follows from the forces": rig(BUMP, slide("bump.z")),
    "model.drivers.drive.value: reads fast, a velocity, but what a driver": rig(
        SWING, expression("fast", "2*swing.rate"), slide("fast")
    ),
    "model.drivers.drive.value[0]: reads spin.x, a velocity, but what a driver": rig(
        SPIN, driver('body = "block"', 'motion = "point"', 'value = ["spin.x", 0, 0]')
    ),
    "model.forces.push.target: reads spin.y, a velocity, but the damping needs": rig(
        SPIN, force('type = "actuator"', POINTED, "damping = 1", 'target = "spin.y"')
    ),
    "model.bodies.arm.mass: reads pointing.y, but is one number for the": rig(POINTING).replace(
        "mass = 2", 'mass = "1 + pointing.y"'
    ),
    "model.bodies.arm.mass: has the unknown name": rig(PARAMETERS, POINTING, table()).replace(
        "mass = 2", 'mass = "kq"'
    ),
    "model.bodies.arm.mass: calls the unknown function": rig(table()).replace("mass = 2", 'mass = "pus(2)"'),
    "parameters.b: has the unknown name": rig("[parameters]\nkp = 40\nb = '2*kq'\n", POINTING),
    "model.gravity[2]: has the unknown name": rig(
        PARAMETERS, POINTING, table(), model='[model]\ngravity = [0, 0, "kq"]\n'
    ),
    "model.bodies.arm.mass: reads push, but is one number for the whole run": rig(table()).replace(
        "mass = 2", 'mass = "push(t)"'
    ),
    "model.forces.push.value[1]: uses the table": rig(table(), torque("2*push")),
    "model.forces.push.value[1]: gives the table push": rig(table(), torque("push(t, 1)")),
}
TRICKS = [
    "__import__('os').getcwd()", "t.__class__", "sin.__globals__", "push.data", "(pointing.y).__class__.__bases__",
    "pointing[1]", "(lambda: 1)()", "pointing.y(t)", "f'{t}'", "[t][0]", "pointing.__init__(t)", "eval('1')",
    "push.__call__(t)", "push(t).a", "(x := 1)", "push(*[t])", "push(t=1)", "sin(**pointing)", "pi.real",
]  # fmt: skip


FORMULAS |= {wanted: (text, wanted) for wanted, text in MORE.items()}


@pytest.mark.parametrize("case", FORMULAS)
def test_wrong_formula(tmp_path: Path, case: str) -> None:
    check_refused(tmp_path, *FORMULAS[case])


@pytest.mark.parametrize("trick", TRICKS)
def test_nothing_of_python_is_reached(tmp_path: Path, trick: str) -> None:
    (message,) = refused_by_both(tmp_path, rig(POINTING, table(), torque(trick)))
    assert message.startswith(f'{AT}"{trick}": ')


@pytest.mark.parametrize("trick", TRICKS[:1])
def test_a_call_of_an_attribute_is_no_missing_star(tmp_path: Path, trick: str) -> None:
    (message,) = refused_by_both(tmp_path, rig(torque(trick)))
    assert "star" not in message
