"""The summary of a dataset whose every number is known."""

import numpy as np
import pytest
import xarray as xr

from lienumba.analysis.summary import summarise
from lienumba.batch.statuses import STATUSES
from lienumba.store.layout import dataset

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
    assert summary.max_relative_energy_drift == pytest.approx(2e-6 / 4.0)


def test_no_good_run():
    summary = summarise(known([1, 3]))
    assert (summary.runs, summary.good, summary.final) == (2, 0, ())
    assert summary.max_position_violation is None
    assert summary.max_relative_energy_drift is None
    assert sum(outcome.count for outcome in summary.outcomes) == 2


def test_what_was_not_stored_is_left_out():
    summary = summarise(known([0, 0], position=None, kinetic_energy=None, end_time=None, max_energy_drift=None))
    assert {row.quantity for row in summary.final} == {"energy"}
    assert summary.max_relative_energy_drift is None
    assert summary.max_energy_drift is None
    assert summary.outcomes[0].end_times == ()


def test_a_system_at_rest_has_no_drift():
    still = np.zeros((2, 3))
    summary = summarise(known([0, 0], kinetic_energy=still, energy_residual=still))
    assert summary.max_relative_energy_drift == 0.0


def test_a_file_gives_the_same_summary(tmp_path):
    ds = known([0, 2, 0, 0])
    ds.to_netcdf(tmp_path / "out.nc", engine="netcdf4")
    with xr.open_dataset(tmp_path / "out.nc") as opened:
        assert summarise(opened) == summarise(ds)
    assert summarise(ds.isel(run=[0])).good == 1
