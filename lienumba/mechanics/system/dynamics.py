"""The equations of motion: M v' + C^T lambda = Q, C v' = xi (Terze et al. 2015, eqs. 10-15), energy and power.

The paper's lambda is `mu`, `multipliers` or `Solution.mu` in the code.
"""

from collections.abc import Sequence
from typing import Any

from lienumba.groups import so3
from lienumba.mechanics.mechanism.kinematics import Instant, inertia_times
from lienumba.mechanics.mechanism.massless import with_lent_masses
from lienumba.mechanics.mechanism.model import Body, Model, at_time
from lienumba.mechanics.system import applied_forces, constraints, kkt, rotors
from lienumba.mechanics.system.body_axes import GLOBAL, Axes
from lienumba.numerics.jets import Jet, lift
from lienumba.numerics.number import Number, Vector
from lienumba.numerics.operations import is_zero

INERTIA_ELEMENTS = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))


def mass_matrix(model: Model, now: Instant) -> kkt.Entries:
    """The lower entries of M that are not exactly zero: diag(m I, J) (Terze et al. 2015, eqs. 30, 33), and what rotors
    give."""
    entries = body_masses(model.bodies)
    for key, x in rotors.mass(model, now).items():
        entries[key] = entries.get(key, 0.0) + x
    return entries


def body_masses(bodies: Sequence[Body]) -> kkt.Entries:
    """The lower entries of the mass matrix of bodies, without rotors."""
    entries: kkt.Entries = {}
    for i, body in enumerate(bodies):
        for c in range(3):
            entries[6 * i + c, 6 * i + c] = body.mass
        for (a, b), x in zip(INERTIA_ELEMENTS, body.inertia, strict=True):
            if not is_zero(x):
                entries[6 * i + 3 + max(a, b), 6 * i + 3 + min(a, b)] = x
    return entries


def shapes(model: Model) -> kkt.Entries:
    """diag(I, I 6 tr(J)/m): the metric of shifts and turns by the size of each body, whatever its mass: for a slender
    bar, its length squared. A massless body counts as large as another."""
    entries: kkt.Entries = {}
    for i, body in enumerate(shaped(model)):
        entries |= {(6 * i + c, 6 * i + c): body.mass if c < 3 else body.inertia[0] for c in range(6)}
    return entries


def shaped(model: Model) -> list[Body]:
    """Bodies that have this metric as their mass matrix."""
    found = []
    for body in with_lent_masses(model).bodies:
        square = 6.0 * (body.inertia[0] + body.inertia[1] + body.inertia[2]) / body.mass
        found.append(Body(body.name, 1.0, (square, square, square, 0.0, 0.0, 0.0)))
    return found


def gravity(model: Model, t: Number) -> Any:
    """The three components of gravity (m/s^2, global) at time t."""
    return tuple(at_time(g, t) for g in model.gravity)


def gyroscopic(inertia: Vector, w: Vector) -> Any:
    """The torque J w x w (N m) about the point about which J is given, body frame."""
    return so3.cross(inertia_times(inertia, w), w)


def loads(model: Model, now: Instant) -> list[Any]:
    """Q: weight (global), gyroscopic torque (body frame) and force laws of every body (Terze et al.
    2015, eqs. 42 to 44), and what rotors give."""
    Q: list[Any] = []
    g = gravity(model, now.t)
    for body, x in zip(model.bodies, now.bodies, strict=True):
        w = x[15:18]
        Q += so3.scale(body.mass, g)
        Q += gyroscopic(body.inertia, w)
    for i, x in rotors.loads(model, now).items():
        Q[i] = Q[i] + x
    return [q + x for q, x in zip(Q, applied_forces.generalized(model, now), strict=True)] if model.forces else Q


