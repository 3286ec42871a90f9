"""Quantities at random states against NumPy, SciPy's rotations, and differences along the motion."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lienumba.groups import so3
from lienumba.mechanics.elements import quantities
from lienumba.mechanics.elements.quantities import OBSERVED, POSITION, VELOCITY, Observed
from lienumba.mechanics.mechanism import kinematics
from lienumba.mechanics.mechanism.model import Coordinate, Driver, Law, Quantity
from lienumba.numerics.expressions import Formula
from lienumba.numerics.jets import lift
from tests.facade import GROUND, Instant, Joint, Model
from tests.mechanics.elements.force_cases import P, frame, moved
from tests.rigs.mechanisms import body, state

TARGET = so3.exp((0.5, 0.9, -1.1))
S = np.array([0.3, -0.7, 0.4])
JOINTS = (
    Joint("sleeve", "cylindrical", (0, 1), P, (frame(1), frame(2))),
    Joint("ball", "spherical", (1, 2), P),
    Joint("hinge", "revolute", (GROUND, 2), P, (frame(3), frame(4))),
)
DRIVERS = (
    Driver("turn", "value", (GROUND, 2), (0.0,), Coordinate(2, "angle")),
    Driver("slide", "rate", (0, 1), (0.0,), Coordinate(0, "displacement")),
    Driver("carry", "point", (0,), (0.0, 0.0, 0.0), point=P[0]),
    Driver("tilt", "orientation", (1,), (0.0, 0.0, 0.0)),
    Driver("roll", "angular_velocity", (2,), (0.0, 0.0, 0.0), frame="body"),
    Driver("yaw", "angular_velocity", (2,), (0.0, 0.0, 0.0), frame="global"),
)
FRAMES = [(GROUND, GROUND), (GROUND, 1), (1, 1), (1, GROUND), (1, 2), (1, 0)]  # relative_to, frame
SEEDS = [0, 1, 2]


def model(*named):
    rng = np.random.default_rng(5)
    return Model((0.0, 0.0, -9.81), tuple(body(rng, f"b{i}") for i in range(3)), JOINTS, DRIVERS, (), named)


def instant(seed, angle=0.0):
    return Instant(state(3, seed), 0.4, {0: angle, 2: angle})


def observed(seed):
    rng = np.random.default_rng(100 + seed)
    efforts = [rng.standard_normal(1 if d.coordinate else 3).tolist() for d in DRIVERS]
    return Observed(*(rng.standard_normal(n).tolist() for n in (18, 9, 9)), efforts)


def numbers(now, *named, seen=None, which=0):
    """All numbers of one of these quantities."""
    m = model(*named)
    return np.array(quantities.rows(m, named[which], kinematics.still(now, (0, 1, 2)), seen), float)


def place(now, i):
    """r, R, v, w of a body, all along global axes."""
    if i == GROUND:
        return np.zeros(3), np.eye(3), np.zeros(3), np.zeros(3)
    x = np.array(now.bodies[i], float)
    R = x[3:12].reshape(3, 3)
    return x[:3], R, x[12:15], R @ x[15:18]


def seen_from(now, base):
    """Position and velocity of the point S of body 0, as seen from a body, along its axes."""
    r, R, v, w = place(now, 0)
    r_b, R_b, v_b, w_b = place(now, base)
    p, dp = r + R @ S, v + np.cross(w, R @ S)
    return R_b.T @ (p - r_b), R_b.T @ (dp - v_b - np.cross(w_b, p - r_b))


def point(derivative, base, axes):
    return Quantity("tip", "point", (0,), point=tuple(S), derivative=derivative, relative_to=base, frame=axes)


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize(("base", "axes"), FRAMES[:4] + FRAMES[4:5])
def test_a_point_and_its_velocity(base, axes, seed):
    now = instant(seed)
    turn = place(now, axes)[1].T @ place(now, base)[1]
    for derivative, wanted in enumerate(seen_from(now, base)):
        found = numbers(now, point(derivative, base, axes))
        np.testing.assert_allclose(found, turn @ wanted, rtol=0, atol=1e-13)


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize(("base", "axes"), FRAMES)
def test_the_acceleration_of_a_point_is_the_difference_of_its_velocity(base, axes, seed):
    """The state is moved along a parabola: its velocities grow by the accelerations."""
    now, seen, h = instant(seed), observed(seed), 1e-4
    a = np.reshape(seen.accelerations, (3, 6))
    u = np.array([x[12:18] for x in now.bodies])

    def later(s):
        there = moved(now, u + 0.5 * s * a, s)
        faster = [(*x[:12], *(u[i] + s * a[i])) for i, x in enumerate(there.bodies)]
        return seen_from(replace(there, bodies=tuple(faster)), base)[1]

    difference = (8 * (later(h) - later(-h)) - later(2 * h) + later(-2 * h)) / (12 * h)
    turn = place(now, axes)[1].T @ place(now, base)[1]
    found = numbers(now, point(2, base, axes), seen=seen)
    np.testing.assert_allclose(found, turn @ difference, rtol=0, atol=1e-9 * max(1.0, np.abs(difference).max()))


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("base", [GROUND, 2])
def test_rotation_error(base, seed):
    q = Quantity("pointing", "rotation_error", (0,), relative_to=base, target=TARGET)
    now = instant(seed)
    goal = place(now, base)[1] @ np.reshape(TARGET, (3, 3))
    wanted = Rotation.from_matrix(goal.T @ place(now, 0)[1]).as_rotvec()
    *found, angle = numbers(now, q)
    np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-13)
    assert angle == pytest.approx(np.linalg.norm(wanted), rel=1e-14)
    np.testing.assert_allclose(goal @ found, place(now, 0)[1] @ found, atol=1e-12)  # along the axes of both


def test_no_rotation_error_at_the_target():
    bodies = tuple((*x[:3], *TARGET, *x[12:]) for x in state(3))
    q = Quantity("pointing", "rotation_error", (0,), target=TARGET)
    np.testing.assert_allclose(numbers(Instant(bodies), q), 0.0, atol=1e-15)


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize(("base", "axes"), [*FRAMES, (GROUND, 0)])
def test_angular_velocity(base, axes, seed):
    now = instant(seed)
    wanted = place(now, axes)[1].T @ (place(now, 0)[3] - place(now, base)[3])
    q = Quantity("rate", "angular_velocity", (0,), relative_to=base, frame=axes)
    np.testing.assert_allclose(numbers(now, q), wanted, rtol=0, atol=1e-13)


def coordinates(now):
    """Angle (principal) and displacement of the sleeve."""
    (r, R, *_), (s, Q, *_) = place(now, 0), place(now, 1)
    (x, y, z), (x_b, *_) = (np.array(f) for f in JOINTS[0].frames)
    return np.arctan2(R @ y @ Q @ x_b, R @ x @ Q @ x_b), R @ z @ (s + Q @ P[1] - r - R @ P[0])


@pytest.mark.parametrize("turns", [-3, 0, 2])
@pytest.mark.parametrize("seed", SEEDS)
def test_the_coordinates_of_a_joint(seed, turns):
    q = Quantity("sleeve", "joint", joint=0)
    now, h = instant(seed), 1e-5
    angle, displacement = coordinates(now)
    now = instant(seed, angle + 2 * np.pi * turns + 3.0)  # the nearest of all turns
    u = np.array([x[12:18] for x in now.bodies])
    before, after = (np.array(coordinates(moved(now, u, s))) for s in (-h, h))
    rate, speed = np.divide(after - before, 2 * h)
    assert quantities.components(model(q), q) == ["angle", "rate", "displacement", "speed"]
    found = numbers(now, q)
    np.testing.assert_allclose(found[[0, 2]], [angle + 2 * np.pi * turns, displacement], rtol=0, atol=1e-13)
    np.testing.assert_allclose(found[[1, 3]], [rate, speed], rtol=0, atol=1e-7)


@pytest.mark.parametrize("axes", [GROUND, 0, 1])
def test_reactions_are_turned_into_their_frame(axes):
    now, seen = instant(1), observed(1)
    R = place(now, axes)[1]
    found = numbers(now, Quantity("load", "reaction", joint=1, frame=axes), seen=seen)
    np.testing.assert_allclose(found, np.r_[R.T @ seen.forces[3:6], R.T @ seen.torques[3:6]], rtol=0, atol=1e-14)


@pytest.mark.parametrize("index", range(len(DRIVERS)))
def test_efforts(index):
    seen = observed(2)
    q = Quantity("motor", "driver_effort", driver=index)
    assert numbers(instant(2), q, seen=seen).tolist() == seen.efforts[index]
    (part,) = quantities.parts(model(q), q)
    name = DRIVERS[index].name
    assert part.units == ("N" if name in ("slide", "carry") else "N m")
    assert part.frame == {"turn": None, "slide": None, "tilt": 1, "roll": 2}.get(name, GROUND)


@pytest.mark.parametrize("about", [None, (0.0, 0.0, 0.0), (0.3, -1.0, 2.0)])
@pytest.mark.parametrize("of", [(0, 1, 2), (2, 0), (1,)])
@pytest.mark.parametrize("seed", SEEDS)
def test_momentum(about, of, seed):
    now, m = instant(seed), model()
    masses = {i: m.bodies[i].mass for i in of}
    centre = sum(masses[i] * place(now, i)[0] for i in of) / sum(masses.values())
    linear, angular = np.zeros(3), np.zeros(3)
    for i in of:
        r, R, v, w = place(now, i)
        xx, yy, zz, xy, xz, yz = m.bodies[i].inertia
        J = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        linear += masses[i] * v
        angular += np.cross(r - (centre if about is None else about), masses[i] * v) + R @ J @ R.T @ w
    found = numbers(now, Quantity("swing", "momentum", of, about=about))
    np.testing.assert_allclose(found, np.r_[linear, angular], rtol=0, atol=1e-12)


TIP, TURN = point(0, 1, 2), Quantity("pointing", "rotation_error", (0,), target=TARGET)
SLEEVE = Quantity("sleeve", "joint", joint=0)


def expression(name, text, **values):
    formula = Formula(text, frozenset({"t", "tip.x", "pointing.y", "sleeve.rate", "sleeve.angle", "inner", *values}))
    read = tuple(sorted(formula.used - values.keys() - {"t"}))
    return Quantity(name, "expression", value=Law(formula, values, read), units="N")


@pytest.mark.parametrize("seed", SEEDS)
def test_expressions_of_expressions(seed):
    inner = expression("inner", "k*tip.x**2 - sin(t)", k=3.0)
    outer = expression("outer", "2*inner + sleeve.rate*pointing.y")
    every, now = (TIP, TURN, SLEEVE, inner, outer), instant(seed)
    x, _, _ = numbers(now, *every)
    e, rate = numbers(now, *every, which=1)[1], numbers(now, *every, which=2)[1]
    wanted = 2 * (3 * x**2 - np.sin(0.4)) + rate * e
    np.testing.assert_allclose(numbers(now, *every, which=4), [wanted], rtol=1e-13)


def test_what_must_be_known():
    inner, outer = expression("inner", "sleeve.angle + tip.x"), expression("outer", "inner + sleeve.rate")
    named = [TIP, TURN, SLEEVE, inner, outer, *(replace(point(n, 1, 2), name=f"d{n}") for n in (1, 2))]
    named += [Quantity("load", "reaction", joint=1), Quantity("motor", "driver_effort", driver=0)]
    named += [Quantity("spin", "angular_velocity", (0,)), Quantity("swing", "momentum", (0,))]
    wanted = {
        "tip.x": POSITION, "pointing.angle": POSITION, "sleeve.angle": POSITION, "sleeve.displacement": POSITION,
        "inner": POSITION, "sleeve.rate": VELOCITY, "sleeve.speed": VELOCITY, "outer": VELOCITY, "d1.z": VELOCITY,
        "spin.x": VELOCITY, "swing.linear.x": VELOCITY, "d2.x": OBSERVED, "load.force.x": OBSERVED,
        "motor": OBSERVED,
    }  # fmt: skip
    assert {name: quantities.level(model(*named), name) for name in wanted} == wanted
    assert quantities.bodies_of(model(*named), inner.value) in ((0, 1, 2), (0, 2, 1))
    assert sorted(quantities.bodies_of(model(*named), outer.value, 3.0)) == [0, 1, 2]
    assert quantities.bodies_of(model(*named), expression("e", "pointing.y").value) == (0,)


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("name", ["tip.x", "pointing.y", "pointing.angle", "sleeve.angle", "inner"])
def test_jets_follow_the_motion(name, seed):
    """Value, rate and second derivative of what a driver may read, while time goes on and the velocities stay."""
    m = model(TIP, TURN, SLEEVE, expression("inner", "tip.x*pointing.y + cos(3*t)"))
    now, h = instant(seed), 1e-3
    u = np.array([x[12:18] for x in now.bodies])

    def at(s):
        there = moved(now, u, s, s)
        return quantities.component(m, name, kinematics.still(there, (0, 1, 2)))

    y = [at(n * h) for n in (-2, -1, 0, 1, 2)]
    x = lift(quantities.component(m, name, kinematics.moving(kinematics.still(now, (0, 1, 2)))))
    scale = max(1.0, abs(x.b), abs(x.c))
    assert x.a == pytest.approx(y[2], abs=1e-14)
    assert x.b == pytest.approx((y[0] - 8 * y[1] + 8 * y[3] - y[4]) / (12 * h), abs=1e-7 * scale)
    assert x.c == pytest.approx((-y[0] + 16 * y[1] - 30 * y[2] + 16 * y[3] - y[4]) / (12 * h * h), abs=1e-6 * scale)
