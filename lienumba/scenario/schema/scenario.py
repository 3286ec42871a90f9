"""The scenario as data: which keys exist, their types, units and defaults.

What one key says about another (names, step and interval, rotations) is in `checks`. A key's description is
also the remedy in its error messages, which read "give <description>".
"""

from collections.abc import Iterator
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Discriminator, Field, Tag, WithJsonSchema, create_model

from lienumba.errors import BadValueError, Problem
from lienumba.integrators.methods import DEFAULT, DEFAULT_PAIR, METHODS
from lienumba.integrators.methods.charts import GROUPS, JOINT
from lienumba.integrators.methods.comparators import COORDINATES
from lienumba.integrators.methods.generalized_alpha import DAMPING, GENERALIZED_ALPHA
from lienumba.integrators.methods.taylor import HIGHEST, LOWEST, TAYLOR
from lienumba.keys.choices import NameOf, OneOf
from lienumba.keys.types import (
    NAME_RULE,
    WRITTEN,
    Count,
    Inertia,
    Name,
    Number,
    Positive,
    Rotation,
    Section,
    Timed3,
    Vec3,
)
from lienumba.mechanics.elements.contacts import CONTACTS
from lienumba.mechanics.elements.contacts.base import ContactType
from lienumba.mechanics.elements.drivers import DRIVERS, DriverType, driver_form
from lienumba.mechanics.elements.events import Event
from lienumba.mechanics.elements.forces import FORCES
from lienumba.mechanics.elements.forces.base import ForceLaw
from lienumba.mechanics.elements.inputs import AnyInput
from lienumba.mechanics.elements.joints import JOINTS, JointType
from lienumba.mechanics.elements.limits import Limit
from lienumba.mechanics.elements.noise import NoiseType
from lienumba.mechanics.elements.quantities import NOISES, QUANTITIES
from lienumba.mechanics.elements.quantities.base import QuantityType
from lienumba.mechanics.system.projection import WEIGHTS
from lienumba.scenario.schema.output import Output
from lienumba.scenario.schema.requirements import Measure, Requirement
from lienumba.scenario.schema.shapes import SHAPES, AnyShapes
from lienumba.scenario.schema.sweep import Sweep
from lienumba.scenario.schema.tables import TableSection
from lienumba.words import listed


def _not_negative(mass: float) -> float:
    if mass < 0.0:
        raise BadValueError("must be above 0", "give the mass in kg, above 0")
    return mass


Mass = Annotated[Number, AfterValidator(_not_negative), WithJsonSchema({**WRITTEN, "minimum": 0})]


class Matter(Section):
    """Without mass, a body has no inertia either."""

    name: Name = Field(description=NAME_RULE)
    mass: Mass = Field(description="the mass in kg, above 0")
    inertia: Inertia | None = Field(
        default=None,
        description="the inertia in kg m^2 about the mass centre in the body frame: 3 principal moments, "
        "the 6 elements xx yy zz xy xz yz of the tensor, or its 3x3 matrix",
    )


class StartState(Section):
    """Of one body; with relative_to: in the frame of that body, and relative to its motion."""

    position: Vec3 | None = Field(
        default=None,
        description="the mass centre in m, global frame: 3 numbers (or omit it: solved from the joints)",
    )
    rotation: Rotation | None = Field(
        default=None,
        description="the rotation from the body to the global frame: a quaternion [w, x, y, z], a 3x3 "
        'matrix, {axis, angle}, {euler = "ZYX", angles} or {rotation_vector}, in rad '
        "(or omit it: solved from the joints)",
    )
    velocity: Vec3 | None = Field(
        default=None,
        description="the velocity of the mass centre in m/s, global frame: 3 numbers "
        "(or omit it: solved from the joints)",
    )
    angular_velocity: Vec3 | None = Field(
        default=None,
        description="the angular velocity in rad/s, body frame: 3 numbers (or omit it: solved from the joints)",
    )


class Body(StartState, Matter):
    relative_to: str | None = Field(
        default=None,
        description="the name of the body in whose frame position, rotation and velocities are given; "
        "omitted velocities move with it",
    )
    guess: StartState | None = Field(
        default=None,
        description="where to start for what is omitted: position, rotation, velocity, angular_velocity, not held",
    )
    shapes: AnyShapes | None = Field(
        default=None,
        description=f"how it looks: a list of {{ type = ..., ... }}, of {', '.join(SHAPES)} (or omit it: the box or "
        "cylinder that has its inertia)",
    )


