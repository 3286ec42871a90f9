"""When a sweep has runs enough: the section [sweep.stop]."""

from typing import Annotated, Literal

from pydantic import Field

from lienumba.keys.types import Count, Positive, Section

Share = Annotated[float, Field(strict=True, gt=0.0, lt=1.0)]


class Stop(Section):
    """The sweep ends where the confidence interval of a statistic over its runs is narrow enough."""

    variable: str = Field(
        description="a number that the dataset has for each run, such as pointing.angle_max, which output.summary asks "
        "for, event_time.impact, energy_lost, or max_energy_drift",
    )
    statistic: Literal["mean", "quantile"] = Field(default="mean", description='"mean" or "quantile"')
    probability: Share | None = Field(
        default=None, description="the part of the quantile, between 0 and 1: 0.95 is what 95 % of the runs stay below"
    )
    width: Positive = Field(
        description="the width of the confidence interval, from end to end, in the variable's unit, above 0"
    )
    confidence: Share = Field(default=0.95, description="that of the interval, between 0 and 1")
    every: Count = Field(
        default=100, description="a whole number of runs after which it is decided, each time, at least 1"
    )
