"""What can be seen of a mechanism, by name: points, coordinates, attitudes, reactions, momenta, and formulas of them.

A quantity is a plain function of a View. Its level says what it needs: the positions (0), the velocities (1), or the
accelerations and multipliers (2), which only an observer has. Rates are derived by jets
(`lienumba.mechanics.mechanism.kinematics`). A formula that reads quantities, or the states of laws, is evaluated here,
too.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

from lienumba.groups import so3
from lienumba.mechanics.elements import joints
from lienumba.mechanics.mechanism import kinematics
from lienumba.mechanics.mechanism.kinematics import Instant, View
from lienumba.mechanics.mechanism.model import GROUND, Coordinate, Law, Model, Quantity, Timed, reads_state
from lienumba.numerics.expressions import WITHIN, Formula
from lienumba.numerics.jets import lift
from lienumba.numerics.operations import sqrt

POSITION, VELOCITY, OBSERVED = range(3)
SQUARE_FLOOR = 1e-200  # so that an angle of zero has a rate
XYZ = ("x", "y", "z")
COORDINATE_OF = {"angle": "angle", "rate": "angle", "displacement": "displacement", "speed": "displacement"}
UNITS = {"angle": "rad", "rate": "rad s-1", "displacement": "m", "speed": "m s-1"}
OF_POINT = (("m", "position"), ("m s-1", "velocity"), ("m s-2", "acceleration"))

Rows = tuple[Any, ...]


def joined(*names: str) -> str:
    """Names with dots between them, empty ones left out."""
    return ".".join(filter(None, names))


@dataclass(frozen=True)
class Part:
    """One variable that a quantity gives: a number, or a vector of three. name: behind that of the quantity, or "";
    frame: the body along whose axes a vector is given, GROUND for the global frame."""

    name: str
    units: str
    long_name: str
    vector: bool = False
    frame: int | None = None

    @property
    def components(self) -> tuple[str, ...]:
        """As formulas call them, behind the name of the quantity."""
        return tuple(joined(self.name, n) for n in (XYZ if self.vector else ("",)))


@dataclass(frozen=True)
class Observed:
    """What is known of a state beside positions and velocities: accelerations (6 per body), force and torque of every
    joint (3 each; `constraints.loads`), and the efforts of each driver."""

    accelerations: list[Any]
    forces: list[Any]
    torques: list[Any]
    efforts: list[list[Any]]


@dataclass(frozen=True)
class QuantityType:
    """parts(model, quantity); rows(model, quantity, view, observed): the numbers of all parts, one after the other."""

    level: Callable[[Quantity], int]
    parts: Callable[[Model, Quantity], tuple[Part, ...]]
    rows: Callable[[Model, Quantity, View, Observed | None], Rows]


# ---------------------------------------------------------------- laws that read quantities
def evaluate(model: Model, x: Timed, view: View, observed: Observed | None = None) -> Any:
    """The number that a timed number is in a view."""
    if not callable(x):
        return x
    if isinstance(x, Formula):
        return x(view.t) if view.within is None else x(view.t, **{WITHIN: (view.within, frozenset())})
    if not isinstance(x, Law):
        return x(view.t)
    read = {name: component(model, name, view, observed) for name in x.quantities}
    return x(view.t, **read) if view.within is None else x(view.t, **read, **{WITHIN: (view.within, frozenset(read))})


def component(model: Model, name: str, view: View, observed: Observed | None = None) -> Any:
    """One number of a quantity, or a state of a law, by its name in formulas: "pointing.x", "pid.integral"."""
    first, _, rest = name.partition(".")
    quantity = _named(model, first)
    if quantity is None:
        force = next(f for f in model.forces if f.name == first)
        states = view.states.get(first, tuple(force.initial.values()))
        return states[list(force.initial).index(rest)]
    return rows(model, quantity, view, observed)[components(model, quantity).index(rest)]


def rows(model: Model, quantity: Quantity, view: View, observed: Observed | None = None) -> Rows:
    """All numbers of a quantity, part by part."""
    return QUANTITY_TYPES[quantity.type].rows(model, quantity, view, observed)


def parts(model: Model, quantity: Quantity) -> tuple[Part, ...]:
    """The variables that it gives."""
    return QUANTITY_TYPES[quantity.type].parts(model, quantity)


def components(model: Model, quantity: Quantity) -> list[str]:
    """The names of its numbers, behind its own."""
    return [name for part in parts(model, quantity) for name in part.components]


def observe(model: Model, now: Instant, observed: Observed) -> Iterator[tuple[str, list[Any]]]:
    """The rows of every variable that quantities give, by its name."""
    everything = kinematics.still(now, tuple(range(len(model.bodies))))
    for quantity in model.quantities:
        numbers = list(rows(model, quantity, everything, observed))
        for part in parts(model, quantity):
            size = len(part.components)
            yield joined(quantity.name, part.name), numbers[:size]
            numbers = numbers[size:]


def conditions(model: Model, now: Instant, observed: Observed | None) -> list[Any]:
    """Whether the condition of each event holds, 1 or 0."""
    everything = kinematics.still(now, tuple(range(len(model.bodies))))
    return [evaluate(model, event.when, everything, observed) for event in model.events]


def bodies_of(model: Model, *numbers: Timed) -> tuple[int, ...]:
    """The bodies (indices) whose motion these numbers read."""
    found: dict[int, None] = {}
    for x in numbers:
        for name in x.quantities if isinstance(x, Law) else ():
            quantity = _named(model, name.partition(".")[0])
            if quantity is None:
                continue
            ends = (*quantity.bodies, quantity.relative_to, quantity.frame)
            if quantity.joint >= 0:
                ends += model.joints[quantity.joint].bodies
            found |= dict.fromkeys((*ends, *bodies_of(model, quantity.value)))
    return tuple(i for i in found if i != GROUND)


def angle_joints(model: Model) -> set[int]:
    """The joints (indices) of which a quantity is the angle, over several turns."""
    of_joints = {q.joint for q in model.quantities if q.type == "joint"}
    return {j for j in of_joints if "angle" in joints.coordinate_kinds(model.joints[j].type)}


# ---------------------------------------------------------------- types
def _always(level: int) -> Callable[[Quantity], int]:
    return lambda quantity: level


def _along(quantity: Quantity, view: View, v: Any) -> Any:
    """A global vector along the axes of the quantity's frame."""
    return so3.rotate_back(view[quantity.frame].R, v)


