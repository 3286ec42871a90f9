"""Which points a study has, what they are called, and that each is the plain run with these settings, bit by bit."""

import numpy as np
import pytest
import xarray as xr

import lienumba
from lienumba.scenario.base import toml
from lienumba.scenario.reading.extends import replaced_by
from lienumba.scenario.study_points import changed
from lienumba.store.outputs import write
from tests.facade import resolve
from tests.rigs.studies import BALL, VARIED, ball, top

PLAIN = ("status", "end_time", "steps", "rejected_steps", "max_position_violation", "max_energy_drift")
TIMES = ["time_per_run", "time_per_run_spread"]
CROSSED = {"integrator.method": ["heun", "rk4"], "integrator.step": [2e-3, 1e-3]}


def test_every_point_is_the_plain_run_with_its_settings():
    ds = lienumba.run(top(CROSSED, sweep=VARIED))
    assert ds["position_error"].dims == ("run", "method", "step")
    fine = lienumba.run(top(sweep=VARIED), overrides={"integrator.method": "dop853"})
    for method in CROSSED["integrator.method"]:
        for step in CROSSED["integrator.step"]:
            point = ds.sel({"method": method, "step": step})
            plain = lienumba.run(top(sweep=VARIED), overrides={"integrator.method": method, "integrator.step": step})
            for name in PLAIN:
                np.testing.assert_array_equal(point[name], plain[name], name)
            np.testing.assert_array_equal(ds["bodies.top.mass"], plain["bodies.top.mass"])
            for name, distance in (
                ("position", np.linalg.norm(plain.position - fine.position, axis=-1)),
                ("velocity", np.linalg.norm(plain.velocity - fine.velocity, axis=-1)),
                ("angular_velocity", np.linalg.norm(plain.angular_velocity - fine.angular_velocity, axis=-1)),
                ("rotation", angle(plain.rotation.values, fine.rotation.values)),
            ):
                np.testing.assert_allclose(point[f"{name}_error"], distance.max(axis=(1, 2)), rtol=1e-9, atol=1e-14)
                np.testing.assert_allclose(point[f"final_{name}_error"], distance[:, -1, 0], rtol=1e-9, atol=1e-14)
            stages = {"heun": 2, "rk4": 4}[method]
            assert (point["evaluations"] == stages * plain["steps"]).all()
            assert point["max_position_iterations"].values == pytest.approx(plain.position_iterations.max("time"))


def angle(A, B):
    """By the trace of A^T B, accurate where the angle is not small; the smallest errors here are 1e-9."""
    return 2 * np.arcsin(np.sqrt(((A - B) ** 2).sum(axis=(-1, -2)) / 8))


def test_nothing_but_times_depends_on_the_workers(tmp_path):
    data = top(CROSSED, sweep=VARIED | {"runs": 20}, repeats=2)
    one, two = (lienumba.run(data, workers=workers) for workers in (1, 2))
    xr.testing.assert_identical(*(ds.drop_vars(TIMES).drop_attrs(deep=False) for ds in (one, two)))
    again = tmp_path / "again.toml"
    again.write_text(one.attrs["scenario"], encoding="utf-8")
    three = lienumba.run(again)
    assert three.attrs["scenario"] == one.attrs["scenario"]
    assert three.attrs["scenario_sha256"] == one.attrs["scenario_sha256"]
    xr.testing.assert_identical(*(ds.drop_vars(TIMES).drop_attrs(deep=False) for ds in (one, three)))
    assert (one["time_per_run"] > 0).all()
    write(one, tmp_path / "study.nc")
    with xr.open_dataset(tmp_path / "study.nc") as read:
        xr.testing.assert_identical(read.load().drop_vars([]), one)


