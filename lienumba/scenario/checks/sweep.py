"""Every path of `sweep.vary` must lead to a number of the model that its distribution suits."""

import re
from functools import cache
from sys import float_info
from typing import Any, cast

from pydantic import BaseModel, TypeAdapter, ValidationError
from pydantic.fields import FieldInfo

from lienumba.groups import so3
from lienumba.keys.conversions import has_rows, inertia_of, rotation_of, timed
from lienumba.keys.facts import is_choice
from lienumba.keys.types import Inertia, Rotation, Section, Vec3
from lienumba.mechanics.elements.quantities import QUANTITIES
from lienumba.numerics.expressions import Formula
from lienumba.numerics.grammar import ExpressionError
from lienumba.numerics.number import Vector
from lienumba.scenario.base import paths
from lienumba.scenario.base.paths import LISTS
from lienumba.scenario.base.problems import Report, read, tables
from lienumba.scenario.base.toml import Keys
from lienumba.scenario.checks.ranges import check_range, refused_below
from lienumba.scenario.checks.samplers import check_sampler, check_table, no_path
from lienumba.scenario.formulas.dependent_inputs import check_derived
from lienumba.scenario.formulas.parameters import Parameters
from lienumba.scenario.schema.sections import SECTIONS, section_of
from lienumba.scenario.schema.sweep import MOST_RUNS
from lienumba.sweep.distributions.base import INERTIA, NUMBER, ROTATION, VECTOR, Distribution
from lienumba.sweep.distributions.registry import DISTRIBUTIONS, form_of
from lienumba.words import printable, show, suggestion

EVERY = "every"  # the key of the interval of a sampled law
ONE_INTERVAL = "is the interval of a sampled law, which is the same in all runs", "run a scenario for each interval"
# What varies as a whole: its name, the last keys of its paths, and its type.
WHOLES: dict[str, tuple[str, tuple[str, ...], Any]] = {
    ROTATION: ("a rotation", ("rotation",), Rotation),
    INERTIA: ("an inertia", ("inertia",), Inertia),
    VECTOR: ("a vector of 3 numbers", (), Vec3),
}


def check_sweep(sweep: Keys, model: Keys, parameters: Parameters, report: Report) -> None:
    """Check the varied paths against the model as written, gravity's default included."""
    vary, runs = sweep.get("vary", {}), sweep.get("runs", 1)
    if not isinstance(vary, dict):
        return
    if not isinstance(runs, int) or not 1 <= runs <= MOST_RUNS:
        runs = 1
    if vary and "runs" not in sweep:
        report.miss("sweep.runs", "give a whole number of runs, at least 1")
    if runs > 1 and not vary and not model.get("noise"):
        report.warn("sweep.runs", "sweep.vary is empty, so all runs are the same", value=runs)
    for noise in tables(model.get("noise", [])):
        rows = noise.get("runs")
        if isinstance(rows, int) and runs > rows:
            at = f"noise.{noise.get('name')}.table"
            report.add(at, f"has courses of {rows} runs, and sweep.runs is {runs}", "give more courses, or fewer runs")
    _check_intervals(vary, parameters, report)
    seen: dict[str, str] = {}
    parts: dict[str, str] = {}
    kinds: dict[str, Distribution] = {}
    before = len(report.problems)
    for path, entry in vary.items():
        if _is_nested(entry):
            continue  # a path without its quotes, which `messages` explains
        kind = _kind(entry)
        shape = kind.shape if kind is not None else DISTRIBUTIONS[form].leads_to if (form := form_of(entry)) else NUMBER
        try:
            nominal = nominal_of(path, model, parameters, shape)
            name = paths.canonical(path, model)
            _refuse_overlap(name, path, seen, parts)
        except paths.PathError as error:
            shown = printable(path)
            unmapped = isinstance(entry, dict) and entry.get("column") == path
            report.problems.append(
                no_path(path, error) if unmapped else error.of(shown).inside(f'sweep.vary."{shown}"')
            )
            continue
        if kind is not None:
            kinds[name] = kind
            if nominal is not None:
                check_range(name, nominal, kind, runs, refused_below(name, model), report)
    if len(kinds) == len(vary) and len(report.problems) == before:
        check_derived(kinds, parameters, report)
    check_table(sweep, kinds, report)
    if len(kinds) == len(vary):
        check_sampler(sweep, kinds, model, report)


@cache
def _adapter(kind: Any) -> TypeAdapter[Any]:
    return TypeAdapter(kind)


def _kind(entry: object) -> Distribution | None:
    """How an input varies; None where that is wrong in itself."""
    form = form_of(entry)
    return None if form is None else read(DISTRIBUTIONS[form], entry)


