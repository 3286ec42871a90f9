"""Wrong limits, contacts and events that change something: one clear message each; nothing is written.

Each case: the text, then its message: key, value, rule; remedy.
"""

from pathlib import Path

import pytest

from tests.scenario.checks.refusal import FREE, accepted, driver, force, joint, refused, refused_by_both, rig


def event(*lines: str, name: str = "act", when: str = "t > 1") -> str:
    return "\n".join(["[[events]]", f'name = "{name}"', f'when = "{when}"', *lines]) + "\n"


def limit(*lines: str) -> str:
    return "\n".join(["[[model.limits]]", *lines]) + "\n"


def contact(
    *lines: str, kind: str = "sphere_plane", name: str = "foot", ends: str = 'bodies = ["arm", "ground"]'
) -> str:
    return "\n".join(["[[model.contacts]]", f'name = "{name}"', f'type = "{kind}"', ends, *lines]) + "\n"


FOOT = ("points = [[0, 0, 0], [0, 0, -2]]", "radius = 0.1")
PARAMETERS = "[parameters]\nkp = 2\n"
PROBE = joint('type = "spherical"', "points = [[0, 0, 0], [0, 0, 0]]", "active = false", name="probe")
SLIDING = PROBE.replace('"spherical"', '"prismatic"').replace("active", "axes = [[1, 0, 0], [1, 0, 0]]\nactive")
BALL = joint('type = "spherical"', "at = [0, 0, -0.3]", name="ball", ends='bodies = ["arm", "free"]')
WELD = joint('type = "fixed"', "at = [0, 0, -0.3]", name="weld", ends='bodies = ["arm", "free"]')
SLEEVE = joint(
    'type = "cylindrical"', "at = [0, 0, -0.3]", "axis = [1, 0, 0]", name="sleeve", ends='bodies = ["arm", "free"]'
)
SET = 'action = "set"'
SHAKEN = driver('joint = "rail"', 'value = "0.1*sin(t)"')
MOTOR = force('type = "actuator"', 'joint = "pivot"', 'value = "kp"')
STICKS = force('type = "friction"', 'joint = "pivot"', "coulomb = 1", 'static = "kp"')
HEAVY = (
    '[[model.bodies]]\nname = "free"\nmass = "{}"\ninertia = [1, 1, 1]\nposition = [9, 9, 9]\nrotation = [1, 0, 0, 0]\n'
)
CASES = {
    "unknown action": (
        rig(event('action = "lok"', 'joint = "pivot"')),
        'events.act.action = "lok": is not known; the nearest known name is "lock"',
    ),
    "no joint": (
        rig(event('action = "lock"')),
        "events.act.joint is missing; give the name of the joint that is locked, released or engaged",
    ),
    "unknown joint": (
        rig(event('action = "lock"', 'joint = "pivto"')),
        'events.act.joint = "pivto": is not a joint of the model; the nearest known name is "pivot"',
    ),
    "a joint for nothing": (
        rig(event('joint = "pivot"')),
        'events.act.joint = "pivot" has no meaning for action = "record"; leave it out, or give action = '
        '"lock", "unlock", "release" or "engage"',
    ),
    "no parameters": (
        rig(event(SET)),
        "events.act.parameters is missing; give parameters by their names with the values that they take "
        '(or a formula of t in quotes, such as "0.3*sin(2*t)"): { kp = 0 }',
    ),
    "empty parameters": (
        rig(PARAMETERS, event(SET, "parameters = {}")),
        "events.act.parameters: names none; give { name = value }, or leave the event out",
    ),
    "unknown parameter": (
        rig(PARAMETERS, event(SET, "parameters = { kd = 1 }"), MOTOR),
        'events.act.parameters.kd: is not a parameter; the nearest known name is "kp"',
    ),
    "static friction that is set below the other": (
        rig(PARAMETERS, STICKS, event(SET, "parameters = { kp = 0.5 }")),
        'events.act.parameters: model.forces.push.static = "kp" = 0.5: must be at least coulomb = 1.0; exchange the '
        "two, or give the same",
    ),
    "not a number": (
        rig(PARAMETERS, event(SET, "parameters = { kp = true }"), MOTOR),
        "events.act.parameters.kp = true: must be a number; give parameters by their names with the values "
        'that they take (or a formula of t in quotes, such as "0.3*sin(2*t)"): { kp = 0 }',
    ),
    "a mass": (
        rig(PARAMETERS, event(SET, "parameters = { kp = 1 }"), HEAVY.format("kp")),
        'model.bodies.free.mass = "kp": reads kp, which an event sets, but is one number for the whole '
        "run; name another parameter there",
    ),
    "a mass through another": (
        rig('[parameters]\nkp = 2\nm = "2*kp"\n', event(SET, "parameters = { kp = 1 }"), HEAVY.format("m")),
        'model.bodies.free.mass = "m": reads kp, which an event sets, but is one number for the whole run; '
        "name another parameter there",
    ),
    "a driver": (
        rig(PARAMETERS, event(SET, "parameters = { kp = 1 }"), driver('joint = "rail"', 'value = "kp*sin(t)"')),
        'model.drivers.drive.value = "kp*sin(t)": reads kp, which an event sets, but what a driver '
        "prescribes cannot jump; name another parameter there",
    ),
    "gravity": (
        rig(PARAMETERS, event(SET, "parameters = { kp = 1 }"), model='[model]\ngravity = [0, 0, "-kp*t"]\n'),
        'model.gravity[2] = "-kp*t": reads kp, which an event sets, but is one number for the whole run; '
        "name another parameter there",
    ),
    "coordinate that it has not": (
        rig(event('action = "lock"', 'joint = "pivot"', 'coordinate = "displacement"')),
        'events.act.coordinate = "displacement": pivot is a revolute joint, which has no displacement; '
        'give "angle", or leave it out',
    ),
    "a joint without coordinates": (
        rig(FREE, WELD, event('action = "lock"', 'joint = "weld"')),
        'events.act.joint = "weld": is a fixed joint, which has no coordinate to lock; joints that have '
        "one are spherical, revolute, universal, cylindrical, prismatic, planar, point_on_line, screw",
    ),
    "part of a ball": (
        rig(FREE, BALL, event('action = "lock"', 'joint = "ball"', 'coordinate = "rx"')),
        'events.act.coordinate = "rx": ball is a spherical joint, which is locked as a whole; leave it out',
    ),
    "never locked": (
        rig(event('action = "unlock"', 'joint = "pivot"')),
        'events.act.joint = "pivot": is never locked; give model.joints.pivot locked = true, or another '
        'event action = "lock"',
    ),
    "release of what is not active": (
        rig(PROBE, event('action = "release"', 'joint = "probe"')),
        'events.act.joint = "probe": is not active at the start, and no event engages it; leave the event '
        'out, or give another one action = "engage"',
    ),
    "engage of what is active": (
        rig(event('action = "engage"', 'joint = "pivot"')),
        'events.act.joint = "pivot": is active from the start, and no event releases it; give '
        "model.joints.pivot active = false",
    ),
    "contradicting": (
        rig(event('action = "lock"', 'joint = "pivot"'), event('action = "unlock"', 'joint = "pivot"', name="other")),
        'events.act.when = "t > 1": happens whenever events.other does, which has action = "unlock" of the '
        "same joint; give one of the two another condition",
    ),
    "release and engage at once": (
        rig(
            event('action = "release"', 'joint = "pivot"'), event('action = "engage"', 'joint = "pivot"', name="other")
        ),
        'events.act.when = "t > 1": happens whenever events.other does, which has action = "engage" of the '
        "same joint; give one of the two another condition",
    ),
    "release and lock at once, written otherwise": (
        rig(
            event('action = "release"', 'joint = "pivot"'),
            event('action = "lock"', 'joint = "pivot"', name="other", when="t>1.0e0"),
        ).replace('t > 1"', 't > 1.0"'),
        'events.act.when = "t > 1.0": happens whenever events.other does, which has action = "lock" of the same joint; '
        "give one of the two another condition",
    ),
    "contradicting, compared from the other side": (
        rig(
            event('action = "lock"', 'joint = "pivot"'),
            event('action = "unlock"', 'joint = "pivot"', name="other", when="1 <= t"),
        ),
        'events.act.when = "t > 1": happens whenever events.other does, which has action = "unlock" of the '
        "same joint; give one of the two another condition",
    ),
    "a condition that assigns": (
        rig(event('action = "lock"', 'joint = "pivot"')).replace('"t > 1"', '"t = 1"'),
        'events.act.when = "t = 1": has an equals sign; write only what stands to its right, or compare by <, <=, > or '
        ">=",
    ),
    "lock of what is driven": (
        rig(SHAKEN, event('action = "lock"', 'joint = "rail"')),
        'events.act.joint = "rail": model.drivers.drive prescribes how it moves, a lock contradicts that; '
        "remove one of the two, or let a force drive it",
    ),
    "release of what is driven": (
        rig(SHAKEN, event('action = "release"', 'joint = "rail"')),
        'events.act.joint = "rail": model.drivers.drive prescribes how it moves, which would move its '
        "bodies still; remove one of the two, or let a force drive it",
    ),
    "driver of a joint that waits": (
        rig(SLIDING, driver('joint = "probe"', 'value = "0.1*sin(t)"'), event('action = "engage"', 'joint = "probe"')),
        'model.drivers.drive.joint = "probe": is not active at the start, and nothing says what its driver '
        "does until then; drive it by a force",
    ),
    "a start of a joint that waits": (
        rig(
            PROBE.replace("active", "rotation_vector = [0, 0, 0.1]\nactive"),
            event('action = "engage"', 'joint = "probe"'),
        ),
        "model.joints.probe.rotation_vector = [0, 0, 0.1]: is of the start, where the joint is not active; "
        "leave it out",
    ),
    "closing of 0": (
        rig(PROBE, event('action = "engage"', 'joint = "probe"', "closing = 0")),
        "events.act.closing = 0: must be above 0; give how far apart in m or rad a joint may be that it "
        "engages, above 0 (or omit it: 0.02); beyond, the run fails",
    ),
    "active in quotes": (
        rig(PROBE.replace("false", '"no"')),
        'model.joints.probe.active = "no": must be true or false; write it so, without quotes',
    ),
    "limit of an unknown joint": (
        rig(limit('joint = "pivto"', "low = 0")),
        'model.limits.pivto.joint = "pivto": is not a joint of the model; the nearest known name is "pivot"',
    ),
    "limit without a stop": (
        rig(limit('joint = "pivot"')),
        "model.limits.pivot: has no stop; give low, high or both",
    ),
    "limit upside down": (
        rig(limit('joint = "pivot"', "low = 1", "high = -1")),
        "model.limits.pivot.low = 1.0: must be below high = -1.0; exchange the two",
    ),
    "limit without room": (
        rig(limit('joint = "pivot"', "low = 1", "high = 1")),
        "model.limits.pivot.low = 1.0: must be below high = 1.0; move them apart, or use a lock",
    ),
    "limit of no coordinate": (
        rig(FREE, BALL, limit('joint = "ball"', "low = 0")),
        'model.limits.ball.joint = "ball": is a spherical joint, which has no coordinate to limit; joints '
        "that have one are pivot and rail",
    ),
    "limit of another coordinate": (
        rig(limit('joint = "pivot"', 'coordinate = "displacement"', "low = -1")),
        'model.limits.pivot.coordinate = "displacement": pivot is a revolute joint, which has no '
        'displacement; give "angle", or leave it out',
    ),
    "limit of one of several": (
        rig(FREE, SLEEVE, limit('joint = "sleeve"', "low = -1")),
        "model.limits.sleeve.coordinate is missing: sleeve is a cylindrical joint, which has 2; give "
        '"angle" or "displacement"',
    ),
    "restitution above 1": (
        rig(limit('joint = "pivot"', "low = -1", "restitution = 1.5")),
        "model.limits.pivot.restitution = 1.5: must be at most 1; give the restitution, from 0 (nothing "
        "comes back of an impact) to 1 (as fast as it came)",
    ),
    "restitution below 0": (
        rig(contact(*FOOT, "restitution = -0.1")),
        "model.contacts.foot.restitution = -0.1: must be at least 0; give the restitution, from 0 (nothing "
        "comes back of an impact) to 1 (as fast as it came)",
    ),
    "restitutions above 1 in a sweep": (
        rig(
            contact(*FOOT, "restitution = 0.5"),
            '[sweep]\nruns = 2\n[sweep.vary."contacts.foot.restitution"]\ndistribution = "uniform"\n'
            "low = 0.5\nhigh = 1.5\n",
        ),
        'sweep.vary."contacts.foot.restitution".high = 1.5: allows values below 0 or above 1, which no contact has; '
        "give high between 0 and 1",
    ),
    "beyond a stop": (
        rig(limit('joint = "pivot"', 'low = "10*deg"')),
        "model.limits.pivot.low = 0.17453292519943295: the angle of pivot begins at 0 rad, 0.175 rad "
        "beyond; correct one of the two",
    ),
    "beyond an upper stop": (
        rig(limit('joint = "rail"', "high = 0.5")),
        "model.limits.rail.high = 0.5: the displacement of rail begins at 1 m, 0.5 m beyond; correct one of the two",
    ),
    "unknown contact": (
        rig(contact(*FOOT, kind="sphere_plan")),
        'model.contacts.foot.type = "sphere_plan": is not known; the nearest known name is "sphere_plane"',
    ),
    "no radius": (
        rig(contact()),
        "model.contacts.foot.radius is missing; give the radius in m, above 0",
    ),
    "radius of a point": (
        rig(contact("radius = 0.1", kind="point_plane")),
        "model.contacts.foot.radius has no meaning for a point_plane contact; leave it out (it belongs to "
        "sphere_plane, cylinder_plane, capsule_plane)",
    ),
    "unknown body": (
        rig(contact(*FOOT, ends='bodies = ["arn", "ground"]')),
        'model.contacts.foot.bodies[0] = "arn": is not a body of the model; the nearest known name is "arm"',
    ),
    "itself": (
        rig(contact(*FOOT, ends='bodies = ["arm", "arm"]')),
        'model.contacts.foot.bodies = ["arm", "arm"]: joins "arm" to itself; name two different bodies',
    ),
    "the name of a joint": (
        rig(contact(*FOOT, name="pivot")),
        'model.contacts.pivot.name = "pivot": is also the name of model.joints.pivot; give another name',
    ),
    "no normal": (
        rig(contact(*FOOT, "normal = [0, 0, 0]")),
        "model.contacts.foot.normal = [0.0, 0.0, 0.0]: has no direction; give 3 numbers that are not all 0",
    ),
    "no axis": (
        rig(contact(*FOOT, kind="cylinder_plane")),
        "model.contacts.foot.axis is missing; give the direction of its axis, 3 numbers in the frame of the first body",
    ),
    "an axis of length 0": (
        rig(contact(*FOOT, "axis = [0, 0, 0]", kind="cylinder_plane")),
        "model.contacts.foot.axis = [0.0, 0.0, 0.0]: has no direction; give 3 numbers that are not all 0",
    ),
    "negative friction": (
        rig(contact(*FOOT, "friction = -0.5")),
        "model.contacts.foot.friction = -0.5: must be at least 0; give the coefficient of friction, at "
        "least 0, or { static = ..., kinetic = ... }",
    ),
    "static below kinetic": (
        rig(contact(*FOOT, "friction = { static = 0.3, kinetic = 0.5 }")),
        "model.contacts.foot.friction.static = 0.3: must be at least kinetic = 0.5; exchange the two, or "
        "give one number",
    ),
    "half a table": (
        rig(contact(*FOOT, "friction = { static = 0.3 }")),
        "model.contacts.foot.friction.kinetic is missing; give the coefficient with which it slides, at "
        "least 0 and at most static",
    ),
    "a misspelt coefficient": (
        rig(contact(*FOOT, "friction = { static = 0.3, kinetics = 0.2, kinetic = 0.1 }")),
        'model.contacts.foot.friction.kinetics is not a known key; the nearest known name is "kinetic"',
    ),
    "restitution of what yields": (
        rig(contact(*FOOT, "stiffness = 1e4", "restitution = 0.3")),
        "model.contacts.foot.restitution = 0.3: is of a rigid contact, and this one has a stiffness; leave "
        "it out, or give dissipation instead",
    ),
    "dissipation of what is rigid": (
        rig(contact(*FOOT, "dissipation = 0.3")),
        "model.contacts.foot.dissipation = 0.3: is of a contact with stiffness, and this one is rigid; "
        "leave it out, or give stiffness, too",
    ),
    "overlap": (
        rig(contact("points = [[0, 0, 0], [0, 0, -0.25]]", "radius = 0.1")),
        "model.contacts.foot: arm and ground overlap by 0.15 m at the start; move one of them apart, or "
        "correct its points and normal",
    ),
    "static friction below coulomb": (
        rig(force('type = "friction"', 'joint = "pivot"', "coulomb = 2", "static = 1")),
        "model.forces.push.static = 1.0: must be at least coulomb = 2.0; exchange the two, or give the same",
    ),
    "static friction below 0": (
        rig(force('type = "friction"', 'joint = "pivot"', "coulomb = 2", "static = -1")),
        "model.forces.push.static = -1.0: must be at least 0; give its size without a sign",
    ),
    "kinetic friction by another name": (
        rig(contact(*FOOT, "friction = { static = 0.7, dynamic = 0.5 }")),
        'model.contacts.foot.friction.dynamic is not a known key; the nearest known name is "kinetic"',
    ),
    "a fixed joint that begins locked": (
        rig(FREE, f"{WELD}locked = true\n"),
        "model.joints.weld.locked = true: is of a fixed joint, which has no coordinate to lock; leave it out",
    ),
    "static friction without coulomb": (
        rig(force('type = "friction"', 'joint = "pivot"', "static = 1")),
        "model.forces.push.coulomb is missing; give the force or torque with which it slides, at most static",
    ),
    "static friction that is smooth": (
        rig(force('type = "friction"', 'joint = "pivot"', "static = 1", "coulomb = 1", "velocity = 0.1")),
        "model.forces.push.velocity = 0.1: is of friction that is smooth about rest, and this one sticks; "
        "leave out either velocity or static",
    ),
    "a method without places between": (
        rig(contact(*FOOT)).replace("[integrator]", '[integrator]\nmethod = "cf4"'),
        'integrator.method = "cf4": says where a body is at the ends of steps only, but [[model.contacts]] '
        'asks for more; give "rk4", or leave [[model.contacts]] out',
    ),
    "a series of slow sliding": (
        rig(contact(*FOOT, "friction = 0.3")).replace("[integrator]", '[integrator]\nmethod = "taylor"'),
        'integrator.step = 0.001: is too long for the method "taylor" where [[model.contacts]] with friction begin or '
        "end to slide; give integrator.tolerance instead, or another method",
    ),
    "rotations as vectors": (
        rig(limit('joint = "pivot"', "low = -1")).replace("[integrator]", '[integrator]\ncoordinates = "quaternion"'),
        'integrator.coordinates = "quaternion": says where a body is at the ends of given steps only, but '
        '[[model.limits]] asks for more; give "lie", or leave [[model.limits]] out',
    ),
    "a chord": (
        rig(event('action = "lock"', 'joint = "pivot"')) + "[projection]\nchord = true\n",
        "projection.chord = true: is not for constraints that are turned on and off, as [[events]] asks "
        "for; leave it out",
    ),
    "the embedded form": (
        rig(contact(*FOOT)) + '[projection]\nposition = "embedded"\n',
        'projection.position = "embedded": is not for constraints that are turned on and off, as '
        '[[model.contacts]] asks for; give "local" or "none"',
    ),
    "damped violations": (
        rig(contact(*FOOT)) + '[projection]\nposition = "none"\nvelocity = "none"\nbaumgarte = 10\n',
        "projection.baumgarte = 10.0: is not for constraints that are turned on and off, as "
        "[[model.contacts]] asks for; leave it out",
    ),
    "lock quantity of what is never locked": (
        rig('[[quantities]]\nname = "hold"\ntype = "lock"\njoint = "pivot"\n'),
        'quantities.hold.joint = "pivot": is never locked; give model.joints.pivot locked = true, or an '
        'event action = "lock"',
    ),
    "unknown contact of a quantity": (
        rig(contact(*FOOT), '[[quantities]]\nname = "hold"\ntype = "contact"\ncontact = "foott"\n'),
        'quantities.hold.contact = "foott": is not a contact of the model; the nearest known name is "foot"',
    ),
}


