"""What a publication says: true of every setting, with references that exist."""

import re
import tomllib
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

import lienumba
from lienumba.integrators.methods.charts import GROUPS
from lienumba.present.citation.cite import cite_dataset, cite_scenario
from lienumba.present.citation.paragraph import CITED
from lienumba.present.citation.references import LITERATURE, bibtex, references, software
from lienumba.sweep.samplers import SAMPLERS
from lienumba.words import number
from tests.facade import METHODS, app, resolve
from tests.present.citation.bib import read
from tests.rigs.places import ROOT, SCENARIOS

TOP = SCENARIOS / "heavy_top.toml"
MONTE_CARLO = SCENARIOS / "heavy_top_monte_carlo.toml"


def paragraph(text: str) -> str:
    """The first part; the rest is BibTeX of exactly what it cites."""
    first, _, entries = text.partition("\n\n")
    assert set(re.findall(r"@(\w+)", first)) == read(entries).keys()
    return first


def told(**overrides: Any) -> str:
    """Of the heavy top with other settings; `a__b` is the path a.b."""
    changes = {key.replace("__", "."): value for key, value in overrides.items()}
    return paragraph(cite_scenario(resolve(TOP, overrides=changes)))


def test_every_reference_is_valid_and_used() -> None:
    found = read("\n".join([software("1.2.3", 2030), *bibtex(references())]))
    assert found.keys() == references().keys() | {"lienumba"}
    for element in (*METHODS.values(), *GROUPS.values(), *SAMPLERS.values()):
        assert re.findall(r"@(\w+)", element.words) == [x.key for x in element.references], element
    source = "".join(path.read_text() for path in (ROOT / "lienumba" / "present" / "citation").glob("*.py"))
    assert all(f"@{x.key}" in source or x.key in CITED.values() for x in LITERATURE)
    for key, fields in found.items():
        assert re.fullmatch(r"10\.\d{4}/\S+", fields.get("doi", "10.1000/none")), key
        assert re.fullmatch(r"\d+(--\d+)?", fields.get("pages", "1")), key
    assert found["terze2015"] == {
        "author": r"Terze, Zdravko and M{\"u}ller, Andreas and Zlatar, Dario",
        "title": "{Lie-group integration method for constrained multibody systems in state space}",
        "journal": "Multibody System Dynamics",
        "year": "2015",
        "volume": "34",
        "number": "3",
        "pages": "275--305",
        "doi": "10.1007/s11044-014-9439-2",
    }


def test_the_citation_file_says_the_same() -> None:
    text = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    paper = references()["terze2015"]
    for line in (f"version: {lienumba.__version__}", f"doi: {paper.doi}", f'title: "{paper.title}"'):
        assert line in text
    assert "volume: 34\n    issue: 3\n    start: 275\n    end: 305" in text


@pytest.mark.parametrize("method", METHODS)
def test_methods(method: str) -> None:
    text = told(integrator__method=method)
    assert f"{METHODS[method].words} of order {METHODS[method].order}" in text
    assert ("Munthe-Kaas" in text) == (not METHODS[method].composed and not METHODS[method].series)
    assert "with a fixed step of 0.001 s, over 2 s." in text


def test_the_default() -> None:
    text = told()
    assert 'The multibody system "Heavy top" (1 rigid body and 1 joint) was simulated with lienumba' in text
    assert (
        "Its equations of Newton and Euler, formulated as differential-algebraic equations of index 1 in state space "
        "[@terze2015], were integrated on the Lie group of the states of all bodies" in text
    )
    assert "each with the group R^3 x SO(3)." in text
    assert (
        "positions in local coordinates of the rotations, to a violation of 1e-11 m in at most 10 iterations; "
        "velocities with the mass matrix as weight." in text
    )
    assert "No run has been made yet" in text
    assert "differed" not in text
    assert "study" not in text


