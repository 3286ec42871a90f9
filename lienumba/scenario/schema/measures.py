"""Numbers of whole runs: the list [[measures]]."""

from typing import Annotated

from pydantic import AfterValidator, Field

from lienumba.errors import BadValueError
from lienumba.keys.types import Section

LONGEST = 60  # characters of a name
FORBIDDEN = '."[]/'  # in names, which are those of variables and stand in paths


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
