"""The satellite with a 5-DOF manipulator, section 7.2, as a model; and states that its joints allow.

Bodies: satellite, base rod, slider rod, slider. Joints: FP, SJ, RJ, PJ, and the driver RH, in the order of (34).
"""

from collections.abc import Sequence
from math import pi
from typing import Any

import numpy as np

from lienumba.mechanics.mechanism.model import Driver, Force, Frame
from tests.facade import GROUND, Body, Instant, Joint, Model
from tests.oracles.reference import naive

BODIES = (
    Body("satellite", 1800.0, (1800.0, 1800.0, 900.0, 0.0, 0.0, 0.0)),
    Body("base_rod", 80.0, (15.1125, 15.1125, 0.225, 0.0, 0.0, 0.0)),
    Body("slider_rod", 60.0, (11.3, 11.3, 0.1, 0.0, 0.0, 0.0)),
    Body("slider", 30.0, (0.35, 0.35, 0.8937, 0.0, 0.0, 0.0)),
)
ENDS = (("FP", "spherical", GROUND, 0), ("SJ", "spherical", 0, 1), ("RJ", "revolute", 1, 2), ("PJ", "prismatic", 2, 3))
SPIN = (pi / 60, 0.0, pi / 30)  # w_g1, global frame
L_SJ, L_RJ, F_PJ = np.array([-1.0, -3.0, -0.1]), np.array([0.0, 0.45, 0.0]), np.array([0.0, 0.0, -0.533])

ORIGIN = (0.0, 0.0, 0.0)
X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
ALONG_Y, ALONG_Z = (Z, X, Y), (X, Y, Z)  # frames: the axis is the last
POINTS = (
    (ORIGIN, ORIGIN),
    ((0.0, 0.0, 1.5), (0.0, 0.0, -0.75)),
    ((0.0, 0.0, 0.75), (0.0, 0.0, -0.75)),
    (ORIGIN, ORIGIN),
)
FRAMES = (None, None, (ALONG_Y, ALONG_Y), (ALONG_Z, ALONG_Z))

Arrays = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]  # r (4,3), R (4,3,3), v (4,3), w (4,3)


def satellite(points: Sequence[Any] = POINTS, frames: Sequence[Any] = FRAMES, spin: Sequence[Any] = SPIN) -> Model:
    """The paper's satellite, or one with other joint points and frames."""
    return Model(
        gravity=ORIGIN,
        bodies=BODIES,
        joints=tuple(
            Joint(name, kind, (a, b), p, f) for (name, kind, a, b), p, f in zip(ENDS, points, frames, strict=True)
        ),
        drivers=(Driver("RH", "angular_velocity", (0,), tuple(spin), frame="global"),),
        forces=(
            _torque("shoulder_on_satellite", 0, -L_SJ),
            _torque("shoulder_on_base_rod", 1, L_SJ),
            _torque("elbow_on_base_rod", 1, -L_RJ),
            _torque("elbow_on_slider_rod", 2, L_RJ),
            Force("slide_on_slider", "force", (3,), (ORIGIN,), frame="body", numbers={"value": tuple(F_PJ.tolist())}),
        ),
    )


def _torque(name: str, body: int, value: np.ndarray) -> Force:
    return Force(name, "torque", (body,), frame="body", numbers={"value": tuple(value.tolist())})


def skew_satellite(seed: int) -> Model:
    """One whose joint points and axes lie anywhere, so that no entry of C vanishes by chance."""
    rng = np.random.default_rng(seed)
    points = [(_vector(rng), _vector(rng)) for _ in ENDS]
    frames = [None, None, (_frame(rng), _frame(rng)), (_frame(rng), _frame(rng))]
    return satellite(points, frames)


def _vector(rng: np.random.Generator) -> tuple[float, ...]:
    return tuple(rng.standard_normal(3).tolist())


def _frame(rng: np.random.Generator) -> Frame:
    x, y, z = naive.exp(1.5 * rng.standard_normal(3)).T.tolist()
    return (tuple(x), tuple(y), tuple(z))


def anywhere(seed: int) -> Arrays:
    """A state that fulfils none of the constraints."""
    rng = np.random.default_rng(seed)
    R = np.array([naive.exp(1.5 * rng.standard_normal(3)) for _ in BODIES])
    return 2.0 * rng.standard_normal((4, 3)), R, rng.standard_normal((4, 3)), rng.standard_normal((4, 3))


def on_the_joints(m: Model, seed: int) -> Arrays:
    """A state that fulfils all of them."""
    rng = np.random.default_rng(seed)
    R1, R2 = (naive.exp(1.5 * rng.standard_normal(3)) for _ in range(2))
    angle, displacement = rng.standard_normal(2)
    r, R = placed(m, R1, R2, angle, displacement)
    v, w = moving(m, r, R, np.array(SPIN), rng.standard_normal(5))
    return r, R, v, w


def placed(m: Model, R1: np.ndarray, R2: np.ndarray, angle: float, displacement: float) -> tuple[np.ndarray, ...]:
    """r, R of all bodies from the satellite's and the base rod's rotations and the two joint coordinates."""
    points = [[np.array(p) for p in joint.points] for joint in m.joints]
    (elbow1, elbow2), (slide1, slide2) = ([np.array(f).T for f in joint.frames] for joint in m.joints[2:])
    R3 = R2 @ elbow1 @ naive.exp(np.array([0.0, 0.0, angle])) @ elbow2.T
    R4 = R3 @ slide1 @ slide2.T
    r1 = points[0][0] - R1 @ points[0][1]
    r2 = r1 + R1 @ points[1][0] - R2 @ points[1][1]
    r3 = r2 + R2 @ points[2][0] - R3 @ points[2][1]
    r4 = r3 + R3 @ (points[3][0] + displacement * slide1[:, 2]) - R4 @ points[3][1]
    return np.array([r1, r2, r3, r4]), np.array([R1, R2, R3, R4])


def moving(m: Model, r: np.ndarray, R: np.ndarray, spin: np.ndarray, freedoms: np.ndarray) -> tuple[np.ndarray, ...]:
    """v, w of all bodies; freedoms: the base rod's w, the elbow's rate, the slide's speed. Linear in spin, freedoms."""
    W1, W2 = spin, R[1] @ freedoms[0:3]  # global frame
    W3 = W2 + freedoms[3] * R[1] @ m.joints[2].frames[0][2]
    W4 = W3
    shoulder, elbow = (r[i] + R[i] @ m.joints[j].points[0] for i, j in ((0, 1), (1, 2)))
    v1 = np.cross(W1, r[0] - m.joints[0].points[0])
    v2 = v1 + np.cross(W1, shoulder - r[0]) + np.cross(W2, r[1] - shoulder)
    v3 = v2 + np.cross(W2, elbow - r[1]) + np.cross(W3, r[2] - elbow)
    v4 = v3 + np.cross(W3, r[3] - r[2]) + freedoms[4] * R[2] @ m.joints[3].frames[0][2]
    W = np.array([W1, W2, W3, W4])
    return np.array([v1, v2, v3, v4]), np.einsum("bji,bj->bi", R, W)


def instant(state: Arrays, t: float = 0.0) -> Instant:
    r, R, v, w = state
    flat = np.concatenate([r, R.reshape(-1, 9), v, w], axis=1)
    return Instant(tuple(tuple(body) for body in flat.tolist()), t)
