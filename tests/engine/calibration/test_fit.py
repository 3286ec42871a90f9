"""`Prepared.fit`: where the model is linear it is linear least squares, with the same errors; what data cannot tell is
said."""

import re
from typing import Any

import numpy as np
import pytest
import xarray as xr
from scipy import stats

import lienumba
from tests.facade import ScenarioError
from tests.rigs.flights import GRAVITY, VELOCITY, fall, flight, height

SPEED, DOWN = "bodies.b.velocity[2]", "gravity[2]"
START = {SPEED: 7.0, DOWN: -9.0}
TIMES = np.array([0.25, 0.5, 0.75, 1.0, 1.5, 2.0])
ERRORS = np.array([0.02, -0.01, 0.03, 0.0, -0.02, 0.01])
COLUMNS = np.stack([TIMES, 0.5 * TIMES**2], axis=1)


@pytest.fixture(scope="module")
def ready() -> Any:
    return lienumba.prepare(flight())


def course(name: str, values: Any, times: Any = TIMES) -> xr.DataArray:
    return xr.DataArray(values, {"time": times}, ("time",), name)


def test_a_linear_model_is_linear_least_squares(ready: Any) -> None:
    values = height(TIMES) + ERRORS
    x, squares, *_ = np.linalg.lstsq(COLUMNS, values, rcond=None)
    scatter = float(squares[0]) / (len(TIMES) - 2)
    covariance = scatter * np.linalg.inv(COLUMNS.T @ COLUMNS)
    found = ready.fit(course("p.z", values), START)
    np.testing.assert_allclose([*found.values.values()], x, rtol=1e-9)
    np.testing.assert_allclose(found.covariance, covariance, rtol=1e-7)
    np.testing.assert_allclose(found.correlation[0, 1], covariance[0, 1] / np.sqrt(np.prod(np.diag(covariance))))
    assert (found.success, found.freedom, found.identifiability) == (True, 4, "the data tell all parameters apart")
    np.testing.assert_allclose(found.scatter**2, scatter, rtol=1e-9)
    np.testing.assert_allclose(found.residuals["p.z"], COLUMNS @ x - values, atol=1e-9)
    assert list(found.covariance["parameter"].values) == [SPEED, DOWN]
    low, high = found.intervals(0.9)[SPEED]
    assert (high - low) / 2.0 == pytest.approx(stats.t.ppf(0.95, 4) * np.sqrt(covariance[0, 0]), rel=1e-7)
    assert str(found).startswith(f"{SPEED}  {x[0]:.8g} +- {np.sqrt(covariance[0, 0]):.2g}\n")


def test_known_errors_weigh_and_are_not_scaled(ready: Any) -> None:
    sigma = np.array([0.02, 0.02, 0.05, 0.02, np.nan, 0.01])
    values = np.where(np.isnan(sigma), np.nan, height(TIMES) + ERRORS)
    sigma = np.nan_to_num(sigma, nan=1.0)
    seen = np.isfinite(values)
    scaled = (COLUMNS / sigma[:, None])[seen]
    x, *_ = np.linalg.lstsq(scaled, (values / sigma)[seen], rcond=None)
    found = ready.fit(course("p.z", values), START, sigma={"p.z": sigma})
    np.testing.assert_allclose([*found.values.values()], x, rtol=1e-9)
    np.testing.assert_allclose(found.covariance, np.linalg.inv(scaled.T @ scaled), rtol=1e-7)
    half = found.standard_errors[DOWN] * stats.norm.ppf(0.975)
    assert found.intervals()[DOWN] == pytest.approx((x[1] - half, x[1] + half), rel=1e-9)


def test_times_of_events_of_several_recordings(ready: Any) -> None:
    downs = np.array([-9.0, -9.5, -10.0])
    recordings = [xr.Dataset({"event_time.fallen": fall(7.5, down)}) for down in downs]
    found = ready.fit(recordings, {SPEED: 8.0}, sigma=1e-3, samples={DOWN: downs})
    assert found.values[SPEED] == pytest.approx(7.5, rel=1e-9)
    t = np.array([fall(7.5, down) for down in downs])
    slopes = -t / (7.5 + downs * t)
    assert found.standard_errors[SPEED] == pytest.approx(1e-3 / np.sqrt(slopes @ slopes), rel=1e-7)
    assert found.residuals["event_time.fallen"].sizes == {"run": 3}


def test_a_vector_with_some_of_its_labels(ready: Any) -> None:
    ds = ready.run()["last_position"].isel(run=0).sel(axis=["z", "x"]).transpose("axis", "body")
    found = ready.fit(ds, {SPEED: 7.0, "bodies.b.velocity[0]": 0.5})
    assert [*found.values.values()] == pytest.approx([VELOCITY[2], VELOCITY[0]], rel=1e-9)


