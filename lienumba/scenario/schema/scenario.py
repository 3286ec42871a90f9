"""The scenario as data: which keys exist, their types, units and defaults.

What one key says about another (names, step and interval, rotations) is in `checks`. A key's description is
also the remedy in its error messages, which read "give <description>".
"""

from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BaseModel, Discriminator, Field, Tag, WithJsonSchema, create_model

from lienumba.errors import BadValueError
from lienumba.integrators.methods import DEFAULT, DEFAULT_PAIR, METHODS
from lienumba.integrators.methods.charts import GROUPS, JOINT
from lienumba.integrators.methods.comparators import COORDINATES
from lienumba.integrators.methods.generalized_alpha import DAMPING, GENERALIZED_ALPHA
from lienumba.integrators.methods.taylor import HIGHEST, LOWEST, TAYLOR
from lienumba.keys.choices import NameOf, OneOf
from lienumba.keys.types import (
    NAME_RULE,
    WRITTEN,
    AxisAngle,
    Count,
    Euler,
    Inertia,
    Name,
    Number,
    Positive,
    Rotation,
    RotationVector,
    Section,
    Timed3,
    Vec3,
)
from lienumba.mechanics.elements.contacts import CONTACTS
from lienumba.mechanics.elements.contacts.base import Coefficients, ContactType
from lienumba.mechanics.elements.drivers import DRIVERS, DriverType, driver_form
from lienumba.mechanics.elements.events import ACTIONS, Event, described
from lienumba.mechanics.elements.forces import FORCES
from lienumba.mechanics.elements.forces.base import ForceLaw
from lienumba.mechanics.elements.inputs import INPUTS_BY_FORM, AnyInput, input_form
from lienumba.mechanics.elements.joints import JOINTS, JointType
from lienumba.mechanics.elements.limits import Limit
from lienumba.mechanics.elements.noise import NoiseType
from lienumba.mechanics.elements.quantities import NOISES, QUANTITIES
from lienumba.mechanics.elements.quantities.base import QuantityType
from lienumba.mechanics.system.output_variables import OUTPUT_VARIABLES, usual
from lienumba.mechanics.system.projection import WEIGHTS
from lienumba.scenario.base import paths
from lienumba.scenario.schema.measures import Measure
from lienumba.scenario.schema.output import Output, outputs_described
from lienumba.scenario.schema.requirements import Requirement
from lienumba.scenario.schema.shapes import SHAPES, AnyShapes
from lienumba.scenario.schema.stop import Stop
from lienumba.scenario.schema.sweep import Correlation, SampleFile, Sweep, samplers_described
from lienumba.scenario.schema.tables import InputFile, Recording, TableFile, TableSection
from lienumba.sweep.distributions.registry import DISTRIBUTIONS
from lienumba.sweep.samplers import SAMPLERS
from lienumba.sweep.samplers.importance import Proposal
from lienumba.sweep.table import SampleTable
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


def _methods() -> str:
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
    method: Annotated[str, NameOf(METHODS)] = Field(default=DEFAULT, description=_methods())
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


# What stands in the lists of the model: the classes of each by their names.
FORMS: dict[str, Mapping[str, type[Section]]] = {
    "joints": JOINTS, "drivers": DRIVERS, "forces": FORCES, "quantities": QUANTITIES, "noise": NOISES,
    "contacts": CONTACTS,
}  # fmt: skip
SHAPE_LISTS = (("model", "bodies", "shapes"), ("model", "ground_shapes"))
# The class behind each place of the file; list indices are left out, "*" is any path of sweep.vary.
SECTIONS: dict[tuple[str, ...], type[BaseModel]] = {}


