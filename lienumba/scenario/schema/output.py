"""What is stored: times, variables, and what is kept of a run where its course is not."""

from typing import Annotated, Any, Literal, get_args

from pydantic import BeforeValidator, Field

from lienumba.errors import BadValueError
from lienumba.keys.types import Number, Positive, Section
from lienumba.mechanics.system.output_variables import OUTPUT_VARIABLES, usual

Precision = Literal["float64", "float32"]
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


def _precisions(given: object) -> Any:
    """One word for all, or one for each name."""
    flat = _flat(given)
    for name, word in flat.items() if isinstance(flat, dict) else [("", flat)]:
        if word not in get_args(Precision):
            remedy = 'give "float64" or "float32", or a table of variables such as { rotation = "float32" }'
            raise BadValueError("is no precision", remedy, name, word)
    return flat


Precisions = Annotated[Precision | dict[str, Precision], BeforeValidator(_precisions)]


def outputs_described() -> str:
    """What may be stored."""
    return "names of the variables and quantities to store: " + ", ".join(OUTPUT_VARIABLES)


class Output(Section):
    every: Positive | None = Field(default=None, description="the interval between stored times in s, above 0")
    times: Annotated[list[Number], Field(min_length=1)] | None = Field(
        default=None, description="the stored times in s, ascending, from 0 to integrator.end_time"
    )
    variables: list[str] = Field(
        default=usual(),
        description=outputs_described(),
    )
    also: list[str] = Field(
        default=[],
        description='names of what is stored beside these variables, such as "multiplier", which else is not stored',
    )
    joint_coordinates: Annotated[bool, Field(strict=True)] = Field(
        default=False,
        description="whether the coordinates of all joints are stored by one name, q, with their rates, qd, and what "
        "acts along them, tau: true or false",
    )
    precision: Precisions = Field(
        default="float64",
        description='how the file holds courses: "float64", or "float32" (rounded, half the room); one word for all, '
        'or a table of variables and quantities such as { rotation = "float32" }',
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
    show: list[str] | None = Field(
        default=None,
        description="variables, quantities and measures that the summary of the sweep shows, in this order, such as "
        '["tip", "energy"]; all by default',
    )
    at_events: list[str] = Field(
        default=[],
        description="variables, quantities or components to store where each event first happens, before it changes "
        'anything, such as ["pointing.angle", "velocity"]',
    )
    max_changes: Annotated[int, Field(strict=True, ge=1, le=100_000)] = Field(
        default=16,
        description="how many changes of a run are stored with when and what they were, from 1 to 100,000; all are "
        "counted",
    )
    full_runs: str | None = Field(
        default=None,
        description='the runs whose course is stored all the same in mode "summary", such as "0:10" or "3,17"',
    )
