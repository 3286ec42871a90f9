"""The summary of a dataset whose every number is known."""

import numpy as np
import pytest
import xarray as xr

import lienumba
from lienumba import ScenarioError
from lienumba.analysis.summary import summarise
from lienumba.batch.statuses import STATUSES
from lienumba.store.layout import Variable, dataset
from tests.rigs.places import SCENARIOS

TIMES = [0.0, 0.5, 1.0]


def known(status, **more):
    """Run i ends at position i * (1, 10, 100) for the first body and twice that for the second."""
    runs = len(status)
    status = np.array(status, dtype=np.int8)
    failed = status != 0
    position = np.zeros((runs, 3, 2, 3))
    position[:, -1, 0] = np.arange(runs)[:, None] * np.array([1.0, 10.0, 100.0])
    position[:, -1, 1] = 2 * position[:, -1, 0]
    energy = 5.0 + np.arange(runs)[:, None] * np.array([0.0, 0.0, 1.0])
    kinetic = np.tile([1.0, 4.0, 2.0], (runs, 1))
    residual = np.arange(runs)[:, None] * np.array([0.0, -1e-6, 5e-7])
    for array in (position, energy, kinetic, residual):
        array[failed, 1:] = np.nan
    variables = {
        "position": position,
        "energy": energy,
        "kinetic_energy": kinetic,
        "energy_residual": residual,
        "status": status,
        "end_time": np.where(failed, 0.25, 1.0),
        "max_position_violation": np.arange(runs) * 1e-9,
        "max_velocity_violation": np.arange(runs) * 1e-8,
        "max_energy_drift": np.arange(runs) * 1e-6,
        "max_relative_energy_drift": np.arange(runs) * 2.5e-7,
    } | more
    return dataset(
        variables={name: array for name, array in variables.items() if array is not None},
        times=TIMES,
        runs=range(100, 100 + runs),
        bodies=["top", "tip"],
        joints=[],
        constraints=[],
        inputs={},
        input_units={},
        attributes={"title": "known"},
    )


def test_outcomes_name_status_labels_and_times():
    summary = summarise(known([0, 2, 0, 1, 2, 2, 2, 2, 2, 0, 0]))
    assert (summary.title, summary.runs, summary.good, summary.final_time) == ("known", 11, 4, 1.0)
    success, frequent, rare = summary.outcomes
    assert (success.status, success.count, success.labels) == ("success", 4, (100, 102, 109, 110))
    assert (frequent.status, frequent.count) == (STATUSES[2].name, 6)
    assert frequent.labels == (101, 104, 105, 106, 107)
    assert frequent.end_times == (0.25,) * 5
    assert (rare.status, rare.count, rare.labels) == (STATUSES[1].name, 1, (103,))


def test_runs_whose_measure_is_undefined_are_told():
    """Quantiles leave them out: a reader would take them for those of all runs."""
    ds = known([0, 0, 0, 0, 2])
    ds["settling"] = "run", [0.5, np.nan, np.nan, 0.25, np.nan]  # the last run has failed, which is told elsewhere
    ds["root"] = "run", [np.nan] * 5
    ds["bounces"] = "run", [1.0, 2.0, 3.0, 4.0, np.nan]
    summary = summarise(ds)
    assert summary.unknown == (
        "without a number, of 4 runs: settling in 2 and root in 4 (undefined, or it never came to that)"
    )
    assert summary.unknown in repr(summary)
    assert summarise(ds.isel(run=[0, 3])[["status", "end_time", "settling", "position"]]).unknown == ""


def test_quantiles_of_the_final_state_of_good_runs():
    ds = known([0] * 21 + [1])
    summary = summarise(ds)
    rows = {(row.quantity, row.body, row.axis): row for row in summary.final}
    assert len(rows) == 2 * 3 + 1
    row = rows["position", "tip", "y"]
    assert (row.low, row.median, row.high) == pytest.approx((20.0, 200.0, 380.0))
    assert row.units == "m"
    row = rows["position", "top", "x"]
    assert (row.low, row.median, row.high) == pytest.approx((1.0, 10.0, 19.0))
    row = rows["energy", "", ""]
    assert (row.low, row.median, row.high) == pytest.approx((6.0, 15.0, 24.0))
    assert row.units == "J"


