"""Starts that contradict themselves: the joint or driver, the size, the limit, what to free; before anything runs."""

from pathlib import Path

import pytest

import lienumba
from tests.scenario.checks.refusal import (
    ARM,
    BLOCK,
    FREE,
    PIVOT,
    RAIL,
    REFERENCES,
    VARY,
    accepted,
    driver,
    force,
    joint,
    refused,
    refused_by_both,
    rig,
)

PIVOTED = 'joint = "pivot"'
TIP = "points = [[0, 0, -0.3], [0, 0, 0]]"
ROD, NUT = FREE.replace("free", "rod"), FREE.replace("free", "nut")
GEAR = joint('type = "gear"', "ratio = 2", ends='joints = ["pivot", "rail"]')
WELD = joint('type = "fixed"', "at = [0, 0, -0.3]", ends='bodies = ["ground", "arm"]')
LINK = joint(
    'type = "spherical"', "points = [[0, 0, -0.3], [-0.1, 0, 0]]", name="first", ends='bodies = ["arm", "rod"]'
)
STILL = "velocity = [0, 0, 0]\nangular_velocity = [0, 0, 0]\n"

CASES = {
    "points that do not meet": (
        rig(joint('type = "spherical"', TIP)),
        "model.joints.extra: its points do not meet at t = 0: they miss by 1.17 m, at most 3e-09 m is "
        "allowed; correct the points or the position and rotation of arm and block, or omit what shall "
        "be solved for",
    ),
    "points off the line": (
        rig(joint('type = "point_on_line"', TIP, "axes = [[0, 1, 0]]")),
        "model.joints.extra: its points are not where it allows them at t = 0: they miss by 1.17 m, at "
        "most 3e-09 m is allowed; correct the points or the position and rotation of arm and block, or "
        "omit what shall be solved for",
    ),
    "axes that are not parallel": (
        rig(joint('type = "parallel_axes"', "axes = [[0, 0, 1], [0, 1, 1]]")),
        "model.joints.extra: its axes do not fit together at t = 0: they differ by 0.785 rad, at most "
        "1e-08 rad is allowed; correct the axes or the position and rotation of arm and block, or omit "
        "what shall be solved for",
    ),
    "parallel pins of given bodies": (
        rig(joint('type = "universal"', "at = [0, 0, 0]", "axes = [[1, 0, 0], [2, 0, 0]]")),
        "model.joints.extra: its axes are not perpendicular at t = 0: they differ by 1.57 rad, at most "
        "1e-08 rad is allowed; correct the axes or the position and rotation of arm and block, or omit "
        "what shall be solved for",
    ),
    "pins at half a right angle": (
        rig(joint('type = "perpendicular_axes"', "axis = [[1, 0, 0], [1, 1, 0]]")),
        "model.joints.extra: its axes are not perpendicular at t = 0: they differ by 0.785 rad, at most "
        "1e-08 rad is allowed; correct the axes or the position and rotation of arm and block, or omit "
        "what shall be solved for",
    ),
    "a wrong length": (
        rig(joint('type = "distance"', TIP, "length = 2")),
        "model.joints.extra: its points are not at its length at t = 0: they miss by 0.834 m, at most "
        "2e-08 m is allowed; correct the length or the position and rotation of arm and block, or omit "
        "what shall be solved for",
    ),
    "a rod without length": (
        rig(joint('type = "distance"', "points = [[1, 0, 0.3], [0, 0, 0]]")),
        "model.joints.extra: its two points coincide at the start, so its length is 0 and it must be "
        "above 0; move a point or a body, or use a spherical joint",
    ),
    "at without a place": (
        rig(joint('type = "spherical"', "at = [0, 0, 0]"), block=""),
        "model.joints.extra.at: is in the global frame, but where block is at the start is not given; "
        "give position and rotation of block, or give points in the bodies' own frames instead",
    ),
    "axis without a rotation": (
        rig(joint('type = "parallel_axes"', "axis = [0, 0, 1]"), FREE, block='relative_to = "free"\n'),
        "model.joints.extra.axis: is in the global frame, but where block is at the start is not given; "
        "give position and rotation of block, or give axes in the bodies' own frames instead",
    ),
    "reference along the given axis": (
        rig(joint('type = "revolute"', "at = [0, 0, 0]", "axis = [0, 0, 2]", "references = [[1, 0, 0], [0, 0, 1]]")),
        "model.joints.extra.references[1] = [0.0, 0.0, 1.0]: is parallel to the axis of the joint at the "
        "start; give a direction across it",
    ),
    "reference along the default axis": (
        rig(joint('type = "fixed"', "at = [0, 0, 0]", "references = [[0, 0, 1], [1, 0, 0]]")),
        "model.joints.extra.references[0] = [0.0, 0.0, 1.0]: is parallel to the axis of the joint at the "
        "start; give a direction across it",
    ),
    "references across": (
        rig(joint('type = "fixed"', "at = [0, 0, 0]", "axis = [0, 0, 1]", "references = [[1, 0, 0], [0, 1, 0]]")),
        "model.joints.extra: its axes do not fit together at t = 0: they differ by 1.57 rad, at most "
        "1e-08 rad is allowed; correct the axes or the position and rotation of arm and block, or omit "
        "what shall be solved for",
    ),
    "references half a turn apart": (
        rig(joint('type = "fixed"', "at = [0, 0, 0]", "axis = [0, 0, 1]", "references = [[1, 0, 0], [-1, 0, 0]]")),
        "model.joints.extra: its axes and references are half a turn apart at t = 0; turn round those of "
        "one body, or correct the position and rotation of arm and block",
    ),
    "an offset that is not there": (
        rig(GEAR + "offset = 3\n"),
        "model.joints.extra: its coordinates do not have its ratio and offset at t = 0: they miss by 2 "
        "m, at most 5e-15 m is allowed; correct the offset, give references to pivot (without them an "
        "angle is 0 at the start) or the position and rotation of arm and block, or omit what shall be solved for",
    ),
    "an angle that is not there": (
        rig(pivot=f"{PIVOT}\n{REFERENCES}\nangle = 0.5"),
        "model.joints.pivot.angle: contradicts what else is given for the start, by 0.5 rad, at most "
        "1e-08 rad is allowed; correct it or the position and rotation of arm, or omit one of them",
    ),
    "a displacement that is not there": (
        rig(rail=f"{RAIL}\ndisplacement = 0.5"),
        "model.joints.rail.displacement: contradicts what else is given for the start, by 0.5 m, at most "
        "5e-15 m is allowed; correct it or the position and rotation of block, or omit one of them",
    ),
    "a rate that is not there": (
        rig(arm=ARM + STILL, pivot=f"{PIVOT}\nrate = 0.5"),
        "model.joints.pivot.rate: contradicts what else is given for the start, by 0.5 rad/s, at most 1e-12 "
        "rad/s is allowed; correct it or the velocity and angular_velocity of arm, or omit one of them",
    ),
    "a speed that is not there": (
        rig(block=BLOCK + STILL, rail=f"{RAIL}\nspeed = 0.5"),
        "model.joints.rail.speed: contradicts what else is given for the start, by 0.5 m/s, at most 1e-12 "
        "m/s is allowed; correct it or the velocity and angular_velocity of block, or omit one of them",
    ),
    "a screw's rate and speed": (
        rig(
            NUT,
            joint(
                'type = "screw"',
                TIP,
                "axes = [[0, 0, 1], [0, 0, 1]]",
                "pitch = 0.1",
                "rate = 1",
                "speed = 1",
                ends='bodies = ["ground", "nut"]',
            ),
        ),
        "model.joints.extra.speed: contradicts what else is given for the start, by 0.984 m/s, at most "
        "2e-10 m/s is allowed; correct it or the rate, or omit one of them",
    ),
    "an angle from nowhere": (
        rig(
            NUT,
            joint(
                'type = "revolute"', TIP, "axes = [[0, 1, 0], [1, 0, 0]]", "angle = 0.3", ends='bodies = ["arm", "nut"]'
            ),
        ),
        "model.joints.extra: its angle is prescribed at the start, but nothing says from where it "
        "counts; give references = [[x, y, z], [x, y, z]], or the rotations of its bodies",
    ),
    "a driven angle from nowhere": (
        rig(
            NUT,
            joint('type = "revolute"', TIP, "axes = [[0, 1, 0], [1, 0, 0]]", ends='bodies = ["arm", "nut"]'),
            driver('joint = "extra"', 'value = "t"'),
        ),
        "model.joints.extra: its angle is prescribed at the start, but nothing says from where it "
        "counts; give references = [[x, y, z], [x, y, z]], or the rotations of its bodies",
    ),
    "a loop that is open between given bodies": (
        rig(
            ROD,
            LINK,
            joint(
                'type = "spherical"',
                "points = [[0.1, 0, 0], [0, 0, 0]]",
                name="second",
                ends='bodies = ["rod", "block"]',
            ),
        ),
        "model.joints.first: its points do not meet at t = 0: they miss by 0.483 m, at most 3e-09 m is "
        "allowed; correct the points or the position and rotation of arm, or omit what shall be solved "
        "for",
        "model.joints.second: its points do not meet at t = 0: they miss by 0.483 m, at most 1e-09 m is "
        "allowed; correct the points or the position and rotation of block, or omit what shall be solved "
        "for",
    ),
    "a loop that cannot be closed": (
        rig(
            ROD,
            LINK,
            joint(
                'type = "spherical"',
                "points = [[0.1, 0, 0], [0, 0, 2]]",
                name="second",
                ends='bodies = ["rod", "ground"]',
            ),
            arm="",
        ),
        "model.joints.pivot: its points do not meet at t = 0: they miss by 0.3 m, at most 3e-09 m is "
        "allowed; correct the points or give a guess of position and rotation for arm, near where they "
        "fit",
        "model.joints.first: its points do not meet at t = 0: they miss by 0.6 m, at most 3e-09 m is "
        "allowed; correct the points or give a guess of position and rotation for arm and rod, near "
        "where they fit",
        "model.joints.second: its points do not meet at t = 0: they miss by 0.3 m, at most 2e-08 m is "
        "allowed; correct the points or give a guess of position and rotation for rod, near where they "
        "fit",
    ),
    "velocities that part a joint": (
        rig(arm=ARM + "velocity = [0, 0, 1]\n"),
        "model.joints.pivot: the initial velocities contradict it: its points separate at 1 m/s, at most "
        "1e-08 m/s is allowed; correct the velocity of arm, or omit what shall be solved for",
    ),
    "velocities that turn a joint": (
        rig(block=BLOCK + "angular_velocity = [0, 0, 1]\n"),
        "model.joints.rail: the initial velocities contradict it: its bodies turn apart at 1 rad/s, at "
        "most 1e-08 rad/s is allowed; correct the angular_velocity of block, or omit what shall be "
        "solved for",
    ),
    "numbers too large": (
        rig(block=BLOCK.replace("[1, 0, 0]\nr", "[1, 1e90, 0]\nr")),
        "model.joints.rail: its points are not where it allows them at t = 0: they miss by 1e+90 m, at "
        "most 4e+75 m is allowed; correct the points or the position and rotation of block, or omit what "
        "shall be solved for",
    ),
    "numbers far too large": (
        rig(block=BLOCK.replace("[1, 0, 0]\nr", "[1, 1e101, 0]\nr")),
        "model.bodies.block.position[1] = 1e+101: must be at most 1e+100; give the mass centre in m, "
        "global frame: 3 numbers (or omit it: solved from the joints)",
    ),
    "driver away from a given position": (
        rig(driver('joint = "rail"', 'value = "0.5 + t"')),
        "model.drivers.drive: prescribes another position at t = 0 than the start has: they differ by "
        "0.5 m, at most 5e-15 m is allowed; correct its value, or the position and rotation of block, or "
        "omit what shall be solved for",
    ),
    "driver away from a given rotation": (
        rig(driver(PIVOTED, "value = 0.5"), pivot=f"{PIVOT}\n{REFERENCES}"),
        "model.drivers.drive: prescribes another position at t = 0 than the start has: they differ by "
        "0.5 rad, at most 1e-08 rad is allowed; correct its value, or the position and rotation of arm, "
        "or omit what shall be solved for",
    ),
    "driver away from a given angle": (
        rig(driver(PIVOTED, "value = 0.5"), arm="", pivot=f"{PIVOT}\n{REFERENCES}\nangle = 0.2"),
        "model.drivers.drive: prescribes the angle 0.5 at t = 0, but model.joints.pivot.angle = 0.2; "
        "leave the latter out",
    ),
    "driver away from a given velocity": (
        rig(driver('joint = "rail"', 'value = "1 + t"'), block=BLOCK + STILL),
        "model.drivers.drive: prescribes another velocity at t = 0 than the start has: they differ by 1 "
        "m/s, at most 1e-12 m/s is allowed; correct its value, or the velocity and angular_velocity of "
        "block, or omit what shall be solved for",
    ),
    "driver away from a given rate": (
        rig(driver(PIVOTED, "rate = 2"), pivot=f"{PIVOT}\nrate = 1"),
        "model.drivers.drive: prescribes the rate 2 at t = 0, but model.joints.pivot.rate = 1.0; leave the latter out",
    ),
    "driver of what begins locked": (
        rig(driver(PIVOTED, "rate = 2"), pivot=f"{PIVOT}\nlocked = true"),
        "model.drivers.drive: prescribes the rate 2 at t = 0, but model.joints.pivot.locked = true; "
        "leave the latter out",
    ),
    "driver away from a given angular velocity": (
        rig(driver(PIVOTED, "rate = 2"), arm=ARM + "angular_velocity = [0, 1, 0]\n"),
        "model.drivers.drive: prescribes another velocity at t = 0 than the start has: they differ by 1 "
        "rad/s, at most 1e-08 rad/s is allowed; correct its value, or the angular_velocity of arm, or "
        "omit what shall be solved for",
    ),
    "driver away from a given speed": (
        rig(driver('joint = "rail"', 'value = "1 + 3*t"'), rail=f"{RAIL}\nspeed = 1"),
        "model.drivers.drive: prescribes the speed 3 at t = 0, but model.joints.rail.speed = 1.0; leave the latter out",
    ),
    "point away from a given position": (
        rig(driver('body = "free"', 'motion = "point"', "value = [0, 3, 4]"), FREE + "position = [0, 0, 0]\n"),
        "model.drivers.drive: prescribes another position at t = 0 than the start has: they differ by 5 "
        "m, at most 1e-15 m is allowed; correct its value, or the position of free, or omit what shall be "
        "solved for",
    ),
    "orientation away from a given rotation": (
        rig(FREE + "rotation = [1, 0, 0, 0]\n", driver('body = "free"', 'motion = "orientation"', "value = [0, 2, 0]")),
        "model.drivers.drive: prescribes another position at t = 0 than the start has: they differ by 2 "
        "rad, at most 1e-08 rad is allowed; correct its value, or the rotation of free, or omit what "
        "shall be solved for",
    ),
    "orientation half a turn away": (
        rig(
            FREE + "rotation = [1, 0, 0, 0]\n",
            driver('body = "free"', 'motion = "orientation"', 'value = ["pi", 0, 0]'),
        ),
        "model.drivers.drive: prescribes another position at t = 0 than the start has: they differ by "
        "3.14 rad, at most 1e-08 rad is allowed; correct its value, or the rotation of free, or omit "
        "what shall be solved for",
    ),
    "orientation half a turn from the guess": (
        rig(
            FREE + "guess = { rotation = [1, 0, 0, 0] }\n",
            driver('body = "free"', 'motion = "orientation"', 'value = ["pi", 0, 0]'),
        ),
        "model.drivers.drive: prescribes another position at t = 0 than the start has: they differ by "
        "3.14 rad, at most 1e-08 rad is allowed; correct its value, or give a guess of the rotation of "
        "free that is nearer to it",
    ),
    "angular velocity away from a given one": (
        rig(FREE + STILL, driver('body = "free"', 'motion = "angular_velocity"', "value = [0, 0, 0.1]")),
        "model.drivers.drive: prescribes another velocity at t = 0 than the start has: they differ by "
        "0.1 rad/s, at most 1e-12 rad/s is allowed; correct its value, or the velocity and angular_velocity "
        "of free, or omit what shall be solved for",
    ),
    "a point that its joint does not let go": (
        rig(driver('body = "arm"', 'motion = "point"', 'value = [0, "0.1*t", -0.3]')),
        "model: pivot and drive contradict each other: there are 13 equations of rank 11 for 12 "
        "velocities, and no motion fulfils them all; remove a driver or a joint of these, correct "
        "what it prescribes, or, if this is a dead point, give velocities that fit or start beside it",
    ),
    "a point that its joint does not turn": (
        rig(driver('body = "arm"', 'motion = "point"', 'value = ["0.1*t", 0, -0.3]')),
        "model: pivot and drive contradict each other: there are 13 equations of rank 11 for 12 "
        "velocities, and no motion fulfils them all; remove a driver or a joint of these, correct "
        "what it prescribes, or, if this is a dead point, give velocities that fit or start beside it",
    ),
    "two rates on one degree of freedom": (
        rig(GEAR, driver(PIVOTED, "rate = 1", name=""), driver('joint = "rail"', "rate = 1", name="")),
        "model: extra, driver_1 and driver_2 contradict each other: there are 13 equations of rank 12 "
        "for 12 velocities, and no motion fulfils them all; remove a driver or a joint of these, "
        "correct what it prescribes, or, if this is a dead point, give velocities that fit or start beside it",
    ),
    "two values on one degree of freedom": (
        rig(GEAR, driver(PIVOTED, 'value = "t**3"', name=""), driver('joint = "rail"', 'value = "1 + t**3"', name="")),
        "model: extra, driver_1 and driver_2 contradict each other: there are 13 equations of rank 12 "
        "for 12 velocities, and no motion fulfils them all; remove a driver or a joint of these, "
        "correct what it prescribes, or, if this is a dead point, give velocities that fit or start beside it",
    ),
    "two values that agree at the start only": (
        rig(
            GEAR, driver(PIVOTED, 'value = "t"', name=""), driver('joint = "rail"', 'value = "1 + 2*t + t**2"', name="")
        ),
        "model: extra, driver_1 and driver_2 contradict each other: there are 13 equations of rank 12 "
        "for 12 velocities, and no motion fulfils them all; remove a driver or a joint of these, "
        "correct what it prescribes, or, if this is a dead point, give velocities that fit or start beside it",
    ),
    "a structure that is driven": (
        rig(WELD, driver(PIVOTED, 'value = "t"')),
        "model: pivot, extra and drive contradict each other: there are 17 equations of rank 11 for 12 "
        "velocities, and no motion fulfils them all; remove a driver or a joint of these, correct "
        "what it prescribes, or, if this is a dead point, give velocities that fit or start beside it",
    ),
    "a structure that is accelerated": (
        rig(WELD, driver(PIVOTED, 'value = "t**2"')),
        "model: pivot, extra and drive contradict each other: there are 17 equations of rank 11 for 12 "
        "velocities, and no motion fulfils them all; remove a driver or a joint of these, correct "
        "what it prescribes, or, if this is a dead point, give velocities that fit or start beside it",
    ),
}


