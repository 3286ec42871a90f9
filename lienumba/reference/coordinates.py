"""Coordinates between two bodies, their gradients and biases, by hand; constraints and springs are made of them.

With d = r_b + R_b q - r_a - R_a p, and w~ x = w x x along a body's own axes, (36) to (41) and (B.1) to (B.6) of Terze
et al. (2015) are  d' = v_b + R_b w_b~ q - v_a - R_a w_a~ p  and, at constant velocities,
d'' = R_b w_b~ w_b~ q - R_a w_a~ w_a~ p.  A gradient is (-g, g_a, g, g_b) by v_a, w_a, v_b and w_b.
"""

import math

import numpy as np

from lienumba.reference.compiling import compiled
from lienumba.reference.mechanism import (
    ALONG,
    ANGLE,
    BIAS,
    DIRECTIONS,
    GLOBAL_SPIN,
    GRADIENT,
    POINT,
    RATE,
    ROD,
    SPIN,
    STATE,
    VALUE,
    VELOCITY,
    Constraints,
    Coordinates,
    Rows,
)
from lienumba.reference.rotations import ZERO, Vec3, cross, dot, matrix, plus, rotate, rotate_back, vector

TINY = 1e-200  # m^2, below the square of every length: two points that coincide have no direction, and no NaN
TURN = 2.0 * math.pi
Coordinate = tuple[float, float, Vec3, Vec3, Vec3]  # value, bias, g, g_a, g_b


@compiled
def of_points(kind: int, s: np.ndarray, x: np.ndarray, a: int, b: int, run: int) -> Coordinate:
    """POINT, ALONG, ROD or LENGTH; s (12, N): p, q, u, v. The first body's row in x is a, the second's b."""
    p, q, u = vector(s, 0, run), vector(s, 3, run), vector(s, 6, run)
    Ra, Rb = matrix(x, a + 3, run), matrix(x, b + 3, run)
    wa, wb = vector(x, a + 15, run), vector(x, b + 15, run)
    p1, q1 = cross(wa, p), cross(wb, q)
    d = plus(plus(vector(x, b, run), 1.0, rotate(Rb, q)), -1.0, plus(vector(x, a, run), 1.0, rotate(Ra, p)))
    d2 = plus(rotate(Rb, cross(wb, q1)), -1.0, rotate(Ra, cross(wa, p1)))
    turning = ZERO
    if kind == POINT:
        g, value, bias = u, dot(u, d), dot(u, d2)
    else:
        a1, b1 = vector(x, a + 12, run), vector(x, b + 12, run)
        d1 = plus(plus(b1, 1.0, rotate(Rb, q1)), -1.0, plus(a1, 1.0, rotate(Ra, p1)))
        if kind == ALONG:
            g, u1 = rotate(Ra, u), cross(wa, u)
            value = dot(g, d)
            bias = dot(rotate(Ra, cross(wa, u1)), d) + 2.0 * dot(rotate(Ra, u1), d1) + dot(g, d2)
            turning = cross(u, rotate_back(Ra, d))
        else:
            square = dot(d, d)
            length = s[9, run] if kind == ROD else math.sqrt(square + TINY)
            g = (d[0] / length, d[1] / length, d[2] / length)
            value = 0.5 * (square / length - length) if kind == ROD else length
            bias = (dot(d1, d1) + dot(d, d2)) / length  # of a ROD
    return value, bias, g, plus(turning, -1.0, cross(p, rotate_back(Ra, g))), cross(q, rotate_back(Rb, g))


@compiled
def of_directions(u: Vec3, v: Vec3, x: np.ndarray, a: int, b: int, run: int) -> tuple[float, float, float, Vec3, Vec3]:
    """(R_a u).(R_b v): value, rate, bias, g_a and g_b."""
    Ra, Rb = matrix(x, a + 3, run), matrix(x, b + 3, run)
    wa, wb = vector(x, a + 15, run), vector(x, b + 15, run)
    u1, v1 = cross(wa, u), cross(wb, v)
    A, B = rotate(Ra, u), rotate(Rb, v)
    A2, B2 = rotate(Ra, cross(wa, u1)), rotate(Rb, cross(wb, v1))
    bias = dot(A2, B) + 2.0 * dot(rotate(Ra, u1), rotate(Rb, v1)) + dot(A, B2)
    ga, gb = cross(u, rotate_back(Ra, B)), cross(v, rotate_back(Rb, A))
    return dot(A, B), dot(ga, wa) + dot(gb, wb), bias, ga, gb


