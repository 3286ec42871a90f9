"""What a study is compared with: settings, formulas, files; each against the others, and what is told of each."""

import numpy as np
import pytest
import xarray as xr

import lienumba
from lienumba.scenario.study_errors import distance
from lienumba.store.files import read
from lienumba.store.outputs import write
from tests.facade import resolve
from tests.rigs.studies import BALL, EXACT, SAMPLED, VARIED, ball, top

STEPS = {"integrator.step": [0.02, 0.01]}
ERRORS = [f"{name}_error" for name in ("position", "rotation", "velocity", "angular_velocity")]


def test_formulas_settings_and_files_agree(tmp_path):
    path = tmp_path / "fine.nc"
    fine = {"integrator.method": "dop853", "integrator.step": 0.005, "output": {"every": 0.05}}
    write(lienumba.run(ball(sweep=SAMPLED), overrides=fine), path)
    references = (EXACT, {"method": "dop853", "step": 0.005}, {"file": str(path)})
    formulas, settings, file = (lienumba.run(ball(STEPS, reference=x, sweep=SAMPLED)) for x in references)
    for name in ERRORS:
        assert (formulas[name] > 1e-10).all()
        for other in (settings, file):
            for kind in ("", "final_"):
                np.testing.assert_allclose(other[f"{kind}{name}"], formulas[f"{kind}{name}"], rtol=1e-4)
        assert (formulas[f"reference_{name}"] < 1e-14).all()
        assert (settings[f"reference_{name}"] < 1e-12).all()
    assert file.attrs["scenario_sha256"] != settings.attrs["scenario_sha256"]
    moved = tmp_path / "elsewhere.nc"
    path.rename(moved)
    again = resolve(ball(STEPS, reference={"file": str(moved)}, sweep=SAMPLED))
    assert again.sha256() == file.attrs["scenario_sha256"]  # by its content, wherever it lies


def test_velocities_follow_from_positions_unless_they_are_given():
    given = {
        **EXACT,
        "velocity": {"ball": ["3 + push/3*sin(3*t)", 0, "1 - 9.81*t"]},
        "angular_velocity": {"ball": ["0", "0.6*(spin + 20/3*sin(3*t))", "0.8*(spin + 20/3*sin(3*t))"]},
    }
    derived, written = (lienumba.run(ball(STEPS, reference=x, sweep=SAMPLED)) for x in (EXACT, given))
    for name in ERRORS:
        np.testing.assert_allclose(derived[name], written[name], rtol=1e-5)


@pytest.mark.parametrize(
    "rotation",
    [
        {"euler": "XYZ", "angles": ["0.3*t", 0, 0]},
        {"rotation_vector": ["0.3*t", 0, 0]},
        ["cos(0.15*t)", "sin(0.15*t)", 0, 0],
        [[1, 0, 0], [0, "cos(0.3*t)", "-sin(0.3*t)"], [0, "sin(0.3*t)", "cos(0.3*t)"]],
    ],
)
def test_rotations_in_every_form(rotation):
    data = ball(STEPS, reference={"rotation": {"ball": rotation}}, parameters={"height": 2.0, "push": 4.0})
    data["model"]["bodies"][0]["angular_velocity"] = [0.3, 0, 0]
    del data["model"]["forces"][1]
    with pytest.warns(UserWarning, match="is less than 100 times"):  # it turns evenly: nothing but rounding
        ds = lienumba.run(data)
    assert "position_error" not in ds
    assert (ds["rotation_error"] < 1e-14).all()
    assert (ds["angular_velocity_error"] < 1e-14).all()


def test_parameters_of_the_grid_reach_the_formulas():
    ds = lienumba.run(ball({"parameters.push": [1.0, 4.0, 40.0]}))
    error = ds["position_error"].isel(run=0).values
    np.testing.assert_allclose(error / error[1], [0.25, 1.0, 10.0], rtol=1e-2)


def test_a_doubtful_reference_is_told():
    with pytest.warns(UserWarning, match="100 times") as told:
        ds = lienumba.run(top({"integrator.step": [2e-3, 1e-3]}, reference={"method": "rk4", "step": 5e-4}))
    (sentence,) = (str(one.message) for one in told)
    assert sentence.startswith("study.reference: the smallest ")
    assert "at step = 0.001, is less than 100 times what the reference is good to" in sentence
    assert sentence.endswith("; give a better reference, or leave out such fine points")
    error, good = ds["position_error"].values.min(), ds["reference_position_error"].values.max()
    assert error / good == pytest.approx(16, rel=0.1)  # of order 4: 1 - 1/16 by 1/16 - 1/256


def test_a_reference_that_fails_is_told():
    reference = {"method": "dop853", "step": 0.02, "projection.max_iterations": 1, "projection.tolerance": 1e-15}
    with pytest.warns(UserWarning, match="has no result in 1 run, run 0 first"):
        ds = lienumba.run(top({"integrator.step": [1e-3]}, reference=reference, output={"times": [0.0, 0.04]}))
    assert ds["position_error"].isnull().all()
    assert (ds["status"] == 0).all()


def test_a_point_that_fails_is_data():
    fast = {**BALL["parameters"], "spin": 12.0}
    ds = lienumba.run(ball({"integrator.step": [0.4, 0.1, 0.01]}, output={}, parameters=fast))
    assert ds["status"].values.tolist() == [[4, 0, 0]]
    assert np.isnan(ds["position_error"].values).tolist() == [[True, False, False]]