def accelerations(
    model: Model,
    structure: kkt.Structure,
    now: Instant,
    mask: Sequence[Number] | None = None,
    expected: Sequence[Number] | None = None,
    baumgarte: float | None = None,
    axes: Axes = GLOBAL,
) -> kkt.Solution:
    """v' (global) and w' (body frame) of every body, and the multipliers (Terze et al. 2015, eq. 14); mask and
    expected: see `kkt.solve`; baumgarte: see `constraints.required`; axes: of the equations, and of the multipliers."""
    C = constraints.jacobian(model, now, axes)
    xi = constraints.required(model, now, baumgarte, axes)
    Q = axes.into(now, loads(model, now))
    near = None if expected is None else axes.into(now, expected)
    coupling = constraints.friction_coupling(model, now)
    solution = kkt.solve(structure, mass_matrix(model, now), C, Q, xi, mask, near, coupling)
    return solution._replace(x=axes.out_of(now, solution.x))


def missing(
    model: Model,
    structure: kkt.Structure,
    now: Instant,
    mask: Sequence[Number],
    accelerations: Sequence[Number],
    multipliers: Sequence[Number],
    baumgarte: float | None = None,
) -> list[Any]:
    """Q - M v' - C^T lambda along all velocities, and xi - C v' of every row of C, for any accelerations (6 k) and
    multipliers of all rows in use: of what slides, those of normals alone."""
    C, weights = constraints.jacobian(model, now), structure.weights(mask, constraints.friction_coupling(model, now))
    C = {key: weights[key[0]] * x for key, x in C.items() if not is_zero(weights[key[0]])}
    xi, mu = constraints.required(model, now, baumgarte), reactions(model, structure, now, mask, multipliers)
    along, rows = kkt.rest(mass_matrix(model, now), C, loads(model, now), xi, accelerations, mu)
    return [*along, *(m * x for m, x in zip(mask, rows, strict=True))]


def reactions(
    model: Model, structure: kkt.Structure, now: Instant, mask: Sequence[Number], multipliers: Sequence[Number]
) -> list[Any]:
    """See `kkt.reactions`."""
    C, coupling = constraints.jacobian(model, now), constraints.friction_coupling(model, now)
    return kkt.reactions(structure, mass_matrix(model, now), C, mask, coupling, multipliers)


def border(
    model: Model,
    structure: kkt.Structure,
    now: Instant,
    mask: Sequence[Number],
    expected: Sequence[Number] | None = None,
    baumgarte: float | None = None,
) -> tuple[list[list[Any]], list[Any]]:
    """S and b of all rows that are switched: with reactions Lambda = -lambda their rates change by S Lambda + b. See
    `accelerations`."""
    C, xi = constraints.jacobian(model, now), constraints.required(model, now, baumgarte)
    return kkt.border(
        structure.bordered(), mass_matrix(model, now), C, loads(model, now), xi, unswitched(structure, mask), expected
    )


def kicked(
    model: Model, structure: kkt.Structure, now: Instant, mask: Sequence[Number], impulses: Sequence[Number]
) -> kkt.Solution:
    """The change of all velocities by impulses along the switched rows, with which the permanent rows keep their rates:
    M x + C^T mu = C_s^T impulses."""
    C, f = constraints.jacobian(model, now), [0.0] * (6 * len(model.bodies))
    for (row, column), x in C.items():
        if row >= structure.switched:
            f[column] = f[column] + x * impulses[row - structure.switched]
    g = [0.0] * structure.rows
    return kkt.solve(structure, mass_matrix(model, now), C, f, g, unswitched(structure, mask))


def unswitched(structure: kkt.Structure, mask: Sequence[Number]) -> list[Any]:
    """The mask without any row that is switched."""
    return [*mask[: structure.switched], *[0.0] * (structure.rows - structure.switched)]


def energies(model: Model, now: Instant) -> tuple[Any, Any]:
    """Kinetic and potential energy (J)."""
    kinetic = rotors.energy(model, now)
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
    total = total + constraints.sliding_power(model, now, multipliers)
    growth = tuple(lift(g).b for g in gravity(model, Jet(now.t, 1.0)))
    for body, x in zip(model.bodies, now.bodies, strict=True):
        if not all(is_zero(g) for g in growth):
            total = total - body.mass * so3.dot(growth, x[0:3])
    return total
