"""How far states lie from a reference: in position (m), rotation (rad), velocity (m/s), angular velocity (rad/s)."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import sqrt
from sys import float_info

import numpy as np

from lienumba.numerics.operations import atan2

STATE = ("position", "rotation", "velocity", "angular_velocity")


@dataclass(frozen=True)
class Truth:
    """What is known of the exact motion: by variable, values (runs, times, bodies, ...) and the names of the bodies.
    One run may stand for all."""

    values: "Mapping[str, np.ndarray]"
    bodies: Mapping[str, Sequence[str]]


def errors(states: "Mapping[str, np.ndarray]", truth: Truth, bodies: Sequence[str]) -> dict[str, np.ndarray]:
    """Of each variable that is known, the distance (runs, times) of the body that is farthest off."""
    found = {}
    for name, known in truth.values.items():
        which = [list(bodies).index(body) for body in truth.bodies[name]]
        found[name] = distance(name, states[name][:, :, which], known).max(axis=2)
    return found


def distance(name: str, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """The distance of two vectors (..., 3), or the angle (rad) between two rotations (..., 3, 3)."""
    if name != "rotation":
        return norm(x - y)
    chord = norm(norm(x - y)) / sqrt(8.0)  # |A - B| = sqrt(8) sin(angle/2)
    half = chord.clip(max=1.0)
    angle: np.ndarray = 2.0 * atan2(half, (1.0 - half * half) ** 0.5)
    return angle


def norm(x: np.ndarray) -> np.ndarray:
    """The length of vectors (..., 3), in an order of operations that no library chooses."""
    squared: np.ndarray = x[..., 0] * x[..., 0] + x[..., 1] * x[..., 1] + x[..., 2] * x[..., 2]
    length: np.ndarray = squared**0.5
    return length


def rounding(truth: Truth) -> dict[str, np.ndarray]:
    """The unit of rounding of the largest value of each variable (runs,): nothing can be known better."""
    return {name: float_info.epsilon * norm(x).reshape(len(x), -1).max(axis=1) for name, x in truth.values.items()}
