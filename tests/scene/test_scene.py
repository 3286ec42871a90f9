"""What is shown of a dataset in motion: where joints are, which runs, and from where their courses come."""

from typing import Any

import numpy as np
import pytest

import lienumba
from lienumba import ScenarioError
from lienumba.batch import statuses
from lienumba.scenario.reading.loading import load
from lienumba.scenario.start.build import geometry
from lienumba.scene import MovingRun, Scene, scene
from lienumba.scene.mechanism import AXIS, ROD, Segment
from lienumba.scene.scene import window
from tests.rigs.places import SCENARIOS
from tests.rigs.sweeps import loop, top
from tests.scene.gallery import gallery


def joints_of(shown: Scene) -> dict[str, list[Any]]:
    """The places of each joint of the first run."""
    found: dict[str, list[Any]] = {}
    for mark in shown.runs[0].mechanism.marks:
        found.setdefault(mark.name, []).append((mark.type, mark.place))
    return found


def rod_of(run: MovingRun) -> Segment:
    (rod,) = [line for line in run.mechanism.segments if (line.kind, line.name) == (ROD, "tie")]
    return rod


@pytest.mark.parametrize("name", ["four_bar", "satellite", "screw_press", "bennett"])
def test_joints_are_where_the_bodies_meet(name):
    shown = scene(gallery(name))
    run = shown.runs[0]
    met = 0
    for joint in joints_of(shown).values():
        if joint[0][0] in ("spherical", "revolute", "universal", "fixed"):
            first, second = np.moveaxis(run.at([place for _, place in joint]), 1, 0)
            assert first == pytest.approx(second, abs=1e-6)
            met += 1
    assert met > 0


def test_axes_are_those_of_both_bodies():
    """Of a hinge the one line that is drawn with the first body lies on the second one, too."""
    ds = gallery("bennett")
    run = scene(ds).runs[0]
    reaction_points = {mark.name: mark.place for mark in run.mechanism.marks}
    axes = [line for line in run.mechanism.segments if line.kind == AXIS]
    assert {line.name for line in axes} == {"hinge1", "hinge2", "hinge3", "hinge4"}
    for line in axes:
        low, high, point = np.moveaxis(run.at([*line.ends, reaction_points[line.name]]), 1, 0)
        assert 0.5 * (low + high) == pytest.approx(point, abs=1e-6)
        direction = (high - low) / np.linalg.norm(high - low, axis=1)[:, None]
        for body in {place.body for place in line.ends} - {-1}:
            seen = np.einsum("tji,tj->ti", run.rotations[:, body], direction)
            assert seen == pytest.approx(np.broadcast_to(seen[0], seen.shape), abs=1e-6)


def test_rods_keep_their_length():
    ds = lienumba.run(loop(runs=3))
    run = scene(ds).runs[0]
    rod = rod_of(run)
    first, second = np.moveaxis(run.at(rod.ends), 1, 0)
    lengths = np.linalg.norm(second - first, axis=1)
    assert lengths == pytest.approx(np.full(len(lengths), lengths[0]), abs=1e-6)


def test_each_run_has_its_own_numbers():
    ds = lienumba.run(loop(runs=5))
    for moving in scene(ds, count=5).runs:
        assert rod_of(moving).ends[0].point[2] == float(ds["joints.tie.points[0][2]"].sel(run=moving.run))


def test_the_nominal_run_and_the_farthest_come_first():
    data = top(runs=30)
    data["sweep"]["nominal"] = True
    ds = lienumba.run(data)
    shown = scene(ds, count=4)
    body = geometry(lienumba.engine.replay.scenario_of(ds, "the dataset"), {})[0].bodies[0]
    points = np.random.default_rng(1).normal(size=(20_000, 3))  # mass points with the moments of the body
    second = 0.5 * sum(body.inertia[:3]) - np.array(body.inertia[:3])
    points = points * np.sqrt(np.maximum(second, 0.0) / body.mass)
    places = [ds[name].sel(body="top").values for name in ("position", "rotation")]
    moved = (places[0] - places[0][0])[:, :, None] + np.einsum("rtij,nj->rtni", places[1] - places[1][0], points[:2000])
    distances = (moved**2).sum(axis=-1).mean(axis=-1).max(axis=1)
    assert [run.label for run in shown.runs[:2]] == [
        "nominal run",
        f"run {int(ds['run'][distances.argmax()])} (farthest from nominal)",
    ]
    assert len({run.run for run in shown.runs}) == 4
    worst = scene(ds, count=2, worst="max_energy_drift").runs[1]
    assert worst.label == f"run {int(ds['run'][ds['max_energy_drift'].values.argmax()])} (largest |max_energy_drift|)"


def test_a_typical_run_stands_for_a_nominal_one_that_is_missing():
    ds = lienumba.run(top(runs=30))
    first = scene(ds).runs[0]
    assert first.why == "typical"
    inputs = [x for x in ds.coords.values() if x.attrs.get("role") == "input"]
    unusual = sum(((x - x.median()) / x.std()) ** 2 for x in inputs)
    assert (unusual < unusual.sel(run=first.run)).sum() < 3


