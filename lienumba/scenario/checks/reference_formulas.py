"""A reference in closed form: formulas of the time and of parameters for positions, rotations and velocities of bodies.

Velocities that are omitted are the derivatives of positions and rotations.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from typing import Any

import numpy as np
from pydantic import TypeAdapter, ValidationError

from lienumba.groups import so3
from lienumba.keys.conversions import rotation_of
from lienumba.keys.formulas import explained
from lienumba.keys.types import Rotation, Vec3, rotation_keys
from lienumba.numerics.expressions import Formula
from lienumba.numerics.grammar import ExpressionError
from lienumba.numerics.jets import Jet, lift
from lienumba.scenario.base.problems import Report
from lienumba.scenario.checks.bodies import check_rotation
from lienumba.scenario.formulas.parameters import TIME, Parameters
from lienumba.scenario.study_errors import STATE, Truth
from lienumba.words import suggestion

RATES = {"position": "velocity", "rotation": "angular_velocity"}
FORMS: dict[str, tuple[Any, str]] = {
    "rotation": (Rotation, "a rotation in one of its five forms, of numbers or formulas of t and parameters"),
    **dict.fromkeys(("position", "velocity", "angular_velocity"), (Vec3, "3 numbers, or formulas of t and parameters")),
}


def check_formulas(reference: Mapping[str, Any], bodies: Sequence[str], parameters: Parameters, report: Report) -> None:
    """Check names, formulas and forms."""
    for variable, listed in reference.items():
        at = f"study.reference.{variable}"
        if not isinstance(listed, dict) or not listed:
            report.add(at, "must be a table", 'give { body = ["sin(t)", 0, 0] }', listed)
            continue
        for body, value in listed.items():
            if body not in bodies:
                report.add(f"{at}.{body}", "is not a body of the model", suggestion(body, bodies))
                continue
            before = len(report.problems)
            at_start = _map(value, lambda text, place: _at_start(text, place, parameters, report), f"{at}.{body}")
            if len(report.problems) == before:
                _check_form(f"{at}.{body}", variable, value, at_start, report)


def used(reference: Mapping[str, Any], parameters: Parameters) -> set[str]:
    """The parameters on which a reference depends."""
    found: set[str] = set()

    def note(text: str, _: str) -> None:
        with suppress(ExpressionError):
            found.update(parameters.all_used(Formula(text, frozenset({TIME, *parameters.values()}))))

    for variable in reference.keys() & set(STATE):
        _map(reference[variable], note, "")
    return found


def truth(
    reference: Mapping[str, Any], parameters: Parameters, samples: Mapping[str, Any], times: Sequence[float]
) -> Truth:
    """What the formulas say at these times (s); samples: by path, (runs,)."""
    t = Jet(np.asarray(times, float), 1.0)
    values = {name: np.reshape(x, (-1, 1)) for name, x in parameters.values(samples).items()}
    names = frozenset({TIME, *values})

    def number(text: str, _: str) -> Any:
        formula = Formula(text, names)
        return formula(t, **{name: values[name] for name in formula.used - {TIME}})

    def spread(numbers: Iterable[Any]) -> list[np.ndarray]:
        return list(np.broadcast_arrays(*(np.asarray(x, float) for x in numbers), np.zeros((1, len(times)))))[:-1]

    found: dict[str, dict[str, np.ndarray]] = {name: {} for name in STATE}
    with np.errstate(all="ignore"):
        for variable, listed in reference.items():
            for body, written in listed.items():
                value = _map(written, number, "")
                jets = [lift(x) for x in (rotation_of(rotation_keys(value)) if variable == "rotation" else value)]
                x, rate = spread(x.a for x in jets), spread(x.b for x in jets)
                if variable == "rotation":
                    rate = list(so3.vee(so3.multiply(so3.transpose(tuple(x)), tuple(rate))))
                shape = (*x[0].shape, 3, 3) if variable == "rotation" else (*x[0].shape, 3)
                found[variable][body] = np.stack(x, axis=-1).reshape(shape)
                if variable in RATES:
                    found[RATES[variable]].setdefault(body, np.stack(rate, axis=-1))
    known = {name: listed for name, listed in found.items() if listed}
    arrays = {name: np.stack(np.broadcast_arrays(*listed.values()), axis=2) for name, listed in known.items()}
    return Truth(arrays, {name: list(listed) for name, listed in known.items()})


def _map(value: object, number: Callable[[str, str], Any], place: str) -> Any:
    """A copy with number(text, place) for every formula; the sequence of Euler angles is a text."""
    if isinstance(value, dict):
        return {key: x if key == "euler" else _map(x, number, f"{place}.{key}") for key, x in value.items()}
    if isinstance(value, list):
        return [_map(x, number, f"{place}[{i}]") for i, x in enumerate(value)]
    return number(value, place) if isinstance(value, str) else value


def _at_start(text: str, place: str, parameters: Parameters, report: Report) -> float:
    """The number that a formula is at the start; a problem where it is none, or not finite at some time."""
    values = parameters.values()
    try:
        formula = Formula(text, frozenset({TIME, *values}))
    except ExpressionError as error:
        report.problems.append(explained(text, error).at(place, text))
        return 0.0
    times = np.zeros(1) if report.times is None else report.times
    with np.errstate(all="ignore"):
        numbers = formula(times, **{name: values[name] for name in formula.used - {TIME}}) + 0.0 * times
    bad = np.flatnonzero(~np.isfinite(numbers))
    if len(bad):
        report.add(place, f"is {numbers[bad[0]]} at t = {times[bad[0]]:.6g}", "give finite numbers", text)
    return float(numbers[0])


def _check_form(at: str, variable: str, value: object, at_start: object, report: Report) -> None:
    kind, what = FORMS[variable]
    try:
        checked = TypeAdapter(kind).validate_python(at_start)
    except ValidationError:
        report.add(at, f"must be {what}", "give those", value)
        return
    if variable == "rotation":
        check_rotation(at, checked, report)