@pytest.mark.parametrize("case", CASES.values(), ids=CASES)
def test_contradiction(tmp_path: Path, case: tuple[str, ...]) -> None:
    text, *messages = case
    assert refused_by_both(tmp_path, text) == messages


def test_a_sweep_that_tears_all_runs_apart(tmp_path: Path) -> None:
    text = rig(driver('joint = "rail"', "value = 1"), VARY.format("drivers.drive.value", 1))
    (message,) = refused(tmp_path, text)
    assert message.startswith("sweep.vary: no sampled run can be assembled with drivers.drive.value varied; ")
    assert "The first run: model.drivers.drive: prescribes another position at t = 0" in message


VALID = {
    "nothing to add": rig(),
    "a structure": rig(WELD),
    "a structure that is driven nowhere": rig(WELD, driver(PIVOTED, "value = 0")),
    "drivers that agree on one degree of freedom": rig(
        GEAR,
        driver(PIVOTED, 'value = "t"', name=""),
        driver('joint = "rail"', 'value = "1 + 2*t"', name=""),
    ),
    "a driver and the angle it begins with": rig(
        driver(PIVOTED, 'value = "pi/6"'), arm="", pivot=f"{PIVOT}\n{REFERENCES}\nangle = 0.5235987755982988"
    ),
    "an orientation by half a turn": rig(
        FREE, driver('body = "free"', 'motion = "orientation"', 'value = ["pi", 0, "t"]')
    ),
    "an orientation by nearly half a turn": rig(
        FREE, driver('body = "free"', 'motion = "orientation"', "value = [3, 0, 0]")
    ),
    "a branch that is not taken": rig(driver(PIVOTED, 'value = "where(t > 0, t*t*log(t), 0)"')),
    "a force without a rate": rig(force('type = "force"', 'body = "arm"', 'value = ["sqrt(t)", 0, 0]')),
    "relative to the ground": rig(block=BLOCK + 'relative_to = "ground"\n'),
    "one name for a joint, a driver and a force": rig(
        driver(PIVOTED, "value = 0", name='name = "pivot"'),
        force('type = "drag"', 'body = "arm"', "linear = 1", name='name = "pivot"'),
    ),
}


