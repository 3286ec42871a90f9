"""Every key of every table that a scenario may have: what is refused, where, by which rule, with which remedy."""

import itertools
import math
import re
from collections import defaultdict
from collections.abc import Iterator
from typing import Any, NamedTuple

import pytest

from lienumba.errors import MISSING, UNKNOWN, Problem
from lienumba.scenario.base.paths import BESIDE, JUDGING, LISTS, written
from lienumba.words import show
from tests.facade import ScenarioError, resolve
from tests.scenario.schema.every_table import FILES, FORM_KEYS, SCHEMA, EveryTable, Keys, Table, branches

# Keys that are read, or looked at by checks of their own, before the schema is: by the form of their table.
READ_FIRST = {
    "scenario": ("extends", "parameters", "files"), "StartSection": ("file", "run", "time"), "Measure": ("function",),
    "TableSection": ("interpolation", "outside"), "Tabulated": ("runs", "samples"), "Output": ("precision",),
}  # fmt: skip
MISPLACED = ("Inertia",)  # whose messages lack the key
OWN_BOUNDS = {("mass", "must be at least"): "must be above 0", ("end_time", "must be above"): "must be at least 1e-100"}
# The rules of values, with how many places break one at least.
RULES = {
    "must be a number": 430, "must be a finite number": 400, "must be a whole number": 9,
    "must be a text in quotes": 130, "must be true or false": 40, "must be a list": 280, "must be a table": 20,
    "has none of the known forms": 3, "has": 560, "must be above": 95, "must be below": 4, "must be at least": 72,
    "must be at most": 36, "is not known": 7, "must be": 25, "is longer than": 2,
}  # fmt: skip
REMEDIES = {"must be true or false": "write it so, without quotes", "is longer than": "shorten it"}


class Offence(NamedTuple):
    """value: in place of that of a key; inside: where in it the problem is."""

    rule: str
    value: Any
    inside: str = ""


def problems(data: Keys) -> dict[str, list[Problem]]:
    """The problems of a scenario by their places, each with a remedy."""
    found = defaultdict(list)
    with pytest.raises(ScenarioError) as caught:
        resolve(data)
    for problem in caught.value.problems:
        assert problem.remedy, str(problem)
        found[problem.place].append(problem)
    return found


def single(found: dict[str, list[Problem]], at: str, words: str) -> Problem:
    """The one problem at a place whose rule, or what is said of the key, begins with these words."""
    those = [x for x in found[at.lstrip(".")] if f"{x.verb}{x.rule}".startswith(words)]
    assert len(those) == 1, (at, words, [*map(str, found[at.lstrip(".")])])
    return those[0]


def described(table: Table, key: str, place: str) -> str:
    """The remedy that is what a key is; of a target's rotation what the target is."""
    around = SCHEMA["$defs"]["RotationError"]["properties"]["target"] if ".target" in place else table.known[key]
    return f"give {around['description']}"


# ------------------------------------------------------------------------------------------------ wrong values
def example(schema: Keys) -> Any:
    """A value of a form."""
    if "enum" in schema:
        return schema["enum"][0]
    if schema.get("type") == "array":
        return [example(branches(schema["items"])[0])] * schema.get("minItems", 1)
    return {"string": "n0"}.get(str(schema.get("type")), 1)


def kind(schema: Keys) -> str:
    """The type of a form; "number" for a number that may be written as a formula."""
    types = schema.get("type", "object")
    return types if isinstance(types, str) else "number"


def of_form(schema: Keys) -> Iterator[Offence]:
    """What a form of a value does not allow."""
    types = kind(schema)
    if "const" in schema or "enum" in schema:
        number = len(schema.get("enum", "1"))
        yield Offence("must be" if number in (2, 3) else "is not known", 17 if types == "integer" else "zzz")
    elif types == "array":
        yield from of_list(schema)
    elif types == "string":
        yield Offence("must be a text in quotes", 3)
        if "maxLength" in schema:
            yield Offence("is longer than", "x" * (schema["maxLength"] + 1))
    elif types == "boolean":
        yield Offence("must be true or false", "yes")
    elif types == "object":
        yield Offence("must be a table", 3)
    else:
        yield from of_number(schema)


