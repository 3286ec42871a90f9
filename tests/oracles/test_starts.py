"""Starts that only the joints' coordinates, or drivers, decide: bodies without poses move as in minimal coordinates."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from .dense import simulate
from .test_joints import chain
from .test_prescribed import NUDGE, SWAY, hung
from .trees import Random, Tree, compare, reactions, run, scenario

SOON = (0.0, 0.02)  # s
EVERYTHING = ("position", "rotation", "velocity", "angular_velocity")
SAYS = {
    "revolute": ("angle", "rate"),
    "prismatic": ("displacement", "speed"),
    "cylindrical": ("angle", "rate", "displacement", "speed"),
    "screw": ("angle", "rate", "displacement"),
}


@pytest.mark.parametrize("order", ["+-", "-+"])
@pytest.mark.parametrize("kind", SAYS)
def test_coordinates_of_the_joints_are_enough(kind: str, order: str) -> None:
    tree, draw = chain(kind, order)
    q, qd = draw.start(tree)
    each = len(tree.links[0].free)
    links = []
    for i, link in enumerate(tree.links):
        c, rate = q[each * i], qd[each * i]
        known = {"angle": c, "rate": rate, "displacement": q[each * i + each - 1], "speed": qd[each * i + each - 1]}
        if kind == "screw":
            known["displacement"] = c * link.size / (2 * np.pi)
        assert link.joint is not None
        says: dict[str, Any] = {key: float(known[key]) for key in SAYS[kind]}
        links.append(replace(link, joint=replace(link.joint, says=says)))
    history = simulate(tree.mechanism, q, qd, SOON)
    compare(tree, run(scenario(Tree(links), history[0], EVERYTHING, end=SOON[-1])), history)


@pytest.mark.parametrize("kind", ["spherical", "revolute", "universal", "fixed"])
def test_positions_and_velocities_follow_from_the_turning(kind: str) -> None:
    tree, draw = chain(kind, "+-")
    q, qd = draw.start(tree)
    history = simulate(tree.mechanism, q, qd, SOON)
    compare(tree, run(scenario(tree, history[0], ("position", "velocity"), end=SOON[-1])), history)


@pytest.mark.parametrize("order", "+-")
def test_drivers_decide_where_a_body_starts(order: str) -> None:
    texts = {"angle": SWAY[0], "displacement": NUDGE[0]}
    drivers = [{"joint": "shaft", "coordinate": c, "value": text} for c, text in texts.items()]
    tree = hung("cylindrical", order, {0: SWAY[1], 1: NUDGE[1]}, drivers=drivers, closing={"speed": 20.0})
    q, qd = Random("decided", order).start(tree)
    history = simulate(tree.mechanism, q, qd, SOON)
    data = scenario(tree, history[0], end=SOON[-1])
    for key in EVERYTHING:
        del data["model"]["bodies"][1][key]
    compare(tree, run(data), history)


MEETING = {  # the coordinates that are 0 where both points are the same
    "spherical": (), "revolute": (), "universal": (), "cylindrical": (1,), "prismatic": (0,), "planar": (1, 2),
    "point_on_line": (0,), "point_in_plane": (0, 1), "parallel_axes": (), "perpendicular_axes": (), "screw": (0,),
}  # fmt: skip


@pytest.mark.parametrize("kind", MEETING)
def test_joints_are_placed_in_the_global_frame(kind: str) -> None:
    """at and axis instead of points and axes; angles count from the start."""
    tree, draw = chain(kind, "+-")
    q, qd = draw.start(tree)
    each = len(tree.links[0].free)
    q[[each * link + i for link in range(2) for i in MEETING[kind]]] = 0.0
    history = simulate(tree.mechanism, q, qd, SOON)
    start = history[0]
    data = scenario(tree, start, end=SOON[-1])
    poses = {"ground": (np.zeros(3), np.eye(3))} | dict(zip("ab", zip(start.r, start.R, strict=True), strict=True))
    for link, joint in zip(tree.links, data["model"]["joints"], strict=True):
        assert link.joint is not None
        ends = [poses[name] for name in link.joint.bodies]
        axes = [(R @ z).tolist() for (_, R), z in zip(ends, link.joint.axes, strict=True)]
        if "axes" in joint:
            joint["axis"] = axes if kind in ("universal", "perpendicular_axes") else axes[0]
        if "points" in joint:
            joint["at"] = (ends[0][0] + ends[0][1] @ link.joint.points[0]).tolist()
        for key in ("points", "axes", "references"):
            joint.pop(key, None)
    ds = run(data)
    compare(tree, ds, history)
    reactions(tree, ds, history)
