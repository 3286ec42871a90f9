"""`extends`: a scenario that builds on another one and writes only what differs."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from lienumba.errors import ScenarioError
from lienumba.mechanics.elements.inputs import INPUTS_BY_FORM, input_form
from lienumba.scenario.base.code import without_clash
from lienumba.scenario.base.paths import INPUTS
from lienumba.scenario.base.toml import Keys
from lienumba.words import show

if TYPE_CHECKING:
    from typing_extensions import TypeIs

# A key that is given takes the place of these below.
REPLACES = {
    "every": ("times",), "times": ("every",), "points": ("at",), "at": ("points",), "axes": ("axis",),
    "axis": ("axes",), "value": ("rate",), "rate": ("value",), "tolerance": ("step",),
    "file": ("data", "columns", "runs", "weights"),
    "step": ("tolerance", "first_step", "max_step", "min_step"), "limit": ("limits",), "limits": ("limit",),
    "below": ("above", "between"), "above": ("below", "between"), "between": ("below", "above"),
}  # fmt: skip
BY_KEY = ("vary", "q", "qd")  # tables that go over those below key by key
Read = Callable[[Path], Keys]


def extended(raw: Keys, folder: Path, read: Read, above: tuple[Path, ...] = ()) -> Keys:
    """The scenario put over the one that it extends, and so on; paths are relative to the file that names them."""
    raw = dict(raw)
    named = raw.pop("extends", None)
    if named is None:
        return raw
    if not isinstance(named, str):
        raise ScenarioError.at("extends", "must be a text in quotes", "give the path of a TOML file", named)
    path = folder / named
    if resolved(path) in above:
        raise ScenarioError.at("extends", "leads back to itself", "take it out of one of the files", named)
    try:
        below = read(path)
    except ScenarioError as error:
        raise error.inside(f"extends = {show(named)}") from None
    return _over(extended(below, path.parent, read, (*above, resolved(path))), raw)


def resolved(path: Path) -> Path:
    """A path by which a file is known; as it is where the folder of the process is gone."""
    try:
        return path.resolve()
    except (OSError, RuntimeError):
        return path


def _over(below: Keys, raw: Keys) -> Keys:
    """Sections are put over sections key by key."""
    merged = dict(below)
    raw = without_clash(raw, below.get("files"))
    for name, section in raw.items():
        old = below.get(name)
        if name == INPUTS and isinstance(section, dict) and isinstance(old, dict):
            merged[name] = {**old, **{key: _input(old.get(key), x) for key, x in section.items()}}
        elif _are_tables(section) and _are_tables(old):
            merged[name] = _by_name(old, section)
        else:
            merged[name] = _section(old, section) if isinstance(section, dict) and isinstance(old, dict) else section
    return merged


def _input(below: object, value: object) -> object:
    """A table over a table of the form to which all its keys belong; else it takes the place of what was there."""
    form = INPUTS_BY_FORM.get(input_form(below) or "")
    within = form is not None and isinstance(value, dict) and value.keys() <= form.model_fields.keys()
    return _replaced(below, value) if within and isinstance(below, dict) and isinstance(value, dict) else value


def _section(below: Keys, section: Keys) -> Keys:
    """Lists of tables go by their names, but grids, correlations and shapes have none; what is varied, by its path; the
    rest is replaced."""
    merged = _replaced(below, section)
    for key, value in section.items():
        old = below.get(key)
        if key not in ("grid", "correlate", "ground_shapes") and _are_tables(value) and _are_tables(old):
            merged[key] = _by_name(old, value)
        elif isinstance(value, dict) and isinstance(old, dict) and (key in BY_KEY or "values" in old):  # a table
            merged[key] = {**old, **value}
    return merged


def _by_name(below: list[Keys], items: list[Keys]) -> list[Keys]:
    merged = list(below)
    places = {name: i for i, item in enumerate(merged) if isinstance(name := item.get("name"), str)}
    for item in items:
        name = item.get("name")
        place = places.get(name) if isinstance(name, str) else None
        if place is None:
            merged.append(item)
        else:
            merged[place] = _replaced(merged[place], item)
    return merged


def _replaced(below: Keys, keys: Keys) -> Keys:
    """Keys take the place of those below, and of what they replace."""
    gone = {old for key in keys for old in replaced_by(key) if old not in keys}
    return {key: value for key, value in below.items() if key not in gone} | keys


def replaced_by(key: str | int) -> tuple[str, ...]:
    """The keys whose place a key takes."""
    return REPLACES.get(str(key), ())


def _are_tables(value: object) -> "TypeIs[list[Keys]]":
    return isinstance(value, list) and bool(value) and all(isinstance(item, dict) for item in value)
