"""Wrong forces, and sweeps of drivers and forces: one clear message each, the same from both commands.

Each case: the text, then its message or messages: key, value, rule; remedy.
"""

from pathlib import Path

import pytest

import lienumba
from lienumba.errors import ScenarioError
from lienumba.scenario.resolve import resolve
from tests.scenario.checks.refusal import VARY, accepted, driver, force, joint, refused_by_both, rig

PIVOTED = 'joint = "pivot"'
BALL = joint('type = "spherical"', "at = [0, 0, -0.3]", name="ball")
TUBE = joint('type = "cylindrical"', "at = [0, 0, -0.3]", "axis = [0, 1, 0]", name="tube")
ENDS = 'bodies = ["ground", "arm"]\npoints = [[0, 0, 1], [0, 0, 0]]'
SPRING = force('type = "torsion_spring"', PIVOTED, 'stiffness = "3*2"', 'free_angle = "0.1*t"')

FORCES = {
    "no type": (
        rig(force(ENDS)),
        "model.forces.push.type is missing; give one of spring_damper, force, torque, torsion_spring, "
        "actuator, friction, end_stop, bushing, drag, point_mass_gravity, python",
    ),
    "spring": (
        rig(force('type = "spring"', ENDS)),
        'model.forces.push.type = "spring": is not known; the nearest known name is "spring_damper"',
    ),
    "a joint's type": (
        rig(force('type = "revolute"', ENDS)),
        'model.forces.push.type = "revolute": is not known; known here are "spring_damper", "force", '
        '"torque", "torsion_spring", "actuator", "friction", "end_stop", "bushing", "drag", '
        '"point_mass_gravity", "python"',
    ),
    "nothing, unnamed": (
        rig(force(name="")),
        "model.forces.force_1.type is missing; give one of spring_damper, force, torque, torsion_spring, "
        "actuator, friction, end_stop, bushing, drag, point_mass_gravity, python",
    ),
    "unnamed, of an unknown body": (
        rig(force('type = "drag"', 'body = "amr"', name="")),
        'model.forces.drag_1.body = "amr": is not a body of the model; the nearest known name is "arm"',
    ),
    "spring_damper without ends": (
        rig(force('type = "spring_damper"')),
        'model.forces.push.bodies is missing; give the names of the two bodies; the fixed world is "ground"',
        "model.forces.push.points is missing; give two points in m, each with 3 numbers in the frame of its own body",
    ),
    "spring_damper of one body": (
        rig(force('type = "spring_damper"', ENDS.replace("ground", "arm"))),
        'model.forces.push.bodies = ["arm", "arm"]: joins "arm" to itself; name two different bodies',
    ),
    "spring_damper of an unknown body": (
        rig(force('type = "spring_damper"', ENDS.replace("arm", "amr"))),
        'model.forces.push.bodies[1] = "amr": is not a body of the model; the nearest known name is "arm"',
    ),
    "spring_damper with length": (
        rig(force('type = "spring_damper"', ENDS, "length = 1")),
        'model.forces.push.length is not a known key; the nearest known name is "free_length"',
    ),
    "spring_damper with k": (
        rig(force('type = "spring_damper"', ENDS, "k = 1")),
        'model.forces.push.k is not a known key; the nearest known name is "stiffness"',
    ),
    "spring_damper with at": (
        rig(force('type = "spring_damper"', ENDS, "at = [0, 0, 0]")),
        'model.forces.push.at is not a known key here; "at" belongs in [[model.joints]]',
    ),
    "spring_damper with three stiffnesses": (
        rig(force('type = "spring_damper"', ENDS, "stiffness = [1, 2, 3]")),
        "model.forces.push.stiffness = [1, 2, 3]: must be a number; give the stiffness in N/m (or a "
        'formula of t in quotes, such as "0.3*sin(2*t)")',
    ),
    "spring_damper with negative length": (
        rig(force('type = "spring_damper"', ENDS, "free_length = -1")),
        "model.forces.push.free_length = -1.0: must be at least 0; give its size without a sign",
    ),
    "force on the ground": (
        rig(force('type = "force"', 'body = "ground"', "value = [0, 0, 1]")),
        'model.forces.push.body = "ground": the ground does not move; name a body',
    ),
    "force without value": (
        rig(force('type = "force"', 'body = "arm"')),
        "model.forces.push.value is missing; give the force in N: 3 numbers (or a formula of t in "
        'quotes, such as "0.3*sin(2*t)")',
    ),
    "force as a number": (
        rig(force('type = "force"', 'body = "arm"', "value = 3")),
        "model.forces.push.value = 3: must be a list; give the force in N: 3 numbers (or a formula of t "
        'in quotes, such as "0.3*sin(2*t)")',
    ),
    "force that is NaN": (
        rig(force('type = "force"', 'body = "arm"', "value = [1, nan, 2]")),
        "model.forces.push.value[1] = nan: must be a finite number; replace it",
    ),
    "force in an unknown frame": (
        rig(force('type = "force"', 'body = "arm"', "value = [1, 0, 0]", 'frame = "inertial"')),
        'model.forces.push.frame = "inertial": must be "global" or "body"; the nearest is "global"',
    ),
    "force at a moving point": (
        rig(force('type = "force"', 'body = "arm"', "value = [1, 0, 0]", 'point = ["0.1*t", 0, 0]')),
        'model.forces.push.point[0] = "0.1*t": must be a number, not a formula, because it cannot vary '
        "in time; give the point in m, 3 numbers in the body's frame",
    ),
    "force with points": (
        rig(force('type = "force"', 'body = "arm"', "value = [1, 0, 0]", "points = [0, 0, 0]")),
        'model.forces.push.points is not a known key; the nearest known name is "point"',
    ),
    "torque with stiffness": (
        rig(force('type = "torque"', 'body = "arm"', "value = [1, 0, 0]", "stiffness = 3")),
        "model.forces.push.stiffness has no meaning for a force of type torque; leave it out (it belongs "
        "to spring_damper, torsion_spring, actuator, end_stop, bushing)",
    ),
    "torque at a point": (
        rig(force('type = "torque"', 'body = "arm"', "value = [1, 0, 0]", "point = [0, 0, 0]")),
        "model.forces.push.point has no meaning for a force of type torque; leave it out (it belongs to force, drag)",
    ),
    "torque of a joint": (
        rig(force('type = "torque"', PIVOTED, "value = [1, 0, 0]")),
        "model.forces.push.body is missing; give the name of the body",
        "model.forces.push.joint has no meaning for a force of type torque; leave it out (it belongs to "
        "torsion_spring, actuator, friction, end_stop)",
    ),
    "torsion_spring of a prismatic joint": (
        rig(force('type = "torsion_spring"', 'joint = "rail"', "stiffness = 1")),
        'model.forces.push.joint = "rail": is a prismatic joint, which has no angle for a torsion_spring '
        "to act on; use an actuator (stiffness, damping, target), or a spring_damper",
    ),
    "torsion_spring of a displacement": (
        rig(TUBE, force('type = "torsion_spring"', 'joint = "tube"', 'coordinate = "displacement"')),
        'model.forces.push.coordinate = "displacement": a torsion_spring acts on an angle; give "angle"',
    ),
    "torsion_spring of a spherical joint": (
        rig(BALL, force('type = "torsion_spring"', 'joint = "ball"', "stiffness = 1")),
        'model.forces.push.joint = "ball": is a spherical joint, which has no coordinate; joints with an '
        "angle or a displacement are revolute, cylindrical, prismatic, point_on_line, screw",
    ),
    "torsion_spring of bodies": (
        rig(force('type = "torsion_spring"', 'bodies = ["ground", "arm"]', "stiffness = 1")),
        "model.forces.push.joint is missing; give the name of the joint",
        "model.forces.push.bodies has no meaning for a force of type torsion_spring; leave it out (it "
        "belongs to spring_damper, bushing, point_mass_gravity, python)",
    ),
    "actuator that does nothing": (
        rig(force('type = "actuator"', PIVOTED)),
        "model.forces.push: has neither value nor stiffness nor damping, so it does nothing; give value, "
        "or stiffness, damping and target",
    ),
    "actuator with a target alone": (
        rig(force('type = "actuator"', PIVOTED, 'target = "t"')),
        'model.forces.push.target = "t": has no effect without stiffness or damping; give them',
    ),
    "actuator with value and target": (
        rig(force('type = "actuator"', PIVOTED, "value = 1", "target = 0.5")),
        "model.forces.push.target = 0.5: has no effect without stiffness or damping; give them",
    ),
    "actuator with three values": (
        rig(force('type = "actuator"', PIVOTED, "value = [1, 0, 0]")),
        "model.forces.push.value = [1, 0, 0]: must be a number; give the force in N or torque in N m (or "
        'a formula of t in quotes, such as "0.3*sin(2*t)")',
    ),
    "actuator with torque": (
        rig(force('type = "actuator"', PIVOTED, "torque = 3")),
        'model.forces.push.torque is not a known key; the nearest known name is "value"',
    ),
    "actuator with a negative limit": (
        rig(force('type = "actuator"', PIVOTED, "value = 3", "limit = -1")),
        "model.forces.push.limit = -1.0: must be at least 0; give its size without a sign",
    ),
    "friction of an unknown joint": (
        rig(force('type = "friction"', 'joint = "pivto"', "viscous = 1")),
        'model.forces.push.joint = "pivto": is not a joint of the model; the nearest known name is "pivot"',
    ),
    "friction at velocity 0": (
        rig(force('type = "friction"', PIVOTED, "coulomb = 3", "velocity = 0")),
        "model.forces.push.velocity = 0.0: must be above 0; give the speed at which sliding sets in",
    ),
    "friction at a negative velocity": (
        rig(force('type = "friction"', PIVOTED, "coulomb = 3", 'velocity = "-pi/60"')),
        'model.forces.push.velocity = "-pi/60": must be above 0; give the speed at which sliding sets in',
    ),
    "friction with mu": (
        rig(force('type = "friction"', PIVOTED, "mu = 0.3")),
        "model.forces.push.mu has no meaning for a force of type friction; leave it out (it belongs to "
        "point_mass_gravity)",
    ),
    "end_stop without stops": (
        rig(force('type = "end_stop"', PIVOTED, "stiffness = 3")),
        "model.forces.push: has no stop; give lower, upper or both",
    ),
    "end_stop the other way round": (
        rig(force('type = "end_stop"', PIVOTED, "stiffness = 3", "lower = 1", "upper = -1")),
        "model.forces.push.lower = 1.0: must be below upper = -1.0; exchange the two",
    ),
    "end_stop at one place": (
        rig(force('type = "end_stop"', PIVOTED, "stiffness = 3", "lower = 1", "upper = 1")),
        "model.forces.push.lower = 1.0: must be below upper = 1.0; move them apart",
    ),
    "end_stop without stiffness": (
        rig(force('type = "end_stop"', PIVOTED, "lower = 1")),
        "model.forces.push.stiffness is missing; give the stiffness in N/m or N m/rad (or a formula of t "
        'in quotes, such as "0.3*sin(2*t)")',
    ),
    "bushing with one stiffness": (
        rig(force('type = "bushing"', ENDS, "stiffness = 3")),
        "model.forces.push.stiffness = 3: must be a list; give the stiffness in N/m: 3 numbers (or a "
        'formula of t in quotes, such as "0.3*sin(2*t)")',
    ),
    "bushing with two": (
        rig(force('type = "bushing"', ENDS, "rotational_damping = [3, 3]")),
        "model.forces.push.rotational_damping = [3, 3]: has 2 entries and must have 3; give the "
        "rotational damping in N m s/rad: 3 numbers (or a formula of t in quotes, such as "
        '"0.3*sin(2*t)")',
    ),
    "drag of the ground": (
        rig(force('type = "drag"', 'body = "ground"', "linear = 1")),
        'model.forces.push.body = "ground": the ground does not move; name a body',
    ),
    "drag in a frame": (
        rig(force('type = "drag"', 'body = "arm"', "linear = 1", 'frame = "body"')),
        "model.forces.push.frame has no meaning for a force of type drag; leave it out (it belongs to force, torque)",
    ),
    "point_mass_gravity without mu": (
        rig(force('type = "point_mass_gravity"', 'bodies = ["ground", "arm"]')),
        "model.forces.push.mu is missing; give the gravitational parameter of the first body in m^3/s^2 "
        '(or a formula of t in quotes, such as "0.3*sin(2*t)")',
    ),
    "point_mass_gravity at one point": (
        rig(
            force(
                'type = "point_mass_gravity"',
                'bodies = ["ground", "arm"]',
                "mu = 1",
                "points = [[0, 0, 0], [0, 0, 0.3]]",
            )
        ),
        "model.forces.push: is infinite at the start, because its two points coincide; move one of them",
    ),
}
SWEEPS = {
    "a formula of t": (
        rig(SPRING, VARY.format("forces.push.free_angle", 1)),
        'sweep.vary."forces.push.free_angle": the path forces.push.free_angle is the formula "0.1*t", '
        "which varies in time; vary a number",
    ),
    "a driver's formula": (
        rig(driver(PIVOTED, 'value = "0.1*t"'), VARY.format("drivers.drive.value", 1)),
        'sweep.vary."drivers.drive.value": the path drivers.drive.value is the formula "0.1*t", which '
        "varies in time; vary a number",
    ),
    "gravity's formula": (
        rig(VARY.format("gravity[2]", 1), model='[model]\ngravity = [0, 0, "-9.81*cos(t)"]\n'),
        'sweep.vary."gravity[2]": the path gravity[2] is the formula "-9.81*cos(t)", which varies in '
        "time; vary a number",
    ),
    "a formula in a list": (
        rig(force('type = "force"', 'body = "arm"', 'value = [1, 2, "t"]'), VARY.format("forces.push.value[2]", 1)),
        'sweep.vary."forces.push.value[2]": the path forces.push.value[2] is the formula "t", which '
        "varies in time; vary a number",
    ),
    "a list": (
        rig(force('type = "force"', 'body = "arm"', 'value = ["1", "2", "t"]'), VARY.format("forces.push.value", 1)),
        'sweep.vary."forces.push.value": the path forces.push.value is not a number but the list ["1", '
        '"2", "t"]; vary one, such as forces.push.value[0]',
    ),
    "a condition of the time": (
        rig('[[events]]\nname = "late"\nwhen = "t > 0.5"\n', VARY.format("events.late.when", 1)),
        'sweep.vary."events.late.when": the path events.late.when is the condition "t > 0.5"; write a parameter '
        "into it, and vary that",
    ),
    "an omitted number": (
        rig(SPRING, VARY.format("forces.push.damping", 1)),
        'sweep.vary."forces.push.damping": the path forces.push.damping leads to a key that is omitted; '
        "give its nominal value first",
    ),
    "a text": (
        rig(SPRING, VARY.format("forces.push.joint", 1)),
        'sweep.vary."forces.push.joint": the path forces.push.joint is not a number but "pivot"; the '
        'nearest numeric path is "forces.push.stiffness"',
    ),
    "a slip in a key": (
        rig(SPRING, VARY.format("forces.push.stifness", 1)),
        'sweep.vary."forces.push.stifness": the path forces.push.stifness does not exist; the nearest '
        'numeric path is "forces.push.stiffness"',
    ),
    "a slip in a name": (
        rig(SPRING, VARY.format("forces.psh.stiffness", 1)),
        'sweep.vary."forces.psh.stiffness": the path forces.psh.stiffness does not exist; the nearest '
        'numeric path is "forces.push.stiffness"',
    ),
    "a driver that is not there": (
        rig(driver(PIVOTED, "rate = 3", name=""), VARY.format("drivers[1].rate", 1)),
        'sweep.vary."drivers[1].rate": the path drivers[1].rate does not exist; the nearest numeric path '
        'is "drivers.driver_1.rate"',
    ),
    "the key of an unnamed driver": (
        rig(driver(PIVOTED, 'rate = "t"', name=""), VARY.format("drivers.driver_1.rate", 1)),
        'sweep.vary."drivers.driver_1.rate": the path drivers.driver_1.rate is the formula "t", which '
        "varies in time; vary a number",
    ),
    "a formula that is none": (
        rig(SPRING.replace("3*2", "3*("), VARY.format("forces.push.stiffness", 1)),
        'model.forces.push.stiffness = "3*(": has 1 "(" and 0 ")"; give each its other half',
    ),
    "a speed below 0": (
        rig(
            force('type = "friction"', PIVOTED, "coulomb = 1", "velocity = 1"), VARY.format("forces.push.velocity", -1)
        ),
        'sweep.vary."forces.push.velocity".low = -1.0: allows values of 0 or below, which no friction '
        "sets in at; give low above 0",
    ),
    "a whole force": (
        rig(SPRING, VARY.format("forces.push", 1)),
        'sweep.vary."forces.push": the path forces.push is not a number but {name = "push", type = '
        '"torsion_spring", joint = "pivot", stiffness = "3*2", ...; the nearest numeric path is '
        '"forces.push.stiffness"',
    ),
}
CASES = FORCES | {f"sweep of {name}": case for name, case in SWEEPS.items()}


