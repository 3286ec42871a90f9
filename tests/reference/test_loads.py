"""Force laws, formulas of time and parameters, and sweeps, by the engine "numba" as by the compiled one."""

import numpy as np
import pytest

import lienumba
from tests.reference.test_joints import STATE, differences
from tests.rigs.parts import body

pytestmark = [pytest.mark.release, pytest.mark.usefixtures("compiled")]
PAIR = {"type": "spring_damper", "bodies": ["bob", "far"], "points": [[0, 0, 0.1], [0.05, 0, 0]]}
SCENARIO = {
    "parameters": {"k": 40.0, "f": 3.0},
    "model": {
        "gravity": [0, "0.2*sin(3*t)", -9.81],
        "bodies": [
            body("bob", 1.2, [0.02, 0.03, 0.015, 0.001, 0.002, 0.0], position=[0.3, 0, -0.4], rotation=[1, 0, 0, 0]),
            body("far", 0.7, [0.02, 0.03, 0.01], position=[0.9, 0.1, -0.4], rotation=[1, 0, 0, 0],
                 velocity=[0, 0, 0.1], angular_velocity=[0, 0, 9]),
        ],
        "joints": [
            {"name": "pivot", "type": "revolute", "bodies": ["ground", "bob"], "at": [0, 0, 0], "axis": [0, 1, 0],
             "rate": 3.0},
            {"name": "tube", "type": "cylindrical", "bodies": ["ground", "far"], "at": [0.9, 0.1, -0.4],
             "axis": [0, 0, 1]},
        ],
        "forces": [
            PAIR | {"stiffness": "k", "damping": "1 + 0.1*t", "free_length": "0.5 + 0.1*sin(f*t)"},
            PAIR | {"stiffness": "k*(1 + 0.1*t)"},
            {"type": "force", "body": "far", "point": [0, 0.1, 0], "frame": "body", "value": ["cos(f*t)", 1, 0.2]},
            {"type": "force", "body": "bob", "value": [1, "t*t", 0.2]},
            {"type": "torque", "body": "bob", "value": [1, "t", 0.2]},
            {"type": "torque", "body": "far", "frame": "body", "value": [1, "t", 0.2]},
            {"type": "torsion_spring", "joint": "pivot", "stiffness": 2.0, "damping": 0.1, "free_angle": 0.3},
            {"type": "actuator", "joint": "tube", "coordinate": "displacement", "stiffness": 30.0, "damping": 0.5,
             "target": "0.1*sin(t)", "limit": 4.0},
            {"type": "actuator", "joint": "tube", "coordinate": "angle", "stiffness": 3.0, "damping": 0.5,
             "target": "9*t", "value": "0.1*k"},
        ],
    },
    "quantities": [{"name": "tip", "type": "point", "body": "bob", "point": [0, 0, 0.3]}],
    "integrator": {"step": 1e-3, "end_time": 0.2},
    "output": {"every": 0.05},
}  # fmt: skip
VARY = {
    "parameters.k": {"distribution": "normal", "std": 3.0},
    "bodies.far.mass": {"distribution": "uniform", "low": 0.5, "high": 0.9},
    "joints.pivot.rate": {"distribution": "normal", "std": 0.3},
}


def test_loads_of_every_kind_in_a_sweep():
    found = differences(SCENARIO, {"sweep": {"runs": 11, "seed": 1, "vary": VARY}})
    assert max(found[name] for name in STATE) < 1e-11
    assert max(found[name] for name in ("tip", "work", "energy", "joint_force")) < 1e-11


def test_a_run_does_not_depend_on_its_neighbours_nor_on_threads():
    sweep = {"sweep": {"runs": 11, "seed": 1, "vary": VARY}, "integrator.engine": "numba", "integrator.end_time": 0.02}
    sweep |= {"output.every": 0.01}
    every = lienumba.run(SCENARIO, overrides=sweep, workers=2, progress=False)
    one = lienumba.run(SCENARIO, overrides=sweep, runs=[9], workers=1, progress=False)
    for name in STATE:
        np.testing.assert_array_equal(every[name].sel(run=[9]).values, one[name].values)


def test_a_step_in_which_a_body_turns_too_far_is_a_status():
    keys = {"integrator.engine": "numba", "integrator.step": 0.5, "integrator.end_time": 1.0, "output.every": 0.5}
    found = lienumba.run("scenarios/heavy_top.toml", overrides=keys, progress=False)
    assert found.status.values.tolist() == [4]
    assert np.isnan(found.position.values[0, 1:]).all()
    assert found.steps.values.tolist() == [0]


def test_what_is_prepared_replayed_or_on_disk_is_integrated_by_this_engine(tmp_path):
    keys = {"integrator.engine": "numba", "integrator.end_time": 0.02, "output.every": 0.01}
    keys |= {"sweep": {"runs": 3, "seed": 1, "vary": VARY}}
    memory = lienumba.run(SCENARIO, overrides=keys, progress=False)
    disk = lienumba.run(SCENARIO, overrides=keys, output=tmp_path / "out.nc", progress=False)
    again = lienumba.replay(tmp_path / "out.nc", 2, progress=False)
    prepared = lienumba.prepare(SCENARIO, overrides=keys).run()
    assert 'engine = "numba"' in again.attrs["scenario"]
    for name in STATE:
        np.testing.assert_array_equal(memory[name].values, disk[name].values)
        np.testing.assert_array_equal(memory[name].values, prepared[name].values)
        np.testing.assert_array_equal(memory[name].isel(run=[2], time=-1).values, again[name].isel(time=-1).values)
