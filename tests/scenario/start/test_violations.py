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
    check_refused,
    driver,
    force,
    joint,
    refused,
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
    "pins at half a right angle": (
        rig(joint('type = "perpendicular_axes"', "axis = [[1, 0, 0], [1, 1, 0]]")),
        "model.joints.extra: its axes are not perpendicular at t = 0: they differ by 0.785 rad",
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
        "model.joints.first: its points do not meet at t = 0: they miss by 0.483 m",
        "model.joints.second: its points do not meet at t = 0: they miss by 0.483 m",
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
        "model.joints.pivot: its points do not meet at t = 0: they miss by 0.3 m",
        "model.joints.first: its points do not meet at t = 0: they miss by 0.6 m",
        "model.joints.second: its points do not meet at t = 0: they miss by 0.3 m",
    ),
    "numbers far too large": (
        rig(block=BLOCK.replace("[1, 0, 0]\nr", "[1, 1e101, 0]\nr")),
        "model.bodies.block.position[1] = 1e+101: must be at most 1e+100; give the mass centre in m, "
        "global frame: 3 numbers (or omit it: solved from the joints)",
    ),
    "driver of what begins locked": (
        rig(driver(PIVOTED, "rate = 2"), pivot=f"{PIVOT}\nlocked = true"),
        "model.drivers.drive: prescribes the rate 2 at t = 0, but model.joints.pivot.locked = true",
    ),
    "orientation away from a given rotation": (
        rig(FREE + "rotation = [1, 0, 0, 0]\n", driver('body = "free"', 'motion = "orientation"', "value = [0, 2, 0]")),
        "model.drivers.drive: prescribes another position at t = 0 than the start has: they differ by 2 rad",
    ),
    "orientation half a turn away": (
        rig(
            FREE + "rotation = [1, 0, 0, 0]\n",
            driver('body = "free"', 'motion = "orientation"', 'value = ["pi", 0, 0]'),
        ),
        "model.drivers.drive: prescribes another position at t = 0 than the start has: they differ by 3.14 rad",
    ),
    "orientation half a turn from the guess": (
        rig(
            FREE + "guess = { rotation = [1, 0, 0, 0] }\n",
            driver('body = "free"', 'motion = "orientation"', 'value = ["pi", 0, 0]'),
        ),
        "model.drivers.drive: prescribes another position at t = 0 than the start has: they differ by 3.14 rad",
    ),
}

