"""From pydantic's errors to sentences: the key with its full path, its value, the rule, the remedy."""

import re
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

from lienumba.scenario import schema

if TYPE_CHECKING:
    from pydantic import BaseModel, ValidationError

NAMED_LISTS = tuple(f"model.{kind}" for kind in schema.LISTS)

# What other programs call the same thing.
ALIASES = {
    "omega": "angular_velocity", "w": "angular_velocity", "spin": "angular_velocity",
    "orientation": "rotation", "quaternion": "rotation", "attitude": "rotation", "R": "rotation",
    "J": "inertia", "I": "inertia", "m": "mass", "r": "position", "x": "position", "v": "velocity",
    "g": "gravity", "dt": "step", "h": "step", "time_step": "step", "timestep": "step",
    "duration": "end_time", "t_end": "end_time", "tend": "end_time", "tf": "end_time",
    "solver": "method", "scheme": "method", "n": "runs", "count": "runs", "samples": "runs",
    "interval": "every", "parameters": "vary", "std_dev": "std", "sigma": "std", "stddev": "std",
    "loc": "mean", "mu": "mean", "scale": "std", "min": "low", "max": "high",
    "ball": "spherical", "rod": "distance", "hinge": "revolute", "pin": "revolute", "slider": "prismatic",
    "translational": "prismatic", "weld": "fixed", "rigid": "fixed", "cardan": "universal", "hooke": "universal",
    "helical": "screw", "spring": "spring_damper", "damper": "spring_damper", "motor": "actuator", "servo": "actuator",
    "k": "stiffness", "d": "damping", "c": "damping", "stop": "end_stop", "length0": "free_length", "rest_length":
    "free_length", "parent": "relative_to", "location": "position", "anchor": "points",
    "gaussian": "normal", "gauss": "normal", "norm": "normal",
    "sequence": "euler", "order": "euler",
    "world": "ground", "earth": "ground", "rk2": "midpoint", "rk3": "kutta3", "rungekutta4": "rk4",
}  # fmt: skip

DISTRIBUTION_KEYS = {
    "distribution": '"normal" or "uniform"', "mean": "the mean (or omit it: the nominal value)",
    "std": "the standard deviation, 0 or above", "low": "the lowest value", "high": "the highest value",
    "relative": "true (multiples of the nominal value) or false",
}  # fmt: skip


def nearest(word: str, known: Iterable[str]) -> str | None:
    """The known name most like a word, or None if none is like it."""
    import difflib

    names = list(known)
    for alias in (word, word.lower()):
        if ALIASES.get(alias) in names:
            return ALIASES[alias]
    folded = {name.lower(): name for name in names}
    close = difflib.get_close_matches(word.lower(), list(folded), n=1, cutoff=0.5)
    return folded[close[0]] if close else None


def suggestion(word: str, known: Iterable[str]) -> str:
    """The remedy for an unknown name: the nearest known one, or the list of them."""
    names = list(known)
    close = nearest(word, names)
    if close is not None:
        return f'the nearest known name is "{close}"'
    if not names:
        return "none is known here"
    return "known here are " + ", ".join(f'"{name}"' for name in names)


def show(value: Any) -> str:
    """A value as TOML writes it, cut to one line of reading."""
    if isinstance(value, bool):
        text = "true" if value else "false"
    elif isinstance(value, str):
        text = '"' + value.replace("\n", "\\n") + '"'
    elif isinstance(value, dict):
        text = "{" + ", ".join(f"{key} = {show(item)}" for key, item in value.items()) + "}"
    elif isinstance(value, list | tuple):
        text = "[" + ", ".join(show(item) for item in value) + "]"
    else:
        text = repr(value)
    return text if len(text) <= 80 else text[:76] + " ..."


def place(loc: Sequence[str | int], raw: Any) -> str:
    """The path of an error as the file has it: bodies and joints by name, union tags left out."""
    text = ""
    node = raw
    for position, part in enumerate(loc):
        last = position == len(loc) - 1
        if isinstance(part, int):
            item = node[part] if isinstance(node, list) and part < len(node) else None
            name = unique_name(node, part) if text in NAMED_LISTS else None
            text += f".{name}" if name else f"[{part}]"
            node = item
        elif isinstance(node, dict) and (part in node or last):
            quoted = f'"{part}"' if "." in part or "[" in part else part
            text += f".{quoted}" if text else quoted
            node = node.get(part)
    return text