def test_maxima_are_over_good_runs_only():
    summary = summarise(known([0, 0, 0, 1]))
    assert summary.max_position_violation == pytest.approx(2e-9)
    assert summary.max_velocity_violation == pytest.approx(2e-8)
    assert summary.max_energy_drift == pytest.approx(2e-6)
    assert summary.max_relative_energy_drift == pytest.approx(5e-7)


def test_no_good_run():
    summary = summarise(known([1, 3]))
    assert (summary.runs, summary.good, summary.final) == (2, 0, ())
    assert summary.max_position_violation is None
    assert summary.max_relative_energy_drift is None
    assert sum(outcome.count for outcome in summary.outcomes) == 2


def test_what_was_not_stored_is_left_out():
    summary = summarise(
        known([0, 0], position=None, end_time=None, max_energy_drift=None, max_relative_energy_drift=None)
    )
    assert {row.quantity for row in summary.final} == {"energy"}
    assert summary.max_relative_energy_drift is None
    assert summary.max_energy_drift is None
    assert summary.outcomes[0].end_times == ()


def test_a_file_gives_the_same_summary(tmp_path):
    ds = known([0, 2, 0, 0])
    ds.to_netcdf(tmp_path / "out.nc", engine="netcdf4")
    with xr.open_dataset(tmp_path / "out.nc") as opened:
        assert summarise(opened) == summarise(ds)
    assert summarise(ds.isel(run=[0])).good == 1


def test_the_nominal_run_is_a_run_but_no_part_of_the_spread():
    ds = known([0] * 21 + [0]).assign_coords(run=[*range(21), -1])
    ds["max_position_violation"][-1] = 7.0
    summary = summarise(ds)
    assert (summary.runs, summary.good, summary.spread) == (22, 22, 21)
    assert summary.max_position_violation == 7.0
    row = next(row for row in summary.final if row.quantity == "energy")
    assert (row.low, row.median, row.high) == pytest.approx((6.0, 15.0, 24.0))
    alone = summarise(ds.sel(run=[-1]))
    assert (alone.spread, alone.final[-1].median) == (1, 26.0)


def test_summaries_instead_of_courses():
    """Quantiles over the good runs, the last states at the end; NaN is left out."""
    runs = 21
    peaks = np.arange(3.0 * runs).reshape(runs, 3)
    peaks[-1] = np.nan
    own = {
        "tip_max": Variable(("run", "axis"), "m", "largest: tip"),
        "load_rms": Variable(("run",), "N", "root mean square over the time: load"),
        "load": Variable(("full_run", "time"), "N", "load"),
    }
    last = np.zeros((runs, 2, 3)) + np.arange(runs)[:, None, None]
    ds = dataset(
        variables={"tip_max": peaks, "load_rms": np.full(runs, 2.5), "load": np.ones((2, 3)), "last_position": last,
                   "status": np.zeros(runs), "end_time": np.ones(runs)},
        own=own, times=TIMES, runs=range(runs), full_runs=[3, 4], bodies=["top", "tip"], joints=[], constraints=[],
        inputs={}, input_units={}, attributes={},
    )  # fmt: skip
    summary = summarise(ds)
    rows = {(row.quantity, row.body, row.axis): (row.low, row.median, row.high) for row in summary.kept}
    assert list(rows) == [("tip_max", "", "x"), ("tip_max", "", "y"), ("tip_max", "", "z"), ("load_rms", "", "")]
    assert rows["tip_max", "", "y"] == pytest.approx(tuple(np.quantile(peaks[:-1, 1], [0.05, 0.5, 0.95])))
    assert rows["load_rms", "", ""] == (2.5, 2.5, 2.5)
    assert {row.quantity for row in summary.final} == {"position"}
    assert summary.final[0].median == 10.0
    assert summary.final_time == 1.0
    assert summary.max_relative_energy_drift is None


def test_what_is_shown_may_be_chosen():
    ds = known([0, 0]).assign_attrs(show="energy, rise")
    ds["rise"] = "run", [1.0, 2.0]
    ds["fall"] = "run", [1.0, 2.0]
    summary = summarise(ds)
    assert {row.quantity for row in summary.final} == {"energy"}
    assert {row.quantity for row in summary.kept} == {"rise"}
    summary = summarise(ds.assign_attrs(show="velocity, position, energy"))
    assert list(dict.fromkeys(row.quantity for row in summary.final)) == ["position", "energy"]


