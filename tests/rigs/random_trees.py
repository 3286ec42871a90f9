"""Random trees of all joints that have moves, at states that fulfil these joints; and dense equations of motion."""

from dataclasses import replace
from typing import Any

import numpy as np

from lienumba.mechanics.mechanism.kinematics import still
from lienumba.mechanics.mechanism.model import Coordinate
from lienumba.mechanics.mechanism.moves import Ball, Free, Turn, Wind
from lienumba.mechanics.system import constraints, dynamics
from lienumba.mechanics.tree.links import PINS, Tree, tree_of
from lienumba.mechanics.tree.posture import Posture
from lienumba.numerics.expressions import Formula
from tests.facade import GROUND, JOINTS, Body, Instant, Joint, Model
from tests.rigs import random_mechanisms as any_mechanism
from tests.rigs.mechanisms import body, dense, vector

MOVING = [name for name, kind in JOINTS.items() if kind.moves is not None]
NO_MASS = (0.0,) * 6


def joint(rng: np.random.Generator, name: str, kind: str, ends: tuple[int, int]) -> Joint:
    """Its bodies in any order, its axes along each other or against."""
    made: Joint = any_mechanism.joint(rng, name, kind, ends)
    if not JOINTS[kind].sides:
        return replace(made, frames=None)
    parallel = JOINTS[kind].moves not in (None, PINS)
    return replace(made, way=float(rng.choice([-1.0, 1.0])) if parallel else 1.0)


def state(rng: np.random.Generator, tree: Tree) -> list[float]:
    """Of all moves, at random."""
    z: list[float] = []
    for link in tree.links:
        move = link.move
        place = vector(rng, 0.7)[: move.places]
        if isinstance(move, Ball):
            place = any_rotation(rng)
        elif isinstance(move, Free):
            place = (*vector(rng), *any_rotation(rng))
        elif isinstance(move, Turn):
            angle = float(rng.uniform(-3.0, 3.0))
            place = (np.cos(angle), np.sin(angle), *([0.3] if isinstance(move, Wind) else []))
        z += [float(x) for x in (*place, *(rng.standard_normal(move.freedoms)))]
    return z


def any_rotation(rng: np.random.Generator) -> tuple[float, ...]:
    columns = any_mechanism.frame(rng)
    return tuple(columns[c][r] for r in range(3) for c in range(3))


def settled(model: Model, now: Instant) -> Model:
    """With the offsets of screws as they are here, and the angles of `now` their principal ones."""
    every = list(model.joints)
    for n, x in enumerate(every):
        if "offset" in x.numbers and x.type != "gear":
            own = JOINTS[x.type].at_start(model, n, still(now, x.bodies))
            every[n] = replace(x, numbers=x.numbers | own)
    return replace(model, joints=tuple(every))


def posture(model: Model, z: list[float], t: float = 0.0, waiting: int = 0) -> tuple[Model, Posture]:
    """The model with its offsets, and where the state puts it."""
    tree = tree_of(model)
    now = Posture(model, tree, z, t).now
    for i, x in enumerate(model.joints):
        if x.type in any_mechanism.TURNING:
            now.angles[i] = _angle(model, i, now)
    model = settled(model, now)
    return model, Posture(model, tree, z, t, now.angles, waiting=waiting)


def _angle(model: Model, i: int, now: Instant) -> float:
    return float(any_mechanism.joints.coordinate(model, Coordinate(i, "angle"), still(now, model.joints[i].bodies)))


def tree(seed: int, kinds: list[str] | None = None, closing: int = 0, drivers: int = 0, forces: bool = True) -> Model:
    """Bodies on each other or on the ground by joints of these kinds, None of a body that flies; rods and planes that
    close loops, drivers, forces."""
    rng = np.random.default_rng(seed)
    chosen: list[Any] = list(kinds or rng.choice([*MOVING, None], int(rng.integers(3, 8))))
    bodies, joints = [], []
    for i, kind in enumerate(chosen):
        bodies.append(body(rng, f"b{i}"))
        if kind is not None:
            made = joint(rng, f"j{i}", str(kind), (int(rng.integers(GROUND, i)), i))
            joints.append(any_mechanism.with_rotor(rng, made))
    for n in range(closing):
        a, b = rng.choice(np.arange(GROUND, len(bodies)), 2, replace=False)
        joints.append(joint(rng, f"c{n}", str(rng.choice(["distance", "point_in_plane"])), (int(a), int(b))))
    order = [int(i) for i in rng.permutation(len(joints))]
    every = [joints[i] for i in order]
    made_drivers = [any_mechanism.driver(rng, f"d{n}", len(bodies), every) for n in range(drivers)]
    gravity = (0.3, Formula("t - 0.2"), -9.81)
    acting = any_mechanism.forces(rng, len(bodies), every) if forces else ()
    return Model(gravity, tuple(bodies), tuple(every), tuple(d for d in made_drivers if d), acting)


def without_mass(model: Model, names: set[str]) -> Model:
    """These bodies weigh nothing."""
    lighter = (Body(b.name, 0.0, NO_MASS) if b.name in names else b for b in model.bodies)
    return replace(model, bodies=tuple(lighter))


def exact(model: Model, now: Instant) -> tuple[np.ndarray, np.ndarray]:
    """v', w' of all bodies and the multipliers of least norm: all equations at once, in absolute coordinates."""
    n, C = 6 * len(model.bodies), constraints.jacobian(model, now)
    xi = np.array(constraints.required(model, now), float)
    M = dense(dynamics.mass_matrix(model, now), (n, n))
    K = np.zeros((n + len(xi),) * 2)
    K[:n, :n] = M + np.tril(M, -1).T
    K[n:, :n] = dense(C, (len(xi), n))
    K[:n, n:] = K[n:, :n].T
    x = np.linalg.lstsq(K, np.concatenate([np.array(dynamics.loads(model, now), float), xi]), rcond=1e-13)[0]
    return x[:n], x[n:]


def close(found: Any, expected: Any, bound: float = 1e-11) -> None:
    """To a bound relative to the largest."""
    expected = np.asarray(expected, float)
    scale = max(1.0, float(np.abs(expected).max(initial=0.0)))
    np.testing.assert_allclose(np.asarray(found, float), expected, rtol=0.0, atol=bound * scale)
