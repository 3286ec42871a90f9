"""Joints and coordinates by their names, as limits and events name them."""

from lienumba.mechanics.elements.joints import JOINTS
from lienumba.scenario.base.problems import Report, check_name, names_of
from lienumba.scenario.checks.joints import Tables
from lienumba.words import printable, suggestion


def type_of(place: str, name: str, joints: Tables, report: Report) -> str | None:
    """The type of a joint by its name; None, and a problem, where there is none."""
    check_name(f"{place}.joint", name, names_of(joints.values()), "a joint", report)
    kind = joints.get(name, {}).get("type")
    return kind if isinstance(kind, str) and kind in JOINTS else None


def no_coordinate(place: str, name: str, kind: str, given: str, having: list[str], report: Report) -> None:
    remedy = suggestion(given, having) if len(having) > 1 else f'give "{having[0]}", or leave it out'
    report.add(f"{place}.coordinate", f"{name} is a {kind} joint, which has no {printable(given)}", remedy, given)
