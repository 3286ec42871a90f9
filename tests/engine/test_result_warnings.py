"""Good runs that are not accurate carry a warning, accurate ones none."""

import warnings

import numpy as np
import pytest

import lienumba
from lienumba.errors import ResultWarning
from tests.facade import resolve
from tests.rigs.places import SCENARIOS

PENDULUM = {
    "model": {
        "bodies": [{"name": "bob", "mass": 1.2, "inertia": [0.01, 0.01, 0.002], "position": [0.3, 0, -0.4]}],
        "joints": [
            {"name": "pivot", "type": "revolute", "bodies": ["ground", "bob"], "at": [0, 0, 0], "axis": [0, 1, 0]}
        ],
    },
    "integrator": {"method": "rk4", "end_time": 20.0},
    "output": {"every": 1.0},
}
VARY = {"bodies.bob.mass": {"distribution": "uniform", "low": 1.0, "high": 2.0}}
FREE = {
    "model": {
        "gravity": [0, 0, 0],
        "bodies": [{"name": "b", "mass": 1, "inertia": [1, 2, 3], "angular_velocity": [0.01, 5, 0.01]}],
    },
    "integrator": {"method": "rk4", "end_time": 10.0},
    "output": {"every": 0.5},
}


def run(scenario, **integrator):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        ds = lienumba.run({**scenario, "integrator": scenario["integrator"] | integrator})
    return ds, [str(x.message) for x in caught if x.category is ResultWarning]


def test_a_frictionless_pendulum_that_stops_is_no_good_result(tmp_path):
    """A step of 0.5 s leaves nothing of its motion."""
    ds, told = run(PENDULUM, step=0.5)
    assert ds.status.item() == 0
    assert ds.max_relative_energy_drift.item() == pytest.approx(
        ds.max_energy_drift.item() / np.ptp(ds.kinetic_energy.values), rel=1e-12
    )
    assert ds.attrs["warnings"].splitlines() == told
    assert told[0].startswith("max_relative_energy_drift = ")
    assert told[0].endswith("give a smaller integrator.step than 0.5 s, or a tolerance")
    path = tmp_path / "out.nc"
    with pytest.warns(ResultWarning):
        lienumba.run({**PENDULUM, "integrator": PENDULUM["integrator"] | {"step": 0.5}}, output=path)
    assert lienumba.analysis.summarise(ds).warnings == tuple(told)
    assert told[0] in repr(lienumba.analysis.summarise(ds))


def test_an_accurate_one_says_nothing():
    ds, told = run(PENDULUM, step=0.01)
    assert not told
    assert "warnings" not in ds.attrs
    assert ds.max_relative_energy_drift.item() < 1e-6


def test_only_the_runs_concerned_are_named():
    """Heavier gravity swings faster: the step is too long for some runs."""
    vary = {"model.gravity[2]": {"distribution": "choice", "values": [-0.1, -10.0, -400.0, -401.0]}}
    scenario = PENDULUM | {"sweep": {"runs": 8, "seed": 1, "vary": vary}}
    ds, told = run(scenario, step=0.02)
    bad = ds.run.values[ds.max_relative_energy_drift.values > 1e-3].tolist()
    assert 0 < len(bad) < 8
    assert f"above 0.001 in {len(bad)} of 8 runs ({', '.join(map(str, bad[:5]))}" in told[0]


def test_what_spins_freely_is_measured_by_its_kinetic_energy():
    """It exchanges none but what the method loses."""
    assert not run(FREE, step=0.01)[1]
    assert run(FREE, step=0.5)[1]


def test_what_rests_has_no_drift():
    still = {**FREE, "model": {"gravity": [0, 0, 0], "bodies": [{"name": "b", "mass": 1, "inertia": [1, 2, 3]}]}}
    ds, told = run(still, step=0.1)
    assert ds.max_relative_energy_drift.item() == 0.0
    assert not told


def test_the_law_that_became_undefined_is_named(tmp_path):
    """sqrt of an angle that passes 0 at 1.617 s: the law, its argument, the time and the run."""
    joint = {"quantities": [{"name": "p", "type": "joint", "joint": "pivot"}]}
    law = {"forces": [{"name": "motor", "type": "actuator", "joint": "pivot", "value": "sqrt(p.angle)"}]}
    scenario = {**PENDULUM, "model": {**PENDULUM["model"], **joint, **law}}
    ds, told = run(scenario, step=1e-3)
    assert ds.status.item() == 1
    assert told[0].startswith("motor.value: undefined at t = 1.61")
    assert "in run 0 where p.angle = -" in told[0]


def test_parts_of_a_sweep_warn_as_the_whole_does(tmp_path):
    scenario = {**PENDULUM, "sweep": {"runs": 4, "vary": VARY}, "integrator": PENDULUM["integrator"] | {"step": 0.5}}
    with pytest.warns(ResultWarning):
        whole = lienumba.run(scenario)
    parts = [tmp_path / "a.nc", tmp_path / "b.nc"]
    for n, part in enumerate(parts):
        with pytest.warns(ResultWarning):
            lienumba.run(scenario, output=part, part=(n + 1, 2))
    merged = lienumba.merge(parts, output=tmp_path / "out.nc")
    assert merged.attrs["warnings"] == whole.attrs["warnings"]


GALLERY = sorted(x.stem for x in SCENARIOS.glob("*.toml") if x.stem not in ("template", "heavy_top_study"))


@pytest.mark.release
@pytest.mark.parametrize("name", GALLERY)
def test_the_gallery_has_no_warnings(name):
    scenario = resolve(SCENARIOS / f"{name}.toml")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of inertias as the paper prints them
        ds = lienumba.run(scenario, runs=scenario.labels[:16])
    assert "warnings" not in ds.attrs
