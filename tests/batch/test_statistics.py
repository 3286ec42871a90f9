"""What is kept of runs whose course is not, against the courses; and sweeps that end where there are runs enough."""

import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import lienumba
from lienumba.engine.stopping import Stopping, interval
from tests.facade import ScenarioError, resolve
from tests.rigs.places import SCENARIOS
from tests.rigs.sweeps import bits, top

QUANTITIES = [
    {"name": "tip", "type": "point", "body": "top", "point": [0, 0.5, 0]},
    {"name": "pointing", "type": "rotation_error", "body": "top"},
]
ALL = ["max", "min", "mean", "rms", "final", "time_of_max"]
TIMES = [0.01, 0.013, 0.02, 0.04, 0.05]  # neither from the start nor evenly


def observed(runs: int = 21, vary: dict[str, Any] | None = None, **output: Any) -> dict[str, Any]:
    data = top(runs=runs, output={"times": TIMES, "also": ["multiplier"], **output}) | {"quantities": QUANTITIES}
    data["sweep"]["vary"] |= vary or {}
    return data


@pytest.fixture(scope="module")
def full() -> xr.Dataset:
    asked = dict.fromkeys(["tip", "pointing.angle", "tip.z", "energy_residual", "rotation", "energy"], ALL)
    return lienumba.run(observed(summary=asked))


def of(course: xr.DataArray, statistic: str) -> xr.DataArray:
    """What a statistic of a course is, by xarray."""
    length = TIMES[-1] - TIMES[0]
    return {
        "max": lambda: course.max("time"), "min": lambda: course.min("time"), "final": lambda: course.isel(time=-1),
        "mean": lambda: course.integrate("time") / length,
        "rms": lambda: np.sqrt((course**2).integrate("time") / length),
        "time_of_max": lambda: course.idxmax("time"),
    }[statistic]()  # fmt: skip


@pytest.mark.parametrize("statistic", ALL)
@pytest.mark.parametrize("name", ["tip", "pointing.angle", "tip.z", "energy_residual", "rotation", "energy"])
def test_summaries_are_those_of_the_courses(full: xr.Dataset, name: str, statistic: str) -> None:
    course = full.tip.sel(axis="z", drop=True) if name == "tip.z" else full[name]
    found, expected = full[f"{name}_{statistic}"], of(course, statistic)
    assert found.dims == expected.dims
    assert found.attrs["units"] == ("s" if statistic == "time_of_max" else course.attrs["units"])
    if statistic in ("mean", "rms"):
        np.testing.assert_allclose(found, expected, rtol=1e-13, atol=1e-15)
    else:
        np.testing.assert_array_equal(found, expected)


def test_a_quantity_stands_for_all_its_parts() -> None:
    ds = lienumba.run(observed(runs=2, summary={"pointing": ["max"]}))
    assert ds["pointing_max"].dims == ("run", "axis")
    assert ds["pointing.angle_max"].dims == ("run",)


def test_of_a_run_that_fails_what_it_reached() -> None:
    data = observed(runs=11, summary={"tip": ALL})
    data["quantities"] = QUANTITIES
    data["parameters"] = {"blow": 1.0}
    data["model"]["forces"] = [{"type": "torque", "body": "top", "value": ["sqrt(blow - t)", 0, 0]}]
    data["sweep"]["vary"]["parameters.blow"] = {"distribution": "choice", "values": [1.0, 0.03, 0.005]}
    ds = lienumba.run(data)
    reached = np.isfinite(ds.tip.values).all(axis=2).sum(axis=1)
    assert {0, 3, 5} <= set(reached.tolist())
    for run, times in enumerate(reached):
        course = ds.tip[run, :times]
        for statistic in ALL:
            found = ds[f"tip_{statistic}"][run].values
            if times == 0 or (statistic == "final" and times < len(TIMES)):
                assert np.isnan(found).all()
            elif statistic == "mean":
                np.testing.assert_allclose(
                    found, course.integrate("time") / float(course.time[-1] - course.time[0]), rtol=1e-13
                )
            elif statistic in ("max", "min"):
                np.testing.assert_array_equal(found, of(course, statistic))


