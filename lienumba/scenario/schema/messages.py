"""From pydantic's errors to sentences: the key with its full path, its value, the rule, the remedy."""

import re
from typing import TYPE_CHECKING, Any

from lienumba.numerics.expressions import ExpressionError, Formula
from lienumba.scenario.schema import scenario
from lienumba.scenario.schema.locations import Loc, place, section_key, without_tags
from lienumba.sweep.distributions.registry import by_key, named
from lienumba.words import ALIASES, VERY_SIMILAR, alias, is_number, nearest, plural, show, suggestion

if TYPE_CHECKING:
    from pydantic import BaseModel, ValidationError


def sentences(error: "ValidationError", raw: Any) -> list[str]:
    """One sentence per error of pydantic."""
    return [_sentence(item, raw) for item in error.errors(include_url=False)]


def _sentence(item: Any, raw: Any) -> str:
    loc, kind, value = item["loc"], item["type"], item["input"]
    ctx = item.get("ctx", {})
    if kind == "extra_forbidden":
        return _unknown(loc, raw)
    path = place(loc, raw) or "the scenario"
    remedy = _remedy(loc)
    if kind == "missing":
        return f"{path} is missing{remedy}"
    at = f"{path} = {show(value)}"
    if kind in ("float_type", "float_parsing"):
        return f"{at}: must be a number{(isinstance(value, str) and _unquoted(value, remedy)) or remedy}"
    if kind == "finite_number":
        return f"{at}: must be a finite number{remedy if isinstance(without_tags(loc)[-1], str) else '; replace it'}"
    if kind in _BOUNDS:
        rule, key = _BOUNDS[kind]
        return f"{at}: must be {rule} {ctx[key]:g}{remedy}"
    if kind == "literal_error":
        known = [choice.strip("'\"") for choice in ctx["expected"].replace(" or ", ", ").split(", ")]
        if len(known) > 3:
            return f"{at}: is not known; {suggestion(str(value), known)}"
        if len(known) == 1 and remedy:  # where something else may stand, too
            return f"{at}: is not known{remedy}"
        close = nearest(str(value), known)
        choices = " or ".join(name if name.isdecimal() else f'"{name}"' for name in known)
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
            f"{at}: has {plural(ctx['actual_length'], 'entry', 'entries')} and must have {_least(loc)}{wanted}{remedy}"
        )
    if kind == "list_type":
        table = (
            " (a list of tables is written with double brackets)" if isinstance(value, dict) and "[[" in remedy else ""
        )
        return f"{at}: must be a list{table}{remedy}"
    if kind in ("model_type", "dict_type", "model_attributes_type"):
        return f"{at}: must be a table of keys and values{remedy}"
    if loc[:1] == ("model",) and kind in ("union_tag_not_found", "union_tag_invalid") and loc[1] in scenario.FORMS:
        return _no_type(str(loc[1]), path, value)
    if kind in ("union_tag_not_found", "union_tag_invalid"):
        return _no_form(loc, path, value, remedy)
    message = str(ctx["error"]) if "error" in ctx else item["msg"]
    return f"{path}.{message}" if re.match(r"\w+ = ", message) else f"{at}: {message}"


def _unquoted(text: str, remedy: str) -> str | None:
    """The remedy for a number or a formula in quotes where a number must stand."""
    if is_number(text):
        return f", not a text; write it without quotes: {text.strip()}"
    try:
        constant = Formula(text).constant
    except ExpressionError:
        return None
    if constant is not None:
        return f", not a formula; write {constant!r}"
    return f", not a formula, because it cannot vary in time{remedy}"


_BOUNDS = {
    "greater_than": ("above", "gt"),
    "greater_than_equal": ("at least", "ge"),
    "less_than": ("below", "lt"),
    "less_than_equal": ("at most", "le"),
}


def _least(loc: Loc) -> str:
    open_ended = (
        tuple(loc) == ("model", "bodies")
        or loc[-1] in ("times", "grid", "paths")
        or "momentum" in loc
        or "python" in loc
    )
    return "at least " if open_ended else ""


