"""Which section stands at which place of a scenario, as the registries have them, now and when they grow."""

from collections.abc import Mapping
from typing import Any

from pydantic import BaseModel

from lienumba.integrators.methods import METHODS
from lienumba.integrators.methods.charts import GROUPS
from lienumba.integrators.methods.comparators import COORDINATES
from lienumba.keys.types import AxisAngle, Euler, RotationVector, Section
from lienumba.mechanics.elements.contacts import CONTACTS
from lienumba.mechanics.elements.contacts.base import Coefficients
from lienumba.mechanics.elements.drivers import DRIVERS, driver_form
from lienumba.mechanics.elements.events import ACTIONS, Event, described
from lienumba.mechanics.elements.forces import FORCES
from lienumba.mechanics.elements.inputs import INPUTS_BY_FORM, input_form
from lienumba.mechanics.elements.joints import JOINTS
from lienumba.mechanics.elements.limits import Limit
from lienumba.mechanics.elements.quantities import NOISES, QUANTITIES
from lienumba.mechanics.system.output_variables import OUTPUT_VARIABLES, usual
from lienumba.scenario.base import paths
from lienumba.scenario.schema.output import Output, outputs_described
from lienumba.scenario.schema.requirements import Measure, Requirement
from lienumba.scenario.schema.scenario import (
    Absolute,
    Body,
    Integrator,
    ModelSection,
    Projection,
    ScenarioData,
    Sensitivities,
    StartSection,
    StartState,
    Study,
    Tolerance,
    methods_described,
)
from lienumba.scenario.schema.shapes import SHAPES
from lienumba.scenario.schema.sweep import Correlation, Stop, Sweep, samplers_described
from lienumba.sweep.distributions.registry import DISTRIBUTIONS
from lienumba.sweep.samplers import SAMPLERS
from lienumba.sweep.samplers.importance import Proposal
from lienumba.sweep.table import SampleTable

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
        ("sensitivities",): Sensitivities,
        **shapes,
    }


def _derive() -> None:
    """What follows from the registries."""
    Integrator.model_fields["method"].description = methods_described()
    Sweep.model_fields["sampler"].description = samplers_described()
    Event.model_fields["action"].description = described()
    variables = Output.model_fields["variables"]
    variables.default, variables.description = usual(), outputs_described()
    for section in (Event, Integrator, Output, Sweep, ModelSection, ScenarioData):  # holders of others are last
        section.model_rebuild(force=True)
    SECTIONS.clear()
    SECTIONS.update(_sections())


SECTIONS.update(_sections())
for registry in (
    JOINTS, DRIVERS, FORCES, CONTACTS, QUANTITIES, NOISES, ACTIONS, OUTPUT_VARIABLES, METHODS, GROUPS, COORDINATES,
    SAMPLERS, DISTRIBUTIONS, SHAPES,
):  # fmt: skip
    registry.listeners.append(_derive)


def section_of(kind: str, item: dict[str, Any]) -> type[BaseModel] | None:
    """The class of a table in one of the model's lists, or of an input, as far as its type is known."""
    if kind == paths.INPUTS:
        return INPUTS_BY_FORM.get(input_form(item) or "")
    if kind in ("bodies", "events", "limits", *paths.JUDGING):
        return SECTIONS[("model", kind)]
    form = driver_form(item) if kind == "drivers" else item.get("type")
    return SECTIONS.get(("model", kind, form)) if isinstance(form, str) else None