def test_runs_by_their_labels():
    data = top({"integrator.step": [2e-3, 1e-3]}, sweep=VARIED)
    whole, some = lienumba.run(data), lienumba.run(data, runs=[2, -1])
    assert some["run"].values.tolist() == [2, -1]
    np.testing.assert_array_equal(whole["position_error"].sel(run=2), some["position_error"].sel(run=2))
    assert float(some["bodies.top.mass"].sel(run=-1)) == 15.0


def test_names_of_dimensions():
    grid = {
        "bodies.ball.mass": [0.4, 1],
        "projection.velocity": ["mass", "none"],
        "bodies.ball.angular_velocity[1]": [1.0],
        "bodies.ball.velocity": [[0, 0, 1], [0, 0, 2]],
        "parameters.steps": [1.0, 2.0],
    }
    plan = resolve(ball(grid, parameters={"steps": 1.0, **BALL["parameters"]})).plan
    assert {c.name: (c.dim, list(c.values), c.units, c.path) for c in plan.coordinates} == {
        "mass": ("mass", [0.4, 1.0], "kg", "bodies.ball.mass"),
        "projection.velocity": ("projection.velocity", ["mass", "none"], "1", "projection.velocity"),
        "angular_velocity[1]": ("angular_velocity[1]", [1.0], "rad s-1", "bodies.ball.angular_velocity[1]"),
        "bodies.ball.velocity": (
            "bodies.ball.velocity", ["[0, 0, 1]", "[0, 0, 2]"], "1", "bodies.ball.velocity",
        ),
        "parameters.steps": ("parameters.steps", [1.0, 2.0], "1", "parameters.steps"),
    }  # fmt: skip
    assert plan.shape == (2, 2, 1, 2, 2)
    assert len(plan.points) == 16


def test_several_grids_are_cases():
    first, second = {"integrator.method": ["heun", "rk4"], "integrator.step": [0.02, 0.01]}, {
        "model.bodies[0].mass": [0.5, 0.6], "integrator.dexpinv": ["closed", 1],
    }  # fmt: skip
    ds = lienumba.run(ball(first, second))
    assert ds["rotation_error"].dims == ("run", "case")
    assert ds["case"].values.tolist() == list(range(8))
    assert ds["method"].values.tolist() == ["heun", "heun", "rk4", "rk4", "", "", "", ""]
    assert ds["dexpinv"].values.tolist() == ["", "", "", "", "closed", "1", "closed", "1"]
    np.testing.assert_array_equal(ds["step"], [0.02, 0.01, 0.02, 0.01, *[np.nan] * 4])
    np.testing.assert_array_equal(ds["mass"], [*[np.nan] * 4, 0.5, 0.5, 0.6, 0.6])
    path = "bodies.ball.mass"
    assert ds["mass"].attrs == {"units": "kg", "long_name": path, "role": "grid", "path": path}
    alone = lienumba.run(ball(first))
    np.testing.assert_array_equal(ds["rotation_error"][:, :4], alone["rotation_error"].values.reshape(1, 4))


def test_points_that_differ_in_what_they_solve_have_references_of_their_own():
    grid = {"bodies.top.mass": [15, 30], "integrator.step": [1e-3, 5e-4]}
    ds = lienumba.run(top(grid))
    for mass in grid["bodies.top.mass"]:
        fine = lienumba.run(top(), overrides={"bodies.top.mass": mass, "integrator.method": "dop853"})
        plain = lienumba.run(top(), overrides={"bodies.top.mass": mass})
        error = np.linalg.norm(plain.position - fine.position, axis=-1).max()
        assert ds["position_error"].sel(mass=mass, step=1e-3).item() == pytest.approx(error, rel=1e-9)


def test_a_setting_takes_the_place_of_its_alternative():
    raw = {"integrator": {"step": 1e-3, "end_time": 1}, "projection": {"tolerance": 1e-9}, "output": {"every": 0.1}}
    assert changed(raw, {"integrator.tolerance": 1e-6})["integrator"] == {"tolerance": 1e-6, "end_time": 1}
    assert changed({"integrator": {"tolerance": 1e-6}}, {"integrator.step": 1e-3})["integrator"] == {"step": 1e-3}
    assert changed(raw, {"projection.tolerance": 1e-6})["projection"] == {"tolerance": 1e-6}
    assert raw["integrator"] == {"step": 1e-3, "end_time": 1}
    assert "tolerance" in replaced_by("step")
    assert replaced_by("mass") == ()


