"""Angles and means of rotations, against closed forms, symmetry and SciPy."""

import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import lienumba
from lienumba.analysis import mean_rotation, rotation_error
from lienumba.store import layout
from lienumba.store.layout import dataset
from tests.analysis.statistics.attitudes import about_z, angle, attitudes, spread


def mean_of(matrices):
    found = mean_rotation(attitudes(matrices))
    return found["mean"].values, found


# ---------------------------------------------------------------- angles
@pytest.mark.parametrize("size", [0.0, 1e-12, 1e-6, 1.0, 3.0, np.pi - 1e-7, np.pi - 1e-12, np.pi])
def test_angles_are_exact_beside_0_and_pi(size):
    R = Rotation.random(5, rng=1)
    axes = np.random.default_rng(2).normal(size=(5, 3))
    turned = R * Rotation.from_rotvec(size * axes / np.linalg.norm(axes, axis=1, keepdims=True))
    errors = rotation_error(attitudes(turned.as_matrix()), attitudes(R.as_matrix()))
    assert errors.values == pytest.approx(size, abs=2e-15)
    assert errors.attrs == {"units": "rad", "long_name": "angle to the reference rotation"}


def test_references_have_some_labels_or_none(monkeypatch):
    monkeypatch.setattr("lienumba.analysis.statistics.rotations.AT_ONCE", 5)
    R = Rotation.random(24, rng=3).as_matrix().reshape(6, 2, 2, 3, 3)
    variable = attitudes(R, ("run", "time", "body"), run=[-1, 0, 1, 2, 3, 4], body=["a", "b"])
    errors = rotation_error(variable, variable.sel(run=-1))
    assert errors.dims == ("run", "time", "body")
    assert list(errors.run) == [-1, 0, 1, 2, 3, 4]
    assert list(errors.body) == ["a", "b"]
    for run, time, body in np.ndindex(6, 2, 2):
        assert errors.values[run, time, body] == pytest.approx(angle(R[0, time, body], R[run, time, body]), abs=1e-14)
    one = rotation_error(variable.isel(time=0, body=1), Rotation.random(rng=4).as_matrix().tolist())
    assert one.values == pytest.approx(angle(Rotation.random(rng=4).as_matrix(), R[:, 0, 1]), abs=1e-14)
    assert float(rotation_error(variable[0, 0, 0], variable[1, 0, 0])) == pytest.approx(angle(R[0, 0, 0], R[1, 0, 0]))


def test_the_mean_of_runs_is_a_reference():
    R = attitudes(spread(np.random.default_rng(23), 12, 0.3).reshape(6, 2, 3, 3), ("run", "time"))
    found = mean_rotation(R)
    errors = rotation_error(R, found)
    assert errors.identical(rotation_error(R, found["mean"]))
    assert errors.max("run").values == pytest.approx(found.radius.values, abs=1e-14)


def test_a_missing_rotation_has_no_angle():
    R = Rotation.random(3, rng=5).as_matrix()
    R[1] = np.nan
    assert np.isnan(rotation_error(attitudes(R), np.eye(3))).values.tolist() == [False, True, False]


# ---------------------------------------------------------------- means
@pytest.mark.parametrize("size", [1e-9, 1e-3, 0.7, 1.5])
def test_the_mean_of_opposite_turns_is_between_them(size):
    middle = Rotation.random(rng=6)
    turns = Rotation.from_rotvec(size * np.concatenate([np.eye(3), -np.eye(3)]))
    found, whole = mean_of((middle * turns).as_matrix())
    assert angle(found, middle.as_matrix()) < 1e-14
    assert float(whole.spread) == pytest.approx(size, abs=1e-14)
    assert float(whole.radius) == pytest.approx(size, abs=1e-14)


@pytest.mark.parametrize("deviation", [0.1, 0.5, 1.0, 2.0])
@pytest.mark.parametrize("runs", [3, 8, 1300])
def test_about_one_axis_it_is_the_mean_direction(deviation, runs):
    angles = deviation * np.random.default_rng([runs, int(10 * deviation)]).normal(size=runs)
    found, whole = mean_of(about_z(*angles))
    direction = np.angle(np.exp(1j * angles).mean())
    assert angle(about_z(direction)[0], found) < 1e-12
    away = np.angle(np.exp(1j * (angles - direction)))
    assert float(whole.spread) == pytest.approx((away**2).mean() ** 0.5, rel=1e-12)
    assert float(whole.radius) == pytest.approx(abs(away).max(), rel=1e-12)


