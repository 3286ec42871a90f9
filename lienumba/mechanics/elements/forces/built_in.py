"""The force types: what each acts along, its potential, its effort."""

from collections.abc import Iterator
from typing import Any, ClassVar, Literal

from pydantic import Field

from lienumba.errors import Problem, missing
from lienumba.groups import so3
from lienumba.keys.formulas import constant
from lienumba.keys.types import AXES, ZERO, Axes, Timed, Timed2, Timed3, Two
from lienumba.mechanics.elements.forces.base import (
    FORCES,
    AlongJoint,
    BetweenPoints,
    Given,
    Keys,
    OnBody,
    OnPoint,
    apart,
    length,
    quadratic,
)
from lienumba.mechanics.elements.forces.numbers import DISSIPATIVE, SIZE, faulty_limits, number, positive
from lienumba.mechanics.mechanism.kinematics import OFF, STICK, Mode, View
from lienumba.mechanics.mechanism.model import Force
from lienumba.numerics.number import Number, Vector
from lienumba.numerics.operations import is_zero, maximum, minimum, sqrt, tanh, where
from lienumba.words import show

# Units of numbers along a displacement, and about an angle.
EFFORT = ("N", "N m")
PLACE = ("m", "rad")
RATE = ("m s-1", "rad s-1")
STIFFNESS = ("N m-1", "N m rad-1")
DAMPING = ("N s m-1", "N m s rad-1")

LEAST_LENGTH = 1e-100  # m, of a spring


@FORCES.add
class SpringDamper(BetweenPoints):
    """A linear spring and damper."""

    example: ClassVar[Keys] = {"stiffness": 40.0, "damping": 3.0}

    type: Literal["spring_damper"]
    stiffness: Timed = number("the stiffness in {}", "N m-1", DISSIPATIVE, effective=True)
    damping: Timed = number("the damping in {}", "N s m-1", DISSIPATIVE, effective=True, in_potential=False)
    free_length: Timed | None = number(
        "the length in {} without force", "m", SIZE, default=None, omitted="the length at the start"
    )

    @staticmethod
    def coordinates(given: Given, view: View) -> Vector:
        """The distance. Without free length it has its stiffness where that is zero, too."""
        return (length(apart(given.force, view)[2], least=LEAST_LENGTH),)

    @staticmethod
    def potential(given: Given, c: Vector) -> Number:
        free = given["free_length"]
        return quadratic(given["stiffness"], c[0] - (given.rest[0] if free is None else free))

    @staticmethod
    def effort(given: Given, c: Vector, rates: Vector, conservative: Vector) -> Vector:
        return (-(given["damping"] * rates[0]),)

    @classmethod
    def at_start(cls, force: Force, view: View) -> Vector | None:
        if force.numbers.get("free_length") is not None:
            return None
        d = apart(force, view)[2]
        return (sqrt(so3.dot(d, d)),)


@FORCES.add
class PointForce(OnPoint):
    """A force at a point."""

    example: ClassVar[Keys] = {"value": [1.5, -2.5, 3.5]}

    type: Literal["force"]
    frame: Axes = AXES
    value: Timed3 = number("the force in {}", "N", size=3, required=True)

    @staticmethod
    def effort(given: Given, c: Vector, rates: Vector, conservative: Vector) -> Vector:
        value, body = given["value"], given.view[given.force.bodies[-1]]
        return so3.rotate(body.R, value) if given.force.frame == "body" else value


@FORCES.add
class Torque(OnBody):
    """A torque."""

    velocity_level: ClassVar[bool] = True
    example: ClassVar[Keys] = {"value": [1.5, -2.5, 3.5]}

    type: Literal["torque"]
    frame: Axes = AXES
    value: Timed3 = number("the torque in {}", "N m", size=3, required=True)

    @staticmethod
    def coordinates(given: Given, view: View) -> Vector:
        """Angular velocity."""
        body = view[given.force.bodies[-1]]
        return body.w if given.force.frame == "body" else so3.rotate(body.R, body.w)

    @staticmethod
    def effort(given: Given, c: Vector, rates: Vector, conservative: Vector) -> Vector:
        value: Vector = given["value"]
        return value