def _turning_parts(model: Model, quantity: Quantity) -> tuple[Part, ...]:
    return (Part("", "rad s-1", "angular velocity", vector=True, frame=quantity.frame),)


def _point_parts(model: Model, quantity: Quantity) -> tuple[Part, ...]:
    units, what = OF_POINT[quantity.derivative]
    return (Part("", units, f"{what} of a point", vector=True, frame=quantity.frame),)


def _point(model: Model, quantity: Quantity, view: View, observed: Observed | None) -> Rows:
    """Position of the point as seen from a body, or a derivative of it, there; then along the axes of the frame."""

    def seen(at: View) -> Any:
        base = at[quantity.relative_to]
        return so3.rotate_back(base.R, so3.subtract(at[quantity.bodies[0]].point(quantity.point), base.r))

    if quantity.derivative == 0:
        p = seen(view)
    else:
        jets = seen(kinematics.moving(view, observed.accelerations if observed and quantity.derivative == 2 else None))
        p = tuple(lift(x).b if quantity.derivative == 1 else lift(x).c for x in jets)
    if quantity.frame == quantity.relative_to:
        return tuple(p)
    return tuple(_along(quantity, view, so3.rotate(view[quantity.relative_to].R, p)))


def _joint_parts(model: Model, quantity: Quantity) -> tuple[Part, ...]:
    kinds = joints.coordinate_kinds(model.joints[quantity.joint].type)
    return tuple(
        Part(name, UNITS[name], f"{name} of the joint {model.joints[quantity.joint].name}")
        for name, kind in COORDINATE_OF.items()
        if kind in kinds
    )


def _joint(model: Model, quantity: Quantity, view: View, observed: Observed | None) -> Rows:
    found: list[Any] = []
    for part in _joint_parts(model, quantity):
        which = Coordinate(quantity.joint, COORDINATE_OF[part.name])
        is_rate = part.name in ("rate", "speed")
        x = joints.coordinate(model, which, kinematics.moving(view) if is_rate else view)
        found.append(lift(x).b if is_rate else x)
    return tuple(found)


def _rotation_error_parts(model: Model, quantity: Quantity) -> tuple[Part, ...]:
    return (
        Part("", "rad", "rotation vector from the target to the body", vector=True, frame=quantity.bodies[0]),
        Part("angle", "rad", "angle between the target and the body"),
    )


def _rotation_error(model: Model, quantity: Quantity, view: View, observed: Observed | None) -> Rows:
    """log(R_target^T R), R_target being given in the frame of `relative_to`; the same along the axes of both."""
    assert quantity.target is not None
    target = so3.multiply(view[quantity.relative_to].R, quantity.target)
    e = so3.log(so3.multiply(so3.transpose(target), view[quantity.bodies[0]].R))
    return (*e, sqrt(so3.dot(e, e) + SQUARE_FLOOR))


def _angular_velocity(model: Model, quantity: Quantity, view: View, observed: Observed | None) -> Rows:
    body, base = view[quantity.bodies[0]], view[quantity.relative_to]
    if quantity.frame == quantity.bodies[0] and quantity.relative_to == GROUND:
        return tuple(body.w)
    relative = so3.subtract(so3.rotate(body.R, body.w), so3.rotate(base.R, base.w))
    return tuple(_along(quantity, view, relative))


