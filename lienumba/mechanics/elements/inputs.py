"""Inputs of a mechanism: numbers with names that come from outside, such as the commands of its motors.

A formula, a recording, what draws a coordinate to a reference, or a state of its own. One class for each form, with its
keys and its mathematics; an input that is a plain number is a parameter. In the model an input is a quantity, which
formulas read; where it has a state, there is a law of its name beside it that acts on nothing.
"""

from collections.abc import Iterator
from dataclasses import replace
from typing import Annotated, Any, ClassVar, Literal

from pydantic import AfterValidator, Discriminator, Field, Tag

from lienumba.errors import Problem
from lienumba.keys.conversions import timed
from lienumba.keys.formulas import checked
from lienumba.keys.types import OR_FORMULA, CoordinateKind, Number, Positive, Section, Timed, Timed2
from lienumba.mechanics.elements import joints
from lienumba.mechanics.elements.forces.numbers import faulty_limits
from lienumba.mechanics.elements.names import Names
from lienumba.mechanics.elements.quantities import INPUT_FORMS, POSITION, VELOCITY, Observed, Part, Readable, evaluate
from lienumba.mechanics.elements.quantities.base import INPUTS, joined
from lienumba.mechanics.mechanism.kinematics import View, moving
from lienumba.mechanics.mechanism.model import Code, Force, Law, Model, Quantity
from lienumba.mechanics.mechanism.tables import Table
from lienumba.numerics.expressions import Formula
from lienumba.numerics.jets import lift
from lienumba.numerics.operations import maximum, minimum, where

RATE = "rate"  # of the state of an input, as its law asks for it
STATE = "value"
RECORDED = "recorded"  # what a recording is called in the formula that reads it
EFFORTS = {"angle": "N m", "displacement": "N"}


