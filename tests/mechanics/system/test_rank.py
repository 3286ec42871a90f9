"""Rank, degrees of freedom, reactions that are not unique, and constraints that contradict each other."""

from dataclasses import replace

import numpy as np
import pytest

from lienumba.groups import so3
from lienumba.mechanics.mechanism.model import Coordinate, Driver, JointStart, Pose, Start
from lienumba.mechanics.start import assembly
from lienumba.mechanics.system.rank import contradiction, nominal, rank_of, ranks
from tests.facade import GROUND, Joint, Model
from tests.rigs.linkages import GRAVITY, bennett, closed_chain, door, planar_four_bar, unit_body

Z = (0.0, 0.0, 1.0)
ZERO = (0.0, 0.0, 0.0)


def assembled(model, start):
    done = assembly.assemble(model, start, 1)
    assert done.good.all(), (done.position_violations, done.velocity_violations)
    return nominal(done.model), done.instant(0)


def driven(linkage, *drivers):
    model, start = linkage
    return replace(model, drivers=drivers), start


def turn(name, joint, law):
    ends = (GROUND, 0) if joint == "j0" else (2, GROUND)
    return Driver(name, "value", ends, (law,), Coordinate(int(joint[1:]), "angle"))


def parallelogram():
    return closed_chain([(0, 0, 0), (0.3, 0.8, 0), (1.3, 0.8, 0), (1, 0, 0)], [Z] * 4)


@pytest.mark.parametrize(
    ("linkage", "rows", "rank", "redundant"),
    [
        (door(), 10, 5, {"high": 5}),
        (planar_four_bar(), 20, 17, {"j3": 3}),
        (bennett(), 20, 17, {"j3": 3}),
    ],
)
def test_redundant_loops_keep_their_freedom(linkage, rows, rank, redundant):
    model, now = assembled(*linkage)
    found = rank_of(model, now)
    assert (found.rows, found.rank, found.freedom, found.redundant) == (rows, rank, 1, redundant)
    assert found.shared == tuple(joint.name for joint in model.joints)
    assert found.exchangeable == tuple(range(rows))
    assert contradiction(model, now) == ()


def test_only_what_takes_part_in_a_dependence_may_be_exchanged():
    """A door on two hinges, and a pendulum on the door."""
    model, start = door()
    pendulum = Joint("pivot", "spherical", (0, 1), ((0.3, 0.0, 0.0), (0.0, 0.0, 0.5)))
    model = replace(model, bodies=(*model.bodies, unit_body("pendulum")), joints=(pendulum, *model.joints))
    start = Start((*start.poses, Pose(rotation=so3.IDENTITY)), (JointStart(), *start.joints))
    found = rank_of(*assembled(model, start))
    assert (found.rank, found.freedom, found.shared) == (8, 4, ("low", "high"))
    assert found.exchangeable == tuple(range(3, 13))


@pytest.mark.parametrize("varied", ["mass", "place", "hinge"])
def test_many_runs_have_the_ranks_that_each_has_alone(varied):
    """A mass does not change them, nor where the door is; a second hinge that is askew locks it."""
    (body,) = door()[0].bodies
    done = assembly.assemble(*door(), 1)
    state, numbers, askew = np.tile(done.state, (3, 1, 1)), np.array([1.0, 2.0, 1.0]), np.array([0.0, 0.0, 0.3])
    frame = tuple(tuple(x * np.ones(3) for x in axis) for axis in done.model.joints[1].frames[1])
    joints = done.model.joints
    if varied == "place":
        state[:, 0, 0] += [0.0, 0.1, 0.2]
    if varied == "hinge":
        x, y, z = (np.array(axis) for axis in frame)
        frame = (tuple(x), tuple(np.cos(askew) * y + np.sin(askew) * z), tuple(np.cos(askew) * z - np.sin(askew) * y))
        joints = (joints[0], replace(joints[1], frames=(joints[1].frames[0], frame)))
    mass = numbers if varied == "mass" else body.mass
    model = replace(done.model, bodies=(replace(body, mass=mass),), joints=joints)
    each = [rank_of(nominal(model, run), done._replace(state=state[run : run + 1]).instant(0)).rank for run in range(3)]
    now = replace(done.instant(0), bodies=tuple(tuple(b.T) for b in state.transpose(1, 0, 2)))
    assert ranks(model, now, 3).tolist() == each == ([5, 5, 6] if varied == "hinge" else [5, 5, 5])


def test_independent_rows_have_unique_reactions_whatever_the_masses():
    bodies = tuple(replace(unit_body(f"b{i}"), mass=10.0 ** (4 - 2 * i)) for i in range(4))
    joints = tuple(Joint(f"j{i}", "spherical", (i - 1, i), ((0.5, 0, 0), (-0.5, 0, 0))) for i in range(4))
    start = Start(tuple(Pose(rotation=so3.exp((0.1 * i, 0.2, 0.0))) for i in range(4)), (JointStart(),) * 4)
    found = rank_of(*assembled(Model(GRAVITY, bodies, joints), start))
    assert (found.rank, found.freedom, found.redundant, found.shared) == (12, 12, {}, ())


def test_a_mechanism_without_constraints():
    found = rank_of(*assembled(Model(GRAVITY, (unit_body("b"),)), Start((Pose(),), ())))
    assert (found.rows, found.rank, found.freedom) == (0, 0, 6)


# ---------------------------------------------------------------- contradictions
def test_drivers_that_agree_are_only_redundant():
    drivers = (turn("a", "j0", lambda t: t * t), turn("b", "j3", lambda t: -t * t))
    model, now = assembled(*driven(parallelogram(), *drivers))
    found = rank_of(model, now)
    assert found.freedom == 0
    assert found.redundant["b"] == 1
    assert contradiction(model, now) == ()


def test_drivers_that_will_part_are_named():
    model, now = assembled(*driven(parallelogram(), turn("a", "j0", lambda t: t * t), turn("b", "j3", lambda t: t * t)))
    named = contradiction(model, now)
    assert {"a", "b"} <= set(named)


def test_drivers_that_part_later_are_named():
    """Position, speed and acceleration agree at the start; nothing later does."""
    model, now = assembled(
        *driven(parallelogram(), turn("a", "j0", lambda t: t * t * t), turn("b", "j3", lambda t: t * t * t))
    )
    assert {"a", "b"} <= set(contradiction(model, now))


def test_a_rate_that_a_locked_mechanism_cannot_have_is_a_violation():
    locked = Joint("lock", "spherical", (GROUND, 0), ((0.4, 0.5, 0.0), (0.0, 0.5, -1.0)))
    model, start = door()
    model = replace(model, joints=(*model.joints, locked))
    start = Start(start.poses, (*start.joints, JointStart()))
    assert rank_of(*assembled(model, start)).freedom == 0
    says = (replace(start.joints[0], known={"rate": 0.3}), *start.joints[1:])
    done = assembly.assemble(model, replace(start, joints=says), 1)
    assert not done.good.any()
    bad = [c.name for c in done.conditions if np.any((done.velocity_violations > done.velocity_limits)[0, c.rows])]
    assert bad