@FORCES.add
class TorsionSpring(AlongJoint):
    """A linear spring and damper about an axis."""

    kinds: ClassVar[tuple[str, ...]] = ("angle",)
    otherwise: ClassVar[str] = "use an actuator (stiffness, damping, target), or a spring_damper"
    example: ClassVar[Keys] = {"stiffness": 4.0, "damping": 0.5, "free_angle": 0.3}

    type: Literal["torsion_spring"]
    stiffness: Timed = number("the stiffness in {}", "N m rad-1", DISSIPATIVE, effective=True)
    damping: Timed = number(
        "the damping in {}", "N m s rad-1", DISSIPATIVE, effective=True, in_potential=False, counts_turns=False
    )
    free_angle: Timed = number("the angle in {} without torque", "rad", counts_turns=False)

    @staticmethod
    def potential(given: Given, c: Vector) -> Number:
        return quadratic(given["stiffness"], c[0] - given["free_angle"])

    @staticmethod
    def effort(given: Given, c: Vector, rates: Vector, conservative: Vector) -> Vector:
        return (-(given["damping"] * rates[0]),)


@FORCES.add
class Actuator(AlongJoint):
    """What is prescribed, and what draws the coordinate to its target."""

    example: ClassVar[Keys] = {"stiffness": 4.0, "damping": 0.5, "target": "sin(2*t)", "limits": [-50.0, 60.0]}

    type: Literal["actuator"]
    value: Timed = number("the force in {0} or torque in {1}", EFFORT, counts_turns=False)
    stiffness: Timed = number("the gain towards the target in {}", STIFFNESS, DISSIPATIVE)
    damping: Timed = number("the gain towards the target's rate", DAMPING, DISSIPATIVE, counts_turns=False)
    target: Timed = number(
        "the angle in {1} or displacement in {0} to reach", PLACE, counts_turns=False, rate_with="damping"
    )
    limit: Timed | None = number(
        "the largest force in {0} or torque in {1}", EFFORT, SIZE, default=None, counts_turns=False
    )
    limits: Timed2 | None = number(
        "the least and the largest force in {0} or torque in {1}, instead of limit", EFFORT, default=None, size=2,
        counts_turns=False,
    )  # fmt: skip

    @staticmethod
    def effort(given: Given, c: Vector, rates: Vector, conservative: Vector) -> Vector:
        effort = given["value"] + given["stiffness"] * (given["target"] - c[0])
        effort = effort + given["damping"] * (given.rate("target") - rates[0])
        limit, limits = given["limit"], given["limits"]
        if limit is not None:
            limits = -limit, limit
        return (effort if limits is None else maximum(limits[0], minimum(limits[1], effort)),)  # NaN stays NaN

    def faults(self) -> Iterator[Problem]:
        given = self.model_fields_set
        if not given & {"value", "stiffness", "damping", "target"}:
            yield Problem(
                "",
                "has neither value nor stiffness nor damping, so it does nothing",
                "give value, or stiffness, damping and target",
            )
        if "target" in given and not given & {"stiffness", "damping"}:
            yield Problem("target", "has no effect without stiffness or damping", "give them", self.target)
        yield from faulty_limits(self.limit, self.limits)


