"""Small mechanisms as scenarios, and their states as the naive twin takes them."""

import copy
from dataclasses import replace
from typing import Any

import numpy as np

import lienumba
from lienumba.mechanics.mechanism.model_numbers import map_numbers
from lienumba.scenario.start.prepare import prepare
from tests.facade import Model, resolve
from tests.oracles.reference.lagrange_top import State, motion
from tests.rigs import parts
from tests.rigs.scenario_example import EXAMPLE

Twin = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]  # r (k,3), R (k,3,3), v (k,3), w (k,3)

TOP: dict[str, Any] = {"model": {key: EXAMPLE["model"][key] for key in ("bodies", "joints")}}

LINK: dict[str, Any] = {"mass": 1.3, "inertia": [0.06, 0.05, 0.02, 0.004, -0.006, 0.005]}
PENDULUM: dict[str, Any] = {  # two skew links, kicked out of their plane
    "model": {
        "bodies": [
            parts.body("upper", **LINK, rotation={"rotation_vector": [0.4, 0.9, -0.2]}, angular_velocity=[2, -3, 5]),
            parts.body("lower", 0.8, [[0.03, 0.002, 0.001], [0.002, 0.04, -0.003], [0.001, -0.003, 0.025]],
                       rotation={"euler": "ZYX", "angles": [0.3, -0.5, 1.1]}, angular_velocity=[-4, 1, 2]),
        ],
        "joints": [
            parts.joint("hang", "spherical", "upper", points=[[0.1, 0, 0], [0, 0.02, 0.3]]),
            parts.joint("elbow", "spherical", "lower", "upper", points=[[0.03, 0, -0.3], [0, -0.01, 0.25]]),
        ],
    }
}  # fmt: skip

LOOP: dict[str, Any] = {  # two bodies, a foot on the ground, four rods; five freedoms are left
    "model": {
        "gravity": [0.3, -1, -9.81],
        "bodies": [
            parts.body("left", **LINK, rotation={"axis": [0, 1, 0.2], "angle": 0.6}, angular_velocity=[1, 0, 2]),
            parts.body("right", 2.1, [0.05, 0.07, 0.04, -0.004, 0.006, 0.001], position=[0.9, 0.1, -0.5],
                       rotation={"rotation_vector": [0.2, -0.4, 0.3]}),
        ],
        "joints": [
            parts.joint("foot", "spherical", "left", points=[[0, 0, 0], [-0.1, 0.05, 0.3]]),
            parts.joint("tie", "distance", "right", "left", points=[[0.1, 0, -0.3], [0, 0.1, -0.2]]),
            parts.joint("rope", "distance", "ground", "right", points=[[0, 0, 0.25], [1, 0.2, 0.4]]),
            parts.joint("stay", "distance", "right", points=[[0.2, 0.9, 0], [0.1, 0.2, 0]]),
            parts.joint("brace", "distance", "right", "left", points=[[0, 0.2, 0], [0.1, -0.1, 0.2]]),
        ],
    }
}  # fmt: skip

BENNETT: dict[str, Any] = {  # four rods whose opposite ones are equal: 20 rows of rank 17, and a full turn of freedom
    "model": {
        "bodies": [
            parts.body(name, mass, inertia, position=place, rotation=[1, 0, 0, 0])
            for name, mass, inertia, place in [
                ("first", 0.6, [0.0126, 0.0091, 0.0126, 0.006, -0.0045, 0.006], [0.35, 0.2, 0]),
                ("second", 0.9, [0.01885, 0.0436, 0.04885, -0.021, 0.01575, 0.009], [-0.15, 0.2, 0]),
                ("third", 0.6, [0.0126, 0.0091, 0.0126, 0.006, 0.0045, -0.006], [-0.35, -0.2, 0]),
            ]
        ],
        "joints": [
            {"name": name, "type": "revolute", "bodies": ends, "at": at, "axis": axis, **rate}
            for name, ends, at, axis, rate in [
                ("hinge1", ["ground", "first"], [0.5, 0, 0.15], [-6, 3, 10], {"rate": 6.0}),
                ("hinge2", ["first", "second"], [0.2, 0.4, -0.15], [0, 3, 4], {}),
                ("hinge3", ["second", "third"], [-0.5, 0, 0.15], [6, -3, 10], {}),
                ("hinge4", ["third", "ground"], [-0.2, -0.4, -0.15], [0, -3, 4], {}),
            ]
        ],
    }
}


