"""What of a scenario needs a method that can change on the way."""

from lienumba.scenario.checks.changes.events import OPPOSITE
from lienumba.scenario.checks.quantities import Lists
from lienumba.scenario.formulas.measures import is_formula


def changing(lists: Lists) -> str:
    """What of a scenario asks for places between the ends of steps, as it is written; "" if nothing does."""
    if lists["events"]:
        return "[[events]]"
    if lists["measures"] or any(is_formula(str(x.get("value"))) for x in lists["requirements"]):
        return "[[measures]]" if lists["measures"] else "[[requirements]]"
    if lists["limits"]:
        return "[[model.limits]]"
    if any("stiffness" not in contact for contact in lists["contacts"]):
        return "[[model.contacts]]"
    return "friction with static" if any("static" in force for force in lists["forces"]) else ""


def switching(lists: Lists) -> str:
    """What of a scenario turns constraints on and off; "" if nothing does."""
    if any(event.get("action") in (*OPPOSITE, *OPPOSITE.values()) for event in lists["events"]):
        return "[[events]]"
    if any(joint.get("locked") is True for joint in lists["joints"]):
        return "locked = true"
    return changing({**lists, "events": [], "measures": [], "requirements": []})


def sliding(lists: Lists) -> bool:
    """Whether a rigid contact may slide with friction."""
    return any("stiffness" not in contact and contact.get("friction", 0) != 0 for contact in lists["contacts"])