FALL: dict[str, Any] = {
    "model": {"gravity": [0, 0, -9.81], "bodies": [{"name": "ball", "mass": 1, "inertia": [1, 1, 1]}]},
    "quantities": [
        {"name": "at", "type": "point", "body": "ball", "point": [0, 0, 0]},
        {"name": "push", "type": "momentum"},
    ],
    "events": [{"name": "impact", "when": "at.z < -depth", "action": "stop"}],
    "parameters": {"depth": 10.0},
    "integrator": {"step": 0.01, "end_time": 2, "method": "rk4"},
    "output": {"every": 0.1, "summary": {"push.linear.z": ALL, "at.z": ALL}},
    "sweep": {"runs": 11, "vary": {"parameters.depth": {"distribution": "uniform", "low": 0.01, "high": 40}}},
}


@pytest.fixture(scope="module")
def fall() -> xr.Dataset:
    return lienumba.run(FALL)


def test_of_a_run_that_an_event_ends_its_end_counts(fall: xr.Dataset) -> None:
    ended = fall.status.values == 9
    assert ended.any()
    assert not ended.all()
    time = np.where(ended, np.sqrt(2 * fall["parameters.depth"].values / 9.81), 2.0)
    push = {name: fall[f"push.linear.z_{name}"].values for name in ALL}
    fallen = {"min": -9.81 * time, "final": -9.81 * time, "mean": -9.81 * time / 2, "max": 0 * time}
    for name, value in fallen.items():
        np.testing.assert_allclose(push[name], value, rtol=1e-11, atol=1e-12)
    np.testing.assert_array_equal(push["time_of_max"], 0.0)
    grid = [np.append(np.arange(0, end, 0.1), end) for end in time]  # the last interval is a shorter one
    rms = [np.sqrt(np.trapezoid((9.81 * t) ** 2, t) / t[-1]) for t in grid]
    np.testing.assert_allclose(push["rms"], rms, rtol=1e-11)
    np.testing.assert_allclose(fall["at.z_final"], -4.905 * time**2, rtol=1e-11)
    np.testing.assert_allclose(fall["at.z_min"], -4.905 * time**2, rtol=1e-11)
    assert (fall["at.z_final"].attrs["long_name"]) == (
        "at the last stored time, or where an event ended the run: position of a point, z"
    )


def test_no_summary_depends_on_neighbours(fall: xr.Dataset) -> None:
    names = [str(name) for name in fall if "_time_of" in str(name) or "linear" in str(name) or "max" in str(name)]
    for run in (0, 1, 2):
        alone = lienumba.run(FALL, runs=[run])
        for name in names:
            assert bits(alone[name])[1] == bits(fall[name].sel(run=[run]))[1]


def test_quantities_at_events(fall: xr.Dataset) -> None:
    """Where an event ends a run, that is its last state; elsewhere free fall says it."""
    half = {"name": "half", "when": "at.z < -0.5*depth"}
    output = {"every": 0.1, "at_events": ["push", "at.z", "velocity", "energy_residual"]}
    ds = lienumba.run(FALL | {"events": [half, *FALL["events"]], "output": output})
    assert ds["event_push.linear"].dims == ("run", "event", "axis")
    assert ds.event_velocity.dims == ("run", "event", "body", "axis")
    assert ds["event_at.z"].attrs["long_name"] == "position of a point, z, at the event"
    depth, times = ds["parameters.depth"].values, ds.event_time.values
    assert np.isnan(times[:, 1]).any()
    assert np.isfinite(times).any(axis=0).all()
    for n, deep in enumerate([0.5 * depth, depth]):
        happened = np.isfinite(times[:, n])
        push = ds["event_push.linear"].values[:, n, 2]
        np.testing.assert_allclose(push[happened], -np.sqrt(2 * 9.81 * deep[happened]), rtol=1e-11)
        np.testing.assert_allclose(ds["event_at.z"].values[happened, n], -deep[happened], rtol=1e-11)
        assert np.isnan(push[~happened]).all()
    ended = ds.status.values == 9
    np.testing.assert_allclose(ds.event_velocity.values[ended, 1], ds.last_velocity.values[ended], rtol=1e-15)
    assert abs(np.nan_to_num(ds.event_energy_residual)).max() < 1e-10
    again = lienumba.replay(ds, 1)  # which warns where bits are others
    assert bits(again["event_push.linear"])[1] == bits(ds["event_push.linear"].sel(run=[1]))[1]


