"""Derivatives along all directions at once are those along one after the other, to the bit and in kind."""

import numpy as np
import pytest

from lienumba.mechanics.mechanism import kinematics
from lienumba.mechanics.system import constraints
from tests.facade import GROUND, Instant
from tests.rigs.random_mechanisms import TOPOLOGIES, mechanism


def blocks(model, now):
    """Of every constraint and body."""
    every = enumerate(constraints.constraints_of(model))
    return [constraints.block(c, n, now, i) for n, c in every for i in c.bodies if i != GROUND]


def spread(now, runs):
    """The same state in many runs, some bodies in arrays and some not."""
    bodies = (tuple(np.full(runs, x) * (1 + np.arange(runs)) for x in body) for body in now.bodies)
    return Instant(tuple(b if n % 3 else now.bodies[n] for n, b in enumerate(bodies)), now.t, now.angles)


@pytest.mark.parametrize("topology", TOPOLOGIES)
@pytest.mark.parametrize("runs", [None, 1, 3])
def test_together_or_one_after_the_other(topology, runs, monkeypatch):
    for seed in range(4):
        model, now = mechanism(topology, seed)
        state = now if runs is None else spread(now, runs)
        together = blocks(model, state)
        with monkeypatch.context() as patch:
            patch.setattr(kinematics, "go_together", lambda numbers: False)
            apart = blocks(model, state)
        for ours, theirs in zip(together, apart, strict=True):
            for row, other in zip(ours, theirs, strict=True):
                for x, y in zip(row, other, strict=True):
                    assert isinstance(x, float) == isinstance(y, float)
                    np.testing.assert_array_equal(np.broadcast_to(x, (runs or 1,)), np.broadcast_to(y, (runs or 1,)))
                    np.testing.assert_array_equal(np.signbit(x), np.signbit(y))
