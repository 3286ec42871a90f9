"""Every block of the documents that names a file is one, and works."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

import lienumba
from lienumba.running.runner import check_initial
from lienumba.scenario.resolve import resolve
from lienumba.scenario.study_start import check

DOCUMENTS = [Path(__file__).parents[2] / "docs" / name for name in ("your_own_laws.md", "studies.md")]
TEXT = "".join(document.read_text() for document in DOCUMENTS)
BLOCKS = dict(re.findall(r"```\w+\n# (\w+\.\w+)\n(.*?)```", TEXT, re.DOTALL))


@pytest.fixture
def folder(tmp_path):
    for name, text in BLOCKS.items():
        (tmp_path / name).write_text(text)
    return tmp_path


def test_there_are_blocks():
    laws = {"pointing.toml", "engine.toml", "engine.csv", "arm.py", "arm.toml", "system.py"}
    assert laws | {"study.toml", "study.py", "known.toml"} == set(BLOCKS)


@pytest.mark.parametrize("name", [name for name in BLOCKS if name.endswith(".toml")])
def test_scenarios_are_valid(folder, name):
    scenario = resolve(folder / name)
    assert scenario.warnings == []
    check(scenario)


@pytest.mark.parametrize(
    ("program", "said"), [("system.py", "travel.displacement"), ("study.py", "time of one core per run")]
)
def test_the_programs_run(folder, program, said):
    path = {**os.environ, "PYTHONPATH": str(Path(lienumba.__file__).parents[1])}
    done = subprocess.run([sys.executable, program], cwd=folder, capture_output=True, text=True, check=False, env=path)
    assert done.returncode == 0, done.stderr
    assert said in done.stdout


def test_the_motion_is_as_known(folder):
    found = lienumba.run(folder / "known.toml")
    assert (found["position_error"] < 1e-5).all()
    order = lienumba.analysis.orders(found)["order"].sel(error="position")
    assert float(order) == pytest.approx(4.0, abs=0.2)


@pytest.mark.parametrize(
    ("function", "more"),
    [
        ("rope", {"bodies": ["ground", "b"], "parameters": {"stiffness": 10, "length": 0.5}}),
        ("well", {"bodies": ["b"], "parameters": {"depth": 3}, "returns": "potential"}),
    ],
)
def test_laws_of_forces_work(folder, function, more, monkeypatch):
    monkeypatch.chdir(folder)
    force = {"name": "law", "type": "python", "function": f"arm.py:{function}", **more}
    check_initial(resolve(scenario(forces=[force])))


@pytest.mark.parametrize(
    ("function", "more"),
    [("on_a_sphere", {"parameters": {"radius": 1.0}}), ("skate", {"level": "velocity"})],
)
def test_laws_of_joints_work(folder, function, more, monkeypatch):
    monkeypatch.chdir(folder)
    joint = {"name": "law", "type": "python", "function": f"arm.py:{function}", "bodies": ["b"], **more}
    check_initial(resolve(scenario(joints=[joint])))


def scenario(**model):
    body = {"name": "b", "mass": 1.0, "inertia": [1.0, 1.0, 1.0], "position": [1.0, 0.0, 0.0], "rotation": [1, 0, 0, 0]}
    return {"model": {"bodies": [body], **model}, "integrator": {"step": 1e-3, "end_time": 0.1}}
