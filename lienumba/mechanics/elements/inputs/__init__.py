"""Inputs of a mechanism: numbers with names that come from outside, such as the commands of its motors.

A formula, a recording, what draws a coordinate to a reference, or a state of its own. One class for each form, with its
keys and its mathematics; an input that is a plain number is a parameter. In the model an input is a quantity, which
formulas read; where it has a state, there is a law of its name beside it that acts on nothing.
"""

from typing import Annotated, Any

from pydantic import AfterValidator, Discriminator, Tag

from lienumba.keys.formulas import checked
from lienumba.keys.types import Number, Section
from lienumba.mechanics.elements.inputs.base import InputType
from lienumba.mechanics.elements.inputs.forms import FormulaInput, RecordedInput, TrackingInput
from lienumba.mechanics.elements.inputs.state import RestingInput, StateInput
from lienumba.mechanics.elements.quantities import INPUT_FORMS
from lienumba.mechanics.mechanism.model import Quantity

INPUTS_BY_FORM: dict[str, type[InputType]] = {
    kind.form: kind for kind in (FormulaInput, RecordedInput, TrackingInput, StateInput)
}
INPUT_FORMS.update({**INPUTS_BY_FORM, RestingInput.form: RestingInput})
FORM_KEYS = {"times": "recording", "values": "recording", "file": "recording", "joint": "tracking",
             "target": "tracking", "value": "formula", "rate": "state"}  # fmt: skip  # the first that is there decides


def input_form(value: object) -> str | None:
    """Which of the forms an input is written in; "number" and "text" for what is no table."""
    if isinstance(value, str) or callable(value):
        return "text"
    if isinstance(value, Section):
        return next((form for form, kind in INPUTS_BY_FORM.items() if isinstance(value, kind)), None)
    if not isinstance(value, dict):
        return "number"
    return next((form for key, form in FORM_KEYS.items() if key in value), None)


AnyInput = Annotated[
    Annotated[Number, Tag("number")]
    | Annotated[str, AfterValidator(checked), Tag("text")]
    | Annotated[FormulaInput, Tag("formula")]
    | Annotated[RecordedInput, Tag("recording")]
    | Annotated[TrackingInput, Tag("tracking")]
    | Annotated[StateInput, Tag("state")],
    Discriminator(input_form),
]


def has_state(quantity: Quantity) -> bool:
    """Whether it is an input that is a state."""
    kind = INPUT_FORMS.get(quantity.type)
    return kind is not None and issubclass(kind, InputType) and kind.has_state(quantity)


def written(value: Any) -> InputType | None:
    """An input as its class has it; None for a number."""
    if isinstance(value, InputType):
        return value
    varies = isinstance(value, str) or callable(value)
    return FormulaInput.model_construct({"value"}, value=value) if varies else None
