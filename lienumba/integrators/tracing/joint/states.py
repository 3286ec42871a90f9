"""What the states of a tree's moves are at the start, beside the places and rates of these, which a kernel reads."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from lienumba.integrators.tracing.law_states import LawStates
from lienumba.mechanics.mechanism import kinematics
from lienumba.mechanics.mechanism.kinematics import Instant
from lienumba.mechanics.mechanism.model import Model
from lienumba.mechanics.tree.links import tree_of
from lienumba.mechanics.tree.motion import read_state
from lienumba.numerics.jets import lift
from lienumba.numerics.number import Number


def start(model: Model, law_states: LawStates, runs: int) -> np.ndarray:
    """(runs, rows) of the element at the start, nothing of the moves yet."""
    moves = [0.0] * tree_of(model).state
    return _rows([*moves, *law_states.together(law_states.initial(model))], runs)


def rate_changes(model: Model, now: Instant, accelerations: Sequence[Number]) -> list[Any]:
    """q'' of the tree where the bodies accelerate so (6 k)."""
    tree = tree_of(model)
    view = kinematics.moving(kinematics.still(now, tuple(range(len(now.bodies)))), accelerations)
    motions = [view[i] for i in range(len(now.bodies))]
    z = read_state(model, tree, [(*m.r, *m.R, *m.v, *m.w) for m in motions])
    found: list[Any] = []
    for link in tree.links:
        own = tuple(z[link.first_state : link.first_state + link.move.state])
        found += link.move.along(tuple(lift(x).a for x in own), tuple(lift(x).b for x in own[link.move.places :]))
    return found


def _rows(numbers: Sequence[Any], runs: int) -> np.ndarray:
    rows = np.empty((runs, len(numbers)))
    for n, x in enumerate(numbers):
        rows[:, n] = x
    return rows
