"""sin, cos, exp, log and atan2 from `+ - * /` alone: at most 2 ulp for |x| up to 1e5, and the same bits on every CPU.

Used by arrays, symbols and lanes. No branch, no table, no call into a mathematics library. Angles are reduced by
pi/2 in four parts (Cody and Waite, 151 bits), so that results stay relatively exact beside the zeros.
"""

from lienumba.numerics.number import Number
from lienumba.numerics.operations import kernel, power_of_two, where

ROUND = 6755399441055744.0  # 1.5 * 2**52: adding and subtracting it rounds to the nearest integer
TWO_OVER_PI = 0.6366197723675814
HALF_PI_1, HALF_PI_2 = 1.5707963267341256, 6.077100506303966e-11  # 33 bits each, so that n * part is exact
HALF_PI_3, HALF_PI_4 = 2.0222662487111665e-21, 8.4784276603689e-32
LOG2_E, LOG_2_HIGH, LOG_2_LOW = 1.4426950408889634, 0.6931471805582987, 1.6465949582897082e-12


@kernel
def two_sum(a: Number, b: Number) -> tuple[Number, Number]:
    """a + b and its rounding error (Knuth)."""
    s = a + b
    c = s - a
    return s, (a - (s - c)) + (b - c)


@kernel
def round_to_integer(x: Number) -> Number:
    return (x + ROUND) - ROUND


@kernel
def reduce_angle(x: Number) -> tuple[Number, Number, Number]:
    """x = n pi/2 + (r + low) with |r| <= pi/4: returns n, r, low."""
    n = round_to_integer(x * TWO_OVER_PI)
    t = x - n * HALF_PI_1
    t, e = two_sum(t, -(n * HALF_PI_2))
    r, f = two_sum(t, -(n * HALF_PI_3))
    low = (e + f) - n * HALF_PI_4
    s = r + low
    return n, s, (r - s) + low


@kernel
def _sin_near_zero(r: Number, low: Number) -> Number:
    z = r * r
    p = -1 / 1307674368000 + z * (1 / 355687428096000)
    p = 1 / 362880 + z * (-1 / 39916800 + z * (1 / 6227020800 + z * p))
    p = z * (-1 / 6 + z * (1 / 120 + z * (-1 / 5040 + z * p)))
    return r + (r * p + low * (1.0 - 0.5 * z))


@kernel
def _cos_near_zero(r: Number, low: Number) -> Number:
    z = r * r
    p = 1 / 479001600 + z * (-1 / 87178291200 + z * (1 / 20922789888000))
    p = 1 / 24 + z * (-1 / 720 + z * (1 / 40320 + z * (-1 / 3628800 + z * p)))
    h = 0.5 * z
    w = 1.0 - h
    return w + (((1.0 - w) - h) + (z * (z * p) - r * low))


@kernel
def _quadrant(n: Number) -> Number:
    """n modulo 4, as one of -2, -1, 0, 1, 2."""
    return n - 4.0 * round_to_integer(0.25 * n)


@kernel
def sin(x: Number) -> Number:
    n, r, low = reduce_angle(x)
    q = _quadrant(n)
    s, c = _sin_near_zero(r, low), _cos_near_zero(r, low)
    y = where(q * q == 1.0, c, s)
    return where(q < 0.0, -y, where(q > 1.0, -y, y))


@kernel
def cos(x: Number) -> Number:
    n, r, low = reduce_angle(x)
    q = _quadrant(n)
    s, c = _sin_near_zero(r, low), _cos_near_zero(r, low)
    y = where(q * q == 1.0, s, c)
    return where(q > 0.0, -y, where(q < -1.0, -y, y))


@kernel
def exp(x: Number) -> Number:
    clipped = where(x < 710.0, where(x > -746.0, x, -746.0), where(x > 710.0, 710.0, x))
    n = round_to_integer(clipped * LOG2_E)
    r = clipped - n * LOG_2_HIGH
    low = n * LOG_2_LOW
    s = r - low
    low = (r - s) - low
    p = 1 / 3628800 + s * (1 / 39916800 + s * (1 / 479001600 + s * (1 / 6227020800)))
    p = 1 / 720 + s * (1 / 5040 + s * (1 / 40320 + s * (1 / 362880 + s * p)))
    p = s * (1 / 6 + s * (1 / 24 + s * (1 / 120 + s * p)))
    y = 1.0 + (s + (s * s * (0.5 + p) + low))
    half = round_to_integer(0.5 * n)
    return y * power_of_two(half) * power_of_two(n - half)


@kernel
def atan2(y: Number, x: Number) -> Number:
    """The angle of (x, y) in [-pi, pi]; 0 at the origin. A minimax polynomial up to tan(pi/8)."""
    a, b = where(x < 0.0, -x, x), where(y < 0.0, -y, y)
    high, low = where(a < b, b, a), where(a < b, a, b)
    steep = low > 0.41421356237309503 * high
    t = where(steep, low - high, low) / where(high == 0.0, 1.0, where(steep, low + high, high))
    z = t * t
    p = -0.05230443640686948 + z * (0.045515447340221615 + z * (-0.03456931506332609 + z * 0.016284375050043393))
    p = 0.07692296368042296 + z * (-0.0666642476020052 + z * (0.05878927554473807 + z * p))
    p = -0.14285714285659779 + z * (0.11111111105150588 + z * (-0.09090908753259112 + z * p))
    p = z * (-0.3333333333333333 + z * (0.19999999999999804 + z * p))
    angle = where(steep, 0.7853981633974483 + (t + (t * p + 3.061616997868383e-17)), t + t * p)
    angle = where(a < b, 1.5707963267948966 - (angle - 6.123233995736766e-17), angle)
    angle = where(x < 0.0, 3.141592653589793 - (angle - 1.2246467991473532e-16), angle)
    return where(y < 0.0, -angle, angle)


@kernel
def log(x: Number) -> Number:
    """The natural logarithm; -inf at 0, NaN below. x = m 2^n with m near 1 by exact steps, then the series of atanh."""
    tiny = x < 2.2250738585072014e-308
    m = where(x > 0.0, x, 1.0) * where(tiny, 18014398509481984.0, 1.0)
    n = where(tiny, -54.0, 0.0)
    for step in (512.0, 256.0, 128.0, 64.0, 32.0, 16.0, 8.0, 4.0, 2.0, 1.0):
        high = m >= power_of_two(step)
        low = m < power_of_two(1.0 - step)
        m = m * where(high, power_of_two(-step), where(low, power_of_two(step), 1.0))
        n = where(high, n + step, where(low, n - step, n))
    upper = m > 1.4142135623730951
    m = where(upper, 0.5 * m, m)
    n = where(upper, n + 1.0, n)
    d = m - 1.0
    f = d / (m + 1.0)
    z = f * f
    p = 1 / 17 + z * (1 / 19 + z * (1 / 21 + z * (1 / 23)))
    p = 1 / 9 + z * (1 / 11 + z * (1 / 13 + z * (1 / 15 + z * p)))
    p = z * (1 / 3 + z * (1 / 5 + z * (1 / 7 + z * p)))
    half = 0.5 * (d * d)
    y = n * LOG_2_HIGH + (d - (half - (f * (half + 2.0 * p) + n * LOG_2_LOW)))
    infinite = float("inf")
    y = where(x < infinite, y, infinite)
    return where(x > 0.0, y, where(x < 0.0, infinite - infinite, where(x == 0.0, -infinite, x)))
