"""A model of lienumba as the arrays of `Mechanism`: which rows each type of joint has, which numbers each force."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from math import inf, pi
from typing import Any

import numpy as np

from lienumba.mechanics.mechanism.model import GROUND, Coordinate, Force, Joint, Model
from lienumba.mechanics.system.dynamics import INERTIA_ELEMENTS
from lienumba.numerics.jets import Jet, lift
from lienumba.numerics.number import Number
from lienumba.reference.mechanism import (
    ALONG,
    ANGLE,
    BODY,
    DIRECTIONS,
    EFFORT,
    GLOBAL,
    GLOBAL_SPIN,
    LENGTH,
    POINT,
    PUSH,
    ROD,
    SPIN,
    TWIST,
    Bodies,
    Constraints,
    Coordinates,
    Laws,
    Mechanism,
)

X, Y, Z = range(3)
UNIT = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
ZERO = (0.0, 0.0, 0.0)
# The rows of each type of joints: the kind of each, its sign, and the axes of the joint's frame on the first body
# (of POINT: of the global frame) and on the second.
MEET = tuple((POINT, -1.0, axis, X) for axis in (X, Y, Z))  # from the second point to the first, as (B.1)
PARALLEL = ((DIRECTIONS, 1.0, X, Z), (DIRECTIONS, 1.0, Y, Z))
CROSSED, ALIGNED = ((DIRECTIONS, 1.0, Z, Z),), ((DIRECTIONS, 1.0, Y, X),)
ON_AXIS, IN_PLANE = ((ALONG, 1.0, X, X), (ALONG, 1.0, Y, X)), ((ALONG, 1.0, Z, X),)
JOINT_ROWS = {
    "spherical": MEET,
    "revolute": (*MEET, *PARALLEL),
    "universal": (*MEET, *CROSSED),
    "cylindrical": (*ON_AXIS, *PARALLEL),
    "prismatic": (*ON_AXIS, *PARALLEL, *ALIGNED),
    "fixed": (*MEET, *PARALLEL, *ALIGNED),
    "planar": (*IN_PLANE, *PARALLEL),
    "point_on_line": ON_AXIS,
    "point_in_plane": IN_PLANE,
    "distance": ((ROD, 1.0, X, X),),
    "parallel_axes": PARALLEL,
    "perpendicular_axes": CROSSED,
    "screw": (*ON_AXIS, *PARALLEL),  # and a row that ties its displacement to its angle
    "gear": (),  # one row, of two coordinates
    "coupler": (),
}
EFFORTS = {  # numbers of the laws along a coordinate, by their keys
    "spring_damper": (None, "stiffness", "damping", "free_length", None, None),
    "torsion_spring": (None, "stiffness", "damping", "free_angle", None, None),
    "actuator": ("value", "stiffness", "damping", "target", None, None),
}
POTENTIALS = ("spring_damper", "torsion_spring")
DRIVERS = ("angular_velocity",)
FORCES = ("force", "torque", *EFFORTS)


@dataclass
class Table:
    """The arrays of `Mechanism` while they are filled. Numbers are floats, arrays (runs,), or functions of time."""

    model: Model
    numbers: list[Any] = field(default_factory=list)
    coordinates: list[tuple[int, int, int]] = field(default_factory=list)
    vectors: list[Sequence[Number]] = field(default_factory=list)
    terms: list[tuple[int, int, Number]] = field(default_factory=list)
    offsets: list[Number] = field(default_factory=list)
    wanted: list[int] = field(default_factory=list)
    laws: list[tuple[int, int, int, int]] = field(default_factory=list)
    points: list[Sequence[Number]] = field(default_factory=list)
    angles: dict[int, int] = field(default_factory=dict)  # joint: its coordinate

    @staticmethod
    def of(model: Model, counted: Sequence[int] = ()) -> "Table":
        """Of a model that this engine supports; counted: joints (indices) whose turns are counted in any case."""
        table = Table(model, [*model.gravity])
        for n, joint in enumerate(model.joints):
            table.add_joint(n, joint)
        for driver in model.drivers:
            kind = SPIN if driver.frame == "body" else GLOBAL_SPIN
            for axis, x in zip(UNIT, driver.value, strict=True):
                row = table.row(wanted=len(table.numbers))
                table.numbers.append(x)
                table.terms.append((row, table.coordinate(kind, (GROUND, driver.bodies[-1]), v=axis), 1.0))
        for force in model.forces:
            table.add_force(force)
        for n in counted:
            table.of_joint(Coordinate(n, "angle"))
        return table

    def row(self, offset: Number = 0.0, wanted: int = -1) -> int:
        """The index of a new row."""
        self.offsets.append(offset)
        self.wanted.append(wanted)
        return len(self.offsets) - 1

    def coordinate(
        self, kind: int, bodies: Sequence[int], p: Any = ZERO, q: Any = ZERO, u: Any = ZERO, v: Any = ZERO
    ) -> int:
        """The index of a new coordinate."""
        a, b = (len(self.model.bodies) if i == GROUND else i for i in bodies)
        self.coordinates.append((kind, a, b))
        self.vectors.append((*p, *q, *u, *v))
        return len(self.coordinates) - 1

    def add_joint(self, index: int, joint: Joint) -> None:
        """Add the rows of a joint."""
        p, q = joint.points or (ZERO, ZERO)
        for kind, sign, first, second in JOINT_ROWS[joint.type]:
            u = UNIT[first] if kind == POINT or joint.frames is None else joint.frames[0][first]
            v = (joint.numbers["length"], 0.0, 0.0) if kind == ROD else ZERO
            if kind == DIRECTIONS and joint.frames is not None:
                v = joint.frames[1][second]
            self.terms.append((self.row(), self.coordinate(kind, joint.bodies, p, q, u, v), sign))
        tie: tuple[Coordinate, Coordinate, Number] | None = None  # second - ratio first
        if joint.type == "screw":
            tie = Coordinate(index, "angle"), Coordinate(index, "displacement"), joint.numbers["pitch"] * (0.5 / pi)
        elif joint.coordinates is not None:
            tie = (*joint.coordinates, joint.numbers["ratio"])
        if tie is not None:
            row = self.row(joint.numbers["offset"])
            self.terms += [(row, self.of_joint(tie[1]), 1.0), (row, self.of_joint(tie[0]), -tie[2])]

    def of_joint(self, which: Coordinate) -> int:
        """The index of the angle or the displacement of a joint."""
        joint = self.model.joints[which.joint]
        assert joint.frames is not None
        (x, y, z), second = joint.frames
        if which.kind != "angle":
            p, q = joint.points or (ZERO, ZERO)
            return self.coordinate(ALONG, joint.bodies, p, q, z)
        if which.joint not in self.angles:
            self.angles[which.joint] = self.coordinate(ANGLE, joint.bodies, y, ZERO, x, second[X])
        return self.angles[which.joint]

    def add_force(self, force: Force) -> None:
        """Add a force law."""
        first, place = len(self.numbers), ZERO
        if force.type in EFFORTS:
            kind, flag = EFFORT, int(force.type in POTENTIALS)
            given = [0.0 if key is None else force.numbers.get(key, 0.0) for key in EFFORTS[force.type]]
            if force.type == "spring_damper" and "free_length" not in force.numbers:
                given[3] = (force.rest or (0.0,))[0]
            limit = force.numbers.get("limit")
            given[4:] = force.numbers.get("limits", (-inf, inf) if limit is None else (_negative(limit), limit))
            self.numbers += given
            if force.coordinate is not None:
                where = self.of_joint(force.coordinate)
            else:
                where = self.coordinate(LENGTH, force.bodies, *force.points)
        else:
            kind, flag = (PUSH if force.type == "force" else TWIST), (BODY if force.frame == "body" else GLOBAL)
            where, place = force.bodies[-1], (force.points or (ZERO,))[0]
            self.numbers += force.numbers["value"]
        self.laws.append((kind, where, flag, first))
        self.points.append(place)

    def mechanism(self, runs: np.ndarray, dropped: Sequence[int]) -> Mechanism:
        """The arrays of these runs (indices), without the dependent rows that are dropped."""
        bodies = self.model.bodies
        inertia = np.empty((len(bodies), 3, 3, len(runs)))
        for body, J in zip(bodies, inertia, strict=True):
            for (i, j), x in zip(INERTIA_ELEMENTS, body.inertia, strict=True):
                J[i, j] = J[j, i] = _row(x, runs)
        used = [row for row in range(len(self.wanted)) if row not in dropped]
        return Mechanism(
            Bodies(_rows([body.mass for body in bodies], runs), inertia),
            Coordinates(_whole(self.coordinates, 3), _vectors(self.vectors, 12, runs)),
            Constraints(
                _whole([x[:2] for x in self.terms], 2), _rows([x[2] for x in self.terms], runs),
                _rows(self.offsets, runs), np.array(self.wanted, np.int64), np.array(used, np.int64),
            ),
            Laws(_whole(self.laws, 4), _vectors(self.points, 3, runs)),
        )  # fmt: skip

    def numbers_at(self, times: np.ndarray, runs: np.ndarray, before: np.ndarray | None = None) -> np.ndarray:
        """All numbers of these runs (indices) and their rates at times (...) in s: (..., n, 2, N). before: those at
        as many other times, or more, which are overwritten."""
        shape = (*times.shape, len(self.numbers), 2, len(runs))
        found = np.zeros(shape) if before is None else before[: len(times)]
        with np.errstate(all="ignore"):
            for n, x in enumerate(self.numbers):
                if before is not None and not callable(x):
                    continue
                y = lift(x(Jet(times[..., None], 1.0)) if callable(x) else x)
                for place, z in enumerate((y.a, y.b)):
                    found[..., n, place, :] = z[..., runs] if np.shape(z)[-1:] not in ((), (1,)) else z
        return found


def _negative(x: Any) -> Any:
    """-x of a number or a function of time."""
    negative: Callable[[Any], Any] = lambda t: -x(t)  # noqa: E731
    return negative if callable(x) else -x


def _row(x: Number, runs: np.ndarray) -> np.ndarray:
    """A number of these runs (N,)."""
    found = np.asarray(x, float)
    return np.broadcast_to(found[runs] if found.ndim else found, runs.shape)


def _rows(numbers: Sequence[Number], runs: np.ndarray) -> np.ndarray:
    return np.array([_row(x, runs) for x in numbers]).reshape(len(numbers), len(runs))


def _vectors(vectors: Sequence[Sequence[Number]], size: int, runs: np.ndarray) -> np.ndarray:
    return np.array([[_row(x, runs) for x in v] for v in vectors]).reshape(len(vectors), size, len(runs))


def _whole(rows: Sequence[Sequence[int]], size: int) -> np.ndarray:
    return np.array(rows, np.int64).reshape(len(rows), size)
