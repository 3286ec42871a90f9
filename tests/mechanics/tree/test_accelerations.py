"""Accelerations and multipliers by the freedoms of joints: those of all equations at once, in absolute coordinates."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from lienumba.mechanics.system import constraints, kkt
from lienumba.mechanics.tree import equations, reactions
from lienumba.mechanics.tree.links import tree_of
from lienumba.mechanics.tree.posture import Posture
from tests.facade import JOINTS, Model
from tests.rigs.mechanisms import dense
from tests.rigs.random_trees import MOVING, close, exact, joint, posture, state, tree, without_mass

WAITING = (0, 1, 3, 99)
LOOSE = ["spherical", "universal", "planar", "cylindrical"]


def compare(model: Model, seed: int, bound: float = 2e-11) -> None:
    """At a state at random, for every number of rates that wait."""
    rng = np.random.default_rng(seed)
    made = tree_of(model)
    z = state(rng, made)
    model, here = posture(model, z, 0.7)
    a, mu = exact(model, here.now)
    structure = kkt.Structure.closing(model, made.joints)
    for waiting in WAITING:
        here = replace(here, waiting=waiting)
        found = equations.accelerations(here, structure, [1.0] * structure.rows)
        bodies = equations.body_accelerations(here, found.links)
        close(bodies, a, bound)
        close(reactions.multipliers(here, bodies, found.mu), mu, 10.0 * bound)


def independent(model: Model, seed: int) -> bool:
    """Whether the rows of C are, by far, at the state of this seed."""
    model, here = posture(model, state(np.random.default_rng(seed), tree_of(model)), 0.7)
    rows = constraints.rows_of(model)
    n, m = 6 * len(model.bodies), rows[-1].stop if rows else 0
    C = dense(constraints.jacobian(model, here.now), (m, n))
    C /= np.linalg.norm(C, axis=1)[:, None]
    return m < n and (m == 0 or bool(np.linalg.svd(C, compute_uv=False)[-1] > 1e-3))


def some(count: int, make: Any, first: int = 0) -> list[tuple[int, Model]]:
    """So many models whose rows are independent, by seed."""
    found: list[tuple[int, Model]] = []
    seed = first
    while len(found) < count:
        model = make(seed)
        if independent(model, seed):
            found.append((seed, model))
        seed += 1
    return found


@pytest.mark.parametrize("kind", MOVING)
def test_a_chain_of_one_kind(kind: str) -> None:
    """On the ground, and on a body that flies; forces, rotors, gravity that varies."""
    compare(tree(1, [kind] * 3), 1)
    compare(tree(2, [None, kind, kind]), 2)  # type: ignore[list-item]


@pytest.mark.parametrize("seed", range(12))
def test_a_tree_of_all_kinds(seed: int) -> None:
    compare(tree(seed), seed)


def test_loops_and_drivers() -> None:
    for seed, model in some(8, lambda seed: tree(seed, closing=seed % 3, drivers=(seed + 1) % 2), 100):
        compare(model, seed, 1e-10)


def closed_with_rotors(seed: int) -> Model:
    """Loops of several freedoms, closed by joints with rotors: not each can be in the tree."""
    rng = np.random.default_rng(seed)
    kinds: list[Any] = [str(x) for x in rng.choice(LOOSE, 6)]
    kinds[int(rng.integers(6))] = None
    model = tree(seed, kinds)
    for n in range(int(rng.integers(1, 3))):
        a, b = (int(i) for i in rng.choice(np.arange(-1, 6), 2, replace=False))
        made = joint(rng, f"c{n}", str(rng.choice([x for x in MOVING if JOINTS[x].rotor])), (a, b))
        model = replace(model, joints=(*model.joints, replace(made, armature=float(rng.uniform(0.1, 5.0)))))
    return model


def test_rotors_of_joints_that_close_loops() -> None:
    def left(seed: int) -> Model:
        model = closed_with_rotors(seed)
        tied = tree_of(model).joints
        has = any(x.armature and n not in tied for n, x in enumerate(model.joints))
        return model if has else left(seed + 1000)

    for seed, model in some(6, left):
        compare(model, seed, 2e-10)


@pytest.mark.parametrize("seed", range(6))
def test_bodies_of_no_mass_between_others(seed: int) -> None:
    """Behind each of them, by joints that leave one freedom in all or turn about axes apart, there is a mass."""
    rng = np.random.default_rng(seed)
    kinds = [str(rng.choice(["spherical", "revolute"]))]
    kinds += [str(x) for x in rng.permutation(["revolute", "prismatic", "screw", "fixed", "revolute", "revolute"])]
    model = tree(seed, kinds, forces=bool(seed % 2))
    ends = [replace(x, bodies=_after(x.bodies, i)) for i, x in _chained(model)]
    model = replace(model, joints=tuple(ends), forces=())
    compare(without_mass(model, {"b1", "b3", "b4"}), seed, 1e-9)


def _chained(model: Model) -> list[tuple[int, Any]]:
    """The joints by the body that they carry."""
    return [(int(x.name[1:]), x) for x in model.joints]


def _after(bodies: tuple[int, ...], i: int) -> tuple[int, ...]:
    """On the body before it, whichever comes first."""
    return (i - 1, i) if bodies[0] < bodies[1] else (i, i - 1)


def test_a_margin_is_that_of_the_same_row_among_all_bodies() -> None:
    """This mechanism happens to be near a singular position: one row that closes a loop hardly says anything."""
    ((_, model),) = some(1, lambda n: tree(n, closing=2), 100)
    made = tree_of(model)
    model, here = posture(model, state(np.random.default_rng(2), made), 0.3)
    structure, every = kkt.Structure.closing(model, made.joints), kkt.Structure.of(model)
    found = equations.velocity_correction(here, structure, [1.0] * structure.rows, model.bodies, True).margin
    M, C = equations.dynamics.mass_matrix(model, here.now), constraints.jacobian(model, here.now)
    whole = kkt.solve(every, M, C, [0.0] * 6 * len(model.bodies), [0.0] * every.rows)
    assert found < 1e-5
    np.testing.assert_allclose(found, whole.margin, rtol=1e-6)


@pytest.mark.parametrize("seed", [0, 1, 3])
def test_what_waits_changes_nothing_of_a_projection(seed: int) -> None:
    """The correction of velocities is the smallest that the joints leave, in the metric of mass."""
    ((_, model),) = some(1, lambda n: tree(n, closing=2), 50 * seed)
    rng = np.random.default_rng(seed)
    made = tree_of(model)
    model, here = posture(model, state(rng, made), 0.3)
    structure = kkt.Structure.closing(model, made.joints)
    n = made.freedoms
    J = np.array([_unit(here, rate) for rate in range(n)]).T
    M = dense(equations.dynamics.mass_matrix(model, here.now), (len(J), len(J)))
    M = M + np.tril(M, -1).T
    C = dense(constraints.jacobian(model, here.now), (structure.rows, len(J)))[list(structure.order)] @ J
    g = -np.array(constraints.rate_and_bias(model, here.now)[0], float)[list(structure.order)]
    K = np.block([[J.T @ M @ J, C.T], [C, np.zeros((len(C),) * 2)]])
    best = np.linalg.solve(K, np.concatenate([np.zeros(n), g]))[:n]
    for waiting in WAITING:
        at = replace(here, waiting=waiting)
        found = equations.velocity_correction(at, structure, [1.0] * structure.rows, model.bodies, True)
        close(found.rates, best, 1e-9)


def _unit(here: Posture, rate: int) -> np.ndarray:
    """v and w of all bodies where one rate is 1 and the others are 0."""
    z = list(here.z)
    for link in here.tree.links:
        for n in link.rates:
            z[link.first_state + link.move.places + n - link.first_rate] = float(n == rate)
    moved = Posture(here.model, here.tree, z)
    return np.array([x for b in moved.now.bodies for x in b[12:18]])
