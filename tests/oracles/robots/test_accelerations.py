"""The gallery's robots against MuJoCo and Pinocchio: accelerations at random states, stored by scripts/robots.

From the same numbers both make articulated bodies of them, in coordinates of joints. Where they are installed, what is
stored is compared with what they say today.
"""

from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from lienumba.mechanics.system import dynamics, kkt
from tests.facade import Instant
from tests.rigs.places import scripts_on_path

NAMES = ("ur5", "iiwa", "solo12", "talos")
BODIES = {"ur5": 6, "iiwa": 7, "solo12": 13, "talos": 33}
ENGINES = ("mujoco", "pinocchio")
CLOSE = 1e-11  # relative to the largest acceleration
NO_PROJECTION = {"position": "none", "velocity": "none"}
MACHINE = [  # robots, and the coordinates in which their kernels integrate
    ("ur5", "lie"), ("solo12_rotors", "lie"), *((name, "joint") for name in NAMES), ("solo12_rotors", "joint"),
]  # fmt: skip


@cache
def bench() -> Any:
    """The helper modules of the scripts."""
    with scripts_on_path():
        from bench import robot_cases, robot_rivals, robots
    return robots, robot_cases, robot_rivals


@cache
def robot(name: str) -> Any:
    return bench()[0].Robot(name, 16)


@cache
def stored(name: str) -> Any:
    """Random states of a robot's tree, and what both engines make of them: q, v, by engine."""
    with np.load(Path(__file__).with_name("accelerations.npz")) as file:
        q, v = bench()[0].normal(robot(name.removesuffix("_rotors")).tree, file[f"{name}_q"]), file[f"{name}_v"]
        return q, v.astype(float), {engine: file[f"{name}_{engine}"] for engine in ENGINES}


def by_the_model(model: Any, states: np.ndarray) -> np.ndarray:
    """Of every body (runs, k, 6) by the elimination that kernels are traced from, in numbers."""
    x = states.reshape(len(states), len(model.bodies), 18)
    now = Instant(tuple(tuple(x[:, i, c] for c in range(18)) for i in range(x.shape[1])))
    found = dynamics.accelerations(model, kkt.Structure.of(model), now).x
    return np.stack(np.broadcast_arrays(*found), axis=1).reshape(len(states), -1, 6)


def assert_close(found: np.ndarray, expected: np.ndarray, close: float = CLOSE) -> None:
    np.testing.assert_allclose(found, expected, rtol=0, atol=close * float(np.abs(expected).max()))


def at_zero(x: np.ndarray, y: list[np.ndarray]) -> np.ndarray:
    """The polynomial through these points at 0, after Neville."""
    for n in range(1, len(x)):
        y = [(x[i] * y[i + 1] - x[i + n] * y[i]) / (x[i] - x[i + n]) for i in range(len(x) - n)]
    return y[0]


@pytest.mark.parametrize("name", NAMES)
def test_accelerations(name: str) -> None:
    tree, (q, v, expected) = robot(name).tree, stored(name)
    found = by_the_model(robot(name).nominal.model, tree.states(q, v))
    assert found.shape == (100, BODIES[name], 6)
    for engine in ENGINES:
        assert_close(found, tree.accelerations(q, v, expected[engine]))


@pytest.mark.parametrize("name", NAMES)
def test_accelerations_with_rotors_at_all_joints(name: str) -> None:
    model, (q, v, expected) = robot(name).nominal.model, stored(f"{name}_rotors")
    model = replace(model, joints=tuple(replace(joint, armature=bench()[0].ARMATURE) for joint in model.joints))
    tree = robot(name).tree
    found = by_the_model(model, tree.states(q, v))
    for engine in ENGINES:
        assert_close(found, tree.accelerations(q, v, expected[engine]))


@pytest.mark.parametrize(("key", "way"), MACHINE)
def test_accelerations_of_machine_code(key: str, way: str) -> None:
    """In a step of Euler the rates of the coordinates gain their changes times h, those of bodies in the limit of h."""
    own, (q, v, expected) = robot(key.removesuffix("_rotors")), stored(key)
    own = own.with_rotors() if key.endswith("_rotors") else own
    settings = bench()[1].WAYS[way] | {"integrator.method": "euler", "projection": NO_PROJECTION}
    engine, before = bench()[0].Engine(own.at(q, v), settings), own.tree.states(q, v)
    steps = 2.0 ** -np.arange(8, 14)
    gained = [(engine.run(1, 1, h)[0] - before).reshape(len(q), -1, 18)[:, :, 12:18] / h for h in steps]
    assert_close(at_zero(steps, gained), own.tree.accelerations(q, v, expected["mujoco"]))


@pytest.mark.parametrize("name", NAMES)
def test_trees_fit_their_joints_and_come_back(name: str) -> None:
    tree, (q, v, _) = robot(name).tree, stored(name)
    start = robot(name).nominal.assembled.state.reshape(1, -1)
    np.testing.assert_allclose(tree.states(*tree.coordinates(start)), start, rtol=0, atol=1e-12)
    states = tree.states(q, v)
    assert_close(tree.states(*tree.coordinates(states)), states)


def test_the_angles_are_those_of_the_urdf() -> None:
    """Where all angles are 0, a UR5 points along x, and its flange is as far out as its links are long."""
    wrist = robot("ur5").tree.states(np.zeros((1, 6)), np.zeros((1, 6)))[0, -18:-15]
    np.testing.assert_allclose(wrist, [0.425 + 0.39225, 0.13585 - 0.1197 + 0.093, 0.089159 - 0.09465], atol=1e-12)


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("name", NAMES)
def test_what_is_stored_is_what_they_say_today(name: str, engine: str) -> None:
    pytest.importorskip(engine, reason=f"{engine} is not installed (extra bench): what is stored is not renewed")
    robots, _, rivals = bench()
    for key, tree in ((name, robot(name).tree), (f"{name}_rotors", robot(name).with_rotors().tree)):
        rival = rivals.Mujoco(tree, robots.STEP) if engine == "mujoco" else rivals.Pinocchio(tree)
        q, v, expected = stored(key)
        assert_close(rival.accelerations(q, v), expected[engine])


@pytest.mark.parametrize("name", ["ur5", "solo12"])
def test_mujoco_ends_where_we_end(name: str) -> None:
    """RK4 in other coordinates: what the benchmark times is the same motion."""
    pytest.importorskip("mujoco", reason="mujoco is not installed (extra bench)")
    (robots, _, rivals), own = bench(), robot(name)
    ends = own.tree.states(*rivals.Mujoco(own.tree, robots.STEP).run(own.q, own.v, 20)[:2])
    assert np.abs(ends - robots.Engine(own).run(20, 1)[0]).max() < 1e-6
