"""Rotors of joints: a/2 rate^2 of kinetic energy each, with the rate c.v + c_t of the joint's own coordinate.

To the equations of motion a rotor gives a c c^T, which couples the two bodies, and -a c times the bias of the rate. An
angle is measured by what each body turns about its own axis: where the axes are parallel this is its rate, and its c is
constant in the frames of the bodies. (What it differs by elsewhere is a combination of the joint's own rows.)
"""

from typing import Any, NamedTuple

from lienumba.mechanics.elements.joints import JOINTS, coordinate, rate_of_turning
from lienumba.mechanics.mechanism import kinematics
from lienumba.mechanics.mechanism.kinematics import Instant, View
from lienumba.mechanics.mechanism.model import GROUND, Coordinate, Model
from lienumba.numerics.jets import lift
from lienumba.numerics.number import Number
from lienumba.numerics.operations import is_zero, sqrt

Entries = dict[tuple[int, int], Any]


class Rotor(NamedTuple):
    """The rotor of a joint (index)."""

    model: Model
    joint: int

    @property
    def inertia(self) -> Number:
        """In kg m^2 of an angle, kg of a displacement."""
        return self.model.joints[self.joint].armature

    @property
    def bodies(self) -> tuple[int, ...]:
        """The bodies that the rotor couples."""
        return tuple(i for i in self.model.joints[self.joint].bodies if i != GROUND)

    @property
    def kind(self) -> str:
        """The kind of the coordinate with whose rate the rotor turns."""
        return JOINTS[self.model.joints[self.joint].type].rotor

    @property
    def constant(self) -> bool:
        """Whether c is, in the frames of the bodies."""
        return self.kind == "angle"

    def law(self, view: View) -> tuple[Any, ...]:
        """The rate of an angle, from velocities; or the displacement, from positions."""
        if self.constant:
            joint = self.model.joints[self.joint]
            return (rate_of_turning(joint, *(view[i] for i in joint.bodies)),)
        return (coordinate(self.model, Coordinate(self.joint, self.kind), view),)

    def row(self, now: Instant) -> dict[int, Any]:
        """c: the entries that are not exactly zero, by column; body i owns 6 i to 6 i + 5."""
        found: dict[int, Any] = {}
        view = kinematics.still(now, self.model.joints[self.joint].bodies)
        for i in self.bodies:
            (values,) = kinematics.columns(self.law, view, i, self.constant)
            found |= {6 * i + n: x for n, x in enumerate(values) if not is_zero(x)}
        return found

    def rate_and_bias(self, now: Instant) -> tuple[Any, Any]:
        """The rate (rad/s or m/s), and its derivative at constant velocities."""
        view = kinematics.moving(kinematics.still(now, self.model.joints[self.joint].bodies))
        x = lift(self.law(view)[0])
        return (x.a, x.b) if self.constant else (x.b, x.c)


def rotors_of(model: Model) -> list[Rotor]:
    """The rotors of all joints."""
    return [Rotor(model, j) for j, joint in enumerate(model.joints) if not is_zero(joint.armature)]


def mass(model: Model, now: Instant) -> Entries:
    """The sum of all a c c^T, its lower entries."""
    entries: Entries = {}
    for rotor in rotors_of(model):
        row = sorted(rotor.row(now).items())
        for n, (i, x) in enumerate(row):
            for j, y in row[: n + 1]:
                entries[i, j] = entries.get((i, j), 0.0) + rotor.inertia * (x * y)
    return entries


def loads(model: Model, now: Instant) -> dict[int, Any]:
    """The sum of all -a c bias, by column."""
    total: dict[int, Any] = {}
    for rotor in rotors_of(model):
        _, bias = rotor.rate_and_bias(now)
        if not is_zero(bias):
            for i, x in rotor.row(now).items():
                total[i] = total.get(i, 0.0) - rotor.inertia * (x * bias)
    return total


def energy(model: Model, now: Instant) -> Any:
    """The sum of all a/2 rate^2 (J)."""
    total: Any = 0.0
    for rotor in rotors_of(model):
        rate, _ = rotor.rate_and_bias(now)
        total = total + 0.5 * (rotor.inertia * (rate * rate))
    return total


def roots(model: Model, now: Instant) -> list[dict[int, Any]]:
    """Of every rotor sqrt(a) c: their squares are the kinetic energy of changes of velocities."""
    return [{i: sqrt(rotor.inertia) * x for i, x in rotor.row(now).items()} for rotor in rotors_of(model)]
