"""Covariances over runs and their ellipsoids, against NumPy, closed forms, symmetry and samples."""

import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation
from scipy.stats import chi2

import lienumba
from lienumba.analysis import covariance, ellipsoid, mean_rotation, rotation_covariance
from tests.analysis.statistics.attitudes import AXES, attitudes, spread


def vectors(values, axes=AXES, **labels):
    return xr.DataArray(
        values,
        {"run": np.arange(len(values)), "time": np.arange(values.shape[1]), "axis": axes, **labels},
        ("run", "time", "axis"),
        "position",
        {"units": "m", "long_name": "position of the mass centre", "frame": "global"},
    )


def matrix(C, name="covariance", **attributes):
    axes = AXES[: len(C)]
    return xr.DataArray(C, {"axis": axes, "axis_2": axes}, ("axis", "axis_2"), name, attributes)


# ---------------------------------------------------------------- covariances
def test_of_vectors_over_the_runs_that_are_there():
    x = np.random.default_rng(1).normal(size=(9, 4, 3))
    x[2, 1:] = np.nan
    x[:, 3] = np.nan
    x[5, 3] = 1.0
    found = covariance(vectors(x, run=np.arange(-1, 8)))
    assert found["covariance"].dims == ("time", "axis", "axis_2")
    assert found["covariance"].attrs["units"] == "m2"
    assert found["covariance"].attrs["frame"] == "global"
    assert found["count"].values.tolist() == [8, 7, 7, 1]
    assert int(found.runs) == 8
    for time, left in enumerate([x[1:, 0], np.delete(x[1:, 1], 1, axis=0), np.delete(x[1:, 2], 1, axis=0)]):
        assert found["covariance"].values[time] == pytest.approx(np.cov(left.T), rel=1e-13)
    assert np.isnan(found["covariance"][3]).all()


@pytest.mark.parametrize("frame", ["body", "global"])
def test_of_rotations_is_that_of_their_vectors(frame, monkeypatch):
    monkeypatch.setattr("lienumba.analysis.statistics.rotations.AT_ONCE", 40)
    R = spread(np.random.default_rng(2), 30 * 3, 0.4).reshape(30, 3, 3, 3)
    R[4, 1:] = np.nan
    variable = attitudes(R, ("run", "time"))
    mean = mean_rotation(variable)
    found = rotation_covariance(variable, mean, frame=frame)
    for time in range(3):
        own, M = Rotation.from_matrix(np.delete(R[:, time], [4] * (time > 0), axis=0)), mean["mean"].values[time]
        M = Rotation.from_matrix(M)
        u = (M.inv() * own if frame == "body" else own * M.inv()).as_rotvec()
        assert found["covariance"].values[time] == pytest.approx(np.cov(u.T), abs=1e-13)
    assert found["covariance"].attrs["units"] == "rad2"
    assert found["covariance"].attrs["frame"] == frame
    assert found["count"].values.tolist() == [30, 29, 29]
    assert found.identical(rotation_covariance(variable, frame=frame))


def test_of_a_known_cross_of_turns():
    turns = Rotation.from_rotvec(0.8 * np.concatenate([np.diag([1.0, 0.5, 0.25]), -np.diag([1.0, 0.5, 0.25])]))
    found = rotation_covariance(attitudes(turns.as_matrix()))
    assert found["covariance"].values == pytest.approx(2 * 0.64 * np.diag([1.0, 0.25, 0.0625]) / 5, abs=1e-15)


def test_about_a_rotation_of_ones_own():
    R = spread(np.random.default_rng(3), 20, 0.2)
    own = Rotation.random(rng=4)
    found = rotation_covariance(attitudes(R), own.as_matrix())
    same = xr.DataArray(own.as_matrix(), dims=("axis", "body_axis"))
    for mean in (same, same.to_dataset(name="mean")):
        assert found.identical(rotation_covariance(attitudes(R), mean))
    assert found["covariance"].values == pytest.approx(np.cov((own.inv() * Rotation.from_matrix(R)).as_rotvec().T))