def test_a_system_may_be_a_study():
    data = ball({"integrator.step": [0.02, 0.01]}, repeats=2)
    section = data["study"]
    system = lienumba.System()
    system._data = {key: value for key, value in data.items() if key != "study"}
    system.study(reference=section["reference"], grid=section["grid"], repeats=2)
    assert resolve(system).sha256() == resolve(data).sha256()
    assert len(resolve(system).plan.points) == 2


def test_choices_and_formulas_are_values_too(tmp_path):
    tables = {"thrust": {"times": [0, 1], "values": [0, 2]}}
    data = ball(
        {"tables.thrust.interpolation": ["linear", "cubic"], "bodies.ball.mass": ["height/4", 0.7]}, tables=tables
    )
    data["model"]["forces"][0]["value"][1] = "thrust(t)"
    plan = resolve(data).plan
    assert [list(c.values) for c in plan.coordinates] == [["linear", "cubic"], ["height/4", "0.7"]]
    assert [p.scenario.data.model.bodies[0].mass for p in plan.points] == [0.5, 0.7, 0.5, 0.7]


def test_a_study_that_extends_another_has_its_own_grid(tmp_path):
    below, above = tmp_path / "below.toml", tmp_path / "above.toml"
    below.write_text(toml.dumps(ball({"integrator.step": [0.02, 0.01]})), encoding="utf-8")
    above.write_text('extends = "below.toml"\n[[study.grid]]\n"integrator.method" = ["heun"]\n', encoding="utf-8")
    scenario = resolve(above)
    assert scenario.data.study.grid == [{"integrator.method": ["heun"]}]
    assert scenario.data.study.reference == resolve(below).data.study.reference


def test_stored_times_fit_every_step():
    data = ball({"integrator.step": [0.02, 0.05]}, output={})
    plan = resolve(data).plan
    assert {tuple(point.scenario.times) for point in plan.points} == {(0.0, 0.1, 0.2, 0.3, 0.4)}


def test_the_hash_is_that_of_what_decides():
    def of(data):
        return resolve(data).sha256()

    data = ball({"integrator.step": [0.02, 0.01]})
    assert of(data) == of({**data, "study": {**data["study"], "repeats": 7}})
    others = [ball({"integrator.step": [0.01, 0.02]}), ball(), ball(data["study"]["grid"][0], reference={"step": 1e-3})]
    assert len({of(x) for x in (data, *others)}) == 4


def test_a_parameter_of_the_reference_alone_is_used():
    parameters = {**BALL["parameters"], "drift": 1.0}
    told = {
        formula: resolve(
            ball(
                {"integrator.step": [0.01]},
                reference={"position": {"ball": [formula, 0, 0]}},
                parameters=parameters,
            )
        ).warnings
        for formula in ("drift*t", "t")
    }
    assert told["drift*t"] == []
    assert [(warning.place, warning.rule) for warning in told["t"]] == [("parameters.drift", "nothing uses it")]


def test_points_warn_for_themselves():
    scenario = resolve(ball({"integrator.end_time": [0.4, 0.44]}))
    assert list(map(str, scenario.warnings)) == [
        'study.grid[0] at "integrator.end_time" = 0.44: output.every = 0.1: does not divide integrator.end_time = '
        "0.44; the last stored time is 0.4"
    ]
    told = resolve(ball({"integrator.step": [0.01]}, output={"every": 0.1, "variables": ["energy"]})).warnings
    assert list(map(str, told)) == ["output.variables: has no meaning in a study, which stores errors; leave it out"]