def test_files_of_other_motions_are_refused(tmp_path):
    def file(name, data, **overrides):
        write(lienumba.run(data, overrides=overrides), tmp_path / name)
        return tmp_path / name

    def refused(path, data, **options):
        with pytest.raises(lienumba.ScenarioError) as error:
            lienumba.run(data, **options)
        start, _, told = str(error.value).partition(": ")
        assert start.startswith('study.reference.file = "')
        return told

    def study(path, **more):
        return top({"integrator.step": [1e-3]}, reference={"file": str(path)}, **more)

    path = file("ball.nc", ball())
    assert refused(path, study(path)) == ("has the bodies ball, but the scenario top; give a dataset of this mechanism")
    path = file("coarse.nc", top(), **{"output.every": 0.02})
    assert refused(path, study(path)) == (
        "has no state at t = 0.01, where the study compares; store its states at all of output.every or output.times "
        "of the study"
    )
    assert refused(path, study(path, sweep=VARIED, output={"every": 0.02})) == (
        "does not have run 1, with which the study compares; make it with the same runs"
    )
    path = file("swept.nc", top(sweep=VARIED), **{"integrator.method": "dop853"})
    assert refused(path, study(path, sweep=VARIED | {"seed": 5})).endswith("make it with the same sweep and seed")
    other = VARIED | {"vary": {**VARIED["vary"], **SPIN}}
    assert refused(path, study(path, sweep=other)) == (
        'does not vary "bodies.top.angular_velocity[1]", which the study varies; make it with the same sweep'
    )
    assert lienumba.run(study(path, sweep=VARIED), runs=[1])["position_error"].shape == (1, 1)
    path = file("energies.nc", top(), **{"output.variables": ["energy"]})
    assert refused(path, study(path)).startswith("has none of position, rotation, velocity and angular_velocity; ")
    (tmp_path / "not.nc").write_bytes(b"\\x89HDF")
    assert "cannot be opened as netCDF" in refused(tmp_path / "not.nc", study(tmp_path / "not.nc"))
    xr.Dataset({"x": 1}).to_netcdf(tmp_path / "else.nc", engine="netcdf4")
    assert "not of lienumba" in refused(tmp_path / "else.nc", study(tmp_path / "else.nc"))
    changed = study(path)
    changed["study"]["reference"]["sha256"] = "ab12"
    assert refused(path, changed).startswith('has changed since sha256 = "ab12" was written; ')


SPIN = {"bodies.top.angular_velocity[1]": {"distribution": "uniform", "low": 149, "high": 151}}


def test_angles_between_rotations():
    def turn(angle):
        c, s = np.cos(angle), np.sin(angle)
        return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])

    for angle in (0.0, 1e-12, 1e-6, 0.5, 3.0):
        assert distance("rotation", turn(0.3 + angle), turn(0.3)) == pytest.approx(angle, rel=1e-9, abs=1e-16)
    assert distance("rotation", turn(np.pi), turn(0.0)) == pytest.approx(np.pi, abs=1e-7)
    assert distance("velocity", np.array([1.0, 2, 2]), np.zeros(3)) == 3.0


MEASURES = [{"name": "reach", "value": "max(p.x)"}, {"name": "mean place", "value": "mean(p.x)", "units": "m"}]


def test_measures_have_errors_and_orders(tmp_path):
    """Of settings as the reference; where the motion is stated, their values alone. The push is a cosine of the time,
    which rk4 integrates to order 4, and so are both numbers of whole runs, whose closed forms are known."""
    steps, shown = (
        {"integrator.step": [0.1, 0.05, 0.025, 0.0125]},
        {"quantities": [{"name": "p", "type": "point", "body": "ball"}]},
    )
    given = shown | {"measures": MEASURES}
    settings = lienumba.run(ball(steps, reference={"method": "dop853", "step": 0.005}, **given))
    stated = lienumba.run(ball(steps, **given))
    end = 0.4
    reach = 3 * end + 4 / 9 * (1 - np.cos(3 * end))
    mean = (1.5 * end**2 + 4 / 9 * (end - np.sin(3 * end) / 3)) / end
    for name, exact in (("reach", reach), ("mean place", mean)):
        values, error = settings[name].isel(run=0).values, settings[f"{name}_error"].isel(run=0).values
        np.testing.assert_allclose(error, np.abs(values - exact), rtol=1e-3)
        assert (settings[f"reference_{name}_error"] < 1e-11).all()
        np.testing.assert_array_equal(stated[name], settings[name])
        assert f"{name}_error" not in stated
        order = lienumba.analysis.orders(settings).sel(error=name)
        assert abs(float(order["order"]) - 4) < 0.1
    assert settings["reach_error"].attrs["units"] == "m"
    path = tmp_path / "study.nc"
    write(settings, path)
    with read(path) as again:
        np.testing.assert_array_equal(again["reach_error"], settings["reach_error"])
    assert "mean place_error" in lienumba.analysis.work_precision(settings)


@pytest.mark.parametrize("name", ["step", "final_position", "reference_position", "evaluations", "case"])
def test_names_of_measures_that_a_study_has_itself_are_refused(name: str):
    given = {
        "measures": [MEASURES[0] | {"name": name}],
        "quantities": [{"name": "p", "type": "point", "body": "ball"}],
    }
    said = rf'measures\.{name}\.name = "{name}": is the name of something else in'
    with pytest.raises(lienumba.ScenarioError, match=said):
        resolve(ball(STEPS, **given))