@pytest.mark.parametrize(("runs", "deviation"), [(2, 1.0), (3, 3.0), (9, 3.0), (50, 1e-3), (200, 0.6)])
def test_it_is_that_of_scipy(runs, deviation):
    matrices = spread(np.random.default_rng(runs), runs, deviation)
    found, _ = mean_of(matrices)
    assert angle(found, Rotation.from_matrix(matrices).mean().as_matrix()) < 1e-10


@pytest.mark.parametrize(
    "matrices",
    [
        about_z(0.0, np.pi),
        about_z(*np.arange(7) * 2.0 * np.pi / 7.0),
        Rotation.create_group("O").as_matrix(),
        about_z(0.3, 0.3 + np.pi).astype(np.float32),
    ],
    ids=["opposite", "even about an axis", "even everywhere", "single precision"],
)
def test_several_nearest_rotations_are_no_mean(matrices):
    found, whole = mean_of(matrices)
    assert np.isnan(found).all()
    assert np.isnan([whole.spread, whole.radius]).all()
    assert int(whole["count"]) == len(matrices)


@pytest.mark.parametrize("runs", [1, 3])
def test_equal_runs_are_their_mean(runs):
    R = Rotation.random(rng=9).as_matrix()
    found, whole = mean_of([R] * runs)
    assert found == pytest.approx(R, abs=1e-15)
    assert float(whole.spread) == pytest.approx(0.0, abs=2e-15)


rotations = st.builds(lambda seed: Rotation.random(rng=seed), st.integers(0, 2**32))


@settings(derandomize=True, max_examples=25)
@given(rotations, rotations, st.integers(0, 2**32), st.sampled_from([1e-6, 0.3, 0.7]))
def test_the_mean_turns_with_the_runs(Q, P, seed, deviation):
    R = Rotation.from_matrix(spread(np.random.default_rng(seed), 12, deviation))
    mean, before = mean_of(R.as_matrix())
    turned, after = mean_of((Q * R * P).as_matrix())
    assert angle(turned, (Q * Rotation.from_matrix(mean) * P).as_matrix()) < 1e-12
    for name in ("spread", "radius"):
        assert float(after[name]) == pytest.approx(float(before[name]), abs=1e-12)


# ---------------------------------------------------------------- labels
def test_labels_stay_and_runs_that_failed_are_left_out(monkeypatch):
    monkeypatch.setattr("lienumba.analysis.statistics.blockwise.BLOCK_BYTES", 2000)
    monkeypatch.setattr("lienumba.analysis.statistics.rotations.AT_ONCE", 7)
    rng = np.random.default_rng(12)
    R = spread(rng, 7 * 5 * 2, 0.4).reshape(7, 5, 2, 3, 3)
    R[3, 2:] = np.nan
    R[:, 4, 0] = np.nan
    variable = attitudes(R, ("run", "time", "body"), run=[-1, *range(6)], body=["arm", "top"])
    found = mean_rotation(variable)
    assert found["mean"].dims == ("time", "body", "axis", "body_axis")
    assert found["mean"].attrs["frame"] == "body to global"
    assert found.spread.attrs["units"] == "rad"
    assert list(found.body) == ["arm", "top"]
    assert int(found.runs) == 6
    assert found["count"].values.tolist() == [[6, 6], [6, 6], [5, 5], [5, 5], [0, 5]]
    assert np.isnan(found["mean"][4, 0]).all()
    assert np.isnan(found.spread[4, 0])
    for time, body in np.ndindex(5, 2):
        own = R[1:, time, body]
        own = own[~np.isnan(own[:, 0, 0])]
        if len(own):
            assert angle(found["mean"].values[time, body], mean_of(own)[0]) < 1e-15


def test_the_nominal_run_counts_where_there_is_no_other():
    assert int(mean_rotation(attitudes(np.eye(3)[None], run=[-1]))["count"]) == 1


