"""Closed loops, free and driven: trees whose last joint is a condition with multipliers; the order of the methods."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from tests.oracles.trees.dense import Array, closed, motion, simulate
from tests.oracles.trees.kinematics import Joint, frame, turned, vector
from tests.oracles.trees.trees import TIMES, Link, Random, Tree, compare, reactions, run, same, scenario
from tests.rigs import parts

Closure = Callable[[Any, Any], Array]


def open_chain(draw: Random, slider: str, crank: dict[int, Callable[[Any], Any]], **more: Any) -> Tree:
    """A crank on the ground, a coupler on it by a ball, and a slider on the ground."""
    links = [
        Link("crank", draw.body(), draw.joint("shaft", "revolute", ("crank", "ground")), "ground", 0.0, crank),
        Link("coupler", draw.body(), draw.joint("pin", "spherical", ("crank", "coupler")), "crank"),
        Link("slider", draw.body(), draw.joint("guide", slider, ("ground", "slider"))),
    ]
    return Tree(links, **more)


def meeting(tree: Tree, q: Array, on_coupler: Any) -> Array:
    """The point of the slider, its own frame, where a point of the coupler is at the start."""
    here = motion(Tree(tree.links).mechanism, 0.0, q, 0 * q)
    return here.R[2].T @ (here.r[1] + here.R[1] @ on_coupler - here.r[2])


def apart(p: Any, s: Any) -> Closure:
    """From the coupler's point to the slider's."""

    def closure(places: Any, t: Any) -> Array:
        (r, R), (x, X) = places[1:]
        return x + turned(X, s) - r - turned(R, p)

    return closure


def with_ball(
    draw: Random, slider: str, crank: dict[int, Callable[[Any], Any]], free: list[int], **more: Any
) -> tuple[Tree, Array, Array]:
    """The loop, closed by a ball between coupler and slider, and its start: rates of the other coordinates follow."""
    tree = open_chain(draw, slider, crank)
    q, qd = draw.start(tree)
    p = np.array(draw.vector(0.6))
    s = meeting(tree, q, p)
    ball = {"name": "ball", "type": "spherical", "bodies": ["coupler", "slider"], "points": [p.tolist(), s.tolist()]}
    tree = Tree(tree.links, joints=[ball], closing={"closure": apart(p, s)}, **more)
    return tree, *closed(tree.mechanism, q, qd, free)


def check_ball(tree: Tree, ds: Any, history: Any) -> None:
    compare(tree, ds, history)
    for time, here in enumerate(history):
        now = ds.sel(joint="ball").isel(time=time)
        same(now["joint_force"], here.multipliers, 2e-7, f"force at {here.t}")
        same(now["joint_torque"], [0, 0, 0], 1e-7, "torque of a ball")


def test_a_crank_swings_on_its_loop() -> None:
    tree, q, qd = with_ball(Random("swinging", 0), "prismatic", {}, [0, 1])
    history = simulate(tree.mechanism, q, qd, TIMES)
    ds = run(scenario(tree, history[0]))
    check_ball(tree, ds, history)
    reactions(tree, ds, history)


ANGLE = ("0.3 + 2*t + 0.4*sin(5*t)", lambda t: 0.3 + 2 * t + 0.4 * np.sin(5 * t))


def driven() -> tuple[Tree, Array, Array]:
    """A slider that also turns: two freedoms are left beside the crank's motion."""
    driver = {"name": "motor", "joint": "shaft", "value": ANGLE[0]}
    return with_ball(Random("driven", 1), "cylindrical", {0: ANGLE[1]}, [0, 3], drivers=[driver])


def test_a_driven_crank_moves_its_loop() -> None:
    tree, q, qd = driven()
    history = simulate(tree.mechanism, q, qd, TIMES)
    ds = run(scenario(tree, history[0]))
    check_ball(tree, ds, history)
    reactions(tree, ds, history, skip=["shaft"])
    shaft = tree.links[0]
    for time, here in enumerate(history):
        force, torque = tree.load(here, shaft)
        axis = here.R[0] @ shaft.joint.frames[0][:, 2]
        effort = torque @ axis
        now = ds.isel(time=time)
        same(now["driver_effort"], [effort], 1e-7, f"effort at {here.t}")
        same(now["joint_force"].sel(joint="shaft"), force, 1e-7, "force of the shaft")
        same(now["joint_torque"].sel(joint="shaft"), torque - effort * axis, 1e-7, "torque of the shaft")
    assert abs(float(ds["work"][-1])) > 1e-2


@pytest.mark.parametrize(
    ("method", "order", "steps"), [("heun", 2, (0.01, 0.005, 0.0025)), ("rk4", 4, (0.05, 0.025, 0.0125))]
)
def test_a_driven_loop_keeps_the_order(method: str, order: int, steps: tuple[float, ...]) -> None:
    """In position, velocity, effort and work."""
    tree, q, qd = driven()
    history = simulate(tree.mechanism, q, qd, TIMES)
    last = history[-1]
    torque = tree.load(last, tree.links[0])[1]
    axis = last.R[0] @ tree.links[0].joint.frames[0][:, 2]
    errors = []
    for step in steps:
        data = scenario(tree, history[0], step=step)
        data["integrator"]["method"] = method
        ds = run(data).isel(time=-1)
        found = [
            np.abs(ds["rotation"].values - last.R).max(),
            np.abs(ds["velocity"].values - last.v).max(),
            abs(float(ds["driver_effort"][0]) - torque @ axis),
            abs(float(ds["energy_residual"])),
        ]
        errors.append(found)
    slopes = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    np.testing.assert_allclose(slopes[-1], order, atol=0.2)


