"""The sparse elimination solves what a dense solver solves, in every order that its rule calls safe."""

import random
from dataclasses import replace

import numpy as np
import pytest

from lienumba.compiler.emit import Kernel
from lienumba.compiler.rows import W
from lienumba.compiler.symbols import Graph
from lienumba.groups import so3
from lienumba.mechanics.system import constraints, dynamics, elimination_order, kkt, rotors
from lienumba.mechanics.tolerances import SINGULAR_PIVOT
from tests.compiler.evaluation import call
from tests.facade import GROUND, JOINTS, Body, Instant, Joint, Model
from tests.oracles.reference import naive
from tests.rigs import random_mechanisms
from tests.rigs.mechanisms import (
    GRAVITY,
    TOPOLOGIES,
    D,
    S,
    chain,
    dense,
    model,
    random_network,
    ring,
    rows,
    star,
    state,
)


def couplings(m):
    return [(*rotor.bodies, rotor.constant) for rotor in rotors.rotors_of(m) if len(rotor.bodies) == 2]


def blocks(m):
    return [(joint.bodies, len(JOINTS[joint.type].kinds(joint))) for joint in m.joints]


def structure(m, block_order):
    k = len(m.bodies)
    sizes = [n for _, n in blocks(m)]
    variables = []
    for b in block_order:
        first, size = (6 * b, 6) if b < k else (6 * k + sum(sizes[: b - k]), sizes[b - k])
        variables += range(first, first + size)
    return kkt.Structure(k, sum(sizes), tuple(variables), coupled=tuple(variables))


def random_safe_order(k, joints, seed, couplings=()):
    """Any order that the rule admits, not only the cheap ones that the greedy search finds."""
    walk, choice = elimination_order._Elimination(k, joints, couplings), random.Random(seed)
    while walk.left:
        node, group = choice.choice([(n, g) for n in sorted(walk.left) if (g := walk.after(n)) is not None])
        walk.take(node, group)
    return walk.order


def check(m, x, block_order, seed=0):
    """Solve with random right-hand sides and compare with numpy.linalg.solve of the dense matrix."""
    n, rng = 6 * len(m.bodies), np.random.default_rng(seed)
    A, C = dynamics.mass_matrix(m, Instant(x)), constraints.jacobian(m, Instant(x))
    f, g = rng.standard_normal(n).tolist(), rng.standard_normal(rows(m)).tolist()
    got = kkt.solve(structure(m, block_order), A, C, f, g)
    M, D_ = naive.mass_matrix(m.bodies), dense(C, (rows(m), n))
    for rotor in rotors.rotors_of(m):
        c = np.zeros(n)
        c[list(rotor.row(Instant(x)))] = list(rotor.row(Instant(x)).values())
        M += rotor.inertia * np.outer(c, c)
    expected = np.concatenate(naive.solve_kkt(M, D_, np.array(f), np.array(g)))
    condition = np.linalg.cond(D_) ** 2 * np.linalg.cond(M) if len(D_) else 1.0
    error = np.abs(np.array([*got.x, *got.mu]) - expected).max() / np.abs(expected).max()
    assert error < 1e-15 * max(condition, 100.0), f"off by {error:.1e} in the order {block_order}"
    assert got.nonsingular > 0.0


def full_rank(m, x):
    C = dense(constraints.jacobian(m, Instant(x)), (rows(m), 6 * len(m.bodies)))
    return len(C) == 0 or np.linalg.svd(C, compute_uv=False)[min(C.shape) - 1] > 1e-2 * (len(C) <= C.shape[1])


# ---------------------------------------------------------------- solutions
@pytest.mark.parametrize("name", TOPOLOGIES)
@pytest.mark.parametrize("seed", range(3))
def test_the_cheapest_order_solves_every_topology(name, seed):
    k, ends = TOPOLOGIES[name]
    m, x = model(k, ends, seed), state(k, seed)
    check(m, x, elimination_order.elimination_order(k, blocks(m)), seed)


@pytest.mark.parametrize("name", TOPOLOGIES)
def test_every_safe_order_solves_every_topology(name):
    k, ends = TOPOLOGIES[name]
    m, x = model(k, ends, 1), state(k, 1)
    for seed in range(12):
        check(m, x, random_safe_order(k, blocks(m), seed))


def test_random_networks_in_the_cheapest_and_in_random_safe_orders():
    tried = 0
    for seed in range(60):
        k, ends = random_network(seed)
        m, x = model(k, ends, seed), state(k, seed)
        if rows(m) > 6 * k or not full_rank(m, x):
            continue
        tried += 1
        check(m, x, elimination_order.elimination_order(k, blocks(m)))
        for again in range(3):
            check(m, x, random_safe_order(k, blocks(m), 100 * seed + again))
    assert tried > 30


