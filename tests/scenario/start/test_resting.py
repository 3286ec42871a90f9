"""Runs that start in their equilibria: each in its own, and what is told of those that have none."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import lienumba
from lienumba.scenario.start.hint import RESTS
from lienumba.scenario.start.prepare import check_initial
from tests.facade import resolve

G = 9.81
ARM = 1.2 * G * 0.5
RUNS = [1.0, 5.0, 40.0, 3.0, 7.0, 9.0, 2.0, 11.0, 6.0, 4.0]


def pendulum(**sections: Any) -> dict[str, Any]:
    """A bob of 1.2 kg at 0.5 m on a hinge with a coil spring that is free at 1 rad; an angle of 0 hangs."""
    bob = {"name": "bob", "mass": 1.2, "inertia": [0.02, 0.02, 0.01]}
    pivot = {
        "name": "pivot", "type": "revolute", "bodies": ["ground", "bob"], "points": [[0, 0, 0], [0, 0, 0.5]],
        "axes": [[0, 1, 0]] * 2, "references": [[1, 0, 0]] * 2, "angle": 0.2, "rate": 3.0,
    }  # fmt: skip
    coil = {"name": "coil", "type": "torsion_spring", "joint": "pivot", "stiffness": 3.0, "free_angle": 1.0}
    seen = {"name": "swing", "type": "joint", "joint": "pivot"}
    model = {"bodies": [bob], "joints": [pivot], "forces": [coil], "quantities": [seen]}
    short = {"step": 1e-3, "end_time": 0.05}
    return {"model": model, "integrator": short, "start": {"from": "equilibrium"}, **sections}


def varied(**columns: list[float]) -> dict[str, Any]:
    return {"sampler": "table", "table": {"columns": {name.replace("__", "."): x for name, x in columns.items()}}}


def slide(**column: list[float]) -> dict[str, Any]:
    """A block of 2 kg on a vertical slide, with a spring of 100 N/m that is free at 0."""
    block = {"name": "block", "mass": 2.0, "inertia": [1, 1, 1]}
    rail = {"name": "rail", "type": "prismatic", "bodies": ["ground", "block"], "points": [[0, 0, 0]] * 2,
            "axes": [[0, 0, 1]] * 2, "references": [[1, 0, 0]] * 2, "displacement": 0.0}  # fmt: skip
    coil = {"name": "coil", "type": "actuator", "joint": "rail", "value": "-k*height.displacement"}
    seen = {"name": "height", "type": "joint", "joint": "rail"}
    return {
        "parameters": {"k": 100.0},
        "model": {"bodies": [block], "joints": [rail], "forces": [coil], "quantities": [seen]},
        "integrator": {"step": 1e-3, "end_time": 0.05}, "start": {"from": "equilibrium"}, "sweep": varied(**column),
    }  # fmt: skip


@pytest.mark.parametrize(
    "integrator",
    [{"step": 1e-3}, {"tolerance": 1e-8, "coordinates": "joint"}, {"step": 2e-3, "group": "SE3", "method": "rk4"}],
)
def test_every_run_starts_where_it_rests_and_stays(integrator: dict[str, Any]) -> None:
    """k (angle - 1) = -m g a sin(angle)."""
    scenario = pendulum(sweep=varied(forces__coil__stiffness=RUNS), integrator=integrator | {"end_time": 0.05})
    found = lienumba.run(scenario)
    x, k = found["swing.angle"].values, np.array(RUNS)
    np.testing.assert_allclose(k * (x[:, 0] - 1.0), -ARM * np.sin(x[:, 0]), atol=1e-12)
    np.testing.assert_allclose(x, x[:, :1] + np.zeros_like(x), atol=1e-12)
    assert found.start_equilibrium.values.tolist() == [0] * len(RUNS)
    assert abs(found["swing.rate"].values[:, 0]).max() == 0.0


def test_bits_are_those_of_other_workers_parts_a_resumed_sweep_and_a_replay(tmp_path: Path) -> None:
    vary = {"forces.coil.stiffness": {"distribution": "uniform", "low": 1.0, "high": 40.0}}
    scenario, whole = pendulum(sweep={"runs": 10, "vary": vary}), tmp_path / "whole.nc"
    lienumba.run(scenario, output=whole, workers=1, overrides={"sweep.runs": 3})
    lienumba.run(scenario, output=whole, workers=1, resume=True)
    other = lienumba.run(scenario, workers=2)
    for n in (1, 2):
        lienumba.run(scenario, output=tmp_path / f"part{n}.nc", part=(n, 2))
    merged = tmp_path / "merged.nc"
    lienumba.merge([tmp_path / "part1.nc", tmp_path / "part2.nc"], merged)
    for file in (whole, merged):
        with _opened(file) as ds:
            for name in ("swing.angle", "position", "start_equilibrium"):
                assert ds[name].values.tobytes() == other[name].values.tobytes()
    one = lienumba.replay(whole, run=4)
    assert one["swing.angle"].values.tobytes() == other["swing.angle"].values[4].tobytes()


def test_a_replay_starts_from_what_is_stored_and_searches_no_equilibrium() -> None:
    """Another processor finds one that differs by roundoff; here the start of another run takes its place."""
    vary = {"forces.coil.stiffness": {"distribution": "uniform", "low": 1.0, "high": 40.0}}
    ds = lienumba.run(pendulum(sweep={"runs": 6, "vary": vary}))
    assert ds.start_number.values[0] == "bob.position.x"
    np.testing.assert_array_equal(ds.start_state.values[:, :3], ds.position.values[:, 0, 0])
    ds["start_state"][4] = ds["start_state"][5]
    with pytest.warns(UserWarning, match="not the same as run 4"):
        one = lienumba.replay(ds, run=4)
    assert one["swing.angle"].values[0, 0] == ds["swing.angle"].values[5, 0]
    assert one["swing.angle"].values[0, -1] != ds["swing.angle"].values[5, -1]


def _opened(file: Path) -> Any:
    import xarray as xr

    return xr.open_dataset(file)


def test_a_run_without_an_equilibrium_fails_alone() -> None:
    found = lienumba.run(slide(parameters__k=[50.0, 0.0, 200.0, 100.0]))
    assert found.status.values.tolist() == [0, 16, 0, 0]
    assert found.start_equilibrium.values.tolist() == [0, 1, 0, 0]
    alone = lienumba.run(slide(parameters__k=[50.0, 200.0, 100.0]))
    height = found["height.displacement"].values
    assert height[[0, 2, 3]].tobytes() == alone["height.displacement"].values.tobytes()
    np.testing.assert_allclose(height[[0, 2, 3], 0], -2 * G / np.array([50.0, 200.0, 100.0]), rtol=1e-12)
    assert "no_equilibrium: no equilibrium was found in which the run could start" in str(
        lienumba.analysis.summarise(found)
    )


def test_one_that_would_be_beyond_a_stop_lies_on_it() -> None:
    scenario = slide(parameters__k=[50.0, 200.0])
    scenario["model"]["limits"] = [{"name": "stop", "joint": "rail", "low": -0.2}]
    found = lienumba.run(scenario)
    assert found.status.values.tolist() == [0, 0]
    expected = np.array([[-0.2], [-2 * G / 200.0]]) + np.zeros(found["height.displacement"].shape)
    np.testing.assert_allclose(found["height.displacement"].values, expected, rtol=1e-12)


def test_an_unstable_start_is_told() -> None:
    scenario = pendulum()
    scenario["model"]["forces"] = []
    scenario["model"]["joints"][0]["angle"] = np.pi
    found = lienumba.run(scenario)
    assert found.start_equilibrium.item() == 2
    assert "the run starts in an equilibrium that is unstable" in str(lienumba.analysis.summarise(found))
    nominal = check_initial(resolve(scenario))
    assert nominal.rests is not None
    assert RESTS[nominal.rests] == "it starts in its equilibrium, which is unstable"


@pytest.mark.parametrize("coordinates", ["lie", "joint"])
def test_loops_with_redundant_rows_rest(coordinates: str) -> None:
    more = {"start.from": "equilibrium", "integrator.end_time": 0.1, "integrator.coordinates": coordinates}
    more |= {"output.every": 0.05}
    found = lienumba.run("scenarios/four_bar.toml", overrides=more)
    assert found.status.item() == 0
    assert abs(found.position - found.position.isel(time=0)).max() < 1e-11
    assert found.energy.values[0, 0] < lienumba.run("scenarios/four_bar.toml", overrides={
        "integrator.end_time": 0.1, "output.every": 0.05}).energy.values[0, 0] - 0.1  # fmt: skip


def follow(pivot: Any, *, k: float, states: Any) -> Any:
    """A torque by an angle that lags behind."""
    return pivot.effort(-k * (states.angle - 1.0)), {"angle": 5.0 * (pivot.angle - states.angle)}


def test_states_of_laws_start_where_they_settle() -> None:
    scenario = pendulum()
    lag = {"name": "lag", "type": "python", "function": follow, "joints": ["pivot"], "states": {"angle": 0.0},
           "parameters": {"k": 3.0}}  # fmt: skip
    scenario["model"]["forces"] = [lag]
    found = lienumba.run(scenario)
    x = found["swing.angle"].values[0]
    assert 3.0 * (x[0] - 1.0) == pytest.approx(-ARM * np.sin(x[0]), abs=1e-12)
    np.testing.assert_allclose(found["lag.angle"].values[0], x[0], atol=1e-12)


def test_what_drivers_move_moves_from_the_start() -> None:
    """A rotor on the pendulum turns; the pendulum rests but for what it feels of that, which is nothing."""
    scenario = pendulum()
    rotor = {"name": "rotor", "mass": 0.1, "inertia": [0.01, 0.01, 0.01]}
    axle = {"name": "axle", "type": "revolute", "bodies": ["bob", "rotor"], "points": [[0, 0, 0]] * 2,
            "axes": [[0, 1, 0]] * 2, "references": [[1, 0, 0]] * 2}  # fmt: skip
    scenario["model"]["bodies"].append(rotor)
    scenario["model"]["joints"].append(axle)
    scenario["model"]["drivers"] = [{"name": "motor", "joint": "axle", "rate": 30.0}]
    found = lienumba.run(scenario)
    assert found.status.item() == 0
    np.testing.assert_allclose(found.angular_velocity.values[0, 0, 1], [0, 30.0, 0], atol=1e-12)
    assert abs(found["swing.angle"] - found["swing.angle"].isel(time=0)).max() < 1e-12


def test_where_drivers_leave_nothing_free_the_start_is_theirs() -> None:
    scenario = pendulum()
    scenario["model"]["drivers"] = [{"name": "motor", "joint": "pivot", "value": "0.4 + 2*t"}]
    del scenario["model"]["joints"][0]["angle"], scenario["model"]["joints"][0]["rate"]
    found = lienumba.run(scenario)
    assert found.start_equilibrium.item() == 0
    np.testing.assert_allclose(found["swing.angle"].values[0], 0.4 + 2 * found.time.values, atol=1e-12)
    assert found["swing.rate"].values[0, 0] == pytest.approx(2.0, abs=1e-12)


def test_speeds_over_runs_leave_neighbours_alone() -> None:
    """Runs that rest, and runs that turn at speeds of their own, have the bits that they have alone."""
    shaft = {"name": "shaft", "mass": 1, "inertia": [0.1, 0.1, 0.1], "position": [0.3, 0, 0], "rotation": [1, 0, 0, 0]}
    bearing = {"name": "bearing", "type": "revolute", "bodies": ["ground", "shaft"], "at": [0.3, 0, 0],
               "axis": [0, 0, 1]}  # fmt: skip
    scenario = pendulum()
    model = scenario["model"]
    model["bodies"].insert(0, shaft)
    model["joints"].insert(0, bearing)
    model["joints"][1] |= {"bodies": ["shaft", "bob"], "points": [[0.1, 0, 0], [0, 0, 0.5]]}
    scenario["start"]["rotation"] = [0, 0, 1.0]
    columns = {"start.rotation[2]": [0.0, 3.0, 6.0, 9.0], "bodies.bob.mass": [1.0, 2.0, 3.0, 4.0]}
    every = lienumba.run(scenario | {"sweep": {"sampler": "table", "table": {"columns": columns}}})
    x = -every["swing.angle"].values
    np.testing.assert_allclose(x, x[:, :1] + np.zeros_like(x), atol=1e-9)
    for run in range(4):
        own = lienumba.run(scenario | {"sweep": {"sampler": "table", "table": {"columns": columns}}}, runs=[run])
        for name in ("swing.angle", "position", "velocity", "start_equilibrium"):
            assert own[name].values.tobytes() == every[name].sel(run=[run]).values.tobytes()


def test_what_is_asked_beside_it_is_refused_in_words() -> None:
    cases: list[tuple[dict[str, Any], str]] = [
        (
            {"from": "equilibrium", "qd": {"pivot": 1.0}},
            "start.qd = {pivot = 1.0}: has no meaning where each run starts in its equilibrium, whose velocities",
        ),
        (
            {"rotation": [0, 0, 1.0]},
            'start.rotation = [0.0, 0.0, 1.0]: has no meaning without an equilibrium; give from = "equilibrium"',
        ),
        ({"from": "rest"}, 'start.from = "rest": is not known; give "equilibrium": each run starts where it rests'),
    ]
    for start, sentence in cases:
        with pytest.raises(lienumba.ScenarioError) as error:
            resolve(pendulum(start=start))
        assert sentence in str(error.value)