def _reaction(model: Model, quantity: Quantity, view: View, observed: Observed | None) -> Rows:
    assert observed is not None
    own = slice(3 * quantity.joint, 3 * quantity.joint + 3)
    return (*_along(quantity, view, observed.forces[own]), *_along(quantity, view, observed.torques[own]))


def _reaction_parts(model: Model, quantity: Quantity) -> tuple[Part, ...]:
    of = f"of the joint {model.joints[quantity.joint].name} on its second body"
    return (
        Part("force", "N", f"force {of}, at its point", vector=True, frame=quantity.frame),
        Part("torque", "N m", f"torque {of}, about its point", vector=True, frame=quantity.frame),
    )


def _effort_parts(model: Model, quantity: Quantity) -> tuple[Part, ...]:
    driver = model.drivers[quantity.driver]
    said = f"effort of the driver {driver.name}"
    if driver.coordinate is not None:
        return (Part("", "N" if driver.coordinate.kind == "displacement" else "N m", said),)
    of_body = driver.motion == "orientation" or (driver.motion == "angular_velocity" and driver.frame == "body")
    frame = driver.bodies[-1] if of_body else GROUND
    return (Part("", "N" if driver.motion == "point" else "N m", said, vector=True, frame=frame),)


def _effort(model: Model, quantity: Quantity, view: View, observed: Observed | None) -> Rows:
    assert observed is not None
    return tuple(observed.efforts[quantity.driver])


def _momentum_parts(model: Model, quantity: Quantity) -> tuple[Part, ...]:
    about = "the mass centre" if quantity.about is None else "a point"
    return (
        Part("linear", "kg m s-1", "linear momentum", vector=True, frame=GROUND),
        Part("angular", "kg m2 s-1", f"angular momentum about {about}", vector=True, frame=GROUND),
    )


def _momentum(model: Model, quantity: Quantity, view: View, observed: Observed | None) -> Rows:
    linear: Any = kinematics.AT_REST
    moment: Any = kinematics.AT_REST
    mass, about, moving = 0.0, quantity.about, kinematics.AT_REST
    for i in quantity.bodies:
        linear = so3.axpy(model.bodies[i].mass, view[i].v, linear)
        moment = so3.axpy(model.bodies[i].mass, view[i].r, moment)
        mass = mass + model.bodies[i].mass
    if about is None:
        about, moving = so3.scale(1.0 / mass, moment), so3.scale(1.0 / mass, linear)
    angular: Any = kinematics.AT_REST
    for i in quantity.bodies:
        m = view[i]
        spin = so3.rotate(m.R, kinematics.inertia_times(model.bodies[i].inertia, m.w))
        arm, v = so3.subtract(m.r, about), so3.subtract(m.v, moving)
        angular = so3.add(angular, so3.axpy(model.bodies[i].mass, so3.cross(arm, v), spin))
    return (*linear, *angular)


def _expression_parts(model: Model, quantity: Quantity) -> tuple[Part, ...]:
    return (Part("", quantity.units, "formula"),)


def _expression(model: Model, quantity: Quantity, view: View, observed: Observed | None) -> Rows:
    return (evaluate(model, quantity.value, view, observed),)


QUANTITY_TYPES: dict[str, QuantityType] = {
    "point": QuantityType(lambda quantity: quantity.derivative, _point_parts, _point),
    "joint": QuantityType(_always(VELOCITY), _joint_parts, _joint),
    "rotation_error": QuantityType(_always(POSITION), _rotation_error_parts, _rotation_error),
    "angular_velocity": QuantityType(_always(VELOCITY), _turning_parts, _angular_velocity),
    "reaction": QuantityType(_always(OBSERVED), _reaction_parts, _reaction),
    "driver_effort": QuantityType(_always(OBSERVED), _effort_parts, _effort),
    "momentum": QuantityType(_always(VELOCITY), _momentum_parts, _momentum),
    "expression": QuantityType(_always(POSITION), _expression_parts, _expression),
}


def _named(model: Model, name: str) -> Quantity | None:
    return next((q for q in model.quantities if q.name == name), None)


def level(model: Model, name: str) -> int:
    """What a component needs to be known of the state; of an expression, what all in it need. States of laws can be
    differentiated no more than velocities."""
    first, _, rest = name.partition(".")
    quantity = _named(model, first)
    if quantity is None:
        return VELOCITY
    if quantity.type == "joint":
        return VELOCITY if rest in ("rate", "speed") else POSITION
    own = QUANTITY_TYPES[quantity.type].level(quantity)
    inner = quantity.value.quantities if reads_state(quantity.value) else ()
    return max([own, *(level(model, x) for x in inner)])
