"""A wheel on a hinge, without gravity: its angle by a torque is a double integral."""

from typing import Any

from lienumba import System

INERTIA = 0.1


def wheel(step: float = 1e-3, end: float = 2.0) -> System:
    """At rest; a quantity hinge_at is what its hinge does."""
    system = System("A wheel on a hinge")
    system.gravity = [0, 0, 0]
    system.body("wheel", mass=1.0, inertia=[INERTIA] * 3, position=[0, 0, 0], rotation=[1, 0, 0, 0])
    system.joint("hinge", "revolute", ["ground", "wheel"], at=[0, 0, 0], axis=[0, 1, 0])
    system.quantity("hinge_at", "joint", joint="hinge")
    return system.integrator(step=step, end_time=end).output(every=0.05)


def at_hinge(torque: Any, **more: float) -> System:
    """With this torque on the hinge."""
    return wheel(**more).force("motor", type="actuator", joint="hinge", value=torque)
