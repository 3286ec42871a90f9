"""Starts along the joints: exact where coordinates are given, in every run, and the same as by least changes."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from lienumba.groups import so3
from lienumba.mechanics.mechanism.model import Coordinate, Driver, JointStart, Pose, Start
from lienumba.mechanics.start import assembly, gauss_newton
from lienumba.mechanics.system import rank
from tests.compiler.evaluation import assert_same_bits
from tests.facade import GROUND, Joint, Model
from tests.mechanics.start.test_assembly import picked
from tests.mechanics.start.test_starts import HALF, TURN, ZERO, X, Y, Z, arm, assembled, rotation_z
from tests.rigs.joint_starts import joint_start, with_known
from tests.rigs.linkages import GRAVITY, unit_body

HERE = Pose(position=ZERO, rotation=so3.IDENTITY)
FLYING = Pose(position=(1.0, 2.0, 3.0), rotation=TURN, velocity=(0.3, -0.2, 1.0), angular_velocity=(0.5, 1.0, -0.7))
BEHIND = [
    ("revolute", {"angle": 2.8, "rate": -1.1}),
    ("prismatic", {"displacement": 0.4, "speed": 0.6}),
    ("cylindrical", {"angle": -0.9, "displacement": -0.2, "rate": 0.4, "speed": -0.3}),
    ("screw", {"angle": 1.3, "displacement": 0.1, "rate": 2.0}),
    ("fixed", {}),
]


def branch(
    turned: bool, says: tuple[tuple[str, dict[str, Any]], ...] = tuple(BEHIND)
) -> tuple[Model, list[JointStart]]:
    """Five bodies on one that flies, one behind the other; turned: joints name the body behind first."""
    joints, starts = [], []
    for i, (kind, given) in enumerate(says):
        ends = (i + 1, i) if turned else (i, i + 1)
        numbers = {"pitch": 0.3, "offset": None} if kind == "screw" else {}
        joints.append(Joint(f"j{i}", kind, ends, ((0.1, 0.2 * i, -0.3), (0.0, -0.2, 0.1 * i)), numbers=numbers))
        axes = ((0.3, -0.5, 0.8), (-1.0, 0.2 * i, 0.4))
        starts.append(joint_start(axes=axes, references=((1.0, 0.2, 0.0), (0.1, 0.0, 1.0)), **given))
    return Model(GRAVITY, tuple(unit_body(f"b{i}") for i in range(len(says) + 1)), tuple(joints)), starts


@pytest.fixture
def unsolved(monkeypatch: pytest.MonkeyPatch) -> None:
    """No equations are solved."""

    def refuse(*_: Any) -> None:
        raise AssertionError("a system of equations is solved")

    monkeypatch.setattr(gauss_newton, "Least", refuse)


@pytest.mark.parametrize("turned", [False, True])
def test_nothing_is_solved_where_joints_say_all(unsolved: None, turned: bool) -> None:
    m, says = branch(turned)
    done = assembled(m, [FLYING, *[Pose()] * 5], says)
    assert done.position_violations.max() < 1e-14
    assert done.velocity_violations.max() < 1e-14
    for j, (_, given) in enumerate(BEHIND):
        assert done.angles.get(j, [given.get("angle")])[0] == pytest.approx(given.get("angle"), abs=1e-14)


@pytest.mark.parametrize("turned", [False, True])
def test_it_is_where_least_changes_end(turned: bool) -> None:
    """From a guess nearby: there joints lead nowhere."""
    m, says = branch(turned)
    done = assembled(m, [FLYING, *[Pose()] * 5], says)
    near = []
    for body in done.state[0, 1:]:
        turn = so3.multiply(tuple(body[3:12].tolist()), so3.exp((0.05, -0.1, 0.08)))
        near.append(Pose(guess=Pose(position=tuple((body[:3] + 0.05).tolist()), rotation=turn)))
    np.testing.assert_allclose(assembled(m, [FLYING, *near], says).state, done.state, atol=1e-12)


@pytest.mark.parametrize("turned", [False, True])
def test_a_ball_joint_holds_its_points_together(unsolved: None, turned: bool) -> None:
    """Of a body whose rotation is given, or as it starts, and which carries others."""
    m, says = branch(turned, (BEHIND[0], ("spherical", {}), BEHIND[0], ("spherical", {})))
    says = [JointStart() if joint.type == "spherical" else x for joint, x in zip(m.joints, says, strict=True)]
    swung = Pose(rotation=TURN, angular_velocity=(1.0, -2.0, 0.5))
    tail = Pose(angular_velocity=(0.0, 0.3, 0.0))
    done = assembled(m, [FLYING, Pose(), swung, Pose(), tail], says)
    np.testing.assert_array_equal(done.state[0, 2, 3:12], TURN)
    np.testing.assert_array_equal(done.state[0, 4, 3:12], so3.IDENTITY)
    np.testing.assert_allclose(done.state[0, [2, 4], 15:], [[1.0, -2.0, 0.5], [0.0, 0.3, 0.0]], atol=1e-15)
    assert done.position_violations.max() < 1e-14
    assert done.velocity_violations.max() < 1e-14


def test_axes_that_point_against_each_other(unsolved: None) -> None:
    against = JointStart(axes=(Z, (0.0, 0.0, -2.0)), references=(X, X), known={"angle": 0.7, "rate": 1.5})
    m, _ = arm()
    done = assembled(m, [Pose()], [against])
    R = rotation_z(0.7) @ np.diag([1.0, -1.0, -1.0])
    r = -R @ HALF[1]
    np.testing.assert_allclose(done.state[0, 0], [*r, *R.ravel(), *np.cross((0, 0, 1.5), r), 0, 0, -1.5], atol=1e-15)


def test_many_links_need_no_references_along_equal_axes(unsolved: None) -> None:
    k, angle = 12, 0.5
    m, says = arm(k, angle=angle, rate=0.0)
    done = assembled(m, [Pose()] * k, says)
    turns = angle * np.arange(1, k + 1)
    ends = np.cumsum(np.exp(1j * turns))
    middle = ends - 0.5 * np.exp(1j * turns)
    np.testing.assert_allclose(done.state[0, :, 0] + 1j * done.state[0, :, 1], middle, atol=1e-14)
    np.testing.assert_allclose(done.state[0, :, 3] + 1j * done.state[0, :, 6], np.exp(1j * turns), atol=1e-14)


def test_drivers_say_what_joints_do_not(unsolved: None) -> None:
    """Their values and rates at t = 0; a joint may say the other half."""
    drivers = (
        Driver("turn", "value", (GROUND, 0), (lambda t: 0.4 + 2.0 * t,), Coordinate(0, "angle")),
        Driver("speed", "rate", (0, 1), (lambda t: 1.5 - t,), Coordinate(1, "angle")),
    )
    m, says = arm(2, drivers=drivers, references=(X, X))
    done = assembled(m, [Pose(), Pose()], [says[0], with_known(says[1], angle=0.3)])
    np.testing.assert_allclose(done.state[0, 1, 3:12].reshape(3, 3), rotation_z(0.7), atol=1e-15)
    np.testing.assert_allclose(done.state[0, :, 15:], [[0, 0, 2.0], [0, 0, 3.5]], atol=1e-15)
    assert done.position_violations.max() < 1e-15


def test_what_is_relative_to_a_body_behind_a_joint_goes_with_it() -> None:
    m, says = arm(1, references=(X, Y), angle=0.25, rate=3.0)
    m = replace(m, bodies=(*m.bodies, unit_body("rider")))
    rider = Pose(position=(0.0, 0.2, 0.4), rotation=TURN, relative_to=0)
    done = assembled(m, [Pose(), rider], says)
    R = rotation_z(0.25 - 0.5 * math.pi)
    np.testing.assert_allclose(done.state[0, 1, :3], R @ (0.5, 0.2, 0.4), atol=1e-14)
    np.testing.assert_allclose(done.state[0, 1, 3:12].reshape(3, 3), R @ np.reshape(TURN, (3, 3)), atol=1e-14)


def test_a_base_without_a_pose_stays_where_it_starts(unsolved: None) -> None:
    """And is at rest, with all that is behind it."""
    m, says = branch(False, (("revolute", {"angle": 0.4}), ("fixed", {})))
    done = assembled(m, [Pose()] * 3, says)
    np.testing.assert_array_equal(done.state[0, 0], [0, 0, 0, *so3.IDENTITY, 0, 0, 0, 0, 0, 0])
    np.testing.assert_array_equal(done.state[0, :, 12:], 0.0)


def test_a_pose_or_a_guess_counts_more_than_the_joint() -> None:
    """What is given is held; a guess says from where changes are least."""
    m, says = arm(2, references=(X, X), angle=0.3)
    given = Pose(rotation=tuple(rotation_z(0.3).ravel()))
    np.testing.assert_array_equal(assembled(m, [given, Pose()], says).state[0, 0, 3:12], given.rotation)
    said = JointStart(axes=(Z, Z), references=(X, X), known={"displacement": 0.5})
    slide = Joint("slide", "cylindrical", (GROUND, 0), (ZERO, ZERO))
    m = Model(GRAVITY, (unit_body("b"),), (slide,))
    guess = Pose(guess=Pose(rotation=tuple(rotation_z(1.1).ravel())))
    np.testing.assert_allclose(assembled(m, [guess], [said]).state[0, 0, 3:12], rotation_z(1.1).ravel(), atol=1e-14)


def test_omitted_rates_are_those_of_least_energy() -> None:
    """As without the way along the joints, which a guess takes away."""
    m, says = branch(False)
    says = [with_known(x, rate=None, speed=None) for x in says]
    free = assembled(m, [FLYING, *[Pose()] * 5], says)
    poses = [Pose(position=tuple(b[:3].tolist()), rotation=tuple(b[3:12].tolist())) for b in free.state[0, 1:]]
    given = assembled(m, [FLYING, *poses], [with_known(x, angle=None, displacement=None) for x in says])
    np.testing.assert_allclose(free.state, given.state, atol=1e-12)
    assert np.abs(free.velocity_violations).max() < 1e-13


@pytest.mark.parametrize("turned", [False, True])
def test_in_every_run(turned: bool) -> None:
    """Angles, rates, points, axes and references differ; a run alone has the same bits."""
    runs, rng = 9, np.random.default_rng(7)
    m, says = branch(turned)

    def spread(x: float) -> Any:
        return x + 0.05 * rng.standard_normal(runs)

    says[0] = with_known(says[0], angle=spread(2.8), references=((spread(1.0), 0.2, 0.0), (0.1, 0.0, 1.0)))
    says[2] = with_known(says[2], rate=spread(0.4), axes=((0.3, spread(-0.5), 0.8), (-1.0, 0.4, 0.4)))
    joints = list(m.joints)
    joints[1] = replace(joints[1], points=((0.1, spread(0.2), -0.3), joints[1].points[1]))
    m = replace(m, joints=tuple(joints))
    together = assembled(m, [FLYING, *[Pose()] * 5], says, runs)
    assert together.position_violations.max() < 1e-14
    for some in ([4], [8, 0, 3]):
        alone = assembled(picked(m, some), [FLYING, *[Pose()] * 5], picked(tuple(says), some), len(some))
        assert_same_bits(alone.state, together.state[some])


def test_a_run_that_contradicts_itself_moves_no_bit_elsewhere() -> None:
    """By a second hinge: on positions in one run, by a driver on velocities in another."""
    second = Joint("second", "revolute", (GROUND, 0), ((0.0, 0.0, np.zeros(4)), (-0.5, 0.0, 0.0)))
    m, says = arm(references=(X, X), angle=np.linspace(0.0, 1.0, 4), rate=np.full(4, 2.0))
    drive = Driver("drive", "rate", (GROUND, 0), (np.full(4, 2.0),), Coordinate(0, "angle"))
    m = replace(m, joints=(*m.joints, second), drivers=(drive,))
    says = (*says, JointStart(axes=(Z, Z)))
    fits = assembled(m, [Pose()], says, 4)
    points = ((0.0, 0.0, np.array([0.0, 0.3, 0.0, 0.0])), second.points[1])
    drive = replace(drive, value=(np.array([2.0, 2.0, 2.0, 5.0]),))
    m = replace(m, joints=(m.joints[0], replace(second, points=points)), drivers=(drive,))
    done = assembly.assemble(m, Start((Pose(),), says), 4)
    assert done.good.tolist() == [True, False, True, False]
    assert_same_bits(done.state[[0, 2]], fits.state[[0, 2]])


def test_a_loop_closes_from_where_the_joints_lead() -> None:
    """A parallelogram: the crank is where its angle says, and the rest follows near it."""
    ends = [(GROUND, 0), (0, 1), (1, 2), (2, GROUND)]
    points = [(ZERO, HALF[1]), HALF, HALF, (HALF[0], (1.0, 0.0, 0.0))]
    joints = tuple(Joint(f"j{i}", "revolute", e, p) for i, (e, p) in enumerate(zip(ends, points, strict=True)))
    says = [JointStart(axes=(Z, Z), references=(X, X)) for _ in ends]
    for i, angle in enumerate((1.2, -1.3, -1.6)):
        says[i] = with_known(says[i], angle=angle if i == 0 else None)
    m = Model(GRAVITY, tuple(unit_body(f"b{i}") for i in range(3)), joints)
    done = assembled(m, [Pose()] * 3, says)
    np.testing.assert_allclose(done.state[0, 0, 3:12].reshape(3, 3), rotation_z(1.2), atol=1e-14)
    assert done.position_violations.max() < 1e-14


def test_the_rows_of_a_tree_are_independent() -> None:
    m, says = branch(True)
    done = assembled(m, [FLYING, *[Pose()] * 5], says)
    assert rank.rank_of(rank.nominal(done.model), done.instant(0)) == rank.independent(done.model)
