"""A scenario's samples: derived from one another, read from tables, and all that a run is built from."""

import csv
import re
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from scipy.spatial.transform import Rotation
from typer.testing import CliRunner

import lienumba
from lienumba.scenario.reading.loading import load
from lienumba.scenario.start.build import build
from lienumba.scenario.start.design import draw
from lienumba.scenario.system import System
from lienumba.store.outputs import write
from tests.facade import app, resolve
from tests.rigs.places import SCENARIOS
from tests.rigs.scenario_example import example

NORMAL = {"distribution": "normal", "std": 0.01, "relative": True}
ROTATIONS = {
    "quaternion": [0.0, 3.0, 0.0, 4.0],
    "matrix": [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]],
    "axis and angle": {"axis": [0.0, 3.0, 4.0], "angle": 0.7},
    "angles": {"euler": "ZYX", "angles": [0.1, 0.2, 0.3]},
    "vector": {"rotation_vector": [0.1, -0.2, 0.3]},
}
WHOLES = {
    "bodies.top.mass": NORMAL,
    "bodies.top.rotation": {"distribution": "rotation_normal", "std": 0.05},
    "bodies.top.inertia": {"distribution": "inertia", "std": 0.05},
    "gravity": {"distribution": "direction", "angle": 0.1},
    "bodies.top.angular_velocity[1]": {"expression": "10*bodies.top.mass + bodies.top.inertia[3]"},
}


def scenario(vary: dict[str, Any], runs: int = 5, parameters: dict[str, Any] | None = None, **body: Any) -> Any:
    data = example(**body) | {"parameters": parameters or {}}
    return data | {"sweep": {"runs": runs, "seed": 1, "vary": vary}}


def short(data: dict[str, Any], **sweep: Any) -> dict[str, Any]:
    """The scenario, stopped soon, with another sweep."""
    soon = {"integrator": {"step": 1e-3, "end_time": 0.003}, "output": {"every": 0.003}}
    return data | soon | ({"sweep": sweep} if sweep else {})


def assert_same(one: Any, two: Any) -> None:
    assert list(one) == list(two)
    for name in one:
        np.testing.assert_array_equal(one[name], two[name], err_msg=name)


# ---------------------------------------------------------------- wholes
@pytest.mark.parametrize("rotation", ROTATIONS.values(), ids=ROTATIONS)
def test_a_rotation_varies_about_its_nominal_one_in_any_form(rotation: Any) -> None:
    still = {"bodies.top.rotation": {"distribution": "rotation_normal", "std": 0}}
    resolved = resolve(scenario(still, rotation=rotation))
    samples = draw(resolved, [-1, 0, 1])
    assert list(samples) == [f"bodies.top.rotation[{i}]" for i in range(4)]
    found = build(resolved, samples)[1].poses[0].rotation
    expected = build(resolved, {})[1].poses[0].rotation
    for x, y in zip(found, expected, strict=True):
        np.testing.assert_allclose(np.broadcast_to(x, 3), y, atol=1e-15)


def test_rotations_of_runs_are_those_of_their_quaternions() -> None:
    resolved = resolve(scenario({"bodies.top.rotation": WHOLES["bodies.top.rotation"]}, rotation=ROTATIONS["matrix"]))
    samples = draw(resolved, range(5))
    R = np.array(build(resolved, samples)[1].poses[0].rotation).T.reshape(5, 3, 3)
    quaternions = np.array(list(samples.values())).T
    np.testing.assert_allclose(R, Rotation.from_quat(quaternions, scalar_first=True).as_matrix(), atol=1e-15)


def test_an_inertia_of_three_moments_varies_with_all_its_elements() -> None:
    resolved = resolve(scenario({"bodies.top.inertia": WHOLES["bodies.top.inertia"]}))
    samples = draw(resolved, [-1, *range(5)])
    assert list(samples) == [f"bodies.top.inertia[{i}]" for i in range(6)]
    assert_same(dict(enumerate(build(resolved, samples)[0].bodies[0].inertia)), dict(enumerate(samples.values())))
    assert [x[0] for x in samples.values()] == [0.234375, 0.46875, 0.234375, 0, 0, 0]


