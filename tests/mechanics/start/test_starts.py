"""Starts as users give them: relative poses, guesses, joint coordinates, joints placed in global coordinates."""

import math
from dataclasses import replace

import numpy as np
import pytest

from lienumba.groups import so3
from lienumba.mechanics.mechanism.model import Coordinate, Driver, Force, JointStart, Pose, Start
from lienumba.mechanics.start import assembly, joint_frames
from lienumba.mechanics.system import constraints
from tests.compiler.evaluation import assert_same_bits
from tests.facade import GROUND, Joint, Model
from tests.mechanics.start.test_assembly import picked
from tests.rigs.joint_starts import joint_start, with_known
from tests.rigs.linkages import GRAVITY, bennett, closed_chain, triple, unit_body

X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
ZERO = (0.0, 0.0, 0.0)
HALF = ((0.5, 0.0, 0.0), (-0.5, 0.0, 0.0))
TURN = so3.exp((0.3, -0.5, 1.1))


def arm(k=1, axis=Z, drivers=(), **says):
    """A chain of links of length 1 along x, hinged one to the next; what is said goes to every joint."""
    joints = tuple(Joint(f"j{i}", "revolute", (i - 1, i), (ZERO if i == 0 else HALF[0], HALF[1])) for i in range(k))
    start = joint_start(axes=(axis, axis), **says)
    return Model(GRAVITY, tuple(unit_body(f"b{i}") for i in range(k)), joints, drivers), (start,) * k


def assembled(model, poses, says, runs=1):
    done = assembly.assemble(model, Start(tuple(poses), tuple(says)), runs)
    assert done.good.all(), (done.position_violations, done.velocity_violations)
    return done


def rotation_z(angle):
    return np.array([[math.cos(angle), -math.sin(angle), 0], [math.sin(angle), math.cos(angle), 0], [0, 0, 1]])


# ---------------------------------------------------------------- angles and rates of joints
def test_a_chain_is_entered_by_its_joint_angles_and_rates():
    k, angle, rate = 4, 0.4, -0.3
    m, says = arm(k, angle=angle, rate=rate)
    done = assembled(m, [Pose()] * k, says)
    tip, tip_v, turn, w = np.zeros(3), np.zeros(3), 0.0, 0.0
    for i in range(k):
        turn, w = turn + angle, w + rate
        half = rotation_z(turn) @ (0.5, 0.0, 0.0)
        v = np.cross((0.0, 0.0, w), half)
        np.testing.assert_allclose(done.state[0, i, :3], tip + half, atol=1e-14)
        np.testing.assert_allclose(done.state[0, i, 3:12].reshape(3, 3), rotation_z(turn), atol=1e-14)
        np.testing.assert_allclose(done.state[0, i, 12:], [*(tip_v + v), 0.0, 0.0, w], atol=1e-14)
        tip, tip_v = tip + 2 * half, tip_v + 2 * v
        assert done.angles[i] == pytest.approx(angle, abs=1e-14)


@pytest.mark.parametrize("angle", [3.0, -3.0, 7.5, -40.0])
def test_an_angle_of_more_than_pi_is_met_and_counted(angle):
    m, says = arm(angle=angle)
    done = assembled(m, [Pose()], says)
    np.testing.assert_allclose(done.state[0, 0, 3:12].reshape(3, 3), rotation_z(angle), atol=1e-13)
    assert done.angles[0][0] == pytest.approx(angle, abs=1e-12)


def test_without_references_the_angle_starts_at_zero_or_as_given():
    m, says = arm()
    pose = Pose(rotation=tuple(rotation_z(0.8).ravel()))
    assert assembled(m, [pose], says).angles[0][0] == pytest.approx(0.0, abs=1e-15)
    m, says = arm(angle=7.0)
    done = assembled(m, [pose], says)
    assert done.angles[0][0] == pytest.approx(7.0, abs=1e-14)
    np.testing.assert_array_equal(done.state[0, 0, 3:12], pose.rotation)


def test_references_say_where_the_angle_is_zero():
    m, says = arm(references=(X, Y), angle=0.25)
    done = assembled(m, [Pose()], says)
    np.testing.assert_allclose(done.state[0, 0, 3:12].reshape(3, 3), rotation_z(0.25 - 0.5 * math.pi), atol=1e-14)


