"""Force laws where they end: no length, no speed, limits, turns; and on every kind of number."""

from dataclasses import replace
from math import nan

import numpy as np
import pytest

import lienumba
from lienumba.compiler.emit import Kernel
from lienumba.compiler.rows import W
from lienumba.compiler.symbols import Graph
from lienumba.groups import so3
from lienumba.mechanics.mechanism.model import Force
from lienumba.mechanics.mechanism.model_numbers import map_numbers
from lienumba.mechanics.system import applied_forces
from lienumba.numerics.jets import Jet
from lienumba.numerics.operations import cos
from tests.compiler.evaluation import call
from tests.facade import GROUND, Instant, Joint
from tests.mechanics.elements.force_cases import (
    ANGLE,
    CENTRES,
    CYLINDRICAL,
    DAMPED,
    DISPLACEMENT,
    FORCES,
    START,
    STIFF,
    along,
    between,
    instant,
    model,
)  # fmt: skip


def at_rest(*places):
    return Instant(tuple((*r, *so3.IDENTITY, *(0.0,) * 6) for r in places))


def test_a_spring_of_no_length_is_linear():
    force = between("spring_damper", points=CENTRES, rest=(0.0,), stiffness=40.0, damping=3.0)
    for d in (0.0, 1e-14, 1e-8, 1.0):
        Q = applied_forces.generalized(model(force), at_rest((0.0, 0.0, 0.0), (d, -2.0 * d, 0.0)))
        assert Q[6:9] == pytest.approx([-40.0 * d, 80.0 * d, 0.0], rel=1e-14)


@pytest.mark.parametrize("speed", [0.0, 1e-15])
@pytest.mark.parametrize("method", ["taylor", "radau3"])
def test_quadratic_drag_from_rest(method, speed):
    """A fall: v = u tanh(g t/u), u^2 = m g/c; of the root of what is 0 there is no derivative."""
    drop = {"name": "drop", "mass": 2.0, "inertia": [1, 1, 1], "position": [0, 0, 0], "velocity": [0, 0, speed]}
    drag = {"name": "air", "type": "drag", "body": "drop", "point": [0, 0, 0], "linear": 0, "quadratic": 0.5}
    data = {
        "title": "A drop",
        "model": {"gravity": [0, 0, -9.81], "bodies": [drop], "forces": [drag]},
        "integrator": {"method": method, "tolerance": 1e-7, "end_time": 1.0},
        "output": {"times": [0, 1.0]},
    }
    ds = lienumba.run(data)
    limit = (2.0 * 9.81 / 0.5) ** 0.5
    assert float(ds.velocity[0, -1, 0, 2]) == pytest.approx(-limit * np.tanh(9.81 / limit), rel=1e-6)


@pytest.mark.parametrize(
    "force",
    [
        between("spring_damper", points=CENTRES, stiffness=40.0, damping=3.0),
        between("bushing", points=CENTRES, rest=so3.IDENTITY, **STIFF, **DAMPED),
    ],
)
def test_coincident_points_are_no_trouble(force):
    now = Instant(tuple((0.0, 0.0, 0.0, *so3.IDENTITY, *v) for v in ((1.0,) * 6, (-1.0,) * 6)))
    m = model(force)
    every = [*applied_forces.generalized(m, now), applied_forces.potential(m, now), applied_forces.power(m, now)]
    assert np.isfinite(every).all()
    assert applied_forces.power(m, now) <= 0.0


def test_a_bushing_at_its_start_damps_and_springs_back():
    """At no rotation the rotation vector turns as fast as the body."""
    m = model(between("bushing", (GROUND, 1), CENTRES, so3.IDENTITY, **STIFF, **DAMPED))
    spinning = (0.0,) * 3 + so3.IDENTITY + (1.0, 2.0, 3.0, 4.0, 5.0, 6.0)
    Q = applied_forces.generalized(m, Instant((spinning, spinning)))
    assert Q[6:] == pytest.approx([-3.0, -4.0, -3.0, -1.2, -1.0, -0.6], rel=1e-15)
    for angle in (1e-300, 1e-160, 1e-12, 1e-5):
        turned = (0.0,) * 3 + so3.exp((angle, 0.0, 0.0)) + (0.0,) * 6
        assert applied_forces.generalized(m, Instant((turned, turned)))[9] == pytest.approx(-3.0 * angle, rel=1e-9)