def unique_name(items: Any, index: int) -> str | None:
    """The name of an item of a list of tables, if it has one that no other item bears."""
    names = [item.get("name") if isinstance(item, dict) else None for item in items]
    name = names[index]
    return name if isinstance(name, str) and name and names.count(name) == 1 else None


def sentences(error: "ValidationError", raw: Any) -> list[str]:
    """One sentence per error of pydantic."""
    return [_sentence(item, raw) for item in error.errors(include_url=False)]


def _sentence(item: Any, raw: Any) -> str:
    loc, kind, value = item["loc"], item["type"], item["input"]
    ctx = item.get("ctx", {})
    if kind == "extra_forbidden":
        return _unknown(loc, raw)
    untagged = _without_tags(loc, raw)
    path = place(loc if kind == "missing" else untagged, raw)
    path = path or "the scenario"
    remedy = _remedy(loc)
    if kind == "missing":
        return f"{path} is missing{remedy}"
    at = f"{path} = {show(value)}"
    if kind in ("float_type", "float_parsing"):
        if isinstance(value, str) and _is_number(value):
            return f"{at}: must be a number, not a text; write it without quotes: {value.strip()}"
        return f"{at}: must be a number{remedy}"
    if kind == "finite_number":
        return f"{at}: must be a finite number{remedy if isinstance(untagged[-1], str) else '; replace it'}"
    if kind in _BOUNDS:
        rule, key = _BOUNDS[kind]
        return f"{at}: must be {rule} {ctx[key]:g}{remedy}"
    if kind == "literal_error":
        known = [choice.strip("'\"") for choice in ctx["expected"].replace(" or ", ", ").split(", ")]
        if len(known) > 3:
            return f"{at}: is not known; {suggestion(str(value), known)}"
        close = nearest(str(value), known)
        choices = " or ".join(f'"{name}"' for name in known)
        return f"{at}: must be {choices}; " + (f'the nearest is "{close}"' if close else "give one of them")
    if kind == "bool_type":
        return f"{at}: must be true or false; write it so, without quotes"
    if kind in ("int_type", "int_from_float", "int_parsing"):
        whole = (isinstance(value, float) and value.is_integer()) or (isinstance(value, str) and value.isdecimal())
        return f"{at}: must be a whole number" + (f"; write {int(value)}" if whole else remedy)
    if kind == "string_pattern_mismatch":
        return f"{at}: is no valid name{remedy}"
    if kind == "string_type":
        return f"{at}: must be a text in quotes{remedy}"
    if kind in ("too_short", "too_long"):
        wanted = ctx.get("min_length" if kind == "too_short" else "max_length")
        return (
            f"{at}: has {_plural(ctx['actual_length'], 'entry', 'entries')} and must have {_least(loc)}{wanted}{remedy}"
        )
    if kind == "list_type":
        table = " (a list of tables is written with double brackets)" if isinstance(value, dict) else ""
        return f"{at}: must be a list{table}{remedy}"
    if kind in ("model_type", "dict_type", "model_attributes_type"):
        return f"{at}: must be a table of keys and values{remedy}"
    if loc[:1] == ("model",) and kind in ("union_tag_not_found", "union_tag_invalid") and loc[1] in schema.FORMS:
        return _no_type(str(loc[1]), path, value)
    if kind in ("union_tag_not_found", "union_tag_invalid"):
        return _no_form(loc, path, value, remedy)
    message = str(ctx["error"]) if "error" in ctx else item["msg"]
    return f"{path}.{message}" if re.match(r"\w+ = ", message) else f"{at}: {message}"


_BOUNDS = {
    "greater_than": ("above", "gt"),
    "greater_than_equal": ("at least", "ge"),
    "less_than": ("below", "lt"),
    "less_than_equal": ("at most", "le"),
}


def _least(loc: Sequence[str | int]) -> str:
    return "at least " if loc[-1] in ("times",) or tuple(loc) == ("model", "bodies") else ""


def _plural(number: int, one: str, many: str) -> str:
    return f"{number} {one if number == 1 else many}"


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _unknown(loc: Sequence[str | int], raw: Any) -> str:
    """An unknown key: the nearest one of its section, or the section it belongs to."""
    key = str(loc[-1])
    path = place(loc, raw)
    section = schema.SECTIONS.get(_section_key(loc[:-1]))
    known = list(section.model_fields) if section else []
    kind = str(loc[1]) if len(loc) > 1 else ""
    for word in (key, ALIASES.get(key, key)):
        if word in known:
            break
        forms = schema.FORMS.get(kind, {}) if loc[:1] == ("model",) else {}
        having = [form for form, other in forms.items() if word in other.model_fields]
        if having:
            form = next(str(part) for part in loc[2:] if part in forms)
            return f"{path} has no meaning for {_kind(kind, form)}; leave it out (it belongs to {', '.join(having)})"
        for names, other in schema.SECTIONS.items():
            if word in other.model_fields and "*" not in names and names:
                return f'{path} is not a known key here; "{word}" belongs in {_header(names)}'
    return f"{path} is not a known key; {suggestion(key, known)}"


