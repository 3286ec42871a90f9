"""Every path of `sweep.vary` must lead to a number of the model that its distribution suits."""

from math import erfc, sqrt
from sys import float_info
from typing import TYPE_CHECKING, Any

from pydantic import TypeAdapter, ValidationError
from pydantic.fields import FieldInfo

from lienumba.expressions import ExpressionError, Formula
from lienumba.scenario import paths
from lienumba.scenario.schema import LISTS, MOST_RUNS, SECTIONS, section_of
from lienumba.scenario.words import printable, show, suggestion
from lienumba.sweep.distributions import Distribution, Normal, Uniform

if TYPE_CHECKING:
    from lienumba.scenario.parameters import Parameters
    from lienumba.scenario.report import Report

# Numbers that must be above 0 in every run, and who says so.
POSITIVE = {"mass": "no body has", "length": "no rod has", "velocity": "no friction sets in at"}
EVERY = "every"  # the key of the interval of a sampled law
ONE_INTERVAL = "is the interval of a sampled law, which is the same in all runs; run a scenario for each interval"
RARE = 1e-3  # expected number of unphysical runs of a sweep that deserves a warning


def check_sweep(sweep: dict[str, Any], model: dict[str, Any], parameters: "Parameters", report: "Report") -> None:
    """Check the varied paths against the model as written, gravity's default included."""
    vary, runs = sweep.get("vary", {}), sweep.get("runs", 1)
    if not isinstance(vary, dict):
        return
    if not isinstance(runs, int) or not 1 <= runs <= MOST_RUNS:
        runs = 1
    if vary and "runs" not in sweep:
        report.problems.append("sweep.runs is missing; give a whole number of runs, at least 1")
    if runs > 1 and not vary:
        report.warnings.append(f"sweep.runs = {runs}: sweep.vary is empty, so all runs are the same")
    _check_intervals(vary, parameters, report)
    seen: dict[str, str] = {}
    for path, entry in vary.items():
        if _is_nested(entry):
            continue  # a path without its quotes, which `messages` explains
        try:
            nominal = _nominal(path, model, parameters)
            name = paths.canonical(path, model)
            if name in seen:
                raise paths.PathError(f'is the same number as "{seen[name]}"; vary it once')
            seen[name] = path
        except paths.PathError as error:
            shown = printable(path)
            report.problems.append(f'sweep.vary."{shown}": the path {shown} {error}')
            continue
        if nominal is None:
            continue
        try:
            distribution = TypeAdapter(Distribution).validate_python(entry)
        except ValidationError:
            continue
        _check_range(name, nominal, distribution, runs, report)


def _check_intervals(vary: dict[str, Any], parameters: "Parameters", report: "Report") -> None:
    """The interval of a sampled law may depend on no varied parameter."""
    varied = {path.removeprefix("parameters.") for path in vary if path.startswith("parameters.")}
    for tokens, formula in parameters.places.items():
        found = sorted(parameters.all_used(formula) & varied)
        if tokens[-1] == EVERY and found:
            path = f"parameters.{found[0]}"
            report.problems.append(
                f'sweep.vary."{path}": model.{paths.text_of(list(tokens))} = {show(formula.text)} depends on it and '
                f"{ONE_INTERVAL}"
            )


def _is_nested(entry: Any) -> bool:
    return isinstance(entry, dict) and any(isinstance(item, dict) for item in entry.values())


def _nominal(path: str, model: dict[str, Any], parameters: "Parameters") -> float | None:
    """The number that a path leads to; PathError if none may vary; None if the model is wrong there."""
    tokens = paths.parse(path)
    if tokens[0] == "parameters":
        return _parameter(tokens, parameters)
    formula = parameters.places.get(tuple(paths.named(tokens, model)))
    if formula is not None and formula.used:
        names = [f"parameters.{name}" for name in sorted(formula.used - {"t"})]
        raise paths.PathError(f"is the formula {show(formula.text)}; vary {' or '.join(names)} instead")
    tokens = tokens[1:] if tokens[0] == "model" else tokens
    if tokens and tokens[0] == "tables":
        raise paths.PathError("is part of a table; multiply the table by a parameter, and vary that")
    if tokens and tokens[-1] == EVERY:
        raise paths.PathError(ONE_INTERVAL)
    if tokens and tokens[0] in {names[0] for names in SECTIONS if names} - {"model"}:
        raise paths.PathError("is not part of the model; vary a number of the model, such as bodies.top.mass")
    try:
        value = paths.get(model, tokens)
    except paths.PathError:
        field = _omitted_field(tokens, model)
        if field is None:
            raise paths.PathError(f"does not exist; {paths.nearest_path(path, model)}") from None
        if field.is_required():
            return None
        raise paths.PathError("leads to a key that is omitted; give its nominal value first") from None
    if isinstance(value, str) and not paths.TEXT_KEYS.intersection(tokens[2:]):
        if tokens[0] not in paths.WITH_FORMULAS:
            return None
        value = _constant(value)
        if value is None:
            return None
    if isinstance(value, list) and any(isinstance(item, float | int | str) for item in value):
        raise paths.PathError(f"is not a number but the list {show(value)}; vary one, such as {path}[0]")
    if isinstance(value, bool) or not isinstance(value, float | int):
        raise paths.PathError(f"is not a number but {show(value)}; {paths.nearest_path(path, model)}")
    _refuse_parts_of_matrices(tokens)
    return float(value) if abs(value) <= float_info.max else None


