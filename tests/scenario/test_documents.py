"""Every block of the documents that names a file is one, and works."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

from lienumba.scenario.resolve import resolve
from lienumba.scenario.runner import check_initial

DOCUMENT = Path(__file__).parents[2] / "docs" / "your_own_laws.md"
BLOCKS = dict(re.findall(r"```\w+\n# (\w+\.\w+)\n(.*?)```", DOCUMENT.read_text(), re.DOTALL))


@pytest.fixture
def folder(tmp_path):
    for name, text in BLOCKS.items():
        (tmp_path / name).write_text(text)
    return tmp_path


def test_there_are_blocks():
    assert {"pointing.toml", "engine.toml", "engine.csv", "arm.py", "arm.toml", "system.py"} == set(BLOCKS)


@pytest.mark.parametrize("name", [name for name in BLOCKS if name.endswith(".toml")])
def test_scenarios_are_valid(folder, name):
    scenario = resolve(folder / name)
    assert scenario.warnings == []
    check_initial(scenario)


def test_the_program_runs(folder):
    done = subprocess.run([sys.executable, "system.py"], cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "travel.displacement" in done.stdout


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
