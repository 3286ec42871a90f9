"""How the links of a tree move where the whole mechanism turns uniformly about an axis through the origin.

Bodies that nothing holds, and balls and hinges on what stands still, carry the rotation; all that hangs on these rests
against it. A hinge carries it where its axis is that of the rotation, wherever it stands; what it cannot turn stands.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from lienumba.groups import so3
from lienumba.mechanics.mechanism.model import GROUND
from lienumba.mechanics.mechanism.moves import Ball, Free, Turn, Wind
from lienumba.mechanics.tree.links import Tree
from lienumba.mechanics.tree.motion import moving_links
from lienumba.numerics.number import Vector

Array = npt.NDArray[Any]
ALONG = 1e-9  # sine: axes that are the same


@dataclass(frozen=True)
class Carried:
    """rates and accelerations (runs, n) of the tree; how both change with its coordinates (runs, n, n); carries: which
    rates are of what carries the rotation (runs, n)."""

    rates: Array
    accelerations: Array
    rates_by: Array
    accelerations_by: Array
    carries: Array

    def turns(self, tree: Tree, rates: Array, allowed: Array) -> Array:
        """Whether anything of a run carries the rotation where rates are these (runs, n), but for so much (runs,)."""
        kept = ~self.carries | (np.abs(rates - self.rates) <= allowed[:, None])
        own = [list(link.rates) for link in tree.links if link.rates]
        turning = [self.carries[:, rows].any(axis=1) & kept[:, rows].all(axis=1) for rows in own]
        return np.any(turning, axis=0)

    def ahead(self, tree: Tree, rates: Array, speed: Array, angle: float) -> Array:
        """By what coordinates change where all turns by an angle (rad), at these rates (runs, n) and this speed (rad/s,
        (runs,)), with its axes; what a body shifts by follows its circle."""
        time = (angle / speed)[:, None]
        change, along = rates * time, (np.sin(angle) / speed)[:, None] - time
        across = ((1.0 - np.cos(angle)) / speed**2)[:, None]
        for link in tree.links:
            if isinstance(link.move, Free):
                own = link.rates[:3]
                change[:, own] += self.rates[:, own] * along + self.accelerations[:, own] * across
        return change


def carried(tree: Tree, z: Sequence[Any], rotation: Array) -> Carried:
    """At the places of this state; rotation: the angular velocity (3, runs) in rad/s, global."""
    runs, n, turning = rotation.shape[1], tree.freedoms, list[Array]()
    rates, accelerations = np.zeros((2, runs, n))
    rates_by, accelerations_by = np.zeros((2, runs, n, n))
    carries = np.zeros((runs, n), bool)
    omega: Vector = tuple(rotation)
    hat = so3.hat(omega)
    square = so3.multiply(hat, hat)
    for link, moving in zip(tree.links, moving_links(tree, tuple(z)), strict=True):
        stands = np.ones(runs, bool) if link.parent == GROUND else ~turning[link.parent]
        first, own = link.first_rate, ~stands
        if isinstance(link.move, Ball | Free):
            w = so3.rotate_back(moving.R, omega)
            last = first + link.move.freedoms - 3
            own = np.ones(runs, bool)
            _put(rates, last, w, stands)
            _put_matrix(rates_by, last, so3.hat(w), stands)
            carries[:, link.first_rate : last + 3] = stands[:, None]
            if isinstance(link.move, Free):
                v = so3.cross(omega, moving.r)
                a = so3.cross(omega, v)
                _put(rates, first, v, stands)
                _put(accelerations, first, a, stands)
                _put_matrix(rates_by, first, hat, stands)
                _put_matrix(accelerations_by, first, square, stands)
        elif isinstance(link.move, Turn) and not isinstance(link.move, Wind):
            R = moving.R
            axis = (R[2], R[5], R[8])
            across = so3.cross(axis, omega)
            same = np.asarray(so3.dot(across, across) <= ALONG * ALONG * so3.dot(omega, omega)) & stands
            _put(rates, first, (so3.dot(axis, omega),), same)
            carries[:, first] = same
            own = own | same
        turning.append(own)
    return Carried(rates, accelerations, rates_by, accelerations_by, carries)


def _put(into: Array, first: int, numbers: Sequence[Any], where: Array) -> None:
    for n, x in enumerate(numbers):
        into[:, first + n] = np.where(where, x, 0.0)


def _put_matrix(into: Array, first: int, numbers: Sequence[Any], where: Array) -> None:
    for n, x in enumerate(numbers):
        into[:, first + n // 3, first + n % 3] = np.where(where, x, 0.0)