@pytest.mark.parametrize(
    ("overrides", "said", "not_said"),
    [
        (
            {"integrator__method": "dp54", "integrator__tolerance": 1e-9, "integrator__max_step": 0.1},
            "an error per step of 1e-9 relative and 1e-9 in SI units absolute (the longest 0.1 s)",
            "fixed",
        ),
        (
            {
                "integrator__method": "dp54",
                "integrator__tolerance": {"relative": 1e-6, "absolute": {"angular_velocity": 1e-4}},
            },
            "1e-6 relative and 0.0001 rad/s in angular velocity and 1e-6 in SI units in all else absolute",
            "fixed",
        ),
        ({"integrator__group": "SE3"}, "each with the group SE(3) [@mueller2014].", "SO(3)"),
        ({"integrator__coordinates": "quaternion"}, "as vectors, namely quaternions, which each", "Munthe-Kaas"),
        ({"integrator__dexpinv": "closed"}, "with the inverse of dexp in closed form,", "commutator"),
        ({"integrator__dexpinv": 1}, "with the inverse of dexp cut behind 1 commutator,", "closed"),
        ({"projection__position": "none"}, "Positions were not projected.", "neither"),
        ({"projection__velocity": "none"}, "Velocities were not projected.", "weight"),
        ({"projection__position": "none", "projection__velocity": "none"}, "neither projected nor damped", "After"),
        (
            {"projection__position": "none", "projection__velocity": "none", "projection__baumgarte": 10},
            "damped by Baumgarte's method [@baumgarte1972], rate 10 1/s.",
            "projected",
        ),
        (
            {"projection__position": "embedded", "projection__velocity": "identity", "projection__chord": True},
            "positions in the elements of the rotation matrices, to a violation of 1e-11 m in at most 10 iterations, "
            "the later ones by the elimination of the first; velocities with the identity as weight.",
            "local",
        ),
    ],
    ids=lambda x: "" if isinstance(x, str) else "-".join(x),
)  # fmt: skip
def test_settings(overrides: dict[str, Any], said: str, not_said: str) -> None:
    text = told(**overrides)
    assert said in text, text
    assert not_said not in text


def test_a_body_without_constraints_has_none() -> None:
    text = paragraph(cite_scenario(resolve(SCENARIOS / "dzhanibekov.toml")))
    assert "Its equations of Newton and Euler, formulated in state space [@terze2015], were integrated on" in text
    assert "constraint" not in text


@pytest.mark.parametrize(
    ("path", "distribution", "said"),
    [
        ("mass", {"distribution": "normal", "std": 0.01, "relative": True},
         "nominal 15 kg; normal, mean the nominal value, standard deviation 0.01 times the nominal value"),
        ("mass", {"distribution": "normal", "std": 0.5, "mean": 14}, "normal, mean 14 kg, standard deviation 0.5 kg"),
        ("mass", {"distribution": "uniform", "low": 14, "high": 16}, "uniform between 14 kg and 16 kg"),
        ("mass", {"distribution": "truncated_normal", "std": 1, "low": 14},
         "standard deviation 1 kg, truncated to values above 14 kg"),
        ("mass", {"distribution": "truncated_normal", "std": 1, "high": 16}, "truncated to values below 16 kg"),
        ("mass", {"distribution": "lognormal", "sigma": 0.1},
         "lognormal, median the nominal value, standard deviation of the logarithm 0.1"),
        ("mass", {"distribution": "triangular", "low": 14, "high": 16},
         "triangular between 14 kg and 16 kg, mode the nominal value"),
        ("mass", {"distribution": "choice", "values": [14, 15]}, "one of 14 kg or 15 kg, all as likely"),
        ("mass", {"distribution": "choice", "values": [14, 15], "weights": [1, 2]}, "with weights [1, 2]"),
        ("mass", {"distribution": "constant", "value": 14}, "14 kg in all runs"),
        ("mass", {"scipy": "weibull_min", "c": 1.7, "scale": 15.0},
         "weibull_min of scipy.stats with c = 1.7, scale = 15"),
        ("mass", {"expression": "15 + 0.1"}, "the formula 15 + 0.1"),
        ("rotation", {"distribution": "rotation_normal", "std": 0.02},
         "exp of a normal rotation vector in body axes, mean 0, standard deviation 0.02 rad"),
        ("rotation", {"distribution": "rotation_uniform"}, "uniform on SO(3)"),
        ("inertia", {"distribution": "inertia", "std": 0.05}, "standard deviation of its second moments 0.05"),
    ],
)  # fmt: skip
def test_distributions(path: str, distribution: dict[str, Any], said: str) -> None:
    text = told(sweep__runs=7, sweep__vary={f"bodies.top.{path}": distribution})
    assert f"7 runs differed in 1 input: bodies.top.{path} (" in text
    assert said in text, text


