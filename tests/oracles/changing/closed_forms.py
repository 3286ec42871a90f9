"""Impacts, stops and friction in closed form. Floats in, floats out; nothing is taken from lienumba."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.integrate import quad
from scipy.optimize import brentq
from scipy.special import ellipk

G = 9.81


@dataclass(frozen=True)
class Bounces:
    """Impacts: their times, the speeds before them, and the energy that each takes; then the ball rests."""

    times: np.ndarray
    speeds: np.ndarray
    losses: np.ndarray
    limit: float  # s, when infinitely many bounces would have ended

    def heights(self, e: float, g: float = G) -> np.ndarray:
        """How high the ball comes behind each impact (m)."""
        return (e * self.speeds) ** 2 / (2 * g)


def bouncing(height: float, e: float, rest_speed: float, m: float = 1.0, g: float = G) -> Bounces:
    """A point dropped from rest; a rebound slower than the rest speed does not happen."""
    v = math.sqrt(2 * g * height)
    t, times, speeds, losses = v / g, [], [], []
    limit = t + 2 * v / g * e / (1 - e)
    while True:
        after = e * v if e * v >= rest_speed else 0.0
        times.append(t)
        speeds.append(v)
        losses.append(0.5 * m * (v**2 - after**2))
        if not after:
            return Bounces(np.array(times), np.array(speeds), np.array(losses), limit)
        t, v = t + 2 * after / g, after


def swings_on_a_stop(amplitude: float, pulsation: float, e: float, count: int) -> np.ndarray:
    """Times (count,) at which a pendulum that starts at rest hits a stop where it hangs straight down.

    Quarter periods are K(sin(a/2)) / pulsation, and the rate at the bottom is 2 pulsation sin(a/2).
    """
    k = math.sin(0.5 * amplitude)
    t, times = ellipk(k * k) / pulsation, []
    for _ in range(count):
        times.append(t)
        k *= e
        t += 2 * ellipk(k * k) / pulsation
    return np.array(times)


@dataclass(frozen=True)
class Belt:
    """A block of mass m on a belt of speed v, a spring to the ground: when it lets go, and when it sticks again."""

    m: float
    stiffness: float
    v: float
    static: float
    kinetic: float

    def times(self, count: int, g: float = G) -> np.ndarray:
        """(count, 2): slips, sticks; the block starts on the belt, the spring at its free length."""
        w = math.sqrt(self.stiffness / self.m)
        reach = (self.static - self.kinetic) * self.m * g / self.stiffness
        slip = 2 * (math.pi - math.atan(reach * w / self.v)) / w
        t, found = self.static * self.m * g / self.stiffness / self.v, []
        for _ in range(count):
            found.append((t, t + slip))
            t += slip + 2 * reach / self.v
        return np.array(found)


def up_an_incline(v: float, angle: float, static: float, kinetic: float, end: float) -> tuple[float, float, float]:
    """When a block sent up stops, how far it came, and where it is at `end`: there, or on its way down."""
    s, c = G * math.sin(angle), G * math.cos(angle)
    stop = v / (s + kinetic * c)
    top = 0.5 * v * stop
    down = s - kinetic * c if math.tan(angle) > static else 0.0
    return stop, top, top - 0.5 * down * (end - stop) ** 2


def rod_hits(m: float, length: float, angle: float, speed: float, e: float) -> tuple[float, float, float]:
    """A rod, level + angle, falls with this speed on its lower end: speed of its middle (upwards) and rate of the angle
    behind the impact, and the impulse. No friction."""
    J, arm = m * length**2 / 12, 0.5 * length * math.cos(angle)
    impulse = (1 + e) * speed / (1 / m + arm**2 / J)
    return -speed + impulse / m, -impulse * arm / J, impulse


def rod_lies_down(m: float, length: float, angle: float, rate: float) -> tuple[float, float]:
    """When a rod whose end slides on the floor, without friction, lies flat, and its rate then (both > 0); `rate`: how
    fast the angle falls at first."""
    J, half = m * length**2 / 12, 0.5 * length
    inertia = lambda q: J + m * (half * math.cos(q)) ** 2  # noqa: E731
    energy = 0.5 * inertia(angle) * rate**2 + m * G * half * math.sin(angle)
    falls = lambda q: math.sqrt(2 * (energy - m * G * half * math.sin(q)) / inertia(q))  # noqa: E731
    if rate > 0:
        return quad(lambda q: 1 / falls(q), 0, angle, epsabs=1e-14, epsrel=1e-14)[0], falls(0.0)
    # q = angle - s^2: the integrand stays finite where the motion begins from rest
    return quad(lambda s: 2 * s / falls(angle - s * s), 0, math.sqrt(angle), epsabs=1e-13, epsrel=1e-13)[0], falls(0.0)


def together(
    m: Sequence[float], J: Sequence[np.ndarray], r: Sequence[np.ndarray], v: Sequence[np.ndarray],
    w: Sequence[np.ndarray],
) -> tuple[np.ndarray, np.ndarray, float]:  # fmt: skip
    """Bodies that become one: velocity of the common mass centre, angular velocity, energy lost. All in the global
    frame, J about each mass centre."""
    total = sum(m)
    centre = sum(a * b for a, b in zip(m, r, strict=True)) / total
    mean = sum(a * b for a, b in zip(m, v, strict=True)) / total
    inertia, spin, before = np.zeros((3, 3)), np.zeros(3), 0.0
    for mass, own, place, speed, rate in zip(m, J, r, v, w, strict=True):
        d = place - centre
        inertia += own + mass * (d @ d * np.eye(3) - np.outer(d, d))
        spin += own @ rate + mass * np.cross(d, speed)
        before += 0.5 * mass * speed @ speed + 0.5 * rate @ own @ rate
    turn = np.linalg.solve(inertia, spin)
    return mean, turn, before - 0.5 * total * mean @ mean - 0.5 * turn @ inertia @ turn


def topples(length: float, start: float, end: float) -> tuple[float, float]:
    """A uniform rod on a hinge at its lower end, at rest at `start` from the vertical: when it is at `end`, and how
    fast then."""
    rate = lambda q: math.sqrt(3 * G / length * (math.cos(start) - math.cos(q)))  # noqa: E731
    time = quad(lambda s: 2 * s / rate(start + s * s), 0, math.sqrt(end - start), epsabs=1e-13, epsrel=1e-13)[0]
    return time, rate(end)


def painleve(angle: float) -> float:
    """The friction from which on a uniform rod that slides, its other end trailing above, has no answer: where it turns
    by nothing, 1 + 3 cos^2 < 3 mu sin cos; `angle` above the floor."""
    return (1 + 3 * math.cos(angle) ** 2) / (3 * math.sin(angle) * math.cos(angle))


def housner(half_width: float, half_height: float) -> float:
    """The rate of a block as it changes from one edge to the other, after over before: momentum about the new edge."""
    return 1 - 1.5 * half_width**2 / (half_width**2 + half_height**2)


def block_rocks(half_width: float, half_height: float, start: float) -> tuple[float, float]:
    """A block at rest on one edge, turned by `start`: when it is upright again, and its rate then."""
    radius, lean = math.hypot(half_width, half_height), math.atan2(half_width, half_height)
    inertia = 4 / 3 * radius**2  # of one kilogram
    rate = lambda q: math.sqrt(2 * G * radius * (math.cos(lean - start) - math.cos(lean - q)) / inertia)  # noqa: E731
    time = quad(lambda s: 2 * s / rate(start - s * s), 0, math.sqrt(start), epsabs=1e-13, epsrel=1e-13)[0]
    return time, rate(0.0)


def cradle(v: float, count: int) -> np.ndarray:
    """Speeds of equal balls in a row that touch, the first of which comes with v, by Newton's rule for all contacts at
    the same time, e = 1: w+ = -e w- in every contact, and momentum."""
    matrix = np.zeros((count, count))
    matrix[0] = 1.0
    for i in range(1, count):
        matrix[i, i - 1], matrix[i, i] = -1.0, 1.0
    right = np.zeros(count)
    right[0], right[1] = v, v
    return np.linalg.solve(matrix, right)


def rolls_down(angle: float, friction: float, shape: float) -> tuple[float, float]:
    """Acceleration along an incline and angular acceleration times radius, of a wheel with J = shape m r^2."""
    if math.tan(angle) * shape / (1 + shape) <= friction:
        a = G * math.sin(angle) / (1 + shape)
        return a, a
    return G * (math.sin(angle) - friction * math.cos(angle)), friction * G * math.cos(angle) / shape


def slides_then_rolls(v: float, friction: float, shape: float) -> tuple[float, float]:
    """When a ball sent off without spin begins to roll, and its speed then."""
    speed = v / (1 + shape)
    return (v - speed) / (friction * G), speed


def pawl(torque: float, J: float, pulsation: float, brake: float) -> tuple[float, float, float]:
    """A wheel under torque sin(pulsation t) - brake, from rest, and a pawl that lets it turn forwards only: when it
    begins to turn, when it is caught, and its angle then."""
    s, a = brake / torque, torque / (J * pulsation)
    begin = math.asin(s) / pulsation
    speed = lambda t: a * (math.cos(pulsation * begin) - math.cos(pulsation * t) - s * pulsation * (t - begin))  # noqa: E731
    caught = brentq(speed, math.pi / pulsation * 0.75, 2 * math.pi / pulsation, xtol=1e-15, rtol=1e-15)
    angle = quad(speed, begin, caught, epsabs=1e-14, epsrel=1e-14)[0]
    return begin, float(caught), angle
