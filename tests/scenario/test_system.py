"""A System is the same scenario, written in Python."""

from pathlib import Path

import numpy as np
import pytest

import lienumba
from lienumba.scenario.system import System
from tests.facade import ScenarioError, resolve
from tests.rigs.scenario_example import example


def heavy_top() -> System:
    top = System("example")
    top.gravity = [0, 0, -9.81]
    top.body(
        "top",
        mass=15,
        inertia=np.array([0.234375, 0.46875, 0.234375]),
        position=(0, 1, 0),
        rotation=[1, 0, 0, 0],
        angular_velocity=np.array([0, 150, -4.61538]),
    )
    top.joint("pivot", "spherical", ("ground", "top"), points=[[0, 0, 0], [0, -1, 0]])
    top.integrator(step=1e-3, end_time=0.1)
    top.output(every=0.01)
    top.sweep(runs=3, seed=1)
    top.vary("bodies.top.mass", distribution="normal", std=0.1)
    return top


def test_equals_the_same_scenario_in_toml() -> None:
    assert resolve(heavy_top()).to_toml() == resolve(example()).to_toml()


def test_writes_and_reads_toml(tmp_path: Path) -> None:
    file = tmp_path / "top.toml"
    file.write_text(heavy_top().to_toml(), encoding="utf-8")
    again = System.from_toml(file)
    assert again.to_dict() == heavy_top().to_dict()
    again.projection(position="none", velocity="none")
    assert resolve(again).data.projection.position == "none"


def test_calls_may_be_chained_and_added_to() -> None:
    system = System().body("a", mass=1, inertia=[1, 1, 1]).body("b", mass=1, inertia=[1, 1, 1])
    system.joint("rod", "distance", ["a", "b"], points=[[0, 0, 0], [0, 0, 0]], length=2.0)
    system.integrator(step=0.1, end_time=1, method="euler")
    data = resolve(system).data
    assert [body.name for body in data.model.bodies] == ["a", "b"]
    assert data.model.joints[0].length == 2.0
    assert data.model.gravity == system.gravity


def test_joints_drivers_and_forces_have_the_keys_of_the_file() -> None:
    system = System().body("a", mass=1, inertia=[1, 1, 1]).body("b", mass=1, inertia=[1, 1, 1], relative_to="a")
    system.joint("hinge", "revolute", ["ground", "a"], at=[0, 0, 1], axis=np.array([0, 1, 0]), rate=2)
    system.joint("slide", "prismatic", ["a", "b"], points=np.zeros((2, 3)), axes=[[1, 0, 0], [1, 0, 0]])
    system.joint("rack", "gear", joints=["hinge", "slide"], ratio=0.1)
    system.driver(joint="hinge", rate="2 + sin(t)")
    system.force(type="spring_damper", bodies=["ground", "b"], points=np.zeros((2, 3)), stiffness=3)
    system.force("wind", type="force", body="b", value=["sin(t)", 0, 0])
    system.integrator(step=0.1, end_time=1)
    model = resolve(system).data.model
    assert [joint.type for joint in model.joints] == ["revolute", "prismatic", "gear"]
    assert [driver.name for driver in model.drivers] == ["driver_1"]
    assert [force.name for force in model.forces] == ["spring_damper_1", "wind"]
    assert resolve(system.to_dict()).to_toml() == resolve(system).to_toml()


def test_mistakes_are_found_by_the_same_checks() -> None:
    system = heavy_top()
    system.output(evry=0.01)
    with pytest.raises(ScenarioError, match=r'output\.evry is not a known key; the nearest known name is "every"'):
        resolve(system)


def test_the_package_offers_it_and_runs_it() -> None:
    assert lienumba.System is System
    dataset = lienumba.run(heavy_top(), overrides={"integrator.end_time": 0.02})
    assert dataset.sizes["run"] == 3
    assert dataset.attrs["title"] == "example"