rotations = st.builds(lambda seed: Rotation.random(rng=seed), st.integers(0, 2**32))


@settings(derandomize=True, max_examples=20)
@given(rotations, rotations, st.integers(0, 2**32))
def test_it_turns_with_the_frame_that_it_is_in(Q, P, seed):
    R = Rotation.from_matrix(spread(np.random.default_rng(seed), 12, 0.3))
    turned = attitudes((Q * R * P).as_matrix())
    for frame, T in (("body", P.inv().as_matrix()), ("global", Q.as_matrix())):
        before = rotation_covariance(attitudes(R.as_matrix()), frame=frame)["covariance"].values
        after = rotation_covariance(turned, frame=frame)["covariance"].values
        assert after == pytest.approx(T @ before @ T.T, abs=1e-13)


# ---------------------------------------------------------------- ellipsoids
@pytest.mark.parametrize("size", [2, 3])
@pytest.mark.parametrize("probability", [0.5, 0.997])
def test_it_holds_the_part_that_is_asked_for(size, probability):
    rng = np.random.default_rng(size)
    L = rng.normal(size=(size, size))
    found = ellipsoid(matrix(L @ L.T, units="m2"), probability)
    x = rng.normal(size=(20_000, size)) @ L.T
    inside = (((x @ found.direction.values) / found.semi_axis.values) ** 2).sum(axis=1) < 1.0
    assert inside.mean() == pytest.approx(probability, abs=4 * (probability * (1 - probability) / 20_000) ** 0.5)
    D, s = found.direction.values, found.semi_axis.values
    assert D @ np.diag(s**2) @ D.T == pytest.approx(chi2.ppf(probability, size) * L @ L.T)
    assert np.linalg.det(D) == pytest.approx(1.0)
    assert (np.diff(s) <= 0).all()
    whole, units = ("volume", "m3") if size == 3 else ("area", "m2")
    assert float(found[whole]) == pytest.approx((4.0 / 3.0 if size == 3 else 1.0) * np.pi * s.prod())
    assert (found[whole].attrs["units"], found.semi_axis.attrs["units"]) == (units, "m")


@pytest.mark.parametrize(("spread", "freedom"), [((2.0, 1.0, 0.0), 2), ((3.0, 0.0, 0.0), 1), ((0.0, 0.0, 0.0), 0)])
def test_motion_in_a_plane_has_a_flat_one(spread, freedom):
    T = Rotation.random(rng=5).as_matrix()
    found = ellipsoid(matrix(T @ np.diag(np.square(spread)) @ T.T), 0.95)
    scale = chi2.ppf(0.95, freedom) ** 0.5 if freedom else 0.0
    assert found.semi_axis.values == pytest.approx(scale * np.array(spread))
    assert (found.semi_axis.values[freedom:] == 0.0).all()
    assert int(found.freedom) == freedom
    assert float(found.volume) == 0.0


def test_at_every_label_and_nan_of_too_few_runs():
    x = np.random.default_rng(6).normal(size=(5, 3, 3))
    x[1:, 2] = np.nan
    found = ellipsoid(covariance(vectors(x)))
    assert found.semi_axis.dims == ("time", "principal")
    assert found.direction.dims == ("time", "axis", "principal")
    assert found.direction.attrs["frame"] == "global"
    assert list(found.axis) == AXES
    assert "axis_2" not in found.coords
    assert np.isnan(found.semi_axis[2]).all()
    assert np.isnan(found.volume).values.tolist() == [False, False, True]


def test_in_a_plane_two_axes_are_selected_first():
    x = vectors(np.random.default_rng(7).normal(size=(9, 2, 3)))
    found = covariance(x.sel(axis=["x", "z"]))["covariance"]
    assert found.values == pytest.approx(covariance(x)["covariance"].sel(axis=["x", "z"], axis_2=["x", "z"]).values)
    assert set(ellipsoid(found)) == {"semi_axis", "direction", "area", "freedom"}