@pytest.mark.parametrize("case", CASES.values(), ids=CASES)
def test_wrong_argument(tmp_path: Path, case: tuple[str, ...]) -> None:
    text, *messages = case
    assert refused_by_both(tmp_path, text) == messages


@pytest.mark.parametrize("kind", ["cylindrical", "screw"])
def test_a_torsion_spring_takes_the_angle(kind: str) -> None:
    """Which it has to be told of by nobody, though the joint has a displacement, too."""
    joint = {
        "name": "tube",
        "type": kind,
        "bodies": ["ground", "b"],
        "points": [[0, 0, 0]] * 2,
        "axes": [[0, 0, 1]] * 2,
    }
    joint |= {"pitch": 0.1} if kind == "screw" else {}
    spring = {"name": "push", "type": "torsion_spring", "joint": "tube", "stiffness": 2.0, "free_angle": 0.5}
    model = {"bodies": [{"name": "b", "mass": 1, "inertia": [1, 1, 1]}], "joints": [joint], "forces": [spring]}
    data = {"model": model | {"gravity": [0, 0, 0]}, "integrator": {"step": 0.01, "end_time": 0.02}}
    ds = lienumba.run(data, workers=1)
    assert ds.angular_velocity.values[0, -1, 0, 2] > 0.01
    spring["coordinate"] = "angle"
    assert (lienumba.run(data, workers=1).rotation == ds.rotation).all()


