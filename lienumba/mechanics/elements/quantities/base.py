"""What quantities have in common. A type is one class: its keys, the variables that it gives, and their numbers as a
plain function of a View.

Its level says what it needs: the positions (0), the velocities (1), or the accelerations and multipliers (2), which
only an observer has. Rates are derived by jets (`lienumba.mechanics.mechanism.kinematics`).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

from pydantic import Field

from lienumba.keys.facts import facts
from lienumba.keys.registry import Registry, literal
from lienumba.keys.types import NAME_RULE, Name, Section
from lienumba.mechanics.elements.names import Names
from lienumba.mechanics.mechanism.kinematics import View
from lienumba.mechanics.mechanism.model import Model, Quantity, Timed
from lienumba.numerics.number import Number, Vector

POSITION, VELOCITY, OBSERVED = range(3)
INPUTS = "inputs"  # before the names of inputs: inputs.motor
XYZ = ("x", "y", "z")


def joined(*names: str) -> str:
    """Names with dots between them, empty ones left out."""
    return ".".join(filter(None, names))


def owner(name: str) -> tuple[str, str]:
    """What a name in a formula belongs to, a quantity, an input or a law with states, and what it is of that."""
    first, _, rest = name.partition(".")
    if first == INPUTS:
        second, _, rest = rest.partition(".")
        first = joined(first, second)
    return first, rest


def is_input(name: str) -> bool:
    """Whether what has this name is an input."""
    return name.startswith(f"{INPUTS}.")


class Part(NamedTuple):
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
    joint (3 each; `constraints.loads`), the efforts of each driver, and the forces and torques along the rows of each
    switched constraint (as `kinematics.Modes` knows it), such that a contact pushes with a positive one."""

    accelerations: list[Number]
    forces: list[Number]
    torques: list[Number]
    efforts: list[list[Number]]
    switches: dict[tuple[str, str], list[Number]] = field(default_factory=dict)


@dataclass(frozen=True)
class Refers:
    """Of a key: it names something of this list of the model, or one of the others."""

    to: str
    others: tuple[str, ...] = ()


def name_of(to: str, *others: str, **field: Any) -> Any:
    """A key that holds a name, or a list of names."""
    made = Field(**field)
    made.metadata.append(Refers(to, others))
    return made


class Readable(Section):
    """What formulas may read by a name: a quantity or an input.

    reads_coordinates: whether it is of the coordinates of its joint, whose turns count then; singular: components that
    have no derivative everywhere.
    """

    reads_coordinates: ClassVar[bool] = False
    singular: ClassVar[tuple[str, ...]] = ()

    @classmethod
    def level(cls, quantity: Quantity, component: str) -> int:
        """What a component needs to be known of the state."""
        raise NotImplementedError

    @classmethod
    def reads(cls, quantity: Quantity, component: str) -> tuple[Timed, ...]:
        """The formulas that a component depends on."""
        return (quantity.value,)

    @classmethod
    def parts(cls, model: Model, quantity: Quantity) -> tuple[Part, ...]:
        """The variables that it gives."""
        raise NotImplementedError

    @classmethod
    def rows(cls, model: Model, quantity: Quantity, view: View, observed: Observed | None) -> Vector:
        """The numbers of all parts, one after the other."""
        raise NotImplementedError

    @classmethod
    def number(cls, model: Model, quantity: Quantity, component: str, view: View, observed: Observed | None) -> Any:
        """One of them."""
        names = [name for part in cls.parts(model, quantity) for name in part.components]
        return cls.rows(model, quantity, view, observed)[names.index(component)]

    @classmethod
    def instead(cls, model: Model, quantity: Quantity) -> tuple[str, str]:
        """Why a law of positions may not read it, behind its name, and what to read instead."""
        return "a velocity, which this law may not depend on", "read positions"


class QuantityType(Readable):
    """A quantity, as a scenario describes it.

    example: values of keys that it needs beside names, for tests; rotations: keys that hold one.
    """

    example: ClassVar[Mapping[str, Any]] = {}
    rotations: ClassVar[tuple[str, ...]] = ()

    name: Name = Field(description=NAME_RULE)
    if TYPE_CHECKING:
        type: str

    @classmethod
    def references(cls) -> Mapping[str, Refers]:
        """What its keys name."""
        return facts(cls, Refers)

    @classmethod
    def sketch(cls, table: Mapping[str, Any], joints: Sequence[str], drivers: Sequence[str]) -> Quantity | None:
        """As much of it as tells its parts and their levels, from keys not yet checked; None if they do not."""
        return Quantity(str(table.get("name")), str(table["type"]), (0,))

    def to_model(self, names: Names) -> Quantity:
        """The quantity of the model."""
        raise NotImplementedError


QUANTITIES: Registry[type[QuantityType]] = Registry("quantity", literal("type"))
NOISES: Registry[type[QuantityType]] = Registry("noise", literal("type"))
INPUT_FORMS: dict[str, type[Readable]] = {}  # by the types that their quantities bear


def kind_of(quantity: Quantity) -> type[Readable]:
    """The class of a quantity, of an input or of a noise."""
    if is_input(quantity.name):
        return INPUT_FORMS[quantity.type]
    return (NOISES if quantity.type in NOISES else QUANTITIES)[quantity.type]