class Gravity(Section):
    gravity: Timed3 = Field(default=[0.0, 0.0, -9.81], description="the acceleration of gravity in m/s^2: 3 numbers")


class Standing(Section):
    ground_shapes: AnyShapes | None = Field(
        default=None, description="shapes that stand still, each as [[model.ground_shapes]], in the global frame"
    )


OneOrMore = Annotated[
    Annotated[Number, Tag("number")] | Annotated[list[Number], Tag("list")],
    Discriminator(lambda value: "list" if isinstance(value, list | tuple) else "number"),
]


EQUILIBRIUM = "equilibrium"
_FROM: Any = (
    Literal["equilibrium"] | None,
    Field(default=None, description=f'"{EQUILIBRIUM}": each run starts where it rests (or omit it: as given)'),
)


class StartSection(create_model("From", __base__=Section, **{"from": _FROM})):  # type: ignore[misc]  # a keyword
    """What is known of the coordinates of joints at the start, over what the joints say themselves."""

    rotation: Vec3 | None = Field(
        default=None,
        description="the angular velocity in rad/s, global frame, with which all turns in equilibrium: 3 numbers (or "
        "omit it: all rests)",
    )
    q: dict[str, OneOrMore] = Field(
        default={},
        description='coordinates by their names, in rad or m: { elbow = 0.3, "piston.angle" = 0.1 }, or all of a joint '
        "in a list",
    )
    qd: dict[str, OneOrMore] = Field(default={}, description="their rates in rad/s or m/s, likewise: { elbow = 1.0 }")
    file: str | None = Field(
        default=None, description="a dataset with q and qd, from which those are taken that are not given here"
    )
    run: int | None = Field(default=None, description="the label of its run (or omit it: the first)")
    time: Number | None = Field(default=None, description="a stored time of it in s (or omit it: the last)")

    def faults(self) -> Iterator[Problem]:
        """The velocities of an equilibrium are its own."""
        if self.resting and self.qd:
            rule = "has no meaning where each run starts in its equilibrium, whose velocities follow"
            yield Problem("qd", rule, "leave it out, or give start.rotation instead", self.qd)
        if self.rotation is not None and not self.resting:
            rule = "has no meaning without an equilibrium"
            yield Problem("rotation", rule, 'give from = "equilibrium"', self.rotation)

    @property
    def resting(self) -> bool:
        """Whether runs start in their equilibria."""
        return getattr(self, "from") is not None


AnyJoint = Annotated[JointType, OneOf(JOINTS)]
AnyDriver = Annotated[DriverType, OneOf(DRIVERS, driver_form)]


class ModelSection(Standing, Gravity):
    bodies: Annotated[list[Body], Field(min_length=1)] = Field(
        description="at least one body, each as [[model.bodies]]"
    )
    joints: list[AnyJoint] = Field(default=[], description="the joints, each as [[model.joints]]")
    drivers: list[AnyDriver] = Field(default=[], description="prescribed motions, each as [[model.drivers]]")
    forces: list[Annotated[ForceLaw, OneOf(FORCES)]] = Field(
        default=[], description="force laws, each as [[model.forces]]"
    )
    limits: list[Limit] = Field(default=[], description="rigid stops of joints, each as [[model.limits]]")
    contacts: list[Annotated[ContactType, OneOf(CONTACTS)]] = Field(
        default=[], description="where bodies may touch, each as [[model.contacts]]"
    )
    quantities: list[Annotated[QuantityType, OneOf(QUANTITIES)]] = Field(
        default=[], description="named quantities, each as [[quantities]]"
    )
    noise: list[Annotated[NoiseType, OneOf(NOISES)]] = Field(
        default=[], description="random courses that each run has of its own, each as [[noise]]"
    )
    events: list[Event] = Field(default=[], description="what is to be noticed, each as [[events]]")
    measures: list[Measure] = Field(default=[], description="numbers of whole runs, each as [[measures]]")
    requirements: list[Requirement] = Field(default=[], description="what runs shall do, each as [[requirements]]")
    inputs: dict[str, AnyInput] = Field(
        default={},
        description="what comes from outside, by name: motor = 12.0, a formula in quotes, or a table with file, time "
        "and value, with joint, kp, kd and target, or with rate",
    )
    start: StartSection | None = Field(default=None, description="the section [start]")