# More of these rules: the place, and words of the rule.
MORE = {
    "model.joints.extra: its points do not meet at t = 0: they miss by 1.17 m": rig(joint('type = "spherical"', TIP)),
    "model.joints.extra: its axes do not fit together at t = 0: they differ by 0.785 rad": rig(
        joint('type = "parallel_axes"', "axes = [[0, 0, 1], [0, 1, 1]]")
    ),
    "model.joints.extra: its axes are not perpendicular at t = 0: they differ by 1.57 rad": rig(
        joint('type = "universal"', "at = [0, 0, 0]", "axes = [[1, 0, 0], [2, 0, 0]]")
    ),
    "model.joints.extra: its points are not at its length at t = 0: they miss by 0.834 m": rig(
        joint('type = "distance"', TIP, "length = 2")
    ),
    "model.joints.extra: its two points coincide at the start, so its length is 0 and it must be above 0": rig(
        joint('type = "distance"', "points = [[1, 0, 0.3], [0, 0, 0]]")
    ),
    "model.joints.extra.at: is in the global frame, but where block is at the start is not given": rig(
        joint('type = "spherical"', "at = [0, 0, 0]"), block=""
    ),
    "model.joints.extra.axis: is in the global frame, but where block is at the start is not given": rig(
        joint('type = "parallel_axes"', "axis = [0, 0, 1]"), FREE, block='relative_to = "free"\n'
    ),
    "model.joints.extra.references[0]: is parallel to the axis of the joint at the start": rig(
        joint('type = "fixed"', "at = [0, 0, 0]", "references = [[0, 0, 1], [1, 0, 0]]")
    ),
    "model.joints.extra: its axes and references are half a turn apart at t = 0": rig(
        joint('type = "fixed"', "at = [0, 0, 0]", "axis = [0, 0, 1]", "references = [[1, 0, 0], [-1, 0, 0]]")
    ),
    "model.joints.extra: its coordinates do not have its ratio and offset at t = 0: they miss by 2 m": rig(
        GEAR + "offset = 3\n"
    ),
    "model.joints.pivot.angle: contradicts what else is given for the start, by 0.5 rad": rig(
        pivot=f"{PIVOT}\n{REFERENCES}\nangle = 0.5"
    ),
    "model.joints.rail.displacement: contradicts what else is given for the start, by 0.5 m": rig(
        rail=f"{RAIL}\ndisplacement = 0.5"
    ),
    "model.joints.pivot.rate: contradicts what else is given for the start, by 0.5 rad/s": rig(
        arm=ARM + STILL, pivot=f"{PIVOT}\nrate = 0.5"
    ),
    "model.joints.rail.speed: contradicts what else is given for the start, by 0.5 m/s": rig(
        block=BLOCK + STILL, rail=f"{RAIL}\nspeed = 0.5"
    ),
    "model.joints.extra: its angle is prescribed at the start, but nothing says from where it counts": rig(
        NUT,
        joint('type = "revolute"', TIP, "axes = [[0, 1, 0], [1, 0, 0]]", "angle = 0.3", ends='bodies = ["arm", "nut"]'),
    ),
    "model.joints.pivot: the initial velocities contradict it: its points separate at 1 m/s": rig(
        arm=ARM + "velocity = [0, 0, 1]\n"
    ),
    "model.joints.rail: the initial velocities contradict it: its bodies turn apart at 1 rad/s": rig(
        block=BLOCK + "angular_velocity = [0, 0, 1]\n"
    ),
    "model.joints.rail: its points are not where it allows them at t = 0: they miss by 1e+90 m": rig(
        block=BLOCK.replace("[1, 0, 0]\nr", "[1, 1e90, 0]\nr")
    ),
    "model.drivers.drive: prescribes another position at t = 0 than the start has: they differ by 0.5 m": rig(
        driver('joint = "rail"', 'value = "0.5 + t"')
    ),
    "model.drivers.drive: prescribes the angle 0.5 at t = 0, but model.joints.pivot.angle = 0.2": rig(
        driver(PIVOTED, "value = 0.5"), arm="", pivot=f"{PIVOT}\n{REFERENCES}\nangle = 0.2"
    ),
    "model.drivers.drive: prescribes another velocity at t = 0 than the start has: they differ by 1 m/s": rig(
        driver('joint = "rail"', 'value = "1 + t"'), block=BLOCK + STILL
    ),
    "model.drivers.drive: prescribes the rate 2 at t = 0, but model.joints.pivot.rate = 1.0": rig(
        driver(PIVOTED, "rate = 2"), pivot=f"{PIVOT}\nrate = 1"
    ),
    "model.drivers.drive: prescribes the speed 3 at t = 0, but model.joints.rail.speed = 1.0": rig(
        driver('joint = "rail"', 'value = "1 + 3*t"'), rail=f"{RAIL}\nspeed = 1"
    ),
    "model: pivot and drive contradict each other: there are": rig(
        driver('body = "arm"', 'motion = "point"', 'value = [0, "0.1*t", -0.3]')
    ),
    "model: extra, driver_": rig(
        GEAR, driver(PIVOTED, "rate = 1", name=""), driver('joint = "rail"', "rate = 1", name="")
    ),
    "model: pivot, extra and drive contradict each other": rig(WELD, driver(PIVOTED, 'value = "t"')),
}


CASES |= {wanted: (text, wanted) for wanted, text in MORE.items()}


@pytest.mark.parametrize("case", CASES.values(), ids=CASES)
def test_contradiction(tmp_path: Path, case: tuple[str, ...]) -> None:
    check_refused(tmp_path, *case)


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
