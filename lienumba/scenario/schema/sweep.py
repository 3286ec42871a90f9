"""The section [sweep] as data."""

from collections.abc import Iterator
from typing import Annotated, Literal

from pydantic import Field

from lienumba.errors import Problem, missing
from lienumba.keys.choices import NameOf
from lienumba.keys.types import Count, Positive, Section
from lienumba.sweep import samplers
from lienumba.sweep.distributions.base import Finite
from lienumba.sweep.distributions.registry import AnyDistribution
from lienumba.sweep.samplers import SAMPLERS
from lienumba.sweep.samplers.importance import Proposal
from lienumba.sweep.table import SampleTable

Share = Annotated[float, Field(strict=True, gt=0.0, lt=1.0)]


MOST_RUNS = 2**31  # labels are int32 in files


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

    def faults(self) -> Iterator[Problem]:
        if self.statistic == "quantile" and self.probability is None:
            yield missing("probability", "give that of the quantile, such as 0.95")
        if self.statistic == "mean" and self.probability is not None:
            remedy = 'leave it out, or give statistic = "quantile"'
            yield Problem("probability", "has no meaning for a mean", remedy, self.probability)


class Correlation(Section):
    paths: Annotated[list[str], Field(min_length=2)] = Field(
        description="at least two varied paths, or components of a rotation vector"
    )
    matrix: list[list[Finite]] = Field(
        description="the correlations of the normal numbers behind them: symmetric, with ones on the diagonal"
    )


class SampleFile(Section):
    """As people write a table of samples."""

    file: str = Field(description="the path of a CSV or netCDF file of samples, relative to the scenario")
    decimal: Literal[".", ","] = Field(default=".", description='the decimal mark of a text file: "." or ","')


def samplers_described() -> str:
    return "how samples are drawn: " + ", ".join(f'"{name}"' for name in SAMPLERS)


class Sweep(Section):
    runs: Annotated[int, Field(strict=True, ge=1, le=MOST_RUNS)] = Field(
        default=1, description="a whole number of runs, at least 1"
    )
    seed: Annotated[int, Field(strict=True, ge=0, lt=2**63)] = Field(
        default=0, description="a whole number from 0 to 2^63 - 1"
    )
    stop: Stop | None = Field(default=None, description="the section [sweep.stop]")
    sampler: Annotated[str, NameOf(SAMPLERS)] = Field(default=samplers.DEFAULT, description=samplers_described())
    nominal: Annotated[bool, Field(strict=True)] = Field(
        default=False, description="whether the nominal run, -1, is simulated, too: true or false"
    )
    vary: dict[str, AnyDistribution] = Field(
        default={},
        description='what varies: "path" = { distribution = "normal", std = ... } '
        'or { distribution = "uniform", low = ..., high = ... }',
    )
    correlate: list[Correlation] = Field(default=[], description="correlations, each as [[sweep.correlate]]")
    proposal: dict[str, Proposal] = Field(
        default={},
        description='where the sampler "importance" draws an input instead: "path" = { shift = 2.0, scale = 1.0 }',
    )
    table: SampleTable | None = Field(
        default=None, description='the samples of the sampler "table": { file = "design.csv" }'
    )