@pytest.mark.parametrize("topology", random_mechanisms.TOPOLOGIES)
def test_every_safe_order_solves_mechanisms_whose_bodies_are_coupled_by_rotors(topology):
    tried = 0
    for seed in range(24):
        m, now = random_mechanisms.mechanism(topology, seed)
        m = replace(m, joints=tuple(j for j in m.joints if j.coordinates is None), drivers=(), forces=())
        x = now.bodies
        if not couplings(m) or rows(m) > 6 * len(x) or not full_rank(m, x):
            continue
        tried += 1
        check(m, x, elimination_order.elimination_order(len(x), blocks(m), couplings(m)), seed)
        for again in range(4):
            check(m, x, random_safe_order(len(x), blocks(m), again, couplings(m)), seed)
    assert tried > 2


def test_a_chain_with_rotors_costs_as_much_per_link_when_it_is_longer():
    def entries(k):
        ends = [(S, i - 1, i) for i in range(k)]
        m = model(k, ends, 3)
        R = Joint("r", "revolute", (0, 1), frames=(((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),) * 2)
        m = replace(m, joints=tuple(replace(R, bodies=j.bodies, points=j.points, armature=0.1) for j in m.joints))
        now = Instant(state(k, 3))
        A, C = dynamics.mass_matrix(m, now), constraints.jacobian(m, now)
        s = kkt.Structure.of(m)
        return len(kkt.Eliminated.of(s, A, C, [1.0] * s.rows).numbers())

    each = [(entries(2 * k) - entries(k)) / k for k in (8, 16)]
    assert each[1] < 1.1 * each[0]


def test_the_accelerations_are_those_of_the_naive_twin():
    for name in ("chain", "star on the ground", "hexapod", "ladder"):
        k, ends = TOPOLOGIES[name]
        m, x = model(k, ends, 2), state(k, 2)
        y = np.array(x)
        r, R, v, w = y[:, :3], y[:, 3:12].reshape(-1, 3, 3), y[:, 12:15], y[:, 15:]
        a, mu = naive.accelerations(m.bodies, m.joints, m.gravity, r, R, v, w)
        solution = dynamics.accelerations(m, kkt.Structure.of(m), Instant(x))
        scale = max(np.abs(a).max(), np.abs(mu).max())
        np.testing.assert_allclose(solution.x, a.ravel(), atol=1e-10 * scale)
        np.testing.assert_allclose(solution.mu, mu, atol=1e-10 * scale)


@pytest.mark.parametrize("name", ["chain", "hexapod", "ring on the ground"])
def test_compiled_solutions_are_those_on_floats(name):
    k, ends = TOPOLOGIES[name]
    m = model(k, ends, 3)
    graph = Graph()
    symbols = tuple(graph.inputs("state", 18, 18 * i) for i in range(k))
    solution = dynamics.accelerations(m, kkt.Structure.of(m), Instant(symbols))
    states = [state(k, 10 + lane) for lane in range(W)]
    given = np.array([[y for body in x for y in body] for x in states]).T
    out = call(Kernel("kkt", (*solution.x, *solution.mu, solution.nonsingular), 0), state=given)
    for lane, x in enumerate(states):
        plain = dynamics.accelerations(m, kkt.Structure.of(m), Instant(x))
        expected = np.array([*plain.x, *plain.mu])
        np.testing.assert_allclose(out[:-1, lane], expected, atol=1e-9 * np.abs(expected).max())
        assert out[-1, lane] > 0.0


# ---------------------------------------------------------------- orders
def test_an_order_holds_every_block_once():
    for seed in range(30):
        k, ends = random_network(seed)
        m = model(k, ends, seed)
        assert sorted(elimination_order.elimination_order(k, blocks(m))) == list(range(k + len(ends)))


def test_the_order_after_one_of_its_bodies_is_unsafe_in_a_loop():
    """A ring of two: bodies 0, 1; once body 0 is gone, neither joint may go before body 1."""
    walk = elimination_order._Elimination(2, [((0, 1), 3), ((1, 0), 1)])
    walk.take(0, walk.after(0))
    assert walk.after(2) is not None  # one joint alone hangs on a free body
    walk.take(2, walk.after(2))
    assert walk.after(3) is None
    tied = elimination_order._Elimination(2, [((GROUND, 0), 3), ((0, 1), 3)])
    tied.take(0, tied.after(0))
    tied.take(2, tied.after(2))
    assert tied.after(3) is None  # body 0 cannot give way any more
    assert elimination_order._Elimination(1, [((0, GROUND), 3)]).after(1) is None


def multiplications(k, ends):
    m = model(k, ends)
    graph = Graph()
    symbols = tuple(graph.inputs("state", 18, 18 * i) for i in range(k))
    solution = dynamics.accelerations(m, kkt.Structure.of(m), Instant(symbols))
    return Kernel("k", (*solution.x,), 0).counts()["operations"]


def test_trees_cost_as_much_per_body_however_large_they_are():
    for make in (chain, star):
        assert multiplications(24, make(24)) < 2.2 * multiplications(12, make(12))


# ---------------------------------------------------------------- the margin
def margin(m, x):
    """As the engine has it: compiled, where a pivot of exactly zero gives an infinity."""
    graph = Graph()
    symbols = tuple(graph.inputs("state", 18, 18 * i) for i in range(len(x)))
    solution = dynamics.accelerations(m, kkt.Structure.of(m), Instant(symbols))
    given = np.repeat(np.array(x).reshape(-1, 1), W, axis=1)
    looped = kkt.Structure.of(m).looped
    value = call(Kernel("margin", (solution.margin if looped else solution.nonsingular,), 0), state=given)[0, 0]
    return value - SINGULAR_PIVOT if looped else value


def on_one_platform(*points):
    """Two bodies in the same place, held together by spherical joints at these points."""
    joints = tuple(Joint(f"j{i}", S, (0, 1), (p, p)) for i, p in enumerate(points))
    place = (0.0, 0.0, 0.0, *so3.exp((0.4, -1.2, 0.3)), *(0.0,) * 6)
    return Model(GRAVITY, model(2, []).bodies, joints), (place, place)


def test_redundant_joints_have_no_positive_margin():
    assert margin(*on_one_platform((0.1, 0.2, 0.3))) > 0.0
    assert not margin(*on_one_platform((0.1, 0.2, 0.3), (0.1, 0.2, 0.3))) > 0.0
    assert not margin(*on_one_platform((0.0, 0.0, 0.0), (1.0, 0.5, 0.0))) > 0.0  # a hinge: rank 5 of 6
    assert not margin(*on_one_platform((0.1, 0.0, 0.0), (1.0, 0.5, 0.0), (0.0, 0.3, 0.2))) > 0.0  # rank 6 of 9


def test_redundant_loops_have_no_positive_margin():
    """More rods than freedoms; a ring with one joint twice."""
    seven_rods = model(1, [(D, GROUND, 0)] * 7)
    assert not margin(seven_rods, state(1)) > 0.0
    doubled = model(4, ring(4))
    doubled = Model(doubled.gravity, doubled.bodies, (*doubled.joints, doubled.joints[2]))
    assert not margin(doubled, state(4)) > 0.0


@pytest.mark.parametrize("neighbour", ["two free bodies", "chain", "hexapod"])
def test_a_redundant_joint_is_seen_whatever_else_there_is(neighbour):
    """A pivot of exactly zero leaves NaN behind; parts that do not touch it, eliminated later, must not hide it."""
    p, ball = (0.5, 0.25, 0.0), (1.0, 1.0, 1.0, 0.0, 0.0, 0.0)
    pair = (Body("a", 1.0, ball), Body("b", 1.0, ball))
    twice = tuple(Joint(f"j{i}", S, (0, 1), (p, p)) for i in range(2))
    k, ends = TOPOLOGIES[neighbour]
    other = model(k, ends, 3)
    beside = tuple(replace(j, bodies=tuple(b if b == GROUND else b + 2 for b in j.bodies)) for j in other.joints)
    place = (0.0, 0.0, 0.0, *so3.IDENTITY, *(0.0,) * 6)
    assert not margin(Model(GRAVITY, pair + other.bodies, twice + beside), (place, place, *state(k))) > 0.0


@pytest.mark.parametrize("lever", [1e-3, 1e-2, 1.0])
def test_the_margin_is_positive_while_rows_are_independent(lever):
    """A rod beside a spherical joint, which it holds on a short lever or a long one."""
    upright = ((0.0,) * 3 + (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0) + (0.0,) * 6,)
    pivot = Joint("pivot", S, (GROUND, 0), ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0)))
    rod = Joint("rod", D, (GROUND, 0), ((lever, 1.0, 0.0), (lever, 0.0, 0.0)), numbers={"length": 1.0})
    assert margin(Model(GRAVITY, model(1, []).bodies, (pivot, rod)), upright) > 0.0
