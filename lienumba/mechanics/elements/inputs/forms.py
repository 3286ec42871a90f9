"""Inputs that are given: formulas, recordings, and what draws a coordinate to a reference."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any, ClassVar, Literal

from pydantic import Field

from lienumba.errors import Problem
from lienumba.keys.conversions import timed
from lienumba.keys.types import OR_FORMULA, CoordinateKind, Number, Timed
from lienumba.mechanics.elements import joints
from lienumba.mechanics.elements.inputs.base import InputType
from lienumba.mechanics.elements.names import Names
from lienumba.mechanics.elements.quantities import VELOCITY, evaluate
from lienumba.mechanics.mechanism.kinematics import View, moving
from lienumba.mechanics.mechanism.model import Law, Model, Quantity
from lienumba.mechanics.mechanism.tables import Table
from lienumba.numerics.expressions import Formula
from lienumba.numerics.jets import lift

RECORDED = "recorded"  # what a recording is called in the formula that reads it
Outside = Literal["hold", 0, "error"]
OUTSIDE_DESCRIBED = (
    '"hold" (the first and the last value), 0 or "error" in front of the first point and behind the last one'
)
EFFORTS = {"angle": "N m", "displacement": "N"}


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
    outside: Outside | None = Field(default=None, description=f"{OUTSIDE_DESCRIBED} (or omit it)")
    delay: Number = Field(
        default=0.0,
        description="by how much later in s it is played; a delayed feedback is a law in Python with every and memory",
    )

    def table(self) -> Table:
        """The recording as a function."""
        return Table.of(self.times, self.values, self.interpolation, self.outside)

    def to_model(self, name: str, names: Names) -> Quantity:
        table = self.table()
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
