"""Laws in files beside the scenario: found from anywhere, kept with the scenario, and part of its hash."""

import os
import tomllib
from pathlib import Path

import numpy as np
import pytest

import lienumba
from lienumba.scenario.base.toml import dumps
from tests.facade import resolve
from tests.laws.rigs import pendulum, run

LAW = "def push(joint, *, size):\n    return joint.effort(size)\n"
SCENARIO = """
[model]
[[model.bodies]]
name = "rod"
mass = 1
inertia = [0.1, 0.1, 0.1]
[[model.joints]]
name = "hinge"
type = "revolute"
bodies = ["ground", "rod"]
points = [[0, 0, 0], [0, 0, 1]]
axes = [[0, 1, 0], [0, 1, 0]]
[[model.forces]]
name = "own"
type = "python"
function = "law.py:push"
joints = ["hinge"]
parameters = { size = 2 }
[integrator]
step = 0.01
end_time = 0.1
"""


def written(folder: Path, scenario: str = SCENARIO, law: str = LAW) -> Path:
    folder.mkdir(exist_ok=True)
    (folder / "arm.toml").write_text(scenario, encoding="utf-8")
    (folder / "law.py").write_text(law, encoding="utf-8")
    return folder / "arm.toml"


def test_the_file_lies_beside_the_scenario_wherever_one_stands(tmp_path, monkeypatch):
    file = written(tmp_path / "deep")
    ds = run(file)
    monkeypatch.chdir(tmp_path)
    np.testing.assert_array_equal(run(Path("deep") / "arm.toml").position, ds.position)
    assert os.getcwd() == str(tmp_path)
    assert tomllib.loads(ds.attrs["scenario"])["files"] == {"law.py": LAW}
    (tmp_path / "deep" / "law.py").unlink()
    np.testing.assert_array_equal(run(tomllib.loads(ds.attrs["scenario"])).position, ds.position)
    with pytest.raises(lienumba.ScenarioError, match=r"there is no file law\.py"):
        run(file)


def test_what_the_file_says_is_what_is_hashed(tmp_path):
    file = written(tmp_path)
    before = resolve(file).sha256()
    assert resolve(written(tmp_path / "elsewhere")).sha256() == before
    written(tmp_path, law=LAW.replace("(size)", "(2*size)"))
    after = resolve(file)
    assert after.sha256() != before
    assert after.data.files["law.py"] != LAW
    assert np.abs(run(file).position - run(tmp_path / "elsewhere" / "arm.toml").position).max() > 1e-4


def test_a_scenario_that_extends_another_finds_the_law_there(tmp_path):
    base = written(tmp_path / "base")
    (tmp_path / "study").mkdir()
    study = tmp_path / "study" / "study.toml"
    study.write_text('extends = "../base/arm.toml"\n[integrator]\nstep = 0.005\n', encoding="utf-8")
    scenario = resolve(study)
    assert scenario.data.files == {"law.py": LAW}
    assert scenario.data.integrator.step == 0.005
    np.testing.assert_allclose(run(study).position[0, -1], run(base).position[0, -1], rtol=0, atol=1e-8)


def test_a_scenario_that_extends_another_brings_a_law_of_its_own(tmp_path):
    """Its file has the name of the one below, and takes the place of it for this force alone."""
    base = written(tmp_path / "base")
    force = '[[model.forces]]\nname = "{}"\ntype = "python"\nfunction = "law.py:push"\njoints = ["hinge"]\n'
    more = f'extends = "../base/arm.toml"\n{force.format("more")}parameters = {{ size = 3 }}\n'
    study = written(tmp_path / "study", scenario=more, law=LAW.replace("(size)", "(-size)"))
    scenario = resolve(study)
    assert len(scenario.data.files) == 2
    ds = run(study)
    base.write_text(SCENARIO.replace("size = 2", "size = -1"))  # 2 - 3
    np.testing.assert_allclose(ds.position, run(base).position, rtol=0, atol=1e-14)


def test_its_numbers_can_be_set_and_its_function_too(tmp_path):
    file = written(tmp_path, law=LAW + "\n\ndef pull(joint, *, size):\n    return joint.effort(-size)\n")
    a = run(file, overrides={"forces.own.parameters.size": -2.0})
    b = run(file, overrides={"forces.own.function": '"law.py:pull"'})
    np.testing.assert_allclose(a.position, b.position, rtol=0, atol=1e-15)


def test_what_a_law_asks_for_is_a_part_of_the_hash(tmp_path):
    """A quantity by its name, as an argument."""
    (tmp_path / "law.py").write_text("def f(joint, *, aim): return joint.effort(-aim.y)\n", encoding="utf-8")

    def scenario(angle: float) -> str:
        aim = {"name": "aim", "type": "rotation_error", "body": "rod", "target": {"axis": [0, 1, 0], "angle": angle}}
        law = {"name": "own", "type": "python", "function": f"{tmp_path}/law.py:f", "joints": ["hinge"]}
        return resolve(pendulum(law, quantities=[aim])).sha256()

    assert scenario(0.1) != scenario(0.2)
    assert scenario(0.1) == scenario(0.1)


def test_a_scenario_that_extends_another_may_change_the_function_alone(tmp_path):
    """Its file lies beside the scenario that names it."""
    for folder in ("base", "study"):
        (tmp_path / folder).mkdir()
    law = {"name": "own", "type": "python", "function": "law.py:f", "joints": ["hinge"]}
    (tmp_path / "base" / "law.py").write_text("def f(joint): return joint.effort(1.0)\n", encoding="utf-8")
    (tmp_path / "study" / "other.py").write_text("def g(joint): return joint.effort(2.0)\n", encoding="utf-8")
    (tmp_path / "base" / "arm.toml").write_text(dumps(pendulum(law)), encoding="utf-8")
    study = tmp_path / "study" / "arm.toml"
    text = 'extends = "../base/arm.toml"\n[[model.forces]]\nname = "own"\nfunction = "other.py:g"\n'
    study.write_text(text, encoding="utf-8")
    push = {"name": "own", "type": "actuator", "joint": "hinge", "value": 2.0}
    np.testing.assert_allclose(run(study).position, run(pendulum(push)).position, rtol=0, atol=1e-13)