def _parameter(tokens: list[paths.Token], parameters: "Parameters") -> float:
    """The nominal value of a parameter that is a number."""
    name = str(tokens[1]) if len(tokens) == 2 else ""
    if name in parameters.formulas:
        formula = parameters.formulas[name]
        if formula.constant is not None:
            return formula.constant
        used = " or ".join(f"parameters.{other}" for other in sorted(formula.used))
        raise paths.PathError(f"is the formula {show(formula.text)}; vary {used or 'a number'} instead")
    if name not in parameters.numbers:
        raise paths.PathError(f"does not exist; {suggestion(name, parameters.numbers)}")
    return parameters.numbers[name]


def _constant(text: str) -> float | None:
    """The number that a formula is, if it does not depend on the time; None if it is no formula."""
    try:
        formula = Formula(text)
    except ExpressionError:
        return None
    if formula.constant is None:
        raise paths.PathError(f"is the formula {show(text)}, which varies in time; vary a number")
    return formula.constant


def _omitted_field(tokens: list[paths.Token], model: dict[str, Any]) -> FieldInfo | None:
    """The known key of an existing body, joint, driver or force that a path leads to, if the file leaves it out."""
    if len(tokens) < 3 or tokens[0] not in LISTS:
        return None
    try:
        item = paths.get(model, tokens[:2])
    except paths.PathError:
        return None
    section = section_of(str(tokens[0]), item)
    fields = section.model_fields if section is not None else {}
    return fields.get(str(tokens[2])) if tokens[2] not in item else None


def _refuse_parts_of_matrices(tokens: list[paths.Token]) -> None:
    """An element of a matrix cannot vary alone where the matrix must stay symmetric or orthogonal."""
    if tokens[0] != "bodies" or len(tokens) < 5 or not isinstance(tokens[-2], int):
        return
    if tokens[-3] == "rotation":
        raise paths.PathError(
            "is an element of a rotation matrix, which must stay orthogonal; "
            "give the rotation as quaternion, {axis, angle} or {euler, angles} and vary that"
        )
    if tokens[-3] == "inertia" and tokens[-2] != tokens[-1]:
        raise paths.PathError(
            "is an element of a 3x3 inertia, which must stay symmetric; "
            "give the inertia as 6 elements xx yy zz xy xz yz and vary one of them"
        )


def _check_range(path: str, nominal: float, given: Normal | Uniform, runs: int, report: "Report") -> None:
    """Distributions relative to 0, and those that draw masses or lengths which no body can have."""
    at = f'sweep.vary."{path}"'
    if given.relative and nominal == 0.0:
        report.problems.append(
            f"{at}.relative = true: must be false for a nominal value of 0, of which every multiple is 0; "
            "leave it out and give absolute numbers"
        )
        return
    key = path.rpartition(".")[2]
    if key not in POSITIVE or ".parameters." in path or nominal <= 0.0:
        return
    factor = nominal if given.relative else 1.0
    if isinstance(given, Uniform):
        if given.low * factor <= 0.0:
            report.problems.append(
                f"{at}.low = {given.low!r}: allows values of 0 or below, which {POSITIVE[key]}; give low above 0"
            )
        return
    mean = nominal if given.mean is None else given.mean * factor
    if mean <= 0.0:
        report.problems.append(f"{at}.mean = {given.mean!r}: must be above 0; give the mean of {path}")
    elif given.std > 0.0:
        expected = 0.5 * erfc(mean / (given.std * factor) / sqrt(2.0)) * runs
        if expected > RARE:
            report.warnings.append(
                f"{at}: of {runs} runs about {expected:.2g} will draw a value of 0 or below and fail; "
                "give a smaller std, or a uniform distribution"
            )
