"""Every way in which a run may end is provoked; what is stored of a failed run, and the exit that it gives."""

from typing import Any

import numpy as np
import pytest

import lienumba
from lienumba.batch import statuses
from lienumba.integrators import codes
from lienumba.integrators.tracing import step_kernels
from tests.facade import ScenarioError
from tests.integrators.methods.test_radau import bars
from tests.rigs.sweeps import a_rod, edit_samples, loop, run, top, two_rods

pytestmark = pytest.mark.usefixtures("step")
SPIN, ROCK = "bodies.top.angular_velocity[1]", "bodies.left.angular_velocity[0]"
STATE = ("position", "rotation", "velocity", "angular_velocity", "energy", "position_iterations")


@pytest.fixture(params=["in one kernel", "stage by stage"])
def step(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Small and large mechanisms step, and fail, on paths of their own."""
    if request.param == "stage by stage":
        monkeypatch.setattr(step_kernels, "INLINE", 0)


def a_fall(step: float, **sections: Any) -> dict[str, Any]:
    """A free body that does not turn."""
    data = top(runs=20, end=40 * step, output={"every": step}, **sections)
    data["integrator"]["step"] = step
    data["model"]["joints"] = []
    data["model"]["bodies"][0].update(position=[0, 0, 0], velocity=[0, 0, 0], angular_velocity=[0, 0, 0])
    data["sweep"]["vary"] = {"gravity[2]": {"distribution": "normal", "std": 0.01}}
    return data


def check_failed(dataset: Any, label: int, code: int, *, last_good_step: int, step: float = 1e-3) -> None:
    """The run has this status; its data are good up to its end time, and NaN after it."""
    failed = dataset.sel(run=label)
    assert int(failed["status"]) == code
    assert int(failed["steps"]) == last_good_step
    assert float(failed["end_time"]) == pytest.approx(last_good_step * step, rel=1e-12)
    before = failed["time"].values <= float(failed["end_time"]) * (1 + 1e-12)
    for name in STATE:
        finite = np.isfinite(failed[name].values).reshape(len(before), -1)
        assert finite[before].all(), name
        assert np.isnan(failed[name].values[~before]).all(), name
    others = dataset.drop_sel(run=label)
    assert (others["status"] == 0).all()
    assert (others["end_time"] == float(dataset["time"][-1])).all()
    for name in STATE:
        assert np.isfinite(others[name]).all(), name


@pytest.mark.parametrize("method", ["rk4", "dop853"])
def test_stiffness_is_named_where_it_ends_runs(method: str) -> None:
    ways = {"integrator.method": method, "integrator.step": 0.01, "output.every": 0.32}
    code = int(lienumba.run(bars(1e7, 100.0), overrides=ways).status[0])
    (status,) = (x for x in statuses.STATUSES if x.code == code)
    assert code == statuses.ROTATION
    assert statuses.IMPLICIT in status.sentence
    ended = (statuses.NON_FINITE, statuses.NOT_CONVERGED, statuses.STEP_TOO_SHORT)  # stiff mechanisms do so as well
    assert all(statuses.IMPLICIT in x.sentence for x in statuses.STATUSES if x.code in ended)


def test_the_drivers_codes_are_statuses() -> None:
    assert (codes.NON_FINITE, codes.NOT_CONVERGED, codes.SINGULAR, codes.ROTATION, codes.TOO_SHORT, codes.STOPPED) == (
        statuses.NON_FINITE, statuses.NOT_CONVERGED, statuses.SINGULAR, statuses.ROTATION, statuses.STEP_TOO_SHORT,
        statuses.STOPPED,
    )  # fmt: skip
    assert [status.code for status in statuses.STATUSES] == [*range(7), *range(8, 20)]
    assert (codes.PUSHED, codes.CONTRADICTS, codes.VIOLATED) == (
        statuses.PUSHED, statuses.CONTRADICTS, statuses.VIOLATED,
    )  # fmt: skip
    assert codes.RESELECT == 7  # such a run goes again


def test_the_dataset_names_its_statuses() -> None:
    attributes = run(top(runs=1))["status"].attrs
    assert attributes["flag_meanings"].split() == [status.name for status in statuses.STATUSES]
    np.testing.assert_array_equal(attributes["flag_values"], [*range(7), *range(8, 20)])


@pytest.mark.parametrize("spin", [1e4, -1e5, 1e8])
def test_rotation_too_large(spin: float, monkeypatch: pytest.MonkeyPatch) -> None:
    edit_samples(monkeypatch, {5: {SPIN: spin}})
    check_failed(run(top(runs=20)), 5, statuses.ROTATION, last_good_step=0)


def test_a_stage_may_turn_by_five_radians_but_not_by_six(monkeypatch: pytest.MonkeyPatch) -> None:
    free = {"position": "none", "velocity": "none"}
    edit_samples(monkeypatch, {0: {SPIN: 5800.0}, 1: {SPIN: 6000.0}})
    dataset = run(top(runs=3, end=0.001, output={"every": 0.001}, projection=free))
    assert dataset["status"].values.tolist() == [statuses.SUCCESS, statuses.ROTATION, statuses.SUCCESS]


def test_a_stage_counts_even_where_the_whole_step_turns_less(monkeypatch: pytest.MonkeyPatch) -> None:
    """Heun's second stage turns by 6 rad; gravity all but stops the body meanwhile, so that the step turns by 3."""
    data = top(runs=3, end=0.001, output={"every": 0.001}, projection={"position": "none", "velocity": "none"})
    data["integrator"]["method"] = "heun"
    data["model"]["bodies"][0]["angular_velocity"] = [6000, 0, 0]
    data["sweep"]["vary"] = {"gravity[2]": {"distribution": "normal", "std": 0.01}}
    edit_samples(monkeypatch, {1: {"gravity[2]": -6e6}})
    heavy = run(data)
    assert heavy["status"].values.tolist() == [statuses.ROTATION] * 3
    data["model"]["bodies"][0]["angular_velocity"] = [5800, 0, 0]
    slower = run(data)
    assert slower["status"].values.tolist() == [statuses.SUCCESS] * 3
    assert float(slower["angular_velocity"].sel(run=1)[-1, 0, 0]) < 2000


@pytest.mark.parametrize("weight", [1e200, -1e306])
def test_non_finite(weight: float, monkeypatch: pytest.MonkeyPatch) -> None:
    data = top(runs=20)
    data["sweep"]["vary"]["gravity[2]"] = {"distribution": "normal", "std": 0.01}
    edit_samples(monkeypatch, {11: {"gravity[2]": weight}})
    dataset = run(data)
    failed = dataset.sel(run=11)
    assert int(failed["status"]) in (statuses.NON_FINITE, statuses.ROTATION)
    assert int(failed["steps"]) == 0
    assert failed["position"].isel(time=slice(1, None)).isnull().all()
    assert (dataset["status"].drop_sel(run=11) == 0).all()


def test_non_finite_where_nothing_turns(monkeypatch: pytest.MonkeyPatch) -> None:
    edit_samples(monkeypatch, {11: {"gravity[2]": 1e200}})
    check_failed(run(a_fall(1e-3)), 11, statuses.NON_FINITE, last_good_step=0)


def test_non_finite_in_the_middle_of_a_run(monkeypatch: pytest.MonkeyPatch) -> None:
    """The step's algebra element has the length g h sqrt(1 + h^2 (n + 1/2)^2), and its square must stay below 1e300."""
    edit_samples(monkeypatch, {11: {"gravity[2]": 4e148}})
    check_failed(run(a_fall(1.0)), 11, statuses.NON_FINITE, last_good_step=25, step=1.0)


def tame_loops(iterations: int, std: float = 0.2) -> dict[str, Any]:
    data = loop(runs=20, projection={"max_iterations": iterations, "tolerance": 1e-9}, output={"every": 0.02})
    data["sweep"]["vary"][ROCK] = {"distribution": "normal", "std": std}
    return data


def test_projection_not_converged(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two iterations are enough for tame runs, not for a wild one."""
    edit_samples(monkeypatch, {3: {ROCK: 30.0}})
    assert (run(tame_loops(10))["status"] == 0).all()
    check_failed(run(tame_loops(2)), 3, statuses.NOT_CONVERGED, last_good_step=0, step=0.02)


def test_every_run_ends_where_it_needs_one_iteration_more() -> None:
    good, bad = run(tame_loops(10, std=1.0)), run(tame_loops(1, std=1.0))
    needed = good["position_iterations"].values
    last = np.argmax(needed > 1, axis=1) - 1
    assert len(set(last)) > 1
    assert max(last) > 0
    assert (bad["status"] == statuses.NOT_CONVERGED).all()
    np.testing.assert_array_equal(bad["steps"], last)
    for label, step in enumerate(last):
        for name in STATE:
            stored = bad[name].values[label]
            np.testing.assert_array_equal(stored[: step + 1], good[name].values[label, : step + 1])
            assert np.isnan(stored[step + 1 :]).all()


def test_singular_constraints(monkeypatch: pytest.MonkeyPatch) -> None:
    """In one run, a body so heavy for its inertia that rounding hides what the pivot says across its arm."""
    data = top(runs=20)
    data["model"]["joints"][0]["points"][1] = [0.3, -0.9, 0.4]
    assert (run(data)["status"] == 0).all()
    edit_samples(monkeypatch, {7: {"bodies.top.mass": 1e14}})
    check_failed(run(data), 7, statuses.SINGULAR, last_good_step=0)


@pytest.mark.parametrize("gap", [0.0, 1e-12])
def test_one_rod_too_many_says_the_same(gap: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """In one run, both rods end in the same point of the ground: it moves as on one."""
    data = two_rods(runs=20)
    edit_samples(monkeypatch, {7: {"joints.near.points[0][1]": -0.7 + gap}})
    on_two = run(data)
    assert (on_two["status"] == 0).all()
    assert (on_two["position_violation"] < 1e-11).all()
    assert (on_two["velocity_violation"] < 1e-10).all()
    del data["model"]["joints"][1], data["sweep"]
    on_one = run(data)
    assert float(abs(on_one["position"][0, -1] - on_one["position"][0, 0]).max()) > 1e-3
    for name in STATE[:5]:
        np.testing.assert_allclose(on_two[name].sel(run=7), on_one[name].sel(run=0), rtol=0, atol=1e-9)


@pytest.mark.parametrize("gap", [1e-9, 1e-6, 1e-4, 1e-2])
def test_rods_that_say_nearly_the_same_are_held_or_the_run_fails(gap: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """In one run, the rods end so close to each other that one of them is all but one too many, all the time."""
    data = two_rods(runs=20, end=0.3)
    edit_samples(monkeypatch, {7: {"joints.near.points[0][1]": -0.7 + gap}})
    one = run(data).sel(run=7)
    assert int(one["status"]) != 0 or float(one["max_position_violation"]) < 1e-10


def test_not_assembled(monkeypatch: pytest.MonkeyPatch) -> None:
    """In one run, the rod cannot reach."""
    assert (run(a_rod(runs=20))["status"] == 0).all()
    edit_samples(monkeypatch, {7: {"joints.near.length": 9.0}})
    dataset = run(a_rod(runs=20))
    failed = dataset.sel(run=7)
    assert int(failed["status"]) == statuses.NOT_ASSEMBLED
    assert int(failed["steps"]) == 0
    assert failed["position"].isnull().all()
    assert (dataset["status"].drop_sel(run=7) == 0).all()


@pytest.mark.parametrize(
    ("path", "value"),
    [("bodies.top.mass", -1.0), ("bodies.top.mass", 0.0), ("bodies.top.inertia[1]", -0.1), ("bodies.top.mass", np.nan)],
)  # fmt: skip
def test_invalid_sample(path: str, value: float, monkeypatch: pytest.MonkeyPatch) -> None:
    edit_samples(monkeypatch, {2: {path: value}})
    dataset = run(top(runs=20))
    assert int(dataset["status"].sel(run=2)) == statuses.INVALID
    assert int(dataset["steps"].sel(run=2)) == 0
    assert float(dataset["end_time"].sel(run=2)) == 0
    for name in (*STATE, "max_position_violation"):
        assert np.isnan(dataset[name].sel(run=2)).all(), name
    assert (dataset["status"].drop_sel(run=2) == 0).all()


def test_all_runs_may_fail(monkeypatch: pytest.MonkeyPatch) -> None:
    edit_samples(monkeypatch, {label: {SPIN: 1e4} for label in range(9)})
    dataset = run(top(runs=9))
    assert (dataset["status"] == statuses.ROTATION).all()
    assert dataset["position"].isel(time=0).notnull().all()
    assert dataset["position"].isel(time=slice(1, None)).isnull().all()


def test_if_no_run_can_be_assembled_nothing_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    edit_samples(monkeypatch, {label: {"joints.near.length": 9.0} for label in range(3)})
    with pytest.raises(ScenarioError, match=r"no sampled run can be assembled with joints\.near\.length varied"):
        run(a_rod(runs=3))