def test_a_rod_closes_a_loop() -> None:
    """Its reaction is along it, and the same on both ends."""
    draw = Random("rod")
    tree = open_chain(draw, "planar", {})
    q, qd = draw.start(tree)
    p, s = np.array(draw.vector(0.4)), np.array(draw.vector(0.4))
    gap = apart(p, s)
    length = float(np.linalg.norm(gap(tree.place(list(q), 0.0), 0.0)))

    def closure(places: Any, t: Any) -> Array:
        d = gap(places, t)
        return (np.sqrt((d * d).sum(axis=-1)) - length)[..., None]

    rod = {"name": "rod", "type": "distance", "bodies": ["slider", "coupler"], "points": [s.tolist(), p.tolist()]}
    tree = Tree(tree.links, joints=[rod], closing={"closure": closure})
    q, qd = closed(tree.mechanism, q, qd, [0, 1, 2, 3, 5, 6])
    history = simulate(tree.mechanism, q, qd, TIMES)
    ds = run(scenario(tree, history[0]))
    compare(tree, ds, history)
    reactions(tree, ds, history)
    for time, here in enumerate(history):
        d = gap(list(zip(here.r, here.R, strict=True)), 0.0)
        now = ds.sel(joint="rod").isel(time=time)
        same(now["joint_force"], -here.multipliers[0] * d / length, 1e-7, f"force at {here.t}")
        same(now["joint_torque"], [0, 0, 0], 1e-7, "torque of a rod")


def test_a_universal_joint_closes_a_loop() -> None:
    """The slider-crank that needs no spin of its coupler: its universal joint is the condition."""
    draw = Random("universal loop")
    tree = open_chain(draw, "prismatic", {})
    q, qd = draw.start(tree)
    p = np.array(draw.vector(0.6))
    s, z = meeting(tree, q, p), np.array(draw.direction())
    here = motion(tree.mechanism, 0.0, q, 0 * q)
    across = np.cross(here.R[1] @ z, draw.vector())
    other = here.R[2].T @ across / np.linalg.norm(across)
    gap = apart(p, s)

    def closure(places: Any, t: Any) -> Array:
        cosine = (turned(places[1][1], z) * turned(places[2][1], other)).sum(axis=-1)
        return np.concatenate([gap(places, t), cosine[..., None]], axis=-1)

    points, axes = [p.tolist(), s.tolist()], [z.tolist(), other.tolist()]
    cross = parts.joint("cross", "universal", "slider", "coupler", points=points, axes=axes)
    tree = Tree(tree.links, joints=[cross], closing={"closure": closure})
    q, qd = closed(tree.mechanism, q, qd, [0])
    history = simulate(tree.mechanism, q, qd, TIMES)
    ds = run(scenario(tree, history[0]))
    compare(tree, ds, history)
    reactions(tree, ds, history)
    for time, here in enumerate(history):
        now = ds.sel(joint="cross").isel(time=time)
        same(now["joint_force"], here.multipliers[:3], 1e-7, f"force at {here.t}")
        torque = here.multipliers[3] * np.cross(here.R[2] @ other, here.R[1] @ z)
        same(now["joint_torque"], torque, 1e-7, f"torque at {here.t}")


def test_a_four_bar_of_four_hinges_in_a_tilted_plane() -> None:
    """Three equations too many: the motion, and the forces in the plane, are still those of the plane mechanism."""
    draw = Random("four bar")
    plane = frame(draw.direction(), draw.direction())
    normal = plane[:, 2]

    def hinge(name: str, ends: tuple[str, str], p: list[float], q: list[float]) -> Joint:
        """All bodies lie in the plane when their frames are the global one."""
        points = (plane @ [*p, 0.1], plane @ [*q, 0.1])
        return Joint(name, "revolute", ends, points, (normal, normal), (plane[:, 0], plane[:, 0]))

    links = [
        Link("crank", draw.body(), hinge("one", ("ground", "crank"), [0, 0], [-0.1, 0.2])),
        Link("coupler", draw.body(), hinge("two", ("crank", "coupler"), [0.3, 0.1], [-0.4, 0.1]), "crank"),
        Link("rocker", draw.body(), hinge("three", ("rocker", "ground"), [-0.2, 0.3], [1.1, 0.1])),
    ]
    tree = Tree(links)
    q = np.array([0.4, -0.2, 0.3])
    p = plane @ [0.5, 0.2, 0.1]
    here = motion(tree.mechanism, 0.0, q, 0 * q)
    s = here.R[2].T @ (here.r[1] + here.R[1] @ p - here.r[2])
    gap = apart(p, s)

    def closure(places: Any, t: Any) -> Array:
        d = gap(places, t)
        return vector(d @ plane[:, 0], d @ plane[:, 1])

    points, axes = [p.tolist(), s.tolist()], [normal.tolist(), normal.tolist()]
    table = parts.joint("four", "revolute", "rocker", "coupler", points=points, axes=axes)
    tree = Tree(links, joints=[table], closing={"closure": closure})
    q, qd = closed(tree.mechanism, q, np.array([2.0, 0.0, 0.0]), [0])
    history = simulate(tree.mechanism, q, qd, TIMES)
    ds = run(scenario(tree, history[0]))
    compare(tree, ds, history)
    for time, here in enumerate(history):
        forces = ds["joint_force"].isel(time=time)
        same(plane[:, :2].T @ forces.sel(joint="four").values, here.multipliers, 1e-7, f"force at {here.t}")
        for link in links:
            force = tree.load(here, link)[0]
            same(plane[:, :2].T @ forces.sel(joint=link.joint.name).values, plane[:, :2].T @ force, 1e-7, "force")
