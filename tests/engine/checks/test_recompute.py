"""Stored runs against those of another engine."""

import numpy as np
import pytest

import lienumba
from lienumba.engine.checks.recompute import compare_run, recompute
from tests.facade import ScenarioError
from tests.rigs.pages import swept


def silent(_):
    pass


def run(label=3):
    return swept().sel(run=[label]).copy(deep=True)


def test_a_changed_number_differs_and_roundoff_does_not():
    stored, rounded = run(), run()
    rounded["velocity"].values[:] *= 1.0 + 1e-14
    found = compare_run(stored, rounded, rounded)
    assert (found.verdict, found.differs, found.run) == ("agrees", False, 3)
    stored["velocity"].values[0, 20, 1, 2] += 1e-6
    found = compare_run(stored, rounded, rounded)
    assert (found.verdict, found.worst.name, found.worst.time) == ("differs", "velocity", pytest.approx(0.2))
    assert found.worst.size == pytest.approx(1e-6)
    speeds = abs(stored["velocity"].values).max()
    assert found.worst.relative == pytest.approx(1e-6 / speeds)


def test_lost_numbers_and_other_ends_differ():
    lost, failed = run(), run()
    lost["position"].values[0, 5] = np.nan
    assert compare_run(lost, run(), run()).differs
    failed["status"].values[:] = 1
    assert compare_run(failed, run(), run()).verdict == "differs: stored as non_finite, recomputed as success"
    found = compare_run(run(), failed, run())
    assert (found.verdict, found.differs) == ("no verdict: recomputed as non_finite", False)


@pytest.mark.parametrize(("growth", "verdict"), [(1e-8, "agrees"), (1e-9, "differs"), (1e-3, "no verdict")])
def test_the_tolerance_follows_how_a_motion_amplifies_roundoff(growth, verdict):
    other, nudged = run(), run()
    other["position"].values[0, -1, 0, 0] += 3e-8
    nudged["position"].values[0, -1, 0, 0] += growth + 3e-8
    assert compare_run(run(), other, nudged).verdict.startswith(verdict)


def test_numbers_of_fewer_digits_differ_by_their_own_roundoff():
    stored, other = run(), run()
    for ds in (stored, other):
        ds["position"] = ds["position"].astype("f4")
    other["position"].values[:] *= np.float32(1 + 2**-22)
    assert compare_run(stored, other, other).verdict == "agrees"


def test_a_spherical_joint_has_torques_of_roundoff():
    other = run()
    other["joint_torque"].values[:] += 1e-13
    assert compare_run(run(), other, other).verdict == "agrees"


def test_a_large_number_without_a_unit_hides_no_rotation():
    stored, other = run(), run()
    for ds in (stored, other):
        ds["large"] = ds["energy"].copy(data=np.full(ds["energy"].shape, 1e6)).assign_attrs(units="1")
    other["rotation"].values[0, -1, 0, 0, 0] += 1e-6
    assert compare_run(stored, other, other).differs


@pytest.mark.parametrize(
    ("keys", "rule"),
    [({"integrator.coordinates": "joint"}, "other coordinates"), ({"integrator.group": "SE3"}, "other groups")],
)
def test_what_the_other_engine_does_not_support_is_refused_before_anything_runs(keys, rule):
    ds = lienumba.run("scenarios/heavy_top.toml", overrides=keys | {"integrator.end_time": 0.01, "output.every": 0.01})
    with pytest.raises(ScenarioError, match=rule) as refused:
        recompute(ds, "top.nc", 1, False, pytest.fail)
    assert "leave integrator.engine out" not in str(refused.value)


@pytest.mark.release
def test_runs_from_start_to_end():
    found = recompute(swept(), "pendel.nc", 3, False, silent)
    assert [x.run for x in found] == [-1, 19, 39]
    assert all(x.verdict == "agrees" and x.worst.relative < 1e-12 and x.tolerance == 1e-9 for x in found)
    wrong = swept().copy(deep=True)
    wrong["last_position"].loc[{"run": 19}] += 1e-7
    verdicts = [x.verdict for x in recompute(wrong, "pendel.nc", 3, False, silent)]
    assert verdicts == ["agrees", "differs", "agrees"]


@pytest.mark.release
def test_a_chaotic_motion_is_measured_by_its_own_growth():
    ds = lienumba.run("scenarios/double_pendulum.toml", runs=[0], progress=False)
    (found,) = recompute(ds, "double.nc", 1, False, silent)
    assert found.verdict == "agrees"
    assert 1e-9 < found.worst.relative < found.tolerance
