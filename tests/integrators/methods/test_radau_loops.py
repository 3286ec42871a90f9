"""Stage systems that are eliminated by loops: the same motion as by straight-line code, but for rounding."""

from typing import Any

import numpy as np
import pytest

import lienumba
from lienumba.integrators.tracing.implicit import stage_system
from tests.laws.rigs import own, pair
from tests.rigs.places import SCENARIOS


def both(scenario: Any, overrides: dict[str, Any], monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    found = []
    for loops in (10**9, 0):
        monkeypatch.setattr(stage_system, "LOOPS", loops)
        found.append(lienumba.run(scenario, overrides=overrides, progress=False))
        assert (found[-1].status == 0).all()
    return found


@pytest.mark.parametrize("method", ["radau3", "radau5", "radau9", "generalized_alpha"])
def test_a_top_with_steps_of_given_length(method: str, monkeypatch: pytest.MonkeyPatch) -> None:
    ways = {"integrator.method": method, "integrator.end_time": 0.05, "output.every": 0.01}
    straight, loops = both(SCENARIOS / "heavy_top.toml", ways, monkeypatch)
    for name in ("position", "rotation", "angular_velocity", "joint_force"):
        scale = float(abs(straight[name]).max())
        assert float(abs(loops[name] - straight[name]).max()) < 1e-11 * scale, name
    assert (loops.steps == straight.steps).all()


def test_steps_with_an_error_that_is_estimated_and_friction_that_sticks(monkeypatch: pytest.MonkeyPatch) -> None:
    ways = {"integrator.method": "radau5", "integrator.tolerance": 1e-6, "integrator.end_time": 1.6, "sweep.runs": 3}
    straight, loops = both(SCENARIOS / "brake.toml", ways, monkeypatch)
    assert (straight.mode.values == loops.mode.values).all()
    assert (straight.steps == loops.steps).all()
    np.testing.assert_allclose(loops["drum.rate"], straight["drum.rate"], rtol=0, atol=1e-10)


def test_laws_with_states(monkeypatch: pytest.MonkeyPatch) -> None:
    pid = own(
        "pid", joints=["shoulder"], parameters={"kp": 30, "kd": 2, "target": 1, "ki": 25}, states={"integral": 0.1}
    )
    data = pair(pid, end=0.02)
    data["integrator"]["method"] = "radau5"
    straight, loops = both(data, {}, monkeypatch)
    for name in ("position", "angular_velocity", "own.integral"):
        np.testing.assert_allclose(loops[name], straight[name], rtol=0, atol=1e-11, err_msg=name)