def test_drivers_place_and_move_the_start():
    drivers = (
        Driver("first", "value", (GROUND, 0), (lambda t: 0.3 + 2.0 * t,), Coordinate(0, "angle")),
        Driver("second", "rate", (0, 1), (lambda t: 4.0 - t,), Coordinate(1, "angle")),
    )
    m, says = arm(2, drivers=drivers)
    done = assembled(m, [Pose(), Pose(relative_to=0)], says)
    turn = rotation_z(0.3)
    np.testing.assert_allclose(done.state[0, :, 3:12].reshape(2, 3, 3), [turn, turn], atol=1e-14)
    np.testing.assert_allclose(done.state[0, :, 15:], [[0, 0, 2], [0, 0, 6]], atol=1e-13)
    assert done.angles[0][0] == pytest.approx(0.3, abs=1e-15)
    assert [c.what for c in done.conditions] == ["joint", "joint", "driver", "driver"]


def test_a_slider_is_entered_by_displacement_and_speed():
    joint = Joint("slide", "prismatic", (GROUND, 0), ((1.0, 0.0, 0.0), ZERO))
    m = Model(GRAVITY, (unit_body("b"),), (joint,))
    says = JointStart(axes=((0.0, 3.0, 0.0), Y), known={"displacement": -0.7, "speed": 2.0})
    done = assembled(m, [Pose()], [says])
    np.testing.assert_allclose(done.state[0, 0], [1, -0.7, 0, *so3.IDENTITY, 0, 2, 0, 0, 0, 0], atol=1e-14)


def test_a_given_angle_that_cannot_be_is_reported_for_its_joint():
    m, says = arm(references=(X, X), angle=0.5)
    done = assembly.assemble(m, Start((Pose(rotation=so3.IDENTITY),), says), 1)
    assert not done.good.any()
    (condition,) = [c for c in done.conditions if c.what == "angle"]
    assert (condition.name, condition.kinds) == ("j0", "r")
    assert done.position_violations[0, condition.rows] == pytest.approx([0.5])


def test_where_nothing_says_from_where_an_angle_counts():
    m, says = arm(angle=0.5)
    turned = JointStart(axes=(Z, X), known={"angle": 0.5})
    assert joint_frames.without_zero(m, Start((Pose(),), says)) == []
    assert joint_frames.without_zero(m, Start((Pose(),), (turned,))) == [0]
    assert joint_frames.without_zero(m, Start((Pose(rotation=so3.IDENTITY),), (turned,))) == []


# ---------------------------------------------------------------- loops from partial data
def four_bar(crank=0.35, guess=None):
    lengths = (0.4, 1.1, 0.9)
    ends = [(ZERO, (-0.2, 0, 0)), ((0.2, 0, 0), (-0.55, 0, 0)), ((0.55, 0, 0), (-0.45, 0, 0)), ((0.45, 0, 0), X)]
    names = [(GROUND, 0), (0, 1), (1, 2), (2, GROUND)]
    joints = tuple(
        Joint(f"j{i}", "revolute", e, (triple(p), triple(q)))
        for i, (e, (p, q)) in enumerate(zip(names, ends, strict=True))
    )
    m = Model(GRAVITY, tuple(unit_body(f"b{i}") for i in range(len(lengths))), joints)
    says = [JointStart(axes=(Z, Z), known={"angle": crank, "rate": 2.0})] + [JointStart(axes=(Z, Z))] * 3
    return m, [Pose(), Pose(), Pose(guess=guess)], says


def tip(done, run=0):
    """Where coupler and rocker meet."""
    return done.state[run, 2, :3] - 0.45 * done.state[run, 2, [3, 6, 9]]


def test_a_four_bar_follows_from_its_crank():
    m, poses, says = four_bar()
    done = assembled(m, poses, says)
    pin, meet = 0.4 * np.array([math.cos(0.35), math.sin(0.35), 0.0]), tip(done)
    assert np.linalg.norm(meet - pin) == pytest.approx(1.1, abs=1e-14)
    assert np.linalg.norm(meet - X) == pytest.approx(0.9, abs=1e-14)
    w = done.state[0, :, 17]
    assert w[0] == pytest.approx(2.0, abs=1e-14)
    pin_v = 2.0 * np.array([-pin[1], pin[0], 0.0])
    coupler = pin_v + np.cross((0, 0, w[1]), meet - pin)
    np.testing.assert_allclose(coupler, np.cross((0, 0, w[2]), meet - np.array(X)), atol=1e-13)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_guess_chooses_the_branch(side):
    turn = tuple(rotation_z(-side * 1.0).ravel())
    guess = Pose(position=(0.9, side * 0.4, 0.0), rotation=turn)
    m, poses, says = four_bar(guess=guess)
    assert np.sign(tip(assembled(m, poses, says))[1]) == side


