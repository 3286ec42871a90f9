"""Who is told of many short steps, and who is not."""

from pathlib import Path
from typing import Any

import pytest
import xarray as xr
from typer.testing import CliRunner

import lienumba
from tests.facade import app
from tests.integrators.methods.test_radau import bars

STIFF = 'the scenario is stiff (strong springs, dampers or gains): try method = "radau5"'


def arm(damping: float, **integrator: Any) -> Any:
    """A link whose motor follows a slow target."""
    system = lienumba.System("arm").body("link", mass=1.0, inertia=[0.1, 0.1, 0.01], position=[0.5, 0, 0])
    system.joint("hinge", "revolute", ["ground", "link"], at=[0, 0, 0], axis=[0, 1, 0])
    system.force("motor", type="actuator", joint="hinge", stiffness=1e6, damping=damping, target="0.5*sin(t)")
    return system.output(every=0.1).integrator(**{"coordinates": "joint", "end_time": 4.0} | integrator)


def test_a_stiff_arm_is_told_of() -> None:
    found = lienumba.run(arm(1e4, method="dp54", tolerance=1e-6))
    assert found.attrs["short_steps"].startswith(f"dp54 took {int(found.steps[0]):,} steps, ")
    assert STIFF in found.attrs["short_steps"]


def test_a_relay_is_told_of_with_an_implicit_method() -> None:
    body = {"name": "block", "mass": 1.0, "inertia": [1, 1, 1]}
    rail = {"name": "rail", "type": "prismatic", "bodies": ["ground", "block"], "points": [[0, 0, 0]] * 2,
            "axes": [[1, 0, 0]] * 2, "references": [[0, 1, 0]] * 2, "displacement": 0.0, "speed": 1.0}  # fmt: skip
    relay = {"name": "relay", "type": "actuator", "joint": "rail", "value": "where(x.speed > 0, -5, 5)"}
    seen = {"name": "x", "type": "joint", "joint": "rail"}
    model = {"gravity": [0, 0, 0], "bodies": [body], "joints": [rail], "forces": [relay], "quantities": [seen]}
    integrator = {"end_time": 1.0, "method": "radau3", "tolerance": 1e-4, "coordinates": "joint"}
    said = lienumba.run({"model": model, "integrator": integrator}).attrs["short_steps"]
    assert "a force jumps back and forth" in said
    assert "stiff" not in said


def test_a_tolerance_below_rounding_is_told_of() -> None:
    """A bushing of 1e12 N/m: positions of 1 m are rounded by 2e-16 m, and that over a step is a velocity."""
    ways = {"integrator.step": None, "integrator.tolerance": 1e-11, "integrator.end_time": 8e-3, "output.every": 8e-3}
    said = lienumba.run(bars(1e12, 1e4), overrides=ways).attrs["short_steps"]
    assert "the estimated errors are rounding" in said
    assert "and the tolerance allows 2e-11 m/s, which no shorter step reaches; give a larger integrator.tol" in said
    assert "jumps" not in said


@pytest.mark.parametrize(
    "integrator",
    [
        {"method": "radau5", "tolerance": 1e-6},
        {"method": "dp54", "tolerance": 1e-6, "end_time": 0.4},
        {"method": "dp54", "tolerance": 1e-6, "max_step": 1e-4, "end_time": 2.0},
        {"method": "rk4", "step": 1e-4},
    ],
    ids=["implicit", "few", "as long as max_step", "given"],
)
def test_few_long_or_given_steps_are_not(integrator: dict[str, Any]) -> None:
    assert "short_steps" not in lienumba.run(arm(1e4, **integrator)).attrs


def test_sweeps_name_a_run_and_say_it_in_the_file_the_summary_and_on_the_terminal(tmp_path: Path) -> None:
    vary = {"forces.motor.damping": {"distribution": "uniform", "low": 2e3, "high": 3e4}}
    system = arm(1e4, method="dp54", tolerance=1e-6, end_time=1.0).sweep(runs=5, seed=1, vary=vary)
    ds = lienumba.run(system)
    said = ds.attrs["short_steps"]
    assert f" steps in run {int(ds.steps.values.argmax())}, " in said
    path = tmp_path / "arm.toml"
    path.write_text(system.to_toml(), encoding="utf-8")
    told = CliRunner().invoke(app, ["run", str(path), "--output", str(tmp_path / "arm.nc")]).output
    assert said in " ".join(told.split())
    kept = xr.open_dataset(tmp_path / "arm.nc")
    assert kept.attrs["short_steps"] == said
    assert said in str(lienumba.analysis.summarise(kept))
    assert "an older sentence" in str(lienumba.analysis.summarise(kept.assign_attrs(stiff="an older sentence")))
