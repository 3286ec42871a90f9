"""The initial state: the given is held, the omitted is solved for, what contradicts is left standing and told."""

from dataclasses import replace

import numpy as np
import pytest

from lienumba.groups import so3
from lienumba.mechanics.mechanism.model import JointStart, Pose, Start
from lienumba.mechanics.start import assembly, gauss_newton
from lienumba.scenario.start import prepare
from tests.compiler.evaluation import assert_same_bits
from tests.facade import GROUND, Body, Joint, Model, ScenarioError, resolve
from tests.oracles.reference import naive
from tests.rigs.mechanisms import GRAVITY, D, S, body

IDENTITY = so3.IDENTITY


def assemble(model, poses, runs):
    return assembly.assemble(model, Start(poses, (JointStart(),) * len(model.joints)), runs)


def bodies(k, seed=0):
    rng = np.random.default_rng(seed)
    return tuple(body(rng, f"b{i}") for i in range(k))


def turned(*u):
    return so3.exp(u)


def links(k, lengths=None):
    """A chain of links whose joints sit half a length before and behind the mass centre, along x."""
    half = [0.5 * n for n in (lengths or [1.0] * k)]
    joints = [Joint("j0", S, (GROUND, 0), ((0.0, 0.0, 0.0), (-half[0], 0.0, 0.0)))]
    for i in range(1, k):
        joints.append(Joint(f"j{i}", S, (i - 1, i), ((half[i - 1], 0.0, 0.0), (-half[i], 0.0, 0.0))))
    return Model(GRAVITY, bodies(k), tuple(joints))


def parts(done, run=0):
    return np.split(done.state[run], [3, 12, 15], axis=1)


# ---------------------------------------------------------------- solving for what is omitted
def test_omitted_positions_follow_from_given_rotations():
    m = links(3)
    R = [turned(0.0, 0.0, 0.3), turned(0.1, -0.4, 0.0), turned(2.0, 1.0, 0.5)]
    done = assemble(m, tuple(Pose(rotation=r) for r in R), 1)
    assert done.good.all()
    end = np.zeros(3)
    for i, r in enumerate(R):
        half = np.array(so3.rotate(r, (0.5, 0.0, 0.0)))
        np.testing.assert_allclose(done.state[0, i, :3], end + half, atol=1e-14)
        np.testing.assert_array_equal(done.state[0, i, 3:12], r)
        end = end + 2.0 * half


def test_omitted_velocities_follow_from_given_angular_velocities():
    m = links(2)
    R, w = [turned(0.2, 0.1, -0.7), turned(1.0, 0.0, 0.4)], [(1.0, 2.0, 3.0), (-0.5, 0.2, 4.0)]
    poses = tuple(Pose(rotation=r, angular_velocity=u) for r, u in zip(R, w, strict=True))
    done = assemble(m, poses, 1)
    r, _, v, turning = parts(done)
    np.testing.assert_array_equal(turning, w)
    global_w = [np.array(so3.rotate(a, b)) for a, b in zip(R, w, strict=True)]
    first = np.cross(global_w[0], r[0])
    elbow, at = np.cross(global_w[0], 2 * r[0]), 2 * r[0]
    np.testing.assert_allclose(v, [first, elbow + np.cross(global_w[1], r[1] - at)], atol=1e-13)


def test_without_any_given_velocity_all_is_at_rest():
    done = assemble(links(3), tuple(Pose(rotation=turned(0.1 * i, 0.2, 0.0)) for i in range(3)), 1)
    assert not done.state[0, :, 12:].any()


def test_omitted_velocities_are_those_of_least_kinetic_energy():
    """One body's velocity is given; the other's, of full inertia, is free: compare with the dense minimiser."""
    m = links(2)
    poses = (
        Pose(rotation=turned(0.2, 0.1, -0.7), angular_velocity=(1.0, 2.0, 3.0)),
        Pose(rotation=turned(1.0, 0.0, 0.4)),
    )
    done = assemble(m, poses, 1)
    r, R, v, w = parts(done)
    C = naive.jacobian(m.joints, r, R.reshape(-1, 3, 3))
    given, free = C[:, 3:6] @ [1.0, 2.0, 3.0], [0, 1, 2, *range(6, 12)]
    M = naive.mass_matrix(m.bodies)[np.ix_(free, free)]
    best = naive.solve_kkt(M, C[:, free], np.zeros(len(free)), -given)[0]
    np.testing.assert_allclose(np.hstack([v[0], v[1], w[1]]), best, atol=1e-12)


