"""The numbers of a model, one by one: to compile it, to look at one run of it, to find what varies."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from lienumba.mechanics.mechanism.model import Contact, Frame, Law, Model, Number
from lienumba.mechanics.mechanism.tables import Samples, Table


def map_numbers(
    model: Model, number: Callable[[Number, bool], Number], data: Callable[[Any], Any] = lambda x: x
) -> Model:
    """The model with number(value, structural) for each of its numbers, in a fixed order, and data(x) for what its
    tables hold.

    structural: an exact 0, 1 or -1 at this place shapes the equations (a coordinate of a point, a product of
    inertia, a component of gravity), where a length is always a parameter. Of masses, moments of inertia and the
    numbers of joints, drivers and forces, only an exact 0 does. Functions of time stay as they are, but for the numbers
    of a `Law`.
    """

    def vector(v: Any) -> Any:
        return tuple(timed(x, True) for x in v)

    def frame(axes: Frame) -> Frame:
        return (vector(axes[0]), vector(axes[1]), vector(axes[2]))

    def timed(x: Any, structural: bool) -> Any:
        if isinstance(x, Law):
            return replace(x, numbers={name: own(y) for name, y in x.numbers.items()})
        return x if callable(x) else number(x, structural)

    def own(x: Any) -> Any:
        if isinstance(x, Samples):
            return replace(x, data=data(x.data), every=number(x.every, False), last=number(x.last, False))
        return replace(x, data=data(x.data)) if isinstance(x, Table) else number(x, False)

    def law(x: Any) -> Any:
        if isinstance(x, tuple):
            return tuple(law(y) for y in x)
        return timed(x, isinstance(x, float | int) and x == 0)

    def of_joint(x: Any, built_in: bool) -> Any:
        return None if x is None else law(x) if built_in else number(x, False)

    def touching(contact: Contact) -> Contact:
        return replace(
            contact,
            points=(vector(contact.points[0]), vector(contact.points[1])),
            normal=None if contact.normal is None else vector(contact.normal),
            axis=None if contact.axis is None else vector(contact.axis),
            numbers={key: number(x, False) for key, x in contact.numbers.items()},
            restitution=law(contact.restitution),
            static=law(contact.static),
            kinetic=law(contact.kinetic),
            rest_speed=None if contact.rest_speed is None else number(contact.rest_speed, False),
        )

    return Model(
        gravity=vector(model.gravity),
        bodies=tuple(
            replace(
                body,
                mass=law(body.mass),
                inertia=tuple(number(x, True) if i >= 3 else law(x) for i, x in enumerate(body.inertia)),
            )
            for body in model.bodies
        ),
        joints=tuple(
            replace(
                joint,
                points=None if joint.points is None else (vector(joint.points[0]), vector(joint.points[1])),
                frames=None if joint.frames is None else (frame(joint.frames[0]), frame(joint.frames[1])),
                numbers={key: of_joint(x, joint.code is None) for key, x in joint.numbers.items()},
                armature=law(joint.armature),
                way=number(joint.way, True),
            )
            for joint in model.joints
        ),
        drivers=tuple(
            replace(
                driver,
                value=law(driver.value),
                point=None if driver.point is None else vector(driver.point),
            )
            for driver in model.drivers
        ),
        forces=tuple(
            replace(
                force,
                points=tuple(vector(p) for p in force.points),
                numbers={key: law(x) for key, x in force.numbers.items()},
                rest=None if force.rest is None else law(force.rest),
                initial={key: number(x, False) for key, x in force.initial.items()},
                contact=None if force.contact is None else touching(force.contact),
            )
            for force in model.forces
        ),
        quantities=tuple(
            replace(
                quantity,
                point=vector(quantity.point),
                target=None if quantity.target is None else vector(quantity.target),
                about=None if quantity.about is None else vector(quantity.about),
                value=law(quantity.value),
                points=tuple(vector(p) for p in quantity.points),
                numbers={key: law(x) for key, x in quantity.numbers.items()},
            )
            for quantity in model.quantities
        ),
        events=tuple(
            replace(
                event,
                when=law(event.when),
                values=tuple((place, law(x)) for place, x in event.values),
                closing=None if event.closing is None else number(event.closing, False),
            )
            for event in model.events
        ),
        locks=model.locks,
        limits=tuple(
            replace(
                limit,
                value=number(limit.value, False),
                restitution=law(limit.restitution),
                rest_speed=None if limit.rest_speed is None else number(limit.rest_speed, False),
            )
            for limit in model.limits
        ),
        contacts=tuple(map(touching, model.contacts)),
        held={name: number(x, False) for name, x in model.held.items()},
        measures=tuple(replace(x, signals=tuple(map(law, x.signals))) for x in model.measures),
    )
