"""Who is told that a scenario is stiff, and who is not."""

from pathlib import Path
from typing import Any

import pytest
import xarray as xr
from typer.testing import CliRunner

import lienumba
from tests.facade import app
from tests.rigs.places import SCENARIOS
from tests.rigs.scenarios import PENDULUM, TOP, scenario


def arm(stiffness: float, damping: float, method: str = "dp54", tolerance: float = 1e-6, end: float = 4.0) -> Any:
    """A link whose motor follows a slow target."""
    system = lienumba.System("arm").body("link", mass=1.0, inertia=[0.1, 0.1, 0.01], position=[0.5, 0, 0])
    system.joint("hinge", "revolute", ["ground", "link"], at=[0, 0, 0], axis=[0, 1, 0])
    system.force("motor", type="actuator", joint="hinge", stiffness=stiffness, damping=damping, target="0.5*sin(t)")
    return system.integrator(method=method, tolerance=tolerance, coordinates="joint", end_time=end)


def ran(source: Any, **ways: Any) -> Any:
    return lienumba.run(source, overrides={"output.every": 0.1} | ways)


@pytest.mark.parametrize(
    ("method", "tolerance"), [("bs32", 1e-4), ("dp54", 1e-6), ("tsit54", 1e-5), ("dop853", 1e-6), ("taylor", 1e-9)]
)
def test_high_gains_are_told_of_with_every_method(method: str, tolerance: float) -> None:
    found = ran(arm(1e6, 2e3, method, tolerance))
    assert found.attrs["stiff"].startswith(f"{method} took {int(found.steps[0]):,} steps, ")
    assert found.attrs["stiff"].endswith('The scenario is stiff: try method = "radau5"')


@pytest.mark.parametrize("stiffness", [1e6, 0.0])
def test_strong_dampers_are(stiffness: float) -> None:
    assert "what dies out at up to 3e+04 1/s" in ran(arm(stiffness, 1e4)).attrs["stiff"]


def swing(damping: float, method: str, tolerance: float, end: float) -> Any:
    """A link that swings, with a flap on a damper."""
    system = lienumba.System("swing").body("link", mass=1.0, inertia=[0.1, 0.1, 0.01], position=[0, 0, -0.5])
    system.body("flap", mass=0.2, inertia=[0.01, 0.01, 0.01], position=[0, 0.2, -1.0])
    system.joint("hinge", "revolute", ["ground", "link"], at=[0, 0, 0], axis=[0, 1, 0], rate=3.0)
    system.joint("pin", "revolute", ["link", "flap"], at=[0, 0, -1.0], axis=[1, 0, 0], rate=0.0)
    system.force("damper", type="actuator", joint="pin", stiffness=0.0, damping=damping)
    return system.integrator(method=method, tolerance=tolerance, coordinates="joint", end_time=end)


@pytest.mark.parametrize(("method", "tolerance", "free"), [("bs32", 1e-4, 400), ("dp54", 1e-6, 300)])
def test_strong_dampers_are_also_where_the_rest_swings(method: str, tolerance: float, free: int) -> None:
    found = ran(swing(13.5, method, tolerance, 10.0))
    assert int(found.steps[0]) > 6 * free
    assert "stiff" in found.attrs
    calm = ran(swing(0.2, method, tolerance, 10.0))
    assert int(calm.steps[0]) < free
    assert "stiff" not in calm.attrs


def test_many_runs_of_few_steps_are_waited_for() -> None:
    """A run of 910 steps is over at once, and thousands of them are not."""
    system = swing(13.5, "dp54", 1e-4, 4.0).output(every=0.5)
    alone = lienumba.run(system)
    assert 500 < int(alone.steps[0]) < 1000
    assert "stiff" not in alone.attrs
    system.sweep(runs=200, seed=1, vary={"bodies.flap.mass": {"distribution": "uniform", "low": 0.19, "high": 0.21}})
    assert " steps in run " in lienumba.run(system).attrs["stiff"]


@pytest.mark.parametrize("damping", [0.0, 3.0])
def test_what_vibrates_all_along_or_for_long_has_to_be_followed(damping: float) -> None:
    found = ran(arm(1e6, damping))
    assert int(found.steps[0]) > 3000
    assert "stiff" not in found.attrs


@pytest.mark.parametrize(("mechanism", "end"), [(TOP, 0.5), (PENDULUM, 4.0)])
def test_many_short_steps_that_motion_and_tolerance_ask_for_are_not_stiff(mechanism: Any, end: float) -> None:
    data = scenario(mechanism, 1.0, end)
    data["integrator"] = {"method": "bs32", "tolerance": 1e-8, "end_time": end}
    found = ran(data)
    assert int(found.steps[0]) > 1000
    assert "stiff" not in found.attrs


def test_a_ball_that_bounces_is_not() -> None:
    found = lienumba.run(SCENARIOS / "bouncing_ball.toml", overrides={"integrator.tolerance": 1e-11})
    assert "stiff" not in found.attrs


def test_neither_given_steps_nor_implicit_methods_are_asked() -> None:
    given = {"integrator.method": "rk4", "integrator.tolerance": None, "integrator.step": 2e-4}
    for ways in (given, {"integrator.method": "radau5"}):
        assert "stiff" not in ran(arm(1e6, 2e3), **ways).attrs


def test_sweeps_name_a_run_and_say_it_in_the_file_the_summary_and_on_the_terminal(tmp_path: Path) -> None:
    vary = {"forces.motor.stiffness": {"distribution": "uniform", "low": 1.0, "high": 1e6}}
    system = arm(1e6, 2e3, end=1.0).sweep(runs=5, seed=1, vary=vary)
    system.output(mode="summary", summary={"energy": ["max"]})
    said = lienumba.run(system).attrs["stiff"]
    assert " steps in run " in said
    path = tmp_path / "arm.toml"
    path.write_text(system.to_toml(), encoding="utf-8")
    told = CliRunner().invoke(app, ["run", str(path), "--output", str(tmp_path / "arm.nc")]).output
    assert said in " ".join(told.split())
    kept = xr.open_dataset(tmp_path / "arm.nc")
    assert kept.attrs["stiff"] == said
    assert said in str(lienumba.analysis.summarise(kept))
