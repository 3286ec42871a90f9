"""What joints leave free, as moves: against the equations of these joints, which know nothing of them."""

from dataclasses import replace

import numpy as np
import pytest

from lienumba.mechanics.elements.joints import coordinate_kinds
from lienumba.mechanics.mechanism import kinematics
from lienumba.mechanics.mechanism.kinematics import still
from lienumba.mechanics.mechanism.model import Coordinate
from lienumba.mechanics.system import constraints
from lienumba.mechanics.tree import equations, motion
from lienumba.mechanics.tree.links import PINS, tree_of, with_ways
from lienumba.mechanics.tree.posture import Posture
from lienumba.numerics.jets import lift
from tests.facade import GROUND, JOINTS, Instant, Model
from tests.rigs import random_mechanisms as any_mechanism
from tests.rigs.mechanisms import body, dense, vector
from tests.rigs.random_trees import MOVING, close, exact, joint, posture, state, tree

every_kind = pytest.mark.parametrize("kind", MOVING)
both_ways = pytest.mark.parametrize("way", [1.0, -1.0])
both_sides = pytest.mark.parametrize("first", [True, False], ids=["parent first", "parent second"])


def pair(kind: str, way: float, first: bool, seed: int = 0) -> tuple[Model, Posture]:
    """A body that flies, and one on it."""
    rng = np.random.default_rng((seed, MOVING.index(kind), first))
    made = replace(joint(rng, "j", kind, (0, 1)), bodies=(0, 1) if first else (1, 0))
    made = replace(made, way=way if JOINTS[kind].sides and JOINTS[kind].moves != PINS else 1.0)
    model = Model((0.0, 0.0, -9.81), (body(rng, "a"), body(rng, "b")), (made,))
    return posture(model, state(rng, tree_of(model)), 0.3)


@every_kind
@both_ways
@both_sides
def test_where_the_moves_put_a_body_its_joint_holds(kind: str, way: float, first: bool) -> None:
    model, here = pair(kind, way, first)
    close(constraints.residual(model, here.now), np.zeros(len(JOINTS[kind].row_kinds)), 1e-14)
    close(constraints.rate_and_bias(model, here.now)[0], np.zeros(len(JOINTS[kind].row_kinds)), 1e-14)
    close(motion.read_state(model, here.tree, here.now.bodies), here.z, 1e-14)
    said = with_ways(replace(model, joints=(replace(model.joints[0], way=1.0),)), here.now.bodies)
    assert said.joints[0].way == model.joints[0].way


@every_kind
@both_ways
@both_sides
def test_freedoms_and_rows_are_all_motions(kind: str, way: float, first: bool) -> None:
    """S, as the velocity of the second body by unit rates, has the rank that C lacks, and C S = 0."""
    model, here = pair(kind, way, first)
    rows, freedoms = len(JOINTS[kind].row_kinds), sum(move.freedoms for move in JOINTS[kind].moves or ())
    assert rows + freedoms == 6
    C = dense(constraints.jacobian(model, here.now), (rows, 12))
    S = np.array([_velocities(here, rate) for rate in range(here.tree.freedoms)]).T
    assert S.shape == (12, 6 + freedoms)
    assert np.linalg.svd(S, compute_uv=False)[-1] > 1e-2
    close(C @ S, np.zeros((rows, 6 + freedoms)), 1e-14)


def _velocities(here: Posture, rate: int) -> np.ndarray:
    """v and w of all bodies (12) where one rate is 1 and the others are 0."""
    z = list(here.z)
    n = 0
    for link in here.tree.links:
        for i in range(link.move.freedoms):
            z[link.first_state + link.move.places + i] = float(n == rate)
            n += 1
    moved = Posture(here.model, here.tree, z)
    return np.array([x for b in moved.now.bodies for x in b[12:18]])


@every_kind
@both_ways
@both_sides
def test_the_state_moves_with_its_rates(kind: str, way: float, first: bool) -> None:
    """Bodies moved by their velocities have the state moved by its own slope: u' = (rates, changes)."""
    model, here = pair(kind, way, first)
    jets = kinematics.moving(still(here.now, (0, 1)))
    moving = [(*jets[i].r, *jets[i].R, *jets[i].v, *jets[i].w) for i in (0, 1)]
    z = motion.read_state(model, here.tree, moving)
    h = 1e-5
    for link in here.tree.links:
        own = motion.state_of(link, tuple(here.z))
        u = link.move.slope((0.0,) * (2 * link.move.freedoms), own, (0.0,) * link.move.freedoms, None)
        ahead, behind = (np.array(link.move.moved(own, tuple(s * h * x for x in u), link.pitch)) for s in (1.0, -1.0))
        places = slice(link.first_state, link.first_state + link.move.places)
        rate = (ahead - behind)[: link.move.places] / (2.0 * h)
        close([lift(x).b for x in z[places]], rate, 1e-9)


