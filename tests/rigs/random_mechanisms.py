"""Random mechanisms of all joints, drivers, rotors and forces, light bodies beside heavy ones, and states for them."""

from dataclasses import replace

import numpy as np

from lienumba.groups import so3
from lienumba.mechanics.elements import joints
from lienumba.mechanics.elements.joints import coordinate_kinds
from lienumba.mechanics.mechanism.kinematics import still
from lienumba.mechanics.mechanism.model import Coordinate, Driver, Force
from lienumba.numerics.expressions import Formula
from tests.facade import GROUND, JOINTS, Body, Instant, Joint, Model
from tests.rigs.mechanisms import vector

STRONG = ["spherical", "revolute", "universal", "cylindrical", "prismatic", "planar", "screw", "fixed"]
LOOSE = ["distance", "point_in_plane", "point_on_line", "perpendicular_axes", "parallel_axes", "spherical", "planar"]
NUMBERS = {"distance": lambda x: {"length": x}, "screw": lambda x: {"pitch": 3.0 * x, "offset": 0.4}}
TOPOLOGIES = ["tree", "loop", "star", "ladder"]
TURNING = [name for name, kind in JOINTS.items() if "angle" in kind.coordinate_kinds]


def ties(topology, rng):
    """How many bodies, and which of them are tied: the first ties make a tree, the others close loops."""
    k = int(rng.integers(2, 8))
    if topology == "tree":
        return k, [(int(rng.integers(GROUND, i)), i) for i in range(k)], []
    if topology == "loop":
        return k, [(i - 1, i) for i in range(k)], [(k - 1, GROUND), (0, k - 1)][: int(rng.integers(1, 3))]
    if topology == "star":
        return k, [(GROUND, 0), *((0, i) for i in range(1, k))], [(GROUND, k - 1)] if k > 3 else []
    rungs = k // 2
    sides = [(i - 2 if i > 1 else GROUND, i) for i in range(2 * rungs)]
    return 2 * rungs, sides, [(2 * i, 2 * i + 1) for i in range(rungs)]


def heavy_or_light(rng, name):
    """Four decades of masses; a body of about its own size."""
    X, mass = rng.standard_normal((3, 3)), 10.0 ** rng.uniform(-2.0, 2.0)
    J = 0.2 * mass * (X @ X.T + np.eye(3))
    return Body(name, mass, tuple(float(J[i]) for i in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))))


def frame(rng):
    R = so3.exp(vector(rng, 2.0))
    return tuple((R[i], R[i + 3], R[i + 6]) for i in range(3))


def joint(rng, name, kind, ends):
    number = float(rng.uniform(0.5, 2.0))
    return Joint(
        name, kind, tuple(int(i) for i in rng.permutation(ends)), (vector(rng), vector(rng)), (frame(rng), frame(rng)),
        numbers=NUMBERS.get(kind, lambda x: {})(number),
    )  # fmt: skip


def with_rotor(rng, x):
    """Some of the joints that may have one, a rotor of any weight."""
    return replace(x, armature=10.0 ** rng.uniform(-3.0, 1.0)) if JOINTS[x.type].rotor and rng.random() < 0.7 else x


def a_coordinate(rng, every, kinds=("angle", "displacement")):
    """A coordinate of one of the joints, or None."""
    found = [Coordinate(i, c) for i, j in enumerate(every) for c in coordinate_kinds(j.type) if c in kinds]
    return found[int(rng.integers(len(found)))] if found else None


def coupling(rng, name, every):
    """A gear between two different joints' coordinates, or None."""
    a, b = a_coordinate(rng, every), a_coordinate(rng, every)
    if a is None or a.joint == b.joint:
        return None
    ends = tuple(dict.fromkeys((*every[a.joint].bodies, *every[b.joint].bodies)))
    return Joint(
        name, "gear", ends, coordinates=(a, b), numbers={"ratio": float(rng.uniform(-2.0, 2.0)), "offset": 0.3}
    )


WAVES = ("0.3*sin(2*t) + 0.1*t**2", "cos(3*t) - t", "exp(-t)*tanh(t)", "1.5*t")
RATES = ("0.6*cos(2*t) + 0.2*t", "-3*sin(3*t) - 1", "exp(-t)*(1 - tanh(t) - tanh(t)**2)", "1.5")  # of these waves


def driver(rng, name, k, every):
    """A driver of any kind, or None; a rate is that of the wave of the same number."""
    i, n = int(rng.integers(k)), int(rng.integers(4))
    waves = tuple(Formula(x) for x in rng.choice(WAVES, 3))
    motion = rng.choice(["value", "rate", "rate", "point", "orientation", "angular_velocity", "angular_velocity"])
    if motion in ("value", "rate"):
        c = a_coordinate(rng, every)
        law = Formula((RATES if motion == "rate" else WAVES)[n])
        return c and Driver(name, motion, every[c.joint].bodies, (law,), c)
    at, point = rng.choice(["global", "body"]), vector(rng) if motion == "point" else None
    return Driver(name, str(motion), (i,), waves, point=point, frame=str(at))


