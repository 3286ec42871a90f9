"""What runs are wanted to do: the list [[requirements]]."""

from collections.abc import Iterator
from typing import Annotated, Literal

from pydantic import Field

from lienumba.errors import Problem
from lienumba.keys.types import Number, Section
from lienumba.scenario.schema.measures import Words
from lienumba.scenario.schema.stop import Share

LIMITS = ("below", "above", "between")


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
        """What is wrong with its numbers together; places are its keys."""
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
