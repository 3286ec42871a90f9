"""The satellite's equations as the paper has them, (33)-(44) and appendix B, transcribed into dense NumPy.

The paper prints the blocks of the fixed point (B.5, B.6) and of the spherical joint (40, 41). Those of the revolute and
the prismatic joint "follow accordingly"; here they are differentiated twice by hand as (36)-(38) are, from:
x and y of the first body are perpendicular to the axis z of the second,  (R1 a).(R2 b) = 0; the same for y and the
second body's x (the slider does not turn); the slider's point lies on the line,  (R1 a).(r2 + R2 q - r1 - R1 p) = 0.
Each block: C (rows, 6 per body) and xi (rows,), with C vdot = xi.
"""

import numpy as np

from tests.facade import Model
from tests.oracles.paper.satellite import F_PJ, L_RJ, L_SJ, Arrays
from tests.oracles.reference.naive import hat

Block = tuple[np.ndarray, np.ndarray]
I3, O3 = np.eye(3), np.zeros((3, 3))


def fixed_point(R1, w1, p) -> Block:
    """(B.5), (B.6)."""
    return np.hstack([-I3, R1 @ hat(p)]), R1 @ hat(w1) @ hat(w1) @ p


def spherical(R1, w1, p, R2, w2, q) -> Block:
    """(40), (41)."""
    C = np.hstack([I3, -R1 @ hat(p), -I3, R2 @ hat(q)])
    return C, R2 @ hat(w2) @ hat(w2) @ q - R1 @ hat(w1) @ hat(w1) @ p


def perpendicular(R1, w1, a, R2, w2, b) -> Block:
    """(R1 a).(R2 b) = 0."""
    A, B = R1 @ a, R2 @ b
    dA, dB = R1 @ hat(w1) @ a, R2 @ hat(w2) @ b
    ddA, ddB = R1 @ hat(w1) @ hat(w1) @ a, R2 @ hat(w2) @ hat(w2) @ b
    o = np.zeros(3)
    C = np.concatenate([o, -B @ R1 @ hat(a), o, -A @ R2 @ hat(b)])
    return C[None], -np.array([ddA @ B + 2.0 * dA @ dB + A @ ddB])


def on_line(first, second, a, p, q) -> Block:
    """(R1 a).(r2 + R2 q - r1 - R1 p) = 0; first, second: r, R, v, w of the bodies."""
    (r1, R1, v1, w1), (r2, R2, v2, w2) = first, second
    A, dA, ddA = R1 @ a, R1 @ hat(w1) @ a, R1 @ hat(w1) @ hat(w1) @ a
    d = r2 + R2 @ q - r1 - R1 @ p
    rate = v2 + R2 @ hat(w2) @ q - v1 - R1 @ hat(w1) @ p
    bend = R2 @ hat(w2) @ hat(w2) @ q - R1 @ hat(w1) @ hat(w1) @ p
    C = np.concatenate([-A, -d @ R1 @ hat(a) + A @ R1 @ hat(p), A, -A @ R2 @ hat(q)])
    return C[None], -np.array([ddA @ d + 2.0 * dA @ rate + A @ bend])


def prescribed(R1, growth) -> Block:
    """RH: R1 w1 - w_g1 = 0 on the velocity level; growth: dw_g1/dt. The term R1 w1~ w1 is zero."""
    return np.hstack([O3, R1]), np.array(growth, float)


def _stack(*blocks: Block) -> Block:
    return np.concatenate([C for C, _ in blocks]), np.concatenate([xi for _, xi in blocks])


def constraint_matrix(m: Model, state: Arrays, growth=(0.0, 0.0, 0.0)) -> Block:
    """(34) and (35): C (19, 24) and xi (19,); m gives points and frames alone."""
    r, R, v, w = state
    body = list(zip(r, R, v, w, strict=True))
    (_, fp), sj, rj, pj = ([np.array(p) for p in joint.points] for joint in m.joints)
    (x1, y1, _), (_, _, z2) = np.array(m.joints[2].frames)
    (X1, Y1, _), (X2, _, Z2) = np.array(m.joints[3].frames)
    FP = fixed_point(R[0], w[0], fp)
    SJ = spherical(R[0], w[0], sj[0], R[1], w[1], sj[1])
    elbow, slide = (R[1], w[1]), (R[2], w[2])
    RJ = _stack(
        spherical(*elbow, rj[0], R[2], w[2], rj[1]),
        perpendicular(*elbow, x1, R[2], w[2], z2),
        perpendicular(*elbow, y1, R[2], w[2], z2),
    )
    PJ = _stack(
        on_line(body[2], body[3], X1, *pj),
        on_line(body[2], body[3], Y1, *pj),
        perpendicular(*slide, X1, R[3], w[3], Z2),
        perpendicular(*slide, Y1, R[3], w[3], Z2),
        perpendicular(*slide, Y1, R[3], w[3], X2),
    )
    RH = prescribed(R[0], growth)
    C, first = np.zeros((19, 24)), 0
    for (block, _), start in zip((FP, SJ, RJ, PJ, RH), (0, 0, 6, 12, 0), strict=True):
        C[first : first + len(block), start : start + block.shape[1]] = block
        first += len(block)
    return C, np.concatenate([xi for _, xi in (FP, SJ, RJ, PJ, RH)])


def mass_matrix(m: Model) -> np.ndarray:
    """(33)."""
    diagonal = [x for body in m.bodies for x in (*[body.mass] * 3, *body.inertia[:3])]
    return np.diag(diagonal)


def forces(m: Model, state: Arrays) -> np.ndarray:
    """(42)-(44): Q (24,)."""
    _, R, _, w = state
    o = np.zeros(3)
    J = [np.diag(body.inertia[:3]) for body in m.bodies]
    nonlinear = np.concatenate([part for i in range(4) for part in (o, -hat(w[i]) @ J[i] @ w[i])])
    external = np.concatenate([o, -L_SJ, o, L_SJ - L_RJ, o, L_RJ, R[3] @ F_PJ, o])
    return external + nonlinear
