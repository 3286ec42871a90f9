"""Accelerations of a URDF by Pinocchio, which reads the file itself, in the coordinates of MuJoCo's model of it."""

from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from bench.importing.reference import Reference, States


def aba(path: Path, reference: Reference, states: States) -> np.ndarray:
    """q'' (n, nv) without motors. Damping, rotors and springs, which Pinocchio's aba leaves out, are MuJoCo's."""
    import pinocchio

    m = reference.model
    robot: Any = pinocchio.buildModelFromUrdf(str(path))
    names = [mujoco.mj_id2name(m, mujoco.mjtObj.mjOBJ_JOINT, j) for j in range(m.njnt)]
    if len(robot.names) - 1 != m.njnt or {*robot.names[1:]} != {*names}:
        raise ValueError("Pinocchio reads other joints than MuJoCo")
    own = [robot.getJointId(name) for name in names]
    at = np.array([robot.joints[j].idx_v for j in own])
    robot.armature = np.zeros(robot.nv)
    robot.armature[at] = m.dof_armature
    robot.gravity.linear = m.opt.gravity
    data, found = robot.createData(), np.empty_like(states.v)
    for n, (q, v, ctrl) in enumerate(zip(states.q, states.v, states.ctrl, strict=True)):
        d = reference.put(q, v, ctrl)
        tau, rates = np.zeros(robot.nv), np.zeros(robot.nv)
        tau[at], rates[at] = d.qfrc_passive + d.qfrc_actuator, v
        found[n] = pinocchio.aba(robot, data, _places(robot, own, q), rates, tau)[at]
    return found


def _places(robot: Any, own: list[int], q: np.ndarray) -> np.ndarray:
    """Its coordinates: of joints without limits cosine and sine."""
    found = np.zeros(robot.nq)
    for j, x in zip(own, q, strict=True):
        joint = robot.joints[j]
        found[joint.idx_q : joint.idx_q + joint.nq] = [x] if joint.nq == 1 else [np.cos(x), np.sin(x)]
    return found
