"""Integrals over subintervals of a step by Lobatto's rule of order 8."""

from lienumba.compiler.lanes import Lanes, Mask, load
from lienumba.compiler.routines.marks import apart, inlined
from lienumba.integrators.drivers.measuring.points import Record, Subinterval, interpolation_error, lobatto_values
from lienumba.integrators.drivers.workspace import Context
from lienumba.integrators.layout import KEPT_VALUE
from lienumba.numerics.operations import absolute, maximum, sqrt

END, INNER, MIDDLE = 0.05, 49.0 / 180.0, 16.0 / 45.0  # Lobatto's weights for mean values
QUADRATURE_RTOL = 3e-11  # of the integral so far, or of the largest value times the step
QUADRATURE_SHARE = 0.05  # of error^(3/2) in units of the spread, what the mean is wrong by: of sines 0.005 to 0.013


@apart
def quadrature_needs_refinement(context: Context, record: Record, part: Subinterval) -> Mask:
    """Where Lobatto's rule may be wrong by more than its tolerance. Its order is higher than that of the interpolant,
    whose error is known: of a function that is smooth there, the rule is wrong by the power 8/5 of that."""
    error, spread, size = interpolation_error(context, part, record.signal)
    mean_error = QUADRATURE_SHARE * error * sqrt(error / maximum(spread, error))
    whole = maximum(size * part.length, absolute(load(record.rows, KEPT_VALUE)))
    return mean_error * (part.high - part.low) * part.length > QUADRATURE_RTOL * whole


@inlined
def mean(context: Context, part: Subinterval, signal: int) -> Lanes:
    """The mean of a signal over a subinterval."""
    a, b, c, d, e = lobatto_values(context, part, signal)
    return END * (a + e) + INNER * (b + d) + MIDDLE * c
