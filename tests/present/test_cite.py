"""BibTeX entries: valid, and those of the settings that a scenario, a study or a dataset has."""

import re
import tomllib
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

import lienumba
from lienumba.integrators.methods.charts import GROUPS
from lienumba.present.cite import cite_dataset, cite_scenario
from lienumba.present.references import bibtex, references, software
from lienumba.sweep.samplers import SAMPLERS
from tests.facade import METHODS, app, resolve
from tests.present.bib import read
from tests.rigs.places import ROOT, SCENARIOS

TOP = SCENARIOS / "heavy_top.toml"
MONTE_CARLO = SCENARIOS / "heavy_top_monte_carlo.toml"
PACKAGES = {"harris2020", "virtanen2020", "lam2015", "hoyer2017"}
ALWAYS = {"lienumba", "terze2015"} | PACKAGES
LIE = {"munthekaas1998", "munthekaas1999"}


def keys(text: str) -> set[str]:
    return set(read(text))


def cited(scenario: Path = TOP, **overrides: Any) -> set[str]:
    """Of a scenario with other settings, beside what each cites; `a__b` is the path a.b."""
    changes = {key.replace("__", "."): value for key, value in overrides.items()}
    found = keys(cite_scenario(resolve(scenario, overrides=changes)))
    assert found >= ALWAYS
    return found - ALWAYS


def of(element: Any) -> set[str]:
    return {reference.key for reference in element.references}


def test_every_reference_is_valid() -> None:
    found = read("\n".join([software("1.2.3", 2030), *bibtex(references())]))
    assert found.keys() == references().keys() | {"lienumba"}
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
    tableau = METHODS[method]
    expected = of(tableau) if tableau.composed or tableau.series else of(tableau) | LIE
    assert cited(integrator__method=method) == expected


@pytest.mark.parametrize(
    ("overrides", "more", "fewer"),
    [
        ({}, set(), set()),
        ({"integrator__group": "SE3"}, of(GROUPS["SE3"]), set()),
        ({"integrator__coordinates": "quaternion"}, set(), LIE),
        ({"integrator__coordinates": "joint"}, {"featherstone2008"}, LIE),
        ({"projection__baumgarte": 10, "projection__position": "none", "projection__velocity": "none"},
         {"baumgarte1972"}, set()),
    ],
)  # fmt: skip
def test_settings(overrides: dict[str, Any], more: set[str], fewer: set[str]) -> None:
    assert cited(**overrides) == ({"kutta1901"} | LIE | more) - fewer


@pytest.mark.parametrize("sampler", [name for name in SAMPLERS if name not in ("table", "saltelli")])
def test_samplers(sampler: str) -> None:
    found = cited(sweep={
        "runs": 8, "seed": 3, "sampler": sampler,
        "vary": {"bodies.top.mass": {"distribution": "uniform", "low": 14, "high": 16}},
        "proposal": {"bodies.top.mass": {"shift": 1.5}} if SAMPLERS[sampler].weighted else {},
    })  # fmt: skip
    assert found == {"kutta1901"} | LIE | of(SAMPLERS[sampler])


def test_yielding_contacts() -> None:
    data = tomllib.loads((SCENARIOS / "bouncing_ball.toml").read_text()) | {"sweep": {}}
    (rigid,) = data["model"]["contacts"]
    yielding = {key: x for key, x in rigid.items() if key not in ("restitution", "rest_speed")} | {"stiffness": 1e4}
    with_yielding = data | {"model": data["model"] | {"contacts": [yielding]}}
    assert keys(cite_scenario(resolve(with_yielding))) - keys(cite_scenario(resolve(data))) == {"hunt1975"}


def test_a_study_cites_the_methods_of_its_grid_and_of_its_reference() -> None:
    grid = [{"integrator.method": ["euler", "rk4"], "integrator.step": [1e-3]}]
    study = {"extends": TOP, "study": {"grid": grid, "reference": {"method": "dop853", "step": 1e-3}}}
    found = keys(cite_scenario(resolve(study)))
    assert found - ALWAYS == of(METHODS["euler"]) | of(METHODS["rk4"]) | of(METHODS["dop853"]) | LIE


def test_a_dataset_and_its_scenario_agree(tmp_path: Path) -> None:
    changes = {"sweep.runs": 2, "integrator.end_time": 0.01}
    ds = lienumba.run(MONTE_CARLO, overrides=changes, output=tmp_path / "out.nc")
    text = cite_dataset(ds)
    assert keys(text) == keys(cite_scenario(resolve(MONTE_CARLO, overrides=changes)))
    entry = read(text)["lienumba"]
    assert entry["year"] == ds.attrs["history"][:4]
    assert entry["note"] == f"Version {ds.attrs['lienumba_version']}"
    shown = CliRunner().invoke(app, ["info", str(tmp_path / "out.nc"), "--cite"])
    assert shown.stdout == text + "\n"
