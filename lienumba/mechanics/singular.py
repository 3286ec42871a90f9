"""Accelerations in a singular position, where the constraints do not say them all: the limit from both sides.

All runs at once, elementwise.
"""

from typing import Any

from lienumba.mechanics import constraints, dynamics, kkt, projection
from lienumba.mechanics.model import Model
from lienumba.mechanics.motion import Instant
from lienumba.operations import where

Both = tuple[list[Any], list[Any]]
TURN, LONGEST = 0.05, 0.05  # rad and s: how far to either side, at most
CORRECTIONS = 6


def limiting_accelerations(model: Model, structure: kkt.Structure, now: Instant, mask: list[Any]) -> Both:
    """The 6 k accelerations at `now`, and their 6 k time derivatives, from those at -2, -1, 1 and 2 steps of its motion,
    to fourth order."""
    fastest = constraints.largest([x for body in now.bodies for x in body[15:18]])
    h = TURN / where(fastest > TURN / LONGEST, fastest, TURN / LONGEST)
    near = list(zip(*(_accelerations(model, structure, now, mask, n * h) for n in (-2.0, -1.0, 1.0, 2.0)), strict=True))
    rates = [(8.0 * (c - b) - (d - a)) / (12.0 * h) for a, b, c, d in near]
    return [(4.0 * (b + c) - (a + d)) / 6.0 for a, b, c, d in near], rates


def _accelerations(model: Model, structure: kkt.Structure, now: Instant, mask: list[Any], dt: Any) -> list[Any]:
    """Where the motion is after dt, to first order and back on the constraints."""
    t = now.t + dt
    moved = projection.placed(now.bodies, [dt * u for body in now.bodies for u in body[12:18]])
    x: list[Any] = [0.0] * (6 * len(moved))
    for _ in range(CORRECTIONS):
        at = Instant(projection.placed(moved, x), t, now.angles)
        x = projection.position_correction(model, structure, at, x, mask).x
    at = Instant(projection.placed(moved, x), t, now.angles)
    dv = projection.velocity_correction(model, structure, at, "mass", mask).x
    bodies = tuple(
        (*body[0:12], *(v + u for v, u in zip(body[12:18], dv[6 * i : 6 * i + 6], strict=True)))
        for i, body in enumerate(at.bodies)
    )
    return dynamics.accelerations(model, structure, Instant(bodies, t, now.angles), mask).x