def test_a_crank_in_every_run():
    crank = np.linspace(-3.0, 3.0, 13)
    m, poses, says = four_bar(crank)
    together = assembled(m, poses, says, 13)
    for i in (0, 6, 12, 3):
        alone = assembled(m, poses, picked(tuple(says), [i]))
        assert_same_bits(alone.state[0], together.state[i])
        assert_same_bits(alone.angles[3][0], together.angles[3][i])


# ---------------------------------------------------------------- relative poses
def test_relative_poses_and_velocities_compose_along_chains_in_every_run():
    rng = np.random.default_rng(3)
    u, w0 = rng.standard_normal((2, 3, 5))
    base = Pose((1.0, 2.0, 3.0), so3.exp(tuple(u)), (0.5, 0.0, -1.0), tuple(w0))
    poses = [
        Pose((0.0, 0.2, 0.0), TURN, (0.0, 0.0, 0.1), (1.0, 0.0, 0.0), relative_to=1),
        Pose((1.0, 0.0, 0.0), TURN, relative_to=2),
        base,
    ]
    m = Model(GRAVITY, tuple(unit_body(f"b{i}") for i in range(3)))
    done = assembled(m, poses, [], 5)
    T = np.array(TURN).reshape(3, 3)
    for run in range(5):
        r, R = np.array(base.position), np.array([x[run] for x in base.rotation]).reshape(3, 3)
        v, w = np.array(base.velocity), R @ w0[:, run]  # both global
        for i, p, dv, dw in ((1, (1.0, 0, 0), ZERO, ZERO), (0, (0, 0.2, 0), (0, 0, 0.1), X)):
            v, r = v + np.cross(w, R @ p) + R @ dv, r + R @ p
            R = R @ T
            w = w + R @ dw
            np.testing.assert_allclose(done.state[run, i], [*r, *R.ravel(), *v, *(R.T @ w)], atol=1e-13)


def test_what_hangs_on_a_base_that_is_solved_for_moves_with_it():
    m, says = arm(angle=0.9, rate=2.0)
    m = Model(m.gravity, (*m.bodies, unit_body("rider")), m.joints)
    done = assembled(m, [Pose(), Pose((0.0, 1.0, 0.0), TURN, (0.1, 0.0, 0.0), ZERO, relative_to=0)], says)
    R = rotation_z(0.9)
    r = R @ (0.5, 1.0, 0.0)
    np.testing.assert_allclose(done.state[0, 1, :3], r, atol=1e-14)
    np.testing.assert_allclose(done.state[0, 1, 3:12].reshape(3, 3), R @ np.array(TURN).reshape(3, 3), atol=1e-14)
    np.testing.assert_allclose(done.state[0, 1, 12:15], np.cross((0, 0, 2.0), r) + R @ (0.1, 0, 0), atol=1e-13)
    np.testing.assert_allclose(so3.rotate(done.state[0, 1, 3:12], done.state[0, 1, 15:]), [0, 0, 2.0], atol=1e-13)


def test_omitted_velocities_of_relative_bodies_are_those_of_rigid_motion():
    """A base on a pivot, its turning given; an arm hinged to it, of which nothing is said."""
    base = Joint("pivot", "spherical", (GROUND, 0), (ZERO, (0.0, 0.0, -1.5)))
    hinge = Joint("hinge", "revolute", (0, 1), ((0.0, 0.0, 0.75), (0.0, 0.0, -0.75)))
    m = Model(GRAVITY, (unit_body("base"), unit_body("arm")), (base, hinge))
    w = (0.2, -0.4, 0.7)
    poses = [Pose(rotation=TURN, angular_velocity=w), Pose((0.0, 0.0, 1.5), so3.IDENTITY, relative_to=0)]
    done = assembled(m, poses, [JointStart(), JointStart(axes=(Y, Y))])
    turning = so3.rotate(TURN, w)
    for body in done.state[0]:
        np.testing.assert_allclose(body[12:15], np.cross(turning, body[:3]), atol=1e-14)
        np.testing.assert_allclose(so3.rotate(tuple(body[3:12]), body[15:]), turning, atol=1e-14)


# ---------------------------------------------------------------- joints in global coordinates
def test_points_and_axes_at_the_start_become_those_of_the_bodies():
    m = Model(GRAVITY, (unit_body("b"),), (Joint("j", "universal", (GROUND, 0)),))
    pose = Pose((1.0, 2.0, 3.0), TURN)
    done = assembled(m, [pose], [JointStart(at=(1.0, 1.0, 0.0), axis=(X, (0.0, 0.0, 2.0)))])
    joint, R = done.model.joints[0], np.array(TURN).reshape(3, 3)
    assert joint.points[0] == (1.0, 1.0, 0.0)
    np.testing.assert_allclose(joint.points[1], R.T @ (0.0, -1.0, -3.0), atol=1e-15)
    np.testing.assert_allclose([joint.frames[0][2], joint.frames[1][2]], [X, R.T @ Z], atol=1e-15)