def test_warnings_come_first_among_remarks():
    ds = known([0, 0]).assign_attrs(warnings="a: is wrong; mend it\nb: is wrong", stopped="stopped early")
    assert repr(summarise(ds)).splitlines()[-3:] == [
        "warning: a: is wrong; mend it",
        "warning: b: is wrong",
        "stopped early",
    ]


def test_it_shows_itself():
    shown = repr(summarise(known([0, 0, 2, 0])))
    assert shown.startswith("known: 3 of 4 runs good, 1 failed\n  1 projection_not_converged: ")
    assert "runs 102 (at 0.25 s)\n" in shown
    assert " position   top   y " in " ".join(shown.split(" ")).replace("  position", " position")
    assert shown.endswith("relative energy drift 7.5e-07")
    assert "\x1b" not in shown


def test_a_study_is_summed_up_elsewhere():
    with pytest.raises(ScenarioError, match=r"is of a study, which lienumba\.analysis\.orders sums up"):
        summarise(known([0]).assign_coords(step=xr.Variable((), 0.1, {"role": "grid", "path": "integrator.step"})))


def test_quantiles_say_of_how_many_runs_they_are():
    """Runs that an event stopped are good, and have no final state."""
    ds = known([0, 0, 9, 9, 1])
    summary = summarise(ds)
    assert (summary.good, summary.spread, summary.finished) == (4, 4, 2)
    assert "\nat t = 1 s, over 2 runs that reached it" in repr(summary)
    assert ", over" not in repr(summarise(ds.isel(run=[0, 1, 4])))
    alone = repr(summarise(ds.isel(run=[1, 2, 3])))
    assert "at t = 1 s, over 1 run that reached it" in alone
    assert "median" not in alone.partition("where an event ended 2 runs")[0]


def test_last_states_and_times_of_events_of_runs_that_events_ended():
    times = np.array([[0.2, np.nan], [np.nan, np.nan], [0.6, 0.5], [np.nan, 0.1]])
    ds = known([9, 0, 9, 1], end_time=np.array([0.25, 1.0, 0.5, 0.1]))
    ds = ds.assign(event_time=(("run", "event"), times), last_position=ds["position"].isel(time=0) + 1.0)
    summary = summarise(ds.assign_coords(event=["near", "far"]))
    assert [(row.quantity, row.body, row.axis) for row in summary.ended][:2] == [
        ("end_time", "", ""), ("position", "top", "x")
    ]  # fmt: skip
    assert (summary.ended[0].low, summary.ended[0].median) == pytest.approx((0.2625, 0.375))
    assert [(x.name, x.runs, x.median) for x in summary.events] == [("near", 2, 0.4), ("far", 1, 0.5)]
    assert repr(summary).index("where an event ended 2 runs") < repr(summary).index("events, the first of each run")


def test_what_was_not_measured_is_left_out():
    """The runs ended before the first stored time."""
    ds = known([9, 9, 1])
    unmeasured = ds.isel(time=slice(1, None)).assign({name: 0.0 * ds[name] for name in ds if name.startswith("max_")})
    summary = summarise(unmeasured)
    assert summary.max_position_violation is summary.max_energy_drift is summary.max_relative_energy_drift is None
    assert "largest" not in repr(summary)
    assert summarise(ds.isel(time=slice(1, None))).max_position_violation == pytest.approx(1e-9)  # of all stored times
    at_rest = summarise(unmeasured.assign(end_time=ds["end_time"] + 1.0))
    assert at_rest.max_position_violation == 0.0


def test_coordinates_that_are_chosen_are_all_shown_in_their_units():
    output = {"every": 0.005, "joint_coordinates": True, "show": ["q", "qd", "tau"]}
    ds = lienumba.run(
        SCENARIOS / "five_bar_leg.toml", overrides={"integrator.end_time": 0.01, "output": output}, runs=[0]
    )
    units = {(row.quantity, row.body): row.units for row in summarise(ds).final}
    assert units["q", "rail"] == "m"
    assert units["qd", "front_hip"] == "rad s-1"
    assert units["tau", "rail"] == "N"
    assert units["tau", "ankle.rx"] == "N m"
    assert repr(summarise(ds)).count("ankle.r") == 9