@pytest.mark.parametrize("output", [None, "out.nc"], ids=["memory", "disk"])
def test_a_sweep_ends_by_a_number_in_a_variable(output: str | None, tmp_path: Path) -> None:
    """A time of an event, by its name; on a disk with runs that are there already."""
    stop = {"variable": "event_time.impact", "width": 0.8, "every": 8}
    data = FALL | {"sweep": FALL["sweep"] | {"runs": 200}}
    whole = lienumba.run(data, overrides={"sweep.runs": 64})
    more: dict[str, Any] = {}
    if output is not None:
        lienumba.run(data, output=tmp_path / output, runs=range(9)).close()
        more = {"output": tmp_path / output, "resume": True}
    with lienumba.run(data, overrides={"sweep.stop": stop}, **more) as ds:
        assert ds.attrs["stopped"].startswith(f"enough after {len(ds.run)} runs: the mean of event_time.impact is ")
        assert 8 < len(ds.run) < 64
        assert bits(ds.event_time)[1] == bits(whole.event_time.isel(run=slice(0, len(ds.run))))[1]


def test_an_end_behind_the_stored_times_does_not_count() -> None:
    window = {"times": [0.02, 0.04], "summary": {"at.z": ALL}}
    ds = lienumba.run(FALL | {"output": window}, overrides={"sweep.runs": 3})
    longer = lienumba.run(
        FALL | {"output": window, "events": [FALL["events"][0] | {"action": "record"}]}, overrides={"sweep.runs": 3}
    )
    assert (ds.status == 9).any()
    for name in ALL:
        assert bits(ds[f"at.z_{name}"])[1] == bits(longer[f"at.z_{name}"])[1]


@pytest.mark.parametrize("output", [None, "out.nc"], ids=["memory", "disk"])
def test_a_sweep_of_summaries(full: xr.Dataset, output: str | None, tmp_path: Path) -> None:
    data = observed(mode="summary", full_runs="3:5,20", summary={"pointing.angle": ["max", "rms"]})
    ds = lienumba.run(data, output=None if output is None else tmp_path / output)
    assert "position" not in {str(name) for name, x in ds.variables.items() if "run" in x.dims}
    assert ds.full_run.values.tolist() == [3, 4, 20]
    for name in ("position", "pointing.angle", "multiplier", "position_iterations"):
        assert ds[name].dims[:2] == ("full_run", "time")
        assert bits(ds[name])[1] == bits(full[name].isel(run=[3, 4, 20]))[1]
    for name in ("pointing.angle_max", "pointing.angle_rms", "last_position", "steps", "max_energy_drift", "status"):
        assert bits(ds[name]) == bits(full[name])
    ds.close()


def test_a_sweep_of_summaries_without_any_course(tmp_path: Path) -> None:
    with lienumba.run(observed(mode="summary"), output=tmp_path / "out.nc") as ds:
        assert "time" not in ds.variables
        assert ds.sizes["run"] == 21


@pytest.mark.parametrize(
    ("output", "message"),
    [
        ({"summary": {"tipp": ["max"]}}, 'output.summary."tipp": is not known; the nearest known name is "tip"'),
        ({"summary": {"tip": ["most"]}}, 'output.summary.tip[0] = "most": is not known; '),
        ({"summary": {"tip": []}}, "output.summary.tip = []: "),
        ({"summary": {"tip": ["max", "max"]}}, 'output.summary."tip": names "max" 2 times; name it once'),
        ({"mode": "summry"}, 'output.mode = "summry": must be "full" or "summary"; the nearest is "summary"'),
        ({"full_runs": "0:3"}, 'output.full_runs = "0:3": has no meaning in the mode "full"'),
        ({"at_events": ["tipp"]}, 'output.at_events[0] = "tipp": is not known; the nearest known name is "tip"'),
        (
            {"at_events": ["tip"]},
            'output.at_events[0] = "tip": has no event where it could be; add one, or leave it out',
        ),
        ({"max_changes": 0}, "output.max_changes = 0: must be "),
        ({"max_changes": 10**12}, "output.max_changes = 1000000000000: must be at most 100,000"),
        ({"full_runs": "3:3", "mode": "summary"}, 'output.full_runs = "3:3": the range "3:3" is empty'),
        (
            {"full_runs": "all", "mode": "summary"},
            'output.full_runs = "all": "all" is not a run; give labels',
        ),
    ],
)
def test_wrong_outputs(output: dict[str, Any], message: str) -> None:
    with pytest.raises(ScenarioError) as refused:
        resolve(observed(**output))
    assert message in str(refused.value)


