"""What the flags of a model switch off."""

import copy
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import mujoco

OFF = {  # fields that are 0 then
    "GRAVITY": (),
    "EQUALITY": ("eq_active0",),
    "LIMIT": ("jnt_limited", "tendon_limited"),
    "FRICTIONLOSS": ("dof_frictionloss", "tendon_frictionloss"),
    "SPRING": ("jnt_stiffness", "jnt_stiffnesspoly", "tendon_stiffness", "tendon_stiffnesspoly"),
    "DAMPER": ("dof_damping", "dof_dampingpoly", "tendon_damping", "tendon_dampingpoly", "actuator_damping"),
    "ACTUATION": ("actuator_gainprm", "actuator_biasprm"),
    "CLAMPCTRL": ("actuator_ctrllimited",),
}
WHOLE = {  # flags that stand for others; PASSIVE is one of older models
    "SPRING": "PASSIVE", "DAMPER": "PASSIVE",
    "EQUALITY": "CONSTRAINT", "LIMIT": "CONSTRAINT", "FRICTIONLOSS": "CONSTRAINT", "CONTACT": "CONSTRAINT",
}  # fmt: skip


def with_flags(model: "mujoco.MjModel") -> "mujoco.MjModel":
    """The model, in which that is 0 which its flags switch off."""
    off = [name for name in OFF if is_off(model, name)]
    if not off:
        return model
    found = copy.copy(model)
    for field in (field for name in off for field in OFF[name] if hasattr(found, field)):
        getattr(found, field)[:] = 0
    if "GRAVITY" in off:
        found.opt.gravity = np.zeros(3)
    if {"SPRING", "DAMPER"} <= set(off):  # all that is passive
        found.opt.density = found.opt.viscosity = 0.0
        found.body_gravcomp[:] = 0
    return found


def is_off(model: "mujoco.MjModel", name: str) -> bool:
    """Whether a flag switches something off."""
    import mujoco

    bits = mujoco.mjtDisableBit
    known = (getattr(bits, f"mjDSBL_{x}", 0) for x in (name, WHOLE.get(name)))
    return any(model.opt.disableflags & int(bit) for bit in known)
