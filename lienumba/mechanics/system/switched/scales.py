"""How large and how fast a switched constraint is: what its gap and its rates compare with, whatever the units.

The length of a row in metres is that of its smaller body, as a slender bar of the same mass and inertia; of an angle it
is 1. The speed of a switch is the largest rate of its rows, or what their accelerations would give within this length.
"""

from collections.abc import Sequence
from functools import reduce
from typing import Any

from lienumba.mechanics.mechanism.kinematics import Instant
from lienumba.mechanics.mechanism.massless import with_lent_masses
from lienumba.mechanics.mechanism.model import GROUND, Model
from lienumba.mechanics.system import constraints, dynamics
from lienumba.mechanics.system.switches import Switch, switches_of
from lienumba.numerics.number import Number
from lienumba.numerics.operations import absolute, maximum, minimum, sqrt, where

FAR = 4e-6  # of a position in lengths: a billionth of that is its rounding
FAST = 2e-4  # of the speeds of bodies, likewise with what is left by projections
REST = 1e-3  # of the speed that the acceleration gives within the length


def lengths(model: Model, now: Instant) -> list[Any]:
    """The length of every switched row (m, or 1)."""
    bodies, found = with_lent_masses(model).bodies, list[Any]()
    reach, far, _ = constraints.sizes(model, now)
    for c in constraints.constraints_of(model):
        if c.switch is not None:
            own = [constraints.size_of(bodies[i]) for i in c.bodies if i != GROUND]
            found += [None if kind == "r" else reduce(minimum, own) for kind in c.kinds]
    first = constraints.permanent_rows(model)
    return [
        1.0 if size is None else size + FAR * (a + b)
        for size, a, b in zip(found, reach[first:], far[first:], strict=True)
    ]


def lasting(model: Model, now: Instant, accelerations: Sequence[Number]) -> list[Any]:
    """Accelerations of all switched rows (m/s^2 or rad/s^2), those that come from motion, such as that of the edge of a
    disc that is flat, no larger than what changes a rate by the speed of the bodies within the length."""
    first, size = constraints.permanent_rows(model), lengths(model, now)
    speed, biases = constraints.sizes(model, now)[2][first:], constraints.rate_and_bias(model, now)[1][first:]
    found: list[Any] = []
    for a, bias, length, v in zip(accelerations, biases, size, speed, strict=True):
        most = v * v / length
        bounded = maximum(minimum(a, most), -most)
        found.append(where(2.0 * absolute(bias) > absolute(a), bounded, a))
    return found


def speeds(model: Model, now: Instant, rates: Sequence[Number], accelerations: Sequence[Number]) -> list[Any]:
    """Of every switch (m/s or rad/s), in metres that of a fall by the length at least. rates, accelerations: of all
    switched rows, these without their reactions."""
    size, speed = lengths(model, now), constraints.sizes(model, now)[2][constraints.permanent_rows(model) :]
    metres = [kind == "m" for kind in _kinds(model)]
    found = []
    for switch in switches_of(model):
        largest: Any = 0.0
        for i in range(switch.first, switch.first + switch.rows):
            if metres[i]:
                largest = maximum(largest, sqrt(weight(model, now) * size[i]))
            largest = maximum(largest, maximum(absolute(rates[i]), sqrt(absolute(accelerations[i]) * size[i])))
            largest = maximum(largest, FAST * speed[i])
        found.append(largest)
    return found


def rest(model: Model, now: Instant, switch: Switch, acceleration: Number) -> Any:
    """The speed (m/s or rad/s) below which nothing comes back of an impact, where nobody says one: the rebound would
    rise by half a millionth of the length. acceleration: of the gap; in metres it counts as gravity at least."""
    pressing: Any = maximum(-acceleration, 0.0)
    if _kinds(model)[switch.first] == "m":
        pressing = maximum(pressing, weight(model, now))
    return REST * sqrt(pressing * lengths(model, now)[switch.first])


def weight(model: Model, now: Instant) -> Any:
    """The largest component of gravity (m/s^2)."""
    return reduce(maximum, (absolute(g) for g in dynamics.gravity(model, now.t)))


def _kinds(model: Model) -> str:
    """The letters of all switched rows."""
    every = "".join(c.kinds for c in constraints.constraints_of(model))
    return every[constraints.permanent_rows(model) :]