@pytest.mark.parametrize("case", CASES)
def test_message(tmp_path: Path, case: str) -> None:
    text, message = CASES[case]
    assert refused(tmp_path, text, command="validate") == [message]


def test_run_and_validate_say_the_same(tmp_path: Path) -> None:
    for case in ("engage of what is active", "overlap"):
        assert refused_by_both(tmp_path, CASES[case][0]) == [CASES[case][1]]


def test_a_joint_that_nothing_engages_is_a_warning(tmp_path: Path) -> None:
    assert accepted(tmp_path, rig(PROBE)) == [
        'model.joints.probe.active = false: no event engages it; give one action = "engage"'
    ]


def test_what_only_touches_at_the_start_is_fine(tmp_path: Path) -> None:
    touching = contact("points = [[0, 0, 0], [0, 0, -0.4]]", "radius = 0.1")  # the arm's mass centre is at -0.3
    at_stop = limit('joint = "rail"', "high = 1.0")
    assert accepted(tmp_path, rig(touching, at_stop)) == []


def test_what_is_set_later_need_not_be_a_number_before(tmp_path: Path) -> None:
    later = force('type = "actuator"', 'joint = "pivot"', 'value = "where(kp > 3, sqrt(t - 0.1), 0)"')
    assert accepted(tmp_path, rig(PARAMETERS, later, event(SET, "parameters = { kp = 5 }", when="t > 0.005"))) == []


