"""Prescribed motions of all kinds: minimal coordinates of which some are functions of time."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.oracles.trees.dense import Array, Motion, closed, motion, simulate
from tests.oracles.trees.kinematics import exponential, turned, vector
from tests.oracles.trees.trees import TIMES, Link, Random, Tree, compare, reactions, run, same, scenario

SWAY = ("0.2*sin(5*t) + 0.3*t - 0.1", lambda t: 0.2 * np.sin(5 * t) + 0.3 * t - 0.1)
SPIN = ("0.4 - 35*t + 0.3*cos(6*t)", lambda t: 0.4 - 35 * t + 0.3 * np.cos(6 * t))  # more than two turns
NUDGE = ("0.1*log(1 + 3*t) + 0.05*tanh(4*t)", lambda t: 0.1 * np.log(1 + 3 * t) + 0.05 * np.tanh(4 * t))
STEP = 2.5e-4  # s, where something spins


def hung(kind: str, order: str, prescribed: dict[int, Callable[[Any], Any]], size: float = 0.0, **more: Any) -> Tree:
    """Body b on body a by the joint `shaft` of this type, a on a ball."""
    draw = Random(kind, order, *prescribed)
    ends = ("a", "b") if order == "+" else ("b", "a")
    ball = draw.joint("ball", "spherical", ("a", "ground"))
    links = [
        Link("a", draw.body(), ball),
        Link("b", draw.body(), draw.joint("shaft", kind, ends), "a", size, prescribed),
    ]
    return Tree(links, **more)


def along_axis(tree: Tree, here: Motion) -> Array:
    """The axis of the shaft that is fixed in its first body, global frame."""
    joint = tree.links[-1].joint
    return here.R[tree.names.index(joint.bodies[0])] @ joint.frames[0][:, 2]


@pytest.mark.parametrize(
    ("kind", "order", "prescriptions", "size"),
    [
        ("revolute", "-", [("angle", 0, *SPIN)], 0.0),
        ("prismatic", "-", [("displacement", 0, *SWAY)], 0.0),
        ("cylindrical", "-", [("angle", 0, *SPIN), ("displacement", 1, *NUDGE)], 0.0),
        ("screw", "+", [("angle", 0, *SPIN)], 0.02),
        ("point_on_line", "-", [("displacement", 0, *SWAY)], 0.0),
    ],
    ids=lambda x: x if isinstance(x, str) else "",
)
def test_coordinates_of_a_joint(kind: str, order: str, prescriptions: list[Any], size: float) -> None:
    drivers = [{"name": c, "joint": "shaft", "coordinate": c, "value": text} for c, _, text, _ in prescriptions]
    prescribed = {i: f for _, i, _, f in prescriptions}
    tree = hung(kind, order, prescribed, size, drivers=drivers, closing={"speed": 35.0})
    q, qd = Random(kind, order, "start").start(tree)
    history = simulate(tree.mechanism, q, qd, TIMES)
    ds = run(scenario(tree, history[0], step=STEP))
    compare(tree, ds, history, 2e-8)
    assert abs(float(ds["work"][-1])) > 1e-3
    reactions(tree, ds, history, 2e-7, skip=["shaft"])
    for time, here in enumerate(history):
        now, axis = ds.isel(time=time), along_axis(tree, here)
        force, torque = tree.load(here, tree.links[-1])
        for name, *_ in prescriptions:
            effort = now["driver_effort"].sel(effort=name)
            if kind == "screw":  # it drives the displacement as well; which of both the thread carries is not unique
                same(effort, torque @ axis + force @ axis * size / (2 * np.pi), 2e-7, "effort on the screw")
                continue
            part = (torque if name == "angle" else force) @ axis
            same(effort, part, 2e-7, f"effort along the {name} at {here.t}")
            force, torque = (force, torque - part * axis) if name == "angle" else (force - part * axis, torque)
        if kind != "screw":
            same(now["joint_force"].sel(joint="shaft"), force, 2e-7, f"force at {here.t}")
            same(now["joint_torque"].sel(joint="shaft"), torque, 2e-7, f"torque at {here.t}")


def started(tree: Tree, draw: Random) -> tuple[Array, Array, Motion]:
    """Any coordinates and rates, and where the tree is with them."""
    q, qd = draw.start(tree)
    bare = Tree(tree.links, tree.gravity).mechanism
    return q, qd, motion(bare, 0.0, q, qd)


def wave(sizes: list[float], t: Any) -> Array:
    """A motion that begins at 0."""
    return vector(*(size * np.sin((2 + i) * t) + 0.5 * size * t**2 for i, size in enumerate(sizes)))


def formulas(start: Array, sizes: list[float]) -> list[str]:
    """start + wave(t), as a scenario writes it."""
    waves = [f"{size!r}*sin({2 + i}*t) + {0.5 * size!r}*t**2" for i, size in enumerate(sizes)]
    return [f"{x!r} + {text}" for x, text in zip(start.tolist(), waves, strict=True)]


def check_lower(tree: Tree, q: Array, qd: Array, effort_bound: float = 2e-7) -> None:
    """The multipliers of the oracle's conditions are the efforts of the driver; the joints carry the rest."""
    history = simulate(tree.mechanism, q, qd, TIMES)
    ds = run(scenario(tree, history[0], step=5e-4))
    compare(tree, ds, history)
    for time, here in enumerate(history):
        same(ds["driver_effort"][time], here.multipliers, effort_bound, f"effort at {here.t}")
    reactions(tree, ds, history)
    assert abs(float(ds["work"][-1])) > 1e-3


