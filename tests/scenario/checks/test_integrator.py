"""Wrong integrators and events: one clear message each, the same from both commands; nothing is written."""

from pathlib import Path

import pytest

from tests.scenario.checks.refusal import RIG, refused_by_both

PAIRS = "bs32, dp54, tsit54, dop853, radau3, radau5, radau9 or taylor"


def integrator(*lines: str) -> str:
    """The rig with these keys of the section [integrator] instead of its step."""
    before, _, rest = RIG.partition("[integrator]")
    kept = [line for line in rest.splitlines() if not line.startswith(("step", "method"))]
    return before + "[integrator]\n" + "\n".join([*lines, *kept]) + "\n"


def event(*lines: str) -> str:
    return (
        RIG + '\n[[quantities]]\nname = "tip"\ntype = "point"\nbody = "arm"\n\n[[events]]\n' + "\n".join(lines) + "\n"
    )


CASES = {
    "nothing": (
        integrator(),
        "integrator.step is missing; give the time step in s, above 0, or integrator.tolerance, the error of one step, "
        "with one of bs32, dp54, tsit54, dop853, radau3, radau5, radau9, taylor",
    ),
    "both": (
        integrator("step = 0.001", "tolerance = 1e-6"),
        "integrator.step and integrator.tolerance are both given; leave one of them out",
    ),
    "no pair": (
        integrator('method = "rk4"', "tolerance = 1e-6"),
        'integrator.tolerance: the method "rk4" does not estimate its error; take ' + PAIRS + ", or give "
        "integrator.step instead",
    ),
    "a text": (
        integrator('tolerance = "fine"'),
        'integrator.tolerance = "fine": must be a number; give the error of one step, from 1e-14 to 0.1, or '
        "{ relative = ..., absolute = { rotation = ... } }",
    ),
    "below rounding": (
        integrator("tolerance = 1e-17"),
        "integrator.tolerance = 1e-17: must be at least 1e-14; give the error of one step, from 1e-14 to 0.1, or "
        "{ relative = ..., absolute = { rotation = ... } }",
    ),
    "only absolute": (
        integrator("tolerance = { absolute = { rotation = 1e-9 } }"),
        "integrator.tolerance.relative is missing; give the error of a step relative to the size, from 1e-14 to 0.1",
    ),
    "unknown kind": (
        integrator("tolerance = { relative = 1e-9, absolute = { attitude = 1e-9 } }"),
        'integrator.tolerance.absolute.attitude is not a known key; the nearest known name is "rotation"',
    ),
    "negative": (
        integrator("tolerance = { relative = 1e-9, absolute = { rotation = -1.0 } }"),
        "integrator.tolerance.absolute.rotation = -1.0: must be above 0; give the error of a rotation in rad, above 0",
    ),
    "bounds of given steps": (
        integrator("step = 0.001", "max_step = 0.005"),
        "integrator.max_step = 0.005: bounds steps that a tolerance chooses, but integrator.step = 0.001 gives them; "
        "leave it out, or give integrator.tolerance instead",
    ),
    "bounds that cross": (
        integrator("tolerance = 1e-6", "max_step = 1e-3", "min_step = 5e-3"),
        "integrator.min_step = 0.005: is longer than integrator.max_step = 0.001; give a shorter one",
    ),
    "a step beyond the end": (
        integrator("tolerance = 1e-6", "first_step = 100.0"),
        "integrator.first_step = 100.0: is longer than the run, integrator.end_time = 0.01; give a shorter one",
    ),
    "an event without a condition": (
        event('name = "far"'),
        'events.far.when is missing; give a condition of quantities, parameters and t, such as "pointing.angle > '
        '20*deg"',
    ),
    "an event that is a number": (
        event('name = "far"', 'when = "tip.x"'),
        'events.far.when = "tip.x": is a number, not a condition; compare it, such as in "t > 0.5"',
    ),
    "an event of an unknown quantity": (
        event('name = "far"', 'when = "top.x > 1"'),
        'events.far.when = "top.x > 1": has the unknown name "top.x"; the nearest known name is "tip.x"',
    ),
    "an event that never changes": (
        event('name = "far"', 'when = "1 > 2"'),
        'events.far.when = "1 > 2": never changes; name a quantity in it, or the time t',
    ),
    "an unknown action": (
        event('name = "far"', 'when = "t > 1"', 'action = "halt"'),
        'events.far.action = "halt": is not known; known here are "record", "stop", "lock", "unlock", '
        '"release", "engage", "set"',
    ),
    "an event of parameters alone": (
        "[parameters]\nk = 1\n" + event('name = "far"', 'when = "k > 50"'),
        'events.far.when = "k > 50": never changes; name a quantity in it, or the time t',
    ),
    "equal numbers": (
        event('name = "far"', 'when = "tip.x == 0"'),
        'events.far.when = "tip.x == 0": asks whether numbers are equal, which they hardly ever are; compare them by '
        "<, <=, > or >=",
    ),
    "an unfinished condition": (
        event('name = "far"', 'when = "tip.x > 0 and"'),
        'events.far.when = "tip.x > 0 and": is not a formula; write one such as "0.3*sin(2*t) + 0.1*t**2"',
    ),
    "too many steps": (
        integrator("tolerance = 1e-6", "max_step = 1e-30"),
        "integrator.max_step = 1e-30: asks for 1e+28 steps until integrator.end_time = 0.01, at most 2,147,483,647 are "
        "possible; give a longer one",
    ),
    "a time that cannot be divided": (
        integrator("tolerance = 1e-6").replace("end_time = 0.01", "end_time = 5e-324"),
        "integrator.end_time = 5e-324: must be at least 1e-100; give the simulated time in s, 1e-100 or more",
    ),
    "too many stored times": (
        integrator("tolerance = 1e-6") + "[output]\nevery = 1e-12\n",
        "output.every = 1e-12: stores 1e+10 states until integrator.end_time = 0.01, at most 1,000,000 are possible; "
        "give a longer interval, or output.times",
    ),
    "too many iterations": (
        RIG + "[projection]\nmax_iterations = 100000000000000000000\n",
        "projection.max_iterations = 100000000000000000000: is a whole number that 64 bits cannot hold; give "
        "a smaller one, or write it with a point or an exponent: 1e30",
    ),
    "events of a method that sees ends alone": (
        event('name = "far"', 'when = "t > 1"').replace("step = 1e-3", 'step = 1e-3\nmethod = "cf4"'),
        'integrator.method = "cf4": says where a body is at the ends of steps only, but [[events]] asks for more; give '
        '"rk4", or leave [[events]] out',
    ),
    "a tolerance of other coordinates": (
        integrator("tolerance = 1e-6", 'coordinates = "quaternion"'),
        'integrator.coordinates = "quaternion": says where a body is at the ends of given steps only, but '
        'integrator.tolerance asks for more; give "lie", or leave integrator.tolerance out',
    ),
    "two events of one name": (
        event('name = "far"', 'when = "t > 1"', "[[events]]", 'name = "far"', 'when = "t > 2"'),
        'events[1].name = "far": is also the name of events[0]; give each its own name',
    ),
}


@pytest.mark.parametrize(("text", "message"), CASES.values(), ids=CASES)
def test_it_is_refused(text: str, message: str, tmp_path: Path) -> None:
    assert refused_by_both(tmp_path, text) == [message]
