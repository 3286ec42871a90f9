"""Formulas as people write them: the usual slips, each with its remedy, and whether they have numbers at the start."""

import re
from typing import Any

from lienumba.compiler.jets import Jet, lift
from lienumba.expressions import ExpressionError, Formula

LARGEST = 1e100  # of any number in SI units: squares and cubes must be numbers, too
SLIPS = (
    (r"\s*$", 'is empty; write a number, or a formula such as "0.3*sin(2*t)"'),
    (r"[^(]*\d,\d", "has a comma in a number; a decimal number has a point: 0.5"),
    (r".*\^", 'has a "^"; a power is written with two stars: t**2'),
    (r".*[^<>=]=[^=]", "has an equals sign; write only what stands to its right"),
    (r".*(?<![\w.])[\d.]+\s*(?!e[-+]?\d)[A-Za-z(]", "multiplies without a star; write 2*t, 30*deg"),
)


def checked(text: str) -> str:
    """The text itself; an ExpressionError with what is wrong and the remedy if it is no formula."""
    try:
        Formula(text)
    except ExpressionError as error:
        raise ExpressionError(explained(text, error)) from None
    return text


def explained(text: str, error: ExpressionError) -> str:
    """What is wrong with a text that is no formula, and the remedy."""
    message = str(error)
    if message.startswith(("is not a formula", "contains")):
        message = _slip(text) or message
    return message if "; " in message else f"{message}; correct it"


def constant(value: Any) -> float | None:
    """The number that a value is; None for one that is omitted or varies in time."""
    return Formula(value).constant if isinstance(value, str) else value


def at_start(value: Any) -> tuple[float, float, float]:
    """A number or a function of time at t = 0: its value, rate and second derivative."""
    import numpy as np

    with np.errstate(all="ignore"):
        x = lift(value(Jet(0.0, 1.0)) if callable(value) else value)
    return float(x.a), float(x.b), float(x.c)


def not_finite_at_start(value: Any, orders: int) -> str | None:
    """What is wrong with a formula, of which so many are needed: value, rate and second derivative."""
    if not isinstance(value, str):
        return None
    for name, number in zip(("value", "rate", "second derivative"), at_start(Formula(value))[:orders], strict=False):
        if not abs(number) < LARGEST:
            return (
                f"its {name} at t = 0 is {number}; give a formula that begins smoothly with finite numbers, such as "
                "where(t > 0, ..., 0)"
            )
    return None


def _slip(text: str) -> str | None:
    opened, closed = text.count("("), text.count(")")
    if opened != closed:
        return f'has {opened} "(" and {closed} ")"; give each its other half'
    return next((remedy for pattern, remedy in SLIPS if re.match(pattern, text, re.DOTALL)), None)