@pytest.mark.parametrize("angle", [0.0, 1e-200, 1e-9, 1e-3, 1.0, 3.0])
def test_the_logarithm_has_its_slope_everywhere(angle):
    """d/dt log(exp(u) exp(t w)) = dexpinv(-u, w)."""
    u, w = (0.6 * angle, 0.0, 0.8 * angle), (0.3, -1.2, 0.7)
    R = so3.exp(u)
    rate = so3.multiply(R, so3.hat(w))
    slopes = [x.b for x in so3.log(tuple(Jet(a, b) for a, b in zip(R, rate, strict=True)))]
    assert slopes == pytest.approx(so3.dexpinv(so3.scale(-1.0, u), w), rel=1e-12, abs=1e-12)


def test_drag_at_no_speed_is_nothing():
    Q = applied_forces.generalized(model(FORCES["drag"]), at_rest((0.0,) * 3, (0.0,) * 3))
    np.testing.assert_array_equal(Q, np.zeros(12))


def turning(angle, rate=0.0, shift=0.0, speed=0.0):
    """A body on a cylindrical joint with the ground about z, turned and displaced."""
    x = (0.0, 0.0, shift, *so3.exp((0.0, 0.0, angle)), 0.0, 0.0, speed, 0.0, 0.0, rate)
    return Instant((x,), 0.0, {0: angle})


