"""Force types as laws. A type is the coordinates that it acts along and, of these, a potential, an effort, or both.

Coordinates are plain functions of a View (`lienumba.mechanics.mechanism.kinematics`): lengths in metres, angles in
radians; or, on the velocity level, quasi-velocities. The effort along a coordinate (N or N m) is -dV/dc plus what
`effort` gives; both signs are such that effort * rate is the power on the bodies. Derivatives are taken in
`lienumba.mechanics.system.applied_forces`.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from lienumba.groups import so3
from lienumba.mechanics.elements import joints
from lienumba.mechanics.elements.quantities import evaluate
from lienumba.mechanics.mechanism.kinematics import AT_REST, Motion, View, moving
from lienumba.mechanics.mechanism.model import Force, Model
from lienumba.numerics.jets import lift
from lienumba.numerics.operations import is_zero, maximum, minimum, sqrt, tanh, where

SQUARE_FLOOR = 1e-200  # m^2, below the square of every length that matters: zero divided by it is zero

Rows = tuple[Any, ...]


@dataclass(frozen=True)
class Given:
    """given[name]: a number of the force, or its components; view: its bodies, and those that it reads, now."""

    model: Model
    force: Force
    view: View

    def __getitem__(self, name: str) -> Any:
        x = self.force.numbers.get(name)
        if x is None:
            x = FORCE_TYPES[self.force.type].numbers[name].default
        if isinstance(x, tuple):
            return tuple(evaluate(self.model, y, self.view) for y in x)
        return evaluate(self.model, x, self.view)

    def rate(self, name: str) -> Any:
        """The time derivative of a number."""
        return lift(replace(self, view=moving(self.view))[name]).b

    @property
    def rest(self) -> Rows:
        """What the start has decided."""
        assert self.force.rest is not None
        return self.force.rest


# ---------------------------------------------------------------- coordinates
def _ends(force: Force, view: View) -> tuple[Motion, Motion, Any]:
    """Both bodies, and the vector from the first point to the second, global frame."""
    a, b = (view[i] for i in force.bodies)
    p, q = force.points
    return a, b, so3.subtract(b.point(q), a.point(p))


def _now(v: Any) -> Any:
    """The numbers behind what may be jets."""
    return tuple(lift(x).a for x in v)


def _length(v: Any) -> Any:
    """|v|, and to first order its change: along the direction that v has now. Zero has no direction."""
    d = _now(v)
    inverse = 1.0 / sqrt(so3.dot(d, d) + SQUARE_FLOOR)
    return so3.dot(so3.scale(inverse, d), v)


def _distance(given: Given, view: View) -> Rows:
    """Between the two points; where they coincide it has no direction, and nothing acts."""
    return (_length(_ends(given.force, view)[2]),)


def _joint_coordinate(given: Given, view: View) -> Rows:
    assert given.force.coordinate is not None
    return (joints.coordinate(given.model, given.force.coordinate, view),)


def _place(given: Given, view: View) -> Rows:
    """The global position of the point."""
    return view[given.force.bodies[-1]].point(given.force.points[0])


def _turning(given: Given, view: View) -> Rows:
    """Angular velocity."""
    body = view[given.force.bodies[-1]]
    return body.w if given.force.frame == "body" else so3.rotate(body.R, body.w)


def _relative_pose(given: Given, view: View) -> Rows:
    """Displacement of the second point, and rotation vector of the second body since the start, in the first's frame.

    The rotation stays below half a turn: it jumps there.
    """
    a, b, d = _ends(given.force, view)
    since_start = so3.multiply(b.R, so3.transpose(given.rest))
    return so3.rotate_back(a.R, d) + so3.log(so3.multiply(so3.transpose(a.R), since_start))


# ---------------------------------------------------------------- potentials
def _spring(given: Given, c: Rows) -> Any:
    free = given["free_length"]
    return _quadratic(given["stiffness"], c[0] - (given.rest[0] if free is None else free))


def _torsion(given: Given, c: Rows) -> Any:
    return _quadratic(given["stiffness"], c[0] - given["free_angle"])


def _stops(given: Given, c: Rows) -> Any:
    """Of the penetration beyond either stop."""
    total: Any = 0.0
    for stop, outwards in (("lower", -1.0), ("upper", 1.0)):
        limit = given[stop]
        if limit is not None:
            depth = maximum(0.0, outwards * (c[0] - limit))
            total = total + _quadratic(given["stiffness"], depth)
    return total


def _bushing(given: Given, c: Rows) -> Any:
    stiffness = given["stiffness"] + given["rotational_stiffness"]
    return sum((_quadratic(k, x) for k, x in zip(stiffness, c, strict=True)), 0.0)


def _attraction(given: Given, c: Rows) -> Any:
    return -(given["mu"] * given.model.bodies[given.force.bodies[1]].mass) / c[0]


def _quadratic(stiffness: Any, x: Any) -> Any:
    return (0.5 * stiffness) * (x * x)


# ---------------------------------------------------------------- efforts beside -dV/dc
def _damping(given: Given, c: Rows, rates: Rows, conservative: Rows) -> Rows:
    return (-(given["damping"] * rates[0]),)


def _stop_damping(given: Given, c: Rows, rates: Rows, conservative: Rows) -> Rows:
    """Only in contact, and never more than what leaves the stop without a pull."""
    push = conservative[0]
    damping = -(given["damping"] * rates[0])
    if is_zero(damping):
        return (0.0,)
    return (where(push > 0.0, maximum(-push, damping), where(push < 0.0, minimum(-push, damping), 0.0)),)


def _bushing_damping(given: Given, c: Rows, rates: Rows, conservative: Rows) -> Rows:
    damping = given["damping"] + given["rotational_damping"]
    return tuple(-(d * rate) for d, rate in zip(damping, rates, strict=True))


def _actuation(given: Given, c: Rows, rates: Rows, conservative: Rows) -> Rows:
    """What is prescribed, and what draws the coordinate to its target."""
    effort = given["value"] + given["stiffness"] * (given["target"] - c[0])
    effort = effort + given["damping"] * (given.rate("target") - rates[0])
    limit = given["limit"]
    return (effort if limit is None else maximum(-limit, minimum(limit, effort)),)  # NaN stays NaN


def _friction(given: Given, c: Rows, rates: Rows, conservative: Rows) -> Rows:
    sliding = given["coulomb"] * tanh(rates[0] / given["velocity"])
    return (-(given["viscous"] * rates[0] + sliding),)


def _drag(given: Given, c: Rows, rates: Rows, conservative: Rows) -> Rows:
    return so3.scale(-(given["linear"] + given["quadratic"] * sqrt(so3.dot(rates, rates))), rates)


def _pushing(given: Given, c: Rows, rates: Rows, conservative: Rows) -> Rows:
    value, body = given["value"], given.view[given.force.bodies[-1]]
    return so3.rotate(body.R, value) if given.force.frame == "body" else value


def _prescribed(given: Given, c: Rows, rates: Rows, conservative: Rows) -> Rows:
    return given["value"]


# ---------------------------------------------------------------- the types
@dataclass(frozen=True)
class Number:
    """One of a force's numbers: a scalar or a vector of `size`, with its default. None: no limit; for a free length,
    the length at the start."""

    size: int = 1
    required: bool = False
    default: Any = 0.0


VECTOR = Number(3, default=AT_REST)


@dataclass(frozen=True)
class ForceType:
    """ends: "bodies" (two, with points), "body" (one) or "joint", whose coordinate is of one of these kinds.

    coordinates(given, view), potential(given, c) in J, effort(given, c, rates, -dV/dc) in N or N m.
    """

    ends: str
    numbers: dict[str, Number]
    coordinates: Callable[[Given, View], Rows]
    potential: Callable[[Given, Rows], Any] | None = None
    effort: Callable[[Given, Rows, Rows, Rows], Rows] | None = None
    velocity_level: bool = False
    coordinate_kinds: tuple[str, ...] = ("angle", "displacement")


def _named(*names: str) -> dict[str, Number]:
    return dict.fromkeys(names, Number())


FORCE_TYPES: dict[str, ForceType] = {
    "spring_damper": ForceType(
        "bodies", _named("stiffness", "damping") | {"free_length": Number(default=None)}, _distance, _spring, _damping
    ),
    "force": ForceType("body", {"value": Number(3, True)}, _place, effort=_pushing),
    "torque": ForceType("body", {"value": Number(3, True)}, _turning, effort=_prescribed, velocity_level=True),
    "torsion_spring": ForceType(
        "joint", _named("stiffness", "damping", "free_angle"), _joint_coordinate, _torsion, _damping,
        coordinate_kinds=("angle",),
    ),
    "actuator": ForceType(
        "joint", _named("value", "stiffness", "damping", "target") | {"limit": Number(default=None)},
        _joint_coordinate, effort=_actuation,
    ),
    "friction": ForceType(
        "joint", _named("viscous", "coulomb") | {"velocity": Number(default=1e-3)}, _joint_coordinate, effort=_friction
    ),
    "end_stop": ForceType(
        "joint",
        {"stiffness": Number(required=True), "lower": Number(default=None), "upper": Number(default=None)}
        | _named("damping"),
        _joint_coordinate, _stops, _stop_damping,
    ),
    "bushing": ForceType(
        "bodies", dict.fromkeys(("stiffness", "damping", "rotational_stiffness", "rotational_damping"), VECTOR),
        _relative_pose, _bushing, _bushing_damping,
    ),
    "drag": ForceType("body", _named("linear", "quadratic"), _place, effort=_drag),
    "point_mass_gravity": ForceType("bodies", {"mu": Number(required=True)}, _distance, _attraction),
}  # fmt: skip
