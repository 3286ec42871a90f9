"""The equations of motion: M v' + C^T lambda = Q, C v' = xi (Terze et al. 2015, eqs. 10-15), energy and power.

The paper's lambda is `mu`, `multipliers` or `Solution.mu` in the code.
"""

from collections.abc import Sequence
from typing import Any

from lienumba.groups import so3
from lienumba.mechanics.mechanism.kinematics import Instant, inertia_times
from lienumba.mechanics.mechanism.model import Model, at_time
from lienumba.mechanics.system import applied_forces, constraints, kkt
from lienumba.numerics.jets import Jet, lift
from lienumba.numerics.number import Number
from lienumba.numerics.operations import is_zero

INERTIA_ELEMENTS = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))


def mass_matrix(model: Model) -> kkt.Entries:
    """The lower entries of M = diag(m I, J) that are not exactly zero (Terze et al. 2015, eqs. 30, 33)."""
    entries: kkt.Entries = {}
    for i, body in enumerate(model.bodies):
        for c in range(3):
            entries[6 * i + c, 6 * i + c] = body.mass
        for (a, b), x in zip(INERTIA_ELEMENTS, body.inertia, strict=True):
            if not is_zero(x):
                entries[6 * i + 3 + max(a, b), 6 * i + 3 + min(a, b)] = x
    return entries


def shapes(model: Model) -> kkt.Entries:
    """diag(I, I 6 tr(J)/m): the metric of shifts and turns by the size of each body, whatever its mass: for a slender
    bar, its length squared."""
    entries: kkt.Entries = {}
    for i, body in enumerate(model.bodies):
        square = 6.0 * (body.inertia[0] + body.inertia[1] + body.inertia[2]) / body.mass
        entries |= {(6 * i + c, 6 * i + c): 1.0 if c < 3 else square for c in range(6)}
    return entries


def gravity(model: Model, t: Number) -> Any:
    """Its three components (m/s^2, global) at time t."""
    return tuple(at_time(g, t) for g in model.gravity)


def loads(model: Model, now: Instant) -> list[Any]:
    """Q: weight (global), gyroscopic torque (body frame) and force laws of every body (Terze et al.
    2015, eqs. 42 to 44)."""
    Q: list[Any] = []
    g = gravity(model, now.t)
    for body, x in zip(model.bodies, now.bodies, strict=True):
        w = x[15:18]
        Q += so3.scale(body.mass, g)
        Q += so3.cross(inertia_times(body.inertia, w), w)
    return [q + x for q, x in zip(Q, applied_forces.generalized(model, now), strict=True)] if model.forces else Q


def accelerations(
    model: Model,
    structure: kkt.Structure,
    now: Instant,
    mask: Sequence[Number] | None = None,
    expected: Sequence[Number] | None = None,
    baumgarte: float | None = None,
) -> kkt.Solution:
    """v' (global) and w' (body frame) of every body, and the multipliers (Terze et al. 2015, eq. 14); mask and
    expected: see `kkt.solve`; baumgarte: see `constraints.required`."""
    C = constraints.jacobian(model, now)
    xi = constraints.required(model, now, baumgarte)
    return kkt.solve(structure, mass_matrix(model), C, loads(model, now), xi, mask, expected)


def energies(model: Model, now: Instant) -> tuple[Any, Any]:
    """Kinetic and potential energy (J)."""
    kinetic: Any = 0.0
    potential: Any = applied_forces.potential(model, now) if model.forces else 0.0
    for body, x in zip(model.bodies, now.bodies, strict=True):
        v, w = x[12:15], x[15:18]
        kinetic = kinetic + 0.5 * (body.mass * so3.dot(v, v) + so3.dot(w, inertia_times(body.inertia, w)))
        potential = potential - body.mass * so3.dot(gravity(model, now.t), x[0:3])
    return kinetic, potential


def power(model: Model, now: Instant, multipliers: Sequence[Number]) -> Any:
    """What changes the energy (W): drivers by lambda.Phi_t or lambda.psi(q, 0, t), forces, and gravity that varies."""
    total: Any = applied_forces.power(model, now) if model.forces else 0.0
    for rate, mu in zip(constraints.time_rate(model, now), multipliers, strict=True):
        if not is_zero(rate):
            total = total + mu * rate
    growth = tuple(lift(g).b for g in gravity(model, Jet(now.t, 1.0)))
    for body, x in zip(model.bodies, now.bodies, strict=True):
        if not all(is_zero(g) for g in growth):
            total = total - body.mass * so3.dot(growth, x[0:3])
    return total
