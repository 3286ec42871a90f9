"""The gallery: every scenario is valid, and the template explains every key."""

import re
from pathlib import Path

import pytest
import xarray as xr

import lienumba
from lienumba import System
from lienumba.mechanics.system.output_variables import OUTPUT_VARIABLES
from lienumba.scenario.schema.sections import SECTIONS
from lienumba.scenario.start.build import build
from tests.facade import resolve
from tests.rigs.places import ROOT, SCENARIOS

EXPECTED = "triangle inequality"  # the inertia of the satellite's last body, as the paper prints it
FILES = sorted(SCENARIOS.glob("*.toml"))


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_is_valid_without_a_warning(file: Path) -> None:
    scenario = resolve(file)
    assert all(EXPECTED in str(warning) for warning in scenario.warnings)
    assert bool(scenario.warnings) == (file.stem in ("satellite", "satellite_monte_carlo"))
    model, start = build(scenario, {})
    assert len(model.bodies) == len(start.poses)
    assert len(model.joints) == len(start.joints)


def test_the_gallery_is_complete() -> None:
    assert {file.stem for file in FILES} == {
        "arm_pd",
        "arm_sampled",
        "arm_stiff",
        "belt_drive",
        "bennett",
        "bouncing_ball",
        "brake",
        "bricard",
        "cam",
        "docking",
        "door_closer",
        "door_on_two_hinges",
        "double_pendulum",
        "dish_in_gusts",
        "dzhanibekov",
        "falling_rod",
        "five_bar_leg",
        "flyball_governor",
        "four_bar",
        "gripper",
        "gyroscope_in_gimbals",
        "heavy_top",
        "heavy_top_monte_carlo",
        "heavy_top_robust",
        "heavy_top_study",
        "hold_down",
        "iiwa",
        "leg_test",
        "machine_on_mounts",
        "n_four_bar",
        "pawl",
        "pendulum_chain",
        "rolling_disc",
        "sarrus",
        "satellite",
        "satellite_monte_carlo",
        "satellite_pointing",
        "satellite_settles",
        "satellite_verdict",
        "screw_press",
        "separation",
        "slider_crank",
        "solar_array",
        "solo12",
        "suspension",
        "table",
        "talos",
        "template",
        "thruster",
        "top_over_spin",
        "ur5",
        "ur5_recorded",
    }
    page = (SCENARIOS / "README.md").read_text(encoding="utf-8")
    assert all(f"]({file.name})" in page for file in FILES)


def test_every_scenario_has_its_picture() -> None:
    page, pictures = (SCENARIOS / "README.md").read_text(encoding="utf-8"), ROOT / "docs" / "pictures" / "gallery"
    assert {picture.stem for picture in pictures.iterdir()} == {file.stem for file in FILES}, "run scripts/gallery"
    for file in FILES:
        picture = pictures / f"{file.stem}.png"
        assert f'src="../docs/pictures/gallery/{picture.name}"' in page
        start = picture.read_bytes()[:24]
        assert start.startswith(b"\x89PNG")
        assert int.from_bytes(start[16:20]) == 600  # pixels wide
        assert picture.stat().st_size < 60_000


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_a_system_writes_the_file_that_it_read(file: Path, tmp_path: Path) -> None:
    written = tmp_path / "elsewhere.toml"
    written.write_text(System.from_toml(file).to_toml(), encoding="utf-8")
    assert resolve(written, allow_code=True).sha256() == resolve(file).sha256()
    assert System.from_toml(written, allow_code=True).to_toml() == written.read_text(encoding="utf-8")
    resolved = tmp_path / "resolved.toml"
    resolved.write_text(resolve(file).to_toml(), encoding="utf-8")
    assert resolve(resolved, allow_code=True).sha256() == resolve(file).sha256()


@pytest.mark.parametrize("name", ["arm_pd", "arm_sampled", "cam", "rolling_disc", "satellite_pointing", "thruster"])
def test_what_a_system_writes_has_the_same_bits(name: str, tmp_path: Path) -> None:
    file, written = SCENARIOS / f"{name}.toml", tmp_path / "elsewhere.toml"
    system = System.from_toml(file)
    written.write_text(system.to_toml(), encoding="utf-8")
    end = 40 * system.to_dict()["integrator"]["step"]
    short = {"integrator.end_time": end, "output": {"times": [0.0, end]}, "sweep.runs": 3}
    first, *others = (lienumba.run(x, overrides=short, allow_code=True) for x in (file, system, written))
    for other in others:
        xr.testing.assert_identical(first.drop_attrs(deep=False), other.drop_attrs(deep=False))


def test_the_template_has_every_key_with_a_comment() -> None:
    text = (SCENARIOS / "template.toml").read_text(encoding="utf-8")
    comments = "\n".join(line for line in text.splitlines() if line.startswith("#"))
    for names, section in SECTIONS.items():
        for key in section.model_fields:
            assert re.search(rf"(^|[\s{{,.\[]){key}( =|\]|:|\.)", text, re.MULTILINE), f"{names}: {key} is not there"
    for word in (*OUTPUT_VARIABLES, "euler", "midpoint", "heun", "kutta3", "rk38", "identity", "none"):
        assert word in text
    for word in ("kg", "rad", "optional, default"):
        assert word in comments


def test_the_sweep_varies_what_it_says() -> None:
    scenario = resolve(SCENARIOS / "heavy_top_monte_carlo.toml")
    varied = " ".join(scenario.data.sweep.vary)
    assert scenario.data.sweep.runs == 1000
    assert all(word in varied for word in ("mass", "inertia", "angular_velocity", "points"))
    assert scenario.data.model.bodies[0].position is None