def forces(rng, k, every):
    """A few forces: with and without potential, on bodies and along joints, constant and not."""
    wave, n = Formula(str(rng.choice(WAVES))), rng.uniform(0.2, 3.0, 6).tolist()
    a, b = (int(i) for i in rng.choice(np.arange(GROUND, k), 2, replace=False))
    points, R = (vector(rng), vector(rng)), so3.exp(vector(rng, 0.3))
    some = [
        Force(
            "spring", "spring_damper", (a, b), points, numbers={"stiffness": n[0], "damping": n[1], "free_length": wave}
        ),
        Force("push", "force", (max(a, b),), points[:1], frame="body", numbers={"value": (n[0], wave, -n[2])}),
        Force("twist", "torque", (max(a, b),), numbers={"value": (wave, n[1], n[2])}),
        Force("drag", "drag", (max(a, b),), points[:1], numbers={"linear": n[0], "quadratic": n[1]}),
        Force("planet", "point_mass_gravity", (a, b) if b != GROUND else (b, a), points, numbers={"mu": n[3]}),
        Force(
            "rubber",
            "bushing",
            (a, b),
            points,
            rest=R,
            numbers={"stiffness": (n[0], wave, n[1]), "damping": (n[2],) * 3},
        ),
    ]
    c, d = a_coordinate(rng, every), a_coordinate(rng, every, ("angle",))
    if c is not None:
        numbers = {"stiffness": n[0], "damping": n[1], "target": wave}
        some.append(Force("servo", "actuator", every[c.joint].bodies, coordinate=c, numbers=numbers))
        numbers = {"viscous": n[0], "coulomb": n[1], "velocity": n[2]}
        some.append(Force("brake", "friction", every[c.joint].bodies, coordinate=c, numbers=numbers))
    if d is not None:
        numbers = {"stiffness": n[4], "damping": n[5], "free_angle": wave}
        some.append(Force("coil", "torsion_spring", every[d.joint].bodies, coordinate=d, numbers=numbers))
    return tuple(some[i] for i in rng.permutation(len(some))[:4])


def state(rng, model):
    """Any positions and velocities, but no angle between axes that are nearly perpendicular: there it jumps."""
    turning = [j for j in model.joints if j.type in TURNING]

    def draw():
        k = len(model.bodies)
        return Instant(
            tuple(vector(rng, 1.5) + so3.exp(vector(rng, 1.5)) + vector(rng) + vector(rng) for _ in range(k))
        )

    def smooth(now):
        lengths = [1.0]
        for j in turning:
            a, b = (still(now, j.bodies)[i] for i in j.bodies)
            x = joints.direction(j, 1, b, joints.X)
            lengths.append(np.hypot(*(so3.dot(joints.direction(j, 0, a, axis), x) for axis in (joints.X, joints.Y))))
        return min(lengths)

    return max((draw() for _ in range(40)), key=smooth).bodies


def mechanism(topology, seed):
    """A model, and a state at random: the equations of motion hold off the constraints too."""
    rng = np.random.default_rng((TOPOLOGIES.index(topology), seed))
    k, tree, closing = ties(topology, rng)
    every = [joint(rng, f"j{n}", str(rng.choice(STRONG)), ends) for n, ends in enumerate(tree)]
    every += [joint(rng, f"c{n}", str(rng.choice(LOOSE)), ends) for n, ends in enumerate(closing)]
    extra = [coupling(rng, f"g{n}", every) for n in range(int(rng.integers(2)))]
    every = [with_rotor(np.random.default_rng((seed, n)), x) for n, x in enumerate(every)]
    drivers = [driver(rng, f"d{n}", k, every) for n in range(int(rng.integers(3)))]
    model = Model(
        (0.3, Formula("t - 0.2"), -9.81),
        tuple(heavy_or_light(rng, f"b{i}") for i in range(k)),
        (*every, *(x for x in extra if x)),
        tuple(x for x in drivers if x),
        forces(rng, k, every),
    )
    now = Instant(state(rng, model), float(rng.uniform(0.0, 2.0)))
    for i, j in enumerate(every):
        if j.type in TURNING:  # some turns on
            turns = 2.0 * np.pi * int(rng.integers(-2, 3))
            now.angles[i] = turns + joints.coordinate(model, Coordinate(i, "angle"), still(now, j.bodies))
    return model, now
