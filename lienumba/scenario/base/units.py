"""The units of a scenario's numbers, by their paths."""

from lienumba.keys.facts import Unit, facts
from lienumba.mechanics.elements.contacts.base import ContactType
from lienumba.mechanics.elements.drivers import DriverType, JointDriver
from lienumba.mechanics.elements.forces.base import AlongJoint, ForceLaw
from lienumba.mechanics.elements.joints import coordinate_kinds, named
from lienumba.mechanics.elements.joints.base import JointType
from lienumba.mechanics.elements.joints.couplings import Coupling
from lienumba.mechanics.elements.limits import Limit
from lienumba.scenario.base import paths
from lienumba.scenario.base.toml import Keys

UNITS = {
    "gravity": "m s-2", "mass": "kg", "inertia": "kg m2", "position": "m", "velocity": "m s-1",
    "angular_velocity": "rad s-1", "points": "m", "point": "m", "angle": "rad", "angles": "rad",
    "rotation_vector": "rad", "size": "m", "radius": "m", "radii": "m", "length": "m", "ends": "m",
}  # fmt: skip
OWN = ("joints", "drivers", "forces", "contacts", "limits")  # whose elements know their units
SETTINGS = {
    "integrator.step": "s",
    "integrator.end_time": "s",
    "integrator.tolerance": "1",
    "projection.tolerance": "m",
}


def units(path: str, model: Keys) -> str:
    """The units of the number at a canonical path of a model that is checked; "1" for quaternions and axes."""
    tokens = paths.parse(path)
    keys = [token for token in tokens if isinstance(token, str)]
    key = keys[-1]
    if keys[0] == "parameters" or "parameters" in keys or "states" in keys:
        return "1"  # nobody says
    if keys[:2] == [paths.START, "rotation"]:
        return "rad s-1"
    if keys[0] == paths.START:
        return _of_coordinate(keys[1], keys[2], [token for token in tokens if isinstance(token, int)], model)
    if keys[0] == paths.INPUTS:
        return "s" if len(keys) > 2 and key in ("filter", "delay") else "1"
    item = paths.get(model, tokens[:2]) if keys[0] in OWN else None
    if isinstance(item, ContactType):
        own = facts(type(item), Unit)
        return own[key].symbol if key in own else "1"
    if isinstance(item, Limit):
        kind = _coordinate(item.joint, item.coordinate, model)
        return {"low": named(kind).unit, "high": named(kind).unit, "rest_speed": named(kind).rate_unit}.get(key, "1")
    if isinstance(item, Coupling):
        kinds = item.coordinates or (None, None)
        return item.unit(key, tuple(_coordinate(*x, model) for x in zip(item.joints, kinds, strict=True)))
    if isinstance(item, JointType):
        return item.unit(key, ())
    if isinstance(item, DriverType):
        driven = _coordinate(item.joint, item.coordinate, model) if isinstance(item, JointDriver) else None
        return item.unit(key, driven)
    if isinstance(item, ForceLaw) and (number := item.numbers().get(key)) is not None:
        of_joint = _coordinate(item.joint, item.coordinate, model) if isinstance(item, AlongJoint) else None
        return number.units_of(of_joint)
    return UNITS.get(key, "1")


def _of_coordinate(key: str, name: str, place: list[int], model: Keys) -> str:
    """Of one of [start], or of one in the list of a joint."""
    for joint in paths.get(model, ["joints"]):
        labelled = joint.labelled(joint.name)
        found = labelled.get(name) or (list(labelled.values())[place[0]] if joint.name == name and place else None)
        if found is not None:
            return found.unit if key == "q" else found.rate_unit
    return "1"


def _coordinate(joint: str, kind: str | None, model: Keys) -> str:
    return kind or coordinate_kinds(paths.get(model, ["joints", joint, "type"]))[0]