def test_directions() -> None:
    vary = {"gravity": {"distribution": "direction", "angle": 0.1}}
    said = "of nominal length, its direction uniform within 0.1 rad of the nominal one"
    assert said in told(sweep__runs=2, sweep__vary=vary)


@pytest.mark.parametrize("sampler", [name for name in SAMPLERS if name not in ("table", "saltelli")])
def test_samplers(sampler: str) -> None:
    text = told(sweep={
        "runs": 8, "seed": 3, "sampler": sampler, "nominal": True,
        "vary": {"bodies.top.mass": {"distribution": "uniform", "low": 14, "high": 16}},
        "proposal": {"bodies.top.mass": {"shift": 1.5}} if SAMPLERS[sampler].weighted else {},
    })  # fmt: skip
    assert ("bodies.top.mass (shift 1.5, scale 1)" in text) == SAMPLERS[sampler].weighted
    assert (
        f"Their values were drawn from {SAMPLERS[sampler].words} with the seed 3. One run more had the nominal" in text
    )


def test_events_may_end_a_run_before() -> None:
    text = paragraph(cite_scenario(resolve(SCENARIOS / "satellite_settles.toml")))
    assert ", over at most 200 s." in text


def test_tables_have_no_seed() -> None:
    table = {"columns": {"bodies.top.mass": [14.0, 15.0]}}
    text = told(
        sweep={
            "sampler": "table",
            "table": table,
            "runs": 2,
            "vary": {"bodies.top.mass": {"column": "bodies.top.mass"}},
        }
    )
    assert "from a table of samples that were given." in text


def test_correlations() -> None:
    text = paragraph(cite_scenario(resolve(SCENARIOS / "heavy_top_robust.toml")))
    assert "(Gaussian copula): bodies.top.mass and bodies.top.angular_velocity[1] with -0.6." in text


def test_failures_of_a_dataset_are_told(tmp_path: Path) -> None:
    changes = {"sweep.runs": 16, "integrator.end_time": 0.02, "sweep.vary.bodies.top.mass.std": 2}
    with pytest.warns(UserWarning, match="will draw a value of 0 or below"):
        ds = lienumba.run(MONTE_CARLO, overrides=changes, output=tmp_path / "out.nc")
    failed = int((ds["status"] != 0).sum())
    text = paragraph(cite_dataset(ds))
    assert f"{failed} runs of 16 failed ({failed}: a sampled mass, inertia, length" in text
    assert f"(invalid_sample)); {16 - failed} succeeded." in text
    assert f"NumPy {ds.attrs['numpy_version']} [@harris2020]" in text
    assert f"year = {{{ds.attrs['history'][:4]}}}" in cite_dataset(ds)
    assert "No run has been made" not in text
    shown = CliRunner().invoke(app, ["info", str(tmp_path / "out.nc"), "--cite"])
    assert shown.stdout == cite_dataset(ds) + "\n"


def test_one_run_and_a_part_of_a_sweep() -> None:
    short = {"integrator.end_time": 0.02}
    assert "The simulation succeeded." in paragraph(cite_dataset(lienumba.run(TOP, overrides=short)))
    some = lienumba.run(MONTE_CARLO, overrides=short, runs=[3, 17])
    assert "2 runs were simulated, of a sweep of 1,000 runs that differ in 9 inputs: " in paragraph(cite_dataset(some))
    assert "Both runs succeeded." in paragraph(cite_dataset(some))
    for one in some.sel(run=[17]), lienumba.replay(some, 17):
        text = paragraph(cite_dataset(one))
        assert "Run 17 was simulated, of a sweep of 1,000 runs that differ in 9 inputs: bodies.top.mass, " in text
        assert "The simulation succeeded." in text
    alone = lienumba.run(MONTE_CARLO, overrides={**short, "sweep.nominal": True}, runs=[-1])
    text = paragraph(cite_dataset(alone))
    assert "Of the sweep, the nominal run alone was simulated. The simulation succeeded." in text
    assert "drawn" not in text