# ---------------------------------------------------------------- derived inputs
def test_expressions_follow_samples_and_parameters_in_any_order() -> None:
    vary = {
        "bodies.top.inertia[1]": {"expression": "2*bodies.top.inertia[0] + 0*kd"},
        "bodies.top.inertia[0]": {"expression": "0.0156*bodies.top.mass*parameters.kp/kp"},
        "parameters.kp": {"expression": "2 + 0.01*bodies.top.mass"},
        "bodies.top.mass": NORMAL,
        "bodies.top.angular_velocity[1]": {"expression": "50*kd"},
    }
    resolved = resolve(scenario(vary, parameters={"kp": 2.0, "kd": "sqrt(kp)*1.5"}))
    assert resolved.warnings == []
    samples = draw(resolved, [-1, *range(5)])
    assert list(samples) == list(vary)
    mass, kp = samples["bodies.top.mass"][1:], samples["parameters.kp"][1:]
    np.testing.assert_array_equal(kp, 2 + 0.01 * mass)
    np.testing.assert_array_equal(samples["bodies.top.inertia[0]"][1:], 0.0156 * mass * kp / kp)
    np.testing.assert_array_equal(samples["bodies.top.angular_velocity[1]"][1:], 50 * (np.sqrt(kp) * 1.5))
    assert {path: x[0] for path, x in samples.items()} == resolved.nominal()


def test_a_derived_input_that_is_no_number_marks_its_run_alone() -> None:
    vary = {
        "bodies.top.angular_velocity[0]": {"distribution": "uniform", "low": -1, "high": 1},
        "bodies.top.angular_velocity[2]": {"expression": "sqrt(bodies.top.angular_velocity[0])"},
    }
    ds = lienumba.run(short(scenario(vary, 16)))
    low = ds["bodies.top.angular_velocity[0]"] < 0
    names = ds["status"].attrs["flag_meanings"].split()
    assert 0 < int(low.sum()) < 16
    np.testing.assert_array_equal(ds["status"] == names.index("invalid_sample"), low)


def test_a_sweep_without_a_possible_run_names_what_it_varies() -> None:
    vary = {
        "bodies.top.inertia[0]": {"distribution": "uniform", "low": -2, "high": -1},
        "bodies.top.angular_velocity[1]": {"distribution": "normal", "std": 1},
    }
    with pytest.raises(lienumba.ScenarioError) as caught:
        lienumba.run(short(scenario(vary)))
    assert str(caught.value).startswith(
        'sweep.vary: no run is possible with "bodies.top.inertia[0]" varied: every sample has a mass, inertia, length, '
        "friction or rotation that nothing has, or is no finite number; give values nearer to the nominal ones. The "
        "first run: "
    )


# ---------------------------------------------------------------- tables
@pytest.mark.parametrize("rotation", [[0.0, 0.6, 0.0, 0.8], ROTATIONS["angles"]], ids=["quaternion", "angles"])
@pytest.mark.parametrize("ending", [".csv", ".nc"])
def test_a_written_design_is_a_table_with_the_same_bits(tmp_path: Path, ending: str, rotation: Any) -> None:
    data = short(scenario(WHOLES, rotation=rotation, position=None))
    file, out = tmp_path / "case.toml", tmp_path / f"design{ending}"
    file.write_text(resolve(data).to_toml(), encoding="utf-8")
    result = CliRunner().invoke(app, ["sample", str(file), "-o", str(out), "--runs", "-1,0:5"])
    assert result.exit_code == 0, result.output
    assert "6 runs drawn" in result.output
    replayed = short(data, sampler="table", table={"file": str(out)})
    assert resolve(replayed).data.sweep.runs == 5
    one, two = lienumba.run(data), lienumba.run(replayed)
    assert_same({name: one[name].values for name in one.variables}, {name: two[name].values for name in one.variables})
    write(one, tmp_path / "runs.nc")
    again = short(data, sampler="table", table={"file": str(tmp_path / "runs.nc")})
    assert_same(draw(resolve(again), range(5)), draw(resolve(replayed), range(5)))