def test_what_other_events_may_have_set_before_is_a_warning(tmp_path: Path) -> None:
    brake = force('type = "friction"', 'joint = "pivot"', 'coulomb = "mu"', 'static = "kp"')
    first = event(SET, "parameters = { mu = 0.1 }", name="first", when="t > 0.002")
    then = event(SET, "parameters = { kp = 0.5 }", when="t > 0.005")
    assert accepted(tmp_path, rig(PARAMETERS, "mu = 1\n", brake, first, then)) == [
        'events.act.parameters: model.forces.push.static = "kp" = 0.5: must be at least coulomb = 1.0; exchange the '
        "two, or give the same"
    ]


def test_what_is_let_go_may_be_caught_again(tmp_path: Path) -> None:
    again = event('action = "engage"', 'joint = "pivot"', name="again", when="t > 0.006")
    assert accepted(tmp_path, rig(event('action = "release"', 'joint = "pivot"', when="t > 0.003"), again)) == []


def test_conditions_are_compared_as_they_are_written(tmp_path: Path) -> None:
    swing = '[[quantities]]\nname = "swing"\ntype = "joint"\njoint = "pivot"\n'
    on = event('action = "lock"', 'joint = "pivot"', name="on", when="swing.rate > 0.5")
    off = event('action = "unlock"', 'joint = "pivot"', name="off", when="swing.rate < 0.4")
    assert accepted(tmp_path, rig(swing, on, off)) == []
    both = off.replace("< 0.4", "> 0.5")
    assert refused(tmp_path, rig(swing, on, both), command="validate") == [
        'events.on.when = "swing.rate > 0.5": happens whenever events.off does, which has action = "unlock" of the '
        "same joint; give one of the two another condition"
    ]


def test_names_of_what_has_none(tmp_path: Path) -> None:
    """A limit has that of its joint, and a second one another."""
    twice = limit('joint = "pivot"', "low = -1"), limit('joint = "pivot"', "low = 2", "high = 1")
    assert refused(tmp_path, rig(*twice), command="validate") == [
        "model.limits.limit_2.low = 2.0: must be below high = 1.0; exchange the two"
    ]
