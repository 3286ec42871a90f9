"""Equations of motion of links in a row in minimal coordinates, written independently of the engine, for a rival that
has no joints.

M by composite bodies, the rest by Newton and Euler, all about the joints and in the axes of the links, which are
parallel where all angles are 0. Numbers are floats, arrays or expressions; an exact 0 or 1 folds away, so that no
rival computes what a hand would leave out.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

Vector = Sequence[Any]
NONE: tuple[float, float, float] = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Link:
    """kind: "hinge" or "slide" about or along an axis (0, 1, 2), or "ball", which only the first link may be; point:
    of its joint, from the joint of the link before it; centre: the mass centre, from its own joint; inertia: about the
    mass centre, along the axes; drive: what acts along the joint (three numbers of a ball); push: a force at the mass
    centre, link axes."""

    kind: str
    axis: int
    point: Vector
    centre: Vector
    mass: Any
    inertia: Vector
    drive: Any = 0.0
    push: Vector = NONE


@dataclass(frozen=True)
class Moving:
    """turns: of each hinge cosine and sine, else (1, 0); slides: displacements, 0 if none; rates: of each joint (three
    of a ball, link axes); lift: the acceleration of the first joint less gravity, in the axes of the first link if it
    is a ball, else in those of the ground."""

    turns: Sequence[tuple[Any, Any]]
    slides: Sequence[Any]
    rates: Sequence[Any]
    lift: Vector


def times(a: Any, b: Any) -> Any:
    for x, y in ((a, b), (b, a)):
        if isinstance(x, float) and x in (0.0, 1.0, -1.0):
            return 0.0 if x == 0.0 else y if x == 1.0 else -y
    return a * b


def plus(*terms: Any) -> Any:
    kept = [x for x in terms if not (isinstance(x, float) and x == 0.0)]
    if not kept:
        return 0.0
    total = kept[0]
    for x in kept[1:]:
        total = total + x
    return total


def add(*vectors: Vector) -> list[Any]:
    return [plus(*parts) for parts in zip(*vectors, strict=True)]


def scale(a: Any, v: Vector) -> list[Any]:
    return [times(a, x) for x in v]


def dot(a: Vector, b: Vector) -> Any:
    return plus(*(times(x, y) for x, y in zip(a, b, strict=True)))


def cross(a: Vector, b: Vector) -> list[Any]:
    return [plus(times(a[i - 2], b[i - 1]), times(times(-1.0, a[i - 1]), b[i - 2])) for i in range(3)]


def unit(axis: int) -> list[float]:
    return [float(i == axis) for i in range(3)]


def to_parent(link: Link, turn: tuple[Any, Any], v: Vector) -> list[Any]:
    (c, s), (a, b) = turn, (link.axis - 2, link.axis - 1)
    out = list(v)
    out[a], out[b] = plus(times(c, v[a]), times(-1.0, times(s, v[b]))), plus(times(s, v[a]), times(c, v[b]))
    return out


def to_link(link: Link, turn: tuple[Any, Any], v: Vector) -> list[Any]:
    return to_parent(link, (turn[0], times(-1.0, turn[1])), v)


def _turned(link: Link, turn: tuple[Any, Any], inertia: list[list[Any]]) -> list[list[Any]]:
    """R I R^T of a turn in a plane, by half the products."""
    (c, s), (a, b, k) = turn, ((link.axis + 1) % 3, (link.axis + 2) % 3, link.axis)
    x = plus(times(c, plus(inertia[a][a], times(-1.0, inertia[b][b]))), times(-2.0, times(s, inertia[a][b])))
    out = [list(row) for row in inertia]
    out[a][a] = plus(inertia[b][b], times(c, x))
    out[b][b] = plus(inertia[a][a], times(-1.0, times(c, x)))
    out[a][b] = out[b][a] = plus(inertia[a][b], times(s, x))
    out[a][k] = out[k][a] = plus(times(c, inertia[a][k]), times(-1.0, times(s, inertia[b][k])))
    out[b][k] = out[k][b] = plus(times(s, inertia[a][k]), times(c, inertia[b][k]))
    return out


def _shifted(p: Vector, mass: Any, h: Vector, inertia: list[list[Any]]) -> list[list[Any]]:
    """About a point that lies at -p: mass and first moment h about the old one."""
    along = [plus(times(0.5, times(mass, p[i])), h[i]) for i in range(3)]
    whole = times(2.0, dot(p, along))
    return [
        [plus(inertia[i][j], whole if i == j else 0.0, times(-1.0, plus(times(p[i], along[j]), times(p[j], along[i]))))
         for j in range(3)] for i in range(3)
    ]  # fmt: skip


def _own(link: Link) -> tuple[Any, list[Any], list[list[Any]]]:
    """Mass, first moment and inertia about the joint."""
    diagonal = [[link.inertia[i] if i == j else 0.0 for j in range(3)] for i in range(3)]
    return link.mass, scale(link.mass, link.centre), _shifted(link.centre, link.mass, NONE, diagonal)


def _arm(link: Link, slide: Any) -> list[Any]:
    return add(link.point, scale(slide, unit(link.axis)))


def _mass_matrix(links: Sequence[Link], now: Moving) -> list[list[Any]]:
    """Of hinges and slides; a ball gives three rows."""
    bodies, n = [_own(link) for link in links], len(links)
    for i in range(n - 1, 0, -1):
        mass, h, inertia = bodies[i]
        h, inertia = to_parent(links[i], now.turns[i], h), _turned(links[i], now.turns[i], inertia)
        p = _arm(links[i], now.slides[i])
        above = bodies[i - 1]
        moved, about = add(h, scale(mass, p)), _shifted(p, mass, h, inertia)
        bodies[i - 1] = (
            plus(above[0], mass),
            add(above[1], moved),
            [add(x, y) for x, y in zip(above[2], about, strict=True)],
        )
    rows: list[list[Any]] = []
    for i, link in enumerate(links):
        mass, h, inertia = bodies[i]
        for k in range(3) if link.kind == "ball" else (link.axis,):
            e = unit(k)
            force, couple = (scale(mass, e), cross(h, e)) if link.kind == "slide" else (cross(e, h), inertia[k])
            column = [_along(link, force, couple)] if link.kind != "ball" else [couple[: k + 1]]
            for j in range(i, 0, -1):
                force, couple = _carried(links[j], now, j, force, couple)
                column.append(_along(links[j - 1], force, couple))
            rows.append([x for part in reversed(column) for x in (part if isinstance(part, list) else [part])])
    return rows


def _carried(link: Link, now: Moving, j: int, force: Vector, couple: Vector) -> tuple[list[Any], list[Any]]:
    """A force and its couple about joint j, about the joint before it."""
    force, couple = to_parent(link, now.turns[j], force), to_parent(link, now.turns[j], couple)
    return force, add(couple, cross(_arm(link, now.slides[j]), force))


def _along(link: Link, force: Vector, couple: Vector) -> Any:
    if link.kind == "ball":
        return list(couple)
    return force[link.axis] if link.kind == "slide" else couple[link.axis]


def _needed(links: Sequence[Link], now: Moving) -> list[Any]:
    """What would have to act along the joints if all their rates were constant, less what does."""
    w, faster, a = list(NONE), list(NONE), list(now.lift)
    loads = []
    for i, link in enumerate(links):
        rate = now.rates[i]
        if link.kind == "ball":
            w = list(rate)
        else:
            p, e = _arm(link, now.slides[i]), unit(link.axis)
            a = add(a, cross(faster, p), cross(w, cross(w, p)))
            if link.kind == "slide":
                a = add(a, scale(2.0, cross(w, scale(rate, e))))
            a, w, faster = (to_link(link, now.turns[i], x) for x in (a, w, faster))
            if link.kind == "hinge":
                own = scale(rate, e)
                faster, w = add(faster, cross(w, own)), add(w, own)
        mass, h, inertia = _own(link)
        force = add(scale(mass, a), cross(faster, h), cross(w, cross(w, h)), scale(-1.0, link.push))
        spin, grows = ([dot(row, x) for row in inertia] for x in (w, faster))
        couple = add(grows, cross(w, spin), cross(h, a), scale(-1.0, cross(link.centre, link.push)))
        loads.append((force, couple))
    found: list[Any] = []
    for i in range(len(links) - 1, -1, -1):
        link, (force, couple) = links[i], loads[i]
        drive = list(link.drive) if link.kind == "ball" else [link.drive]
        along = _along(link, force, couple)
        along = along if isinstance(along, list) else [along]
        found = [plus(x, times(-1.0, y)) for x, y in zip(along, drive, strict=True)] + found
        if i:
            carried = _carried(link, now, i, force, couple)
            loads[i - 1] = (add(loads[i - 1][0], carried[0]), add(loads[i - 1][1], carried[1]))
    return found


def accelerations(links: Sequence[Link], now: Moving) -> list[Any]:
    """The rates of the rates, three first of a ball."""
    return solved(_mass_matrix(links, now), scale(-1.0, _needed(links, now)))


def solved(rows: list[list[Any]], b: Vector) -> list[Any]:
    """x of M x = b; rows: of the lower triangle; by L D L^T."""
    n, x = len(rows), list(b)
    lower = [[0.0] * n for _ in range(n)]
    inverse: list[Any] = []
    for i in range(n):
        scaled: list[Any] = []
        for j in range(i):
            scaled.append(plus(rows[i][j], *(times(-1.0, times(scaled[k], lower[j][k])) for k in range(j))))
            lower[i][j] = times(scaled[j], inverse[j])
        inverse.append(1.0 / plus(rows[i][i], *(times(-1.0, times(scaled[k], lower[i][k])) for k in range(i))))
        x[i] = plus(x[i], *(times(-1.0, times(lower[i][k], x[k])) for k in range(i)))
    x = [times(inverse[i], x[i]) for i in range(n)]
    for i in range(n - 1, -1, -1):
        x[i] = plus(x[i], *(times(-1.0, times(lower[k][i], x[k])) for k in range(i + 1, n)))
    return x


def centres(links: Sequence[Link], now: Moving, first: Sequence[Vector], at: Vector) -> list[list[Any]]:
    """Mass centres, global axes; first: columns of the first link's rotation if it is a ball; at: the first joint."""
    columns, joint, found = [unit(0), unit(1), unit(2)], list(at), []
    for i, link in enumerate(links):
        if link.kind == "ball":
            columns = [list(x) for x in first]
        else:
            p = _arm(link, now.slides[i])
            joint = add(joint, *(scale(x, column) for x, column in zip(p, columns, strict=True)))
            turned = [to_parent(link, now.turns[i], unit(k)) for k in range(3)]
            columns = [add(*(scale(x, column) for x, column in zip(e, columns, strict=True))) for e in turned]
        found.append(add(joint, *(scale(x, column) for x, column in zip(link.centre, columns, strict=True))))
    return found
