"""A tree of links as other engines want it: coordinates and rates of its joints, and what they make of its bodies.

Coordinates of a link: of a hinge its angle, of a slide its displacement; of a ball the quaternion (w, x, y, z) from the
link to its parent's axes; of a free link the position of its mass centre, then the quaternion from its axes to the
global ones. Rates: of a ball the relative angular velocity, link axes; of a free link the velocity of its mass centre,
global axes, then its angular velocity, link axes. Arrays over runs come first: q (runs, nq), v and a (runs, nv).
"""

from copy import copy
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from lienumba.mechanics.mechanism.model import GROUND, Model

Array = np.ndarray
KINDS = {"revolute": "hinge", "prismatic": "slide", "spherical": "ball"}
SIZES = {"hinge": (1, 1), "slide": (1, 1), "ball": (4, 3), "free": (7, 6)}  # of coordinates and rates


@dataclass(frozen=True)
class Link:
    """points: of the joint, in the parent's and the link's frame; place (3, 3): from the link's axes to its parent's
    where the coordinate is 0; axis: link axes; q, v: where its coordinates and rates begin."""

    name: str
    joint: str
    kind: str
    parent: int
    mass: float
    inertia: Array
    points: Array
    place: Array
    axis: Array
    armature: float
    q: int
    v: int


class Tree:
    """Of a model whose joints tie each body to one before it, or to the ground."""

    def __init__(self, model: Model) -> None:
        self.gravity = np.array(model.gravity, float)
        self.links: list[Link] = []
        above = {joint.bodies[1]: joint for joint in model.joints}
        if len(above) != len(model.joints) or any(joint.bodies[0] >= joint.bodies[1] for joint in model.joints):
            raise ValueError("a joint of this model closes a loop, or ties a body to one behind it")
        q = v = 0
        for i, body in enumerate(model.bodies):
            joint = above.get(i)
            xx, yy, zz, xy, xz, yz = body.inertia
            inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]], float)
            kind = "free" if joint is None else KINDS[joint.type]
            points = np.zeros((2, 3)) if joint is None else np.array(joint.points, float)
            place, axis = np.eye(3), np.zeros(3)
            if joint is not None and joint.frames is not None:
                first, second = (np.array(frame, float) for frame in joint.frames)
                place, axis = first.T @ second, second[2]
            parent = GROUND if joint is None else joint.bodies[0]
            name, armature = ("", 0.0) if joint is None else (joint.name, float(joint.armature))
            link = Link(body.name, name, kind, parent, float(body.mass), inertia, points, place, axis, armature, q, v)
            self.links.append(link)
            q, v = q + SIZES[kind][0], v + SIZES[kind][1]
        self.nq, self.nv = q, v

    def with_rotors(self, armature: float) -> "Tree":
        """The same with rotors of this inertia (kg m^2, or kg) at all joints."""
        other = copy(self)
        other.links = [x if x.kind in ("free", "ball") else replace(x, armature=armature) for x in self.links]
        return other

    # ------------------------------------------------------------ where bodies are, and how they move
    def coordinates(self, states: Array) -> tuple[Array, Array]:
        """q and v of states (runs, 18 k), in which bodies fit their joints."""
        q, v = np.zeros((len(states), self.nq)), np.zeros((len(states), self.nv))
        bodies = _bodies(states, len(self.links))
        for link, (r, R, velocity, w) in zip(self.links, bodies, strict=True):
            p, Q, u, o = _parent(bodies, link, len(states))
            across = link.place.T @ np.swapaxes(Q, 1, 2) @ R  # the turn from coordinate 0, link axes
            relative = w - _back(R, _turn(Q, o))
            if link.kind == "free":
                q[:, link.q : link.q + 7] = np.concatenate([r, quaternions(R)], axis=1)
                v[:, link.v : link.v + 6] = np.concatenate([velocity, w], axis=1)
            elif link.kind == "ball":
                q[:, link.q : link.q + 4], v[:, link.v : link.v + 3] = quaternions(across), relative
            elif link.kind == "hinge":
                vector = 0.5 * np.stack([across[:, 2, 1] - across[:, 1, 2], across[:, 0, 2] - across[:, 2, 0],
                                         across[:, 1, 0] - across[:, 0, 1]], axis=1)  # fmt: skip
                q[:, link.q] = np.arctan2(vector @ link.axis, 0.5 * (np.trace(across, axis1=1, axis2=2) - 1.0))
                v[:, link.v] = relative @ link.axis
            else:
                d = r + _turn(R, link.points[1]) - p - _turn(Q, link.points[0])
                z = _turn(R, link.axis)
                moved = velocity + np.cross(_turn(R, w), _turn(R, link.points[1])) - u
                q[:, link.q] = np.sum(z * d, axis=1)
                v[:, link.v] = np.sum(z * (moved - np.cross(_turn(Q, o), d + _turn(Q, link.points[0]))), axis=1)
        return q, v

    def states(self, q: Array, v: Array) -> Array:
        """States (runs, 18 k): mass centre, rotation row by row, velocity (global axes), angular velocity (body)."""
        return np.concatenate([np.concatenate([x.reshape(len(q), -1) for x in body[:4]], axis=1)
                               for body in self._moving(q, v, np.zeros_like(v))], axis=1)  # fmt: skip

    def accelerations(self, q: Array, v: Array, a: Array) -> Array:
        """Of every body (runs, k, 6): of the mass centre, global axes, and angular, body axes. a: rates of v."""
        return np.stack([np.concatenate(body[4:], axis=1) for body in self._moving(q, v, a)], axis=1)

    def _moving(self, q: Array, v: Array, a: Array) -> list[tuple[Array, ...]]:
        """r, R, r', w, r'', w' of every body; w and w' in body axes."""
        done: list[tuple[Array, ...]] = []
        for link in self.links:
            x, rate, more = (y[:, first:] for y, first in ((q, link.q), (v, link.v), (a, link.v)))
            if link.kind == "free":
                done.append((x[:, :3], rotations(x[:, 3:7]), rate[:, :3], rate[:, 3:6], more[:, :3], more[:, 3:6]))
                continue
            p, Q, u, o, b, e = _carrier(done, link, len(q))
            slides = link.kind == "slide"
            turn = rotations(x[:, :4]) if link.kind == "ball" else about(link.axis, x[:, 0] * (not slides))
            R = Q @ link.place @ turn
            own, grows = _relative(link, rate), _relative(link, more)
            w = _back(R, _turn(Q, o)) + own
            faster = _back(R, _turn(Q, e)) + grows + np.cross(w, own)
            arm, back = _turn(Q, link.points[0]), -_turn(R, link.points[1])
            here, there = _spin(_turn(R, w), _turn(R, faster), back), _turn(Q, o)
            r, s, t = p + arm + back, u + here[0], b + here[1]
            if slides:
                z = _turn(R, link.axis)
                r, s, t = r + z * x[:, :1], s + z * rate[:, :1], t + z * more[:, :1]
                t = t + 2 * np.cross(there, z) * rate[:, :1]
                arm = arm + z * x[:, :1]
            carried = _spin(there, _turn(Q, e), arm)
            done.append((r, R, s + carried[0], w, t + carried[1], faster))
        return done