def test_a_loop_of_rods_closes():
    """A four-bar of rods between two given bodies: the omitted ones find their places, rotations included."""
    m = Model(GRAVITY, bodies(3), (
        Joint("a", S, (GROUND, 0), ((0.0, 0.0, 0.0), (-0.5, 0.0, 0.0))),
        Joint("b", D, (0, 1), ((0.5, 0.0, 0.0), (-0.5, 0.0, 0.1)), numbers={"length": 1.2}),
        Joint("c", D, (1, 2), ((0.5, 0.0, 0.0), (-0.5, 0.0, 0.0)), numbers={"length": 0.7}),
        Joint("d", S, (2, GROUND), ((0.5, 0.0, 0.0), (2.5, 0.3, 0.2))),
        Joint("e", D, (GROUND, 1), ((1.0, -1.0, 0.0), (0.0, 0.2, 0.0)), numbers={"length": 1.1}),
    ))  # fmt: skip
    done = assemble(m, (Pose(rotation=turned(0.0, 0.3, 0.8)), Pose(), Pose()), 1)
    assert done.good.all()
    r, R, _, _ = parts(done)
    assert np.abs(naive.residual(m.joints, r, R.reshape(-1, 3, 3))).max() < 1e-13
    np.testing.assert_array_equal(R[0], turned(0.0, 0.3, 0.8))
    for i in range(3):
        np.testing.assert_allclose(R[i].reshape(3, 3) @ R[i].reshape(3, 3).T, np.eye(3), atol=1e-13)


def test_a_rod_without_a_length_keeps_the_distance_at_the_start():
    m = Model(GRAVITY, bodies(2), (
        Joint("pivot", S, (GROUND, 0), ((0.0, 0.0, 0.0), (-1.0, 0.0, 0.0))),
        Joint("rod", D, (0, 1), ((1.0, 0.0, 0.0), (0.0, 0.0, 0.0)), numbers={"length": None}),
    ))  # fmt: skip
    done = assemble(m, (Pose(rotation=IDENTITY), Pose(position=(2.0, 3.0, 4.0), rotation=IDENTITY)), 2)
    assert done.good.all()
    assert np.broadcast_to(done.model.joints[1].numbers["length"], 2) == pytest.approx([5.0, 5.0], rel=1e-15)
    assert m.joints[1].numbers["length"] is None


def test_a_straight_start_finds_a_bent_solution():
    """Both ends on the ground and closer than the links are long: a straight start shows no way to turn."""
    m = links(2)
    m = Model(m.gravity, m.bodies, (*m.joints, Joint("end", S, (1, GROUND), ((0.5, 0.0, 0.0), (1.2, 0.0, 0.0)))))
    done = assemble(m, (Pose(), Pose()), 1)
    assert done.good.all()
    assert done.position_violations.max() < 1e-13


# ---------------------------------------------------------------- holding what is given
def test_what_is_given_and_fits_is_held_to_the_bit():
    m = links(2)
    R = (turned(0.3, -0.2, 0.9), turned(-1.0, 0.4, 0.1))
    half = [np.array(so3.rotate(r, (0.5, 0.0, 0.0))) for r in R]
    position = tuple((2.0 * half[0] + half[1]).tolist())
    done = assemble(
        m, (Pose(rotation=R[0], angular_velocity=(1.0, 2.0, -3.0)), Pose(position=position, rotation=R[1])), 3
    )
    assert done.good.all()
    for run in range(3):
        np.testing.assert_array_equal(done.state[run, 1, :3], position)
        np.testing.assert_array_equal(done.state[run, :, 3:12], R)
        np.testing.assert_array_equal(done.state[run, 0, 15:], (1.0, 2.0, -3.0))


# ---------------------------------------------------------------- contradictions
def test_a_given_position_that_misses_its_joint_is_reported_with_its_size():
    m = links(2)
    poses = (Pose(position=(0.5, 0.0, 0.0), rotation=IDENTITY), Pose(position=(1.5, 0.02, 0.0), rotation=IDENTITY))
    done = assemble(m, poses, 1)
    assert not done.good.any()
    assert done.position_violations[0] == pytest.approx([0.0, 0.0, 0.0, 0.0, 0.02, 0.0], abs=1e-15)
    np.testing.assert_array_equal(done.state[0, 1, :3], (1.5, 0.02, 0.0))  # held, not quietly moved


def test_a_given_velocity_that_contradicts_its_joint_is_reported_with_its_size():
    pose = Pose(rotation=IDENTITY, velocity=(0.0, 0.25, 0.0), angular_velocity=(0.0, 0.0, 1.0))
    done = assemble(links(1), (pose,), 1)
    assert not done.good.any()
    assert done.position_violations.max() < 1e-15
    assert done.velocity_violations[0] == pytest.approx([0.0, 0.25, 0.0], abs=1e-15)


def test_points_too_far_apart_for_any_rotation_are_reported():
    m = links(1)
    m = Model(m.gravity, m.bodies, (*m.joints, Joint("end", S, (0, GROUND), ((0.5, 0.0, 0.0), (3.0, 0.0, 0.0)))))
    done = assemble(m, (Pose(),), 1)
    assert not done.good.any()
    assert done.position_violations.max() > 0.5


