"""What is let go where others say the same: a pendulum that a lock and a weld hold, which go one after the other."""

from typing import Any

import numpy as np
import pytest

import lienumba
from tests.oracles.changing import scenarios
from tests.rigs import parts

LAST, END, LENGTH, ANGLE = 0.6, 1.1, 0.5, 0.7


def pendulum(coordinates: str, gone: dict[str, float]) -> dict[str, Any]:
    """A rod at rest beside the vertical, held until both have gone."""
    place = {"points": [[0, 0, 0], [0, LENGTH, 0]], "axes": [[1, 0, 0]] * 2, "references": [[0, 1, 0]] * 2}
    hinge = parts.joint("hinge", "revolute", "rod", **place, locked=True)
    weld = parts.joint("weld", "fixed", "rod", at=[0, 0, 0])
    c, s = np.cos(ANGLE), np.sin(ANGLE)
    rotation = [np.cos(ANGLE / 2), np.sin(ANGLE / 2), 0, 0]
    rod = parts.resting("rod", 2, [0.1, 0.01, 0.1], [0, -LENGTH * c, -LENGTH * s], rotation=rotation)
    return {
        "title": "Let go",
        "model": {"gravity": [0, -scenarios.G, 0], "bodies": [rod], "joints": [hinge, weld]},
        "events": [
            {"name": "unlock", "when": f"t > {gone['lock']}", "action": "unlock", "joint": "hinge"},
            {"name": "part", "when": f"t > {gone['weld']}", "action": "release", "joint": "weld"},
        ],
        "quantities": [{"name": "at", "type": "joint", "joint": "hinge"}],
        "integrator": scenarios.settings(END, 1e-11, coordinates=coordinates),
        "output": {"times": [0, 0.3, 0.5, LAST, END]},
    }  # fmt: skip


@pytest.mark.parametrize("coordinates", ["lie", "joint"])
@pytest.mark.parametrize("first", ["lock", "weld"])
def test_what_is_left_holds_alone(first: str, coordinates: str) -> None:
    """Whichever of the two was in use: the other one goes on, and behind the last one the rod swings from rest."""
    other = "weld" if first == "lock" else "lock"
    ds = lienumba.run(pendulum(coordinates, {first: 0.2, other: LAST}), progress=False).isel(run=0)
    assert (int(ds.status), int(ds.changes)) == (0, 2)
    angle, rate = ds["at.angle"].values, ds["at.rate"].values
    np.testing.assert_allclose(angle[:4], angle[0], rtol=0, atol=1e-14)
    np.testing.assert_allclose(rate[:4], 0.0, rtol=0, atol=1e-14)
    inertia = 0.1 + 2 * LENGTH**2
    fallen = 2 * scenarios.G * LENGTH * (np.cos(angle[4]) - np.cos(angle[0]))
    assert abs(angle[4] - angle[0]) > 0.3
    assert 0.5 * inertia * rate[4] ** 2 == pytest.approx(abs(fallen), rel=1e-9)
    assert abs(float(ds.energy_residual[-1])) < 1e-10
