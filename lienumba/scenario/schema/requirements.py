"""Measures and requirements as data: numbers of whole runs, and what runs shall do."""

from collections.abc import Iterator
from typing import Annotated, Literal

from pydantic import AfterValidator, Field

from lienumba.errors import BadValueError, Problem
from lienumba.keys.types import Number, Section
from lienumba.scenario.schema.sweep import Share

LONGEST = 60  # characters of a name
FORBIDDEN = '."[]/'  # in names, which are those of variables and stand in paths


LIMITS = ("below", "above", "between")


def words(name: str) -> str:
    """A name of words; a BadValueError if it is none."""
    if not name.strip() or name != name.strip() or not name.isprintable() or set(name) & set(FORBIDDEN):
        raise BadValueError("is no valid name", 'give words without ".", "[", "]", "/" and quotes')
    return name


Words = Annotated[str, Field(strict=True, max_length=LONGEST), AfterValidator(words)]


class Measure(Section):
    """A number that each run has as a whole."""

    name: Words = Field(description='the name of the variable in the dataset: words such as "settling" or "worst tilt"')
    value: str | None = Field(
        default=None,
        description='a formula with reducers, such as "max(pointing.angle, t > 5)" or "last_time(pointing.angle > '
        '0.1*deg)" (or give function)',
    )
    function: str | None = Field(
        default=None,
        description='instead of value, a file and a function in it, "reducers.py:roughness", of the courses at the '
        "times of the output: its arguments are t (s) and names of quantities, with _ for a point",
    )
    units: str | None = Field(
        default=None, max_length=40, description='its units, such as "rad" (or omit it: they follow from the formula)'
    )


class Requirement(Section):
    """A number that each run has shall be on one side of a limit, in so large a part of all runs."""

    name: Words = Field(description='the name: words such as "pointing stays fine"')
    value: str = Field(
        description="a formula of the whole run, such as max(pointing.angle, t > 5), or a number that the dataset has "
        "for each run: a measure, event_time.impact, energy_lost, or pointing.angle_max, which output.summary asks for"
    )
    below: Number | None = Field(default=None, description="what the value must be below, in its unit")
    above: Number | None = Field(default=None, description="what the value must be above, in its unit")
    between: Annotated[list[Number], Field(min_length=2, max_length=2)] | None = Field(
        default=None, description="the least and the largest value that are good, in its unit: [low, high]"
    )
    probability: Share = Field(description="the part of all runs that shall meet it, between 0 and 1, such as 0.99")
    confidence: Share = Field(default=0.95, description="how sure this is to be, between 0 and 1, such as 0.95")
    failed: Literal["count", "ignore"] = Field(
        default="count", description='whether failed runs do not meet it ("count"), or are left out ("ignore")'
    )

    def faults(self) -> Iterator[Problem]:
        given = [key for key in LIMITS if getattr(self, key) is not None]
        if not given:
            yield Problem("", "has no limit", "give below, above or between")
        for key in given[1:]:
            remedy = "give below, above or between = [low, high]"
            yield Problem(key, f"stands beside {given[0]}", remedy, getattr(self, key))
        if self.between is not None and not self.between[0] < self.between[1]:
            yield Problem(
                "between", "has no smaller number first", "give the least value first, and a larger one", self.between
            )