def _refuse_overlap(name: str, path: str, seen: dict[str, str], parts: dict[str, str]) -> None:
    """A number varies once: neither under two names, nor alone and as a part. seen: the paths so far by their names;
    parts: by the names of all that they are parts of."""
    if name in seen:
        raise paths.PathError(f'is the same number as "{seen[name]}"', "vary it once")
    around = [name[: match.start()] for match in re.finditer(r"[.\[]", name)]
    other = parts.get(name) or next((seen[outer] for outer in around if outer in seen), None)
    if other is not None:
        raise paths.PathError(f'varies together with "{other}", of which one is a part of the other', "vary it once")
    seen[name] = path
    for outer in around:
        parts.setdefault(outer, path)


def _check_intervals(vary: Keys, parameters: Parameters, report: Report) -> None:
    """The interval of a sampled law may depend on no varied parameter."""
    varied = {path.removeprefix("parameters.") for path in vary if path.startswith("parameters.")}
    for tokens, formula in parameters.places.items():
        found = sorted(parameters.all_used(formula) & varied)
        if tokens[-1] == EVERY and found:
            path = f"parameters.{found[0]}"
            (rule, remedy), text = ONE_INTERVAL, f"{paths.written(tokens)} = {show(formula.text)}"
            report.add(f'sweep.vary."{path}"', f"{text} depends on it and {rule}", remedy)


def _is_nested(entry: object) -> bool:
    return isinstance(entry, dict) and any(isinstance(item, dict) for item in entry.values())


def nominal_of(path: str, model: Keys, parameters: Parameters, shape: str) -> Any:
    """The number that a path leads to, or those of a whole; PathError if none may vary; None if the model is wrong
    there."""
    tokens = paths.parse(path)
    if tokens[0] == "parameters":
        if shape != NUMBER:
            raise paths.PathError(
                f"is a parameter, which is a number, not {WHOLES[shape][0]}", "give a distribution of one"
            )
        return _parameter(tokens, parameters)
    _refuse_formulas(tuple(paths.named(tokens, model)), parameters)
    tokens = tokens[1:] if tokens[0] == "model" else tokens
    if tokens and (tokens[0] == "tables" or paths.is_recording(tokens)):
        raise paths.PathError("is part of a table", "multiply the table by a parameter, and vary that")
    if tokens and tokens[-1] == EVERY:
        raise paths.PathError(*ONE_INTERVAL)
    if tokens and tokens[0] in {names[0] for names in SECTIONS if names} - {"model"}:
        raise paths.PathError("is not part of the model", "vary a number of the model, such as bodies.top.mass")
    try:
        value = paths.get(model, tokens)
    except paths.PathError:
        field = _omitted_field(tokens, model)
        if field is None:
            raise paths.PathError("does not exist", paths.nearest_path(path, model)) from None
        if field.is_required():
            return None
        raise paths.PathError("leads to a key that is omitted", "give its nominal value first") from None
    if shape != NUMBER:
        return _whole(value, tokens, shape)
    if isinstance(value, str) and not paths.holds_text(tokens) and "shapes" not in tokens:
        if tokens[0] not in paths.WITH_FORMULAS:
            return None
        value = _constant(value)
        if value is None:
            return None
    if isinstance(value, list) and any(isinstance(item, float | int | str) for item in value):
        raise paths.PathError(f"is not a number but the list {show(value)}", f"vary one, such as {path}[0]")
    if isinstance(value, bool) or not isinstance(value, float | int):
        raise paths.PathError(f"is not a number but {show(value)}", paths.nearest_path(path, model))
    _refuse_parts_of_matrices(tokens)
    _refuse_choices(tokens, model)
    return float(value) if abs(value) <= float_info.max else None


def _refuse_formulas(tokens: tuple[paths.Token, ...], parameters: Parameters) -> None:
    """What is a formula, or has one in it, follows its parameters."""
    for place, formula in parameters.places.items():
        if place[: len(tokens)] == tokens and formula.used:
            known = [x for x in sorted(formula.used) if x in parameters.numbers or x in parameters.formulas]
            names = " or ".join(f"parameters.{name}" for name in known)
            is_or_has = "is" if place == tokens else "has"
            remedy = f"vary {names} instead" if names else "write a parameter into it, and vary that"
            raise paths.PathError(f"{is_or_has} the formula {show(formula.text)}", remedy)


