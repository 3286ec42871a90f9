"""From pydantic's errors to problems: the key with its full path, its value, the rule, the remedy."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

from lienumba.errors import UNKNOWN, BadValueError, Problem, missing
from lienumba.keys.facts import is_open_ended
from lienumba.mechanics.elements.drivers import DRIVERS
from lienumba.mechanics.elements.inputs import FORM_KEYS, INPUTS_BY_FORM
from lienumba.numerics.expressions import Formula
from lienumba.numerics.grammar import ExpressionError
from lienumba.scenario.base.paths import INPUTS, written
from lienumba.scenario.base.toml import Keys
from lienumba.scenario.schema import sections, shapes
from lienumba.scenario.schema.locations import Loc, place, section_key, without_tags
from lienumba.sweep.distributions.registry import by_key, named
from lienumba.words import ALIASES, VERY_SIMILAR, alias, is_number, nearest, plural, suggestion

if TYPE_CHECKING:
    from pydantic import BaseModel, ValidationError
    from pydantic_core import ErrorDetails


NEEDED = {form: key for key, form in FORM_KEYS.items()}  # the key by which a form of inputs is known
GROUND, SHAPES = "ground_shapes", "shapes"
NO_FORMULA = ", not a formula or a parameter"


def problems(error: "ValidationError", raw: object) -> list[Problem]:
    """One problem per error of pydantic, but none of a key that is missing because its name is mistyped."""
    items = error.errors(include_url=False)
    mistyped = [item["loc"] for item in items if item["type"] == "extra_forbidden"]
    meant = {(*loc[:-1], _meant(loc)) for loc in mistyped}
    return [problem(item, raw) for item in items if item["type"] != "missing" or item["loc"] not in meant]


def problem(item: "ErrorDetails", raw: object) -> Problem:
    """That of one error."""
    loc, kind, value, context = item["loc"], item["type"], item["input"], item.get("ctx", {})
    if kind == "extra_forbidden":
        return _unknown(loc, raw)
    path = place(loc, raw) or "the scenario"
    remedy = _remedy(loc)
    if kind == "missing":
        return missing(path, remedy)
    if loc[:1] == ("model",) and kind in ("union_tag_not_found", "union_tag_invalid") and loc[1] in sections.FORMS:
        return _no_type(str(loc[1]), path, value)
    if kind in ("union_tag_not_found", "union_tag_invalid") and without_tags(loc)[-2:-1] in ([SHAPES], [GROUND]):
        return _no_type_of(list(shapes.SHAPES), path, value, f"write [[model.{GROUND}]], or shapes = [{{ ... }}]")
    if kind in ("union_tag_not_found", "union_tag_invalid"):
        return _no_form(loc, path, value, remedy)
    if "error" in context:  # of our own
        error = context["error"]
        return error.at(path, value) if isinstance(error, BadValueError) else Problem(path, str(error), value=value)
    rule, remedy = _rule(loc, kind, value, context, remedy) or (item["msg"], "")
    return Problem(path, rule, remedy, value)


def _rule(loc: Loc, kind: str, value: object, context: Mapping[str, object], remedy: str) -> tuple[str, str] | None:
    """What a value must be, and the remedy, which may be another than that of its key."""
    if kind in ("float_type", "float_parsing"):
        other = _unquoted(value, remedy) if isinstance(value, str) else None
        return other or (f"must be a number{NO_FORMULA if isinstance(value, str) else ''}", remedy)
    if kind == "finite_number":
        return "must be a finite number", remedy if isinstance(without_tags(loc)[-1], str) else "replace it"
    if kind in _BOUNDS:
        rule, key = _BOUNDS[kind]
        limit = context[key]
        return f"must be {rule} {f'{limit:,}' if isinstance(limit, int) else f'{limit:g}'}", remedy
    if kind == "literal_error":
        return _choice(value, str(context["expected"]), remedy)
    if kind == "bool_type":
        return "must be true or false", "write it so, without quotes"
    if kind in ("int_type", "int_from_float", "int_parsing"):
        if (isinstance(value, float) and value.is_integer()) or (isinstance(value, str) and value.isdecimal()):
            return "must be a whole number", f"write {int(value)}"
        return f"must be a whole number{NO_FORMULA if isinstance(value, str) else ''}", remedy
    if kind == "string_too_long":
        return f"is longer than {context['max_length']} characters", "shorten it"
    if kind == "string_pattern_mismatch":
        return "is no valid name", remedy
    if kind == "string_type":
        return "must be a text in quotes", remedy
    actual = context.get("actual_length")
    if kind in ("too_short", "too_long") and isinstance(actual, int):
        wanted = context.get("min_length" if kind == "too_short" else "max_length")
        entries = plural(actual, "entry", "entries")
        return f"has {entries} and must have {_least(loc)}{wanted}", remedy
    if kind == "list_type":
        doubled = " (a list of tables is written with double brackets)"
        return f"must be a list{doubled if isinstance(value, dict) and '[[' in remedy else ''}", remedy
    if kind in ("model_type", "dict_type", "model_attributes_type"):
        return "must be a table of keys and values", remedy
    return None


def _choice(value: object, expected: str, remedy: str) -> tuple[str, str]:
    """A text that is none of those that are known."""
    known = [choice.strip("'\"") for choice in expected.replace(" or ", ", ").split(", ")]
    if len(known) > 3:
        return "is not known", suggestion(str(value), known)
    if len(known) == 1 and remedy:  # where something else may stand, too
        return "is not known", remedy
    close = nearest(str(value), known)
    choices = " or ".join(name if name.isdecimal() else f'"{name}"' for name in known)
    return f"must be {choices}", f'the nearest is "{close}"' if close else "give one of them"


def _unquoted(text: str, remedy: str) -> tuple[str, str] | None:
    """A number or a formula in quotes where a number must stand."""
    if is_number(text):
        return "must be a number, not a text", f"write it without quotes: {text.strip()}"
    try:
        constant = Formula(text).constant
    except ExpressionError:
        return None
    if constant is not None:
        return "must be a number, not a formula", f"write {constant!r}"
    return "must be a number, not a formula, because it cannot vary in time", remedy


_BOUNDS = {
    "greater_than": ("above", "gt"),
    "greater_than_equal": ("at least", "ge"),
    "less_than": ("below", "lt"),
    "less_than_equal": ("at most", "le"),
}


def _least(loc: Loc) -> str:
    """Before the number of entries that a list must have, where it may have more."""
    section, key = sections.SECTIONS.get(section_key(loc[:-1])), str(loc[-1])
    return "at least " if section is not None and key in section.model_fields and is_open_ended(section, key) else ""


def _known(loc: Loc) -> list[str]:
    """The keys of the section in which a key stands."""
    section = sections.SECTIONS.get(section_key(loc[:-1]))
    return list(section.model_fields) if section else []


def _meant(loc: Loc) -> str | None:
    """The key that `_unknown` says is the nearest."""
    return nearest(str(loc[-1]), _known(loc))


def _unknown(loc: Loc, raw: object) -> Problem:
    """An unknown key: the nearest one of its section, or what it belongs to."""
    key, path, known = str(loc[-1]), place(loc, raw), _known(loc)
    names = section_key(loc[:-1])
    kind, form = (SHAPES, names[-1]) if names[:-1] in sections.SHAPE_LISTS else (str(loc[min(1, len(loc) - 1)]), "")
    forms: Mapping[str, type[BaseModel]] = shapes.SHAPES if kind == SHAPES else {}
    if loc[0] == "model" and kind in (*sections.FORMS, INPUTS) and len(loc) > 4:
        forms, form = {**sections.FORMS, INPUTS: INPUTS_BY_FORM}[kind], str(loc[3])
    having = [other for other, having_it in forms.items() if key in having_it.model_fields]
    if having and alias(key, known) is None:
        belongs = ", ".join(_form(kind, other) for other in having)
        if kind == INPUTS and len(having) == 1:
            belongs += f": {forms[having[0]].model_fields[key].description}"
        return Problem(
            path, "", f"leave it out (it belongs to {belongs})", verb=f"has no meaning for {_kind(kind, form)}"
        )
    if nearest(key, known, VERY_SIMILAR) is None and loc[:2] != ("sweep", "vary"):  # a distribution has its own keys
        for word in (key, *ALIASES.get(key, "").split()):
            for names, other in sorted(sections.SECTIONS.items(), key=lambda item: len(item[0])):
                if word in other.model_fields and "*" not in names and names:
                    return Problem(path, "", f'"{word}" belongs in {_header(names)}', verb=f"{UNKNOWN} here")
    return Problem(path, "", suggestion(key, known), verb=UNKNOWN)


def _form(kind: str, form: str) -> str:
    if kind == INPUTS:
        return f"an input with {NEEDED[form]}"
    return DRIVERS[form].noun if kind == "drivers" and "motion" not in DRIVERS[form].model_fields else form


def _kind(kind: str, form: str) -> str:
    """What one of the model's tables is, as a noun."""
    article = "an" if form[0] in "aeio" else "a"
    if kind == INPUTS:
        return _form(kind, form)
    if kind == "joints":
        return f"{article} {form} joint"
    if kind == SHAPES:
        return f"{article} {form}"
    if kind == "contacts":
        return f"a {form} contact"
    if kind == "forces":
        return f"a force of type {form}"
    if kind == "noise":
        return f"noise of type {form}"
    return DRIVERS[form].noun if kind == "drivers" else f"a quantity of type {form}"