def test_a_table_takes_the_place_of_a_distribution_and_stands_beside_others() -> None:
    columns = {"m": [10.0, 11.0, 12.0], "bodies.top.mass": [1.0, 2.0, 3.0]}
    vary = {
        "bodies.top.mass": NORMAL,
        "bodies.top.angular_velocity[1]": {"column": "m"},
        "bodies.top.angular_velocity[0]": {"distribution": "normal", "std": 1},
    }
    data = scenario(vary) | {"sweep": {"sampler": "table", "table": {"columns": columns}, "vary": vary}}
    resolved = resolve(data)
    samples = draw(resolved, [2, 0])
    np.testing.assert_array_equal(samples["bodies.top.mass"], [3, 1])
    np.testing.assert_array_equal(samples["bodies.top.angular_velocity[1]"], [12, 10])
    alone = draw(resolve(scenario({path: vary[path] for path in [*vary][2:]}) | {"sweep": {"runs": 3, "vary": {
        "bodies.top.angular_velocity[0]": NORMAL | {"relative": False, "std": 1}}}}), [2, 0])  # fmt: skip
    assert_same({k: samples[k] for k in alone}, alone)
    again = resolve(tomllib.loads(resolved.to_toml()))
    assert (again.to_toml(), again.sha256()) == (resolved.to_toml(), resolved.sha256())