def test_a_sweep_that_stops() -> None:
    text = paragraph(cite_scenario(resolve(SCENARIOS / "heavy_top_robust.toml")))
    assert "At most 8,192 runs differed in 3 inputs" in text
    end = "The sweep was to end once the 95 % confidence interval of the"
    assert f"{end} 5 % quantile of height_min, computed after every 256 runs, was no wider than 0.02. (No" in text
    changes: dict[str, Any] = {"integrator.end_time": 0.01, "sweep.runs": 2048, "output.mode": "summary"}
    for width, runs, said in (
        (1.0, "1,024 runs of at most 2,048 differed in 9 inputs", " 1 m. It had enough after 1,024 runs: the mean of"),
        (1e-99, "2,048 runs differed in 9 inputs", " 1e-99 m. These runs were not enough for that."),
    ):
        rule = {"variable": "max_position_violation", "width": width, "every": 1024}
        text = paragraph(cite_dataset(lienumba.run(MONTE_CARLO, overrides=changes | {"sweep.stop": rule})))
        assert f". {runs}" in text
        assert f"{end} mean of max_position_violation, computed after every 1,024 runs, was no wider than{said}" in text


def test_a_sweep_that_stops_by_a_requirement() -> None:
    text = paragraph(
        cite_scenario(
            resolve(
                SCENARIOS / "satellite_verdict.toml",
                overrides={"sweep.stop": {"requirement": "points finely", "every": 50}},
            )
        )
    )
    end = 'once its runs, looked at after every 50 runs, showed whether "points finely" is met, by a mixture martingale'
    assert end in text


@pytest.fixture(scope="module")
def four() -> Any:
    return lienumba.run(MONTE_CARLO, overrides={"integrator.end_time": 0.02, "sweep.runs": 4})


@pytest.mark.parametrize(
    ("codes", "said"),
    [
        ([0, 0, 0, 0], ". All 4 runs succeeded."),
        ([0, 9, 9, 0], ". All 4 runs succeeded; 2 of them ended at an event, as intended."),
        ([9, 9, 9, 9], ". All 4 runs ended at an event, as intended."),
        ([9], ". The simulation ended at an event, as intended."),
        ([1, 1], ". Both runs failed (the state became infinite or undefined (non_finite))."),
        ([1, 1, 1, 1], ". All 4 runs failed (the state became infinite or undefined (non_finite))."),
        ([1, 0, 9, 0], ". 1 run of 4 failed (1: the state became infinite or undefined (non_finite)); 3 succeeded; "
         "1 of them ended at an event, as intended."),
    ],
)  # fmt: skip
def test_how_runs_ended(four: Any, codes: list[int], said: str) -> None:
    some = four.isel(run=slice(len(codes))).assign(status=("run", codes))
    assert f"{said} lienumba ran on" in paragraph(cite_dataset(some))


@pytest.mark.parametrize(
    ("scenario", "said"),
    [
        ("arm_sampled", "The force laws shoulder_motor and elbow_motor are the authors' own, written in Python (the "
         "function pid in arm.py, sampled every 0.015 s and held in between)."),
        ("cam", "The constraint profile is the authors' own, written in Python (the function touches in cam.py)."),
        ("rolling_disc", "written in Python (the function rolls in rolling.py, on velocities)."),
        ("rolling_disc", "parameters.lean (nominal 10*deg; uniform between 0.05 and 0.5)."),
        ("satellite_settles", "Runs ended at the event settled (pointing.angle < 0.1*deg and "),
        ("satellite_settles", "It was recorded when the event halfway (pointing.angle < 15*deg) first occurred, and"),
        ("pawl", "The events caught (wheel.rate < 0) locked the joint axle and lets_go (drive > 0) unlocked the joint "
         "axle."),
        ("door_closer", "The event latched (door.angle < 0.2*deg and abs(door.rate) < 0.3) locked the joint hinge "
         "(once in a run)."),
        ("satellite_monte_carlo", "bodies.base_rod.mass, bodies.slider_rod.mass, bodies.slider.mass, "
         "bodies.base_rod.inertia[0] and bodies.slider_rod.inertia[0] (nominal 80 kg, 60 kg, 30 kg, 15.1125 kg m2 and "
         "11.3 kg m2; normal, mean the nominal value, standard deviation 0.01 times the nominal value); "),
        ("satellite_monte_carlo", "(each nominal 0 m; normal, mean the nominal value, standard deviation 0.002 m)"),
        ("satellite_monte_carlo", "(nominal pi/60 (rad s-1) and pi/30 (rad s-1); normal"),
    ],
)  # fmt: skip
def test_what_the_gallery_has(scenario: str, said: str) -> None:
    assert said in paragraph(cite_scenario(resolve(SCENARIOS / f"{scenario}.toml")))