@FORCES.add
class Friction(AlongJoint):
    """Viscous and Coulomb friction, the latter smoothed about rest; with static friction it holds at rest, as a
    constraint, and the direction in which it slides is kept."""

    example: ClassVar[Keys] = {"viscous": 0.4, "coulomb": 2.0, "velocity": 0.5}

    type: Literal["friction"]
    viscous: Timed = number("the viscous coefficient in {}", DAMPING, DISSIPATIVE, effective=True, counts_turns=False)
    coulomb: Timed = number(
        "the sliding force in {0} or torque in {1}", EFFORT, DISSIPATIVE, effective=True, counts_turns=False
    )
    velocity: Timed = number(
        "the speed in {} at which sliding sets in, above 0", RATE,
        positive("give the speed at which sliding sets in", "no friction sets in at"),
        default=1e-3, counts_turns=False,
    )  # fmt: skip
    static: Timed | None = number(
        "the force in {0} or torque in {1} up to which it sticks, at least coulomb", EFFORT, SIZE, default=None,
        counts_turns=False, omitted="it does not stick",
    )  # fmt: skip

    @staticmethod
    def effort(given: Given, c: Vector, rates: Vector, conservative: Vector) -> Vector:
        if "static" in given.force.numbers:
            mode = given.view.modes.get(("friction", given.force.name), Mode(OFF, (0.0,)))
            load = mode.memory[0]  # of what sticks: what it bears beside others that hold it
            sliding = where(mode.on > STICK, given["coulomb"] * load, where(mode.on > OFF, load, 0.0))
        else:
            sliding = given["coulomb"] * tanh(rates[0] / given["velocity"])
        return (-(given["viscous"] * rates[0] + sliding),)

    def faults(self) -> Iterator[Problem]:
        static, coulomb = constant(self.static), constant(self.coulomb)
        if self.static is None:
            return
        if self.velocity != type(self).model_fields["velocity"].default:  # which resolved scenarios have written out
            rule = "is of friction that is smooth about rest, and this one sticks"
            yield Problem("velocity", rule, "leave out either velocity or static", self.velocity)
        if "coulomb" not in self.model_fields_set:
            yield missing("coulomb", "give the force or torque with which it slides, at most static")
        elif static is not None and coulomb is not None and 0.0 <= static < coulomb:
            rule, remedy = f"must be at least coulomb = {show(self.coulomb)}", "exchange the two, or give the same"
            yield Problem("static", rule, remedy, self.static)


@FORCES.add
class EndStop(AlongJoint):
    """Springs and dampers beyond two limits."""

    example: ClassVar[Keys] = {"stiffness": 50.0, "damping": 2.0, "lower": 5.0}

    type: Literal["end_stop"]
    lower: Timed | None = number("the lower stop in {}", PLACE, default=None, counts_turns=False)
    upper: Timed | None = number("the upper stop in {}", PLACE, default=None, counts_turns=False)
    stiffness: Timed = number("the stiffness in {}", STIFFNESS, DISSIPATIVE, required=True)
    damping: Timed = number(
        "the damping in contact in {}", DAMPING, DISSIPATIVE, in_potential=False, counts_turns=False
    )

    @staticmethod
    def potential(given: Given, c: Vector) -> Number:
        """Of the penetration beyond either stop."""
        total: Number = 0.0
        for stop, outwards in (("lower", -1.0), ("upper", 1.0)):
            limit = given[stop]
            if limit is not None:
                depth = maximum(0.0, outwards * (c[0] - limit))
                total = total + quadratic(given["stiffness"], depth)
        return total

    @staticmethod
    def effort(given: Given, c: Vector, rates: Vector, conservative: Vector) -> Vector:
        """Damping only in contact, and never more than what leaves the stop without a pull."""
        push = conservative[0]
        damping = -(given["damping"] * rates[0])
        if is_zero(damping):
            return (0.0,)
        return (where(push > 0.0, maximum(-push, damping), where(push < 0.0, minimum(-push, damping), 0.0)),)

    def faults(self) -> Iterator[Problem]:
        lower, upper = constant(self.lower), constant(self.upper)
        if self.lower is None and self.upper is None:
            yield Problem("", "has no stop", "give lower, upper or both")
        elif lower is not None and upper is not None and not lower < upper:
            remedy = "exchange the two" if lower > upper else "move them apart"
            yield Problem("lower", f"must be below upper = {show(self.upper)}", remedy, self.lower)