def _relative(link: Link, rate: Array) -> Array:
    """The relative angular velocity, or its rate, in the link's axes."""
    if link.kind == "ball":
        return rate[:, :3]
    return rate[:, :1] * link.axis * (link.kind == "hinge")


def _spin(w: Array, faster: Array, arm: Array) -> tuple[Array, Array]:
    """Velocity and acceleration of the end of an arm on a turning body, global axes."""
    velocity = np.cross(w, arm)
    return velocity, np.cross(faster, arm) + np.cross(w, velocity)


def _carrier(done: list[tuple[Array, ...]], link: Link, runs: int) -> tuple[Array, ...]:
    if link.parent != GROUND:
        return done[link.parent]
    zero = np.zeros((runs, 3))
    return zero, np.broadcast_to(np.eye(3), (runs, 3, 3)), zero, zero, zero, zero


def _bodies(states: Array, k: int) -> list[tuple[Array, ...]]:
    x = states[:, : 18 * k].reshape(len(states), k, 18)
    return [(y[:, :3], y[:, 3:12].reshape(-1, 3, 3), y[:, 12:15], y[:, 15:18]) for y in np.moveaxis(x, 1, 0)]


def _parent(bodies: list[tuple[Array, ...]], link: Link, runs: int) -> tuple[Array, ...]:
    return _carrier(bodies, link, runs)[:4]


def _turn(R: Array, x: Array) -> Array:
    return np.einsum("nij,nj->ni", R, np.broadcast_to(x, (len(R), 3)))


def _back(R: Array, x: Array) -> Array:
    return np.einsum("nji,nj->ni", R, np.broadcast_to(x, (len(R), 3)))


def about(axis: Array, angle: Array) -> Array:
    """Rotations (runs, 3, 3) about a unit axis."""
    x, y, z = axis
    hat = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    s, c = np.sin(angle)[:, None, None], 2 * np.sin(0.5 * angle)[:, None, None] ** 2
    rotation: Array = np.eye(3) + s * hat + c * (hat @ hat)
    return rotation


def rotations(quaternion: Array) -> Array:
    """Rotations (runs, 3, 3) of unit quaternions (runs, 4)."""
    w, x, y, z = np.moveaxis(quaternion, 1, 0)
    rows = [[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]]  # fmt: skip
    return np.moveaxis(np.array(rows), 2, 0)


def quaternions(R: Array) -> Array:
    """Unit quaternions (runs, 4) of rotations (runs, 3, 3)."""
    from scipy.spatial.transform import Rotation

    found: Any = Rotation.from_matrix(R).as_quat(scalar_first=True)
    return np.asarray(found)
