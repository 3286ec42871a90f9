"""One Runge-Kutta-Munthe-Kaas step on the state-space group (Terze et al. 2015, eq. 20), for any explicit tableau."""

from collections.abc import Callable
from typing import Any

from lienumba.groups import so3, state
from lienumba.integrators.tableaus import Tableau
from lienumba.operations import at_most, maximum

LARGEST_STAGE = 35.0  # |u|^2 (rad^2) of a stage's rotation: dexpinv ends at 2 pi, long before a step is this coarse

Bodies = Any  # a sequence: an element of S per body
Algebra = Any  # a sequence: an element of its algebra per body


def moved(x: Bodies, u: Algebra) -> Bodies:
    """x exp(u), body by body."""
    return tuple(state.product(body, state.exp(z)) for body, z in zip(x, u, strict=True))


def slope(x: Bodies, u: Algebra, F: Callable[[Bodies], Algebra], order: int) -> Algebra:
    """f* = dexpinv_{-u}(F(x exp(u))), truncated where a method of this order no longer sees it."""
    promised(u)
    f = F(moved(x, u))
    return tuple(state.dexpinv_truncated(tuple(-c for c in z), y, max(order - 2, 0)) for z, y in zip(u, f, strict=True))


def promised(u: Algebra) -> Any:
    """The largest squared rotation of u, which the driver keeps below LARGEST_STAGE."""
    worst: Any = 0.0
    for z in u:
        worst = maximum(worst, at_most(so3.dot(z[3:6], z[3:6]), LARGEST_STAGE))
    return worst


def combination(h: Any, weights: tuple[Any, ...], slopes: list[Algebra], body: int) -> Any:
    """h sum_j w_j f_j of one body."""
    (first, f), *rest = [(h * float(w), f) for w, f in zip(weights, slopes, strict=True) if w != 0]
    z = tuple(first * c for c in f[body])
    for w, f in rest:
        z = tuple(total + w * c for total, c in zip(z, f[body], strict=True))
    return z


def step(
    tableau: Tableau, x: Bodies, t: Any, h: Any, stage: Callable[[Bodies, Algebra | None, Any], Algebra]
) -> tuple[Bodies, Any, Any]:
    """One step of size h from x at time t.

    `stage(x, u, t)` is the slope at x exp(u); u is None in the first stage, where it is exactly zero. Returns the
    new state, the largest squared rotation of a stage (rad^2), and the sum of squares of the step's algebra element,
    which tells whether all of it is finite. Goes body by body, so that few values are alive at a time.
    """
    slopes: list[Algebra] = []
    rotation: Any = 0.0
    for row, c in zip(tableau.A, tableau.c, strict=True):
        if not any(row):
            slopes.append(stage(x, None, t))
            continue
        u = []
        for i in range(len(x)):
            u.append(combination(h, row, slopes, i))
            rotation = maximum(rotation, promised(u[-1:]))
        slopes.append(stage(x, tuple(u), t + float(c) * h))
    new: list[Any] = []
    square: Any = 0.0
    for i, body in enumerate(x):
        w = combination(h, tableau.b, slopes, i)
        rotation = maximum(rotation, promised((w,)))
        for c in w:
            square = square + c * c
        new += moved((body,), (w,))
    return tuple(new), rotation, square