@compiled
def of_angle(s: np.ndarray, x: np.ndarray, a: int, b: int, near: float, run: int) -> Coordinate:
    """atan2(y, x) of x = (R_a u).(R_b v) and y = (R_a p).(R_b v), with as many turns as bring it near a value (rad)."""
    p, u, v = vector(s, 0, run), vector(s, 6, run), vector(s, 9, run)
    c, c1, c2, ca, cb = of_directions(u, v, x, a, b, run)
    y, y1, y2, ya, yb = of_directions(p, v, x, a, b, run)
    n = c * c + y * y
    rate = (c * y1 - y * c1) / n
    bias = (c * y2 - y * c2) / n - 2.0 * rate * (c * c1 + y * y1) / n
    value = math.atan2(y, c)
    value += TURN * math.floor((near - value) / TURN + 0.5)
    i, j = c / n, -y / n
    ga = (i * ya[0] + j * ca[0], i * ya[1] + j * ca[1], i * ya[2] + j * ca[2])
    gb = (i * yb[0] + j * cb[0], i * yb[1] + j * cb[1], i * yb[2] + j * cb[2])
    return value, bias, ZERO, ga, gb


@compiled
def evaluate(coordinates: Coordinates, x: np.ndarray, near: np.ndarray, seen: np.ndarray) -> None:
    """All coordinates at a state, with their rates, gradients and biases; near (c, N): where angles are counted."""
    for n in range(coordinates.table.shape[0]):
        kind, s = coordinates.table[n, 0], coordinates.vectors[n]
        a, b = STATE * coordinates.table[n, 1], STATE * coordinates.table[n, 2]
        for run in range(x.shape[1]):
            value, bias, g, ga = 0.0, 0.0, ZERO, ZERO
            if kind == DIRECTIONS:
                value, _, bias, ga, gb = of_directions(vector(s, 6, run), vector(s, 9, run), x, a, b, run)
            elif kind == ANGLE:
                value, bias, g, ga, gb = of_angle(s, x, a, b, near[n, run], run)
            elif kind in (SPIN, GLOBAL_SPIN):  # R w changes by R w' alone: w x w = 0
                gb = vector(s, 9, run)
                if kind == GLOBAL_SPIN:
                    gb = rotate_back(matrix(x, b + 3, run), gb)
            else:
                value, bias, g, ga, gb = of_points(kind, s, x, a, b, run)
            rate = dot(g, plus(vector(x, b + 12, run), -1.0, vector(x, a + 12, run)))
            seen[n, RATE, run] = rate + dot(ga, vector(x, a + 15, run)) + dot(gb, vector(x, b + 15, run))
            seen[n, VALUE, run], seen[n, BIAS, run] = value, bias
            for i in range(3):
                seen[n, i, run], seen[n, 3 + i, run] = -g[i], ga[i]
                seen[n, 6 + i, run], seen[n, 9 + i, run] = g[i], gb[i]


@compiled
def constrain(
    coordinates: Coordinates, constraints: Constraints, numbers: np.ndarray, seen: np.ndarray, rows: Rows
) -> None:
    """Phi, psi = C v - b, C and xi of all rows (10c) to (12) from the coordinates; b and b' of a prescribed rate are in
    numbers (n, 2, N)."""
    for row in range(constraints.wanted.size):
        number = constraints.wanted[row]
        for run in range(numbers.shape[2]):
            rows.phi[row, run], rows.psi[row, run], rows.xi[row, run] = -constraints.offsets[row, run], 0.0, 0.0
            if number >= 0:
                rows.psi[row, run], rows.xi[row, run] = -numbers[number, 0, run], numbers[number, 1, run]
        for i in range(rows.C.shape[1]):
            for run in range(numbers.shape[2]):
                rows.C[row, i, run] = 0.0
    for t in range(constraints.terms.shape[0]):
        row, n = constraints.terms[t, 0], constraints.terms[t, 1]
        first, second = VELOCITY * coordinates.table[n, 1], VELOCITY * coordinates.table[n, 2]
        for run in range(numbers.shape[2]):
            factor = constraints.factors[t, run]
            rows.phi[row, run] += factor * seen[n, VALUE, run]
            rows.psi[row, run] += factor * seen[n, RATE, run]
            rows.xi[row, run] -= factor * seen[n, BIAS, run]
        for i in range(VELOCITY):
            for run in range(numbers.shape[2]):
                rows.C[row, first + i, run] += constraints.factors[t, run] * seen[n, GRADIENT + i, run]
                rows.C[row, second + i, run] += constraints.factors[t, run] * seen[n, GRADIENT + VELOCITY + i, run]