def test_over_another_dimension_everything_counts():
    R = attitudes(spread(np.random.default_rng(13), 8, 0.1).reshape(2, 4, 3, 3), ("run", "time"), run=[-1, 0])
    found = mean_rotation(R, dim="time")
    assert found["mean"].dims == ("run", "axis", "body_axis")
    assert found["count"].values.tolist() == [4, 4]


@pytest.mark.parametrize("shape", [(0, 3), (4, 0)])
def test_nothing_has_no_mean(shape):
    found = mean_rotation(attitudes(np.empty((*shape, 3, 3)), ("run", "time")))
    assert found["mean"].shape == (shape[1], 3, 3)
    assert np.isnan(found["mean"]).all()


@pytest.mark.parametrize("kept", [0, 2**30])
def test_of_a_sweep_in_a_file(tmp_path, monkeypatch, kept):
    """Read by windows of runs, all labels at once or one after the other."""
    monkeypatch.setattr("lienumba.analysis.statistics.blockwise.BLOCK_BYTES", 1500)
    monkeypatch.setattr("lienumba.analysis.statistics.blockwise.KEPT_BYTES", kept)
    monkeypatch.setattr("lienumba.store.windows.WINDOW_BYTES", 700)
    R = spread(np.random.default_rng(14), 40 * 3 * 2, 0.2).reshape(40, 3, 2, 3, 3)
    R[7, 1:] = np.nan
    made = dataset(
        variables={"rotation": R}, times=[0.0, 1.0, 2.0], runs=range(-1, 39), bodies=["arm", "top"], joints=(),
        constraints=(), inputs={}, input_units={}, attributes={},
    )  # fmt: skip
    made.to_netcdf(tmp_path / "runs.nc")
    with xr.open_dataset(tmp_path / "runs.nc") as ds:
        for dim in ("run", "time"):
            found = mean_rotation(ds.rotation, dim)
            assert not ds.rotation.variable._in_memory
            assert found.identical(mean_rotation(made.rotation, dim))
        assert rotation_error(ds.rotation, np.eye(3)).identical(rotation_error(made.rotation, np.eye(3)))
    assert found["count"].max() == 3
    assert layout.VARIABLES["rotation"].frame == found["mean"].attrs["frame"]


# ---------------------------------------------------------------- bad input
def refused(call, *words):
    with pytest.raises(lienumba.ScenarioError) as error:
        call()
    for word in words:
        assert word in str(error.value)
    assert "\n" not in str(error.value)


def test_what_is_no_rotation_is_named():
    R = spread(np.random.default_rng(15), 6, 0.1).reshape(3, 2, 3, 3)
    R[2, 1] *= 1.01
    variable = attitudes(R, ("run", "time"), time=[0.0, 0.5])
    message = "the matrix at run 2, time 0.5 is no rotation, since R^T R is 0.02 off the identity"
    refused(lambda: mean_rotation(variable), message)
    refused(lambda: rotation_error(variable, np.eye(3)), message)
    refused(lambda: rotation_error(variable[:2], np.diag([1.0, 1.0, -1.0])), "is no rotation, since it mirrors")
    refused(lambda: rotation_error(variable[:2], 2.0 * np.eye(3)), "the matrix is no rotation, since R^T R is 3 off")


def test_wrong_dimensions_are_named():
    R = attitudes(spread(np.random.default_rng(16), 4, 0.1).reshape(2, 2, 3, 3), ("run", "time"))
    refused(lambda: mean_rotation(R, dim="runs"), '"runs" is no dimension of the variable rotation', '"run"')
    refused(lambda: mean_rotation(R.isel(axis=0)), '"axis" is no dimension')
    refused(lambda: mean_rotation(R.isel(axis=[0, 1])), "rotation: has not 3 entries")
    refused(lambda: mean_rotation(R.to_dataset()), "a whole dataset has no numbers to compare; give one variable")
    refused(lambda: rotation_error(R, R.isel(time=[1])), "rotation: has other labels of time than rotation")
    refused(lambda: rotation_error(R, None), "reference: has the shape ()")
    refused(lambda: rotation_error(R, np.eye(2)), "reference: has the shape (2, 2); give a 3x3 matrix")