def test_a_dataset_and_its_scenario_agree() -> None:
    changes = {"integrator.end_time": 0.02, "sweep.runs": 4}
    of_dataset = paragraph(cite_dataset(lienumba.run(MONTE_CARLO, overrides=changes)))
    of_scenario = paragraph(cite_scenario(resolve(MONTE_CARLO, overrides=changes)))
    expected = re.sub(r"\(No run.*?why\.\)", "All 4 runs succeeded.", of_scenario)
    assert of_dataset == expected


def test_studies() -> None:
    study = SCENARIOS / "heavy_top_study.toml"
    text = paragraph(cite_scenario(resolve(study)))
    assert "Heun's method [@heun1900] of order 2, Kutta's method [@kutta1901] of order 3, the classical" in text
    assert "integrator.method (heun, kutta3, rk4, dp54) by integrator.step (0.004, 0.002, 0.001," in text
    assert "a reference solution (method = dop853, step = 0.001; the method DOP853" in text


def test_a_dataset_of_a_study() -> None:
    grid = [{"integrator.group": ["R3xSO3", "SE3"], "integrator.step": [2e-3, 1e-3]}]
    reference = {"position": {"top": ["0", "1", "0"]}}
    changes = {"integrator.end_time": 0.02, "output.every": 0.02, "study": {"grid": grid, "reference": reference}}
    text = paragraph(cite_dataset(lienumba.run(TOP, overrides=changes)))
    assert "each with the group R^3 x SO(3) or SE(3) [@mueller2014]." in text
    assert "with a fixed step of 0.002 or 0.001 s" in text
    assert "compared with formulas of the motion. All 4 simulations succeeded." in text


def test_a_step_on_a_grid_takes_the_place_of_a_tolerance() -> None:
    reference = {"method": "dop853", "step": 1e-4}
    grids = [{"integrator.step": [1e-3, 5e-4]}, {"integrator.tolerance": [1e-6]}]
    changes = {"integrator__method": "dp54", "integrator__tolerance": 1e-9, "output__every": 0.1}
    one = told(**changes, study={"grid": grids[:1], "reference": reference})
    assert "with a fixed step of 0.001 or 0.0005 s, over" in one
    assert "1e-9" not in one
    both = told(**changes, study={"grid": grids, "reference": reference})
    assert "step of 0.001 or 0.0005 s or with steps that each run chose for an error per step of 1e-6 relative" in both


@pytest.mark.parametrize("x", [0.001, 1e-9, 1.5e20, 15, -4.61538, 2.5e-4, 1e16])
def test_numbers_keep_their_digits(x: float) -> None:
    assert float(number(x)) == x
    assert "e-0" not in number(x)


@pytest.mark.parametrize("file", sorted(SCENARIOS.glob("*.toml")), ids=lambda file: file.stem)
def test_every_scenario_of_the_gallery(file: Path) -> None:
    assert "None" not in paragraph(cite_scenario(resolve(file)))


def test_contacts() -> None:
    """Rigid ones and those that yield, which have a law that somebody has published."""
    data = tomllib.loads((SCENARIOS / "bouncing_ball.toml").read_text())
    (rigid,) = data["model"]["contacts"]
    bare = {key: x for key, x in rigid.items() if key not in ("restitution", "rest_speed")}
    others = [bare | {"name": "soft", "stiffness": 1e4}, bare | {"name": "softer", "stiffness": 1e3}]
    first = paragraph(cite_scenario(resolve(data | {"model": data["model"] | {"contacts": [rigid]}})))
    assert "1 rigid body and 1 contact" in first
    assert "The contact floor is rigid, with Newton's restitution and Coulomb's friction." in first
    every = paragraph(cite_scenario(resolve(data | {"model": data["model"] | {"contacts": [rigid, *others]}})))
    assert "The contacts soft and softer yield, with the force of Hunt and Crossley [@hunt1975]." in every