def _unknown(loc: Loc, raw: Any) -> str:
    """An unknown key: the nearest one of its section, or what it belongs to."""
    key, path = str(loc[-1]), place(loc, raw)
    section = scenario.SECTIONS.get(section_key(loc[:-1]))
    known = list(section.model_fields) if section else []
    forms = scenario.FORMS.get(str(loc[1]), {}) if loc[0] == "model" and len(loc) > 1 else {}
    having = [form for form, other in forms.items() if key in other.model_fields]
    if having and alias(key, known) is None:
        kind, form = str(loc[1]), str(loc[3])
        belongs = ", ".join(_form(kind, other) for other in having)
        return f"{path} has no meaning for {_kind(kind, form)}; leave it out (it belongs to {belongs})"
    if nearest(key, known, VERY_SIMILAR) is None:
        for word in (key, *ALIASES.get(key, "").split()):
            for names, other in sorted(scenario.SECTIONS.items(), key=lambda item: len(item[0])):
                if word in other.model_fields and "*" not in names and names:
                    return f'{path} is not a known key here; "{word}" belongs in {_header(names)}'
    return f"{path} is not a known key; {suggestion(key, known)}"


def _form(kind: str, form: str) -> str:
    return "the driver of a joint" if (kind, form) == ("drivers", "joint") else form


def _kind(kind: str, form: str) -> str:
    """What one of the model's tables is, as a noun."""
    if kind == "joints":
        return f"{'an' if form[0] in 'aeio' else 'a'} {form} joint"
    if kind == "forces":
        return f"a force of type {form}"
    return _form(kind, form) if form == "joint" else f"the motion {form}"


def _header(names: tuple[str, ...]) -> str:
    if names[:2] == ("model", "bodies") and len(names) > 2:
        return f"a body's {names[2]}"
    return f"[[{'.'.join(names[:2])}]]" if len(names) > 1 else f"[{names[0]}]"


def _no_type(kind: str, path: str, value: Any) -> str:
    """A joint, driver or force whose type is missing or not known."""
    known = list(scenario.FORMS[kind])
    if not isinstance(value, dict):
        return f"{path} = {show(value)}: must be a table of keys and values; write it as [[model.{kind}]]"
    if kind != "drivers":
        if "type" not in value:
            return f"{path}.type is missing; give one of {', '.join(known)}"
        return f"{path}.type = {show(value['type'])}: is not known; {suggestion(str(value['type']), known)}"
    motions = [motion for motion in known if motion != "joint"]
    if "motion" in value:
        return f"{path}.motion = {show(value['motion'])}: is not known; {suggestion(str(value['motion']), motions)}"
    if "body" in value:
        return f"{path}.motion is missing; give one of {', '.join(motions)}"
    return f"{path}: drives nothing; give joint = ..., or body = ... with motion = one of {', '.join(motions)}"


def _no_form(loc: Loc, path: str, value: Any, remedy: str) -> str:
    """A distribution, rotation or inertia that has none of the known forms."""
    if loc[:2] != ("sweep", "vary"):
        return f"{path} = {show(value)}: has none of the known forms{remedy}"
    known = named()
    if isinstance(value, dict) and isinstance(value.get("distribution"), str):
        name = value["distribution"]
        return f"{path}.distribution = {show(name)}: is not known; {suggestion(name, known)}"
    if isinstance(value, dict) and any(isinstance(item, dict) for item in value.values()):
        return f'{path}: a varied path needs quotes; write "{_dotted(str(loc[2]), value)}" = {{ ... }}'
    if isinstance(value, dict):
        return f"{path}.distribution is missing; give one of {', '.join(known)}, or {', '.join(by_key())} instead"
    return f'{path} = {show(value)}: must be a table; give {{ distribution = "normal", std = ... }}'


def _dotted(key: str, value: dict[str, Any]) -> str:
    """The path that was written without quotes, which TOML reads as tables in tables."""
    for name, item in value.items():
        if isinstance(item, dict):
            return _dotted(f"{key}.{name}", item)
    return key


def _remedy(loc: Loc) -> str:
    """What to give instead: the description of the field that the error lies in."""
    for end in range(len(loc) - 1, -1, -1):
        section: type[BaseModel] | None = scenario.SECTIONS.get(section_key(loc[:end]))
        field = section.model_fields.get(str(loc[end])) if section else None
        if field is not None:
            return f"; give {field.description or 'another'}"
    return ""
