"""A run never feels its neighbours: lanes that fail, blow up or need more iterations move no bit elsewhere."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest

from lienumba.batch import statuses
from tests.rigs.sweeps import SWEEPS, a_rod, assert_same, edit_samples, linkage, links, loop, run, top

SPIN, ROCK = "bodies.top.angular_velocity[1]", "bodies.left.angular_velocity[0]"
SWING, TURN = "joints.hinge1.rate", "bodies.wheel.angular_velocity[2]"
EDITS: list[tuple[str, dict[int, dict[str, float]]]] = [
    ("top", {3: {SPIN: 1e9}}),
    ("top", {0: {SPIN: 1e5}, 7: {SPIN: -1e300}, 12: {SPIN: np.inf}}),
    ("top", {3: {"bodies.top.mass": np.nan}, 9: {"bodies.top.mass": -1.0}, 10: {"bodies.top.mass": 1e-300}}),
    ("top", {5: {"bodies.top.inertia[0]": 1e308}, 6: {"joints.pivot.points[1][1]": np.nan}}),
    ("links", {2: {"bodies.link4.angular_velocity[1]": 1e7}, 4: {"bodies.link0.mass": 1e-310}}),
    ("links", {11: {"joints.hinge1.points[1][2]": np.inf}, 12: {"bodies.link2.inertia[4]": 1e9}}),
    ("loop", {8: {"gravity[0]": 1e200}, 15: {"gravity[0]": np.nan}}),
    ("linkage", {3: {SWING: np.nan}, 9: {SWING: 1e5}, 14: {"gravity[1]": 1e200}}),
    ("wheel", {0: {TURN: 200.0}, 1: {TURN: 4e3}, 12: {"bodies.wheel.mass": np.nan}}),
    ("loop", {1: {ROCK: 60.0}, 2: {ROCK: 1e4}, 13: {"joints.tie.points[0][2]": 50.0}}),
]


@pytest.mark.parametrize(("name", "edits"), EDITS, ids=[f"{name} {edits}" for name, edits in EDITS])
def test_a_broken_lane_leaves_the_bits_of_the_others(
    name: str, edits: Mapping[int, Mapping[str, float]], monkeypatch: pytest.MonkeyPatch
) -> None:
    data = (SWEEPS | {"linkage": linkage})[name]()
    healthy = run(data)
    assert (healthy["status"] == 0).all()
    edit_samples(monkeypatch, edits)
    broken = run(data)
    others = [label for label in healthy["run"].values if label not in edits]
    assert_same(broken.sel(run=others), healthy.sel(run=others))
    marked = broken.sel(run=list(edits))
    assert not np.array_equal(marked["velocity"], healthy["velocity"].sel(run=list(edits)))
    for label in edits:
        one = marked.sel(run=label)
        assert (int(one["status"]) == 0) == np.isfinite(one["position"].values).all()
        assert np.isfinite(one["position"].values[one["time"].values <= float(one["end_time"])]).all() or (
            int(one["status"]) in (statuses.INVALID, statuses.NOT_ASSEMBLED)
        )
    assert (marked["status"] != 0).any()


def test_a_lane_that_needs_more_iterations_changes_no_other(monkeypatch: pytest.MonkeyPatch) -> None:
    """The neighbours were done before and must not take part in what is iterated further."""
    data = loop(output={"every": 0.02})
    calm = run(data)
    edit_samples(monkeypatch, {3: {ROCK: 30.0}})
    wild = run(data)
    more = wild["position_iterations"].sel(run=3) - wild["position_iterations"].drop_sel(run=3).isel(
        run=slice(0, 7)
    ).max("run")
    assert (more.isel(time=slice(1, None)) >= 0).all()
    assert more.max() >= 1
    assert (wild["status"] == 0).all()
    assert_same(wild.drop_sel(run=3), calm.drop_sel(run=3))


def test_a_lane_that_needs_other_rows_changes_no_other(monkeypatch: pytest.MonkeyPatch) -> None:
    """It goes again, in a block with others than before; those that went again before go beside others now."""
    slow = {label: {SWING: 1.0 + 0.05 * label} for label in range(20)}
    edit_samples(monkeypatch, slow)
    calm = run(linkage())
    edit_samples(monkeypatch, {3: {SWING: 9.0}, 4: {SWING: 8.0}})
    swift = run(linkage())
    assert (swift["status"] == 0).all()
    assert_same(swift.drop_sel(run=[3, 4]), calm.drop_sel(run=[3, 4]))
    edit_samples(monkeypatch, {3: {SWING: 1.0}})
    assert_same(run(linkage()).sel(run=[4]), swift.sel(run=[4]))


def test_a_lane_that_fails_in_the_middle(monkeypatch: pytest.MonkeyPatch) -> None:
    """The others of its block go on to the end, past the outputs after its failure."""
    data = top(end=0.2)
    healthy = run(data)
    edit_samples(monkeypatch, {2: {SPIN: 2900.0}})
    broken = run({**data, "projection": {**data["projection"], "max_iterations": 1}})
    assert int(broken["status"].sel(run=2)) == statuses.NOT_CONVERGED
    assert (broken["status"].drop_sel(run=2) == 0).all()
    assert_same(broken.drop_sel(run=2), healthy.drop_sel(run=2))


def test_a_run_that_cannot_be_assembled(monkeypatch: pytest.MonkeyPatch) -> None:
    """The others are done long before the assembly gives it up."""
    data = a_rod(runs=20)
    healthy = run(data)
    edit_samples(monkeypatch, {7: {"joints.near.length": 9.0}})
    broken = run(data)
    assert int(broken["status"].sel(run=7)) == statuses.NOT_ASSEMBLED
    assert_same(broken.drop_sel(run=7), healthy.drop_sel(run=7))


LAW = """
from lienumba.laws import sqrt

