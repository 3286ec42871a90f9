"""What force laws do to the bodies: generalised forces, potential energy and power, all derived from the laws.

With J the derivative of the coordinates' rates by v (global) and w (body
frame), the rates are J u and the generalised forces J^T effort; the conservative effort is -dV/dc, and at rest the
potential changes by dV/dt: both by jets.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

from lienumba.mechanics.elements import user_laws
from lienumba.mechanics.elements.forces import law_of
from lienumba.mechanics.elements.forces.base import ForceLaw, Given
from lienumba.mechanics.elements.joints import coordinate_kinds
from lienumba.mechanics.elements.quantities import bodies_of
from lienumba.mechanics.mechanism import kinematics
from lienumba.mechanics.mechanism.kinematics import Instant
from lienumba.mechanics.mechanism.model import GROUND, Force, Model
from lienumba.numerics.jets import Jet, lift
from lienumba.numerics.number import Number, Vector


class _Acting(NamedTuple):
    """A force at an instant: J by body (rows x 6), and along each row the rate and the effort by its two causes."""

    J: dict[int, list[list[Any]]]
    rates: tuple[Any, ...]
    conservative: tuple[Any, ...]
    other: tuple[Any, ...]


def generalized(model: Model, now: Instant, forces: Iterable[Force] | None = None) -> list[Any]:
    """Q of force laws (all of the model, or these), 6 rows per body: force (N, global frame), torque about the mass
    centre (N m, body frame)."""
    Q: list[Any] = [0.0] * (6 * len(model.bodies))
    for force in model.forces if forces is None else forces:
        if force.code is not None:
            for i, own in user_laws.generalized(model, force, now)[0].items():
                Q[6 * i : 6 * i + 6] = [a + b for a, b in zip(Q[6 * i : 6 * i + 6], own, strict=True)]
            continue
        acting = _acting(model, force, now)
        for i, rows in acting.J.items():
            for row, a, b in zip(rows, acting.conservative, acting.other, strict=True):
                effort = a + b
                for n, x in enumerate(row):
                    Q[6 * i + n] = Q[6 * i + n] + x * effort
    return Q


def effort(model: Model, force: Force, now: Instant, rate: Number) -> Any:
    """Of a force along the coordinate of a joint (N or N m), where the coordinate's rate is known."""
    kind, given = law_of(force), _given(model, force, now)
    (c,) = kind.coordinates(given, given.view)
    conservative, other = _efforts(kind, given, (c,), (rate,))
    return conservative[0] + other[0]


def potential(model: Model, now: Instant) -> Any:
    """The potential energy (J) of springs, stops, bushings and attractions, and of laws that return it."""
    total: Any = 0.0
    for force in model.forces:
        if force.code is not None:
            ends = user_laws.ends_of(model, force.code, force.bodies, force.numbers)
            if force.code.returns == user_laws.POTENTIAL:
                total = total + user_laws.energy(model, force, now, kinematics.still(now, ends))
            continue
        kind, given = law_of(force), _given(model, force, now)
        if kind.has_potential():
            total = total + kind.potential(given, kind.coordinates(given, given.view))
    return total


def power(model: Model, now: Instant) -> Any:
    """What changes kinetic plus potential energy (W): efforts without a potential, and potentials that vary in time."""
    total: Any = 0.0
    for force in model.forces:
        if force.code is not None:
            total = total + user_laws.generalized(model, force, now)[1]
            continue
        acting = _acting(model, force, now)
        for rate, effort in zip(acting.rates, acting.other, strict=True):
            total = total + rate * effort
        kind, given = law_of(force), _given(model, force, now)
        if kind.has_potential():
            later = replace(given, view=kinematics.moving(given.view))
            total = total + lift(kind.potential(later, kind.coordinates(given, given.view))).b
    return total


def angle_joints(model: Model) -> set[int]:
    """The joints (indices) whose angle matters to a force over several turns; a rate alone does not."""
    stiff = {
        force.coordinate.joint
        for force in model.forces
        if force.coordinate is not None and force.coordinate.kind == "angle" and law_of(force).reads_angle(force)
    }
    seen = {j for force in model.forces if force.code is not None for j in force.code.joints}
    return stiff | {j for j in seen if "angle" in coordinate_kinds(model.joints[j].type)}


def _ends(model: Model, force: Force) -> tuple[int, ...]:
    ends = force.bodies if force.coordinate is None else model.joints[force.coordinate.joint].bodies
    return tuple(dict.fromkeys(ends))


def _given(model: Model, force: Force, now: Instant) -> Given:
    numbers = [y for x in force.numbers.values() for y in (x if isinstance(x, tuple) else (x,))]
    return Given(model, force, kinematics.still(now, (*_ends(model, force), *bodies_of(model, *numbers))))


def _acting(model: Model, force: Force, now: Instant) -> _Acting:
    kind, given, ends = law_of(force), _given(model, force, now), _ends(model, force)
    law = partial(kind.coordinates, given)
    c = law(given.view)
    J = {i: kinematics.columns(law, kinematics.still(now, ends), i, kind.velocity_level) for i in ends if i != GROUND}
    rates: tuple[Any, ...] = (0.0,) * len(c)
    for i, rows in J.items():
        velocity = now.bodies[i][12:18]
        rates = tuple(_plus_dot(rate, row, velocity) for rate, row in zip(rates, rows, strict=True))
    return _Acting(J, rates, *_efforts(kind, given, c, rates))


def _efforts(kind: type[ForceLaw], given: Given, c: Vector, rates: Vector) -> tuple[Vector, Vector]:
    """Along every coordinate, those that have a potential, and the others."""
    conservative = tuple(_slopes(kind, given, c)) if kind.has_potential() else (0.0,) * len(c)
    other = kind.effort(given, c, rates, conservative) if kind.has_effort() else (0.0,) * len(c)
    return conservative, other


def _plus_dot(start: Number, a: Sequence[Number], b: Sequence[Number]) -> Any:
    for x, y in zip(a, b, strict=True):
        start = start + x * y
    return start


def _slopes(kind: type[ForceLaw], given: Given, c: Vector) -> Iterator[Any]:
    """-dV/dc along every coordinate."""
    for n, x in enumerate(c):
        yield -lift(kind.potential(given, (*c[:n], Jet(x, 1.0), *c[n + 1 :]))).b
