"""Every joint, twice in a chain: the motion and the reactions are those of minimal coordinates."""

import numpy as np
import pytest

from .dense import simulate
from .kinematics import COORDINATES
from .trees import TIMES, Link, Random, Tree, compare, reactions, run, scenario

SIZES = {"distance": 0.8, "screw": 0.9}


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


@pytest.mark.parametrize("order", ["+-", "-+"])
@pytest.mark.parametrize("kind", COORDINATES)
def test_a_chain_moves_as_in_minimal_coordinates(kind: str, order: str) -> None:
    tree, draw = chain(kind, order)
    q, qd = draw.start(tree)
    history = simulate(tree.mechanism, q, qd, TIMES)
    ds = run(scenario(tree, history[0]))
    compare(tree, ds, history)
    reactions(tree, ds, history)
    assert np.linalg.norm(history[-1].r - history[0].r) > 0.05