def test_a_point_of_the_last_body_is_led() -> None:
    draw = Random("point")
    tree, sizes, p = hung("universal", "-", {}), [0.1, -0.08, 0.12], np.array(draw.vector(0.3))
    q, qd, start = started(tree, draw)
    at = start.r[1] + start.R[1] @ p
    driver = {"body": "b", "motion": "point", "point": p.tolist(), "value": formulas(at, sizes)}

    def closure(places: Any, t: Any) -> Array:
        r, R = places[1]
        return r + turned(R, p) - at - wave(sizes, t)

    tree = Tree(tree.links, drivers=[driver], closing={"closure": closure})
    check_lower(tree, *closed(tree.mechanism, q, qd, free=[0, 3]))


def test_the_last_body_is_oriented() -> None:
    """The effort is the torque on the body, in its own frame."""
    draw = Random("orientation")
    tree, sizes = hung("spherical", "+", {}), [0.5, 0.8, -0.4]
    q, qd, start = started(tree, draw)
    u = Rotation.from_matrix(start.R[1]).as_rotvec()
    driver = {"body": "b", "motion": "orientation", "value": formulas(u, sizes)}

    def closure(places: Any, t: Any) -> Array:
        between = np.swapaxes(exponential(u + wave(sizes, t)), -1, -2) @ places[1][1]
        skew = 0.5 * (between - np.swapaxes(between, -1, -2))
        return vector(skew[..., 2, 1], skew[..., 0, 2], skew[..., 1, 0])

    tree = Tree(tree.links, drivers=[driver], closing={"closure": closure})
    check_lower(tree, *closed(tree.mechanism, q, qd, free=[0, 1, 2]))


@pytest.mark.parametrize("frame", ["global", "body"])
def test_the_last_body_turns_about_an_axis_that_wanders(frame: str) -> None:
    draw = Random("wandering", frame)
    tree, sizes = hung("revolute", "+", {}), [2.0, -1.5, 1.0]
    q, qd, start = started(tree, draw)
    w = start.w[1] if frame == "global" else start.R[1].T @ start.w[1]
    driver = {"body": "b", "motion": "angular_velocity", "frame": frame, "value": formulas(w, sizes)}

    def prescribed(places: Any, v: Array, spin: Array, t: Any) -> Array:
        R = places[1][1]
        own = spin[1] if frame == "global" else turned(np.swapaxes(R, -1, -2), spin[1])
        return own - w - wave(sizes, t)

    tree = Tree(tree.links, drivers=[driver], closing={"prescribed": prescribed})
    check_lower(tree, q, qd)
