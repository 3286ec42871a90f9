"""The hint at the coordinates of joints: where it is told, and that what it tells is so."""

from typing import Any

import pytest
from typer.testing import CliRunner

from lienumba.engine import runner
from lienumba.scenario.start.hint import hint
from lienumba.scenario.start.prepare import check_initial
from tests.facade import app, resolve
from tests.rigs.places import SCENARIOS

STAGE = {"integrator.method": "euler", "integrator.step": 1e-3, "integrator.tolerance": None}


def told(name: str, **settings: Any) -> str:
    return hint(check_initial(resolve(SCENARIOS / f"{name}.toml", overrides=settings)))


@pytest.mark.parametrize(("name", "number"), [("double_pendulum", 2), ("gyroscope_in_gimbals", 3), ("four_bar", 3)])
def test_hinges_are_counted(name: str, number: int) -> None:
    assert told(name).startswith(f'integrator.coordinates = "joint" integrates {number} joints by their freedoms')


@pytest.mark.parametrize("name", ["heavy_top", "pendulum_chain", "door_on_two_hinges", "rolling_disc", "ur5"])
def test_other_mechanisms_have_none(name: str) -> None:
    assert told(name) == ""


@pytest.mark.parametrize(
    "settings",
    [
        {"integrator.coordinates": "joint"},
        {"integrator.coordinates": "quaternion"},
        {"integrator.group": "SE3"},
        {"projection.position": "embedded"},
        {"projection.position": "none", "projection.velocity": "none"},
        {"projection.chord": True},
    ],
)
def test_a_way_that_was_chosen_is_left_alone(settings: dict[str, Any]) -> None:
    assert told("double_pendulum", **settings) == ""


@pytest.mark.parametrize("name", ["double_pendulum", "four_bar", "satellite"])
def test_what_is_told_is_so(name: str) -> None:
    """Fewer operations, and kernels of projections where it says so."""
    kernels, counts = {}, {}
    for way in ("lie", "joint"):
        scenario = resolve(SCENARIOS / f"{name}.toml", overrides=STAGE | {"integrator.coordinates": way})
        kernels = runner.operation_counts(scenario)
        counts[way] = sum(kernels[key]["operations"] for key in kernels if key not in ("observe", "schur"))
    assert ("nothing has to be projected" in told(name)) == (not {"position", "velocity"} & kernels.keys())
    assert counts["lie"] > 2.5 * counts["joint"]


def test_validate_and_info_tell_it() -> None:
    sentence = told("double_pendulum")
    for command in ("validate", "info"):
        lines = CliRunner().invoke(app, [command, str(SCENARIOS / "double_pendulum.toml")]).stdout.splitlines()
        assert [line.split(":", 1)[1].strip() for line in lines if line.startswith("hint:")] == [sentence]
