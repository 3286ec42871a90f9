"""Every joint, twice in a chain: the motion and the reactions are those of minimal coordinates."""

from typing import Any

import numpy as np
import pytest

from tests.oracles.trees.dense import Motion, simulate
from tests.oracles.trees.kinematics import COORDINATES
from tests.oracles.trees.trees import TIMES, Link, Random, Tree, compare, reactions, run, scenario

SIZES = {"distance": 0.8, "screw": 0.9}
MEETING = {  # the coordinates that are 0 where both points are the same
    "spherical": (), "revolute": (), "universal": (), "cylindrical": (1,), "prismatic": (0,), "planar": (1, 2),
    "point_on_line": (0,), "point_in_plane": (0, 1), "parallel_axes": (), "perpendicular_axes": (), "screw": (0,),
}  # fmt: skip


def chain(kind: str, order: str) -> tuple[Tree, Random]:
    """Two bodies, one hung from the other; `order`: whether each joint names its base first.

    A fixed joint gets something to move with.
    """
    draw = Random(kind, order)
    size = SIZES.get(kind, 0.0)
    upper = ("ground", "a") if order[0] == "+" else ("a", "ground")
    lower = ("a", "b") if order[1] == "+" else ("b", "a")
    links = [
        Link("a", draw.body(), draw.joint("one", "spherical" if kind == "fixed" else kind, upper), "ground", size),
        Link("b", draw.body(), draw.joint("two", kind, lower), "a", -size if kind == "screw" else size),
    ]
    return Tree(links), draw


@pytest.mark.parametrize("kind", COORDINATES)
def test_a_chain_moves_as_in_minimal_coordinates(kind: str) -> None:
    tree, draw = chain(kind, "+-")
    q, qd = draw.start(tree)
    history = simulate(tree.mechanism, q, qd, TIMES)
    ds = run(scenario(tree, history[0]))
    compare(tree, ds, history)
    reactions(tree, ds, history)
    assert np.linalg.norm(history[-1].r - history[0].r) > 0.05


@pytest.mark.parametrize("kind", COORDINATES)
def test_joints_are_placed_in_the_global_frame_at_the_start(kind: str) -> None:
    """The other bodies first; at and axis instead of points and axes, where the joint can be said so."""
    tree, draw = chain(kind, "-+")
    q, qd = draw.start(tree)
    each = len(tree.links[0].free)
    q[[each * link + i for link in range(2) for i in MEETING.get(kind, ())]] = 0.0
    history = simulate(tree.mechanism, q, qd, TIMES)
    data = scenario(tree, history[0])
    if kind in MEETING:
        data["model"]["joints"] = [placed(tree, link, history[0]) for link in tree.links]
    ds = run(data)
    compare(tree, ds, history)
    reactions(tree, ds, history)


def placed(tree: Tree, link: Link, start: Motion) -> dict[str, Any]:
    """The joint in terms of the global frame, its angle counted from the start."""
    joint = link.joint
    poses = {"ground": (np.zeros(3), np.eye(3))}
    poses |= dict(zip(tree.names, zip(start.r, start.R, strict=True), strict=True))
    (r, R), (_, Q) = (poses[name] for name in joint.bodies)
    axes = [(R @ joint.axes[0]).tolist(), (Q @ joint.axes[1]).tolist()]
    table: dict[str, Any] = {"name": joint.name, "type": joint.type, "bodies": list(joint.bodies)}
    if joint.type not in ("parallel_axes", "perpendicular_axes"):
        table["at"] = (r + R @ joint.points[0]).tolist()
    if joint.type != "spherical":
        table["axis"] = axes if joint.type in ("universal", "perpendicular_axes") else axes[0]
    if joint.type == "screw":
        table["pitch"] = link.size
    return table