class InputType(Readable):
    """An input, as a scenario describes it.

    keeps: whether it is a state whatever else is said of it; fixed: keys of numbers that are the same throughout a run.
    """

    form: ClassVar[str]
    keeps: ClassVar[bool] = False
    fixed: ClassVar[tuple[str, ...]] = ("filter", "start", "delay")

    limit: Timed | None = Field(default=None, description=f"the largest size of the input, at least 0 {OR_FORMULA}")
    limits: Timed2 | None = Field(
        default=None, description=f"the least and the largest value, instead of limit: 2 numbers {OR_FORMULA}"
    )
    filter: Positive | None = Field(
        default=None, description="the time constant in s, above 0, with which the input follows (or omit it: at once)"
    )
    start: Number | None = Field(
        default=None, description="the value at t = 0 of an input with filter or rate (or omit it: 0)"
    )
    units: str | None = Field(default=None, description='the units as a text, such as "N m"')

    # ---------------------------------------------------------------- mathematics
    @classmethod
    def has_state(cls, quantity: Quantity) -> bool:
        """Whether it follows with a delay of the first order, or by a rate."""
        return cls.keeps or "filter" in quantity.numbers

    @classmethod
    def command(cls, model: Model, quantity: Quantity, view: View) -> Any:
        """What is commanded: the input itself, or if it is a state what decides its rate."""
        return evaluate(model, quantity.value, view)

    @classmethod
    def level(cls, quantity: Quantity, component: str) -> int:
        return VELOCITY if cls.has_state(quantity) and component != RATE else POSITION

    @classmethod
    def reads(cls, quantity: Quantity, component: str) -> tuple[Any, ...]:
        if cls.has_state(quantity) and component != RATE:
            return ()
        numbers = (y for x in quantity.numbers.values() for y in (x if isinstance(x, tuple) else (x,)))
        return (quantity.value, *numbers)

    @classmethod
    def parts(cls, model: Model, quantity: Quantity) -> tuple[Part, ...]:
        return (Part("", quantity.units, "input"),)

    @classmethod
    def rows(cls, model: Model, quantity: Quantity, view: View, observed: Observed | None) -> tuple[Any, ...]:
        return (cls.number(model, quantity, "", view, observed),)

    @classmethod
    def number(cls, model: Model, quantity: Quantity, component: str, view: View, observed: Observed | None) -> Any:
        if not cls.has_state(quantity):
            return _within(cls.limits_of(model, quantity, view), cls.command(model, quantity, view))
        law = next(force for force in model.forces if force.name == quantity.name)
        state = view.states.get(quantity.name, tuple(law.initial.values()))[0]
        return cls.moved(model, quantity, view, state) if component == RATE else cls.kept(model, quantity, view, state)

    @classmethod
    def kept(cls, model: Model, quantity: Quantity, view: View, state: Any) -> Any:
        """The input where its state is known."""
        return state

    @classmethod
    def moved(cls, model: Model, quantity: Quantity, view: View, state: Any) -> Any:
        """The rate of its state."""
        command = _within(cls.limits_of(model, quantity, view), cls.command(model, quantity, view))
        return (command - state) / evaluate(model, quantity.numbers["filter"], view)

    @classmethod
    def limits_of(cls, model: Model, quantity: Quantity, view: View) -> tuple[Any, Any] | None:
        """The least and the largest value."""
        if "limit" in quantity.numbers:
            most = evaluate(model, quantity.numbers["limit"], view)
            return -most, most
        if "limits" in quantity.numbers:
            low, high = (evaluate(model, x, view) for x in quantity.numbers["limits"])
            return low, high
        return None

    # ---------------------------------------------------------------- keys
    def faults(self) -> Iterator[Problem]:
        """What is wrong with its keys together; places are its keys."""
        yield from faulty_limits(self.limit, self.limits)
        if isinstance(self.limit, float | int) and self.limit < 0.0:
            yield Problem("limit", "must be at least 0", "give its size without a sign", self.limit)
        if self.filter is None and not self.keeps and self.start is not None:
            yield Problem("start", "has no effect without filter", "give filter, or leave it out", self.start)

    def to_model(self, name: str, names: Names) -> Quantity:
        """The input as a quantity of the model; name: without `inputs.`."""
        numbers: dict[str, Any] = {}
        for key in ("limit", "limits", "filter"):
            if (x := getattr(self, key)) is not None:
                numbers[key] = tuple(map(timed, x)) if isinstance(x, list) else timed(x)
        return Quantity(joined(INPUTS, name), self.form, value=0.0, units=self.units or "1", numbers=numbers)

    def law(self, name: str) -> Force | None:
        """What moves the state of an input; None where it has none."""
        if self.filter is None and not self.keeps:
            return None
        own = joined(INPUTS, name)
        rate = joined(own, RATE)
        asked = Law(Formula(rate, frozenset({rate})), {}, (rate,))
        code = Code(follow, "loads", states=(STATE,))
        return Force(
            own,
            "python",
            (),
            numbers={RATE: asked},
            code=code,
            initial={STATE: 0.0 if self.start is None else self.start},
        )


def follow(*, rate: Any) -> tuple[list[Any], dict[str, Any]]:
    """The law of an input that is a state."""
    return [], {STATE: rate}


def _within(limits: tuple[Any, Any] | None, x: Any) -> Any:
    return x if limits is None else maximum(limits[0], minimum(limits[1], x))  # NaN stays NaN


class FormulaInput(InputType):
    """A formula; a text alone is one, too."""

    form: ClassVar[str] = "formula"

    value: Timed = Field(description=f"a number {OR_FORMULA}, of quantities, parameters, tables and other inputs")

    def to_model(self, name: str, names: Names) -> Quantity:
        return replace(super().to_model(name, names), value=timed(self.value))


class RecordedInput(InputType):
    """A recording: a table that is read at the time."""

    form: ClassVar[str] = "recording"

    times: list[float] = Field(description="the times in s, ascending")
    values: list[float] = Field(description="the values, one for each of the times")
    interpolation: Literal["hold", "linear", "cubic"] = Field(
        default="linear", description='"hold" (a value until the next), "linear" or "cubic" (a smooth spline)'
    )
    delay: Number = Field(default=0.0, description="by how much later in s it is played")

    def to_model(self, name: str, names: Names) -> Quantity:
        table = Table.of(self.times, self.values, self.interpolation)
        formula = Formula(f"{RECORDED}(t - delay)", frozenset({"t", "delay"}), frozenset({RECORDED}))
        value = Law(formula, {RECORDED: table, "delay": self.delay})
        return replace(super().to_model(name, names), value=value)