@FORCES.add
class Bushing(BetweenPoints):
    """Springs and dampers along and about the axes of the first body. The rotation stays below half a turn: it jumps
    there."""

    example: ClassVar[Keys] = {
        "stiffness": [30.0, 20.0, 10.0], "damping": [3.0, 2.0, 1.0],
        "rotational_stiffness": [3.0, 2.0, 1.0], "rotational_damping": [0.3, 0.2, 0.1],
    }  # fmt: skip

    type: Literal["bushing"]
    stiffness: Timed3 = number("the stiffness in {}", "N m-1", DISSIPATIVE, size=3, effective=True)
    damping: Timed3 = number("the damping in {}", "N s m-1", DISSIPATIVE, size=3, effective=True, in_potential=False)
    rotational_stiffness: Timed3 = number(
        "the rotational stiffness in {}", "N m rad-1", DISSIPATIVE, size=3, effective=True
    )
    rotational_damping: Timed3 = number(
        "the rotational damping in {}", "N m s rad-1", DISSIPATIVE, size=3, effective=True, in_potential=False
    )

    @staticmethod
    def coordinates(given: Given, view: View) -> Vector:
        """Displacement of the second point, and rotation vector of the second body since the start, along the axes of
        the first body."""
        a, b, d = apart(given.force, view)
        since_start = so3.multiply(b.R, so3.transpose(given.rest))
        pose: Vector = so3.rotate_back(a.R, d) + so3.log(so3.multiply(so3.transpose(a.R), since_start))
        return pose

    @staticmethod
    def potential(given: Given, c: Vector) -> Number:
        stiffness = given["stiffness"] + given["rotational_stiffness"]
        return sum((quadratic(k, x) for k, x in zip(stiffness, c, strict=True)), 0.0)

    @staticmethod
    def effort(given: Given, c: Vector, rates: Vector, conservative: Vector) -> Vector:
        damping = given["damping"] + given["rotational_damping"]
        return tuple(-(d * rate) for d, rate in zip(damping, rates, strict=True))

    @classmethod
    def at_start(cls, force: Force, view: View) -> Vector | None:
        a, b = (view[i] for i in force.bodies)
        return so3.multiply(so3.transpose(a.R), b.R)


@FORCES.add
class Drag(OnPoint):
    """Against the velocity of a point."""

    example: ClassVar[Keys] = {"linear": 2.0, "quadratic": 0.7}

    type: Literal["drag"]
    linear: Timed = number("the linear coefficient in {}", "N s m-1", DISSIPATIVE, effective=True)
    quadratic: Timed = number("the quadratic coefficient in {}", "N s2 m-2", DISSIPATIVE, effective=True)

    @staticmethod
    def effort(given: Given, c: Vector, rates: Vector, conservative: Vector) -> Vector:
        v: Any = rates
        return so3.scale(-(given["linear"] + given["quadratic"] * sqrt(so3.dot(v, v))), v)


@FORCES.add
class PointMassGravity(BetweenPoints):
    """The attraction of a point mass, the first body's, on the whole mass of the second."""

    infinite: ClassVar[tuple[str, str]] = (
        "is infinite at the start, because its two points coincide",
        "move one of them",
    )
    example: ClassVar[Keys] = {"mu": 5.0}

    type: Literal["point_mass_gravity"]
    points: Two = Field(
        default=[ZERO, ZERO], description="two points in m, each with 3 numbers in the frame of its own body"
    )
    mu: Timed = number("the gravitational parameter of the first body in {}", "m3 s-2", DISSIPATIVE, required=True)

    @staticmethod
    def potential(given: Given, c: Vector) -> Number:
        return -(given["mu"] * given.model.bodies[given.force.bodies[1]].mass) / c[0]
