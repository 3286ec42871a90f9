"""One Runge-Kutta-Munthe-Kaas step on the state-space group (Terze et al. 2015, eq. 20), for any explicit tableau."""

from collections.abc import Callable, Sequence
from typing import Any

from lienumba.groups import so3, state
from lienumba.integrators import codes
from lienumba.integrators.tableaus import Tableau
from lienumba.operations import at_most, kernel, maximum, where

LARGEST_STAGE = 35.0  # |u|^2 (rad^2) of a stage's rotation: dexpinv ends at 2 pi, long before a step is this coarse

Bodies = Any  # a sequence: an element of S per body
Algebra = Any  # a sequence: an element of its algebra per body


def moved(x: Bodies, u: Algebra) -> Bodies:
    """x exp(u), body by body."""
    return tuple(state.product(body, state.exp(z)) for body, z in zip(x, u, strict=True))


def slope(x: Bodies, u: Algebra, F: Callable[[Bodies], Algebra], terms: int | None) -> Algebra:
    """f* = dexpinv_{-u}(F(x exp(u))), its series cut behind ad^terms, or in closed form for None."""
    promised(u)
    minus = [tuple(-c for c in z) for z in u]
    pairs = zip(minus, F(moved(x, u)), strict=True)
    if terms is None:
        return tuple(state.dexpinv(z, y) for z, y in pairs)
    return tuple(state.dexpinv_truncated(z, y, terms) for z, y in pairs)


def promised(u: Algebra) -> Any:
    """The largest squared rotation of u, which the driver keeps below LARGEST_STAGE."""
    worst: Any = 0.0
    for z in u:
        worst = maximum(at_most(so3.dot(z[3:6], z[3:6]), LARGEST_STAGE), worst)
    return worst


def combination(h: Any, weights: tuple[Any, ...], slopes: Sequence[Any]) -> tuple[Any, Any]:
    """u = h sum_j w_j f_j of one body from its slopes, and its squared rotation (rad^2)."""
    (first, f), *rest = [(h * float(w), f) for w, f in zip(weights, slopes, strict=True) if w != 0]
    u = tuple(first * c for c in f)
    for w, f in rest:
        u = tuple(total + w * c for total, c in zip(u, f, strict=True))
    return u, promised((u,))


def advanced(h: Any, tableau: Tableau, x: Any, slopes: Sequence[Any]) -> tuple[Any, Any, Any]:
    """One body at the end of a step: its new state, the squared rotation, and the sum of squares of the move."""
    w, rotation = combination(h, tableau.b, slopes)
    square: Any = 0.0
    for c in w:
        square = square + c * c
    return moved((x,), (w,))[0], rotation, square


@kernel
def verdict(rotation: Any, square: Any, first: Any, every: Any) -> Any:
    """The code of a step, from its largest squared rotation, its sum of squares, and whether the KKT of its first stage
    and of every stage was sound. Overflow makes later stages unsound: there it is the state that is not finite."""
    code = where(every > 0.0, 0.0, codes.SINGULAR)
    code = where(square < codes.HUGE, code, codes.NON_FINITE)
    code = where(first > 0.0, code, codes.SINGULAR)
    return where(rotation >= LARGEST_STAGE, codes.ROTATION, code)


def step(
    tableau: Tableau, x: Bodies, t: Any, h: Any, stage: Callable[[Bodies, Algebra | None, Any], Algebra]
) -> tuple[Bodies, Any, Any]:
    """One step of size h from x at time t.

    `stage(x, u, t)` is the slope at x exp(u); u is None in the first stage, where it is exactly zero. Returns the
    new state, the largest squared rotation of a stage (rad^2), and the sum of squares of the move, which tells
    whether all of it is finite.
    """
    slopes: list[list[Any]] = [[] for _ in x]  # by body
    rotation: Any = 0.0
    square: Any = 0.0
    for row, c in zip(tableau.A, tableau.c, strict=True):
        u = []
        for f in slopes if any(row) else ():
            z, turned = combination(h, row, f)
            rotation = maximum(turned, rotation)
            u.append(z)
        for f, new in zip(slopes, stage(x, tuple(u) or None, t + float(c) * h), strict=True):
            f.append(new)
    end = []
    for body, f in zip(x, slopes, strict=True):
        state_, turned, length = advanced(h, tableau, body, f)
        rotation = maximum(turned, rotation)
        square = square + length
        end.append(state_)
    return tuple(end), rotation, square