def test_bounds_hold(ready: Any) -> None:
    found = ready.fit(course("p.z", height(TIMES)), START, bounds={DOWN: (-9.2, -8.0)})
    assert found.values[DOWN] == pytest.approx(-9.2, abs=1e-6)


def test_what_the_data_cannot_tell_is_named(ready: Any) -> None:
    sought = {"bodies.b.velocity[0]": 1.1, "bodies.b.velocity[1]": 2.1, DOWN: GRAVITY}
    found = ready.fit(course("far", 5.0 * TIMES), sought)
    assert "the data do not depend on gravity[2]" in found.identifiability
    told = "the data cannot tell bodies.b.velocity[0] and bodies.b.velocity[1] apart"
    assert told in found.identifiability
    assert [*found.standard_errors.values()] == [np.inf] * 3
    np.testing.assert_allclose(found.singular_values, [np.sqrt(2.0), 0.0, 0.0], atol=1e-7)
    assert found.values["bodies.b.velocity[0]"] + 2.0 * found.values["bodies.b.velocity[1]"] == pytest.approx(5.0)


def test_what_is_barely_told_apart(ready: Any) -> None:
    times = np.array([1.75, 1.875, 2.0])
    found = ready.fit(course("p.z", height(times), times), START, sigma=0.01)
    columns = np.stack([times, 0.5 * times**2], axis=1)
    least = np.linalg.svd(columns / np.linalg.norm(columns, axis=0))[1][-1]
    told = f"the data can barely tell {SPEED} and {DOWN} apart: .* 1 part in {1.0 / least:.0f}"
    assert re.search(re.escape(told).replace(r"\.\*", ".*"), found.identifiability)
    assert np.isfinite([*found.standard_errors.values()]).all()


Z = course("p.z", height(TIMES))


@pytest.mark.parametrize(
    ("measured", "given", "told"),
    [
        (course("p.w", TIMES), {}, '"p.w", which the dataset does not have'),
        (Z.rename(None), {}, "measured: has no name"),
        (Z.drop_vars("time"), {}, "measured.p.z: has no times"),
        (3, {}, "measured: is a int"),
        ([], {}, "measured: is empty"),
        (xr.Dataset(), {}, "measured: has no variable"),
        (Z * np.nan, {}, "has no number that is finite"),
        (Z.expand_dims(run=[0]), {}, "has a dimension run"),
        (Z.expand_dims(body=["b"]), {}, "has the dimensions body and time, but the dataset has time"),
        (Z.assign_coords(time=TIMES + 1.0), {}, "has the time 2.5 s, but runs go from 0 to 2 s"),
        (xr.Dataset({"p.z": Z, "p.x": Z}), {}, "sigma: is missing, and 2 variables were measured"),
        (Z, {"sigma": 0.0}, "sigma.p.z: must be above 0"),
        (Z, {"sigma": {"p.x": 1.0}}, "sigma: has none of p.z"),
        (Z, {"sigma": [1.0, 2.0]}, "sigma.p.z: must be one number"),
        (Z, {"bounds": {"gravity[1]": (0, 1)}}, "is none of the parameters"),
        (Z, {"bounds": {DOWN: (2.0, 1.0)}}, "must be a lower and an upper end"),
        (Z, {"bounds": {DOWN: (0.0, 1.0)}}, "lies outside its bounds"),
        (Z, {"max_calls": 0}, "max_calls = 0: must be a whole number"),
        (Z.assign_coords(time=TIMES - 0.1), {}, "measured: output.times[0] = 0.15: is not a whole number of steps"),
        (Z.isel(time=[0]), {}, "has 1 number for 2 parameters"),
        ([Z, Z], {}, "run 1 does not exist"),
        (
            xr.DataArray([[1.0, 1.0, 1.0]], {"body": ["c"]}, ("body", "axis"), "last_position"),
            {},
            "has the body .c., but the dataset has b",
        ),
    ],
)
def test_what_does_not_fit_is_refused(ready: Any, measured: Any, given: dict[str, Any], told: str) -> None:
    with pytest.raises(ScenarioError, match=re.escape(told).replace(r"\.c\.", '"c"')):
        ready.fit(measured, START, **given)


def test_an_event_that_does_not_happen_at_the_start(ready: Any) -> None:
    with pytest.raises(ScenarioError, match="does not happen with the values from which the search starts"):
        ready.fit(xr.DataArray(1.8, name="event_time.fallen"), {SPEED: 20.0}, sigma=1e-3)


def test_calls_run_out(ready: Any) -> None:
    found = ready.fit(xr.DataArray(1.0, name="event_time.fallen"), {SPEED: 8.0}, sigma=1e-3, max_calls=1)
    assert not found.success
    assert "raise max_calls" in found.message