def test_a_summary_that_is_asked_for_twice_is_there_once() -> None:
    ds = lienumba.run(observed(runs=2, summary={"pointing": ["max"], "pointing.angle": ["max"]}))
    assert ds["pointing.angle_max"].dims == ("run",)


def test_names_that_collide() -> None:
    data = observed(runs=2, summary={"tip": ["max"]})
    data["quantities"] = [*QUANTITIES, {"name": "tip_max", "type": "expression", "value": "tip.z"}]
    with pytest.raises(ScenarioError, match=r"output\.summary: gives tip_max, but the dataset has a variable"):
        lienumba.run(data)


def test_courses_of_nothing(tmp_path: Path) -> None:
    data = observed(mode="summary", full_runs="0:2", variables=["driver_effort"], also=[])
    with lienumba.run(data, output=tmp_path / "out.nc") as ds:
        assert "full_run" not in ds.dims


def test_runs_that_are_all_invalid_in_one_portion_do_not_end_a_sweep(monkeypatch: pytest.MonkeyPatch) -> None:
    from lienumba.engine import simulate

    monkeypatch.setattr(simulate.Runs, "portions", lambda self, bodies: (self.part(slice(n, n + 8)) for n in (0, 8)))
    data = top(runs=16)
    mass = {"distribution": "choice", "values": [15.0, 15.0]}
    data["sweep"]["vary"] = {"bodies.top.mass": mass}
    from tests.rigs.sweeps import edit_samples

    edit_samples(monkeypatch, {run: {"bodies.top.mass": -1.0} for run in range(8)})
    assert (lienumba.run(data).status.values == [6] * 8 + [0] * 8).all()


def test_a_component_without_quotes() -> None:
    text = '[output]\nsummary = { pointing.angle = ["max"] }\n'
    data = observed() | tomllib.loads(text)
    assert resolve(data).data.output.summary == {"pointing.angle": ["max"]}


# ---------------------------------------------------------------- sweeps that end where there are runs enough
RULE: dict[str, Any] = {"variable": "pointing.angle_max", "width": 0.02, "every": 16}


def stopped(**rule: Any) -> dict[str, Any]:
    data = observed(400, mode="summary", summary={"pointing.angle": ["max"]})
    data["sweep"]["stop"] = RULE | rule
    return data


@pytest.fixture(scope="module")
def end() -> int:
    """After how many runs the rule is fulfilled, by hand."""
    from scipy import stats

    every = lienumba.run(observed(400, mode="summary", summary={"pointing.angle": ["max"]}))["pointing.angle_max"]
    for runs in range(16, 400, 16):
        x = every.values[:runs]
        low, high = stats.t.interval(0.95, runs - 1, x.mean(), stats.sem(x))
        if high - low <= 0.02:
            return runs
    raise AssertionError("never")


def test_the_rule_has_a_meaning(end: int) -> None:
    assert 16 < end < 300


@pytest.mark.parametrize("workers", [1, 2])
@pytest.mark.parametrize("output", [None, "out.nc"], ids=["memory", "disk"])
def test_it_ends_at_the_same_run(end: int, workers: int, output: str | None, tmp_path: Path) -> None:
    with lienumba.run(stopped(), workers=workers, output=None if output is None else tmp_path / output) as ds:
        assert ds.run.values.tolist() == list(range(end))
        assert ds.attrs["stopped"].startswith(f"enough after {end:,} runs: the mean of pointing.angle_max is ")


