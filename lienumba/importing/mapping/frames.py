"""Frames, and numbers as somebody would write them."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from lienumba.groups import so3

DIGITS = 15  # that a number is written with
WHOLE = 1e6  # below which whole numbers are written without a point


@dataclass(frozen=True)
class Frame:
    """p (3,) in m and R (3, 3): origin and axes of a frame in another one."""

    p: np.ndarray
    R: np.ndarray

    @classmethod
    def of(cls, position: np.ndarray, quaternion: np.ndarray) -> Self:
        """From a position and a quaternion w x y z."""
        return cls(np.array(position, float), rotation(quaternion))

    def __matmul__(self, other: "Frame") -> "Frame":
        return Frame(self.p + self.R @ other.p, self.R @ other.R)

    def inverse(self) -> "Frame":
        """Of the other frame in this one."""
        return Frame(-self.R.T @ self.p, self.R.T)

    def point(self, p: np.ndarray) -> np.ndarray:
        """A point of this frame in the other one."""
        return self.p + self.R @ p

    def moved(self, offset: np.ndarray) -> "Frame":
        """The same axes at another origin, given in this frame."""
        return Frame(self.point(offset), self.R)


HERE = Frame(np.zeros(3), np.eye(3))


def rotation(quaternion: np.ndarray) -> np.ndarray:
    """The matrix (3, 3) of a quaternion w x y z of any length."""
    return np.array(so3.from_quaternion(tuple(quaternion))).reshape(3, 3)


def quaternion(R: np.ndarray) -> np.ndarray:
    """w x y z of a matrix (3, 3), w at least 0."""
    return np.array(so3.to_quaternion(tuple(R.ravel())))


def about(axis: np.ndarray, angle: float) -> np.ndarray:
    """The matrix (3, 3) of a rotation by an angle (rad)."""
    return rotation(np.concatenate([[np.cos(angle / 2)], np.sin(angle / 2) * np.asarray(axis)]))


def across(axis: np.ndarray) -> np.ndarray:
    """A direction across an axis: of the coordinate axes, where one is."""
    axes = np.eye(3)
    x = axes[np.argmin(abs(axis))]
    x = x - (x @ axis) / (axis @ axis) * axis
    return np.asarray(x / np.linalg.norm(x))


def tidy(x: np.ndarray | float) -> list[float]:
    """As a list of numbers in `DIGITS` digits of the largest of them: what lies below is rounding."""
    values = np.asarray(x, float).ravel()
    largest = abs(values).max(initial=0.0)
    if largest == 0.0:
        return [0] * len(values)
    places = DIGITS - 1 - int(np.floor(np.log10(largest)))
    return [neat(round(float(v), places)) for v in values]


def neat(x: float) -> float:
    """A number in `DIGITS` digits; a whole one without a point."""
    found = float(f"{x:.{DIGITS}g}")
    return int(found) if found.is_integer() and abs(found) < WHOLE else found


def tensor(J: np.ndarray) -> list[float]:
    """An inertia (3, 3): its 3 moments, or the 6 elements xx yy zz xy xz yz."""
    whole = tidy(np.array([J[0, 0], J[1, 1], J[2, 2], J[0, 1], J[0, 2], J[1, 2]]))
    return whole if any(whole[3:]) else whole[:3]