# ------------------------------------------------------------------------------------------------ warnings
NEGATIVE = {
    "stiffness = -1.0": ('type = "spring_damper"', ENDS, "stiffness = -1"),
    'damping = "-pi"': ('type = "spring_damper"', ENDS, 'damping = "-pi"'),
    "coulomb = -3.0": ('type = "friction"', PIVOTED, "coulomb = -3"),
    "viscous = -3.0": ('type = "friction"', PIVOTED, "viscous = -3"),
    "quadratic = -1.0": ('type = "drag"', 'body = "arm"', "quadratic = -1"),
    "rotational_stiffness[1] = -1.0": ('type = "bushing"', ENDS, "rotational_stiffness = [0, -1, 0]"),
    "mu = -1.0": ('type = "point_mass_gravity"', ENDS, "mu = -1"),
}


@pytest.mark.parametrize("what", NEGATIVE)
def test_negative_numbers_are_warned_of(tmp_path: Path, what: str) -> None:
    assert accepted(tmp_path, rig(force(*NEGATIVE[what]))) == [
        f"model.forces.push.{what}: is negative, so it pushes away or feeds energy in; check its sign"
    ]


def test_constant_formulas_may_vary(tmp_path: Path) -> None:
    for table, path in (
        (SPRING, "forces.push.stiffness"),
        (driver(PIVOTED, 'rate = "pi/60"'), "drivers.drive.rate"),
        (driver(PIVOTED, 'rate = "pi/60"', name=""), "drivers.driver_1.rate"),
        (driver(PIVOTED, "rate = 3", name=""), "drivers[0].rate"),
        (force('type = "drag"', 'body = "arm"', "linear = 1", name=""), "forces.drag_1.linear"),
    ):
        assert accepted(tmp_path, rig(table, VARY.format(path, 1))) == []


@pytest.mark.parametrize("every", [2e-19, 3e-6])
def test_a_law_that_is_sampled_too_often(every: float) -> None:
    with pytest.raises(ScenarioError, match=r"motor\.every = .*: makes .* samples until 4 s, at most 1,000,000 are"):
        resolve("scenarios/arm_sampled.toml", overrides={"forces.elbow_motor.every": every}, allow_code=True)
