"""Projection onto the constraints: the nearest state that fulfils them (Terze et al. 2015, eqs. 21, 22).

Positions, in local coordinates about the unprojected q^:  r = r^ + x_r,  R = R^ exp(x_R). There
|R - R^|_F^2 = 2 |x_R|^2 + O(x^4), so with W = diag(I, 2 I) this is the paper's problem with orthogonality built in.
x is the total correction: adding up plain Gauss-Newton steps would miss the minimiser by O(x^2).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

from lienumba.groups import so3
from lienumba.groups.state import State
from lienumba.keys.registry import Registry
from lienumba.mechanics.elements.contacts import CONTACTS
from lienumba.mechanics.mechanism.kinematics import OFF, Instant
from lienumba.mechanics.mechanism.massless import with_lent_masses
from lienumba.mechanics.mechanism.model import Body, Model
from lienumba.mechanics.system import constraints, kkt
from lienumba.mechanics.system.body_axes import GLOBAL, Axes
from lienumba.mechanics.system.dynamics import body_masses, energies, mass_matrix
from lienumba.mechanics.system.switches import CONTACT, Switch, switches_of
from lienumba.mechanics.tolerances import (
    BRANCH_ENERGY,
    LEAP_SPEED,
    ROUNDOFF,
    SINGULAR_RATE,
)
from lienumba.numerics.number import Number
from lienumba.numerics.operations import absolute, divide, is_zero, maximum, minimum, where


def position_violation(model: Model, now: Instant, counts: Sequence[Number] | None = None) -> Any:
    """The largest violation (m, or 1) that is more than the rounding of its joint; 0 if there is none.

    counts: for each row whether it counts, above one half.
    """
    reach, far, _ = constraints.sizes(model, now)
    rounding = [ROUNDOFF * (p + r) for p, r in zip(reach, far, strict=True)]
    return _worst(constraints.residual(model, now), rounding, counts)


def velocity_violation(model: Model, now: Instant, counts: Sequence[Number] | None = None) -> Any:
    """The largest rate of a violation (m/s or rad/s) beyond the rounding of its joint; 0 if there is none."""
    _, _, speed = constraints.sizes(model, now)
    return _worst(constraints.rates(model, now), [ROUNDOFF * v for v in speed], counts)


def _worst(rows: Sequence[Number], rounding: Sequence[Number], counts: Sequence[Number] | None) -> Any:
    worst: Any = 0.0
    for row, limit, count in zip(rows, rounding, counts or [1.0] * len(rows), strict=True):
        violation = where(absolute(row) <= limit, 0.0, absolute(row))
        worst = maximum(worst, where(count > 0.5, violation, 0.0))
    return worst


def placed(bodies: Sequence[State], x: Sequence[Number]) -> tuple[Any, ...]:
    """The state with its positions moved by the correction x (6 k: global shift, body-frame rotation)."""
    return tuple(
        so3.add(body[0:3], tuple(x[6 * i : 6 * i + 3]))
        + so3.multiply(body[3:12], so3.exp(tuple(x[6 * i + 3 : 6 * i + 6])))
        + body[12:18]
        for i, body in enumerate(bodies)
    )


def position_correction(
    model: Model,
    structure: kkt.Structure,
    now: Instant,
    x: Sequence[Number],
    mask: Sequence[Number],
    axes: Axes = GLOBAL,
    masses: bool = False,
) -> kkt.Solution:
    """The next total correction x+ from q^ (Terze et al. 2015, eqs. 21, 22):  W x+ + C^T mu = 0,  C (x+ - x) = -Phi;
    `now` is q^ moved by x; axes: of the equations at `now`; masses: whether W is that of the bodies."""
    C = constraints.jacobian(model, now, axes)
    W: kkt.Entries = {(i, i): weight for i, weight in enumerate(_weights(structure.bodies))}
    if masses:
        W = body_masses(with_lent_masses(model).bodies)
    g = [-phi for phi in constraints.residual(model, now, axes)]
    along = axes.into(now, x)
    for (row, column), entry in C.items():
        g[row] = g[row] + entry * along[column]
    solution = kkt.solve(structure, W, C, [0.0] * (6 * structure.bodies), g, position_mask(model, mask))
    return solution._replace(x=axes.out_of(now, solution.x))


def chord_correction(
    model: Model,
    by: kkt.Eliminated,
    now: Instant,
    x: Sequence[Number],
    mu: Sequence[Number],
    mask: Sequence[Number],
    axes: Axes = GLOBAL,
) -> kkt.Solution:
    """The next total correction and multipliers by an earlier elimination, which need not be that of `now`: it turns
    what x and mu leave of  W x + C^T mu = 0,  Phi = 0  into their changes. So the limit is the same."""
    pull = [-weight * xi for weight, xi in zip(_weights(by.structure.bodies), axes.into(now, x), strict=True)]
    g = masked([-phi for phi in constraints.residual(model, now, axes)], position_mask(model, mask))
    step = by.solve(without_reactions(model, now, pull, mu, axes), g)
    return kkt.Solution(_sum(x, axes.out_of(now, step.x)), _sum(mu, step.mu), by)


def without_reactions(
    model: Model, now: Instant, f: Sequence[Number], mu: Sequence[Number], axes: Axes = GLOBAL
) -> list[Any]:
    """f - C^T mu."""
    rest = list(f)
    for (row, column), entry in constraints.jacobian(model, now, axes).items():
        rest[column] = rest[column] - entry * mu[row]
    return rest


def position_mask(model: Model, mask: Sequence[Number]) -> list[Any]:
    """The mask without the rows that have no position."""
    levels = [c.level for c in constraints.constraints_of(model) for _ in c.kinds]
    return [m if level == "position" else 0.0 for m, level in zip(mask, levels, strict=True)]


def masked(rows: Sequence[Number], mask: Sequence[Number]) -> list[Any]:
    """0 in the rows that are left out."""
    return [m * row for m, row in zip(mask, rows, strict=True)]


def _weights(bodies: int) -> list[float]:
    """The diagonal of W: |R - R^|_F^2 is twice the squared angle."""
    return [1.0, 1.0, 1.0, 2.0, 2.0, 2.0] * bodies


def _sum(x: Sequence[Number], y: Sequence[Number]) -> list[Any]:
    return [a + b for a, b in zip(x, y, strict=True)]


def counted(row_weights: Sequence[Number], mask: Sequence[Number], level: str, switched: int) -> list[Any]:
    """Which rows a position or velocity must fulfil, 1 or 0: not those that are faded. The masked ones only on the
    "position" level, and while none is faded: their rates follow from the others no better than positions do. switched:
    where the rows begin that count only in use."""
    counts = [where(x == 1.0, 1.0, 0.0) for x in row_weights]
    every: Any = 1.0
    for count in counts:
        every = minimum(count, every)
    every = every if level == "position" else 0.0
    rest = [every] * switched + [0.0] * (len(counts) - switched)
    return [where(m > 0.5, count, other) for m, count, other in zip(mask, counts, rest, strict=True)]


def lost(model: Model, now: Instant, counts: Sequence[Number]) -> Any:
    """The largest violation of the rows that do not count, relative to the largest joint; 1 for angles."""
    reach = constraints.sizes(model, now)[0]
    lengths = [x for c in constraints.constraints_of(model) for x in c.kinds]
    size = constraints.largest([r for r, kind in zip(reach, lengths, strict=True) if kind == "m"])
    worst: Any = 0.0
    permanent = constraints.permanent_rows(model)
    residual = constraints.residual(model, now)[:permanent]
    for phi, kind, count in zip(residual, lengths[:permanent], counts[:permanent], strict=True):
        violation = absolute(phi) if kind == "r" else divide(absolute(phi), size)
        worst = maximum(where(count > 0.5, 0.0, violation), worst)
    return worst


def lost_rate(model: Model, now: Instant, counts: Sequence[Number]) -> Any:
    """The largest violation (m/s or rad/s) of the rows that have no position and do not count."""
    worst: Any = 0.0
    rates = constraints.rates(model, now)
    for c, rows in zip(constraints.constraints_of(model), constraints.rows_of(model), strict=True):
        if c.level != "position" and c.switch is None:
            for row in range(rows.start, rows.stop):
                worst = maximum(where(counts[row] > 0.5, 0.0, absolute(rates[row])), worst)
    return worst


def branch_energy_excess(model: Model, before: Instant, after: Instant) -> Any:
    """Kinetic energy (J) of the correction of velocities beyond `BRANCH_ENERGY` of that of the motion; 0 for roundoff.

    A loop that comes through a singular position on another branch has velocities which this branch does not allow.
    Prescribed motions may jump: then it is 0.
    """
    if not all(is_zero(x) for x in constraints.time_rate(model, before)):
        return 0.0
    every = list(zip(before.bodies, after.bodies, strict=True))
    x = [[b - a for a, b in zip(old[12:18], new[12:18], strict=True)] for old, new in every]
    changed = tuple((*old[:12], *dv) for (old, _), dv in zip(every, x, strict=True))
    largest = constraints.largest([c for dv in x for c in dv])
    taken = energies(model, replace(after, bodies=changed))[0] - BRANCH_ENERGY * energies(model, before)[0]
    return where(largest > SINGULAR_RATE, taken, 0.0)


def leap_speed_excess(model: Model, before: Instant) -> Any:
    """Speed (m/s) of closed contacts along their normals, before the projection, beyond `LEAP_SPEED` of their speeds.

    In a step that has passed over the leap of a contact the projection would take the energy of an impact, which the
    energy balance does not have.
    """
    worst: Any = 0.0
    if not any(leaps(model, switch) for switch in switches_of(model)):
        return worst
    rates, (_, _, speeds) = constraints.rates(model, before), constraints.sizes(model, before)
    for c, rows in zip(constraints.constraints_of(model), constraints.rows_of(model), strict=True):
        if c.level == "position" and c.switch is not None and leaps(model, c.switch):
            row, closed = rows.start, before.modes[c.switch.key].on > OFF
            worst = maximum(where(closed, absolute(rates[row]) - LEAP_SPEED * speeds[row] - SINGULAR_RATE, 0.0), worst)
    return worst


def leaps(model: Model, switch: Switch) -> bool:
    """Whether a switch is a contact that may."""
    return switch.what == CONTACT and CONTACTS[model.contacts[switch.index].type].leaps


def velocity_correction(
    model: Model,
    structure: kkt.Structure,
    now: Instant,
    weight: "Weight",
    mask: Sequence[Number],
    axes: Axes = GLOBAL,
) -> kkt.Solution:
    """The change x of all velocities (Terze et al. 2015, eq. 21, for velocities) with  W x + C^T mu = 0,  C (v + x) =
    -Phi_t."""
    C = constraints.jacobian(model, now, axes)
    W = weight.matrix(model, now)
    rates = [-rate for rate in constraints.rates(model, now, axes)]
    solution = kkt.solve(structure, W, C, [0.0] * (6 * structure.bodies), rates, mask)
    return solution._replace(x=axes.out_of(now, solution.x))


def tangential(
    model: Model,
    structure: kkt.Structure,
    now: Instant,
    mask: Sequence[Number],
    x: Sequence[Number],
    axes: Axes = GLOBAL,
) -> list[Any]:
    """Of changes x of all velocities (6 k) the nearest, by the kinetic energy, that the constraints allow; also where
    these are weak."""
    M, none = mass_matrix(model, now), [0.0] * structure.rows
    pull = kkt.rest(M, {}, [0.0] * len(x), none, [-c for c in axes.into(now, x)], none)[0]
    return axes.out_of(now, kkt.solve(structure, M, constraints.jacobian(model, now, axes), pull, none, mask).x)


@dataclass(frozen=True)
class Weight:
    """W of a velocity correction; words: what a citation calls it; bodies: as they weigh in it; rotors: whether these
    do, too."""

    name: str
    words: str
    matrix: Callable[[Model, Instant], dict[tuple[int, int], Number]]
    bodies: Callable[[Model], Sequence[Body]]
    rotors: bool


def identity(model: Model, now: Instant) -> dict[tuple[int, int], Number]:
    """I, of all velocities."""
    return {(i, i): 1.0 for i in range(6 * len(model.bodies))}


def _units(model: Model) -> list[Body]:
    return [Body(body.name, 1.0, (1.0, 1.0, 1.0, 0.0, 0.0, 0.0)) for body in model.bodies]


WEIGHTS: Registry[Weight] = Registry("weight", lambda weight: weight.name)
MASS = WEIGHTS.add(Weight("mass", "the mass matrix", mass_matrix, lambda model: model.bodies, True))
WEIGHTS.add(Weight("identity", "the identity", identity, _units, False))
