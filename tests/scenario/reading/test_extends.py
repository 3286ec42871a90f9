"""Scenarios that build on others."""

from pathlib import Path

import pytest

import lienumba
from tests.facade import resolve
from tests.rigs.places import SCENARIOS

MORE = """
extends = "{base}"
title = "A lighter top in a gust"
[[model.bodies]]
name = "top"
mass = 14
[[model.bodies]]
name = "fly"
mass = 0.1
inertia = [1e-5, 1e-5, 1e-5]
position = [0, 0, 1]
[[model.forces]]
type = "force"
body = "top"
value = ["sin(t)", 0, 0]
[output]
times = [0.1, 0.5]
[sweep.vary]
"bodies.top.mass" = {{ distribution = "uniform", low = 13, high = 15 }}
"""


def written(folder: Path, name: str, text: str) -> Path:
    (folder / name).write_text(text)
    return folder / name


def test_what_differs_takes_the_place_of_what_is_below(tmp_path):
    base = resolve(SCENARIOS / "heavy_top_monte_carlo.toml").to_dict()
    (tmp_path / "base.toml").write_bytes((SCENARIOS / "heavy_top_monte_carlo.toml").read_bytes())
    over = resolve(written(tmp_path, "over.toml", MORE.format(base="base.toml"))).to_dict()
    top, fly = over["model"]["bodies"]
    assert top == base["model"]["bodies"][0] | {"mass": 14.0}
    assert fly["name"] == "fly"
    assert over["model"]["joints"] == base["model"]["joints"]
    assert [force["type"] for force in over["model"]["forces"]] == ["force"]
    assert over["output"]["times"] == [0.1, 0.5]
    assert "every" not in over["output"]
    assert over["integrator"] == base["integrator"]
    assert over["sweep"]["vary"].keys() == base["sweep"]["vary"].keys()
    assert over["sweep"]["vary"]["bodies.top.mass"] == {
        "relative": False, "distribution": "uniform", "low": 13.0, "high": 15.0
    }  # fmt: skip
    assert "extends" not in over


def test_the_whole_is_stored_and_runs_alone(tmp_path):
    (tmp_path / "base.toml").write_bytes((SCENARIOS / "heavy_top.toml").read_bytes())
    short = "[integrator]\nstep = 1e-3\nend_time = 0.01\n"
    file = written(tmp_path, "short.toml", f'extends = "base.toml"\n{short}')
    ds = lienumba.run(file)
    (tmp_path / "base.toml").unlink()
    again = lienumba.run(written(tmp_path, "stored.toml", ds.attrs["scenario"]))
    assert again.attrs["scenario_sha256"] == ds.attrs["scenario_sha256"]
    assert again.position.equals(ds.position)


def test_files_are_sought_beside_the_file_that_names_them(tmp_path):
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "top.toml").write_bytes((SCENARIOS / "heavy_top.toml").read_bytes())
    written(tmp_path / "parts", "middle.toml", 'extends = "top.toml"\n[[model.bodies]]\nname = "top"\nmass = 3\n')
    file = written(tmp_path, "last.toml", 'extends = "parts/middle.toml"\ntitle = "last"\n')
    scenario = resolve(file)
    assert (scenario.data.title, scenario.data.model.bodies[0].mass) == ("last", 3.0)
    assert lienumba.System.from_toml(file).to_dict()["model"]["bodies"][0]["mass"] == 3
    assert resolve({"extends": str(file)}).data.title == "last"


@pytest.mark.parametrize(
    ("first", "second", "sentence"),
    [
        ("a.toml", "", 'extends = "a.toml": leads back to itself; take it out of one of the files'),
        ("b.toml", "a.toml", 'extends = "a.toml": leads back to itself; take it out of one of the files'),
        ("c.toml", "", "does not exist"),
    ],
)
def test_what_cannot_be_extended(tmp_path, first, second, sentence):
    file = written(tmp_path, "a.toml", f'extends = "{first}"\n')
    written(tmp_path, "b.toml", f'extends = "{second}"\n' if second else "")
    with pytest.raises(lienumba.ScenarioError) as caught:
        resolve(file)
    assert sentence in str(caught.value)
    assert str(caught.value).startswith('extends = "')


def test_a_number_is_no_file(tmp_path):
    with pytest.raises(lienumba.ScenarioError, match="must be a text in quotes; give the path of a TOML file"):
        resolve(written(tmp_path, "a.toml", "extends = 3\n"))
