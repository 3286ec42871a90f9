"""Steps that a tolerance chooses: errors as asked for, no run felt by another, no step moved by an output."""

import copy
from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

import lienumba
from lienumba.batch import statuses
from lienumba.integrators.tracing import step_kernels
from lienumba.scenario.system import System
from tests.facade import METHODS
from tests.integrators.drivers.test_discontinuities import END, TIMES, exact, off, rod
from tests.rigs.places import SCENARIOS
from tests.rigs.scenarios import TOP, chain

ARM = SCENARIOS / "arm_sampled.toml"
PAIRS = [name for name, tableau in METHODS.items() if tableau.errors]
TOLERANCES = {"bs32": range(4, 9), "dp54": range(4, 13), "tsit54": range(4, 13), "dop853": range(4, 13)}
SWEEP: dict[str, Any] = {
    "runs": 21,
    "seed": 3,
    "vary": {
        "bodies.top.mass": {"distribution": "normal", "std": 0.2, "relative": True},
        "bodies.top.angular_velocity[1]": {"distribution": "uniform", "low": 5.0, "high": 200.0},
    },
}


def run(data: dict[str, Any], overrides: Any = None, **options: Any) -> Any:
    return lienumba.run(data, overrides=overrides, **{"workers": 1, **options})


def top(tolerance: Any = 1e-9, end: float = 0.5, **keys: Any) -> dict[str, Any]:
    data = copy.deepcopy(TOP)
    data["integrator"] = {"end_time": end, "tolerance": tolerance, **keys}
    return data | {"output": {"every": end / 4}}


@cache
def reference(end: float = 0.5) -> Any:
    return run(top(1e-14, end))


def distance(ds: Any, truth: Any) -> float:
    """Of the states at the end, the speeds relative to their size; rotations as angles."""
    here, there = ds.isel(run=0, time=-1), truth.isel(run=0, time=-1)
    off = [np.abs(here.position - there.position).max(), np.abs(here.rotation - there.rotation).max()]
    off += [np.linalg.norm(here[n] - there[n]) / np.linalg.norm(there[n]) for n in ("velocity", "angular_velocity")]
    return float(max(off))


def equal(a: Any, b: Any) -> bool:
    """All numbers to the bit."""
    numbers = [name for name in a.data_vars if a[name].dtype.kind in "fi"]
    return all(np.array_equal(a[name], b[name], equal_nan=a[name].dtype.kind == "f") for name in numbers)


@pytest.mark.parametrize("method", TOLERANCES)
def test_the_error_is_proportional_to_the_tolerance(method):
    """Monotone, and within two decades of it; over the paper's two seconds, but for the pair of order 3, whose many
    steps add up to more."""
    errors, end = {}, 0.5 if method == "bs32" else 2.0
    for digits in TOLERANCES[method]:
        ds = run(top(10.0**-digits, end=end, method=method))
        assert int(ds.status[0]) == statuses.SUCCESS
        errors[digits] = distance(ds, reference(end))
    values = list(errors.values())
    assert all(later < earlier for earlier, later in pairwise(values))
    assert all(1e-2 < error / 10.0**-digits < 1e2 for digits, error in errors.items()), errors


def test_an_absolute_tolerance_may_be_looser_than_the_relative_one():
    absolute = {"position": 1.0, "velocity": 1e2, "angular_velocity": 1e3}
    only_rotation = run(top({"relative": 1e-9, "absolute": absolute}))
    all_kinds, coarse = run(top(1e-9)), run(top({"relative": 1e-9, "absolute": absolute | {"rotation": 1e-5}}))
    assert int(coarse.steps[0]) < 0.6 * int(only_rotation.steps[0]) <= 0.6 * int(all_kinds.steps[0]) + 1
    assert distance(only_rotation, reference()) < 1e-7


@pytest.mark.parametrize(("method", "tolerance"), [("bs32", 1e-5), ("dp54", 1e-7), ("tsit54", 1e-7), ("dop853", 1e-9)])
def test_between_steps_the_extension_is_as_exact_as_the_steps(method, tolerance):
    fine = top(tolerance, end=0.1, method=method) | {"output": {"every": 0.001}}
    truth = run(fine | {"integrator": {"end_time": 0.1, "step": 2e-4, "method": "dop853"}})
    ds = run(fine)
    assert int(ds.steps[0]) < 101  # there are times between steps
    for name, size in (("position", 1.0), ("rotation", 1.0), ("angular_velocity", 150.0), ("joint_force", 4000.0)):
        assert np.abs(ds[name] - truth[name]).max() < 30 * tolerance * size, name
    assert ds.position_violation.max() < 1e-11  # what is stored is projected
    assert ds.velocity_violation.max() < 1e-13


def test_outputs_move_no_step():
    few, many = run(top(), {"output.every": 0.5}), run(top(), {"output.every": 0.001})
    listed = run(top(), {"output.times": [0.123456789, 0.5]})
    assert int(few.steps[0]) == int(many.steps[0]) == int(listed.steps[0])
    for ds in (many, listed):
        assert np.array_equal(ds.rotation.sel(time=0.5), few.rotation.sel(time=0.5))
    assert float(listed.time[0]) == 0.123456789