@pytest.mark.parametrize("text", VALID.values(), ids=VALID)
def test_what_is_no_contradiction(tmp_path: Path, text: str) -> None:
    assert accepted(tmp_path, text) == []


def test_joints_without_rows_contradict_nothing() -> None:
    """A spare joint that is not active stands before others that cannot hold together."""
    body = {"name": "dish", "mass": 1, "inertia": [1, 2, 3], "position": [0, 0, 0]}
    ends, points = ["dish", "ground"], [[0, 0, 0], [0, 0, 1]]
    spare = {"name": "spare", "active": False, "type": "distance", "bodies": ends, "points": points}
    upright = {"name": "upright", "type": "parallel_axes", "bodies": ends[::-1], "axis": [0, 0, 1]}
    tilts = {"name": "tilts", "body": "dish", "motion": "angular_velocity", "frame": "body", "value": [1, 0.5, 0]}
    model = {"bodies": [body], "joints": [spare, upright], "drivers": [tilts]}
    caught = {"name": "caught", "when": "t > 0.005", "action": "engage", "joint": "spare"}
    scenario = {"model": model, "integrator": {"step": 1e-3, "end_time": 0.01}, "events": [caught]}
    with pytest.raises(lienumba.ScenarioError, match="model: upright and tilts contradict each other"):
        lienumba.run(scenario, progress=False)
