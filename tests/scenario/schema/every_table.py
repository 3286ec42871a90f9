"""A scenario with every table that the JSON schema allows, each with the keys that tell its form and no others."""

import itertools
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from lienumba.scenario.base.paths import LISTS
from lienumba.scenario.schema.json_schema import json_schema

Keys = dict[str, Any]
SCHEMA: Keys = json_schema()
# Tables of files, which are read and replaced before anything else is looked at.
FILES = ("TableFile", "InputFile", "Recording", "SampleFile")
# The key that tells a form, where the form has no constant for it.
FORM_KEYS: dict[str, Keys] = {
    "JointDriver": {"joint": "hinge"}, "SciPy": {"scipy": "beta"}, "Column": {"column": "m"},
    "lienumba__sweep__distributions__external__Expression": {"expression": "1"}, "AxisAngle": {"axis": [0, 0, 1]},
    "Euler": {"euler": "ZYX"}, "RotationVector": {"rotation_vector": [0, 0, 0]}, "FormulaInput": {"value": 1},
    "RecordedInput": {"times": [0, 1], "values": [0, 1]}, "TrackingInput": {"joint": "hinge"},
    "StateInput": {"rate": 1}, "Measure": {"value": "max(t)"}, "TableSection": {"times": [0, 1], "values": [0, 1]},
}  # fmt: skip


@dataclass
class Table:
    """keys: as the scenario has them; known: the schema of each that it may have; form: its name in the schema;
    siblings: the forms that may stand in its place."""

    keys: Keys
    known: dict[str, Keys]
    required: list[str]
    form: str
    siblings: list[str]

    def changeable(self, rule: str) -> set[str]:
        """The keys that may break a rule: those that it has not yet, or those that hold other tables."""
        if rule == "must be a table" and self.form not in ("scenario", "ModelSection"):
            return {key for key, item in self.known.items() if "const" not in item} - {*FORM_KEYS.get(self.form, ())}
        return {*self.known} - {*self.keys}


def branches(schema: Keys) -> list[Keys]:
    """The forms that a value may have, as schemas without references; none of them is null."""
    if "$ref" in schema:
        form = schema["$ref"].removeprefix("#/$defs/")
        return [] if form in FILES else [{**SCHEMA["$defs"][form], "form": form}]
    several = schema.get("anyOf", schema.get("oneOf"))
    if several is None:
        return [] if schema.get("type") == "null" else [schema]
    return [form for item in several for form in branches(item)]


class EveryTable:
    """data: the scenario; tables: all in it; places: the path of each table by its identity."""

    def __init__(self) -> None:
        self.tables: list[Table] = []
        self._number = itertools.count()
        (self.data,) = self._instances({**SCHEMA, "form": "scenario"}, [])

    def placed(self) -> Iterator[tuple[str, Table]]:
        """Every table that the scenario still has, with its path as messages have it."""
        places = dict(_places(self.data, ""))
        yield from ((places[id(table.keys)], table) for table in self.tables if id(table.keys) in places)

    def _instances(self, schema: Keys, siblings: list[str]) -> list[Keys]:
        """As many tables of a form as its keys that are tables have forms."""
        known, form = schema["properties"], schema["form"]
        inner = {key: found for key, item in known.items() if (found := self._values(item))}
        made = []
        for n in range(max(map(len, inner.values()), default=1)):
            keys = {key: item["const"] for key, item in known.items() if "const" in item} | FORM_KEYS.get(form, {})
            keys |= {"name": f"n{next(self._number)}"} if "name" in known else {}
            keys |= {key: found[n] for key, found in inner.items() if n < len(found)}
            self.tables.append(Table(keys, known, schema.get("required", []), form, siblings))
            made.append(keys)
        return made

    def _values(self, schema: Keys) -> list[Any]:
        """What a key may hold that has tables in it: a table of each form, a list, or tables by names."""
        found: list[Any] = []
        for branch in branches(schema):
            inner = branch.get("items") or branch.get("additionalProperties") or {"type": "null"}
            if "form" in branch:
                found += self._instances(branch, [])
            elif isinstance(inner, dict) and (tables := [item for item in branches(inner) if "form" in item]):
                forms = [item["form"] for item in tables]
                each = [x for item in tables for x in self._instances(item, forms)]
                found.append(each if "items" in branch else {f"k{n}": x for n, x in enumerate(each)})
        return found


def _places(node: Any, place: str) -> Iterator[tuple[int, str]]:
    """The paths of all tables below one, by their identity."""
    if isinstance(node, dict):
        yield id(node), place
        for key, item in node.items():
            yield from _places(item, f"{place}.{key}" if place else key)
    elif isinstance(node, list):
        names = [item.get("name") if isinstance(item, dict) else None for item in node]
        for n, item in enumerate(node):
            known = place.rpartition(".")[2] in LISTS and isinstance(names[n], str) and names.count(names[n]) == 1
            yield from _places(item, f"{place}.{names[n]}" if known else f"{place}[{n}]")