@every_kind
def test_a_step_in_two_parts_is_one_step(kind: str) -> None:
    """moved, composed and pulled of every move: exponential coordinates of one group."""
    _, here = pair(kind, 1.0, True)
    rng = np.random.default_rng(1)
    for link in here.tree.links:
        move, z = link.move, motion.state_of(link, tuple(here.z))
        u, w = (vector(rng, 0.2) * 4 for _ in range(2))
        u, w = u[: 2 * move.freedoms], w[: 2 * move.freedoms]
        there = move.moved(move.moved(z, u, link.pitch), w, link.pitch)
        close(move.moved(z, move.composed(u, w), link.pitch), there, 1e-14)
        close(move.settled(there), there, 1e-14)
        small = tuple(1e-6 * x for x in w)
        change = (np.array(move.composed(u, small)) - np.array(move.composed(u, tuple(-x for x in small)))) / 2e-6
        close(move.pulled(u, w, None), change, 1e-8)


@pytest.mark.parametrize("kind", [kind for kind in MOVING if coordinate_kinds(kind)])
@both_ways
@both_sides
def test_a_gain_is_how_the_coordinate_grows(kind: str, way: float, first: bool) -> None:
    """Of the second body against the first, whichever is the parent."""
    model, here = pair(kind, way, first)
    for name in coordinate_kinds(kind):
        jets = kinematics.moving(still(here.now, (0, 1)))
        rate = lift(any_mechanism.joints.coordinate(model, Coordinate(0, name), jets)).b
        gains = [(link.move.gain(name, link.pitch), link) for link in here.tree.links if link.joint == 0]
        ((gain, link),) = [(gain, link) for gain, link in gains if gain is not None]
        own = motion.state_of(link, tuple(here.z))[link.move.places]
        assert rate == pytest.approx(gain * own if first else -gain * own, rel=1e-12)


@pytest.mark.parametrize("seed", range(6))
def test_a_tree_is_read_as_it_is_put(seed: int) -> None:
    rng = np.random.default_rng(seed)
    model = tree(seed, forces=False)
    model, here = posture(model, state(rng, tree_of(model)))
    close(motion.read_state(model, here.tree, here.now.bodies), here.z, 1e-13)
    own = [r for j in here.tree.joints for r in range(*_rows(model, j))]
    close(np.array(constraints.residual(model, here.now), float)[own], np.zeros(len(own)), 1e-13)


def _rows(model: Model, j: int) -> tuple[int, int]:
    rows = constraints.rows_of(model)[j]
    return rows.start, rows.stop


def test_axes_that_nearly_meet_need_no_direction() -> None:
    """Joints in a line, along one axis, against it, across it, and off by rounding: frames of links stay finite."""
    for z in ((0.0, 0.0, 1.0), (0.0, 0.0, -1.0), (1.0, 0.0, 0.0), (1e-17, 0.0, 1.0), (1e-9, 0.0, 1.0)):
        length = float(np.linalg.norm(z))
        z = tuple(x / length for x in z)
        y = (0.0, 1.0, 0.0)
        x = tuple(np.cross(y, z).tolist())
        rng = np.random.default_rng(0)
        upright = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
        ends = [(GROUND, 0), (0, 1), (1, 2)]
        frames = [(upright, upright), ((x, y, z), upright), (upright, upright)]
        joints = []
        for n, (end, frame) in enumerate(zip(ends, frames, strict=True)):
            joints.append(replace(joint(rng, f"j{n}", "revolute", end), bodies=end, frames=frame, way=1.0))
        model = Model((0.1, 0.2, -9.81), tuple(body(rng, f"b{n}") for n in range(3)), tuple(joints))
        model, here = posture(model, state(rng, tree_of(model)))
        close(constraints.residual(model, here.now), np.zeros(15), 1e-14)
        structure = equations.kkt.Structure.closing(model, here.tree.joints)
        found = equations.accelerations(here, structure, [1.0] * 15)
        a, _ = exact(model, Instant(here.now.bodies))
        close(equations.body_accelerations(here, found.links), a)
