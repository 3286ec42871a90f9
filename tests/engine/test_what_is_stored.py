"""Courses in single precision, and what is stored only where it is asked for."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import lienumba
from lienumba.engine.replay import again
from lienumba.engine.select_run import worst
from lienumba.figures import figure
from lienumba.store import shards
from tests.facade import ScenarioError, resolve
from tests.rigs.disturbed import assert_same_data, sweep

SINGLE = {"every": 0.01, "precision": {"rotation": "float32", "energy": "float32"}}
RUNS = 12


@pytest.fixture(scope="module")
def double() -> Any:
    return lienumba.run(sweep(RUNS, every=0.01, also=["multiplier"]))


def nothing(event: object) -> None:
    pass


@pytest.mark.parametrize("way", ["memory", "disk", "resumed"])
def test_single_precision_is_what_double_precision_rounds_to(
    double: Any, way: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    target = None if way == "memory" else tmp_path / "out.nc"
    if way == "resumed":
        monkeypatch.setattr(shards, "PAUSE", 0.0)
        lienumba.run(sweep(RUNS, **SINGLE), output=target, runs=[1, 5]).close()
    with lienumba.run(sweep(RUNS, **SINGLE), output=target, resume=way == "resumed") as ds:
        for name in ds.data_vars:
            single = name in SINGLE["precision"]
            assert ds[name].dtype == (np.float32 if single else double[name].dtype), name
            assert ("precision" in ds[name].attrs) == single
            np.testing.assert_array_equal(ds[name], double[name].astype(ds[name].dtype))


def test_one_word_is_for_all_courses_and_for_no_count_and_no_end(double: Any) -> None:
    ds = lienumba.run(sweep(RUNS, every=0.01, precision="float32"))
    singles = {str(name) for name, x in ds.data_vars.items() if x.dtype == np.float32}
    assert singles == {str(name) for name, x in ds.data_vars.items() if "time" in x.dims and "iterations" not in name}
    np.testing.assert_array_equal(ds.last_rotation, double.last_rotation)
    np.testing.assert_array_equal(ds.max_energy_drift, double.max_energy_drift)


def test_courses_of_some_runs_too() -> None:
    ds = lienumba.run(sweep(RUNS, every=0.01, mode="summary", full_runs="3", precision={"rotation": "float32"}))
    assert (ds.rotation.dtype, ds.position.dtype) == (np.float32, np.float64)


def test_what_single_precision_cannot_hold_is_infinite() -> None:
    data = sweep(2, every=0.05, precision="float32", variables=["large"])
    data |= {"quantities": [{"name": "large", "type": "expression", "value": "1e30*1e30"}], "measures": []}
    assert np.isposinf(lienumba.run(data).large).all()


def test_a_replay_compares_what_was_stored_and_has_double_precision(double: Any) -> None:
    done = again(lienumba.run(sweep(RUNS, **SINGLE)), "it", 7, None, False, nothing)
    assert done.same, done.sentence
    assert done.dataset.rotation.dtype == np.float64
    np.testing.assert_array_equal(done.dataset.rotation.sel(time=double.time)[0], double.rotation.sel(run=7))


@pytest.mark.parametrize(
    ("precision", "message"),
    [
        ("half", 'output.precision = "half": is no precision; give "float64" or "float32", or a table'),
        ({"rotation": 32}, "output.precision.rotation = 32: is no precision"),
        ({"rotatoin": "float32"}, 'is not known; the nearest known name is "rotation"'),
        ({"position_iterations": "float32"}, "counts, and is stored in whole numbers; leave it out"),
    ],
)
def test_what_is_no_precision_is_told(precision: object, message: str) -> None:
    with pytest.raises(ScenarioError) as told:
        resolve(sweep(precision=precision))
    assert message in str(told.value)


def test_single_precision_is_no_reference(tmp_path: Path) -> None:
    lienumba.run(sweep(1, every=0.05, **{"precision": "float32"}), output=tmp_path / "single.nc").close()
    study = sweep(1, every=0.05) | {
        "study": {"grid": [{"integrator.step": [1e-3]}], "reference": {"file": str(tmp_path / "single.nc")}}
    }
    with pytest.raises(ScenarioError, match="in single precision; leave out output"):
        lienumba.run(study)


def test_what_says_the_same_is_stored_where_it_is_asked_for(double: Any) -> None:
    usual = lienumba.run(sweep(RUNS, every=0.01))
    assert set(double.data_vars) - set(usual.data_vars) == {"multiplier"}
    assert_same_data(usual, double.drop_vars(["multiplier", "constraint"]))
    np.testing.assert_allclose(double.multiplier.values, double.joint_force.values[:, :, 0], rtol=1e-14)
    assert resolve(sweep(also=["multiplier"])).data.output.variables[-1] == "multiplier"


def test_a_request_for_it_is_told_what_to_do() -> None:
    usual = lienumba.run(sweep(RUNS, every=0.01))
    remedy = r'it is stored where a scenario asks for it: give output.also = \["multiplier"\]'
    with pytest.raises(ScenarioError, match=remedy):
        worst(usual, "multiplier")
    with pytest.raises(ScenarioError, match=remedy):
        figure(usual, "multiplier")
    with pytest.raises(ScenarioError, match=r'output.also\[0\] = "multplier": is not known'):
        resolve(sweep(also=["multplier"]))


def test_a_replay_has_it_where_the_sweep_had(double: Any) -> None:
    done = again(double, "it", 2, None, False, nothing)
    assert done.same
    assert isinstance(done.dataset.multiplier, xr.DataArray)
