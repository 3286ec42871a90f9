"""Wrong forces, and sweeps of drivers and forces: one clear message each, the same from both commands.

Each case: the text, then its message or messages: key, value, rule; remedy.
"""

from pathlib import Path

import pytest

import lienumba
from tests.facade import ScenarioError, resolve
from tests.scenario.checks.refusal import VARY, accepted, check_refused, driver, force, joint, rig

PIVOTED = 'joint = "pivot"'
BALL = joint('type = "spherical"', "at = [0, 0, -0.3]", name="ball")
TUBE = joint('type = "cylindrical"', "at = [0, 0, -0.3]", "axis = [0, 1, 0]", name="tube")
ENDS = 'bodies = ["ground", "arm"]\npoints = [[0, 0, 1], [0, 0, 0]]'
SPRING = force('type = "torsion_spring"', PIVOTED, 'stiffness = "3*2"', 'free_angle = "0.1*t"')

FORCES = {
    "nothing, unnamed": (
        rig(force(name="")),
        "model.forces.force_1.type is missing; give one of spring_damper, force, torque, torsion_spring, "
        "actuator, friction, end_stop, bushing, drag, point_mass_gravity, python",
    ),
    "unnamed, of an unknown body": (
        rig(force('type = "drag"', 'body = "amr"', name="")),
        'model.forces.drag_1.body = "amr": is not a body of the model; the nearest known name is "arm"',
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
    "actuator with a negative limit": (
        rig(force('type = "actuator"', PIVOTED, "value = 3", "limit = -1")),
        "model.forces.push.limit = -1.0: must be at least 0; give its size without a sign",
    ),
    "end_stop without stops": (
        rig(force('type = "end_stop"', PIVOTED, "stiffness = 3")),
        "model.forces.push: has no stop; give lower, upper or both",
    ),
    "end_stop at one place": (
        rig(force('type = "end_stop"', PIVOTED, "stiffness = 3", "lower = 1", "upper = 1")),
        "model.forces.push.lower: must be below upper",
    ),
    "drag of the ground": (
        rig(force('type = "drag"', 'body = "ground"', "linear = 1")),
        'model.forces.push.body = "ground": the ground does not move; name a body',
    ),
}
SWEEPS = {}

# More of these rules: the place, and words of the rule.
MORE = {
    "model.forces.push.bodies: to itself": rig(force('type = "spring_damper"', ENDS.replace("ground", "arm"))),
    "model.forces.push.free_length: must be at least": rig(force('type = "spring_damper"', ENDS, "free_length = -1")),
    "model.forces.push.joint: is a spherical joint, which has no coordinate": rig(
        BALL, force('type = "torsion_spring"', 'joint = "ball"', "stiffness = 1")
    ),
    "model.forces.push: has neither value nor stiffness nor damping, so": rig(force('type = "actuator"', PIVOTED)),
    "model.forces.push.target: has no effect without stiffness or damping": rig(
        force('type = "actuator"', PIVOTED, 'target = "t"')
    ),
    "model.forces.push.velocity: must be above": rig(
        force('type = "friction"', PIVOTED, "coulomb = 3", "velocity = 0")
    ),
    "model.forces.push.lower: must be below upper": rig(
        force('type = "end_stop"', PIVOTED, "stiffness = 3", "lower = 1", "upper = -1")
    ),
    "model.forces.push: is infinite at the start, because its two": rig(
        force(
            'type = "point_mass_gravity"',
            'bodies = ["ground", "arm"]',
            "mu = 1",
            "points = [[0, 0, 0], [0, 0, 0.3]]",
        )
    ),
    'sweep.vary."forces.push.free_angle": the path forces.push.free_angle is the formula': rig(
        SPRING, VARY.format("forces.push.free_angle", 1)
    ),
    'sweep.vary."forces.push.value": the path forces.push.value is not a number but': rig(
        force('type = "force"', 'body = "arm"', 'value = ["1", "2", "t"]'), VARY.format("forces.push.value", 1)
    ),
    'sweep.vary."events.late.when": the path events.late.when is the condition': rig(
        '[[events]]\nname = "late"\nwhen = "t > 0.5"\n', VARY.format("events.late.when", 1)
    ),
    'sweep.vary."forces.push.joint": the path forces.push.joint is not a number but': rig(
        SPRING, VARY.format("forces.push.joint", 1)
    ),
    'sweep.vary."forces.psh.stiffness": the path forces.psh.stiffness does not exist': rig(
        SPRING, VARY.format("forces.psh.stiffness", 1)
    ),
    'sweep.vary."drivers[1].rate": the path drivers': rig(
        driver(PIVOTED, "rate = 3", name=""), VARY.format("drivers[1].rate", 1)
    ),
    "model.forces.push.stiffness: has": rig(SPRING.replace("3*2", "3*("), VARY.format("forces.push.stiffness", 1)),
    'sweep.vary."forces.push.velocity".low: allows values of': rig(
        force('type = "friction"', PIVOTED, "coulomb = 1", "velocity = 1"), VARY.format("forces.push.velocity", -1)
    ),
}
CASES = FORCES | {f"sweep of {name}": case for name, case in SWEEPS.items()}
CASES |= {wanted: (text, wanted) for wanted, text in MORE.items()}


@pytest.mark.parametrize("case", CASES.values(), ids=CASES)
def test_wrong_argument(tmp_path: Path, case: tuple[str, ...]) -> None:
    check_refused(tmp_path, *case)


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