def fading(top, t, late):
    return top.torque((0, 0, 1e-3*sqrt(late - t)))
"""
TORQUE = {"name": "own", "type": "torque", "body": "top"}
FADING = {"name": "own", "type": "python", "function": "fading.py:fading", "bodies": ["top"],
          "parameters": {"late": "late"}}  # fmt: skip
UNDEFINED: dict[str, tuple[dict[str, Any], float, float]] = {  # a force, of which value of `late`, and since when
    "law": (FADING, 0.0125, 0.0125),
    "formula": (TORQUE | {"value": [0, 0, "1e-3*sqrt(late - t)"]}, 0.0125, 0.0125),
    "division": (TORQUE | {"value": [0, 0, "1e-3/late"]}, 0.0, 0.0),
}


@pytest.mark.parametrize("name", UNDEFINED)
@pytest.mark.parametrize("pace", [{"step": 1e-3}, {"tolerance": 1e-6, "method": "tsit54"}])
def test_a_force_that_is_undefined_in_any_lane(
    name: str, pace: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    """That run fails, where its force ends, and no other is moved, whichever lane it is in."""
    force, late, end = UNDEFINED[name]
    data = top(runs=8, output={"times": [0.0, 0.01, 0.05]}) | {"files": {"fading.py": LAW}, "parameters": {"late": 1.0}}
    del data["integrator"]["step"]
    data["integrator"] |= pace
    data["model"]["forces"] = [force]
    data["sweep"]["vary"]["parameters.late"] = {"distribution": "uniform", "low": 0.5, "high": 1.0}
    healthy = run(data)
    assert (healthy["status"] == 0).all()
    for lane in range(8):
        with monkeypatch.context() as patch:
            edit_samples(patch, {lane: {"parameters.late": late}})
            broken = run(data)
        assert_same(broken.drop_sel(run=lane), healthy.drop_sel(run=lane))
        one = broken.sel(run=lane)
        assert int(one["status"]) in (statuses.NON_FINITE, statuses.STEP_TOO_SHORT)
        assert end - 1e-3 < float(one["end_time"]) <= end
        assert np.isfinite(one["last_velocity"]).all()
        assert np.isfinite(one["velocity"].sel(time=0.01)).all() == (end > 0.01)


def test_edges_of_a_block(monkeypatch: pytest.MonkeyPatch) -> None:
    """The last run is repeated to fill its block: if it fails, so do its copies, and they are not counted."""
    edit_samples(monkeypatch, {19: {"bodies.link4.angular_velocity[1]": 1e8}})
    failures = []

    def listen(event: Any) -> None:
        failures.append((event.stage, event.done, event.total, event.failed))

    broken = run(links(runs=20), progress=listen)
    assert int((broken["status"] != 0).sum()) == 1
    assert failures[-1] == ("run", 20, 20, 1)