def _header(names: tuple[str, ...]) -> str:
    if names[:2] == ("model", "bodies") and len(names) > 2:
        return f"a body's {names[2]}"
    if len(names) > 1 and names[0] == "model":
        return f"[[{written(names[1:2])}]]"
    return f"[[{'.'.join(names[:2])}]]" if len(names) > 1 else f"[{names[0]}]"


def _no_type(kind: str, path: str, value: object) -> Problem:
    """A joint, driver or force whose type is missing or not known."""
    known, remedy = list(sections.FORMS[kind]), f"write it as [[{written([kind])}]]"
    if kind != "drivers" or not isinstance(value, dict):
        return _no_type_of(known, path, value, remedy)
    motions = [form for form, kind_of_driver in DRIVERS.items() if "motion" in kind_of_driver.model_fields]
    if "motion" in value:
        return Problem(f"{path}.motion", "is not known", suggestion(str(value["motion"]), motions), value["motion"])
    if "body" in value:
        return missing(f"{path}.motion", f"give one of {', '.join(motions)}")
    remedy = f"give joint = ..., or body = ... with motion = one of {', '.join(motions)}"
    return Problem(path, "drives nothing", remedy)


def _no_type_of(known: list[str], path: str, value: object, remedy: str) -> Problem:
    """A table whose type is missing or not known, or what is none."""
    if not isinstance(value, dict):
        return Problem(path, "must be a table of keys and values", remedy, value)
    if "type" not in value:
        return missing(f"{path}.type", f"give one of {', '.join(known)}")
    return Problem(f"{path}.type", "is not known", suggestion(str(value["type"]), known), value["type"])


