"""The units of a scenario's numbers, by their paths."""

from typing import Any

from lienumba.mechanics.elements.drivers import DRIVERS, driver_form
from lienumba.mechanics.elements.forces import FORCES
from lienumba.mechanics.elements.joints import JOINTS, coordinate_kinds
from lienumba.scenario.base import paths
from lienumba.scenario.base.toml import Keys

UNITS = {
    "gravity": "m s-2", "mass": "kg", "inertia": "kg m2", "position": "m", "velocity": "m s-1",
    "angular_velocity": "rad s-1", "points": "m", "point": "m", "angle": "rad", "angles": "rad",
    "rotation_vector": "rad",
}  # fmt: skip
SETTINGS = {
    "integrator.step": "s",
    "integrator.end_time": "s",
    "integrator.tolerance": "1",
    "projection.tolerance": "m",
}


def units(path: str, model: Keys) -> str:
    """The units of the number at a canonical path of a resolved scenario's model; "1" for quaternions and axes."""
    tokens = paths.parse(path)
    keys = [token for token in tokens if isinstance(token, str)]
    if keys[0] == "parameters":
        return "1"  # nobody says
    key = keys[-1]
    if "parameters" in keys or "states" in keys:
        return "1"
    if keys[0] not in ("joints", "drivers", "forces"):
        return UNITS.get(key, "1")
    item = paths.get(model, tokens[:2])
    if keys[0] == "joints":
        return JOINTS[item["type"]].unit(key, _coupled(item, model))
    if keys[0] == "drivers":
        driven = _coordinate(item["joint"], item["coordinate"], model) if "joint" in item else None
        return DRIVERS[driver_form(item) or ""].unit(key, driven)
    if keys[0] == "forces":
        number = FORCES[item["type"]].numbers().get(key)
        if number is not None:
            return number.units_of(_coordinate(item["joint"], item["coordinate"], model) if "joint" in item else None)
    return UNITS.get(key, "1")


def _coordinate(joint: str, kind: str | None, model: Keys) -> str:
    return kind or coordinate_kinds(paths.get(model, ["joints", joint, "type"]))[0]


def _coupled(item: dict[str, Any], model: Keys) -> tuple[str, ...]:
    """The kinds of the coordinates that a joint couples."""
    joints: list[str] = item.get("joints", [])
    kinds: list[str | None] = item.get("coordinates") or [None] * len(joints)
    return tuple(_coordinate(name, kind, model) for name, kind in zip(joints, kinds, strict=True))