def test_rows_go_by_their_labels(tmp_path: Path) -> None:
    (tmp_path / "design.csv").write_text("run; bodies.top.mass\n7; 17\n3; 13\n-1; 15\n", encoding="utf-8")
    data = short(example(), sampler="table", table={"file": str(tmp_path / "design.csv")})
    resolved = resolve(data)
    assert resolved.data.sweep.runs == 8
    np.testing.assert_array_equal(draw(resolved, [3, -1, 7])["bodies.top.mass"], [13, 15, 17])
    with pytest.raises(lienumba.ScenarioError, match=r"sweep.table: has no row for run 0; run those that it has"):
        draw(resolved, range(8))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("bodies.top.mass\n15\nnan\n", 'row 2 of column "bodies.top.mass": nan is no finite number; correct it'),
        ("bodies.top.mass\n15\nx\n", 'line 3, column bodies.top.mass: "x" is no number; correct it'),
        ("run,bodies.top.mass\n0.5,15\n", "column run: has labels that are no whole numbers from 0 on; correct them"),
        ("a,a\n1,2\n", 'columns 1 and 2 are both called "a"; give each its own name'),
        ("", "is empty; give a first line with the names of the columns, and numbers below"),
    ],
)
def test_a_wrong_file_is_named_with_the_place(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, text: str, message: str
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("design.csv").write_text(text, encoding="utf-8")
    with pytest.raises(lienumba.ScenarioError) as caught:
        load(short(example(), sampler="table", table={"file": "design.csv"}))
    assert str(caught.value) == f'sweep.table.file = "design.csv": {message}'


def test_a_netcdf_file_without_inputs_is_no_table(tmp_path: Path) -> None:
    xr.Dataset({"x": ("run", [1.0])}).to_netcdf(tmp_path / "x.nc")
    with pytest.raises(lienumba.ScenarioError, match="has no sampled inputs"):
        load(short(example(), sampler="table", table={"file": str(tmp_path / "x.nc")}))


# ---------------------------------------------------------------- settings, Python, the command
def test_the_hash_knows_what_samples_depend_on() -> None:
    def hashed(**sweep: Any) -> str:
        data = scenario({"bodies.top.mass": NORMAL})
        return resolve(data | {"sweep": data["sweep"] | sweep}).sha256()

    first = hashed()
    assert hashed(runs=9) == hashed(nominal=True) == first
    assert len({first, hashed(sampler="sobol"), hashed(sampler="halton"), hashed(seed=2)}) == 4
    assert hashed(sampler="latin_hypercube") != hashed(sampler="latin_hypercube", runs=9)


def test_the_nominal_run_is_one_of_the_labels_on_request() -> None:
    data = scenario({"bodies.top.mass": NORMAL}, 3)
    assert list(resolve(data).labels) == [0, 1, 2]
    assert list(resolve(data | {"sweep": data["sweep"] | {"nominal": True}}).labels) == [-1, 0, 1, 2]


def test_python_can_say_all_of_it() -> None:
    top = System.from_toml(SCENARIOS / "heavy_top.toml")
    top.sweep(runs=8, sampler="sobol", nominal=True)
    top.vary("bodies.top.mass", "normal", std=0.01, relative=True)
    top.vary("bodies.top.angular_velocity[1]", scipy="uniform", loc=149, scale=2)
    top.vary("bodies.top.angular_velocity[2]", expression="-bodies.top.mass/3")
    top.correlate(["bodies.top.mass", "bodies.top.angular_velocity[1]"], np.array([[1.0, 0.9], [0.9, 1.0]]))
    samples = draw(resolve(top), range(8))
    assert np.corrcoef(samples["bodies.top.mass"], samples["bodies.top.angular_velocity[1]"])[0, 1] > 0.7
    assert_same(draw(resolve(tomllib.loads(top.to_toml())), range(8)), samples)


def test_settings_reach_every_key_of_a_distribution() -> None:
    data = scenario({"bodies.top.mass": {"distribution": "lognormal", "sigma": 0.1}})
    changed = resolve(data, overrides={"sweep.vary.bodies.top.mass.sigma": 0.2, "sweep.sampler": "halton"})
    assert (changed.data.sweep.vary["bodies.top.mass"].sigma, changed.data.sweep.sampler) == (0.2, "halton")  # type: ignore[attr-defined]
    changed = resolve(data, overrides={'sweep.vary."bodies.top.mass".median': 14.0})
    assert changed.data.sweep.vary["bodies.top.mass"].median == 14.0  # type: ignore[attr-defined]


def test_the_command_tells_how_inputs_spread(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("case.toml").write_text(resolve(scenario({"bodies.top.mass": NORMAL}, 4)).to_toml(), encoding="utf-8")
    result = CliRunner().invoke(app, ["sample", "case.toml", "--seed", "5", "--set", "sweep.runs=3"])
    assert result.exit_code == 0, result.output
    with Path("case.samples.csv").open(encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    assert header == ["run", "bodies.top.mass"]
    expected = draw(resolve("case.toml", seed=5), range(3))["bodies.top.mass"]
    assert [(int(run), float(mass)) for run, mass in rows] == list(enumerate(expected.tolist()))
    (line,) = re.findall(r"bodies\.top\.mass +(\S+) +(\S+) +(\S+) +(\S+) +kg", result.output)
    shown = [expected.mean(), expected.std(), expected.min(), expected.max()]
    np.testing.assert_allclose([float(x) for x in line], shown, rtol=1e-5)
    again = CliRunner().invoke(app, ["sample", "case.toml"])
    assert (again.exit_code, "exists already" in again.stderr) == (2, True)
    assert CliRunner().invoke(app, ["sample", "case.toml", "--overwrite"]).exit_code == 0


def test_drawing_needs_no_compiler_and_plain_names_no_scipy(tmp_path: Path) -> None:
    Path(tmp_path / "case.toml").write_text(resolve(scenario({"bodies.top.mass": NORMAL})).to_toml(), encoding="utf-8")
    code = (
        "import sys\nfrom lienumba.cli import app\n"
        f"app(['sample', {str(tmp_path / 'case.toml')!r}, '-o', {str(tmp_path / 'x.csv')!r}], standalone_mode=False)\n"
        "print([name for name in ('numba', 'scipy', 'xarray') if name in sys.modules])"
    )
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert result.stdout.splitlines()[-1] == "[]"


@pytest.mark.parametrize(
    ("vary", "expected"),
    [
        ({"distribution": "normal", "std": 0.0}, 3.0),
        ({"distribution": "uniform", "low": 2.0, "high": 2.0 + 1e-12, "relative": True}, 6.0),
        ({"distribution": "lognormal", "sigma": 0.0}, 3.0),
    ],
)
def test_what_samples_follow_may_be_set(vary: dict[str, Any], expected: float) -> None:
    data = example()
    data["sweep"]["vary"] = {"bodies.top.mass": vary}
    scenario = resolve(data, overrides={"bodies.top.mass": 3})
    np.testing.assert_allclose(draw(scenario, range(3))["bodies.top.mass"], expected, rtol=1e-9)