def test_what_fits_nowhere_is_not_sought_for_long(monkeypatch):
    """Hinges about one axis, of which the last body shall be turned about another one: where starts that differ end
    equally far from it, no other one is tried."""
    chain = {
        "bodies": [{"name": f"b{i}", "mass": 1.0, "inertia": [0.1, 0.1, 0.1]} for i in range(4)],
        "joints": [
            {
                "name": f"j{i}",
                "type": "revolute",
                "bodies": [f"b{i - 1}" if i else "ground", f"b{i}"],
                "points": [[0.5 if i else 0.0, 0, 0], [-0.5, 0, 0]],
                "axes": [[0, 0, 1], [0, 0, 1]],
                "angle": 0.3,
                "rate": 0.0,
            }
            for i in range(4)
        ],
        "drivers": [{"name": "tilt", "motion": "orientation", "body": "b3", "value": [0.4, 0, 0]}],
    }
    steps, least = [], gauss_newton.Least
    monkeypatch.setattr(gauss_newton, "Least", lambda *given: steps.append(1) or least(*given))
    integrator = {"method": "rk4", "step": 1e-3, "end_time": 0.1}
    with pytest.raises(ScenarioError, match="prescribes another position at t = 0"):
        prepare.check_initial(resolve({"model": chain, "integrator": integrator}))
    assert len(steps) < 120


# ---------------------------------------------------------------- one run and its batch
def varied(runs, seed=1):
    """A chain with a closing rod in which masses, points, a rotation, a velocity and a length differ by run."""
    rng = np.random.default_rng(seed)

    def spread(x, by=0.05):
        return x + by * rng.standard_normal(runs)

    first, *others = bodies(3)
    first = Body("b0", spread(first.mass), (*first.inertia[:5], spread(first.inertia[5])))
    joints = list(links(3).joints)
    joints[1] = replace(joints[1], points=((spread(0.5), 0.0, spread(0.0)), joints[1].points[1]))
    joints.append(Joint("rod", D, (GROUND, 2), ((2.0, 1.0, 0.0), (0.5, 0.0, 0.0)), numbers={"length": spread(1.5)}))
    u = tuple(spread(x, 0.3) for x in (0.1, 0.2, 0.3))
    poses = (Pose(rotation=so3.exp(u), angular_velocity=(spread(1.0), 0.0, spread(-2.0))), Pose(), Pose())
    return Model(GRAVITY, (first, *others), tuple(joints)), poses


def picked(x, runs):
    """The same model or poses with these runs of every array."""
    if isinstance(x, np.ndarray):
        return x[runs]
    if isinstance(x, tuple):
        return tuple(picked(y, runs) for y in x)
    if isinstance(x, dict):
        return {key: picked(value, runs) for key, value in x.items()}
    if hasattr(x, "__dataclass_fields__"):
        return replace(x, **{name: picked(value, runs) for name, value in vars(x).items()})
    return x


def test_a_run_is_assembled_the_same_whichever_others_are_with_it():
    m, poses = varied(12)
    together = assemble(m, poses, 12)
    assert together.good.all()
    for runs in ([3], [0], [11, 2], [5, 6, 7, 8, 5]):
        some = assemble(picked(m, runs), picked(poses, runs), len(runs))
        assert_same_bits(some.state, together.state[runs])
        assert_same_bits(some.position_violations, together.position_violations[runs])


def test_a_run_that_cannot_be_assembled_moves_no_bit_elsewhere():
    m, poses = varied(4)
    alone = assemble(m, poses, 4)
    for value in (-40.0, np.nan):
        length = m.joints[3].numbers["length"].copy()
        length[2] = value
        broken = replace(m, joints=(*m.joints[:3], replace(m.joints[3], numbers={"length": length})))
        done = assemble(broken, poses, 4)
        assert done.good.tolist() == [True, True, False, True]
        others = [0, 1, 3]
        assert_same_bits(done.state[others], alone.state[others])


def test_a_run_that_fits_from_the_start_is_untouched_by_those_that_do_not():
    """Not even in the sign of a zero, of which the rotation about -z has some."""
    R = turned(0.0, 0.0, -0.3)
    meeting, elsewhere = so3.rotate(R, (0.5, 0.0, 0.0)), (1.0, 2.0, 3.0)
    ground = tuple(np.array(x) for x in zip(meeting, elsewhere, strict=True))
    m = Model(GRAVITY, bodies(1), (Joint("j", S, (GROUND, 0), (ground, (0.5, 0.0, 0.0))),))
    together = assemble(m, (Pose(rotation=R),), 2)
    for run in range(2):
        alone = assemble(picked(m, [run]), (Pose(rotation=R),), 1)
        assert_same_bits(together.state[run], alone.state[0])
