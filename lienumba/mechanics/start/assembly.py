"""The initial state: what is given is held, what is omitted is solved for from the joints.

Works on all runs at once, elementwise (numbers are floats or arrays of shape (runs,)), so that a run's initial state
depends on nothing but its own inputs, on any CPU. Positions move before rotations do: an omitted rotation is the
identity, or the guess, unless the joints force it away. Omitted velocities are those of least kinetic energy relative
to where they start: at rest, as guessed, or moving with the body to which they are relative.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from lienumba.mechanics.elements import joints
from lienumba.mechanics.elements.joints import JOINTS
from lienumba.mechanics.mechanism.kinematics import Instant, still
from lienumba.mechanics.mechanism.model import Coordinate, Driver, Model, Start
from lienumba.mechanics.mechanism.model_numbers import map_numbers
from lienumba.mechanics.start import joint_frames
from lienumba.mechanics.start.gauss_newton import ACCEPTED, Closing, velocities
from lienumba.mechanics.start.least_norm import Entries
from lienumba.mechanics.start.poses import Poses
from lienumba.mechanics.system import constraints
from lienumba.mechanics.system.projection import ROUNDING

MOTIONS = {"angle": "value", "displacement": "value", "rate": "rate", "speed": "rate"}
COORDINATES = {"angle": "angle", "rate": "angle", "displacement": "displacement", "speed": "displacement"}


@dataclass(frozen=True)
class Condition:
    """Something that the start has to fulfil: a "joint", a "driver", or the "angle", "displacement", "rate" or "speed"
    given for a joint; name: of the joint or driver; kinds: one letter for each row, "m" for a length, "r" for an angle.
    """

    what: str
    name: str
    bodies: tuple[int, ...]
    rows: slice
    kinds: str


@dataclass(frozen=True)
class Assembly:
    """model: with all that the start decides; state (runs, k, 18); angles: by joint (runs,) rad; per row of the
    conditions (runs, m): the violations left (m or 1, m/s or rad/s), and the limits up to which they are accepted.

    Rows come as in the constraints of the model, then those of what is given for joint coordinates.
    """

    model: Model
    state: np.ndarray
    angles: dict[int, np.ndarray]
    conditions: tuple[Condition, ...]
    position_violations: np.ndarray
    velocity_violations: np.ndarray
    position_limits: np.ndarray
    velocity_limits: np.ndarray

    @property
    def good(self) -> np.ndarray:
        """Whether each run fulfils its joints (runs,)."""
        position = np.all(self.position_violations <= self.position_limits, axis=1)
        velocity = np.all(self.velocity_violations <= self.velocity_limits, axis=1)
        finite: np.ndarray = np.all(np.isfinite(self.state), axis=(1, 2))
        return position & velocity & finite

    def instant(self, run: int) -> Instant:
        """The start of one run, in floats."""
        bodies = tuple(tuple(float(x) for x in body) for body in self.state[run])
        return Instant(bodies, 0.0, {j: float(angle[run]) for j, angle in self.angles.items()})


def assemble(model: Model, start: Start, runs: int) -> Assembly:
    """The initial state of every run. Nothing is raised here: violations that are left tell what did not fit."""
    with np.errstate(all="ignore"):
        try:
            return _assemble(model, start, runs)
        except ZeroDivisionError:  # of plain numbers, which are faster
            return _assemble(map_numbers(model, _divisible), _all_divisible(start), runs)


def _assemble(model: Model, start: Start, runs: int) -> Assembly:
    poses = Poses.of(start, joint_frames.carried_by_start(start, model))
    targets = joint_frames.angles_given(model, start)
    angles = {j: targets.get(j, 0.0) for j in range(len(model.joints))}
    given = [(j, name) for j, says in enumerate(start.joints) for name in MOTIONS if getattr(says, name) is not None]

    bodies = poses.bodies(poses.local)
    unsolved = _with_given(_placed(model, start, poses, targets, bodies, final=False), start, given)
    unsolved = replace(unsolved, joints=tuple(map(joint_frames.provisional, unsolved.joints)))
    local = poses.local
    if poses.shifts | poses.turns:
        local = Closing(
            unsolved, poses, angles, _rows_known(unsolved, model, start), runs, _upright(model, start, poses)
        ).positions()
    bodies = poses.bodies(local)

    model = _placed(model, start, poses, targets, bodies, final=True)
    model = map_numbers(joint_frames.with_numbers(model, bodies, angles), _plain)
    full = _with_given(model, start, given)
    rows = _on_velocities(_conditions(full, len(model.drivers), given))
    bodies = velocities(full, poses, local, _inverse_mass(model), rows)
    return _result(model, full, given, Instant(bodies, 0.0, angles), runs)


def _divisible(x: Any, _: bool = False) -> Any:
    """Division by 0 gives inf or nan, as for arrays."""
    return np.float64(x) if isinstance(x, float | int) else x


def _all_divisible(x: Any) -> Any:
    """A start, or a part of it."""
    if isinstance(x, tuple):
        return tuple(_all_divisible(y) for y in x)
    if hasattr(x, "__dataclass_fields__"):
        return replace(x, **{name: _all_divisible(y) for name, y in vars(x).items() if name != "relative_to"})
    return _divisible(x)


def _plain(x: Any, _: bool = False) -> Any:
    """A number that cannot differ between runs is a float."""
    if type(x) is float:
        return x
    return float(x) if np.ndim(x) == 0 else np.asarray(x)


def _placed(
    model: Model, start: Start, poses: Poses, targets: dict[int, Any], bodies: tuple[Any, ...], final: bool
) -> Model:
    """The model with the points and frames of its joints where these bodies have them."""
    placed = []
    for j, (joint, says) in enumerate(zip(model.joints, start.joints, strict=True)):
        known = joint_frames.relative_known(joint, poses) or (final and j not in targets)
        placed.append(joint_frames.place(joint, says, bodies, targets.get(j), known))
    return map_numbers(replace(model, joints=tuple(placed)), _plain)


def _with_given(model: Model, start: Start, given: list[tuple[int, str]]) -> Model:
    """What is given for the coordinates of joints, as drivers behind those of the model."""
    drivers = []
    for j, name in given:
        joint, value = model.joints[j], getattr(start.joints[j], name)
        drivers.append(Driver(joint.name, MOTIONS[name], joint.bodies, (value,), Coordinate(j, COORDINATES[name])))
    return replace(model, drivers=(*model.drivers, *drivers))


def _upright(model: Model, start: Start, poses: Poses) -> tuple[tuple[int, int], ...]:
    """The joints with parallel axes in both bodies, or aligned references, whose relative rotation is not given."""
    found = []
    for j, (joint, says) in enumerate(zip(model.joints, start.joints, strict=True)):
        kind = JOINTS[joint.type]
        if says.axes is None or joint_frames.relative_known(joint, poses) or not kind.stays_parallel:
            continue
        found.append((j, joints.Z))
        if says.references is not None and joints.X in kind.same_way:
            found.append((j, joints.X))
    return tuple(found)


def _rows_known(unsolved: Model, model: Model, start: Start) -> tuple[int, ...]:
    """The rows on the position level, but for those that only the assembled start decides."""
    rows: list[int] = []
    undecided = [JOINTS[joint.type].open_rows(model, start, j) for j, joint in enumerate(model.joints)]
    undecided += [0] * len(unsolved.drivers)
    listed = zip(constraints.constraints_of(unsolved), constraints.rows_of(unsolved), undecided, strict=True)
    for constraint, own, last in listed:
        if constraint.level == "position":
            rows += range(own.start, own.stop - last)
    return tuple(rows)


def _conditions(full: Model, drivers: int, given: list[tuple[int, str]]) -> tuple[Condition, ...]:
    what = ["joint"] * len(full.joints) + ["driver"] * drivers + [name for _, name in given]
    listed = zip(what, constraints.constraints_of(full), constraints.rows_of(full), strict=True)
    return tuple(Condition(w, c.name, c.bodies, rows, c.kinds) for w, c, rows in listed)


def _on_velocities(conditions: tuple[Condition, ...]) -> tuple[int, ...]:
    """The rows that hold for velocities: all but given positions."""
    rows: list[int] = []
    for c in conditions:
        rows += range(c.rows.start, c.rows.stop) if c.what not in ("angle", "displacement") else ()
    return tuple(rows)


def _inverse_mass(model: Model) -> Entries:
    """The entries of M^-1."""
    entries: Entries = {}
    for i, body in enumerate(model.bodies):
        xx, yy, zz, xy, xz, yz = body.inertia
        a, b, c = yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy
        d = xx * a + xy * b + xz * c
        e, f, g = (xx * zz - xz * xz) / d, (xy * xz - xx * yz) / d, (xx * yy - xy * xy) / d
        J = ((a / d, b / d, c / d), (b / d, e, f), (c / d, f, g))
        entries |= {(6 * i + n, 6 * i + n): 1.0 / body.mass for n in range(3)}
        entries |= {(6 * i + 3 + m, 6 * i + 3 + n): J[m][n] for m in range(3) for n in range(3)}
    return entries


def _result(model: Model, full: Model, given: list[tuple[int, str]], now: Instant, runs: int) -> Assembly:
    conditions = _conditions(full, len(model.drivers), given)
    on_velocities = _on_velocities(conditions)
    rates, _ = constraints.rate_and_bias(full, now)
    rates = [rate if row in on_velocities else 0.0 for row, rate in enumerate(rates)]
    reach, far, speed = constraints.sizes(full, now)
    fastest = constraints.largest([x for body in now.bodies for x in body[12:18]])
    flat = _stack([x for body in now.bodies for x in body], runs)
    angles = {
        j: np.array(np.broadcast_to(joints.angle(joint, still(now, joint.bodies), now.angles[j]), (runs,)), float)
        for j, joint in enumerate(model.joints)
        if "angle" in JOINTS[joint.type].coordinate_kinds
    }
    return Assembly(
        model,
        flat.reshape(runs, len(now.bodies), 18),
        angles,
        conditions,
        np.abs(_stack(constraints.residual(full, now), runs)),
        np.abs(_stack(rates, runs)),
        ACCEPTED * _stack(reach, runs) + ROUNDING * _stack(far, runs),
        ACCEPTED * _stack(speed, runs) + ROUNDING * _stack([fastest], runs),
    )


def _stack(rows: list[Any], runs: int) -> np.ndarray:
    """(runs, len(rows)) of numbers."""
    if all(isinstance(x, float) for x in rows):
        return np.tile(np.array(rows, float), (runs, 1))
    return np.stack([np.broadcast_to(np.asarray(x, float), (runs,)) for x in rows], axis=1)
