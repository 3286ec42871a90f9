"""The initial state: what is given is held, what is omitted is solved for from the joints.

Works on all runs at once, elementwise (numbers are floats or arrays of shape (runs,)), so that a run's initial state
depends on nothing but its own inputs, on any CPU. Positions move before rotations do: an omitted rotation is the
identity, or the guess, unless the joints force it away. Omitted velocities are those of least kinetic energy relative
to where they start: at rest, as guessed, or moving with the body to which they are relative.
"""

from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from lienumba.mechanics.elements import joints
from lienumba.mechanics.elements.joints import JOINTS
from lienumba.mechanics.mechanism.kinematics import Instant, still
from lienumba.mechanics.mechanism.massless import evened, with_lent_masses
from lienumba.mechanics.mechanism.model import Coordinate, Counted, Driver, Model, Start
from lienumba.mechanics.mechanism.model_numbers import map_numbers
from lienumba.mechanics.start import joint_frames
from lienumba.mechanics.start.along_joints import Along, along_joints, moving_along
from lienumba.mechanics.start.gauss_newton import Closing, allowed_distances, allowed_rates, velocities
from lienumba.mechanics.start.least_norm import Entries
from lienumba.mechanics.start.poses import Poses
from lienumba.mechanics.system import constraints
from lienumba.mechanics.system.switches import at_start, switches_of

LENT = 1e-4  # of the lightest body, a massless one gets so much; `velocities` takes it back
FEW = 4  # bodies up to which the least change is found from anywhere; more start along joints without references, too


class Condition(NamedTuple):
    """Something that the start has to fulfil: a "joint", a "driver", or what is given for a coordinate of a joint, by
    the name of this or of its rate; name: of the joint or driver; kinds: one letter for each row, "m" for a length, "r"
    for an angle; of_positions: whether only positions have to."""

    what: str
    name: str
    bodies: tuple[int, ...]
    rows: slice
    kinds: str
    of_positions: bool = False


class Assembly(NamedTuple):
    """model: with all that the start decides; state (runs, k, 18); angles: those that count turns (runs,) rad; per row
    of the conditions (runs, m): the violations left (m or 1, m/s or rad/s), and the limits up to which they are
    accepted.

    Rows come as in the constraints of the model, then those of what is given for joint coordinates.
    """

    model: Model
    state: np.ndarray
    angles: dict[Counted, np.ndarray]
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
    holding = at_start(model)
    with np.errstate(all="ignore"):
        try:
            done = _assemble(holding, start, runs)
        except ZeroDivisionError:  # of plain numbers, which are faster
            done = _assemble(map_numbers(holding, _divisible), _all_divisible(start), runs)
    return done._replace(model=_switched(model, done.model))


def _switched(model: Model, done: Model) -> Model:
    """A model with what the start has decided of it as it was when nothing was switched."""
    if not switches_of(model):
        return done
    joints = tuple(replace(x, switched=y.switched) for x, y in zip(done.joints, model.joints, strict=True))
    forces = {force.name: force for force in done.forces}
    decided = tuple(forces.get(force.name, force) for force in model.forces)
    same = map_numbers(model, _plain)
    return replace(same, joints=joints, forces=decided)


def _assemble(model: Model, start: Start, runs: int) -> Assembly:
    poses = Poses.of(start, joint_frames.carried_by_start(start, model))
    targets = joint_frames.angles_given(model, start)
    angles: dict[Counted, Any] = {**dict.fromkeys(range(len(model.joints)), 0.0), **targets}
    given = [x for j in range(len(model.joints)) for x in _given(model, start, j)]

    bodies = poses.bodies(poses.local)
    unsolved = _with_given(_placed(model, start, poses, targets, bodies, final=False), given)
    unsolved = replace(unsolved, joints=tuple(map(joint_frames.provisional, unsolved.joints)))
    told = joint_frames.with_driven(model, start)
    along = along_joints(unsolved, told, poses)
    by_axes = along_joints(unsolved, told, poses, zero_by_axes=True)
    if len(by_axes.ties) > FEW:
        along = by_axes
    poses = poses.at(along.local, along.bodies)
    rows = _rows_known(unsolved, model, start)
    local = poses.local
    if poses.shifts | poses.turns and not _all_said(unsolved, poses, along, given):
        closing = Closing(unsolved, poses, angles, rows, runs, _upright(model, start, poses))
        local = closing.positions(by_axes.local if by_axes.ties != along.ties else None)
    bodies = poses.bodies(local)

    model = _placed(model, start, poses, targets, bodies, final=True)
    model = map_numbers(joint_frames.with_numbers(model, bodies, angles), _plain)
    full = _with_given(model, given)
    conditions = _conditions(full, len(model.drivers), given)
    rows = _on_velocities(conditions)
    moving = moving_along(model, told, poses, along.ties, poses.bodies(local, poses.rates))
    lent = with_lent_masses(model, LENT)
    bodies = velocities(full, poses, local, lambda evenness: _inverse_mass(evened(lent, evenness)), rows, moving)
    return _result(model, full, conditions, Instant(bodies, 0.0, angles), runs)


