"""Quantities of what a run may turn on and off: contacts, limits, locks; and how far two points are apart."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, ClassVar, Literal

from pydantic import Field

from lienumba.groups import so3
from lienumba.keys.conversions import vec3
from lienumba.keys.types import ZERO, Two
from lienumba.mechanics.elements import joints
from lienumba.mechanics.elements.contacts import CONTACTS, yielding
from lienumba.mechanics.elements.locks import BALL, chosen, lockable
from lienumba.mechanics.elements.names import Names
from lienumba.mechanics.elements.quantities.base import (
    OBSERVED,
    POSITION,
    QUANTITIES,
    VELOCITY,
    Observed,
    Part,
    QuantityType,
    name_of,
)
from lienumba.mechanics.mechanism import kinematics
from lienumba.mechanics.mechanism.kinematics import OFF, Mode, View
from lienumba.mechanics.mechanism.model import GROUND, Contact, Coordinate, Force, Model, Quantity
from lienumba.numerics.jets import Jet, lift
from lienumba.numerics.number import Number, Vector
from lienumba.numerics.operations import maximum, minimum, sqrt, where

SQUARE_FLOOR = 1e-200  # so that a distance of zero has a rate
CONTACT, LIMIT, LOCK = "contact", "limit", "lock"  # as modes call them, too


def _length(rows: Sequence[Number]) -> Number:
    square: Number = 0.0
    for x in rows:
        square = square + x * x
    length: Number = sqrt(square)
    return length


def _on(view: View, what: str, name: str, on: Number = 1.0, off: Number = 0.0) -> Number:
    """One of two numbers: whether it is closed, or holds."""
    found: Number = where(view.modes.get((what, name), Mode()).on > OFF, on, off)
    return found


@QUANTITIES.add
class Distance(QuantityType):
    """How far two points are apart."""

    singular: ClassVar[tuple[str, ...]] = ("distance",)

    type: Literal["distance"]
    bodies: list[str] = name_of(
        "bodies", "ground", description='the names of the two bodies, or "ground"', min_length=2, max_length=2
    )
    points: Two = Field(
        default=[ZERO, ZERO], description="two points in m, each with 3 numbers in the frame of its own body"
    )

    @classmethod
    def level(cls, quantity: Quantity, component: str) -> int:
        return POSITION if component == "distance" else VELOCITY

    @classmethod
    def parts(cls, model: Model, quantity: Quantity) -> tuple[Part, ...]:
        return (
            Part("distance", "m", "distance of two points"),
            Part("speed", "m s-1", "rate of the distance of two points"),
        )

    @classmethod
    def rows(cls, model: Model, quantity: Quantity, view: View, observed: Observed | None) -> Vector:
        def apart(at: View) -> Number:
            first, second = (at[i].point(p) for i, p in zip(quantity.bodies, quantity.points, strict=True))
            d = so3.subtract(second, first)
            distance: Number = sqrt(so3.dot(d, d) + SQUARE_FLOOR)
            return distance

        return apart(view), lift(apart(kinematics.moving(view))).b

    def to_model(self, names: Names) -> Quantity:
        bodies = tuple(names.bodies[name] for name in self.bodies)
        first, second = map(vec3, self.points)
        return Quantity(self.name, self.type, bodies, points=(first, second))


@QUANTITIES.add
class ContactQuantity(QuantityType):
    """Where two bodies may touch; of several points the nearest, the fastest, and the sum of all."""

    type: Literal["contact"]
    contact: str = name_of("contacts", description="the name of the contact")

    @classmethod
    def level(cls, quantity: Quantity, component: str) -> int:
        return {"gap": POSITION, "slip": VELOCITY}.get(component, OBSERVED)

    @classmethod
    def parts(cls, model: Model, quantity: Quantity) -> tuple[Part, ...]:
        of = f"of the contact {quantity.of}"
        return (
            Part("gap", "m", f"gap {of}"),
            Part("slip", "m s-1", f"sliding speed {of}"),
            Part("normal", "N", f"normal force {of}"),
            Part("friction", "N", f"size of the friction {of}"),
            Part("on", "1", f"whether anything touches {of}"),
        )

    @classmethod
    def rows(cls, model: Model, quantity: Quantity, view: View, observed: Observed | None) -> Vector:
        every = [cls._of_one(model, contact, force, view, observed) for contact, force in _points(model, quantity.of)]
        total = every[0]
        for x in every[1:]:
            gap, slip = minimum(total[0], x[0]), maximum(total[1], x[1])
            total = gap, slip, total[2] + x[2], total[3] + x[3], maximum(total[4], x[4])
        return total

    @classmethod
    def number(cls, model: Model, quantity: Quantity, component: str, view: View, observed: Observed | None) -> Any:
        if cls.level(quantity, component) < OBSERVED:  # which can be seen without forces
            observed = None
        return super().number(model, quantity, component, view, observed)

    @staticmethod
    def _of_one(
        model: Model, contact: Contact, force: Force | None, view: View, observed: Observed | None
    ) -> tuple[Number, Number, Number, Number, Number]:
        kind, (a, b) = CONTACTS[contact.type], (view[i] for i in contact.bodies)
        gap, rates = kind.gap(contact, a, b), kind.rates(contact, a, b)
        slip = _length(rates)
        if force is not None:
            a, b = (kinematics.moving(view)[i] for i in contact.bodies)
            push = -lift(yielding.energy(force.numbers["stiffness"], Jet(gap, 1.0))).b
            normal = push + yielding.damping(push, force.numbers["dissipation"], lift(kind.gap(contact, a, b)).b)
            friction = _length(yielding.friction(contact, normal, rates, force.numbers["velocity"]))
            return gap, slip, normal, friction, where(gap < 0.0, 1.0, 0.0)
        own = observed.switches[CONTACT, contact.name] if observed is not None else (0.0,)
        gap = _on(view, CONTACT, contact.name, 0.0, gap)
        slip = view.modes.get((CONTACT, contact.name), Mode()).sliding(slip)
        return gap, slip, own[0], _length(own[1:]) if own[1:] else 0.0, _on(view, CONTACT, contact.name)

    @classmethod
    def sketch(cls, table: Mapping[str, Any], joints: Sequence[str], drivers: Sequence[str]) -> Quantity | None:
        return Quantity(str(table.get("name")), str(table["type"]), (0,), of=str(table.get("contact")))

    def to_model(self, names: Names) -> Quantity:
        return Quantity(self.name, self.type, of=self.contact, bodies=names.touching(self.contact))


def _points(model: Model, name: str) -> list[tuple[Contact, Force | None]]:
    """The points of a contact, each with the force that it is, if it yields."""

    def belongs(other: str) -> bool:
        return other == name or other.startswith(f"{name}.")

    found: list[tuple[Contact, Force | None]] = [(x, None) for x in model.contacts if belongs(x.name)]
    return found + [(x.contact, x) for x in model.forces if x.contact is not None and belongs(x.name)]


@QUANTITIES.add
class LimitQuantity(QuantityType):
    """A rigid stop; of two sides the nearer one, and what both do together along the coordinate."""

    reads_coordinates: ClassVar[bool] = True

    type: Literal["limit"]
    limit: str = name_of("limits", description="the name of the limit (that of its joint, if it has none of its own)")

    @classmethod
    def level(cls, quantity: Quantity, component: str) -> int:
        return POSITION if component == "gap" else OBSERVED

    @classmethod
    def parts(cls, model: Model, quantity: Quantity) -> tuple[Part, ...]:
        turning = any(x.name.startswith(f"{quantity.of}.") and _turns(model, x.coordinate) for x in model.limits)
        of = f"of the limit {quantity.of}"
        return (
            Part("gap", "rad" if turning else "m", f"distance from the stop {of}"),
            Part("effort", "N m" if turning else "N", f"effort {of} along its coordinate"),
            Part("on", "1", f"whether anything touches {of}"),
        )

    @classmethod
    def rows(cls, model: Model, quantity: Quantity, view: View, observed: Observed | None) -> Vector:
        gap: Number | None = None
        effort: Number = 0.0
        on: Number = 0.0
        for limit in model.limits:
            if limit.name.rpartition(".")[0] == quantity.of:
                own = limit.side * (joints.coordinate(model, limit.coordinate, view) - limit.value)
                own = _on(view, LIMIT, limit.name, 0.0, own)
                gap = own if gap is None else minimum(gap, own)
                if observed is not None:
                    effort = effort + limit.side * observed.switches[LIMIT, limit.name][0]
                on = maximum(on, _on(view, LIMIT, limit.name))
        assert gap is not None
        return gap, effort, on

    @classmethod
    def sketch(cls, table: Mapping[str, Any], joints: Sequence[str], drivers: Sequence[str]) -> Quantity | None:
        return Quantity(str(table.get("name")), str(table["type"]), (0,), of=str(table.get("limit")))

    def to_model(self, names: Names) -> Quantity:
        return Quantity(self.name, self.type, of=self.limit, joint=names.limited(self.limit))


def _turns(model: Model, which: Coordinate) -> bool:
    return joints.freedom(model, which).turning


@QUANTITIES.add
class LockQuantity(QuantityType):
    """What holds the coordinates of a joint that is locked."""

    type: Literal["lock"]
    joint: str = name_of("joints", description="the name of the joint")

    @classmethod
    def level(cls, quantity: Quantity, component: str) -> int:
        return OBSERVED

    @classmethod
    def parts(cls, model: Model, quantity: Quantity) -> tuple[Part, ...]:
        joint = model.joints[quantity.joint]
        of = f"of the lock of the joint {joint.name}"
        on = Part("on", "1", f"whether anything is held {of}")
        held = lockable(joint.type)
        if tuple(x.name for x in held) == BALL:
            second = joint.bodies[-1] if joint.bodies else GROUND
            return Part("effort", "N m", f"torque {of}", vector=True, frame=second), on
        if len(held) == 1:
            return Part("effort", "N m" if held[0].turning else "N", f"effort {of}"), on
        return *(Part(x.name, "N m" if x.turning else "N", f"effort {of} along {x.name}") for x in held), on

    @classmethod
    def rows(cls, model: Model, quantity: Quantity, view: View, observed: Observed | None) -> Vector:
        assert observed is not None
        efforts: dict[str, Number] = {x.name: 0.0 for x in lockable(model.joints[quantity.joint].type)}
        on: Number = 0.0
        for n in chosen(model.locks, quantity.joint, None):
            lock = model.locks[n]
            efforts |= zip(lock.coordinates, observed.switches[LOCK, lock.name], strict=True)
            on = maximum(on, _on(view, LOCK, lock.name))
        return *efforts.values(), on

    @classmethod
    def sketch(cls, table: Mapping[str, Any], joints: Sequence[str], drivers: Sequence[str]) -> Quantity | None:
        name = str(table.get("joint"))
        if name not in joints:
            return None
        return Quantity(str(table.get("name")), str(table["type"]), (0,), joint=joints.index(name))

    def to_model(self, names: Names) -> Quantity:
        return replace(Quantity(self.name, self.type), joint=names.joints[self.joint])