@pytest.mark.parametrize("pins", [(X, Y), (X, Z), (Y, Z), (Y, X), (Z, X), (Z, (0.0, -1.0, 0.0)), (X, (0.0, 1.0, 1e-9))])
def test_crossed_pins_along_any_axes_have_frames(pins):
    """Also where the second pin is the direction from which the angle about the first counts."""
    m = Model(GRAVITY, (unit_body("b"),), (Joint("j", "universal", (GROUND, 0)),))
    done = assembled(m, [Pose(X, TURN)], [JointStart(at=X, axis=pins)])
    joint, R = done.model.joints[0], np.array(TURN).reshape(3, 3)
    for frame, pin, rotation in zip(joint.frames, pins, (np.eye(3), R), strict=True):
        np.testing.assert_allclose(np.array(frame) @ np.array(frame).T, np.eye(3), atol=1e-15)
        np.testing.assert_allclose(rotation @ frame[2], pin, atol=1e-15)
    assert np.isfinite([*joint.numbers.values()]).all()


def test_a_body_placed_by_nothing_cannot_carry_a_point_at_the_start():
    m, _ = closed_chain([(0, 0, 0), (1, 0, 0)], [Z, Z])
    says = (JointStart(at=ZERO, axis=(Z,)), JointStart(at=X, axis=(Z,)))
    assert joint_frames.unplaced(m, Start((Pose(rotation=TURN),), says)) == [(0, 0), (1, 0)]
    assert joint_frames.unplaced(m, Start((Pose(position=ZERO),), says)) == []


@pytest.mark.parametrize("z", [X, Y, Z, (0.0, 0.0, -2.0), (-5.0, 0.0, 0.0)])
def test_frames_along_coordinate_axes_are_exact(z):
    x, y, axis = joint_frames.any_frame(joint_frames.unit(tuple(map(np.float64, z))))
    numbers = {float(c) for v in (x, y, axis) for c in v}
    assert numbers <= {0.0, 1.0, -1.0}
    np.testing.assert_array_equal(np.cross(axis, x), y)
    np.testing.assert_array_equal(axis, np.sign(z))


def test_frames_are_orthonormal():
    for z in np.random.default_rng(0).standard_normal((20, 3)):
        F = np.array(joint_frames.any_frame(joint_frames.unit(tuple(z))))
        np.testing.assert_allclose(F @ F.T, np.eye(3), atol=1e-15)
        assert np.linalg.det(F) == pytest.approx(1.0)


def test_where_rotations_are_given_the_frames_are_structure():
    m, says = arm()
    frames = assembled(m, [Pose(rotation=so3.IDENTITY)], says, 3).model.joints[0].frames
    assert frames == ((X, Y, Z), (X, Y, Z))
    assert {type(c) for side in frames for v in side for c in v} == {float}


# ---------------------------------------------------------------- what the start decides
def test_a_weld_and_a_slider_keep_the_orientation_of_the_start():
    joints = (
        Joint("slide", "prismatic", (GROUND, 0), (ZERO, ZERO)),
        Joint("weld", "fixed", (0, 1), (X, ZERO)),
        Joint("tilt", "parallel_axes", (GROUND, 1)),
    )
    m = Model(GRAVITY, (unit_body("a"), unit_body("b")), joints)
    tilted = triple((math.sin(0.4), 0.0, math.cos(0.4)))
    says = [JointStart(axes=(X, X)), JointStart(), JointStart(axes=(tilted, Z))]
    done = assembled(m, [Pose(), Pose()], says)
    R = done.state[0, 1, 3:12].reshape(3, 3)
    np.testing.assert_allclose(R @ Z, tilted, atol=1e-14)
    now = done.instant(0)
    assert max(map(abs, constraints.residual(picked(done.model, [0]), now))) < 1e-14


def test_couplings_count_from_the_start():
    m, says = arm(2)
    gear = Joint(
        "gear",
        "gear",
        (GROUND, 0, 1),
        coordinates=(Coordinate(0, "angle"), Coordinate(1, "angle")),
        numbers={"ratio": -3.0, "offset": None},
    )
    m = Model(m.gravity, m.bodies, (*m.joints, gear))
    says = (joint_start(axes=(Z, Z), angle=0.2, rate=1.0), joint_start(axes=(Z, Z), angle=0.5), JointStart())
    done = assembled(m, [Pose(), Pose()], says)
    assert done.model.joints[2].numbers["offset"] == pytest.approx(0.5 + 3.0 * 0.2, abs=1e-13)
    np.testing.assert_allclose(done.state[0, :, 17], [1.0, 1.0 - 3.0], atol=1e-13)


