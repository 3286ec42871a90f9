"""What all inputs have in common: limits, a filter, units, and the law that moves those which are states."""

from collections.abc import Iterator
from typing import Any, ClassVar

from pydantic import Field

from lienumba.errors import Problem
from lienumba.keys.conversions import timed
from lienumba.keys.types import OR_FORMULA, Number, Positive, Timed, Timed2
from lienumba.mechanics.elements.forces.numbers import faulty_limits
from lienumba.mechanics.elements.names import Names
from lienumba.mechanics.elements.quantities import POSITION, VELOCITY, Observed, Part, Readable, evaluate
from lienumba.mechanics.elements.quantities.base import INPUTS, joined
from lienumba.mechanics.mechanism.kinematics import View
from lienumba.mechanics.mechanism.model import Code, Force, Law, Model, Quantity
from lienumba.numerics.expressions import Formula
from lienumba.numerics.operations import maximum, minimum

RATE = "rate"  # of the state of an input, as its law asks for it
STATE = "value"


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
            return within(cls.limits_of(model, quantity, view), cls.command(model, quantity, view))
        state = cls.state_of(model, quantity, view)
        return cls.moved(model, quantity, view, state) if component == RATE else cls.kept(model, quantity, view, state)

    @classmethod
    def state_of(cls, model: Model, quantity: Quantity, view: View) -> Any:
        """What its law moves."""
        law = next(force for force in model.forces if force.name == quantity.name)
        return view.states.get(quantity.name, tuple(law.initial.values()))[0]

    @classmethod
    def kept(cls, model: Model, quantity: Quantity, view: View, state: Any) -> Any:
        """The input where its state is known."""
        return state

    @classmethod
    def moved(cls, model: Model, quantity: Quantity, view: View, state: Any) -> Any:
        """The rate of its state."""
        command = within(cls.limits_of(model, quantity, view), cls.command(model, quantity, view))
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


def within(limits: tuple[Any, Any] | None, x: Any) -> Any:
    """What is nearest to x between the limits."""
    return x if limits is None else maximum(limits[0], minimum(limits[1], x))  # NaN stays NaN