class TrackingInput(InputType):
    """What draws a coordinate of a joint to a reference: proportional, derivative, and what is fed forward."""

    form: ClassVar[str] = "tracking"
    reads_coordinates: ClassVar[bool] = True
    terms: ClassVar[tuple[str, ...]] = ("kp", "kd", "target", "rate", "feedforward")

    joint: str = Field(description="the name of the joint that follows the reference")
    coordinate: CoordinateKind | None = Field(
        default=None,
        description='which coordinate of the joint: "angle" or "displacement" (or omit it where there is only one)',
    )
    kp: Timed = Field(default=0.0, description=f"the gain of the error in N m/rad or N/m {OR_FORMULA}")
    kd: Timed = Field(default=0.0, description=f"the gain of the error's rate in N m s/rad or N s/m {OR_FORMULA}")
    target: Timed = Field(description=f"the angle in rad or displacement in m to follow {OR_FORMULA}")
    rate: Timed | None = Field(
        default=None, description=f"the rate to follow in rad/s or m/s {OR_FORMULA} (or omit it: that of the target)"
    )
    feedforward: Timed = Field(default=0.0, description=f"what is added, in N m or N {OR_FORMULA}")

    @classmethod
    def level(cls, quantity: Quantity, component: str) -> int:
        return VELOCITY

    @classmethod
    def command(cls, model: Model, quantity: Quantity, view: View) -> Any:
        x, which = quantity.numbers, quantity.coordinate
        assert which is not None
        target, ahead = evaluate(model, x["target"], view), moving(view)
        wanted = evaluate(model, x["rate"], view) if "rate" in x else lift(evaluate(model, x["target"], ahead)).b
        error = target - joints.coordinate(model, which, view)
        change = wanted - lift(joints.coordinate(model, which, ahead)).b
        given = (evaluate(model, x[key], view) for key in ("feedforward", "kp", "kd"))
        feedforward, kp, kd = given
        return feedforward + kp * error + kd * change

    def faults(self) -> Iterator[Problem]:
        yield from super().faults()
        if not self.model_fields_set & {"kp", "kd"}:
            yield Problem("", "has neither kp nor kd, so it follows nothing", "give one of them")

    def to_model(self, name: str, names: Names) -> Quantity:
        made, which = super().to_model(name, names), names.coordinate(self.joint, self.coordinate)
        numbers = {key: timed(x) for key in self.terms if (x := getattr(self, key)) is not None}
        units = self.units or EFFORTS[which.kind]
        return replace(made, joint=which.joint, coordinate=which, units=units, numbers={**numbers, **made.numbers})


class StateInput(InputType):
    """A number of which the rate is given; at its limits it stays."""

    form: ClassVar[str] = "state"
    keeps: ClassVar[bool] = True

    rate: Timed = Field(description=f"the rate of the input in 1/s times its units {OR_FORMULA}, which may read it")

    def to_model(self, name: str, names: Names) -> Quantity:
        return replace(super().to_model(name, names), value=timed(self.rate))

    @classmethod
    def kept(cls, model: Model, quantity: Quantity, view: View, state: Any) -> Any:
        return _within(cls.limits_of(model, quantity, view), state)

    @classmethod
    def moved(cls, model: Model, quantity: Quantity, view: View, state: Any) -> Any:
        rate, limits = cls.command(model, quantity, view), cls.limits_of(model, quantity, view)
        if limits is None:
            return rate
        low, high = limits  # one comparison each: a step ends where the state stops or goes on, and nowhere else
        above, below = minimum(rate, state - high), minimum(-rate, low - state)
        return where(above >= 0.0, 0.0, where(below >= 0.0, 0.0, rate))


INPUTS_BY_FORM: dict[str, type[InputType]] = {
    kind.form: kind for kind in (FormulaInput, RecordedInput, TrackingInput, StateInput)
}
INPUT_FORMS.update(INPUTS_BY_FORM)
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
    kind = INPUTS_BY_FORM.get(quantity.type)
    return kind is not None and kind.has_state(quantity)


def written(value: Any) -> InputType | None:
    """An input as its class has it; None for a number."""
    if isinstance(value, InputType):
        return value
    varies = isinstance(value, str) or callable(value)
    return FormulaInput.model_construct({"value"}, value=value) if varies else None
