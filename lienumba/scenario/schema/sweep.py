"""The section [sweep] as data."""

from typing import Annotated, Literal

from pydantic import Field

from lienumba.keys.choices import NameOf
from lienumba.keys.types import Section
from lienumba.scenario.schema.stop import Stop
from lienumba.sweep import samplers
from lienumba.sweep.distributions.base import Finite
from lienumba.sweep.distributions.registry import AnyDistribution
from lienumba.sweep.samplers import SAMPLERS
from lienumba.sweep.samplers.importance import Proposal
from lienumba.sweep.table import SampleTable

MOST_RUNS = 2**31  # labels are int32 in files


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
