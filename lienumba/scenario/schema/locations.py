"""Where an error lies: the path of a key as the file has it."""

from collections.abc import Sequence

from pydantic import Discriminator

from lienumba.scenario.base.paths import BESIDE, INPUTS, LISTS, START, written
from lienumba.scenario.base.problems import unique_name
from lienumba.scenario.schema import sections
from lienumba.words import show

NAMED_LISTS = tuple(written([kind]) for kind in LISTS)

Loc = Sequence[str | int]


def place(loc: Loc, raw: object) -> str:
    """The path of an error of pydantic: bodies, joints, drivers and forces by name, union tags left out."""
    text = ""
    node = raw
    kept = without_tags(loc)
    if kept[:1] == ["model"] and len(kept) > 1 and kept[1] in BESIDE and isinstance(raw, dict):
        node, kept = raw.get("model"), kept[1:]
    for position, part in enumerate(kept):
        last = position == len(kept) - 1
        if isinstance(part, int):
            item = node[part] if isinstance(node, list) and part < len(node) else None
            name = unique_name(node, part) if text in NAMED_LISTS and isinstance(node, list) else None
            text += f".{name}" if name else f"[{part}]"
            node = item
        elif isinstance(node, dict) and (part in node or last):
            quoted = show(part) if "." in part or "[" in part or not part.isprintable() else part
            text += f".{quoted}" if text else quoted
            node = node.get(part)
    return text


def without_tags(loc: Loc) -> list[str | int]:
    """An error's location without the names of union members, which are not in the file."""
    return [part for position, part in enumerate(loc) if not _is_tag(loc, position)]


def _is_tag(loc: Loc, position: int) -> bool:
    in_form = len(loc) > 1 and loc[0] == "model" and loc[1] in sections.FORMS
    if position == 3 and (in_form or tuple(loc[:2]) == ("sweep", "vary")):
        return True
    if position > 2 and loc[position - 2] in ("shapes", "ground_shapes") and isinstance(loc[position], str):
        return True
    if position > 4 and loc[position - 1] == "scale":
        return isinstance(loc[position], str)
    if position > 2 and loc[position - 1] in ("rotation", "inertia") and isinstance(loc[position], str):
        return True
    if in_form and position == 5 and isinstance(loc[5], str) and _has_forms(loc):
        return True
    if position == 2 and tuple(loc[:2]) == ("integrator", "tolerance"):
        return True
    if tuple(loc[:2]) == ("model", START):
        return position == 4
    if tuple(loc[:2]) == ("model", INPUTS) and position > 2:
        return position == 3 or (position > 4 and position == len(loc) - 1 and loc[position] in ("number", "formula"))
    timed = position >= 5 if in_form else len(loc) > 1 and loc[1] == "gravity"
    return timed and position == len(loc) - 1 and loc[position] in ("number", "formula")


def _has_forms(loc: Loc) -> bool:
    """Whether the fifth part of a location is a key whose value has several forms, as a rotation has."""
    section = sections.SECTIONS.get(section_key(loc[:4]))
    field = section.model_fields.get(str(loc[4])) if section is not None else None
    return field is not None and any(isinstance(x, Discriminator) for x in field.metadata)


def section_key(loc: Loc) -> tuple[str, ...]:
    """The place of a table among `sections.SECTIONS`."""
    names = [part for part in loc if isinstance(part, str)]
    if names[:1] == ["sweep"] and names[1:2] in (["vary"], ["proposal"]) and len(names) > 2:
        names[2] = "*"
    if names[:2] == ["model", INPUTS] and len(names) > 3:
        del names[2]
    return tuple(names)
