"""Shapes before meanings: what a scenario may be made of, whatever it says.

TOML, a dict or what `--set` gives becomes a copy of tables, lists, texts, numbers and booleans within limits. Whatever
reads it afterwards need not fear odd types, endless depth, or texts that no file can hold.
"""

import os
import re
from collections.abc import Mapping
from typing import Any

from lienumba.errors import NOTHING, ScenarioError
from lienumba.scenario.base.toml import Keys
from lienumba.words import printable

DEEPEST = 32  # tables and lists in one another
LONGEST_KEY = 250  # characters; netCDF has 256 for the name of a variable
MOST_VALUES = 50_000_000  # numbers, texts, tables and lists in all
LONGEST_TEXT = 100_000_000  # characters, of code and of meshes
WHOLE = 2**63  # whole numbers in TOML have 64 bits
FILES = "files"  # whose texts are code, and may hold what others may not
FUNCTION = "function"  # the key of a function of Python
NEVER = re.compile("[\0\ud800-\udfff]")  # what no file can hold
CONTROL = re.compile("[\0-\x08\x0e-\x1f\x7f-\x9f\ud800-\udfff]")  # control characters beside those that lay texts out
SHOWN = 60  # characters of a place


def plain(source: Mapping[Any, object]) -> Keys:
    """A copy of a whole scenario in plain types; a ScenarioError where it cannot be one.

    NumPy's arrays become lists, its numbers plain, tuples lists, paths texts; keys with None are left out.
    """
    return _Walk().table(source, ())


def plain_value(value: object, place: str) -> Any:
    """The same of one value, which stands at a place; None, for a key that is left out, stays."""
    return None if value is None else _Walk().value(value, (place,))


class _Walk:
    """Goes through a scenario once, and counts."""

    def __init__(self) -> None:
        self.count = 0

    def table(self, table: Mapping[Any, object], place: tuple[object, ...]) -> Keys:
        self.enter(len(table), place)
        for key in table:
            if not isinstance(key, str):
                what = f"{_text(place)}: its key" if place else "the key"
                shown = key if isinstance(key, float | int) else NOTHING
                raise ScenarioError.at(what, "must be a text", 'give keys in quotes, such as "title"', shown)
            if len(key) > LONGEST_KEY:
                rule = f"is {len(key):,} characters long, at most {LONGEST_KEY} are allowed"
                raise ScenarioError.at(f"the key {_text((*place, key))}", rule, "give a shorter one")
            if not key.isprintable():
                rule = "has a character in its name that cannot be seen"
                raise ScenarioError.at(f"the key {_text((*place, key))}", rule, "take it out")
        return {str(key): self.value(item, (*place, key)) for key, item in table.items() if item is not None}

    def value(self, value: object, place: tuple[object, ...]) -> Any:
        if isinstance(value, Mapping):
            return self.table(value, place)
        if not isinstance(value, str | int | float | list | tuple) and hasattr(value, "tolist"):
            value = value.tolist()
        if isinstance(value, list | tuple):
            return self.list(value, place)
        if isinstance(value, bool):
            return value
        if isinstance(value, int):
            return _whole(value, place)
        if isinstance(value, float):
            return float(value)
        if isinstance(value, os.PathLike):
            value = os.fspath(value)
        if isinstance(value, str):
            return _read(str(value), place)
        if callable(value) and place[-1] == FUNCTION:
            return value
        what = {"datetime": "a time", "date": "a date", "time": "a time"}.get(type(value).__name__)
        what = what or ("empty" if value is None else f"a {type(value).__name__}")
        raise ScenarioError.at(
            _text(place), f"is {what}, which no scenario can hold", "give a number, a text in quotes, a list or a table"
        )

    def list(self, items: list[object] | tuple[object, ...], place: tuple[object, ...]) -> list[Any]:
        self.enter(len(items), place)
        if {*map(type, items)} <= {float}:  # long ones are such
            return list(items)
        return [self.value(item, (*place, i)) for i, item in enumerate(items)]

    def enter(self, count: int, place: tuple[object, ...]) -> None:
        """Another table or list with so many items."""
        if len(place) > DEEPEST:
            rule = f"nests more than {DEEPEST} tables and lists in one another"
            raise ScenarioError.at(_text(place[:3]), rule, "take brackets, braces or dots out")
        self.count += count
        if self.count > MOST_VALUES:
            rule = f"holds more than {MOST_VALUES:,} values"
            raise ScenarioError.at("the scenario", rule, "put numbers into files: tables, recordings, samples")


def _whole(value: int, place: tuple[object, ...]) -> int:
    if not -WHOLE <= value < WHOLE:
        remedy = "give a smaller one, or write it with a point or an exponent: 1e30"
        raise ScenarioError.at(_text(place), "is a whole number that 64 bits cannot hold", remedy, value)
    return int(value)


def _read(text: str, place: tuple[object, ...]) -> str:
    if len(text) > LONGEST_TEXT:
        rule = f"is a text of {len(text):,} characters, at most {LONGEST_TEXT:,} are allowed"
        raise ScenarioError.at(_text(place), rule, "shorten it")
    if (NEVER if place[0] == FILES else CONTROL).search(text):
        raise ScenarioError.at(_text(place), "has a control character in it", "take it out", text)
    return text


def _text(place: tuple[object, ...]) -> str:
    """A place as messages name it."""
    text = ""
    for key in place:
        text += f"[{key}]" if isinstance(key, int) else f".{printable(str(key))}"
    text = text.removeprefix(".")
    return text if len(text) <= SHOWN else f"{text[: SHOWN - 4]} ..."