def chain(links: int) -> dict[str, Any]:
    """Links that hang from the ground by spherical joints, every one with its own full inertia and turn."""
    bodies: list[dict[str, Any]] = []
    joints: list[dict[str, Any]] = []
    for i in range(links):
        xx, xy = 0.02 + 0.003 * i, 0.002 * (-1) ** i
        bodies.append(
            parts.body(
                f"link{i}", 1 + 0.1 * i, [xx, xx + 0.004, 0.01, xy, -0.001, 0.0015],
                rotation={"rotation_vector": [0.3 * i - 0.4, 0.7 - 0.2 * i, 0.1 * i]},
                angular_velocity=[1.0 - i, 0.5 * i, 2.0],
            )
        )  # fmt: skip
        points = [[0, 0.01, -0.2] if i else [0, 0, 0], [0.02, 0, 0.2]]
        joints.append(
            parts.joint(f"hinge{i}", "spherical", f"link{i}", f"link{i - 1}" if i else "ground", points=points)
        )
    return {"model": {"bodies": bodies, "joints": joints}}


def scenario(
    mechanism: dict[str, Any],
    step: float,
    end: float,
    *,
    method: str = "rk4",
    projection: tuple[str, str] = ("local", "mass"),
    output: dict[str, Any] | None = None,
    **keys: Any,
) -> dict[str, Any]:
    """The scenario of a mechanism; `projection`: of positions and velocities; `keys`: more of that section.

    The output is, unless given, at the start and the end alone.
    """
    data = copy.deepcopy(mechanism)
    data["integrator"] = {"method": method, "step": step, "end_time": end}
    data["projection"] = {"position": projection[0], "velocity": projection[1], **keys}
    data["output"] = output or {"times": [0.0, end], "also": ["multiplier"]}
    return data


def simulate(*arguments: Any, **keywords: Any) -> Any:
    """The dataset of the first run of `scenario(...)`; every run must be good."""
    dataset = lienumba.run(scenario(*arguments, **keywords), workers=1)
    assert (dataset["status"] == 0).all()
    return dataset.isel(run=0)


def state_at(dataset: Any, time: int = -1) -> Twin:
    """r (k,3), R (k,3,3), v (k,3), w (k,3) of one run at one of its output times."""
    names = ("position", "rotation", "velocity", "angular_velocity")
    r, R, v, w = (dataset[name].isel(time=time).values for name in names)
    return r, R, v, w


def start_of(data: dict[str, Any]) -> tuple[Model, np.ndarray]:
    """The model of one run, all its numbers floats and its rods' lengths found; and the assembled state (k, 18)."""
    prepared = prepare(resolve(data), [0])
    model = map_numbers(prepared.model, lambda x, _: float(np.ravel(x)[0]))
    return model, prepared.states.reshape(-1, 18)


def twin_of(data: dict[str, Any]) -> tuple[tuple[Any, Any, Any], Twin]:
    """Bodies, joints and gravity for the naive twin, and the state r R v w at the start."""
    model, states = start_of(data)
    joints = [replace(joint, points=tuple(np.array(point) for point in joint.points)) for joint in model.joints]
    r, R, v, w = np.split(states, (3, 12, 15), axis=1)
    return (model.bodies, joints, np.array(model.gravity)), (r, R.reshape(-1, 3, 3), v, w)


def exact_top(time: float) -> State:
    (state,) = motion([time])
    return state