def test_so_few_runs_that_they_always_lie_in_a_plane_have_none():
    x = np.random.default_rng(8).normal(size=(6, 3, 3))
    x[4:, 1] = np.nan
    x[3:, 2] = np.nan
    found = ellipsoid(covariance(vectors(x)))
    assert found["count"].values.tolist() == [6, 4, 3]
    assert found.freedom.values.tolist() == [3, 3, 0]
    for name in ("semi_axis", "direction", "volume"):
        assert np.isnan(found[name]).any(dim=set(found[name].dims) - {"time"}).values.tolist() == [False, False, True]
    in_a_plane = covariance(vectors(x).sel(axis=["x", "z"]))
    assert ellipsoid(in_a_plane).freedom.values.tolist() == [2, 2, 2]
    assert ellipsoid(rotation_covariance(attitudes(spread(np.random.default_rng(9), 3, 0.1)))).freedom == 0


# ---------------------------------------------------------------- bad input
@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: ellipsoid(matrix(np.diag([1.0, 2.0, -0.5]))), "has the variance -0.5 in one direction, so it is no"),
        (lambda: ellipsoid(matrix([[1.0, 0.5], [0.0, 1.0]])), "is not symmetric, so it is no covariance"),
        (lambda: ellipsoid(matrix(np.eye(2)), 1.0), "probability = 1.0: must be above 0 and below 1"),
        (lambda: ellipsoid(matrix(np.eye(2)), 95), "probability = 95: must be above 0 and below 1"),
        (lambda: ellipsoid(vectors(np.zeros((3, 2, 3)))), "position: is no covariance, which has 2 or 3 entries"),
        (lambda: ellipsoid(xr.Dataset()), "a whole dataset has no numbers to compare"),
        (lambda: ellipsoid(matrix(np.eye(2)), None), "probability = None: must be above 0 and below 1"),
        (lambda: ellipsoid(matrix(np.eye(2)), [0.5, 0.9]), "probability = [0.5, 0.9]: must be above 0 and below 1"),
        (
            lambda: ellipsoid(matrix(np.eye(2)).expand_dims("principal")),
            'covariance has a dimension "principal", which the result needs; rename it, such as by x.rename(',
        ),
        (
            lambda: covariance(vectors(np.zeros((3, 2, 3))).rename(time="axis_2")),
            'the variable position has a dimension "axis_2", which the result needs',
        ),
        (
            lambda: rotation_covariance(attitudes(np.zeros((3, 2, 3, 3)), ("run", "axis_2"))),
            'the variable rotation has a dimension "axis_2", which the result needs',
        ),
        (
            lambda: covariance(vectors(np.zeros((3, 2, 3))), dim="axis"),
            'dim = "axis": is a dimension of each value, not of runs; give one of "run", "time"',
        ),
        (lambda: mean_rotation(attitudes(np.eye(3)[None]), dim="axis"), 'not of runs; give one of "run"'),
        (lambda: rotation_covariance(attitudes(np.eye(3)[None]), "mean"), 'mean = "mean": has no numbers; give a 3x3'),
        (lambda: rotation_covariance(attitudes(np.eye(3)[None]), np.eye(2)), "mean: has the shape (2, 2); give a 3x3"),
        (
            lambda: rotation_covariance(attitudes(np.eye(3)[None]), frame="boddy"),
            'frame = "boddy": is not known; the nearest known name is "body"',
        ),
        (
            lambda: rotation_covariance(attitudes(np.eye(3)[None]), attitudes(np.eye(3)[None])),
            "mean: has the dimension run; give one rotation for all runs",
        ),
    ],
)
def test_bad_input_is_told(call, words):
    with pytest.raises(lienumba.ScenarioError) as error:
        call()
    assert words in str(error.value)


def test_what_is_no_covariance_is_named():
    C = xr.concat([matrix(np.eye(3)), matrix(-np.eye(3))], xr.DataArray([0.0, 0.5], dims="time", name="time"))
    with pytest.raises(lienumba.ScenarioError, match=r"covariance: the matrix at time 0\.5 has the variance -1"):
        ellipsoid(C)
