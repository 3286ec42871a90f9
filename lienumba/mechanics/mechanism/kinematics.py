"""What a law sees of a mechanism, and what follows from a law by jets.

A law is a plain function of a View that returns rows of numbers: a joint's residual, a driver's, the coordinates of a
force. Run along the motion  r' = v, R' = R hat(w)  it gives its rate and the bias of its second derivative; run on
unit velocities, its columns of C. A velocity-level law reads v and w: its value is a rate, its columns d/dv.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np

from lienumba.groups import so3
from lienumba.mechanics.mechanism.model import GROUND
from lienumba.numerics.jets import Directions, Dual, Jet, go_together, lift, seeds
from lienumba.numerics.number import Matrix, Number, Vector
from lienumba.numerics.operations import where

Body = tuple[Any, ...]  # 18 numbers: an element of S
AT_REST = (0.0, 0.0, 0.0)
UNIT = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
UNITS = tuple(tuple(float(i == j) for j in range(6)) for i in range(6))  # velocities of a body
TOGETHER = tuple(seeds(UNITS))
Rates = tuple[Any, ...]  # numbers, or derivatives along several directions at once


class Motion(NamedTuple):
    """The motion of one body: r and v of the mass centre (global), R (body to global), w (body frame)."""

    r: Any
    R: Any
    v: Any = AT_REST
    w: Any = AT_REST

    def point(self, p: Vector) -> Any:
        """The global position of a point given in the body's frame."""
        return so3.add(self.r, so3.rotate(self.R, p))


FIXED = Motion(AT_REST, so3.IDENTITY)


class Mode(NamedTuple):
    """The mode of a switched constraint. on: OFF, STICK or SLIDE; memory: numbers that it keeps while it is on."""

    on: Any = 0.0
    memory: tuple[Any, ...] = ()

    def sliding(self, rate: Any) -> Any:
        """A rate of sliding: exactly 0 of what sticks."""
        return where(self.on > OFF, where(self.on > STICK, rate, 0.0), rate)


OFF, STICK, SLIDE = 0.0, 1.0, 2.0  # not there; closed, or stuck; closed and sliding
Modes = dict[tuple[str, str], Mode]  # by what it is ("joint", "lock", "limit", "contact", "friction") and its name


@dataclass(frozen=True)
class Instant:
    """A state at a time. angles: by joint (`model.Counted`), the angle (rad, over all turns) near which its angle is to
    be counted; within: the time that tells on which side of a jump t lies, where that is not t itself; states: of the
    laws of the user's own, by name; modes: of switched constraints."""

    bodies: tuple[Body, ...]
    t: Any = 0.0
    angles: dict[Any, Any] = field(default_factory=dict)
    within: Any = None
    states: dict[str, tuple[Any, ...]] = field(default_factory=dict)
    modes: Modes = field(default_factory=dict)

    def motion(self, i: int) -> Motion:
        body = self.bodies[i]
        return Motion(body[0:3], body[3:12], body[12:15], body[15:18])


@dataclass(frozen=True)
class View:
    """view[i]: the motion of body i, of the ground for GROUND; the rest as in Instant. Jets where they move."""

    motions: dict[int, Motion]
    t: Any
    angles: dict[Any, Any]
    within: Any = None
    states: dict[str, tuple[Any, ...]] = field(default_factory=dict)
    modes: Modes = field(default_factory=dict)

    def __getitem__(self, i: int) -> Motion:
        return self.motions.get(i, FIXED)


Law = Callable[[View], Any]  # a sequence of rows


def still(now: Instant, ends: tuple[int, ...]) -> View:
    """The state as it is: numbers."""
    return View({i: now.motion(i) for i in ends if i != GROUND}, now.t, now.angles, now.within, now.states, now.modes)


def moving(now: View, accelerations: Sequence[Number] | None = None) -> View:
    """All bodies in motion, and time with them: second-order jets. accelerations: v' (global) and w' (body frame), 6
    rows per body; without them the velocities are frozen."""
    motions = {}
    for i, m in now.motions.items():
        first = _times_hat(m.R, m.w)
        second = _times_hat(first, m.w)
        rows = AT_REST + AT_REST if accelerations is None else tuple(accelerations[6 * i : 6 * i + 6])
        if accelerations is not None:
            second = tuple(a + b for a, b in zip(second, _times_hat(m.R, rows[3:6]), strict=True))
        R = zip(m.R, first, second, strict=True)
        r = zip(m.r, m.v, rows[0:3], strict=True)
        v, w = (m.v, m.w) if accelerations is None else (_jets(m.v, rows[0:3]), _jets(m.w, rows[3:6]))
        motions[i] = Motion(tuple(Jet(*x) for x in r), tuple(Jet(*x) for x in R), v, w)
    return replace(now, motions=motions, t=Jet(now.t, 1.0))


