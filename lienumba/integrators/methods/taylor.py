"""Steps that are power series in time, of any order.

Jorba and Zou, Experimental Mathematics 14 (2005): where series end at a radius, and an order costs what it has in
coefficients, 1 - ln(tolerance)/2 costs least. Motions that turn have series like those of sin, without any radius:
there it is - ln(tolerance), and in between the cost hardly depends on it.
"""

from collections.abc import Sequence
from math import ceil, log

from lienumba.integrators.methods.tableau import Tableau
from lienumba.keys.literature import Reference
from lienumba.numerics import operations
from lienumba.numerics.number import Number
from lienumba.numerics.operations import maximum, minimum, where

LOWEST, HIGHEST = 2, 40
ROTATION = 1  # the kind of rows that have no size
SAFETY = 0.9
DIGITS = 0.75  # orders for each factor e of the tolerance
DEFECT = 4.0  # of a step that is accepted, in tolerances
SHORTER = 0.5  # the factor to a step that is not
SMALLEST = 1e-300  # squares of coefficients below which they say nothing against a long step
LARGEST = 1e300  # those above which there is no saying how short it has to be

TAYLOR = Tableau.of(
    "taylor", 8, "Taylor series in time [@jorba2005]", [""], "1",
    Reference(
        "jorba2005", "article", "Jorba, Àngel and Zou, Maorong", 2005,
        "A software package for the numerical integration of ODEs by means of high-order Taylor methods",
        "Experimental Mathematics", "14(1):99--117", "10.1080/10586458.2005.10128904",
    ),
    series=True,
)  # fmt: skip


def order_for(tolerance: float) -> int:
    """An order that costs little with this error of a step."""
    return min(max(ceil(1.0 - DIGITS * log(tolerance)), LOWEST), HIGHEST)


def length(squares: Sequence[tuple[int, Number]]) -> Number:
    """How long a step may be (s): squares of the last coefficients, as fractions of what is allowed, with their orders;
    1 if one is not a number, for then no step is. Next to a singularity squares may be larger than any number."""
    found: Number | None = None
    total: Number = 0.0
    for order, square in squares:
        total = total + square
        size = minimum(maximum(square, SMALLEST), LARGEST)
        own = operations.exp(operations.log(size) * (-0.5 / order))
        found = own if found is None else minimum(own, found)
    assert found is not None
    return where(total >= 0.0, SAFETY * found, 1.0)
