"""What is stored: times, variables, and what is kept of a run where its course is not."""

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field

from lienumba.keys.types import Number, Positive, Section
from lienumba.mechanics.system.output_variables import OUTPUT_VARIABLES

Statistic = Literal["max", "min", "mean", "rms", "final", "time_of_max"]


def _flat(given: object) -> Any:
    """`pointing.angle = [...]` without quotes is a table in a table for TOML."""
    if not isinstance(given, dict):
        return given
    found: dict[str, Any] = {}
    for name, item in given.items():
        inner = _flat(item)
        found |= {f"{name}.{rest}": x for rest, x in inner.items()} if isinstance(inner, dict) else {name: item}
    return found


Summaries = Annotated[
    dict[str, Annotated[list[Statistic], Field(min_length=1)]],
    BeforeValidator(_flat),
]


def outputs_described() -> str:
    """What may be stored."""
    return "names of the variables and quantities to store: " + ", ".join(OUTPUT_VARIABLES)


class Output(Section):
    every: Positive | None = Field(default=None, description="the interval between stored times in s, above 0")
    times: Annotated[list[Number], Field(min_length=1)] | None = Field(
        default=None, description="the stored times in s, ascending, from 0 to integrator.end_time"
    )
    variables: list[str] = Field(
        default=list(OUTPUT_VARIABLES),
        description=outputs_described(),
    )
    joint_coordinates: Annotated[bool, Field(strict=True)] = Field(
        default=False,
        description="whether the coordinates of all joints are stored by one name, q, with their rates, qd, and what "
        "acts along them, tau: true or false",
    )
    mode: Literal["full", "summary"] = Field(
        default="full",
        description='"full" (the course of every variable), or "summary" (only what there is one of for each run)',
    )
    summary: Summaries = Field(
        default={},
        description='a table of variables, quantities or components, such as pointing = ["max", "rms", "final", '
        '"time_of_max"], over the stored times',
    )
    full_runs: str | None = Field(
        default=None,
        description='the runs whose course is stored all the same in mode "summary", such as "0:10" or "3,17"',
    )
