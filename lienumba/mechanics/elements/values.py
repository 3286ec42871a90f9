"""From the values of checked keys to those of the model: lists become tuples, formulas functions of time.

A number is a float, or an array (runs,) where the sweep varies it.
"""

from collections.abc import Sequence
from typing import Any

from lienumba.mechanics.mechanism.model import Number, Timed, Vec3
from lienumba.numerics.expressions import Formula


def vec3(values: Sequence[Number]) -> Vec3:
    """A vector."""
    return values[0], values[1], values[2]


def pair(vectors: Sequence[Sequence[Number]] | None) -> tuple[Vec3, Vec3] | None:
    """Two vectors, one for each of two bodies."""
    return None if vectors is None else (vec3(vectors[0]), vec3(vectors[1]))


def timed(value: Any) -> Timed:
    """A number, or the function of time that a text describes; a text without t is a number too."""
    if not isinstance(value, str):
        return value
    formula = Formula(value)
    return formula if formula.constant is None else formula.constant


def timed3(values: Sequence[Any]) -> tuple[Timed, Timed, Timed]:
    """A vector of such numbers."""
    return timed(values[0]), timed(values[1]), timed(values[2])
