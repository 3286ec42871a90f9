"""A mechanism as arrays that jitted functions read: rows of numbers, one column for each of N runs.

State x (18 (k + 1), N): of every body r (global), R (row by row, body to global), v (global) and w (body frame);
the ground is the last body. Velocities (6 k, N): v and w of every body. All numbers are in SI units.
"""

from typing import NamedTuple

import numpy as np

STATE, VELOCITY, ALGEBRA = 18, 6, 12  # numbers of one body in x, in its velocities, and in u

# Kinds of coordinates: numbers that depend on where two bodies a and b are. Points p of a and q of b, d from p to q;
# directions u of a and v of b (in POINT u is global).
(
    POINT,  # u.d
    DIRECTIONS,  # (R_a u).(R_b v)
    ALONG,  # (R_a u).d
    ROD,  # (d.d/L - L)/2 of a rod of length L
    LENGTH,  # |d|
    ANGLE,  # of v of b about an axis of a, from u towards p, over all turns
    SPIN,  # no coordinate but a rate: w of b along v, frame of b
    GLOBAL_SPIN,  # likewise R_b w of b along v
) = range(8)

PUSH, TWIST, EFFORT = range(3)  # kinds of force laws: a force at a point, a torque, an effort along a coordinate
GLOBAL, BODY = range(2)  # frames of forces and torques
LOAD, STIFFNESS, DAMPING, TARGET, LOW, HIGH = range(6)  # numbers of an effort
GRADIENT, VALUE, RATE, BIAS, SEEN = 0, 12, 13, 14, 15  # what is computed of a coordinate, row by row

NONE, MASS, IDENTITY, PLACES = range(-1, 3)  # weights of projections: of velocities, if there is any, and of positions
CLOSED = -1  # terms of dexp^-1: its closed form

SUCCESS, NON_FINITE, NOT_CONVERGED, SINGULAR, ROTATION = range(5)  # how a run ends, as in the datasets


class Bodies(NamedTuple):
    """masses (k, N) in kg; inertia (k, 3, 3, N) in kg m^2, body frame."""

    masses: np.ndarray
    inertia: np.ndarray


class Coordinates(NamedTuple):
    """table (c, 3): kind and bodies a and b of each; vectors (c, 12, N): p, q, u and v, of a ROD its length L for v."""

    table: np.ndarray
    vectors: np.ndarray


class Constraints(NamedTuple):
    """terms (t, 2): row and coordinate, and factors (t, N): a row is the sum of its terms less its offset (m, N).
    wanted (m,): the number that a row prescribes as a rate, -1 for a row of positions; used: the rows that are
    independent of the others."""

    terms: np.ndarray
    factors: np.ndarray
    offsets: np.ndarray
    wanted: np.ndarray
    used: np.ndarray


class Laws(NamedTuple):
    """table (f, 4): kind, body or coordinate, frame or whether it has a potential, first number; points (f, 3, N)."""

    table: np.ndarray
    points: np.ndarray


class Mechanism(NamedTuple):
    """A mechanism of k bodies, c coordinates, m constraint rows and f force laws. Numbers that may vary in time are
    apart from it, the first three of them gravity in m/s^2."""

    bodies: Bodies
    coordinates: Coordinates
    constraints: Constraints
    laws: Laws


class Method(NamedTuple):
    """A (s, s), b (s,): an explicit tableau; terms: of the series of dexp^-1, or CLOSED; h: the step in s; positions,
    velocities: the weights of their projections, or NONE; tolerance in m, limit: of iterations; largest: the largest
    squared rotation of a body in a step, rad^2."""

    A: np.ndarray
    b: np.ndarray
    terms: int
    h: float
    positions: int
    velocities: int
    tolerance: float
    limit: int
    largest: float


class Run(NamedTuple):
    """What N runs carry from step to step: the state x; near (c, N): the angles over all turns, in rad; work (N,) in J;
    code (N,): how each run ended, SUCCESS while it goes on; steps (N,): how many were made; iterations (2, N): the most
    of both projections since the last record; size (N,): of the mechanism in m, with which roundoff compares."""

    x: np.ndarray
    near: np.ndarray
    work: np.ndarray
    code: np.ndarray
    steps: np.ndarray
    iterations: np.ndarray
    size: np.ndarray


class Rows(NamedTuple):
    """Of all constraint rows phi, its rate psi and xi (m, N), and C (m, 6 (k + 1), N)."""

    phi: np.ndarray
    psi: np.ndarray
    xi: np.ndarray
    C: np.ndarray


class System(NamedTuple):
    """The linear system K (n, n, N), b (n, N) of n = 6 k + m unknowns, the scales of its pivots (n, N), and whether it
    is regular, 1 or 0 (N,)."""

    K: np.ndarray
    b: np.ndarray
    scale: np.ndarray
    nonsingular: np.ndarray


class Room(NamedTuple):
    """Memory of a step. seen (c, 15, N): of every coordinate its GRADIENT by v and w of both bodies, VALUE, RATE and
    BIAS, the second derivative at constant velocities. Q (6 k, N) and the power (N,) of loads; slopes
    (s, 12 k, N) and powers (s, N) of the stages; u (12 k, N); the new state y, as x of `Run`, and hat, as it was before
    its projection; pending (N,): the runs that a projection has not finished."""

    seen: np.ndarray
    rows: Rows
    system: System
    Q: np.ndarray
    power: np.ndarray
    slopes: np.ndarray
    powers: np.ndarray
    u: np.ndarray
    y: np.ndarray
    hat: np.ndarray
    pending: np.ndarray


class Records(NamedTuple):
    """What is stored: steps (n,) of the outputs; states (n, 18 (k + 1), N), near (n, c, N), work (n, N), accelerations
    (n, 6 k, N), multipliers (n, m, N) and iterations (n, 2, N); NaN of runs that have ended."""

    steps: np.ndarray
    states: np.ndarray
    near: np.ndarray
    work: np.ndarray
    accelerations: np.ndarray
    multipliers: np.ndarray
    iterations: np.ndarray


def room_of(mechanism: Mechanism, stages: int) -> Room:
    """Memory for a mechanism and a method of so many stages."""
    k, c, m = len(mechanism.bodies.masses), len(mechanism.coordinates.table), len(mechanism.constraints.wanted)
    N = mechanism.bodies.masses.shape[1]
    n, size = VELOCITY * k, VELOCITY * k + len(mechanism.constraints.used)
    phi, psi, xi = np.zeros((3, m, N))
    K, (b, scale), nonsingular = np.zeros((size, size, N)), np.zeros((2, size, N)), np.zeros(N)
    y, hat = np.zeros((2, STATE * (k + 1), N))
    return Room(
        np.zeros((c, SEEN, N)), Rows(phi, psi, xi, np.zeros((m, n + VELOCITY, N))), System(K, b, scale, nonsingular),
        np.zeros((n, N)), np.zeros(N), np.zeros((stages, ALGEBRA * k, N)), np.zeros((stages, N)),
        np.zeros((ALGEBRA * k, N)), y, hat, np.zeros(N, np.int64),
    )  # fmt: skip


def records_of(mechanism: Mechanism, steps: np.ndarray) -> Records:
    """Empty records of the states after these steps."""
    k, c, m = len(mechanism.bodies.masses), len(mechanism.coordinates.table), len(mechanism.constraints.wanted)
    N = mechanism.bodies.masses.shape[1]
    shapes = ((STATE * (k + 1), N), (c, N), (N,), (VELOCITY * k, N), (m, N), (2, N))
    return Records(steps, *(np.full((len(steps), *shape), np.nan) for shape in shapes))