def test_no_run_feels_another():
    """More runs than lanes, of different numbers of steps: lanes are filled again."""
    data = top(1e-8) | {"sweep": SWEEP}
    alone, pair = run(data), run(data, workers=2)
    assert len(set(alone.steps.values.tolist())) > 10
    assert equal(alone, pair)
    some = run(data, runs=[17, 3, 20])
    assert equal(alone.sel(run=[17, 3, 20]), some)
    more = run(data, {"sweep.runs": 30})
    assert equal(alone, more.isel(run=slice(21)))


def test_a_run_that_fails_harms_no_other():
    data = copy.deepcopy(top(1e-8)) | {"sweep": copy.deepcopy(SWEEP)}
    data["parameters"] = {"late": 10.0}
    data["model"]["forces"] = [{"name": "burst", "type": "force", "body": "top",
                                "value": [0, 0, "1e-3*log(late - t)"]}]  # fmt: skip
    data["sweep"]["vary"]["parameters.late"] = {"distribution": "uniform", "low": 0.1, "high": 1.5}
    ds = run(data)
    failed = ds.status.values != statuses.SUCCESS
    assert 3 <= failed.sum() < 15
    assert set(ds.status.values[failed].tolist()) == {statuses.NON_FINITE}
    late = ds["parameters.late"].values
    np.testing.assert_allclose(ds.end_time.values[failed], late[failed], atol=1e-6)
    assert np.isnan(ds.position.values[failed, -1]).all()
    assert np.isfinite(ds.position.values[~failed]).all()
    assert equal(ds.isel(run=~failed), run(data, runs=np.flatnonzero(~failed).tolist()))
    assert (ds.rejected_steps.values[failed] > 5).all()


def test_a_step_may_be_too_short():
    ds = run(top(1e-10, method="bs32", min_step=1e-4))
    assert int(ds.status[0]) == statuses.STEP_TOO_SHORT
    assert float(ds.end_time[0]) < 0.5
    assert np.isnan(ds.position[0, -1]).all()


def test_first_and_longest_steps_are_as_asked():
    ds = run(top(1e-3, max_step=1e-3))
    assert int(ds.steps[0]) == pytest.approx(500, abs=5)
    slow = run(top(1e-6, first_step=1e-12)), run(top(1e-6))
    assert 0 < int(slow[0].steps[0]) - int(slow[1].steps[0]) < 25  # a factor of six at a time
    assert int(run(top(1e-6, first_step=0.4)).rejected_steps[0]) >= 2


@pytest.mark.parametrize("method", ["bs32", "dop853"])
def test_stages_apart_are_the_same_step(method, monkeypatch):
    data = chain(3) | {"integrator": {"end_time": 0.2, "tolerance": 1e-7, "method": method}, "output": {"every": 0.01}}
    inline = run(data)
    monkeypatch.setattr(step_kernels, "INLINE", 0)
    apart = run(data)
    assert inline.steps.values == apart.steps.values
    for name in ("position", "rotation", "velocity", "angular_velocity", "joint_force"):
        assert np.abs(inline[name] - apart[name]).max() < 1e-9 * max(1.0, float(np.abs(inline[name]).max())), name


@pytest.mark.parametrize("kind", ["hold", "linear"])
@pytest.mark.parametrize("method", ["tsit54", "dop853"])
def test_steps_land_where_something_jumps(kind, method):
    """Otherwise each jump costs a dozen rejected steps, and the error is what the last of these leaves."""
    data = rod(0.01, kind)
    data["integrator"] = {"end_time": END, "tolerance": 1e-10, "method": method}
    ds = run(data)
    assert off(ds, exact(kind)).max() < 1e-8
    assert int(ds.rejected_steps[0]) <= 2 * len(TIMES)


def test_every_lane_lands_on_its_own_times():
    data = rod(0.01, "hold", value="2*push(t - delay)", parameters={"delay": 0.0})
    data["integrator"] = {"end_time": END, "tolerance": 1e-10}
    data["sweep"] = {"runs": 9, "vary": {"parameters.delay": {"distribution": "uniform", "low": 0.0, "high": 0.05}}}
    ds = run(data)
    truths = [exact("hold", float(delay)) for delay in ds["parameters.delay"].values[:3]]
    assert off(ds.isel(run=slice(3)), *truths).max() < 1e-8


@pytest.mark.parametrize("how", [{"tolerance": 1e-11}, {"step": 1e-3, "method": "dop853"}])
def test_what_a_sampled_law_holds_is_stored_behind_the_sample(how):
    """Where samples and outputs meet, whichever driver makes the steps."""
    base = {"integrator.end_time": 0.3, "output.every": 0.015, "sweep.runs": 2}
    known = run(ARM, {**base, "integrator.step": 1e-3, "integrator.method": "dop853"})
    watched = System.from_toml(ARM).event("never", "sin(t) > 2")
    other = run(watched, {**base, **{f"integrator.{key}": value for key, value in how.items()}})
    for name in ("shoulder_motor.integral", "elbow_motor.integral", "position"):
        assert np.abs(known[name] - other[name]).max() < 1e-9, name