def of_number(schema: Keys) -> Iterator[Offence]:
    whole = schema["type"] == "integer"
    yield Offence("must be a whole number" if whole else "must be a number", True)
    if not whole and not (schema["type"] == "number" and {"maximum", "exclusiveMaximum"} & {*schema}):
        yield Offence("must be a finite number", math.nan)
    for bound, rule in (("exclusiveMinimum", "must be above"), ("exclusiveMaximum", "must be below")):
        if bound in schema and schema[bound] < 2**63:  # beyond which no whole number is read
            yield Offence(rule, schema[bound])
    for bound, rule, way in (("minimum", "must be at least", -1), ("maximum", "must be at most", 1)):
        if bound in schema:
            limit = schema[bound]
            yield Offence(rule, limit + way if whole else math.nextafter(limit, math.inf * way))


def of_list(schema: Keys) -> Iterator[Offence]:
    forms, fewest = branches(schema["items"]), schema.get("minItems", 1)
    yield Offence("must be a list", True)
    for bound, step in (("minItems", -1), ("maxItems", 1)):
        if bound in schema:
            yield Offence("has", [example(forms[0])] * (schema[bound] + step))
    for rule, value, inside in of_forms(forms):
        yield Offence(rule, [value, *[example(forms[0])] * (fewest - 1)], f"[0]{inside}")


def of_forms(forms: list[Keys]) -> Iterator[Offence]:
    """What no form of a value allows."""
    kinds = [kind(x) for x in forms]
    if {*kinds} == {"object"} or len(forms) == 1:
        yield from of_form(forms[0])
        return
    if "array" in kinds and {*kinds} <= {"array", "object"}:
        yield Offence("has none of the known forms", True)
    for form, type_ in zip(forms, kinds, strict=True):
        if type_ in ("number", "integer", "array") or {"enum", "const"} & {*form}:
            yield from (x for x in of_form(form) if type_ != "array" or isinstance(x.value, list))


def check(problem: Problem, offence: Offence, schema: Keys, remedy: str) -> None:
    """Whether a problem has the value, and the remedy of its rule."""
    value = offence.value
    for _ in range(offence.inside.count("[")):
        value = value[0]
    assert str(problem) == f"{problem.place} = {show(value)}: {problem.rule}; {problem.remedy}"
    if offence.rule in ("is not known", "must be"):
        choices = [str(x) for form in branches(schema) for x in form.get("enum", ())]
        assert all(x in str(problem) for x in choices), str(problem)
    elif offence.rule == "must be a finite number" and offence.inside:
        assert problem.remedy == "replace it"
    else:
        assert problem.remedy == REMEDIES.get(offence.rule, remedy), str(problem)


@pytest.mark.parametrize("rule", RULES)
def test_wrong_values(rule: str) -> None:
    """Each key with the first value that breaks the rule, then each with its second, and so on."""
    number = 0
    for turn in itertools.count():
        every, wrong = EveryTable(), defaultdict[int, dict[str, Offence]](dict)
        for table in every.tables:
            left = table.changeable(rule)
            for key in left - {*READ_FIRST.get(table.form, ())} if table.form not in MISPLACED else ():
                offences = [x for x in of_forms(branches(table.known[key])) if x.rule == rule]
                if turn < len(offences):
                    table.keys[key] = offences[turn].value
                    wrong[id(table)][key] = offences[turn]
        if not wrong:
            break
        found = problems(every.data)
        for place, table in every.placed():
            for key, offence in wrong[id(table)].items():
                problem = single(found, f"{place}.{key}{offence.inside}", OWN_BOUNDS.get((key, rule), rule))
                check(problem, offence, table.known[key], described(table, key, place))
                number += 1
    assert number >= RULES[rule]


BOUNDS = {
    r"above 0\b": ("exclusiveMinimum", 0),
    r"at least 0\b|0 or above": ("minimum", 0),
    r"at least 1\b": ("minimum", 1),
}
RANGE = re.compile(r"from (-?[\d.]+) (?:\([^)]*\) )?to (-?[\d.,]*\d)")
CHECKED_ELSEWHERE = ("mass", "velocity", "relative", "tolerance", "seed", "limit")  # whose bounds no schema has