def test_a_narrower_rule_goes_on_and_a_wider_one_takes_nothing_away(end: int, tmp_path: Path) -> None:
    target = tmp_path / "out.nc"
    lienumba.run(stopped(), output=target).close()
    with lienumba.run(stopped(width=0.015), output=target, resume=True) as more:
        assert more.sizes["run"] > end
        assert bits(more["pointing.angle_max"]) == bits(lienumba.run(stopped(width=0.015))["pointing.angle_max"])
        count = more.sizes["run"]
    with lienumba.run(stopped(width=0.02), output=target, resume=True) as same:
        assert same.sizes["run"] == count


def test_what_is_not_reached_takes_all_runs() -> None:
    ds = lienumba.run(stopped(width=1e-9))
    assert ds.sizes["run"] == 400
    assert "stopped" not in ds.attrs


def test_the_interval_of_a_quantile_covers_it() -> None:
    """In 95 % of 400 samples of 200, whatever the distribution."""
    rule = resolve(stopped(statistic="quantile", probability=0.9)).data.sweep.stop
    assert rule is not None
    random = np.random.default_rng(3)
    inside = 0
    for _ in range(400):
        found = interval(random.exponential(size=200), rule)
        inside += found.low <= -np.log(0.1) <= found.high
    assert 0.93 < inside / 400 < 0.99
    assert interval(np.array([1.0, np.nan]), rule).width == np.inf
    assert interval(np.arange(5.0), rule).width == np.inf, "five runs cannot bound it from above"


def test_runs_may_finish_in_any_order() -> None:
    rule = resolve(stopped(width=0.5, every=10)).data.sweep.stop
    values, order = np.random.default_rng(5).normal(size=400), np.random.default_rng(6).permutation(400)
    ends = set()
    for labels in (np.arange(400), np.arange(400)[::-1], order):
        stopping = Stopping(rule, 400, False)
        for part in np.array_split(labels, 60):
            stopping.know(part, lambda name, place, part=part: values[part])
        ends.add(stopping.end)
    assert len(ends) == 1


def test_the_last_run_may_decide() -> None:
    rule = resolve(stopped(width=10.0, every=400)).data.sweep.stop
    values, stopping = np.random.default_rng(5).normal(size=400), Stopping(rule, 400, False)
    stopping.know(np.arange(399), lambda name, place: values[:399])
    assert stopping.end is None
    stopping.know(np.array([399]), lambda name, place: values[399:])
    assert stopping.end == 400
    assert stopping.kept(np.array([399, 400])).tolist() == [True, False]


@pytest.mark.parametrize(
    ("rule", "message"),
    [
        (
            {"variable": "pointing.angle_mx"},
            'sweep.stop.variable = "pointing.angle_mx": is not a number that the dataset',
        ),
        (
            {"variable": "position"},
            'sweep.stop.variable = "position": is not a number that the dataset has for each run',
        ),
        ({"statistic": "quantile"}, "sweep.stop.probability is missing; give that of the quantile, such as 0.95"),
        ({"probability": 0.5}, "sweep.stop.probability = 0.5: has no meaning for a mean; leave it out"),
        ({"width": 0}, "sweep.stop.width = 0: must be above 0; give the width of the confidence interval, from end"),
        ({"confidence": 95}, "sweep.stop.confidence = 95: must be below 1; give that of the interval, between 0 and 1"),
        ({"every": 401}, "sweep.stop.every = 401: is never reached by sweep.runs = 400; give fewer, or more runs"),
        ({"colour": 1}, "sweep.stop.colour is not a known key"),
    ],
)
def test_wrong_rules(rule: dict[str, Any], message: str) -> None:
    with pytest.raises(ScenarioError) as refused:
        lienumba.run(stopped(**rule))
    assert message in str(refused.value)
    assert "\n" not in str(refused.value)


def test_a_study_knows_no_end() -> None:
    from lienumba.scenario.reading.loading import load

    data = load(SCENARIOS / "heavy_top_study.toml")
    data.setdefault("sweep", {})["stop"] = RULE
    with pytest.raises(ScenarioError, match=r"sweep\.stop: a study needs all runs at every point; leave it out"):
        resolve(data)
