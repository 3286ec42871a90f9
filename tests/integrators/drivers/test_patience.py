"""Runs that would never be done end with a status; runs with as many steps that get on do not."""

import numpy as np
import pytest

import lienumba
from lienumba.batch.statuses import STATUSES, STEP_TOO_SHORT
from tests.rigs.inputs import at_hinge

BS32 = {"method": "bs32", "tolerance": 1e-5, "min_step": 1e-300}


def test_a_run_that_creeps_ends() -> None:
    """A torque that swings 1e10 times within the run, from a time on."""
    system = at_hinge("where(t > late, 1e9*sin(1e10*t), 0)").parameter("late", 9.0)
    system.vary("parameters.late", "choice", values=[0.5, 9.0])
    more = {"integrator": {"end_time": 1.0, **BS32}, "output.every": 0.25, "sweep.runs": 8, "sweep.seed": 2}
    ds = lienumba.run(system, overrides=more)
    late = ds["parameters.late"].values > 1.0
    assert 0 < late.sum() < 8
    np.testing.assert_array_equal(ds.status, np.where(late, 0, STEP_TOO_SHORT))
    assert (ds.steps.values[~late] > 50_000).all()
    np.testing.assert_array_equal(np.isnan(ds["hinge_at.angle"]).sum("time"), np.where(late, 0, 2))
    sentence = next(status.sentence for status in STATUSES if status.code == STEP_TOO_SHORT)
    assert "or for 100,000 within a thousandth of the run" in sentence


@pytest.mark.usefixtures("vectors")
def test_a_long_run_does_not() -> None:
    more = {"integrator": {"end_time": 0.5, **BS32, "max_step": 5e-7}, "output.every": 0.25}
    ds = lienumba.run(at_hinge("0.1"), overrides=more)
    assert int(ds.status[0]) == 0
    assert int(ds.steps[0]) >= 1_000_000
