"""The gallery: every scenario is valid, and the template explains every key."""

import re
from pathlib import Path

import pytest

from lienumba.scenario.build import build
from lienumba.scenario.resolve import resolve
from lienumba.scenario.schema import SECTIONS, VARIABLES

FOLDER = Path(__file__).parents[2] / "scenarios"
EXPECTED = "triangle inequality"  # the inertia of the satellite's last body, as the paper prints it
FILES = sorted(FOLDER.glob("*.toml"))


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_is_valid_without_a_warning(file: Path) -> None:
    scenario = resolve(file)
    assert all(EXPECTED in sentence for sentence in scenario.warnings)
    assert bool(scenario.warnings) == file.stem.startswith("satellite")
    model, start = build(scenario, {})
    assert len(model.bodies) == len(start.poses)
    assert len(model.joints) == len(start.joints)


def test_the_gallery_is_complete() -> None:
    assert {file.stem for file in FILES} == {
        "bennett",
        "bricard",
        "door_on_two_hinges",
        "double_pendulum",
        "dzhanibekov",
        "flyball_governor",
        "four_bar",
        "gyroscope_in_gimbals",
        "heavy_top",
        "heavy_top_monte_carlo",
        "n_four_bar",
        "pendulum_chain",
        "sarrus",
        "satellite",
        "satellite_monte_carlo",
        "screw_press",
        "slider_crank",
        "template",
    }
    page = (FOLDER / "README.md").read_text(encoding="utf-8")
    assert all(f"]({file.name})" in page for file in FILES)


def test_the_template_has_every_key_with_a_comment() -> None:
    text = (FOLDER / "template.toml").read_text(encoding="utf-8")
    comments = "\n".join(line for line in text.splitlines() if line.startswith("#"))
    for names, section in SECTIONS.items():
        for key in section.model_fields:
            assert re.search(rf"(^|[\s{{,.\[]){key}( =|\]|:)", text, re.MULTILINE), f"{names}: {key} is not there"
    for word in (*VARIABLES, "euler", "midpoint", "heun", "kutta3", "rk38", "identity", "none"):
        assert word in text
    for word in ("kg", "rad", "optional, default"):
        assert word in comments


def test_the_sweep_varies_what_it_says() -> None:
    scenario = resolve(FOLDER / "heavy_top_monte_carlo.toml")
    varied = " ".join(scenario.data.sweep.vary)
    assert scenario.data.sweep.runs == 1000
    assert all(word in varied for word in ("mass", "inertia", "angular_velocity", "points"))
    assert scenario.data.model.bodies[0].position is None
