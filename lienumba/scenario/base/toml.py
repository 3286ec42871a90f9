"""A scenario's keys and values as TOML text that reads well: lists and leaf tables on one line."""

import json
import re
from collections.abc import Mapping
from functools import lru_cache
from typing import Any

Keys = dict[str, object]  # the same, of which nothing is known yet

Tables = Mapping[str, Any]  # of a scenario: keys and what they hold, which is known


def table_in(raw: Keys, key: str) -> Keys:
    """The table at a key; an empty one for what is none."""
    table = raw.get(key)
    return table if isinstance(table, dict) else {}


def dumps(data: Mapping[str, object]) -> str:
    """TOML text of nested dicts, lists, texts, numbers and booleans; `tomllib` reads the same values back."""
    return "\n".join(_section(data, [])).strip("\n") + "\n"


def _section(table: Mapping[str, object], names: list[str]) -> list[str]:
    """The lines of one table: its own values first, then the tables in it."""
    lines, inner = [], []
    for key, value in table.items():
        here = [*names, _key(key)]
        if isinstance(value, dict) and _is_section(value, len(here)):
            inner += ["", f"[{'.'.join(here)}]", *_section(value, here)]
        elif isinstance(value, list) and value and all(isinstance(item, dict) for item in value):
            for item in value:
                inner += ["", f"[[{'.'.join(here)}]]"]
                inner += pairs(item)
        elif isinstance(value, str) and "\n" in value:
            lines.append(f"{_key(key)} = {_long_text(value)}")
        else:
            lines.append(f"{_key(key)} = {value_text(value)}")
    return lines + inner


def pairs(table: Mapping[str, object]) -> list[str]:
    """A line for each key of a table."""
    return [f"{_key(name)} = {_lines_text(part)}" for name, part in table.items()]


def _lines_text(value: object) -> str:
    """One value; each table of a list in a line of its own."""
    if isinstance(value, list) and value and all(isinstance(item, dict) for item in value):
        return "[\n" + "".join(f"  {value_text(item)},\n" for item in value) + "]"
    return value_text(value)


def _long_text(text: str) -> str:
    """A text of several lines as it is."""
    *lines, last = [value_text(line)[1:-1] for line in text.split("\n")]
    readable = [x if '\\"\\"\\"' in x else x.replace('\\"', '"') for x in lines]
    return '"""\n' + "\n".join([*readable, last]) + '"""'


def _is_section(value: Keys, depth: int) -> bool:
    return depth == 1 or any(isinstance(item, dict) for item in value.values())


@lru_cache(4096)
def _key(key: str) -> str:
    return key if re.fullmatch(r"[A-Za-z0-9_-]+", key) else value_text(key)


def value_text(value: object) -> str:
    """One value on one line."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007F")
    if isinstance(value, dict):
        items = ", ".join(f"{_key(key)} = {value_text(item)}" for key, item in value.items())
        return f"{{ {items} }}" if items else "{}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(value_text(item) for item in value) + "]"
    return repr(value)
