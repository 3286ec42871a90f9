"""Methods, charts and stabilisations that do not go together: one clear message each, the same from both commands."""

from pathlib import Path

import pytest

from tests.scenario.checks.refusal import accepted, check_refused, rig

DAMPED = "[projection]\nbaumgarte = 10.0\n"


def integrator(*lines: str) -> str:
    return rig().replace("step = 1e-3\n", "\n".join(["step = 1e-3", *lines, ""]))


REFUSED = {
    "vectors on another group": (
        integrator('coordinates = "quaternion"', 'group = "SE3"'),
        'integrator.coordinates = "quaternion": are coordinates of rotations alone, not of integrator.group = "SE3"; '
        "leave one of the two out",
    ),
    "vectors without exponentials": (
        integrator('coordinates = "matrix"', 'method = "cf4"'),
        'integrator.coordinates = "matrix": have no exponentials for integrator.method = "cf4" to compose; give the '
        'method "rk4", which it is in a vector space',
    ),
    "vectors without dexpinv": (
        integrator('coordinates = "tait_bryan"', "dexpinv = 2"),
        'integrator.dexpinv = 2: is not used with integrator.coordinates = "tait_bryan"; leave one of the two out',
    ),
    "a method without dexpinv": (
        integrator('method = "cf4"', 'dexpinv = "closed"'),
        'integrator.dexpinv = "closed": is not used by integrator.method = "cf4", which needs none; leave it out',
    ),
    "an unknown group": (
        integrator('group = "SE(3)"'),
        'integrator.group = "SE(3)": must be "R3xSO3" or "SE3"; the nearest is "SE3"',
    ),
    "damping beside projections": (
        rig(DAMPED),
        'projection.baumgarte = 10.0: damps violations instead of projecting, against projection.position = "local" '
        'and projection.velocity = "mass"; give position = "none" and velocity = "none", or leave baumgarte out',
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_it_is_refused(case: str, tmp_path: Path) -> None:
    check_refused(tmp_path, *REFUSED[case])


@pytest.mark.parametrize(
    "text",
    [
        integrator('group = "SE3"', 'method = "cf4"'),
        integrator('group = "SE3"', 'dexpinv = "closed"'),
        integrator('coordinates = "matrix"', 'group = "R3xSO3"'),
        rig(DAMPED + 'position = "none"\nvelocity = "none"\n'),
    ],
)
def test_these_go_together(text: str, tmp_path: Path) -> None:
    assert accepted(tmp_path, text) == []