def test_a_screw_counts_from_the_start():
    joint = Joint("screw", "screw", (GROUND, 0), (ZERO, ZERO), numbers={"pitch": 0.2, "offset": None})
    m = Model(GRAVITY, (unit_body("nut"),), (joint,))
    done = assembled(m, [Pose()], [JointStart(axes=(Z, Z), known={"displacement": 0.05, "rate": 2 * math.pi})])
    assert done.model.joints[0].numbers["offset"] == pytest.approx(0.05, abs=1e-15)
    np.testing.assert_allclose(done.state[0, 0, 12:], [0, 0, 0.2, 0, 0, 2 * math.pi], atol=1e-13)


def test_rests_of_forces_are_those_of_the_start():
    forces = (
        Force("spring", "spring_damper", (GROUND, 0), (ZERO, ZERO), numbers={"stiffness": 1.0}),
        Force("set", "spring_damper", (GROUND, 0), (ZERO, ZERO), numbers={"stiffness": 1.0, "free_length": 2.0}),
        Force("pad", "bushing", (GROUND, 0), (ZERO, ZERO)),
    )
    m = Model(GRAVITY, (unit_body("b"),), forces=forces)
    done = assembled(m, [Pose((3.0, 0.0, 4.0), TURN)], [])
    spring, given, pad = done.model.forces
    assert (spring.rest, given.rest, pad.rest) == ((5.0,), None, TURN)


# ---------------------------------------------------------------- over-constrained
def test_an_overconstrained_linkage_is_assembled_from_guesses():
    m, start = bennett()
    exact = assembly.assemble(m, start, 1)
    rng = np.random.default_rng(5)
    near = []
    for pose in start.poses:
        turned = so3.multiply(pose.rotation, so3.exp(triple(0.05 * rng.standard_normal(3))))
        near.append(Pose(guess=Pose(triple(pose.position + 0.05 * rng.standard_normal(3)), turned)))
    says = [JointStart(axes=tuple(f[2] for f in joint.frames)) for joint in exact.model.joints]
    done = assembled(exact.model, near, says)
    assert done.position_violations.max() < 1e-13


# ---------------------------------------------------------------- rounding, and bodies of very different masses
@pytest.mark.parametrize(("turning", "good"), [(1e-16, True), (1e-13, True), (1e-9, False)])
def test_a_start_at_rest_may_have_rounding(turning, good):
    """About an axis across the hinge's, while nothing else moves."""
    m, says = arm()
    pose = Pose(position=HALF[0], rotation=so3.IDENTITY, velocity=ZERO, angular_velocity=(turning, 0.0, 0.0))
    assert assembly.assemble(m, Start((pose,), says), 1).good.tolist() == [good]


@pytest.mark.parametrize(("off", "good"), [(1e-17, True), (1e-9, False)])
def test_so_may_one_in_the_middle_of_everything(off, good):
    joint = Joint("ball", "spherical", (GROUND, 0), (ZERO, ZERO))
    m = Model(GRAVITY, (unit_body("b"),), (joint,))
    pose = Pose(position=(off, 0.0, 0.0), rotation=so3.IDENTITY)
    assert assembly.assemble(m, Start((pose,), (JointStart(),)), 1).good.tolist() == [good]


@pytest.mark.parametrize("lightest", [1e-8, 1e-12, 1e-16])
def test_a_light_link_between_hinges_starts_with_the_rates_that_are_given(lightest):
    """Also where guesses, and not the joints alone, say where the bodies are, and in the one run that has it."""
    rates = (0.7, -1.3, 0.4)
    m, says = arm(3, angle=0.4)
    says = tuple(with_known(x, rate=rate) for x, rate in zip(says, rates, strict=True))
    light = np.array([1.0, lightest])
    body = replace(m.bodies[1], mass=light, inertia=tuple(light * x for x in m.bodies[1].inertia))
    m = replace(m, bodies=(m.bodies[0], body, m.bodies[2]))
    guess = [Pose(guess=Pose(position=(0.5 + i, 0.1 * i, 0.0))) for i in range(3)]
    done = assembled(m, guess, says, 2)
    np.testing.assert_allclose(done.state[:, :, 17], np.tile(np.cumsum(rates), (2, 1)), atol=1e-11)
    alone = assembled(replace(m, bodies=(m.bodies[0], unit_body("b1"), m.bodies[2])), guess, says)
    assert_same_bits(done.state[:1], alone.state)
