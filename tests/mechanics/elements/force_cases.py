"""One of every force, and states for them."""

import numpy as np

from lienumba.groups import so3
from lienumba.mechanics.mechanism.model import Coordinate, Force
from lienumba.numerics.operations import sin
from tests.facade import GROUND, Instant, Joint, Model
from tests.rigs.mechanisms import body, state

P = ((0.3, -0.2, 0.5), (-0.4, 0.1, 0.2))
CENTRES = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
START = so3.exp((0.3, -0.8, 0.4))
ANGLE, DISPLACEMENT = Coordinate(0, "angle"), Coordinate(0, "displacement")
VALUE = (1.5, -2.5, 3.5)
STIFF = {"stiffness": (30.0, 20.0, 10.0), "rotational_stiffness": (3.0, 2.0, 1.0)}
DAMPED = {"damping": (3.0, 2.0, 1.0), "rotational_damping": (0.3, 0.2, 0.1)}


def frame(seed):
    R = so3.exp(tuple(np.random.default_rng(seed).standard_normal(3)))
    return tuple((R[i], R[i + 3], R[i + 6]) for i in range(3))


CYLINDRICAL = Joint("j", "cylindrical", (0, 1), P, (frame(1), frame(2)))


def between(kind, ends=(0, 1), points=P, rest=(0.7,), **numbers):
    return Force("f", kind, ends, points, numbers=numbers, rest=rest)


def on(kind, at="global", i=1, **numbers):
    return Force("f", kind, (i,), () if kind == "torque" else P[:1], frame=at, numbers=numbers)


def along(kind, coordinate=ANGLE, **numbers):
    return Force("f", kind, (0, 1), coordinate=coordinate, numbers=numbers)


FORCES = {
    "spring": between("spring_damper", stiffness=40.0),
    "spring-damper": between("spring_damper", stiffness=40.0, damping=3.0),
    "spring-damper on the ground": between("spring_damper", (GROUND, 1), stiffness=40.0, damping=3.0),
    "spring that grows": between(
        "spring_damper", rest=None, free_length=lambda t: 0.7 + sin(t), stiffness=lambda t: 40.0 + t * t, damping=3.0
    ),
    "force": on("force", value=VALUE),
    "force in body axes": on("force", "body", value=VALUE),
    "force in time": on("force", value=(1.0, lambda t: sin(3.0 * t), 0.0)),
    "torque": on("torque", value=VALUE),
    "torque in body axes": on("torque", "body", value=VALUE),
    "torsion spring": along("torsion_spring", stiffness=4.0, free_angle=0.3),
    "torsion spring-damper": along("torsion_spring", stiffness=4.0, damping=0.5, free_angle=lambda t: 0.3 * t),
    "constant actuator": along("actuator", value=2.0),
    "servo": along("actuator", stiffness=4.0, damping=0.5, target=lambda t: sin(2.0 * t)),
    "servo along": along("actuator", DISPLACEMENT, stiffness=4.0, damping=0.5, target=1.0),
    "servo at its limit": along("actuator", DISPLACEMENT, stiffness=40.0, damping=0.5, target=9.0, limit=2.0),
    "friction": along("friction", viscous=0.4, coulomb=2.0, velocity=0.5),
    "friction along": along("friction", DISPLACEMENT, viscous=0.4, coulomb=2.0, velocity=0.5),
    "stop above": along("end_stop", DISPLACEMENT, stiffness=50.0, damping=2.0, upper=-5.0),
    "stop below": along("end_stop", DISPLACEMENT, stiffness=50.0, damping=2.0, lower=5.0, upper=6.0),
    "stop that moves": along("end_stop", DISPLACEMENT, stiffness=50.0, lower=lambda t: 5.0 + t),
    "stop out of reach": along("end_stop", DISPLACEMENT, stiffness=50.0, damping=2.0, lower=-50.0, upper=50.0),
    "bushing": between("bushing", rest=START, **STIFF),
    "bushing with damping": between("bushing", rest=START, **STIFF, **DAMPED),
    "bushing on the ground": between("bushing", (GROUND, 1), rest=START, **STIFF, **DAMPED),
    "bushing that hardens": between(
        "bushing", rest=START, stiffness=(lambda t: 5.0 * t, 1.0, 0.0), rotational_stiffness=(0.0, 0.0, lambda t: t + 1)
    ),
    "drag": on("drag", linear=2.0, quadratic=0.7),
    "attraction": between("point_mass_gravity", rest=None, mu=5.0),
    "planet": between("point_mass_gravity", (GROUND, 1), CENTRES, rest=None, mu=lambda t: 5.0 + t),
}  # fmt: skip
INTERNAL = [name for name, force in FORCES.items() if 0 in force.bodies]
SEEDS = [0, 1, 2]


def model(*every, joint=CYLINDRICAL, k=2):
    rng = np.random.default_rng(7)
    bodies = tuple(body(rng, f"b{i}") for i in range(k))
    return Model((0.0, 0.0, -9.81), bodies, () if joint is None else (joint,), (), every)


def instant(seed, t=0.4, k=2):
    return Instant(state(k, seed), t)


def velocities(now):
    return np.array([x[12:18] for x in now.bodies]).ravel()


def moved(now, u, h, dt=0.0):
    """The state after a time h of constant velocities u, the clock dt later."""
    every = []
    for x, v in zip(now.bodies, np.reshape(u, (-1, 6)), strict=True):
        R = so3.multiply(x[3:12], so3.exp(tuple(h * v[3:])))
        every.append((*(np.array(x[:3]) + h * v[:3]), *R, *x[12:18]))
    return Instant(tuple(every), now.t + dt, now.angles)
