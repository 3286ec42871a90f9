"""What follows from the residuals: Phi, its rate, the Jacobian C and the bias of its second derivative.

A residual is run on jets along the motion  r(t), R(t)  with  r' = v, R' = R hat(w). Unit velocities give the columns
of C; the motion with frozen velocities gives the rate C v and the bias, so that  C v' = xi = -bias.
"""

from typing import Any

from lienumba.compiler.jets import Jet, lift
from lienumba.groups import so3
from lienumba.mechanics.joints import JOINT_TYPES, Placement, rows_of
from lienumba.mechanics.model import GROUND, Joint, Model
from lienumba.operations import absolute, maximum

Body = tuple[Any, ...]  # 18 numbers: an element of S
AT_ORIGIN: Placement = ((0.0, 0.0, 0.0), so3.IDENTITY)
UNIT = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
AT_REST = (0.0, 0.0, 0.0)


def placement(bodies: tuple[Body, ...], index: int) -> Placement:
    """r and R of a body; the ground is at the origin."""
    return AT_ORIGIN if index == GROUND else (bodies[index][0:3], bodies[index][3:12])


def _times_hat(R: Any, w: Any) -> Any:
    """R hat(w): each row crossed with w."""
    return so3.cross(R[0:3], w) + so3.cross(R[3:6], w) + so3.cross(R[6:9], w)


def _moving(place: Placement, v: Any, w: Any, order: int) -> Placement:
    """The placement as jets up to first or second order, moving with constant v (global) and w (body frame)."""
    r, R = place
    first = _times_hat(R, w)
    second = _times_hat(first, w) if order == 2 else (0.0,) * 9
    return (
        tuple(Jet(x, dx) for x, dx in zip(r, v, strict=True)),
        tuple(Jet(x, dx, ddx) for x, dx, ddx in zip(R, first, second, strict=True)),
    )


def residual(model: Model, bodies: tuple[Body, ...]) -> list[Any]:
    """Phi (m), every row of every joint."""
    rows: list[Any] = []
    for joint in model.joints:
        a, b = (placement(bodies, i) for i in joint.bodies)
        rows += JOINT_TYPES[joint.type].residual(joint, a, b)
    return rows


def rate_and_bias(model: Model, bodies: tuple[Body, ...]) -> tuple[list[Any], list[Any]]:
    """The rate C v (m/s) of every row, and its second derivative where all velocities stay constant."""
    rates: list[Any] = []
    biases: list[Any] = []
    for joint in model.joints:
        moving = []
        for i in joint.bodies:
            v, w = (AT_REST, AT_REST) if i == GROUND else (bodies[i][12:15], bodies[i][15:18])
            moving.append(_moving(placement(bodies, i), v, w, 2))
        for row in JOINT_TYPES[joint.type].residual(joint, *moving):
            rates.append(lift(row).b)
            biases.append(lift(row).c)
    return rates, biases


def columns(joint: Joint, a: Placement, b: Placement, side: int) -> list[list[Any]]:
    """The block of C of one side's body (0 first, 1 second): rows x 6 (v global, w in the body frame)."""
    block: list[list[Any]] = []
    for v, w in [(e, AT_REST) for e in UNIT] + [(AT_REST, e) for e in UNIT]:
        moving = (_moving(a, v, w, 1), b) if side == 0 else (a, _moving(b, v, w, 1))
        block.append([lift(row).b for row in JOINT_TYPES[joint.type].residual(joint, *moving)])
    return [list(row) for row in zip(*block, strict=True)]


def jacobian(model: Model, bodies: tuple[Body, ...]) -> dict[tuple[int, int], Any]:
    """The entries of C that are not exactly zero, by (row, column); body i owns columns 6 i to 6 i + 5."""
    entries: dict[tuple[int, int], Any] = {}
    for joint, rows in zip(model.joints, rows_of(model), strict=True):
        a, b = (placement(bodies, i) for i in joint.bodies)
        for side, i in enumerate(joint.bodies):
            if i == GROUND:
                continue
            for row, values in enumerate(columns(joint, a, b, side)):
                for c, x in enumerate(values):
                    if not (isinstance(x, float) and x == 0.0):
                        entries[rows.start + row, 6 * i + c] = x
    return entries


def loads(model: Model, bodies: tuple[Body, ...], multipliers: list[Any]) -> tuple[list[Any], list[Any]]:
    """Force (N) and torque (N m) of every joint on its second body at its point there, global frame, 3 each."""
    forces: list[Any] = []
    torques: list[Any] = []
    for joint, rows in zip(model.joints, rows_of(model), strict=True):
        a, b = (placement(bodies, i) for i in joint.bodies)
        mu = multipliers[rows]
        load: list[Any] = [0.0] * 6
        for row, m in zip(columns(joint, a, b, 1), mu, strict=True):
            load = [total - x * m for total, x in zip(load, row, strict=True)]
        force = (load[0], load[1], load[2])
        arm = so3.rotate(b[1], joint.points[1])
        torque = so3.rotate(b[1], (load[3], load[4], load[5]))
        forces += force
        torques += so3.subtract(torque, so3.cross(arm, force))
    return forces, torques


def sizes(model: Model, bodies: tuple[Body, ...]) -> tuple[list[Any], list[Any], list[Any]]:
    """For every row of Phi: the size of its joint (m), of its bodies' positions (m), and of its points' speeds (m/s).

    What a violation of the joint compares with, whatever else is in the model.
    """
    reach: list[Any] = []
    far: list[Any] = []
    speed: list[Any] = []
    for joint in model.joints:
        joint_reach: Any = 0.0 if joint.length is None else joint.length
        joint_far: Any = 0.0
        joint_speed: Any = 0.0
        for i, p in zip(joint.bodies, joint.points, strict=True):
            arm = largest(p)
            joint_reach = maximum(joint_reach, arm)
            if i == GROUND:
                continue
            joint_far = maximum(joint_far, largest(bodies[i][0:3]))
            joint_speed = maximum(joint_speed, largest(bodies[i][12:15]))
            joint_speed = maximum(joint_speed, arm * largest(bodies[i][15:18]))
        rows = JOINT_TYPES[joint.type].rows
        reach += [joint_reach] * rows
        far += [joint_far] * rows
        speed += [joint_speed] * rows
    return reach, far, speed


def largest(rows: Any) -> Any:
    """The largest absolute value of finite rows."""
    worst: Any = 0.0
    for row in rows:
        worst = maximum(worst, absolute(row))
    return worst
