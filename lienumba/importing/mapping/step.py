"""A step with which explicit methods are stable: damping and stiffness of joints and servos set it."""

from typing import TYPE_CHECKING

import numpy as np

from lienumba.importing.mapping.source import Source

if TYPE_CHECKING:
    import mujoco

DIFFERENCE = 1e-6
STEP_RTOL = 1e-9  # of a step: the roundoff of an eigenvalue


def stable_step(source: Source) -> float:
    """A step in s: 1, 2 or 5 of a power of ten, at most the model's own and 1 / |fastest eigenvalue| at the start."""
    longest = min(float(source.model.opt.timestep), 1.0 / max(_fastest(source), 1e-9))
    decade = int(np.floor(np.log10(longest)))
    rounded = (float(f"{x}e{decade + n}") for n in (-1, 0, 1) for x in (1, 2, 5))  # log10 may be rounded either way
    return max(x for x in rounded if x <= longest * (1.0 + STEP_RTOL))


def _fastest(source: Source) -> float:
    """The largest eigenvalue of the linear motion about the start, in 1/s, without contacts, limits and friction."""
    import mujoco

    m, d = source.model, mujoco.MjData(source.model)
    d.qpos[:], d.qvel[:] = source.qpos, source.qvel
    mujoco.mj_forward(m, d)
    n = m.nv
    if n == 0:
        return 0.0
    M = mass_matrix(m, d)
    base = _passive(m, d)
    K, D = np.zeros((n, n)), np.zeros((n, n))
    q, v = d.qpos.copy(), d.qvel.copy()
    for i in range(n):
        step = np.zeros(n)
        step[i] = DIFFERENCE
        mujoco.mj_integratePos(m, d.qpos, step, 1.0)
        K[:, i] = (_passive(m, d) - base) / DIFFERENCE
        d.qpos[:] = q
        d.qvel[i] += DIFFERENCE
        D[:, i] = (_passive(m, d) - base) / DIFFERENCE
        d.qvel[:] = v
    A = np.block([[np.zeros((n, n)), np.eye(n)], [np.linalg.solve(M, K), np.linalg.solve(M, D)]])
    return float(abs(np.linalg.eigvals(A)).max()) if np.isfinite(A).all() else 0.0


def mass_matrix(m: "mujoco.MjModel", d: "mujoco.MjData") -> np.ndarray:
    """(nv, nv), at what was last evaluated."""
    import mujoco

    M = np.zeros((m.nv, m.nv))
    if hasattr(d, "qM"):
        mujoco.mj_fullM(m, M, d.qM)
    else:
        mujoco.mj_fullM(m, d, M)
    return M


def _passive(m: "mujoco.MjModel", d: "mujoco.MjData") -> np.ndarray:
    """Forces of springs, dampers and actuators (nv,)."""
    import mujoco

    mujoco.mj_fwdPosition(m, d)
    mujoco.mj_fwdVelocity(m, d)
    mujoco.mj_fwdActuation(m, d)
    return np.asarray(d.qfrc_passive + d.qfrc_actuator)