def test_a_run_that_failed_is_shown_as_far_as_it_came():
    data = loop(runs=20, projection={"max_iterations": 1, "tolerance": 3e-9})
    data["sweep"]["vary"]["bodies.left.angular_velocity[0]"] = {"distribution": "normal", "std": 1.0}
    ds = lienumba.run(data)
    failed = ds["run"].values[(ds["status"].values == statuses.NOT_CONVERGED) & (ds["end_time"].values > 0.0)]
    assert 0 < len(failed) < 20
    shown = [run for run in scene(ds, count=6).runs if not run.good]
    assert [run.run for run in shown] == [failed[0]]
    end = float(ds["end_time"].sel(run=failed[0]))
    assert shown[0].label == f"run {failed[0]} (projection not converged at {end:.4g} s)"
    assert shown[0].times[-1] <= end
    assert np.isfinite(shown[0].positions).all()


@pytest.mark.parametrize(
    "output",
    [
        {"mode": "summary", "every": 0.01},
        {"every": 0.01, "variables": ["energy"]},
        {"times": [0.02, 0.05]},
        {"every": 0.05},  # 150 rad/s: more than a turn from one to the next
    ],
)
def test_what_is_not_stored_is_simulated_again(output):
    whole = scene(lienumba.run(top(runs=4, output={"every": 0.001})), runs=[2]).runs[0]
    again = scene(lienumba.run(top(runs=4, output=output)), runs=[2]).runs[0]
    assert again.times == pytest.approx(whole.times)
    assert (again.positions == whole.positions).all()
    assert (again.rotations == whole.rotations).all()


@pytest.mark.parametrize(
    "change",
    [
        lambda ds: ds.isel(axis=[2, 1, 0]),
        lambda ds: ds.isel(axis=[1, 2, 0], body_axis=[1, 2, 0]),
        lambda ds: ds.assign(rotation=-ds["rotation"]),
        lambda ds: ds.assign(rotation=1e200 * ds["rotation"]),
    ],
)
def test_what_is_no_rotation_or_in_other_axes_is_simulated_again(change):
    ds = lienumba.run(top(runs=3, output={"every": 0.01}))
    whole, changed = (scene(x, runs=[2]).runs[0] for x in (ds, change(ds)))
    np.testing.assert_array_equal(changed.rotations[-1], whole.rotations[-1])
    np.testing.assert_array_equal(changed.positions[-1], whole.positions[-1])


def test_full_runs_are_read():
    ds = lienumba.run(top(runs=9, output={"mode": "summary", "full_runs": "3,5", "every": 0.01}))
    shown = scene(ds, runs=[5]).runs[0]
    assert (shown.positions == ds["position"].sel(full_run=5).values).all()
    assert scene(ds, count=3).runs[1].why == "farthest from typical"


def test_code_is_asked_for_only_where_it_must_run():
    ds = gallery("cam")
    assert scene(ds).runs
    with pytest.raises(ScenarioError, match=r"brings Python code, which a replay runs.*allow_code=True"):
        scene(ds.isel(time=slice(1, None)))


def test_the_view_travels_with_what_would_be_too_small():
    data = load(SCENARIOS / "thruster.toml")
    data["model"]["bodies"][0] |= {"position": [0.0, 0.0, 0.0], "velocity": [500.0, 0.0, 0.0]}
    data["sweep"]["runs"] = 3
    ds = lienumba.run(data)
    shown = scene(ds, count=2)
    assert shown.followed
    assert (shown.runs[0].positions == ds["position"].sel(run=shown.runs[0].run).values).all()
    for runs in (shown.runs[:1], shown.runs):
        middle, half = window(runs)
        for run in runs:
            (solid,) = run.mechanism.solids
            corners = run.positions + solid.vertices @ np.swapaxes(run.rotations[:, 0], 1, 2)
            assert (abs(corners - middle[:, None]) <= half[..., None]).all()
            assert (np.ptp(corners, axis=1).max(axis=1) >= 0.25 * half[:, 0]).all()
    assert not scene(gallery("rolling_disc")).followed


def test_what_cannot_be_shown_is_refused():
    ds = lienumba.run(top(runs=3))
    with pytest.raises(ScenarioError, match="has no run 77, but 3 with labels from 0 to 2"):
        scene(ds, "out.nc", runs=[77])
    nothing = ds.assign(end_time=ds["end_time"] * 0.0, status=ds["status"] * 0 + statuses.NOT_ASSEMBLED)
    with pytest.raises(ScenarioError, match=r"out.nc: no run has moved, so there is nothing to see; lienumba info"):
        scene(nothing, "out.nc")


def test_a_selection_of_bodies_is_seen_whole():
    ds = gallery("four_bar")
    some = scene(ds.isel(body=[0, 2])).runs[0]
    whole = scene(ds).runs[0]
    assert some.mechanism.bodies == whole.mechanism.bodies
    together = np.searchsorted(some.times, whole.times - 1e-9)
    assert (some.positions[together] == whole.positions).all()


def test_a_run_that_never_moved_is_refused():
    data = top(runs=3)
    data["sweep"]["vary"] = {"bodies.top.mass": {"distribution": "normal", "std": 1e9}}
    with pytest.warns(UserWarning, match="will draw a value of 0 or below"):
        ds = lienumba.run(data)
    bad = int(ds["run"][ds["status"].values == statuses.INVALID][0])
    with pytest.raises(ScenarioError, match=rf"run {bad} has not moved \(invalid sample at 0 s\); choose another"):
        scene(ds, runs=[bad])


def test_a_run_that_flew_apart_is_the_farthest():
    ds = lienumba.run(top(runs=4)).copy(deep=True)
    ds["position"].loc[{"run": 3}] *= 1e200
    assert "run 3 (farthest from typical)" in [run.label for run in scene(ds, count=2).runs]
