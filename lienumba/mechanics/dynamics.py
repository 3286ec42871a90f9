"""The equations of motion: M v' + C^T lambda = Q, C v' = xi (Terze et al. 2015, eqs. 10-15)."""

from typing import Any

from lienumba.groups import so3
from lienumba.mechanics import constraints, kkt
from lienumba.mechanics.model import Body, Model

INERTIA_ELEMENTS = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))


def inertia_times(body: Body, w: Any) -> Any:
    """J w, body frame."""
    xx, yy, zz, xy, xz, yz = body.inertia
    return (
        xx * w[0] + xy * w[1] + xz * w[2],
        xy * w[0] + yy * w[1] + yz * w[2],
        xz * w[0] + yz * w[1] + zz * w[2],
    )


def mass_matrix(model: Model) -> kkt.Entries:
    """The lower entries of M = diag(m I, J) that are not exactly zero."""
    entries: kkt.Entries = {}
    for i, body in enumerate(model.bodies):
        for c in range(3):
            entries[6 * i + c, 6 * i + c] = body.mass
        for (a, b), x in zip(INERTIA_ELEMENTS, body.inertia, strict=True):
            if not (isinstance(x, float) and x == 0.0):
                entries[6 * i + 3 + max(a, b), 6 * i + 3 + min(a, b)] = x
    return entries


def forces(model: Model, state: tuple[Any, ...]) -> list[Any]:
    """Q: weight (global) and gyroscopic torque (body frame) of every body."""
    Q: list[Any] = []
    for body, x in zip(model.bodies, state, strict=True):
        w = x[15:18]
        Q += so3.scale(body.mass, model.gravity)
        Q += so3.cross(inertia_times(body, w), w)
    return Q


def accelerations(model: Model, structure: kkt.Structure, state: tuple[Any, ...]) -> kkt.Solution:
    """v' (global) and w' (body frame) of every body, and the multipliers; `state`: an element of S per body."""
    C = constraints.jacobian(model, state)
    _, bias = constraints.rate_and_bias(model, state)
    return kkt.solve(structure, mass_matrix(model), C, forces(model, state), [-x for x in bias])


def energies(model: Model, state: tuple[Any, ...]) -> tuple[Any, Any]:
    """Kinetic and potential energy (J)."""
    kinetic: Any = 0.0
    potential: Any = 0.0
    for body, x in zip(model.bodies, state, strict=True):
        v, w = x[12:15], x[15:18]
        kinetic = kinetic + 0.5 * (body.mass * so3.dot(v, v) + so3.dot(w, inertia_times(body, w)))
        potential = potential - body.mass * so3.dot(model.gravity, x[0:3])
    return kinetic, potential
