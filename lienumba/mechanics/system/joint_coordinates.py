"""The coordinates of the whole mechanism: those of all joints that have moves, in the order of the model.

What acts along one is what the laws of its joint exert: forces along it, drivers of it, efforts that laws of the user's
own return for it. A positive one accelerates the coordinate. What gears, loops and other joints make of it is no part.
"""

from collections.abc import Iterator

from lienumba.mechanics.elements import joints, user_laws
from lienumba.mechanics.elements.joints import JOINTS
from lienumba.mechanics.mechanism.kinematics import still
from lienumba.mechanics.mechanism.model import Coordinate, Model
from lienumba.mechanics.system import applied_forces
from lienumba.mechanics.system.output_variables import Observation, OutputVariable
from lienumba.numerics.number import Number

ALONG = ("coordinate",)
# Of each variable, where the coordinate is in rad and in m.
UNITS = {
    "q": {"rad": "rad", "m": "m"},
    "qd": {"rad": "rad s-1", "m": "m s-1"},
    "tau": {"rad": "N m", "m": "N"},
}


def units(model: Model) -> dict[str, str]:
    """The unit, rad or m, of each by its name."""
    every = [JOINTS[joint.type].labelled(joint.name) for joint in model.joints]
    return {label: x.unit for own in every for label, x in own.items()}


def _values(seen: Observation) -> list[Number]:
    view = still(seen.now, tuple(range(len(seen.model.bodies))))
    return [joints.coordinate(seen.model, which, view) for which in joints.coordinates(seen.model)]


def _rates(seen: Observation) -> list[Number]:
    view = still(seen.now, tuple(range(len(seen.model.bodies))))
    return [joints.rate(seen.model, which, view) for which in joints.coordinates(seen.model)]


def _efforts(seen: Observation) -> list[Number]:
    """Along each, of all that acts along the coordinates of its joint."""
    acting = list(_acting(seen))
    found: list[Number] = []
    for which in joints.coordinates(seen.model):
        total: Number = 0.0
        for along, effort in acting:
            gain = joints.gain(seen.model, which, along)
            total = total if gain is None else total + gain * effort
        found.append(total)
    return found


def _acting(seen: Observation) -> Iterator[tuple[Coordinate, Number]]:
    """What acts along coordinates of joints that have moves."""
    model, now = seen.model, seen.now
    for force in model.forces:
        if force.coordinate is not None and _moves(model, force.coordinate):
            view = still(now, model.joints[force.coordinate.joint].bodies)
            rate = joints.rate(model, force.coordinate, view)
            yield force.coordinate, applied_forces.effort(model, force, now, rate)
        elif force.code is not None and force.code.joints and force.code.returns == user_laws.LOADS:
            for load in user_laws.acting(model, force, now):
                if load.kind == "effort":
                    yield Coordinate(load.target, load.coordinate), load.value[0]
    for index, driver in enumerate(model.drivers):
        if driver.coordinate is not None and _moves(model, driver.coordinate):
            yield driver.coordinate, seen.observed.efforts[index][0]


def _moves(model: Model, which: Coordinate) -> bool:
    return bool(JOINTS[model.joints[which.joint].type].independent())


JOINT_COORDINATES = {
    variable.name: variable
    for variable in (
        OutputVariable("q", "1", "coordinate of the joint (rad or m)", dims=ALONG, rows=_values),
        OutputVariable("qd", "1", "rate of the coordinate (rad s-1 or m s-1)", dims=ALONG, rows=_rates),
        OutputVariable(
            "tau", "1", "what the laws of the joint exert along the coordinate (N m or N)", dims=ALONG, rows=_efforts
        ),
    )
}  # stored where [output] joint_coordinates asks for them
