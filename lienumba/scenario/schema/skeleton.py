"""The skeleton of a scenario: sections are tables, lists hold tables, names and types are texts.

What is checked behind it, and what formulas may read, relies on that. Of a scenario without it nothing else is said.
"""

from pydantic import ValidationError

from lienumba.errors import Problem
from lienumba.scenario.base.paths import INPUTS, LISTS, START
from lienumba.scenario.base.toml import Keys
from lienumba.scenario.schema import messages
from lienumba.scenario.schema.locations import without_tags
from lienumba.scenario.schema.scenario import ScenarioData

PLAIN = ("title",)  # keys of a scenario that are no sections
NAMING = ("name", "type")
Place = tuple[str | int, ...]


def broken(raw: Keys) -> list[Problem]:
    """What is wrong with the skeleton, in the words of the schema."""
    places = _places(raw)
    if not places:
        return []
    try:
        ScenarioData.model_validate(raw)
    except ValidationError as error:
        found = error.errors(include_url=False)
        told = [item for item in found if any(_meets(tuple(without_tags(item["loc"])), place) for place in places)]
        return [messages.problem(item, raw) for item in told]
    return []


def _places(raw: Keys) -> list[Place]:
    """Where something else stands than a table, a list of tables, or a text."""
    known = [key for key in raw if key in ScenarioData.model_fields and key not in PLAIN]
    found: list[Place] = [(key,) for key in known if not isinstance(raw[key], dict)]
    model = raw.get("model")
    if not isinstance(model, dict):
        return found
    found += [("model", key) for key in (INPUTS, START) if not isinstance(model.get(key, {}), dict)]
    for kind in LISTS:
        items = model.get(kind, [])
        if not isinstance(items, list):
            found.append(("model", kind))
            continue
        for n, item in enumerate(items):
            if not isinstance(item, dict):
                found.append(("model", kind, n))
            else:
                found += [("model", kind, n, key) for key in NAMING if not isinstance(item.get(key, ""), str)]
    return found


def _meets(loc: Place, place: Place) -> bool:
    """Whether an error is at a place, or around it: a table of no known type has no errors inside."""
    return loc[: len(place)] == place or (len(loc) >= 3 and place[: len(loc)] == loc)