@dataclass(frozen=True)
class Given:
    """Of a coordinate at the start: motion, "value" or "rate"; name: by which it or its rate is known; value: of it."""

    which: Coordinate
    motion: str
    name: str
    value: Any


def _given(model: Model, start: Start, index: int) -> list[Given]:
    """What is known of the coordinates of a joint, and then of their rates."""
    known, every = start.joints[index].known, JOINTS[model.joints[index].type].freedoms()
    names = [(x.name, "value", x.name) for x in every] + [(x.name, "rate", x.rate) for x in every]
    return [Given(Coordinate(index, x), motion, key, known[key]) for x, motion, key in names if key in known]


def _all_said(unsolved: Model, poses: Poses, along: Along, given: list[Given]) -> bool:
    """Whether joints have put every body that is not given, and nothing else is asked of positions."""
    if any(c // 6 not in along.bodies for c in poses.shifts | poses.turns):
        return False
    drivers = len(unsolved.drivers) - len(given)
    asked = [*range(len(unsolved.joints)), *[None] * drivers, *(x.which.joint for x in given)]
    listed = zip(constraints.constraints_of(unsolved), asked, strict=True)
    return all(constraint.level != "position" or joint in along.joints for constraint, joint in listed)


def _divisible(x: Any, _: bool = False) -> Any:
    """Division by 0 gives inf or nan, as for arrays."""
    return np.float64(x) if isinstance(x, float | int) else x


def _all_divisible(x: Any) -> Any:
    """A start, or a part of it."""
    if isinstance(x, tuple):
        return tuple(_all_divisible(y) for y in x)
    if isinstance(x, dict):
        return {key: y if isinstance(y, str) else _all_divisible(y) for key, y in x.items()}
    if hasattr(x, "__dataclass_fields__"):
        return replace(x, **{name: _all_divisible(y) for name, y in vars(x).items() if name != "relative_to"})
    return _divisible(x)


def _plain(x: Any, _: bool = False) -> Any:
    """A number that cannot differ between runs is a float."""
    if type(x) is float:
        return x
    return float(x) if np.ndim(x) == 0 else np.asarray(x)


def _placed(
    model: Model, start: Start, poses: Poses, targets: dict[Counted, Any], bodies: tuple[Any, ...], final: bool
) -> Model:
    """The model with the points and frames of its joints where these bodies have them."""
    placed = []
    for j, (joint, says) in enumerate(zip(model.joints, start.joints, strict=True)):
        known = joint_frames.relative_known(joint, poses) or (final and j not in targets)
        placed.append(joint_frames.place(joint, says, bodies, targets.get(j), known))
    return map_numbers(replace(model, joints=tuple(placed)), _plain)


def _with_given(model: Model, given: list[Given]) -> Model:
    """What is given for the coordinates of joints, as drivers behind those of the model."""
    drivers = []
    for x in given:
        joint = model.joints[x.which.joint]
        drivers.append(Driver(joint.name, x.motion, joint.bodies, (x.value,), x.which))
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


def _conditions(full: Model, drivers: int, given: list[Given]) -> tuple[Condition, ...]:
    what = [("joint", False)] * len(full.joints) + [("driver", False)] * drivers
    what += [(x.name, x.motion == "value") for x in given]
    listed = zip(what, constraints.constraints_of(full), constraints.rows_of(full), strict=True)
    return tuple(Condition(w, c.name, c.bodies, rows, c.kinds, place) for (w, place), c, rows in listed)


def _on_velocities(conditions: tuple[Condition, ...]) -> tuple[int, ...]:
    """The rows that hold for velocities: all but given positions."""
    rows: list[int] = []
    for c in conditions:
        rows += () if c.of_positions else range(c.rows.start, c.rows.stop)
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


def _result(model: Model, full: Model, conditions: tuple[Condition, ...], now: Instant, runs: int) -> Assembly:
    on_velocities = _on_velocities(conditions)
    rates, _ = constraints.rate_and_bias(full, now)
    rates = [rate if row in on_velocities else 0.0 for row, rate in enumerate(rates)]
    flat = _stack([x for body in now.bodies for x in body], runs)
    everything = still(now, tuple(range(len(now.bodies))))
    angles = {
        which.counted: np.array(np.broadcast_to(joints.coordinate(model, which, everything), (runs,)), float)
        for j, joint in enumerate(model.joints)
        for which in (Coordinate(j, x.name) for x in JOINTS[joint.type].freedoms() if x.counts)
    }
    return Assembly(
        model,
        flat.reshape(runs, len(now.bodies), 18),
        angles,
        conditions,
        np.abs(_stack(constraints.residual(full, now), runs)),
        np.abs(_stack(rates, runs)),
        _stack(allowed_distances(full, now), runs),
        _stack(allowed_rates(full, now), runs),
    )


def _stack(rows: list[Any], runs: int) -> np.ndarray:
    """(runs, len(rows)) of numbers."""
    if all(isinstance(x, float) for x in rows):
        return np.tile(np.array(rows, float), (runs, 1))
    return np.stack([np.broadcast_to(np.asarray(x, float), (runs,)) for x in rows], axis=1)