def parts(schema: Keys) -> Iterator[Keys]:
    """A value's forms, and those of what is in it."""
    for form in branches(schema):
        yield form
        for inner in (form.get("items"), form.get("additionalProperties")):
            yield from parts(inner) if isinstance(inner, dict) else ()


def test_numbers_have_the_bounds_that_are_said_of_them() -> None:
    keys = {(table.form, key): x for table in EveryTable().tables for key, x in table.known.items()}
    said = 0
    for (form, key), schema in keys.items():
        if key in CHECKED_ELSEWHERE:
            continue
        text, found = schema.get("description", ""), [*parts(schema)]
        for pattern, (bound, limit) in BOUNDS.items():
            if re.search(pattern, text):
                assert any(x.get(bound) == limit for x in found), (form, key, text)
                said += 1
        for low, high in RANGE.findall(text):
            limits = float(low), float(high.replace(",", ""))
            assert any((x.get("minimum"), x.get("maximum")) == limits for x in found), (form, key, text)
            said += 1
    assert said > 90


# ------------------------------------------------------------------------------------------------- which keys
def test_every_key_of_the_schema_is_visited() -> None:
    every = EveryTable()
    forms = {form: x["properties"] for form, x in SCHEMA["$defs"].items() if form not in FILES}
    assert {(form, key) for form, keys in forms.items() for key in keys} <= {
        (table.form, key) for table in every.tables for key in table.known
    }
    assert len([*every.placed()]) == len(every.tables)


def test_missing_keys() -> None:
    every, number = EveryTable(), 0
    found = problems(every.data)
    for place, table in every.placed():
        for key in {*table.required} - {*table.keys} if table.form not in MISPLACED else ():
            problem = single(found, f"{place}.{key}", MISSING)
            assert str(problem) == f"{problem.place} is missing; {described(table, key, place)}"
            number += 1
    assert number > 150


def test_misspelt_keys() -> None:
    """Such a key is not missing as well."""
    every, number = EveryTable(), 0
    misspelt = [x for x in every.tables if x.form not in (*MISPLACED, "TableSection", "SciPy")]
    for table in misspelt:
        table.keys |= {f"{key}_": 1 for key in table.known if key not in table.keys}
    found = problems(every.data)
    for place, table in every.placed():
        for key in [key for key in table.keys if key.endswith("_")]:
            problem = single(found, f"{place}.{key}", UNKNOWN)
            if ".target" not in place:  # whose keys are not known
                assert problem.remedy == f'the nearest known name is "{key[:-1]}"'
                assert key[:-1] not in table.required or f"{place}.{key[:-1]}".lstrip(".") not in found
            number += 1
    assert number > 600


def test_keys_of_other_forms() -> None:
    every, number = EveryTable(), 0
    foreign: dict[int, set[str]] = {}
    keys = {form: x["properties"] for form, x in SCHEMA["$defs"].items()}
    for table in every.tables:
        telling = {key for x in table.siblings for key in ("motion", "distribution", *FORM_KEYS.get(x, ()))}
        foreign[id(table)] = {key for form in table.siblings for key in keys[form]} - {*table.known} - telling
        table.keys |= dict.fromkeys(foreign[id(table)], 1)
    found = problems(every.data)
    for place, table in every.placed():
        for key in foreign[id(table)] if place.startswith(("model.", "quantities.", "noise.")) else ():
            (problem,) = found[f"{place}.{key}"]
            having = [x for x in table.siblings if key in keys[x]]
            if problem.verb == UNKNOWN:  # by the name that another program has for one of its own
                assert any(problem.remedy == f'the nearest known name is "{x}"' for x in table.known), str(problem)
            else:
                assert problem.verb.startswith("has no meaning for ")
                assert problem.remedy.count(",") == len(having) - 1, str(problem)
                assert all(f"{keys[x]['type']['const']}" in problem.remedy for x in having if "type" in keys[x])
                number += 1
    assert number > 1000


REFERENCES = {"body": "body", "bodies": "body", "relative_to": "body", "joint": "joint", "joints": "joint"}
REFERENCES |= {kind: kind for kind in ("driver", "contact", "limit")}
WHERE_ALL_ELSE_IS_RIGHT = ("Gear", "Coupler", "Actuator", "EndStop", "Event", "TrackingInput", "ModelSection")


