"""Whatever is on: the accelerations are those of a dense system of the rows in use, in both kinds of coordinates."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from lienumba.mechanics.mechanism.kinematics import Mode
from lienumba.mechanics.mechanism.model import Contact
from lienumba.mechanics.system import constraints, dynamics, kkt
from lienumba.mechanics.system.switched import turning
from lienumba.mechanics.system.switched.border import DEPENDENT, PARADOX
from lienumba.mechanics.system.switches import FRICTION, is_ball
from lienumba.mechanics.tree import equations, locking, reactions
from lienumba.mechanics.tree.spanning import joints_of, ties_of
from lienumba.scenario.start import prepare
from tests.facade import GROUND, Body, Instant, Model, resolve
from tests.rigs import switching
from tests.rigs.random_trees import close

SEEDS = range(8)
FOUR_BAR = Path(__file__).parents[4] / "scenarios" / "four_bar.toml"


def cases(seed):
    return switching.somewhere(switching.mechanism(seed, friction=seed % 3 > 0, closing=seed % 2), seed)


def closing(model):
    return kkt.Structure.closing(model, joints_of(ties_of(model)))


@pytest.mark.parametrize("seed", SEEDS)
def test_accelerations_and_multipliers_of_the_rows_in_use(seed):
    case = cases(seed)
    a, mu = switching.exact(case)
    found = dynamics.accelerations(case.model, kkt.Structure.of(case.model), case.now, case.mask)
    close(found.x, a, 1e-9)
    close(found.mu, mu, 1e-9)


@pytest.mark.parametrize("seed", SEEDS)
def test_the_same_by_joints(seed):
    case = cases(seed)
    a, _ = switching.exact(case)
    found = equations.accelerations(case.posture, closing(case.model), case.mask)
    close(equations.body_accelerations(case.posture, found.links), a, 1e-9)


@pytest.mark.parametrize("seed", SEEDS)
def test_locks_of_a_tree_are_rates_that_stand_still(seed):
    """Whether rates wait in the elimination or not; their multipliers come from what bodies lack. All but balls, of
    which others may hold a part here."""
    case = cases(seed)
    model, tree, rows = case.model, case.posture.tree, constraints.rows_of(case.model)
    own = {lock.number for lock in locking.locked(model, tree)}
    assert len(own) == sum(not is_ball(lock) for lock in model.locks)
    locks = {row: case.mask[row] for n in own for row in range(rows[n].start, rows[n].stop)}
    mask = [0.0 if row in locks else m for row, m in enumerate(case.mask)]
    structure = kkt.Structure.closing(model, joints_of(ties_of(model)) | own)
    a, mu = switching.exact(case)
    for waiting in (0, 2, tree.freedoms):
        posture = replace(case.posture, locks=locks, waiting=waiting)
        found = equations.accelerations(posture, structure, mask)
        accelerations = equations.body_accelerations(posture, found.links)
        close(accelerations, a, 1e-9)
    close(reactions.multipliers(posture, accelerations, found.mu), mu, 1e-8)


def dense_border(case):
    """S, b and the response to impulses, by inverting the matrix of the permanent rows."""
    model = case.model
    M, C, _, xi = switching.parts(case)
    first, n = constraints.permanent_rows(model), len(M)
    resting = {key: mode._replace(on=0.0) if key[0] == FRICTION else mode for key, mode in case.now.modes.items()}
    Q = np.array(dynamics.loads(model, replace(case.now, modes=resting)), float)
    K = np.block([[M, C[:first].T], [C[:first], np.zeros((first, first))]])
    a = np.linalg.solve(K, np.concatenate([Q, xi[:first]]))[:n]
    response = np.linalg.solve(K, np.vstack([C[first:].T, np.zeros((first, len(C) - first))]))[:n]
    return C[first:] @ response, C[first:] @ a - xi[first:], response


@pytest.mark.parametrize("seed", SEEDS)
def test_what_is_left_of_all_switched_rows(seed):
    case = cases(seed)
    S, b, response = dense_border(case)
    resting = case.posture.resting()
    for found in (
        dynamics.border(case.model, kkt.Structure.of(case.model), resting.now, case.mask),
        equations.border(resting, closing(case.model), case.mask, None, None),
    ):
        close(np.array(found[0]), S, 1e-9)
        close(found[1], b, 1e-9)
    impulses = np.random.default_rng(seed).standard_normal(len(S))
    kicked = dynamics.kicked(case.model, kkt.Structure.of(case.model), case.now, case.mask, impulses)
    close(kicked.x, response @ impulses, 1e-9)
    along = equations.kicked(case.posture, closing(case.model), case.mask, impulses)
    velocities = equations.body_accelerations(
        replace(case.posture, model=replace(case.model, gravity=(0.0,) * 3)), along.links
    )
    still = np.array(velocities) - centrifugal(case)
    close(still, response @ impulses, 1e-9)


def centrifugal(case):
    """What `body_accelerations` adds for the turning of links."""
    n = len(case.posture.tree.links)
    weightless = replace(case.posture, model=replace(case.model, gravity=(0.0,) * 3))
    return np.array(equations.body_accelerations(weightless, [(0.0,) * 6] * n))


def rod(friction, turned=1.0, contacts=1):
    """A slender rod of 2 m on a floor, 60 degrees upright, leaning to the side to which its end slides, or away."""
    tilt = np.pi / 3.0
    body = Body("rod", 3.0, (1e-3, 1.0, 1.0, 0.0, 0.0, 0.0))
    c, s = float(np.cos(tilt)), float(np.sin(tilt))
    R = (c, 0.0, -s, 0.0, 1.0, 0.0, s, 0.0, c)  # its x axis points up along it
    low, still = (-1.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    tip = Contact("tip", "point_plane", (0, GROUND), (low, still), (0.0, 0.0, 1.0), static=friction, kinetic=friction)
    every = tuple(replace(tip, name=f"tip {n}") for n in range(contacts))
    model = Model((0.0, 0.0, -9.81), (body,), contacts=every)
    state = (c, 0.0, s, *R, turned, 0.0, 0.0, 0.0, 0.0, 0.0)
    modes = {("contact", contact.name): Mode(2.0, (turned, 0.0)) for contact in every}
    return model, Instant((state,), modes=modes)


def test_painleves_paradox_is_told():
    """1 + 3 cos a (cos a - mu sin a) < 0: a rod whose end is driven into the floor by its friction."""
    limit = (1.0 + 3.0 * 0.25) / (3.0 * 0.5 * 0.75**0.5)
    for friction, turned, nonsingular in ((0.99, -1.0, 1.0), (1.01, -1.0, PARADOX), (1.01, 1.0, 1.0)):
        model, now = rod(friction * limit, turned)
        assert dynamics.accelerations(model, kkt.Structure.of(model), now, [1.0, 0.0, 0.0]).nonsingular == nonsingular


def test_rows_that_say_the_same_are_told():
    model, now = rod(0.2, contacts=2)
    solution = dynamics.accelerations(model, kkt.Structure.of(model), now, [1.0, 0.0, 0.0, 1.0, 0.0, 0.0])
    assert solution.nonsingular == DEPENDENT


def test_rows_that_only_rounding_tells_from_others_are_zero():
    """In space, a planar linkage that closes by a hinge has two rows that say something: of five."""
    released = {"name": "let_go", "when": "t > 1", "action": "release", "joint": "rocker_bearing"}
    start = prepare.check_initial(resolve(FOUR_BAR, overrides={"events": [released]}))
    model, now = start.model, start.now
    structure = kkt.Structure.of(model)
    S = dynamics.border(model, structure, now, [1.0] * structure.rows)[0]
    triangle = np.zeros((5, 5))
    triangle[np.tril_indices(5)] = turning.triangle(S, turning.alone(model, now))
    assert [bool(x) for x in np.diag(triangle)] == [True, True, False, False, False]
    close(triangle[:2, :2], np.tril(np.array(S)[:2, :2]))
    assert not triangle[2:].any()
