"""Wrong limits, contacts and events that change something: one clear message each; nothing is written.

Each case: the text, then its message: key, value, rule; remedy.
"""

from pathlib import Path

import pytest

from tests.scenario.checks.refusal import FREE, accepted, check_refused, driver, force, joint, refused, rig


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
    "no joint": (
        rig(event('action = "lock"')),
        "events.act.joint is missing; give the name of the joint that is locked, released or engaged",
    ),
    "unknown parameter": (
        rig(PARAMETERS, event(SET, "parameters = { kd = 1 }"), MOTOR),
        'events.act.parameters.kd: is not a parameter; the nearest known name is "kp"',
    ),
    "a mass through another": (
        rig('[parameters]\nkp = 2\nm = "2*kp"\n', event(SET, "parameters = { kp = 1 }"), HEAVY.format("m")),
        "model.bodies.free.mass: reads kp, which an event sets, but is one",
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
    "restitutions above 1 in a sweep": (
        rig(
            contact(*FOOT, "restitution = 0.5"),
            '[sweep]\nruns = 2\n[sweep.vary."contacts.foot.restitution"]\ndistribution = "uniform"\n'
            "low = 0.5\nhigh = 1.5\n",
        ),
        'sweep.vary."contacts.foot.restitution".high = 1.5: allows values below 0 or above 1, which no contact has; '
        "give high between 0 and 1",
    ),
    "the name of a joint": (
        rig(contact(*FOOT, name="pivot")),
        'model.contacts.pivot.name = "pivot": is also the name of model.joints.pivot; give another name',
    ),
    "an axis of length 0": (
        rig(contact(*FOOT, "axis = [0, 0, 0]", kind="cylinder_plane")),
        "model.contacts.foot.axis = [0.0, 0.0, 0.0]: has no direction; give 3 numbers that are not all 0",
    ),
    "dissipation of what is rigid": (
        rig(contact(*FOOT, "dissipation = 0.3")),
        "model.contacts.foot.dissipation = 0.3: is of a contact with stiffness, and this one is rigid; "
        "leave it out, or give stiffness, too",
    ),
    "a fixed joint that begins locked": (
        rig(FREE, f"{WELD}locked = true\n"),
        "model.joints.weld.locked = true: is of a fixed joint, which has no coordinate to lock; leave it out",
    ),
    "a series of slow sliding": (
        rig(contact(*FOOT, "friction = 0.3")).replace("[integrator]", '[integrator]\nmethod = "taylor"'),
        'integrator.step = 0.001: is too long for the method "taylor" where [[model.contacts]] with friction begin or '
        "end to slide; give integrator.tolerance instead, or another method",
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
}

# More of these rules: the place, and words of the rule.
MORE = {
    "model.limits.pivot.low: exchange the two": rig(limit('joint = "pivot"', "low = 1", "high = -1")),
    "model.limits.pivot.low: move them apart, or use a lock": rig(limit('joint = "pivot"', "low = 1", "high = 1")),
    "events.act.joint: is not a joint of the model": rig(event('action = "lock"', 'joint = "pivto"')),
    "events.act.joint: has no meaning for action": rig(event('joint = "pivot"')),
    "events.act.parameters: is missing": rig(event(SET)),
    "events.act.parameters: names none": rig(PARAMETERS, event(SET, "parameters = {}")),
    "events.act.parameters: model.forces.push.static": rig(PARAMETERS, STICKS, event(SET, "parameters = { kp = 0.5 }")),
    "model.bodies.free.mass: reads kp, which an event sets, but is one": rig(
        PARAMETERS, event(SET, "parameters = { kp = 1 }"), HEAVY.format("kp")
    ),
    "model.drivers.drive.value: reads kp, which an event sets, but what a": rig(
        PARAMETERS, event(SET, "parameters = { kp = 1 }"), driver('joint = "rail"', 'value = "kp*sin(t)"')
    ),
    "model.gravity[2]: reads kp, which an event sets, but is one": rig(
        PARAMETERS, event(SET, "parameters = { kp = 1 }"), model='[model]\ngravity = [0, 0, "-kp*t"]\n'
    ),
    "events.act.coordinate: pivot is a revolute joint, which has no": rig(
        event('action = "lock"', 'joint = "pivot"', 'coordinate = "displacement"')
    ),
    "events.act.when: happens whenever events.other does, which has": rig(
        event('action = "lock"', 'joint = "pivot"'),
        event('action = "unlock"', 'joint = "pivot"', name="other", when="1 <= t"),
    ),
    "events.act.joint: model.drivers.drive prescribes how it moves": rig(
        SHAKEN, event('action = "release"', 'joint = "rail"')
    ),
    "model.limits.pivot.low: the angle of pivot begins at 0 rad, 0.175 rad beyond": rig(
        limit('joint = "pivot"', 'low = "10*deg"')
    ),
    "model.limits.rail.high: the displacement of rail begins at 1 m, 0.5 m beyond": rig(
        limit('joint = "rail"', "high = 0.5")
    ),
    "model.contacts.foot.type: is not known": rig(contact(*FOOT, kind="sphere_plan")),
    "model.contacts.foot.bodies: to itself": rig(contact(*FOOT, ends='bodies = ["arm", "arm"]')),
    "model.contacts.foot.normal: has no direction": rig(contact(*FOOT, "normal = [0, 0, 0]")),
    "model.contacts.foot.friction.static: must be at least kinetic": rig(
        contact(*FOOT, "friction = { static = 0.3, kinetic = 0.5 }")
    ),
    "model.contacts.foot.restitution: is of a rigid contact, and this one has a": rig(
        contact(*FOOT, "stiffness = 1e4", "restitution = 0.3")
    ),
    "model.contacts.foot: arm and ground overlap by 0.15 m at the start": rig(
        contact("points = [[0, 0, 0], [0, 0, -0.25]]", "radius = 0.1")
    ),
    "model.forces.push.static: must be at least coulomb": rig(
        force('type = "friction"', 'joint = "pivot"', "coulomb = 2", "static = 1")
    ),
    "model.forces.push.static: must be at least": rig(
        force('type = "friction"', 'joint = "pivot"', "coulomb = 2", "static = -1")
    ),
    "model.forces.push.coulomb: is missing": rig(force('type = "friction"', 'joint = "pivot"', "static = 1")),
    "model.forces.push.velocity: is of friction that is smooth about rest, and": rig(
        force('type = "friction"', 'joint = "pivot"', "static = 1", "coulomb = 1", "velocity = 0.1")
    ),
}


CASES |= {wanted: (text, wanted) for wanted, text in MORE.items()}


@pytest.mark.parametrize("case", CASES)
def test_message(tmp_path: Path, case: str) -> None:
    check_refused(tmp_path, *CASES[case])


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
