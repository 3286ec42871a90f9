"""The position projection as the paper prints it (Terze et al. 2015, eqs. 21, 22), in the R^12 of every body:

    min |r - r^|^2 + |R - R^|_F^2   subject to   Phi(r, R) = 0,  R R^T = I,

the residuals and the orthogonality both linearised where the iteration stands, on matrices R that are no rotations yet.
That is a KKT system of 12 k + 6 k + m unknowns. Of each body, nine elements and six multipliers leave it in closed
form: what fulfils the linearised R R^T = I is

    R+ = (R + R^-T) / 2 + R hat(w),   w in R^3,

for (R hat(w)) R^T is skew at any R, and a step of Newton towards the nearest rotation does the rest. So 6 k + m
unknowns are left, with the C of everything else, and in the place of 2 I the metric of R hat(w), tr(R^T R) I - R^T R.
det R stays positive: det(R (S + hat(w))) = det R (det S + w^T S w) with S = (I + (R^T R)^-1) / 2.
"""

from collections.abc import Sequence
from typing import Any

from lienumba.groups import so3
from lienumba.mechanics.mechanism.kinematics import Instant
from lienumba.mechanics.mechanism.model import Model
from lienumba.mechanics.system import constraints, kkt, projection
from lienumba.mechanics.tolerances import ROUNDOFF
from lienumba.numerics.number import Matrix, Number, Vector
from lienumba.numerics.operations import absolute, maximum, where

Bodies = tuple[Any, ...]


def correction(
    model: Model, structure: kkt.Structure, now: Instant, hat: Bodies, mask: Sequence[Number]
) -> kkt.Solution:
    """Terze et al. 2015, eqs. 21, 22. x: the step from `now`, 6 k (shift of r; w); mu: of Phi, as a whole."""
    C = constraints.jacobian(model, now)
    mask = projection.position_mask(model, mask)
    return kkt.solve(structure, _metric(now.bodies), C, _pull(now.bodies, hat), _gap(model, now), mask)


def chord_correction(
    model: Model, by: kkt.Eliminated, now: Instant, hat: Bodies, mu: Sequence[Number], mask: Sequence[Number]
) -> kkt.Solution:
    """The same by an earlier elimination, from what is missing at `now` with the multipliers mu."""
    f = projection.without_reactions(model, now, _pull(now.bodies, hat), mu)
    step = by.solve(f, projection.masked(_gap(model, now), projection.position_mask(model, mask)))
    return kkt.Solution(step.x, [a + b for a, b in zip(mu, step.mu, strict=True)], by)


def placed(bodies: Bodies, x: Sequence[Number]) -> Bodies:
    """The state with its positions moved by the step x."""
    return tuple(
        so3.add(body[0:3], tuple(x[6 * i : 6 * i + 3]))
        + _turned(body[3:12], tuple(x[6 * i + 3 : 6 * i + 6]))
        + body[12:18]
        for i, body in enumerate(bodies)
    )


def violation(bodies: Bodies) -> Any:
    """The largest element of R R^T - I that is more than rounding; 0 if there is none."""
    worst: Any = 0.0
    for body in bodies:
        rows = (body[3:6], body[6:9], body[9:12])
        for i in range(3):
            for j in range(i + 1):
                missed = absolute(so3.dot(rows[i], rows[j]) - (1.0 if i == j else 0.0))
                worst = maximum(worst, where(missed <= ROUNDOFF, 0.0, missed))
    return worst


def _turned(R: Matrix, w: Vector) -> Any:
    """(R + R^-T) / 2 + R hat(w)."""
    rows = zip(R, _inverse_transpose(R), so3.multiply(R, so3.hat(w)), strict=True)
    return tuple(0.5 * (a + b) + turn for a, b, turn in rows)


def _inverse_transpose(R: Matrix) -> Any:
    """R^-T: its rows are the cross products of the rows of R, by det R."""
    x, y, z = R[0:3], R[3:6], R[6:9]
    rows = (so3.cross(y, z), so3.cross(z, x), so3.cross(x, y))
    inverse = 1.0 / so3.dot(x, rows[0])
    return tuple(inverse * c for row in rows for c in row)


def _metric(bodies: Bodies) -> kkt.Entries:
    """|x_r|^2 + |R hat(w)|_F^2, its lower triangle."""
    W: kkt.Entries = {}
    for i, body in enumerate(bodies):
        G = so3.multiply(so3.transpose(body[3:12]), body[3:12])
        trace = G[0] + G[4] + G[8]
        for a in range(3):
            W[6 * i + a, 6 * i + a] = 1.0
            for b in range(a + 1):
                W[6 * i + 3 + a, 6 * i + 3 + b] = trace - G[4 * a] if a == b else -G[3 * a + b]
    return W


def _pull(bodies: Bodies, hat: Bodies) -> list[Any]:
    """The negative slope of half the squared distance from q^, along the 6 k steps; that of R is 2 vee(R^T R^), to
    which R and R^-T, being symmetric in R^T R, give nothing."""
    f: list[Any] = []
    for body, there in zip(bodies, hat, strict=True):
        f += so3.subtract(there[0:3], body[0:3])
        f += so3.scale(2.0, so3.vee(so3.multiply(so3.transpose(body[3:12]), there[3:12])))
    return f


def _gap(model: Model, now: Instant) -> list[Any]:
    """What Phi still lacks once R has gone to (R + R^-T) / 2."""
    drifts = [
        tuple(0.5 * (b - a) for a, b in zip(body[3:12], _inverse_transpose(body[3:12]), strict=True))
        for body in now.bodies
    ]
    along = constraints.derivative(model, now, drifts)
    return [-(phi + drift) for phi, drift in zip(constraints.residual(model, now), along, strict=True)]