def _whole(value: object, tokens: list[paths.Token], shape: str) -> Any:
    """The nominal numbers of what varies as a whole; None where they are wrong in themselves."""
    what, keys, kind = WHOLES[shape]
    if shape == ROTATION and tokens[0] == "quantities":
        keys = (*keys, *(key for q in QUANTITIES.values() for key in q.rotations))
    if keys and (tokens[-1] not in keys or "parameters" in tokens[2:]):  # a law of one's own has numbers of any name
        raise paths.PathError(f"does not lead to {what}", "give one, or a distribution of a number")
    try:
        adapter = _adapter(kind)
        found = nominal_numbers(adapter.validate_python(value), shape)
        return None if shape == ROTATION and not any(cast(Vector, found)) else found
    except (ValidationError, ArithmeticError):  # the latter: an axis without length, a matrix of zeros
        if keys:
            return None  # the schema says so, or the check of bodies
    raise paths.PathError(f"is not {what} but {show(value)}", "give the path of one")


def nominal_numbers(value: object, shape: str) -> float | Vector:
    """The number of a varied path, or those that the design table has of it: a quaternion w x y z for a rotation, the
    elements xx yy zz xy xz yz of an inertia, the components of a vector. value: checked."""
    if shape == NUMBER:
        return cast(float, timed(value))
    if shape == INERTIA:
        return inertia_of(cast(Inertia, value))
    if shape == ROTATION and (isinstance(value, Section) or has_rows(value)):
        return so3.to_quaternion(rotation_of(cast(Rotation, value)))
    assert isinstance(value, list)
    return tuple(map(timed, value))


def _parameter(tokens: list[paths.Token], parameters: Parameters) -> float:
    """The nominal value of a parameter that is a number."""
    name = str(tokens[1]) if len(tokens) == 2 else paths.text_of(tokens[1:])
    listed = [x for x in parameters.numbers if x.startswith(f"{name}[")]
    if listed:
        raise paths.PathError("is a list of numbers", f"vary one of them, such as parameters.{listed[0]}")
    if name in parameters.formulas:
        formula = parameters.formulas[name]
        if formula.constant is not None:
            return formula.constant
        used = " or ".join(f"parameters.{other}" for other in sorted(formula.used))
        raise paths.PathError(f"is the formula {show(formula.text)}", f"vary {used or 'a number'} instead")
    if name not in parameters.numbers:
        raise paths.PathError("does not exist", suggestion(name, parameters.numbers))
    return parameters.numbers[name]


def _constant(text: str) -> float | None:
    """The number that a formula is, if it does not depend on the time; None if it is no formula."""
    try:
        formula = Formula(text)
    except ExpressionError:
        if not _is_condition(text):
            return None
        raise paths.PathError(f"is the condition {show(text)}", "write a parameter into it, and vary that") from None
    if formula.constant is None:
        raise paths.PathError(f"is the formula {show(text)}, which varies in time", "vary a number")
    return formula.constant


def _is_condition(text: str) -> bool:
    try:
        Formula(text, condition=True)
    except ExpressionError:
        return False
    return True


def _omitted_field(tokens: list[paths.Token], model: Keys) -> FieldInfo | None:
    """The known key of an existing body, joint, driver or force that a path leads to, if the file leaves it out."""
    item, section = _element(tokens, model)
    fields = section.model_fields if section is not None else {}
    return fields.get(str(tokens[2])) if fields and tokens[2] not in item else None


def _element(tokens: list[paths.Token], model: Keys) -> tuple[Keys, type[BaseModel] | None]:
    """The table of a list of the model, or the input, in which a path ends, and its class as far as that is known."""
    if len(tokens) < 3 or tokens[0] not in (*LISTS, paths.INPUTS):
        return {}, None
    try:
        item = paths.get(model, tokens[:2])
    except paths.PathError:
        return {}, None
    return (item, section_of(str(tokens[0]), item)) if isinstance(item, dict) else ({}, None)


def _refuse_choices(tokens: list[paths.Token], model: Keys) -> None:
    """What shapes the equations is no number that differs from run to run."""
    _, section = _element(tokens, model)
    known = section is not None and len(tokens) == 3 and tokens[2] in section.model_fields
    if section is not None and known and is_choice(section, str(tokens[2])):
        raise paths.PathError("chooses what is computed, which is the same in all runs", "vary a number of the model")


def _refuse_parts_of_matrices(tokens: list[paths.Token]) -> None:
    """An element of a matrix cannot vary alone where the matrix must stay symmetric or orthogonal."""
    if tokens[0] != "bodies" or len(tokens) < 5 or not isinstance(tokens[-2], int):
        return
    if tokens[-3] == "rotation":
        raise paths.PathError(
            "is an element of a rotation matrix, which must stay orthogonal",
            "give the rotation as quaternion, {axis, angle} or {euler, angles} and vary that",
        )
    if tokens[-3] == "inertia" and tokens[-2] != tokens[-1]:
        raise paths.PathError(
            "is an element of a 3x3 inertia, which must stay symmetric",
            "give the inertia as 6 elements xx yy zz xy xz yz and vary one of them",
        )