def test_names_of_what_is_not_there() -> None:
    every, number = EveryTable(), 0
    for table in every.tables:
        for key in REFERENCES.keys() & table.known.keys() if table.form not in WHERE_ALL_ELSE_IS_RIGHT else ():
            if kind(branches(table.known[key])[0]) in ("string", "array"):
                table.keys[key] = ["zzz", "zzy"] if "array" in str(table.known[key]) else f"zz{key}"
    found = problems(every.data)
    for place, table in every.placed():
        for key in REFERENCES.keys() & table.keys.keys() if table.form not in WHERE_ALL_ELSE_IS_RIGHT else ():
            listed = isinstance(table.keys[key], list)
            for at in [f"{place}.{key}[{n}]" for n in (0, 1)] if listed else [f"{place}.{key}"]:
                single(found, at, f"is not a {REFERENCES[key]} of the model")
                number += 1
    assert number > 75


# ------------------------------------------------------------------------------- tables of no form, and their names
LISTED = {**SCHEMA["$defs"]["ModelSection"]["properties"], **SCHEMA["properties"]}
LISTED = {key: x for key, x in LISTED.items() if key in LISTS}
# The names of the forms of each list that has several; drivers have no names of forms.
TYPES = {key: [*x["items"]["discriminator"]["mapping"]] for key, x in LISTED.items() if "discriminator" in x["items"]}


def with_lists(lists: Keys) -> dict[str, list[Problem]]:
    """The problems of a scenario with these lists of tables."""
    return problems(
        {"model": {kind: x for kind, x in lists.items() if kind not in BESIDE}}
        | {kind: x for kind, x in lists.items() if kind in BESIDE}
    )


def test_what_is_no_table() -> None:
    sections = {key: x for key, x in SCHEMA["properties"].items() if kind(branches(x)[0]) == "object"}
    found = problems({key: 3 for key in sections if key not in BESIDE})
    for key in sections.keys() - {*BESIDE}:
        problem = single(found, key, "must be a table of keys and values")
        assert str(problem) == f"{key} = 3: {problem.rule}; give {sections[key]['description']}"
    found = with_lists(dict.fromkeys(LISTED, 3))
    for key, x in LISTED.items():
        problem = single(found, written([key]), "must be a list")
        assert str(problem) == f"{problem.place} = 3: must be a list; give {x['description']}"
    found = with_lists({key: [3] for key in LISTED})
    for key, x in LISTED.items():
        problem = single(found, f"{written([key])}[0]", "must be a table of keys and values")
        assert problem.remedy in (f"give {x['description']}", f"write it as [[{written([key])}]]")


def test_no_known_form() -> None:
    found = with_lists({kind: [{"name": f"{kind}_a", "type": "zzz"}, {"name": f"{kind}_b"}] for kind in TYPES})
    for kind, types in TYPES.items():
        at = written([kind])
        unknown, absent = (
            single(found, f"{at}.{kind}_a.type", "is not known"),
            single(found, f"{at}.{kind}_b.type", MISSING),
        )
        assert all(f'"{x}"' in unknown.remedy for x in types), str(unknown)
        assert {*absent.remedy.removeprefix("give one of ").split(", ")} == {*types}


def test_names() -> None:
    wrong = ["a b", "twin", "twin", "x" * 101, "ground"]
    first = {"drivers": {"joint": "a"}, "measures": {"value": "max(t)"}} | {k: {"type": x[0]} for k, x in TYPES.items()}
    lists = {kind: [{"name": name} | first.get(kind, {}) for name in wrong] for kind in LISTED if kind != "noise"}
    lists["noise"] = [{"name": name, "type": "white"} for name in ("c d", "two", "two")]  # others than of quantities
    found = with_lists(lists)
    for kind in LISTED:
        at = written([kind])
        assert single(found, f"{at}[2].name", "is also the name of").rule == f"is also the name of {at}[1]"
        if kind not in JUDGING:  # whose names are words
            single(found, f"{at}.{lists[kind][0]['name']}.name", "is no valid name")
        if kind != "noise":
            single(found, f"{at}.{wrong[3]}.name", "is longer than ")
            single(found, f"{at}[4].name", "is reserved for the fixed world")
