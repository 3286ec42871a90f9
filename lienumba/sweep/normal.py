"""The normal distribution function and its inverse, with the same bits on every processor.

scipy.special.ndtri and numpy.log call mathematical libraries that choose their formula by processor. Here
every operation is one correctly rounded NumPy operation, and NumPy never fuses two of them.
"""

from __future__ import annotations

import numpy as np

from lienumba.numerics.operations import exp

# M. J. Wichura, Algorithm AS 241: the percentage points of the normal distribution, Applied Statistics 37
# (1988): numerators and denominators for |u - 1/2| <= 0.425, for sqrt(-log u) <= 5, and beyond; constant first.
CENTRE = (
    (
        3.3871328727963666080e0, 1.3314166789178437745e2, 1.9715909503065514427e3,
        1.3731693765509461125e4, 4.5921953931549871457e4, 6.7265770927008700853e4,
        3.3430575583588128105e4, 2.5090809287301226727e3,
    ),
    (
        1.0, 4.2313330701600911252e1, 6.8718700749205790830e2,
        5.3941960214247511077e3, 2.1213794301586595867e4, 3.9307895800092710610e4,
        2.8729085735721942674e4, 5.2264952788528545610e3,
    ),
)  # fmt: skip
TAIL = (
    (
        1.42343711074968357734e0, 4.63033784615654529590e0, 5.76949722146069140550e0,
        3.64784832476320460504e0, 1.27045825245236838258e0, 2.41780725177450611770e-1,
        2.27238449892691845833e-2, 7.74545014278341407640e-4,
    ),
    (
        1.0, 2.05319162663775882187e0, 1.67638483018380384940e0,
        6.89767334985100004550e-1, 1.48103976427480074590e-1, 1.51986665636164571966e-2,
        5.47593808499534494600e-4, 1.05075007164441684324e-9,
    ),
)  # fmt: skip
FAR_TAIL = (
    (
        6.65790464350110377720e0, 5.46378491116411436990e0, 1.78482653991729133580e0,
        2.96560571828504891230e-1, 2.65321895265761230930e-2, 1.24266094738807843860e-3,
        2.71155556874348757815e-5, 2.01033439929228813265e-7,
    ),
    (
        1.0, 5.99832206555887937690e-1, 1.36929880922735805310e-1,
        1.48753612908506148525e-2, 7.86869131145613259100e-4, 1.84631831751005468180e-5,
        1.42151175831644588870e-7, 2.04426310338993978564e-15,
    ),
)  # fmt: skip
LOG_2 = 0.6931471805599453
SQRT_HALF = 0.7071067811865476
SQRT_2PI = 2.5066282746310002
SERIES_END = 2.0  # where the tails begin
SERIES_TERMS, FRACTION_TERMS = 26, 80
ATANH_SERIES = tuple(2.0 / (2 * k + 1) for k in range(12))  # log m = s P(s^2), s = (m - 1)/(m + 1), |s| < 0.172


def inverse(u: np.ndarray) -> np.ndarray:
    """x with P(X <= x) = u for the standard normal X; 0 < u < 1."""
    q = u - 0.5
    centre = q * _ratio(CENTRE, 0.180625 - q * q)
    tail_area = np.minimum(u, 1.0 - u)
    r = np.sqrt(-_log(tail_area))
    tail = np.where(r <= 5.0, _ratio(TAIL, r - 1.6), _ratio(FAR_TAIL, r - 5.0))
    x: np.ndarray = np.where(np.abs(q) <= 0.425, centre, np.where(q < 0.0, -tail, tail))
    return x


def probability(x: np.ndarray) -> np.ndarray:
    """P(X <= x) for the standard normal X: a series of positive terms, and the continued fraction of its tails.

    M. Abramowitz, I. A. Stegun, Handbook of Mathematical Functions (1964), 26.2.11 and 26.2.14.
    """
    size = np.abs(x)
    density = exp(-0.5 * (size * size)) / SQRT_2PI
    near = np.minimum(size, SERIES_END)
    square, total = near * near, np.zeros_like(near)
    for k in range(SERIES_TERMS, 0, -1):
        total = (1.0 + total) * square / (2.0 * k + 1.0)
    centre = density * near * (1.0 + total)
    far = np.maximum(size, SERIES_END)
    fraction = far
    for k in range(FRACTION_TERMS, 0, -1):
        fraction = far + k / fraction
    tail = density / fraction
    below: np.ndarray = np.where(size < SERIES_END, 0.5 - centre, tail)
    return np.where(x < 0.0, below, np.where(size < SERIES_END, 0.5 + centre, 1.0 - tail))


def _ratio(coefficients: tuple[tuple[float, ...], tuple[float, ...]], x: np.ndarray) -> np.ndarray:
    ratio: np.ndarray = _polynomial(coefficients[0], x) / _polynomial(coefficients[1], x)
    return ratio


def _polynomial(coefficients: tuple[float, ...], x: np.ndarray) -> np.ndarray:
    value = coefficients[-1] * x
    for coefficient in coefficients[-2:0:-1]:
        value = (value + coefficient) * x
    return value + coefficients[0]


def _log(x: np.ndarray) -> np.ndarray:
    mantissa, exponent = np.frexp(x)
    low = mantissa < SQRT_HALF
    mantissa = np.where(low, 2.0 * mantissa, mantissa)
    exponent = exponent - low
    s = (mantissa - 1.0) / (mantissa + 1.0)
    logarithm: np.ndarray = exponent * LOG_2 + s * _polynomial(ATANH_SERIES, s * s)
    return logarithm