DexpInv = Annotated[
    Annotated[Literal["closed"], Tag("name")] | Annotated[int, Field(strict=True, ge=0, le=10), Tag("terms")],
    Discriminator(lambda value: "name" if isinstance(value, str) else "terms"),
]


Error = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=1e-14, le=0.1), WithJsonSchema(WRITTEN)]


class Absolute(Section):
    """Errors for which size does not count; omitted: those of `Tolerance.relative`, of 1 in SI units."""

    position: Positive | None = Field(default=None, description="the error of a position in m, above 0")
    rotation: Positive | None = Field(default=None, description="the error of a rotation in rad, above 0")
    velocity: Positive | None = Field(default=None, description="the error of a velocity in m/s, above 0")
    angular_velocity: Positive | None = Field(
        default=None, description="the error of an angular velocity in rad/s, above 0"
    )
    state: Positive | None = Field(
        default=None, description="the error of a state of a law, and of the work in J, above 0"
    )


class Tolerance(Section):
    """Of the error of one step: absolute plus relative times the size; rotations have no size."""

    relative: Error = Field(description="the error of a step relative to the size, from 1e-14 to 0.1")
    absolute: Absolute = Field(
        default_factory=Absolute,
        description="{ position = ..., rotation = ..., velocity = ..., angular_velocity = ..., state = ... }",
    )


AnyTolerance = Annotated[
    Annotated[Error, Tag("number")] | Annotated[Tolerance, Tag("table")],
    Discriminator(lambda value: "table" if isinstance(value, dict | Tolerance) else "number"),
]


def methods_described() -> str:
    return f"the method: {', '.join(METHODS)} (or omit it: {DEFAULT} with a step, {DEFAULT_PAIR} with a tolerance)"


def _groups() -> str:
    named = (f'"{name}"' + (f", {group.note}" if group.note else "") for name, group in GROUPS.items())
    return f"the group of each body: {', or '.join(named)}"


def _coordinates() -> str:
    named = [f'"{name}"' + (f" ({chart.note})" if chart.note else "") for name, chart in COORDINATES.items()]
    every = f"to compare with, as vectors, {listed(named, 'or')}"
    joints = f'"{JOINT}" (those of the joints, which hold by themselves)'
    return f'"lie" (those of the group of each body), {joints}, or {every}'


class Integrator(Section):
    method: Annotated[str, NameOf(METHODS)] = Field(default=DEFAULT, description=methods_described())
    order: Annotated[int, Field(strict=True, ge=LOWEST, le=HIGHEST)] | None = Field(
        default=None,
        description=f"the order of a series, from {LOWEST} to {HIGHEST} (or omit it: as the tolerance asks, or "
        f"{TAYLOR.order} with a step)",
    )
    rho_infinity: Annotated[float, Field(strict=True, ge=0.0, le=1.0)] | None = Field(
        default=None,
        description="what a step leaves of the fastest vibrations, from 0 (nothing) to 1 (all), of the method "
        f'"{GENERALIZED_ALPHA.name}" (or omit it: {DAMPING})',
    )
    step: Positive | None = Field(default=None, description="the time step in s, above 0")
    tolerance: AnyTolerance | None = Field(
        default=None,
        description="the error of one step, from 1e-14 to 0.1, or { relative = ..., absolute = { rotation = ... } }",
    )
    first_step: Positive | None = Field(default=None, description="the first step in s that is tried, above 0")
    max_step: Positive | None = Field(default=None, description="the longest step in s, above 0")
    min_step: Positive | None = Field(default=None, description="the shortest step in s, above 0")
    end_time: Annotated[Positive, Field(ge=1e-100)] = Field(description="the simulated time in s, 1e-100 or more")
    dexpinv: DexpInv | None = Field(
        default=None,
        description='"closed", or a whole number of terms of the series of dexpinv, from 0 to 10 (or omit it: as many '
        "as the order of the method needs)",
    )
    group: Annotated[str, NameOf(GROUPS)] = Field(
        default="R3xSO3",
        description=_groups(),
    )
    coordinates: Annotated[str, NameOf(COORDINATES, besides=("lie", JOINT))] = Field(
        default="lie",
        description=_coordinates(),
    )
    engine: Literal["numba"] | None = Field(
        default=None,
        description='"numba": the formulas of the paper in plain Numba, an independent and slower check (or omit it)',
    )