UPRIGHT = Joint("j", "cylindrical", (GROUND, 0), CENTRES, (((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),) * 2)


def effort(now, kind, coordinate=ANGLE, **numbers):
    """Torque about z or force along z."""
    force = Force("f", kind, (GROUND, 0), coordinate=coordinate, numbers=numbers)
    Q = applied_forces.generalized(model(force, joint=UPRIGHT, k=1), now)
    return Q[5 if coordinate is ANGLE else 2]


@pytest.mark.parametrize("angle", [-40.0, -3.2, 0.5, 3.2, 7.0, 100.0])
def test_a_torsion_spring_counts_turns(angle):
    assert effort(turning(angle), "torsion_spring", stiffness=2.0, free_angle=0.5) == pytest.approx(
        -2.0 * (angle - 0.5)
    )


def test_an_actuator_saturates():
    servo = {"stiffness": 10.0, "target": 1.0, "limit": 3.0}
    for angle, expected in ((0.9, 1.0), (0.0, 3.0), (3.0, -3.0)):
        assert effort(turning(angle), "actuator", **servo) == pytest.approx(expected)
    assert np.isnan(effort(turning(nan), "actuator", **servo))


def test_a_servo_follows_the_rate_of_its_target():
    now = replace(turning(0.3, rate=0.2), t=0.5)
    f = effort(now, "actuator", stiffness=10.0, damping=2.0, target=lambda t: 0.3 * cos(2.0 * t))
    assert f == pytest.approx(10.0 * (0.3 * np.cos(1.0) - 0.3) + 2.0 * (-0.6 * np.sin(1.0) - 0.2), rel=1e-12)


def test_a_stop_never_pulls():
    stop = {"stiffness": 100.0, "damping": 5.0, "lower": -0.2, "upper": 0.5}
    for shift, speed, expected in [
        (0.6, 0.0, -10.0),
        (0.6, 1.0, -15.0),
        (0.6, -1.0, -5.0),
        (0.6, -9.0, 0.0),  # leaves faster than the spring follows
        (0.4, 9.0, 0.0),
        (-0.3, 0.0, 10.0),
        (-0.3, -1.0, 15.0),
        (-0.3, 9.0, 0.0),
    ]:
        assert effort(turning(0.0, 0.0, shift, speed), "end_stop", DISPLACEMENT, **stop) == pytest.approx(expected)


def test_coulomb_friction_is_bounded():
    assert effort(turning(0.0, rate=5.0), "friction", coulomb=2.0) == pytest.approx(-2.0)
    assert effort(turning(0.0, rate=-1e-9), "friction", coulomb=2.0) == pytest.approx(2e-6)


def test_only_forces_that_read_an_angle_need_its_turns():
    assert applied_forces.angle_joints(
        model(along("torsion_spring", stiffness=1.0), along("friction", viscous=1.0))
    ) == {0}
    for force in (
        along("friction", viscous=1.0),
        along("actuator", value=1.0),
        along("torsion_spring", damping=1.0),
        along("end_stop", DISPLACEMENT, stiffness=1.0, lower=0.0),
        FORCES["spring"],
    ):
        assert applied_forces.angle_joints(model(force)) == set()


# ---------------------------------------------------------------- every kind of number
def every_result(m, now):
    return [*applied_forces.generalized(m, now), applied_forces.potential(m, now), applied_forces.power(m, now)]


@pytest.mark.parametrize("name", FORCES)
def test_arrays_give_what_floats_give(name):
    m = model(FORCES[name])
    alone = np.array([every_result(m, instant(seed)) for seed in range(4)]).T
    bodies = np.moveaxis(np.array([instant(seed).bodies for seed in range(4)]), 0, -1)
    with np.errstate(all="ignore"):
        together = every_result(m, Instant(tuple(tuple(x) for x in bodies), 0.4))
    np.testing.assert_allclose([np.broadcast_to(x, (4,)) for x in together], alone, rtol=1e-12, atol=1e-11)


@pytest.mark.parametrize("name", FORCES)
def test_kernels_give_what_floats_give(name):
    m = model(FORCES[name])
    graph, values = Graph(), []

    def parameter(x, structural):
        if structural and x in (0, 1, -1):
            return float(x)
        values.append(x)
        return graph.input("parameters", len(values) - 1)

    template = map_numbers(m, parameter)
    now = Instant(tuple(graph.inputs("state", 18, 18 * i) for i in range(2)), graph.input("clock", 0))
    kernel = Kernel("forces", tuple(every_result(template, now)), len(values))
    states = np.array([np.array(instant(seed).bodies).ravel() for seed in range(W)]).T
    parameters = np.repeat(np.array(values, float)[:, None], W, axis=1)
    result = call(kernel, state=states, parameters=parameters, clock=np.full((1, W), 0.4))
    alone = np.array([every_result(m, instant(seed)) for seed in range(W)]).T
    np.testing.assert_allclose(result, alone, rtol=1e-11, atol=1e-10)


def operations(*every, joint=None, of=applied_forces.generalized):
    """The operations of a kernel of this function, per evaluation."""
    graph = Graph()
    rows = iter(range(1000))
    m = map_numbers(
        model(*every, joint=joint),
        lambda x, structural: x if structural and x in (0, 1, -1) else graph.input("parameters", next(rows)),
    )
    now = Instant(tuple(graph.inputs("state", 18, 18 * i) for i in range(2)), graph.input("clock", 0))
    result = of(m, now)
    outputs = tuple(result) if isinstance(result, list) else (result,)
    return Kernel("forces", outputs, 1000).counts()["operations"]


def test_what_is_not_used_costs_nothing():
    spring, damped = FORCES["spring"], FORCES["spring-damper"]
    assert operations(damped) < 130  # about what is needed by hand
    assert operations(spring) < operations(damped)
    none = replace(spring, numbers={"stiffness": 40.0, "damping": 0.0})
    assert operations(none) == operations(spring)
    assert operations(none, of=applied_forces.power) == 0
    assert operations(replace(spring, numbers={}), of=applied_forces.generalized) == 0
    assert operations(along("actuator", value=0.0), joint=CYLINDRICAL) == 0
    assert operations(along("end_stop", stiffness=9.0, lower=0.0), joint=CYLINDRICAL, of=applied_forces.power) == 0
    linear = between("bushing", rest=START, stiffness=(1.5, 2.5, 3.5), rotational_stiffness=(0.0, 0.0, 0.0))
    assert operations(linear) < operations(between("bushing", rest=START, **STIFF)) / 2
