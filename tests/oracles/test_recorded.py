"""Commands that were recorded while a controller ran give the same motion when they are played without it."""

from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import lienumba
from lienumba import System

SCENARIOS = Path(__file__).parents[2] / "scenarios"
EVERY = 0.005


def arm() -> System:
    system = System("Two links")
    for name, above, x, rate in (("upper", "ground", 0.0, 0.5), ("lower", "upper", 0.25, 0.0)):
        system.body(name, mass=1.0, inertia=[0.002, 0.02, 0.02])
        joint = {"points": [[x, 0, 0], [-0.25, 0, 0]], "axes": [[0, 1, 0]] * 2, "references": [[1, 0, 0]] * 2}
        system.joint(f"{name}_joint", "revolute", [above, name], angle=0.3, rate=rate, **joint)
        system.quantity(f"{name}_at", "joint", joint=f"{name}_joint")
        system.force(f"{name}_motor", type="actuator", joint=f"{name}_joint", value=f"inputs.{name}")
    system.integrator(step=1e-3, end_time=1, coordinates="joint").output(every=EVERY)
    return system


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    controlled = arm()
    for name, target in (("upper", "0.3 + 0.5*t"), ("lower", "0.3*cos(5*t)")):
        controlled.input(name, joint=f"{name}_joint", kp=2, kd=0.3, target=target)
    file = tmp_path_factory.mktemp("recorded") / "run.nc"
    lienumba.run(controlled).to_netcdf(file)
    return file


@pytest.mark.parametrize(
    ("interpolation", "most", "least"), [("cubic", 1e-7, 0), ("linear", 5e-4, 1e-6), ("hold", 5e-2, 5e-4)]
)
def test_open_loop(recorded: Path, interpolation: str, most: float, least: float) -> None:
    played = arm()
    for name in ("upper", "lower"):
        played.input(name, file=str(recorded), value=f"inputs.{name}", interpolation=interpolation)
    ds = lienumba.run(played)
    with xr.open_dataset(recorded) as before:
        gap = max(abs(ds[f"{name}_at.angle"] - before[f"{name}_at.angle"]).values.max() for name in ("upper", "lower"))
    assert least <= gap < most


def test_the_recorded_motion_of_the_ur5_is_what_its_torques_move() -> None:
    """The nominal run follows its reference as far as a hundred points per second tell, and the controllers, whose
    gains are those of the scenario, add next to nothing to what is fed forward."""
    only = {"sweep": {"runs": 1}, "integrator.end_time": 2.0, "output.every": 0.05}
    ds = lienumba.run(SCENARIOS / "ur5_recorded.toml", overrides=only).isel(run=0)
    for name in ("pan", "lift", "elbow", "wrist_1", "wrist_2", "wrist_3"):
        np.testing.assert_allclose(ds[f"{name}_at.angle"], ds[f"inputs.{name}"], rtol=0, atol=1e-4)
        np.testing.assert_allclose(ds[f"inputs.{name}_motor"], ds[f"inputs.{name}_torque"], rtol=0, atol=0.2)