def _weights() -> str:
    named = [f'"{name}"' for name in WEIGHTS]
    return f'the weight of the correction: {listed(named, "or")}, or "none"'


class Projection(Section):
    position: Literal["local", "embedded", "none"] = Field(
        default="local",
        description='back onto the joints after each step: "local" (in coordinates of the rotations), "embedded" (in '
        'their matrix elements, as printed in the paper) or "none"',
    )
    velocity: Annotated[str, NameOf(WEIGHTS, none=True)] = Field(default="mass", description=_weights())
    tolerance: Positive = Field(default=1e-11, description="the largest violation left over, in m, above 0")
    max_iterations: Annotated[int, Field(strict=True, ge=1, le=1000)] = Field(
        default=10, description="a whole number of iterations, from 1 to 1000"
    )
    chord: Annotated[bool, Field(strict=True)] = Field(
        default=False,
        description="whether later iterations for the positions use the elimination of the first: true or false",
    )
    baumgarte: Positive | None = Field(
        default=None,
        description='the rate in 1/s at which violations are damped, above 0, with position and velocity "none" '
        "(or omit it: no damping)",
    )

    def faults(self) -> Iterator[Problem]:
        """Violations are damped or projected; chords are of projected positions."""
        if self.chord and self.position == "none":
            rule = 'is for projected positions, and projection.position = "none" projects none'
            yield Problem("chord", rule, 'leave it out, or give position = "local" or "embedded"', True)
        projected = [f'projection.{x} = "{y}"' for x in ("position", "velocity") if (y := getattr(self, x)) != "none"]
        if self.baumgarte is not None and projected:
            rule = f"damps violations instead of projecting, against {' and '.join(projected)}"
            remedy = 'give position = "none" and velocity = "none", or leave baumgarte out'
            yield Problem("baumgarte", rule, remedy, self.baumgarte)


class Study(Section):
    """A grid instead of samples: every point is the scenario with other settings, compared with a reference."""

    reference: dict[str, Any] = Field(
        description='what the runs are compared with: settings such as { method = "dop853", step = 1e-4 }, formulas '
        'such as { position = { top = ["sin(t)", 0, 0] } }, or { file = "ref.nc" }'
    )
    grid: Annotated[list[dict[str, Any]], Field(min_length=1)] = Field(
        description='paths with lists of values, such as "integrator.step" = [1e-2, 5e-3], each as [[study.grid]]'
    )
    repeats: Count = Field(
        default=3, description="a whole number of times that each point is run to time it, at least 1"
    )


class Sensitivities(Section):
    """Derivatives of every run by its inputs."""

    of: Annotated[list[str], Field(min_length=1)] = Field(
        description='what is differentiated: names of the dataset such as "position", "tip.z", "event_time.deployed", '
        "the name of a measure"
    )
    by: list[str] | None = Field(
        default=None,
        description="paths of numbers of the model such as bodies.top.mass; by default all inputs of the sweep",
    )


class ScenarioData(Section):
    """A whole scenario, as the TOML file has it."""

    title: Annotated[str, Field(strict=True, max_length=1000)] = Field(default="", description="a text")
    extends: str | None = Field(default=None, description="the path of a scenario on which this one builds")
    parameters: dict[str, float | str | list[float | str]] = Field(
        default={},
        description="numbers with names, or formulas of other parameters: kp = 40; lists: k = [1, 2]",
    )
    tables: dict[str, TableSection] = Field(
        default={}, description="functions known at points, each as [tables.name] with file, time and value"
    )
    files: dict[str, str] = Field(
        default={}, description="the texts of Python files that laws name, kept with the scenario"
    )
    model: ModelSection = Field(description="the section [model] with its bodies")
    integrator: Integrator = Field(description="the section [integrator] with step and end_time")
    projection: Projection = Field(default_factory=Projection, description="the section [projection]")
    output: Output = Field(default_factory=Output, description="the section [output]")
    sweep: Sweep = Field(default_factory=Sweep, description="the section [sweep]")
    study: Study | None = Field(default=None, description="the section [study]")
    sensitivities: Sensitivities | None = Field(default=None, description="the section [sensitivities]")
