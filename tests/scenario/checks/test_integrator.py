"""Wrong integrators and events; methods, charts and stabilisations that do not go together: one clear message each."""

from pathlib import Path

import pytest

from tests.scenario.checks.refusal import RIG, accepted, check_refused, rig

DAMPED = "[projection]\nbaumgarte = 10.0\n"
STEP = "step = 1e-3"
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
    "an event of parameters alone": (
        "[parameters]\nk = 1\n" + event('name = "far"', 'when = "k > 50"'),
        "events.far.when: never changes",
    ),
    "too many steps": (
        integrator("tolerance = 1e-6", "max_step = 1e-30"),
        "integrator.max_step = 1e-30: asks for 1e+28 steps until integrator.end_time = 0.01, at most 2,147,483,647 are "
        "possible; give a longer one",
    ),
    "too many stored times": (
        integrator("tolerance = 1e-6") + "[output]\nevery = 1e-12\n",
        "output.every = 1e-12: stores 1e+10 states until integrator.end_time = 0.01, at most 1,000,000 are possible; "
        "give a longer interval, or output.times",
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
    "vectors on another group": (
        integrator(STEP, 'coordinates = "quaternion"', 'group = "SE3"'),
        'integrator.coordinates = "quaternion": are coordinates of rotations alone, not of integrator.group = "SE3"; '
        "leave one of the two out",
    ),
    "vectors without exponentials": (
        integrator(STEP, 'coordinates = "matrix"', 'method = "cf4"'),
        'integrator.coordinates = "matrix": have no exponentials for integrator.method = "cf4" to compose; give the '
        'method "rk4", which it is in a vector space',
    ),
    "vectors without dexpinv": (
        integrator(STEP, 'coordinates = "tait_bryan"', "dexpinv = 2"),
        'integrator.dexpinv = 2: is not used with integrator.coordinates = "tait_bryan"; leave one of the two out',
    ),
    "a method without dexpinv": (
        integrator(STEP, 'method = "cf4"', 'dexpinv = "closed"'),
        'integrator.dexpinv = "closed": is not used by integrator.method = "cf4", which needs none; leave it out',
    ),
    "an unknown group": (
        integrator(STEP, 'group = "SE(3)"'),
        'integrator.group = "SE(3)": must be "R3xSO3" or "SE3"; the nearest is "SE3"',
    ),
    "damping beside projections": (
        rig(DAMPED),
        'projection.baumgarte = 10.0: damps violations instead of projecting, against projection.position = "local" '
        'and projection.velocity = "mass"; give position = "none" and velocity = "none", or leave baumgarte out',
    ),
}

# More of these rules: the place, and words of the rule.
MORE = {
    "integrator.tolerance: must be at least 1e-14": integrator("tolerance = 1e-17"),
    "integrator.tolerance.relative: must be at most 0.1": integrator("tolerance = { relative = 0.11 }"),
    "events.far.when: is a number, not a condition": event('name = "far"', 'when = "tip.x"'),
    "events.far.when: has the unknown name": event('name = "far"', 'when = "top.x > 1"'),
    "events.far.when: never changes": event('name = "far"', 'when = "1 > 2"'),
    "events.far.when: asks whether numbers are equal, which they": event('name = "far"', 'when = "tip.x == 0"'),
    "events.far.when: is not a formula": event('name = "far"', 'when = "tip.x > 0 and"'),
    "projection.max_iterations: is a whole number that": RIG + "[projection]\nmax_iterations = 100000000000000000000\n",
}


CASES |= {wanted: (text, wanted) for wanted, text in MORE.items()}


@pytest.mark.parametrize(("text", "message"), CASES.values(), ids=CASES)
def test_it_is_refused(text: str, message: str, tmp_path: Path) -> None:
    check_refused(tmp_path, text, message)


@pytest.mark.parametrize(
    "text",
    [
        integrator(STEP, 'group = "SE3"', 'method = "cf4"'),
        integrator(STEP, 'group = "SE3"', 'dexpinv = "closed"'),
        integrator(STEP, 'coordinates = "matrix"', 'group = "R3xSO3"'),
        rig(DAMPED + 'position = "none"\nvelocity = "none"\n'),
    ],
)
def test_these_go_together(text: str, tmp_path: Path) -> None:
    assert accepted(tmp_path, text) == []
