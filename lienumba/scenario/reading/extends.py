"""`extends`: a scenario that builds on another one and writes only what differs."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lienumba.errors import ScenarioError
from lienumba.scenario.base.code import without_clash
from lienumba.words import show

if TYPE_CHECKING:
    from typing_extensions import TypeIs

# A key that is given takes the place of these below.
REPLACES = {
    "every": ("times",), "times": ("every",), "points": ("at",), "at": ("points",), "axes": ("axis",),
    "axis": ("axes",), "value": ("rate",), "rate": ("value",), "tolerance": ("step",),
    "step": ("tolerance", "first_step", "max_step", "min_step"),
}  # fmt: skip
Table = dict[str, Any]
Read = Callable[[Path], dict[str, Any]]


def extended(raw: dict[str, Any], folder: Path, read: Read, above: tuple[Path, ...] = ()) -> dict[str, Any]:
    """The scenario put over the one that it extends, and so on; paths are relative to the file that names them."""
    raw = dict(raw)
    named = raw.pop("extends", None)
    if named is None:
        return raw
    if not isinstance(named, str):
        raise ScenarioError.at("extends", "must be a text in quotes", "give the path of a TOML file", named)
    path = folder / named
    if path.resolve() in above:
        raise ScenarioError.at("extends", "leads back to itself", "take it out of one of the files", named)
    try:
        below = read(path)
    except ScenarioError as error:
        raise error.inside(f"extends = {show(named)}") from None
    return _over(extended(below, path.parent, read, (*above, path.resolve())), raw)


def _over(below: dict[str, Any], raw: dict[str, Any]) -> dict[str, Any]:
    """Sections are put over sections key by key."""
    merged = dict(below)
    raw = without_clash(raw, below.get("files"))
    for name, section in raw.items():
        if _are_tables(section) and _are_tables(below.get(name)):
            merged[name] = _by_name(below[name], section)
            continue
        both = isinstance(section, dict) and isinstance(below.get(name), dict)
        merged[name] = _section(below[name], section) if both else section
    return merged


def _section(below: dict[str, Any], section: dict[str, Any]) -> dict[str, Any]:
    """Lists of tables go by their names, but grids and correlations have none; what is varied, by its path; the rest is
    replaced."""
    merged = _replaced(below, section)
    for key, value in section.items():
        old = below.get(key)
        if key not in ("grid", "correlate") and _are_tables(value) and _are_tables(old):
            merged[key] = _by_name(old, value)
        elif isinstance(value, dict) and isinstance(old, dict) and (key == "vary" or "values" in old):  # a table
            merged[key] = {**old, **value}
    return merged


def _by_name(below: list[Table], items: list[Table]) -> list[Table]:
    merged = list(below)
    places = {item.get("name"): i for i, item in enumerate(merged)}
    for item in items:
        place = places.get(item.get("name")) if "name" in item else None
        if place is None:
            merged.append(item)
        else:
            merged[place] = _replaced(merged[place], item)
    return merged


def _replaced(below: dict[str, Any], keys: dict[str, Any]) -> dict[str, Any]:
    """Keys take the place of those below, and of what they replace."""
    gone = {old for key in keys for old in replaced_by(key) if old not in keys}
    return {key: value for key, value in below.items() if key not in gone} | keys


def replaced_by(key: str | int) -> tuple[str, ...]:
    """The keys whose place a key takes."""
    return REPLACES.get(str(key), ())


def _are_tables(value: object) -> "TypeIs[list[Table]]":
    return isinstance(value, list) and bool(value) and all(isinstance(item, dict) for item in value)
