"""Accelerations in a singular position, where the constraints do not say them all: the limit from both sides.

All runs at once, elementwise.
"""

from collections.abc import Sequence
from typing import Any

from lienumba.groups.state import State
from lienumba.mechanics.mechanism.kinematics import Instant
from lienumba.mechanics.mechanism.model import Model
from lienumba.mechanics.system import constraints, dynamics, kkt, projection
from lienumba.mechanics.tolerances import (
    PASS_CORRECTIONS,
    PASS_ROUNDS,
    PASS_TIME,
    PASS_TURN,
)
from lienumba.numerics.number import Number
from lienumba.numerics.operations import where

Both = tuple[list[Any], list[Any]]


def limiting_accelerations(model: Model, structure: kkt.Structure, now: Instant, mask: Sequence[Number]) -> Both:
    """The 6 k accelerations at `now`, and their 6 k time derivatives, to fourth order from those at -2, -1, 1 and 2
    steps of its motion."""
    fastest = constraints.largest([x for body in now.bodies for x in body[15:18]])
    h = PASS_TURN / where(fastest > PASS_TURN / PASS_TIME, fastest, PASS_TURN / PASS_TIME)
    last: list[Any] = [0.0] * (6 * len(now.bodies))
    rates = last
    for _ in range(PASS_ROUNDS):  # the motion bends as the accelerations found before have it
        at = (_accelerations(model, structure, now, mask, last, n * h) for n in (-2.0, -1.0, 1.0, 2.0))
        near = list(zip(*at, strict=True))
        rates = [(8.0 * (c - b) - (d - a)) / (12.0 * h) for a, b, c, d in near]
        last = [(4.0 * (b + c) - (a + d)) / 6.0 for a, b, c, d in near]
    return last, rates


def _accelerations(
    model: Model, structure: kkt.Structure, now: Instant, mask: Sequence[Number], a: Sequence[Number], dt: Number
) -> list[Any]:
    """Where the motion is after dt, to second order and back on the constraints."""
    t = now.t + dt
    v = [u for body in now.bodies for u in body[12:18]]
    moved = projection.placed(now.bodies, [dt * (u + 0.5 * dt * b) for u, b in zip(v, a, strict=True)])
    x: list[Any] = [0.0] * (6 * len(moved))
    for _ in range(PASS_CORRECTIONS):
        at = Instant(projection.placed(moved, x), t, now.angles)
        x = projection.position_correction(model, structure, at, x, mask).x
    moved = projection.placed(moved, x)
    at = Instant(_with(moved, [u + dt * b for u, b in zip(v, a, strict=True)]), t, now.angles)
    dv = projection.velocity_correction(model, structure, at, projection.MASS, mask).x
    v = [u + dt * b + c for u, b, c in zip(v, a, dv, strict=True)]
    return dynamics.accelerations(model, structure, Instant(_with(moved, v), t, now.angles), mask).x


def _with(bodies: Sequence[State], v: Sequence[Number]) -> tuple[Any, ...]:
    """The state with these velocities."""
    return tuple((*body[0:12], *v[6 * i : 6 * i + 6]) for i, body in enumerate(bodies))