def _no_form(loc: Loc, path: str, value: object, remedy: str) -> Problem:
    """A distribution, rotation or inertia that has none of the known forms."""
    if loc[:2] != ("sweep", "vary"):
        return Problem(path, "has none of the known forms", remedy, value)
    known = named()
    if not isinstance(value, dict):
        return Problem(path, "must be a table", 'give { distribution = "normal", std = ... }', value)
    name = value.get("distribution")
    if isinstance(name, str):
        return Problem(f"{path}.distribution", "is not known", suggestion(name, known), name)
    if any(isinstance(item, dict) for item in value.values()):
        return Problem(path, "a varied path needs quotes", f'write "{_dotted(str(loc[2]), value)}" = {{ ... }}')
    return missing(f"{path}.distribution", f"give one of {', '.join(known)}, or {', '.join(by_key())} instead")


def _dotted(key: str, value: Keys) -> str:
    """The path that was written without quotes, which TOML reads as tables in tables."""
    for name, item in value.items():
        if isinstance(item, dict):
            return _dotted(f"{key}.{name}", item)
    return key


def _remedy(loc: Loc) -> str:
    """What to give instead: the description of the field that the error lies in."""
    for end in range(len(loc) - 1, -1, -1):
        section: type[BaseModel] | None = sections.SECTIONS.get(section_key(loc[:end]))
        field = section.model_fields.get(str(loc[end])) if section else None
        if field is not None:
            return f"give {field.description or 'another'}"
    return ""