def seen_from(view: View, base: int) -> View:
    """The view from the axes of one body, as if it stood still where the ground stands, r = 0 and R = I, and the ground
    elsewhere: positions and velocities moved rigidly, by a motion that is frozen."""
    origin = view[base]

    def moved(m: Motion) -> Motion:
        r = so3.rotate_back(origin.R, so3.subtract(m.r, origin.r))
        return Motion(r, so3.multiply(so3.transpose(origin.R), m.R), so3.rotate_back(origin.R, m.v), m.w)

    motions = {i: moved(m) for i, m in view.motions.items() if i != base}
    own = Motion(AT_REST, so3.IDENTITY, so3.rotate_back(origin.R, origin.v), origin.w)
    return replace(view, motions=motions | {GROUND: moved(FIXED), base: own})


def waiting(now: Instant, ends: tuple[int, ...]) -> View:
    """All bodies at rest, while time moves."""
    view = still(now, ends)
    at_rest = {i: Motion(m.r, m.R) for i, m in view.motions.items()}
    return replace(view, motions=at_rest, t=Jet(now.t, 1.0))


def _unit(view: View, body: int, velocity: Rates, velocity_level: bool) -> View:
    """One body moving with a unit velocity (6), or with it as the derivative of its velocity; time stands."""
    v, w = velocity[0:3], velocity[3:6]
    m = view[body]
    if velocity_level:
        m = Motion(m.r, m.R, _duals(m.v, v), _duals(m.w, w))
    else:
        m = Motion(_duals(m.r, v), _duals(m.R, _times_hat(m.R, w)), m.v, m.w)
    return replace(view, motions=view.motions | {body: m})


def drifting(now: Instant, ends: tuple[int, ...], drifts: Sequence[Matrix]) -> View:
    """The R of every body moving along a matrix of its own (9 numbers each), which may lead off SO(3); time stands."""
    view = still(now, ends)
    motions = {i: m._replace(R=_duals(m.R, drifts[i])) for i, m in view.motions.items()}
    return replace(view, motions=motions)


def columns(
    law: Law, view: View, body: int, velocity_level: bool = False, along: Sequence[Vector] | None = None
) -> list[list[Any]]:
    """The block of C of one body: rows x 6 (v, w in the body frame). along: what v counts along, three unit vectors in
    the axes of the view; by default these axes."""
    numbers = (x for m in (view[body], *view.motions.values()) for x in (*m.r, *m.R, *m.v, *m.w))
    if along is None and go_together(numbers):
        with np.errstate(all="ignore"):  # floats know no warnings
            rows = [lift(row).b for row in law(_unit(view, body, TOGETHER, velocity_level))]
        return [row.apart() if isinstance(row, Directions) else [row] * 6 for row in rows]
    units = UNITS if along is None else (*((*e, *AT_REST) for e in along), *UNITS[3:])
    block = [[lift(row).b for row in law(_unit(view, body, u, velocity_level))] for u in units]
    return [list(row) for row in zip(*block, strict=True)]


def _jets(values: Vector, rates: Vector) -> Any:
    return tuple(Jet(x, dx) for x, dx in zip(values, rates, strict=True))


def _duals(values: Vector, rates: Rates) -> Any:
    return tuple(Dual(x, dx) for x, dx in zip(values, rates, strict=True))


def _times_hat(R: Matrix, w: Rates) -> Any:
    """R hat(w): each row crossed with w."""
    return so3.cross(R[0:3], w) + so3.cross(R[3:6], w) + so3.cross(R[6:9], w)


def inertia_times(inertia: Vector, w: Vector) -> Any:
    """J w, body frame, J by its elements xx yy zz xy xz yz."""
    xx, yy, zz, xy, xz, yz = inertia
    return (
        xx * w[0] + xy * w[1] + xz * w[2],
        xy * w[0] + yy * w[1] + yz * w[2],
        xz * w[0] + yz * w[1] + zz * w[2],
    )