def _sections() -> dict[tuple[str, ...], type[BaseModel]]:
    shapes = {(*place, form): section for place in SHAPE_LISTS for form, section in SHAPES.items()}
    return {
        (): ScenarioData,
        ("model",): ModelSection,
        ("model", "bodies"): Body,
        ("model", "bodies", "guess"): StartState,
        **{
            (*start, "rotation", form): section
            for start in (("model", "bodies"), ("model", "bodies", "guess"), *shapes)
            for form, section in (("axis_angle", AxisAngle), ("euler_angles", Euler), ("vector", RotationVector))
        },
        **{("model", kind, form): section for kind, forms in FORMS.items() for form, section in forms.items()},
        ("model", "events"): Event,
        ("model", "limits"): Limit,
        ("model", "measures"): Measure,
        ("model", "requirements"): Requirement,
        **{("model", "contacts", form, "friction", "coefficients"): Coefficients for form in CONTACTS},
        **{("model", "inputs", form): kind for form, kind in INPUTS_BY_FORM.items()},
        ("model", "start"): StartSection,
        ("integrator",): Integrator,
        ("integrator", "tolerance", "table"): Tolerance,
        ("integrator", "tolerance", "table", "absolute"): Absolute,
        ("projection",): Projection,
        ("output",): Output,
        ("sweep",): Sweep,
        ("sweep", "stop"): Stop,
        ("sweep", "correlate"): Correlation,
        ("sweep", "proposal", "*"): Proposal,
        ("sweep", "table"): SampleTable,
        **{("sweep", "vary", "*", form): kind for form, kind in DISTRIBUTIONS.items()},
        ("study",): Study,
        **shapes,
    }


def _derive() -> None:
    """What follows from the registries."""
    Integrator.model_fields["method"].description = _methods()
    Sweep.model_fields["sampler"].description = samplers_described()
    Event.model_fields["action"].description = described()
    variables = Output.model_fields["variables"]
    variables.default, variables.description = usual(), outputs_described()
    sections = (
        Body,
        Standing,
        Event,
        Integrator,
        Output,
        Sweep,
        ModelSection,
        ScenarioData,
    )  # those that hold others behind these
    for section in sections:
        section.model_rebuild(force=True)
    SECTIONS.clear()
    SECTIONS.update(_sections())


SECTIONS.update(_sections())
for registry in (
    JOINTS, DRIVERS, FORCES, CONTACTS, QUANTITIES, NOISES, ACTIONS, OUTPUT_VARIABLES, METHODS, GROUPS, COORDINATES,
    SAMPLERS, DISTRIBUTIONS, SHAPES,
):  # fmt: skip
    registry.listeners.append(_derive)


def json_schema() -> dict[str, Any]:
    """The JSON schema of a scenario as people write it: quantities and events beside the model, tables with files."""
    schema = ScenarioData.model_json_schema()
    model = schema["$defs"]["ModelSection"]["properties"]
    for kind in paths.BESIDE:
        schema["properties"][kind] = model.pop(kind)
    schema["$defs"]["TableFile"] = TableFile.model_json_schema()
    schema["properties"]["tables"]["additionalProperties"] = {
        "anyOf": [{"$ref": "#/$defs/TableFile"}, {"$ref": "#/$defs/TableSection"}]
    }
    inputs = schema["properties"][paths.INPUTS]
    inputs["additionalProperties"] = {"anyOf": [*inputs["additionalProperties"]["oneOf"], _defined(schema, InputFile)]}
    recording = _defined(schema, Recording)
    inputs["properties"] = {paths.RECORDING: {"anyOf": [recording, {"type": "array", "items": recording}]}}
    schema["$defs"]["SampleFile"] = SampleFile.model_json_schema()
    schema["$defs"]["Sweep"]["properties"]["table"]["anyOf"].append({"$ref": "#/$defs/SampleFile"})
    return schema


def _defined(schema: dict[str, Any], section: type[Section]) -> dict[str, str]:
    """A reference to a section that is added to the definitions of a schema."""
    own = section.model_json_schema()
    schema["$defs"] |= {**own.pop("$defs", {}), section.__name__: own}
    return {"$ref": f"#/$defs/{section.__name__}"}


def section_of(kind: str, item: dict[str, Any]) -> type[BaseModel] | None:
    """The class of a table in one of the model's lists, or of an input, as far as its type is known."""
    if kind == paths.INPUTS:
        return INPUTS_BY_FORM.get(input_form(item) or "")
    if kind in ("bodies", "events", "limits", *paths.JUDGING):
        return SECTIONS[("model", kind)]
    form = driver_form(item) if kind == "drivers" else item.get("type")
    return SECTIONS.get(("model", kind, form)) if isinstance(form, str) else None
