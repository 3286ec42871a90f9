"""A mechanism as data: bodies, joints, drivers, forces, gravity, and what is known of the initial state.

A *number* is a float, an array of shape (runs,) where a sweep varies it, or where the field says so a function of
time (anything that is called with t), or of time and state (a `Law`).
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import wraps
from typing import Any, TypeVar
from weakref import ref

T = TypeVar("T")

GROUND = -1
HELD = "held"  # the states that held numbers are
EVENT_TIME = "event_time"  # before the name of an event: the held number that is its latest time, NOT_YET before it
NOT_YET = -1.0

Number = Any  # float | numpy.ndarray of shape (runs,) | Symbol | Jet: whatever the kernels compute with
Timed = Any  # a Number or a function of time
Vec3 = tuple[Number, Number, Number]
Matrix3 = tuple[Number, ...]  # nine numbers, row major
Frame = tuple[Vec3, Vec3, Vec3]  # x (reference), y, z (axis): orthonormal, in a body's own frame


def time(t: Any) -> Any:
    """The time itself, as a timed number."""
    return t


def at_time(x: Timed, t: Any) -> Any:
    """The number that a timed number is at time t."""
    return x(t) if callable(x) else x


@dataclass(frozen=True)
class Law:
    """A function of time that has numbers and tables of its own, and may read the state: function(t, **numbers,
    **quantities).

    quantities: the components that it reads, such as "pointing.x"; `lienumba.mechanics.elements.quantities` evaluates
    them.
    """

    function: Callable[..., Any]
    numbers: dict[str, Any]
    quantities: tuple[str, ...] = ()

    def __call__(self, t: Any, **quantities: Any) -> Any:
        return self.function(t, **self.numbers, **quantities)


def reads_state(x: Timed) -> bool:
    """Whether a timed number depends on more than the time."""
    return isinstance(x, Law) and bool(x.quantities)


@dataclass(frozen=True)
class Code:
    """A law of the user's own (`lienumba.mechanics.elements.user_laws`).

    returns: "loads" or "potential" of a force, one letter for each row of a joint ("m" for a length, "r" for an angle);
    level: of these, "position" or "velocity"; joints: those that it sees; names: the arguments that are its bodies and
    joints, none if it takes any number of them; wants: of t, states, memory and interval what the function asks for;
    quantities: those that it asks for; states: their names; memory: the sizes of its arrays, by name; every: the
    interval (s) of a sampled law; untraced: the names of the functions that it calls and that are not traced, which
    have no derivatives.
    """

    function: Callable[..., Any]
    returns: str
    level: str = "position"
    joints: tuple[int, ...] = ()
    names: tuple[str, ...] = ()
    wants: frozenset[str] = frozenset()
    quantities: frozenset[str] = frozenset()
    states: tuple[str, ...] = ()
    memory: tuple[tuple[str, int], ...] = ()
    every: float | None = None
    untraced: tuple[str, ...] = ()

    @property
    def kept(self) -> int:
        """How many numbers its states and its memory have."""
        return len(self.states) + sum(size for _, size in self.memory)


@dataclass(frozen=True)
class Body:
    """A rigid body. `inertia` holds xx yy zz xy xz yz of the tensor, about the mass centre, body frame."""

    name: str
    mass: Number
    inertia: tuple[Number, ...]


@dataclass(frozen=True)
class Coordinate:
    """A coordinate of a joint (index), by its name: "angle" (rad), "displacement" (m), or another that its type has."""

    joint: int
    kind: str

    @property
    def counted(self) -> "Counted":
        """By what its turns are known."""
        return self.joint if self.kind == "angle" else self


Counted = int | Coordinate  # the angle of a joint (index), or another coordinate that counts turns


def coordinate_of(which: Counted) -> Coordinate:
    """The reverse of `Coordinate.counted`."""
    return Coordinate(which, "angle") if isinstance(which, int) else which


@dataclass(frozen=True)
class Joint:
    """A joint between two bodies (indices, GROUND = -1); `points` and `frames` are given in each body's own frame.

    frames: x counts the angle, z is the axis; None where the type has no axis, or as long as the start has not
    decided it. A gear or coupler joins two coordinates instead, and its `bodies` are those of both joints, without
    repetition. numbers: by name, those of its own; None as long as the start has not decided them. armature: of a rotor
    with the kinetic energy armature/2 rate^2 (kg m^2 or kg), the rate being that of the type's `rotor`. way: of the
    second axis along the first, 1 or -1, where the joint makes them parallel and who integrates it wants to know.
    active: whether it holds from the start on; switched: whether a run may turn it on and off. One that is neither has
    no equations.
    """

    name: str
    type: str
    bodies: tuple[int, ...]
    points: tuple[Vec3, Vec3] | None = None
    frames: tuple[Frame, Frame] | None = None
    coordinates: tuple[Coordinate, Coordinate] | None = None
    numbers: dict[str, Number] = field(default_factory=dict)
    code: Code | None = None
    armature: Number = 0.0
    way: Number = 1.0
    active: bool = True
    switched: bool = False


@dataclass(frozen=True)
class Driver:
    """A prescribed motion of a joint's coordinate, or of a body.

    motion: "value" or "rate" (of `coordinate`; one number), "point" (global position of `point`; 3), "orientation"
    (rotation vector from body to global; 3), "angular_velocity" (in `frame`, "global" or "body"; 3).
    """

    name: str
    motion: str
    bodies: tuple[int, ...]
    value: tuple[Timed, ...]
    coordinate: Coordinate | None = None
    point: Vec3 | None = None
    frame: str = "global"


@dataclass(frozen=True)
class Force:
    """A force law on bodies; see `lienumba.mechanics.elements.forces` for the types and the numbers that each has.

    rest: what the start decides where it is omitted (a free length; the relative rotation of a bushing, 9 numbers);
    contact: which it is, where it yields.
    """

    name: str
    type: str
    bodies: tuple[int, ...]
    points: tuple[Vec3, ...] = ()
    coordinate: Coordinate | None = None
    frame: str = "global"
    numbers: dict[str, Timed] = field(default_factory=dict)  # a tuple for a vector
    rest: tuple[Number, ...] | None = None
    code: Code | None = None
    initial: dict[str, Number] = field(default_factory=dict)  # of the states of a law of the user's own
    contact: "Contact | None" = None


@dataclass(frozen=True)
class Quantity:
    """Something that can be seen of the mechanism; see `lienumba.mechanics.elements.quantities` for the types. An input
    is one, too: its name begins with "inputs."; what it keeps in a state is that of a force of this name.

    bodies: what it is about; point: in the first body's frame; derivative: of the position of a point, 0, 1 or 2;
    relative_to: the body from which it is seen; frame: the body along whose axes it is given; target: rotation;
    joint, driver: indices; coordinate: that of the joint which an input asks for; about: the point (global) of a
    moment, None for the mass centre; value: of an expression; points: of its bodies; of: the contact or limit that it
    is about, by its name; numbers: others that a type needs.
    """

    name: str
    type: str
    bodies: tuple[int, ...] = ()
    point: Vec3 = (0.0, 0.0, 0.0)
    derivative: int = 0
    relative_to: int = GROUND
    frame: int = GROUND
    target: Matrix3 | None = None
    joint: int = -1
    coordinate: Coordinate | None = None
    driver: int = -1
    about: Vec3 | None = None
    value: Timed = 0.0
    units: str = "1"
    points: tuple[Vec3, ...] = ()
    of: str = ""
    numbers: dict[str, Timed] = field(default_factory=dict)  # a tuple for a vector


@dataclass(frozen=True)
class Lock:
    """Of coordinates of a joint (index), by their names: while it is on, they stay as they were when it was locked.
    on: whether it is from the start."""

    name: str
    joint: int
    coordinates: tuple[str, ...]
    on: bool = False


@dataclass(frozen=True)
class Limit:
    """A rigid stop on a coordinate: side * (coordinate - value) >= 0; side: 1 of a lower stop, -1 of an upper one.
    restitution: 0 to 1; rest_speed: (m/s or rad/s) of a rebound below which there is none, None: see `scales`."""

    name: str
    coordinate: Coordinate
    side: float
    value: Number
    restitution: Number = 0.0
    rest_speed: Number | None = 0.0


@dataclass(frozen=True)
class Contact:
    """Of two bodies (indices) that may touch; see `lienumba.mechanics.elements.contacts` for the types and the numbers
    of each. points, in each body's own frame; normal: in the second body's, axis: in the first body's, where the type
    has one; static, kinetic: coefficients of Coulomb friction."""

    name: str
    type: str
    bodies: tuple[int, int]
    points: tuple[Vec3, Vec3]
    normal: Vec3 | None = None
    axis: Vec3 | None = None
    numbers: dict[str, Number] = field(default_factory=dict)
    restitution: Number = 0.0
    static: Number = 0.0
    kinetic: Number = 0.0
    rest_speed: Number | None = 0.0


@dataclass(frozen=True)
class Event:
    """Something that happens when a condition becomes true; stop: whether the run ends there.

    action: by its name; joint: which it releases or engages, locks: which it turns on or off (indices); values: what
    held numbers (by their place in `Model.held`) become; once: whether it acts once in a run; closing: by how much (m
    or rad) the rows of the joint that it engages may be violated; clock: the place of the held number that is its
    latest time (s), -1 if nothing reads it.
    """

    name: str
    when: Timed
    stop: bool
    action: str = "record"
    joint: int = -1
    locks: tuple[int, ...] = ()
    values: tuple[tuple[int, Timed], ...] = ()
    once: bool = False
    closing: Number | None = None
    clock: int = -1

    @property
    def acts(self) -> bool:
        """Whether the mechanism changes."""
        return self.joint >= 0 or self.clock >= 0 or bool(self.locks or self.values)

    @property
    def numbers(self) -> tuple[Timed, ...]:
        """What its action reads where it happens."""
        own = tuple(x for _, x in self.values) + (() if self.closing is None else (self.closing,))
        return own + ((time,) if self.clock >= 0 else ())


LARGEST, SMALLEST, INTEGRAL, FIRST, LAST, COUNT = "largest", "smallest", "integral", "first", "last", "count"
KEPT = (LARGEST, SMALLEST, INTEGRAL, FIRST, LAST, COUNT)
NONE = -1  # no signal


@dataclass(frozen=True)
class Kept:
    """What is kept of a signal while another one, a condition, is above 0 (both by their numbers, NONE for 1 and for
    always), with a time (s): the LARGEST or SMALLEST value and when it is that; the INTEGRAL, and over how long; the
    FIRST or LAST value, and when; the COUNT of how often the condition becomes true. event: the name of the event that
    is meant by the condition, at which the value is taken instead."""

    kind: str
    value: int
    condition: int
    event: str = ""


@dataclass(frozen=True)
class Measure:
    """What a run is asked for as a whole: signals, numbers of the state, and what is kept of them."""

    signals: tuple[Timed, ...]
    kept: tuple[Kept, ...]


@dataclass(frozen=True)
class Model:
    """held: numbers that events may change, by their names, as they are at the start; laws read them as
    "held.name"."""

    gravity: tuple[Timed, Timed, Timed]
    bodies: tuple[Body, ...]
    joints: tuple[Joint, ...] = ()
    drivers: tuple[Driver, ...] = ()
    forces: tuple[Force, ...] = ()
    quantities: tuple[Quantity, ...] = ()
    events: tuple[Event, ...] = ()
    locks: tuple[Lock, ...] = ()
    limits: tuple[Limit, ...] = ()
    contacts: tuple[Contact, ...] = ()
    held: dict[str, Number] = field(default_factory=dict)
    measures: tuple[Measure, ...] = ()


@dataclass(frozen=True)
class Pose:
    """The initial state of one body. None, or what `guess` marks, is solved for from the joints.

    position, velocity: mass centre, global frame; rotation: body to global, row major; angular_velocity: body frame.
    relative_to: the body (index) in whose frame all four are given instead (angular_velocity: in the own body frame).
    guess: where the solution starts for what is omitted, in the same terms.
    """

    position: Vec3 | None = None
    rotation: Matrix3 | None = None
    velocity: Vec3 | None = None
    angular_velocity: Vec3 | None = None
    relative_to: int | None = None
    guess: "Pose | None" = None


@dataclass(frozen=True)
class JointStart:
    """How a joint is placed, and what is known of its coordinates at the start.

    known: by the name of a coordinate, or of its rate; places: where these are said, where that is not a key of the
    joint.

    Either `axes` (a pair, in each body's own frame; a type that needs one axis takes the first) or `axis` (global, at
    the start; a pair for universal and perpendicular axes); `at` (global, at the start) instead of the joint's points.
    """

    axes: tuple[Vec3, Vec3] | None = None
    references: tuple[Vec3, Vec3] | None = None
    at: Vec3 | None = None
    axis: tuple[Vec3, ...] | None = None
    known: dict[str, Number] = field(default_factory=dict)
    places: dict[str, str] = field(default_factory=dict)

    def place(self, joint: str, name: str) -> str:
        """Where the scenario says this of a joint."""
        return self.places.get(name, f"model.joints.{joint}.{name}")


@dataclass(frozen=True)
class Start:
    """What a scenario says of the initial state: one entry per body, one per joint; rotation: the angular velocity
    (rad/s, global) of the axes against which it is to be in equilibrium, None where it is as given."""

    poses: tuple[Pose, ...]
    joints: tuple[JointStart, ...]
    rotation: Vec3 | None = None


_followed: dict[int, tuple["ref[Model]", dict[object, Any]]] = {}  # by the identity of a model, while there is one


def once_per_model(function: Callable[[Model], T]) -> Callable[[Model], T]:
    """The function, computed once for each model, which nobody changes; nobody may change what it returns either."""

    @wraps(function)
    def remembered(model: Model) -> T:
        key = id(model)
        if key not in _followed:
            _followed[key] = ref(model, lambda _: _followed.pop(key, None)), {}
        found = _followed[key][1]
        if function not in found:
            found[function] = function(model)
        value: T = found[function]
        return value

    return remembered
