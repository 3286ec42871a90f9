"""Comparisons of two engines on the same samples."""

import numpy as np
import pytest
from typer.testing import CliRunner

import lienumba
from lienumba.engine.checks.engines import check, compare
from tests.facade import ScenarioError, app

SWEEP = "scenarios/heavy_top_monte_carlo.toml"


def silent(_):
    pass


@pytest.mark.release
def test_the_first_runs_of_a_sweep_agree():
    found = check(SWEEP, runs=3, steps=20, tell=silent)
    assert found.agrees
    assert found.headline == "3 of 3 runs, 60 of 60 steps of rk4 compared"
    assert found.differences[0].relative < 1e-12
    assert {"position", "rotation", "energy", "joint_force"} <= {x.name for x in found.differences}


@pytest.mark.release
def test_a_dataset_brings_its_own_samples(tmp_path):
    short = {"integrator.end_time": 0.02, "output.every": 0.01, "sweep.runs": 4}
    lienumba.run(SWEEP, overrides=short, output=tmp_path / "sweep.nc", progress=False)
    found = check(tmp_path / "sweep.nc", runs=8, steps=10, tell=silent)
    assert found.agrees
    assert found.headline == "4 of 4 runs, 40 of 40 steps of rk4 compared"


def test_runs_that_fail_before_anything_is_compared_do_not_agree():
    keys = {"integrator.step": 0.5, "integrator.end_time": 1.0, "output.every": 0.5}
    one = lienumba.run("scenarios/heavy_top.toml", overrides=keys, progress=False)
    found = compare(one, one, 0.5, "rk4")
    assert not found.agrees
    assert found.headline == "0 of 1 run, 0 of 2 steps of rk4 compared"
    assert found.sentence.startswith("nothing was compared: run 0 ends as rotation_too_large, before the first")


def test_what_the_other_engine_does_not_support_is_refused_before_anything_runs():
    with pytest.raises(ScenarioError, match='the engine "numba" does not support'):
        check("scenarios/heavy_top.toml", 1, 10, pytest.fail, {"integrator.group": "SE3"})


def test_a_difference_is_told_with_its_run_and_time():
    one = lienumba.run(
        SWEEP, overrides={"integrator.end_time": 0.02, "output.every": 0.01}, runs=[4, 7], progress=False
    )
    other = one.copy(deep=True)
    other.velocity.values[1, 2, 0, 0] += 1e-3
    found = compare(one, other, 1e-3, "rk4")
    assert not found.agrees
    worst = found.differences[0]
    assert (worst.name, worst.run, worst.time) == ("velocity", 7, 0.02)
    assert worst.size == pytest.approx(1e-3)
    assert "the engines do not agree: velocity differs by" in found.sentence
    other.status.values[0] = 3
    assert compare(one, other, 1e-3, "rk4").sentence == "run 4 ends otherwise: the engines do not agree"
    lost = one.copy(deep=True)
    lost.position.values[0, 1] = np.nan
    assert not compare(one, lost, 1e-3, "rk4").agrees


@pytest.mark.release
def test_the_command_prints_the_differences_and_refuses_what_it_cannot_compare():
    done = CliRunner().invoke(app, ["check", "scenarios/heavy_top.toml", "--steps", "10", "--quiet"])
    assert done.exit_code == 0
    done = CliRunner().invoke(app, ["check", "scenarios/heavy_top.toml", "--steps", "10"])
    assert "the engines agree" in done.output
    with pytest.raises(ScenarioError, match="steps of one length"):
        check("scenarios/bouncing_ball.toml", 1, 10, silent)