def _kind(kind: str, form: str) -> str:
    """What one of the model's tables is, as a noun."""
    if kind == "drivers":
        return "the driver of a joint" if form == "joint" else f"the motion {form}"
    noun = f"{form} joint" if kind == "joints" else form
    return f"{'an' if noun[0] in 'aeiou' else 'a'} {noun}"


def _header(names: tuple[str, ...]) -> str:
    if names[:2] == ("model", "bodies") and len(names) > 2:
        return f"a body's {names[2]}"
    return f"[[{'.'.join(names[:2])}]]" if len(names) > 1 else f"[{names[0]}]"


def _no_type(kind: str, path: str, value: Any) -> str:
    """A joint, driver or force whose type is missing or not known."""
    known = list(schema.FORMS[kind])
    if not isinstance(value, dict):
        return f"{path} = {show(value)}: must be a table of keys and values; write it as [[model.{kind}]]"
    if kind != "drivers":
        if "type" not in value:
            return f"{path}.type is missing; give one of {', '.join(known)}"
        return f"{path}.type = {show(value['type'])}: is not known; {suggestion(str(value['type']), known)}"
    motions = [motion for motion in known if motion != "joint"]
    if "joint" in value:
        return (
            f"{path}.motion = {show(value['motion'])}: has no meaning for the driver of a joint; leave it out, and "
            "give value or rate"
        )
    if "motion" in value:
        return f"{path}.motion = {show(value['motion'])}: is not known; {suggestion(str(value['motion']), motions)}"
    return f"{path}: drives nothing; give joint = ..., or body = ... with motion = one of {', '.join(motions)}"


def _no_form(loc: Sequence[str | int], path: str, value: Any, remedy: str) -> str:
    """A distribution, rotation or inertia that has none of the known forms."""
    if loc[:2] != ("sweep", "vary"):
        return f"{path} = {show(value)}: has none of the known forms{remedy}"
    known = ["normal", "uniform"]
    if isinstance(value, dict) and isinstance(value.get("distribution"), str):
        name = value["distribution"]
        return f'{path}.distribution = "{name}": is not known; {suggestion(name, known)}'
    if isinstance(value, dict) and any(isinstance(item, dict) for item in value.values()):
        return f'{path}: a varied path needs quotes; write "{_dotted(str(loc[2]), value)}" = {{ ... }}'
    if isinstance(value, dict):
        return f'{path}.distribution is missing; give "normal" or "uniform"'
    return f'{path} = {show(value)}: must be a table; give {{ distribution = "normal", std = ... }}'


def _dotted(key: str, value: dict[str, Any]) -> str:
    """The path that was written without quotes, which TOML reads as tables in tables."""
    for name, item in value.items():
        if isinstance(item, dict):
            return _dotted(f"{key}.{name}", item)
    return key


def _remedy(loc: Sequence[str | int]) -> str:
    """What to give instead: the description of the field that the error lies in."""
    for end in range(len(loc) - 1, -1, -1):
        section: type[BaseModel] | None = schema.SECTIONS.get(_section_key(loc[:end]))
        field = section.model_fields.get(str(loc[end])) if section else None
        if field is not None:
            return f"; give {field.description or DISTRIBUTION_KEYS.get(str(loc[end]), 'another')}"
    return ""


def _section_key(loc: Sequence[str | int]) -> tuple[str, ...]:
    names = [part for part in loc if isinstance(part, str)]
    if names[:2] == ["sweep", "vary"] and len(names) > 2:
        names[2] = "*"
    return tuple(names)


def _without_tags(loc: Sequence[str | int], raw: Any) -> list[str | int]:
    """An error's location without the names of union members, which are not in the file."""
    kept: list[str | int] = []
    node = raw
    for part in loc:
        if isinstance(part, int):
            inside = isinstance(node, list) and part < len(node)
            node = node[part] if inside else None
            kept.append(part)
        elif isinstance(node, dict) and part in node:
            node = node[part]
            kept.append(part)
    return kept
