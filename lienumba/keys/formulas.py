"""Formulas as people write them: the usual slips, each with its remedy, and whether they have numbers at the start."""

import re
from collections.abc import Callable

import numpy as np

from lienumba.errors import BadValueError
from lienumba.numerics.expressions import Formula
from lienumba.numerics.grammar import ExpressionError, NotAFormulaError
from lienumba.numerics.jets import Jet, lift
from lienumba.numerics.number import Number

Function = Callable[[Number], Number]  # of the time
LARGEST = 1e100  # of any number in SI units: squares and cubes must be numbers, too
SLIPS = (
    (r"\s*$", "is empty", 'write a number, or a formula such as "0.3*sin(2*t)"'),
    (r"[^(]*\d,\d", "has a comma in a number", "a decimal number has a point: 0.5"),
    (r".*\bif\b", "has an if", "write where(t < 1, number, other number)"),
    (
        r"\s*[-+]?[\d.]+(e[-+]?\d+)?(\s+(m|s|N|J|W)|\s*(kg|rad|Nm|Hz|mm))\b",
        "has a unit",
        "numbers are in SI units, without it",
    ),
    (r".*\^", 'has a "^"', "a power is written with two stars: t**2"),
    (r".*[!=]=", "asks whether numbers are equal, which they hardly ever are", "compare them by <, <=, > or >="),
    (r".*[^<>=]=[^=]", "has an equals sign", "write only what stands to its right, or compare by <, <=, > or >="),
    (
        r".*(?<![\w.])(\d[\d.]*|\.\d+)\s*(?!e[-+]?\d|and\b|or\b|not\b)[A-Za-z(]",
        "multiplies without a star",
        "write 2*t, 30*deg",
    ),
)


def checked(text: str) -> str:
    """The text itself; an ExpressionError with what is wrong and the remedy if it is no formula."""
    try:
        Formula(text)
    except ExpressionError as error:
        raise explained(text, error) from None
    return text


def condition(text: str) -> str:
    """The same for the text of a condition."""
    try:
        Formula(text, condition=True)
    except ExpressionError as error:
        raise explained(text, error) from None
    return text


def explained(text: str, error: ExpressionError) -> ExpressionError:
    """What is wrong with a text that is no formula, and the remedy."""
    slip = _slip(text) if isinstance(error, NotAFormulaError) else None
    return slip or ExpressionError(error.problem.rule, error.problem.remedy or "correct it")


def constant(value: float | str | None) -> float | None:
    """The number that a value is; None for one that is omitted or varies in time."""
    return Formula(value).constant if isinstance(value, str) else value


def at_start(value: Number | Function) -> tuple[float, float, float]:
    """A number or a function of time at t = 0: its value, rate and second derivative."""
    with np.errstate(all="ignore"):
        x = lift(value(Jet(0.0, 1.0)) if callable(value) else value)
    return float(x.a), float(x.b), float(x.c)


def not_finite_at_start(value: object, orders: int) -> BadValueError | None:
    """What is wrong with a formula, of which so many are needed: value, rate and second derivative."""
    if not isinstance(value, str):
        return None
    for name, number in zip(("value", "rate", "second derivative"), at_start(Formula(value))[:orders], strict=False):
        if not abs(number) < LARGEST:
            remedy = "give a formula that begins smoothly with finite numbers, such as t**2, or sqrt(t + 0.001)"
            return BadValueError(f"its {name} at t = 0 is {number}", remedy)
    return None


def derivatives(value: str | Function, times: np.ndarray) -> "tuple[np.ndarray, np.ndarray, np.ndarray]":
    """A function of the time (or the text of its formula), its rate and its second derivative at these times."""
    with np.errstate(all="ignore"):
        x = lift((Formula(value) if isinstance(value, str) else value)(Jet(times, 1.0)))
    a, b, c = (np.array(np.broadcast_to(np.asarray(y, float), times.shape)) for y in (x.a, x.b, x.c))
    return a, b, c


def not_finite_later(value: str | Function, orders: int, times: np.ndarray) -> BadValueError | None:
    """What is wrong with a function of the time, or the text of its formula, in the course of a run."""
    for name, x in zip(("value", "rate", "second derivative"), derivatives(value, times)[:orders], strict=False):
        bad = ~(np.abs(x) < LARGEST)
        if bad.any():
            first = int(np.argmax(bad))
            remedy = f"give a formula that is finite until integrator.end_time = {times[-1]:.6g}"
            return BadValueError(f"its {name} is {x[first]:.3g} at t = {times[first]:.6g}", remedy)
    return None


def jump(x: np.ndarray, rate: np.ndarray, times: np.ndarray) -> tuple[float, float] | None:
    """Where a function changes by far more than its rate says on both sides: the time, and by how much."""
    rates, spacing = np.abs(rate), times[1] - times[0]
    with np.errstate(all="ignore"):  # where it is not finite, `not_finite_later` says so
        steps = np.abs(np.diff(x))
        most = 4.0 * spacing * np.maximum(rates[:-1], rates[1:]) + 1e-6 * np.max(np.abs(x))
    found = np.flatnonzero(steps > most)
    return (float(times[found[0] + 1]), float(steps[found[0]])) if len(found) else None


def _slip(text: str) -> ExpressionError | None:
    opened, closed = text.count("("), text.count(")")
    if opened != closed:
        return ExpressionError(f'has {opened} "(" and {closed} ")"', "give each its other half")
    found = (slip for pattern, *slip in SLIPS if re.match(pattern, text, re.DOTALL))
    return next((ExpressionError(*slip) for slip in found), None)
