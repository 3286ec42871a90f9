"""Random mechanisms with switched constraints of all kinds, in random modes; and dense equations of those in use."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from lienumba.mechanics.elements.contacts import CONTACTS
from lienumba.mechanics.elements.joints import freedom
from lienumba.mechanics.mechanism.kinematics import Mode, still
from lienumba.mechanics.mechanism.model import Contact, Coordinate, Force, Limit, Lock
from lienumba.mechanics.system import constraints, dynamics
from lienumba.mechanics.system.switched import laws
from lienumba.mechanics.system.switches import BALL, CONTACT, FRICTION, JOINT, LOCK, Switch, switches_of
from lienumba.mechanics.tree.links import tree_of
from lienumba.mechanics.tree.posture import Posture
from lienumba.numerics.jets import lift
from tests.facade import GROUND, JOINTS, Instant, Model
from tests.rigs import random_trees
from tests.rigs.mechanisms import dense, vector

KINDS = ["revolute", "prismatic", "spherical", "cylindrical", "universal", "revolute"]
OFF, STICK, SLIDE = 0.0, 1.0, 2.0


@dataclass(frozen=True)
class Case:
    """A mechanism somewhere, how its switches are on, and which rows of C are in use."""

    model: Model
    posture: Posture
    mask: list[float]

    @property
    def now(self) -> Instant:
        return self.posture.now


def mechanism(seed: int, friction: bool = True, closing: int = 0, kinds: list[str] = KINDS) -> Model:
    """A tree of joints with locks, stops, contacts and friction that sticks; with friction at the contacts, too."""
    rng = np.random.default_rng(100 + seed)
    model = random_trees.tree(seed, kinds, closing=closing + 1)
    joints = [replace(j, switched=j.name == "c0") for j in model.joints]
    locks, limits, sticks = [], [], []
    for n, joint in enumerate(joints):
        names = tuple(x.name for x in JOINTS[joint.type].independent())
        if joint.type == "distance" or not names:
            continue
        locks.append(Lock(f"lock of {joint.name}", n, names))
        if joint.type != "spherical":
            for side in (1.0, -1.0):
                value = float(rng.standard_normal())
                limits.append(Limit(f"stop {side} of {joint.name}", Coordinate(n, names[0]), side, value, 0.3, 0.01))
        if joint.type in ("revolute", "prismatic"):
            numbers = {"viscous": 0.1, "coulomb": 0.4, "static": 0.7}
            sticks.append(
                Force(f"friction of {joint.name}", "friction", (), (), Coordinate(n, names[0]), numbers=numbers)
            )
    k = len(model.bodies)
    contacts = []
    for n, kind in enumerate(["point_plane", "sphere_plane", "sphere_sphere", "point_plane"]):
        a, b = rng.choice(np.arange(0 if n % 2 else GROUND, k), 2, replace=False)
        a, b = (b, a) if a == GROUND else (a, b)
        numbers = (
            {"radius": 0.2}
            if kind == "sphere_plane"
            else {"first_radius": 0.2, "second_radius": 0.3}
            if kind == "sphere_sphere"
            else {}
        )
        normal = vector(rng)
        normal = tuple(x / float(np.linalg.norm(normal)) for x in normal)
        mu = (0.7, 0.5) if friction and n < 3 else (0.0, 0.0)
        points: Any = (vector(rng), vector(rng))
        contacts.append(
            Contact(f"contact {n}", kind, (int(a), int(b)), points, normal, None, numbers, 0.4, mu[0], mu[1], 1e-3)
        )
    return replace(
        model, joints=tuple(joints), locks=tuple(locks), limits=tuple(limits), contacts=tuple(contacts),
        forces=(*model.forces, *sticks),
    )  # fmt: skip


def somewhere(model: Model, seed: int, on: bool = True) -> Case:
    """At random, with as many switches on at random as leave the rows in use independent."""
    rng = np.random.default_rng(200 + seed)
    model, posture = random_trees.posture(model, random_trees.state(rng, tree_of(model)))
    modes = {switch.key: Mode(OFF, _memory(model, switch, posture.now, rng)) for switch in switches_of(model)}
    mask = [1.0] * constraints.permanent_rows(model) + [0.0] * sum(s.rows for s in switches_of(model))
    C = dense(constraints.jacobian(model, replace(posture.now, modes=modes)), (len(mask), 6 * len(model.bodies)))
    for n in rng.permutation(len(switches_of(model))) if on else ():
        switch = switches_of(model)[n]
        how = float(rng.choice([OFF, STICK, SLIDE]))
        if switch.what in (JOINT, LOCK):
            how = min(how, STICK)
        elif not switch.tangents:
            how = SLIDE if how else OFF
        tried, first = list(mask), constraints.permanent_rows(model) + switch.first
        held = switch.rows - (switch.tangents if how == SLIDE else 0) if how else 0
        tried[first : first + held] = [1.0] * held
        used = C[[row for row, m in enumerate(tried) if m]]
        if np.linalg.svd(used.T, compute_uv=False)[len(used) - 1 :].max(initial=0.0) > 1e-2:
            mask = tried
            modes[switch.key] = modes[switch.key]._replace(on=how)
    return Case(model, replace(posture, modes=modes), mask)


def _memory(model: Model, switch: Switch, now: Instant, rng: np.random.Generator) -> tuple[float, ...]:
    if switch.what == LOCK:
        view = still(now, tuple(range(len(model.bodies))))
        kept = laws.measured(model, model.locks[switch.index], view)
        return tuple(kept) if switch.memories == 9 else tuple(x + 0.01 * float(rng.standard_normal()) for x in kept)
    if switch.what == CONTACT and switch.tangents:
        angle = float(rng.uniform(0.0, 6.28))
        d = float(np.cos(angle)), float(np.sin(angle))
        view, contact = still(now, tuple(range(len(model.bodies)))), model.contacts[switch.index]
        normal = CONTACTS[contact.type].place(contact, *(view[i] for i in contact.bodies)).normal
        moves = () if contact.normal is not None else (1.0 if float(lift(normal[2]).a) >= 0.0 else -1.0,)
        # however what sticks grips: it changes nothing where nothing else says the same
        grip = np.random.default_rng(switch.first).uniform([-0.6, -0.6, 0.1], [0.6, 0.6, 1.0])
        return (*d, *moves, *(grip.tolist() if switch.compliant else ()))
    return (float(rng.choice([-1.0, 1.0])),) * switch.memories


def parts(case: Case) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """M, C, Q and xi, dense."""
    model, now, n = case.model, case.now, 6 * len(case.model.bodies)
    M = dense(dynamics.mass_matrix(model, now), (n, n))
    xi = np.array(constraints.required(model, now), float)
    C = dense(constraints.jacobian(model, now), (len(xi), n))
    return M + np.tril(M, -1).T, C, np.array(dynamics.loads(model, now), float), xi


def friction(case: Case) -> np.ndarray:
    """T of lambda = T lambda*, from the definition of Coulomb's law."""
    T = np.eye(len(case.mask))
    w = np.array(constraints.rates(case.model, case.now), float)
    for switch in switches_of(case.model):
        mode = case.now.modes[switch.key]
        if switch.what == CONTACT and switch.tangents and mode.on == SLIDE:
            n = constraints.permanent_rows(case.model) + switch.first
            along = w[n + 1 : n + 3]
            d = along / np.linalg.norm(along)
            d = d if along @ np.array(mode.memory[:2]) >= 0.0 else -d
            T[n + 1 : n + 3, n] = -case.model.contacts[switch.index].kinetic * d
    return T


def exact(case: Case) -> tuple[np.ndarray, np.ndarray]:
    """v', w' of all bodies and all multipliers: all equations in use at once."""
    M, C, Q, xi = parts(case)
    used = [row for row, m in enumerate(case.mask) if m]
    T, n = friction(case), len(M)
    K = np.block([[M, C.T @ T[:, used]], [C[used], np.zeros((len(used), len(used)))]])
    x = np.linalg.solve(K, np.concatenate([Q, xi[used]]))
    return x[:n], T[:, used] @ x[n:]


__all__ = ["BALL", "FRICTION", "Case", "exact", "freedom", "friction", "mechanism", "parts", "somewhere"]
