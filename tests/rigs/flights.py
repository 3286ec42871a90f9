"""A body that flies freely: its motion is known, and linear in its velocity and in gravity."""

from typing import Any

import numpy as np

import lienumba

VELOCITY = np.array([1.0, 2.0, 8.0])
GRAVITY = -9.5
FLOOR = -1.0


def flight(**vary: dict[str, Any]) -> lienumba.System:
    """It falls below a floor at some time; vary: distributions by the last part of paths."""
    system = lienumba.System("A flight")
    system.gravity = [0, 0, GRAVITY]
    still = {"position": [0, 0, 0], "rotation": [1, 0, 0, 0], "angular_velocity": [0, 0, 0]}
    system.body("b", mass=1.0, inertia=[1, 1, 1], velocity=VELOCITY.tolist(), **still)
    system.quantity("p", "point", body="b").quantity("far", "expression", value="p.x + 2*p.y", units="m")
    system.quantity("bent", "expression", value="p.x*p.x - p.y")
    system.measure("top", "max(p.z)")
    system.event("fallen", when=f"p.z < {FLOOR}", action="record")
    for path, distribution in vary.items():
        system.vary(path, **distribution)
    system.integrator(method="rk4", step=0.125, end_time=2.0)
    system.output(every=0.5, variables=["p", "far", "bent"])
    return system


def height(t: Any, speed: float = 8.0, gravity: float = GRAVITY) -> Any:
    """p.z at these times (s)."""
    return speed * t + 0.5 * gravity * t**2


def fall(speed: float = 8.0, gravity: float = GRAVITY) -> float:
    """When it falls below the floor (s)."""
    return float((speed + np.sqrt(speed**2 + 2.0 * gravity * FLOOR)) / -gravity)
