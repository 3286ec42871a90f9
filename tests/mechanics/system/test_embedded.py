"""The paper's projection in the R^12 of every body: its steps, its limit, and how near the local one comes to it."""

from typing import Any

import numpy as np
import pytest

from lienumba.groups import so3
from lienumba.mechanics.system import constraints, embedded, kkt, projection
from tests.facade import Instant
from tests.oracles.reference.nearest import nearest
from tests.rigs.mechanisms import TOPOLOGIES, arrays, model, state
from tests.rigs.random_mechanisms import TOPOLOGIES as RANDOM
from tests.rigs.random_mechanisms import mechanism

STENCIL = {1: 4 / 5, 2: -1 / 5, 3: 4 / 105, 4: -1 / 280}  # the first derivative to eighth order
LOWER = np.tril_indices(3)
ITERATIONS = 30


def elements(bodies: Any) -> np.ndarray:
    """r and R of every body: 12 k numbers."""
    return np.array([x[0:12] for x in bodies], float).ravel()


def with_elements(bodies: Any, y: np.ndarray) -> Any:
    return tuple((*new.tolist(), *x[12:18]) for x, new in zip(bodies, y.reshape(-1, 12), strict=True))


def orthogonality(y: np.ndarray) -> np.ndarray:
    """The six elements of R R^T - I of every body."""
    return np.concatenate([(R @ R.T - np.eye(3))[LOWER] for R in y.reshape(-1, 12)[:, 3:].reshape(-1, 3, 3)])


def slopes(function: Any, y: np.ndarray, h: float = 4e-3) -> np.ndarray:
    """Its Jacobian, every number moved by itself."""
    columns = []
    for e in np.eye(len(y)):
        columns.append(sum(c * (function(y + s * h * e) - function(y - s * h * e)) for s, c in STENCIL.items()) / h)
    return np.array(columns).T


def literal_step(m: Any, now: Instant, hat: Any, rows: np.ndarray) -> np.ndarray:
    """Where the KKT system of 12 k + 6 k + m unknowns leads, all of it written down and solved densely."""

    def g(y: np.ndarray) -> np.ndarray:
        phi = constraints.residual(m, Instant(with_elements(now.bodies, y), now.t, now.angles))
        return np.concatenate([np.array(phi, float)[rows], orthogonality(y)])

    y = elements(now.bodies)
    G = slopes(g, y)
    K = np.block([[np.eye(len(y)), G.T], [G, np.zeros((len(G), len(G)))]])
    return np.linalg.solve(K, np.concatenate([elements(hat), G @ y - g(y)]))[: len(y)]


@pytest.mark.parametrize("topology", RANDOM)
def test_a_step_is_that_of_the_literal_system_off_the_rotations_too(topology: str) -> None:
    """Any joints and drivers, any state, and matrices that are no rotations."""
    tried = 0
    for seed in range(20):
        m, hat = mechanism(topology, seed)
        if len(hat.bodies) > 4:
            continue
        rng = np.random.default_rng(seed)
        y = elements(hat.bodies)
        now = Instant(with_elements(hat.bodies, y + 0.03 * rng.standard_normal(len(y))), hat.t, hat.angles)
        structure = kkt.Structure.of(m)
        mask = [1.0] * structure.rows
        solution = embedded.correction(m, structure, now, hat.bodies, mask)
        if min(solution.row_weights) < 1.0 or not solution.nonsingular:
            continue
        rows = np.flatnonzero(projection.position_mask(m, mask))
        expected = literal_step(m, now, hat.bodies, rows)
        found = elements(embedded.placed(now.bodies, solution.x))
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-8 * np.abs(expected).max())
        tried += 1
    assert tried >= 3


def test_the_determinant_stays_positive() -> None:
    """Three steps on, however far each turns: no iteration ends at a reflection."""
    rng = np.random.default_rng(1)
    for size in 0.1, 1.0, 10.0:
        for _ in range(50):
            bodies: Any = ((0.0,) * 3 + so3.exp(tuple(rng.standard_normal(3).tolist())) + (0.0,) * 6,)
            for _ in range(3):
                bodies = embedded.placed(bodies, [0.0] * 3 + (size * rng.standard_normal(3)).tolist())
                assert np.linalg.det(np.reshape(bodies[0][3:12], (3, 3))) > 0.0


# ---------------------------------------------------------------- both forms, to their limits
FULL_RANK = ["top", "rod between", "chain", "star on the ground", "ring on the ground", "ladder", "two rings"]


def local(m: Any, hat: Any) -> Any:
    structure, x, now = kkt.Structure.of(m), [0.0] * (6 * len(hat)), hat
    for _ in range(ITERATIONS):
        x = projection.position_correction(m, structure, Instant(now), x, [1.0] * structure.rows).x
        now = projection.placed(hat, x)
    return now


def literal(m: Any, hat: Any) -> Any:
    structure, now = kkt.Structure.of(m), hat
    for _ in range(ITERATIONS):
        x = embedded.correction(m, structure, Instant(now), hat, [1.0] * structure.rows).x
        now = embedded.placed(now, x)
    return now


def on_the_joints(topology: str, seed: int = 3) -> tuple[Any, Any]:
    """A mechanism and a state on its joints: from anywhere, by steps that are not too long."""
    k, ends = TOPOLOGIES[topology]
    m, now = model(k, ends, seed), state(k, seed)
    structure = kkt.Structure.of(m)
    for _ in range(40):
        x = projection.position_correction(m, structure, Instant(now), [0.0] * (6 * k), [1.0] * structure.rows).x
        longest = max(1.0, 2.0 * max(map(abs, x)))
        now = projection.placed(now, [c / longest for c in x])
    assert max(map(abs, constraints.residual(m, Instant(now)))) < 1e-14
    return m, now


def disturbed(now: Any, size: float) -> Any:
    """Off the joints in a direction of no meaning, rotations staying rotations."""
    x = np.random.default_rng(5).standard_normal(6 * len(now))
    return projection.placed(now, (size / np.abs(x).max() * x).tolist())


@pytest.mark.parametrize("topology", FULL_RANK)
def test_the_minimisers_of_both_forms_differ_by_the_third_power_of_the_correction(topology: str) -> None:
    """|R - R^|_F^2 = 2 |x|^2 + O(|x|^4)."""
    m, now = on_the_joints(topology)
    sizes = 10.0 ** np.array([-1.0, -2.0, -3.0])
    apart = []
    for size in sizes:
        hat = disturbed(now, size)
        apart.append(np.linalg.norm(elements(local(m, hat)) - elements(literal(m, hat))))
    assert np.polyfit(np.log10(sizes), np.log10(apart), 1)[0] == pytest.approx(3.0, abs=0.2), apart
    assert apart[-1] > 1e-12  # more than rounding


@pytest.mark.parametrize("topology", ["top", "rod between", "ring on the ground", "two rings"])
def test_it_is_the_minimum_that_a_general_solver_finds(topology: str) -> None:
    m, now = on_the_joints(topology)
    hat = disturbed(now, 0.05)
    r, R, _, _ = arrays(hat)
    best = np.concatenate([part.reshape(len(r), -1) for part in nearest(m.joints, r, R)], axis=1)
    there = literal(m, hat)
    np.testing.assert_allclose(elements(there).reshape(best.shape), best, rtol=0, atol=2e-14)
    assert np.abs(orthogonality(elements(there))).max() < 1e-15
    assert np.abs(elements(local(m, hat)).reshape(best.shape) - best).max() > 1e-7
