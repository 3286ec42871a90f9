"""Friction of joints that stick only as long as a driver lets them, or that nothing can move."""

from typing import Any

import numpy as np
import pytest

import lienumba
from tests.oracles.changing import scenarios

MASS, KINETIC, STATIC, BEGIN = 2.0, 3.0, 4.0, 0.3
LAWS = {  # what a driver prescribes, and its second derivative
    "0.1*t**3": lambda t: 0.6 * t,
    "0.1*max(t - 0.3, 0)**3": lambda t: 0.6 * np.maximum(t - BEGIN, 0),
    "0.1*max(t - 0.3, 0)**2": lambda t: np.where(t > BEGIN, 0.2, 0.0),
    "0.1*max(t - 0.3, 0)**2*(0.8 - t)": lambda t: np.where(t > BEGIN, 0.1 * (2 * (0.8 - t) - 4 * (t - BEGIN)), 0.0),
}


def driven(law: str, **integrator: Any) -> dict[str, Any]:
    """A slide with dry friction whose displacement is prescribed."""
    body = {"name": "body", "mass": MASS, "inertia": [1.0] * 3, "position": [0, 0, 0], "rotation": [1, 0, 0, 0]}
    slide = {"name": "slide", "type": "prismatic", "bodies": ["ground", "body"], "at": [0, 0, 0], "axis": [1, 0, 0]}
    along = {"joint": "slide", "coordinate": "displacement"}
    return {
        "title": "A driven slide",
        "model": {
            "gravity": [0, 0, 0],
            "bodies": [body],
            "joints": [slide],
            "drivers": [{"name": "motor", "value": law} | along],
            "forces": [{"name": "dry", "type": "friction", "coulomb": KINETIC, "static": STATIC} | along],
        },
        "quantities": [{"name": "motor", "type": "driver_effort", "driver": "motor"}],
        "integrator": scenarios.settings(1.0, 1e-9) | integrator,
        "output": {"times": np.linspace(0, 1, 21).tolist()},
    }


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("way", [{"coordinates": "joint"}, {"coordinates": "lie", "method": "taylor"}])
def test_what_sticks_slides_as_soon_as_a_driver_moves_it(law: str, way: dict[str, Any]) -> None:
    ds = lienumba.run(driven(law, **way)).isel(run=0)
    t = ds.time.values
    moves = np.sign(np.gradient(ds.position[:, 0, 0].values))
    rate = ds.velocity[:, 0, 0].values
    clear = np.abs(rate) > 1e-6
    assert clear.sum() > 10
    assert (np.sign(rate[clear]) == moves[clear]).all()
    wanted = MASS * LAWS[law](t) + KINETIC * np.sign(rate)
    np.testing.assert_allclose(ds["motor"].values.ravel()[clear], wanted[clear], rtol=0, atol=1e-6)
    mode = ds["mode"].sel(switch="dry").values
    assert (mode[clear] == 2).all()
    begin = BEGIN if "max" in law else 0.0
    assert (mode[t < begin - 1e-9] == 1).all()
    slid = ds.change_time.values[scenarios.kinds(ds, "slid")]
    assert slid[0] == pytest.approx(begin, abs=1e-4)
    assert abs(ds.energy_residual).max() < 1e-8


@pytest.mark.parametrize("coordinates", ["joint", "lie"])
def test_what_nothing_can_move_sticks(coordinates: str) -> None:
    """A hinge beside a weld, whose rates and accelerations are rounding, in a body that swings; and a screw that cannot
    turn since a point of its nut stays in a plane."""
    inertia = [[0.1, 0.02, 0.01], [0.02, 0.2, 0.03], [0.01, 0.03, 0.15]]
    start = {"position": [0.3, 0.4, -0.2], "rotation": [0.6, 0.0, 0.8, 0.0]}
    bodies = [{"name": name, "mass": 1.3, "inertia": inertia} | start for name in ("first", "second", "nut")]
    hinge = {"type": "revolute", "at": [0.1, -0.2, 0.3], "axis": [0.48, 0.6, 0.64]}
    ds = lienumba.run({
        "title": "A weld",
        "model": {
            "bodies": bodies,
            "joints": [
                hinge | {"name": "swing", "bodies": ["ground", "first"], "rate": 1.0},
                {"name": "weld", "type": "fixed", "bodies": ["first", "second"], "at": [0.3, 0.1, 0.2]},
                hinge | {"name": "rusty", "bodies": ["first", "second"], "at": [0.2, 0.3, 0.1]},
                hinge | {"name": "screw", "type": "screw", "pitch": 0.3, "bodies": ["ground", "nut"]},
                hinge | {"name": "plane", "type": "point_in_plane", "bodies": ["nut", "ground"], "at": [0.7, 0.1, 0.4]},
            ],
            "forces": [
                {"name": name, "type": "friction", "joint": joint, "coordinate": "angle", "coulomb": 0.5, "static": 0.8}
                for name, joint in (("rust", "rusty"), ("dirt", "screw"))
            ],
        },
        "integrator": scenarios.settings(0.5, 1e-9, coordinates=coordinates),
        "output": {"every": 0.1},
    }).isel(run=0)  # fmt: skip
    assert int(ds.status) == 0
    assert float(abs(ds.angular_velocity[-1]).max()) > 0.1
    assert (ds["mode"].sel(switch=["rust", "dirt"]) == 1).all()
    assert int(ds.changes) == 0
