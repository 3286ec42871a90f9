"""What the paper measures, from arrays over time. Knows nothing of lienumba.

r, v, w (times, 3), R (times, 3, 3). Sums are written out, so that no library decides about the last digits.
"""

from typing import Any

import numpy as np

Array = np.ndarray
ARM = (0.0, 1.0, 0.0)  # r_b of the heavy top, (25)
SHOULDER = ((0.0, 0.0, 1.5), (0.0, 0.0, -0.75))  # r_b1, r_b2 of the satellite's spherical joint, (36)


def rotated(R: Array, a: Any) -> Array:
    """R a."""
    a = np.broadcast_to(np.asarray(a, float), (len(R), 3))
    return R[:, :, 0] * a[:, :1] + R[:, :, 1] * a[:, 1:2] + R[:, :, 2] * a[:, 2:]


def cross(a: Any, b: Array) -> Array:
    """a x b."""
    a = np.broadcast_to(np.asarray(a, float), b.shape)
    return np.stack([a[:, i - 2] * b[:, i - 1] - a[:, i - 1] * b[:, i - 2] for i in range(3)], axis=1)


def norm(a: Array) -> Array:
    return np.sqrt(a[:, 0] ** 2 + a[:, 1] ** 2 + a[:, 2] ** 2)


def relative(found: Array, wanted: Array) -> Array:
    """(31)."""
    return norm(found - wanted) / norm(wanted)


def top_positions(r: Array, R: Array) -> Array:
    """(31) with r and R r_b."""
    return relative(r, rotated(R, ARM))


def top_velocities(R: Array, v: Array, w: Array) -> Array:
    """(31) with -v and R r_b~ w."""
    return relative(-v, rotated(R, cross(ARM, w)))


def shoulder_positions(r2: Array, R1: Array, R2: Array) -> Array:
    """(31) with r_2 and R_1 r_b1 - R_2 r_b2."""
    return relative(r2, rotated(R1, SHOULDER[0]) - rotated(R2, SHOULDER[1]))


def shoulder_velocities(v2: Array, R1: Array, w1: Array, R2: Array, w2: Array) -> Array:
    """(31) with -v_2 and R_1 r_b1~ w_1 - R_2 r_b2~ w_2."""
    return relative(-v2, rotated(R1, cross(SHOULDER[0], w1)) - rotated(R2, cross(SHOULDER[1], w2)))


def gram(R: Array) -> Array:
    """R R^T."""
    return np.stack([rotated(R, R[:, i]) for i in range(3)], axis=2)


def determinant(R: Array) -> Array:
    x, y, z = (R[:, i] for i in range(3))
    yz = cross(y, z)
    return x[:, 0] * yz[:, 0] + x[:, 1] * yz[:, 1] + x[:, 2] * yz[:, 2]


def rotation_vector(R: Array) -> Array:
    """Psi with exp(Psi) = R and |Psi| <= pi: twice the arcus tangent of the quaternion's vector part by its scalar."""
    sine = 0.5 * np.stack([R[:, 2, 1] - R[:, 1, 2], R[:, 0, 2] - R[:, 2, 0], R[:, 1, 0] - R[:, 0, 1]], axis=1)
    cosine = 0.5 * (R[:, 0, 0] + R[:, 1, 1] + R[:, 2, 2] - 1.0)
    length = norm(sine)
    angle = np.arctan2(length, cosine)
    return sine * (angle / np.where(length > 0.0, length, 1.0))[:, None]


def tait_bryan(R: Array) -> tuple[Array, Array, Array]:
    """phi, theta, psi with R = R_z(psi) R_y(theta) R_x(phi), the successive rotations 3-2-1."""
    phi = np.arctan2(R[:, 2, 1], R[:, 2, 2])
    theta = np.arctan2(-R[:, 2, 0], np.hypot(R[:, 2, 1], R[:, 2, 2]))
    return phi, theta, np.arctan2(R[:, 1, 0], R[:, 0, 0])
