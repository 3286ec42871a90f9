"""Tables of a scenario: from a CSV or netCDF file, or written out, to functions that formulas may call."""

import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Literal, cast

from pydantic import Field, ValidationError

from lienumba.errors import UNKNOWN, BadValueError, Problem, ScenarioError, missing
from lienumba.keys.formulas import LARGEST
from lienumba.keys.types import NAME, Number, Section
from lienumba.mechanics.elements.inputs.base import InputType
from lienumba.mechanics.elements.inputs.forms import OUTSIDE_DESCRIBED, Outside
from lienumba.mechanics.mechanism.tables import HOLD, INTERPOLATIONS, OUTSIDE, Table
from lienumba.scenario.base.toml import Keys
from lienumba.words import absence, suggestion

Interpolation = Literal["hold", "linear", "cubic"]
ENDINGS = (".nc", ".nc4", ".cdf", ".h5")


class _Table(Section):
    interpolation: Interpolation = Field(
        default="linear", description='"hold" (a value until the next), "linear" or "cubic" (a smooth spline)'
    )
    outside: Outside | None = Field(default=None, description=OUTSIDE_DESCRIBED)


class _File(_Table):
    """Keys of a file, which its numbers take the place of."""

    file: str = Field(description="the path of a CSV or netCDF file, relative to the scenario")
    time: str | None = Field(
        default=None, description='the column of the times, or whatever it depends on (or omit it: "t" or "time")'
    )
    decimal: Literal[".", ","] = Field(default=".", description='the decimal mark of a text file: "." or ","')
    offset: Number = Field(default=0.0, description="a number in s that is added to the times of the file")
    run: int = Field(default=0, description="the run, of a dataset")


class TableFile(_File):
    """As people write it."""

    value: str = Field(description="the column or variable of the values")


class InputFile(InputType, _File):
    """An input that is recorded, as people write it."""

    value: str = Field(description='the column of the values; of a dataset such as "tau[elbow]"')
    delay: Number = Field(default=0.0, description="by how much later in s it is played")


class Recording(InputType, _File):
    """Inputs of one file, as people write them: one for each column."""

    values: dict[str, str] | list[str] | str | None = Field(
        default=None,
        description="the columns by the names of the inputs, a list of columns, or the name of a variable of a dataset "
        'that has several, such as "tau" (or omit it: all columns)',
    )
    prefix: str = Field(default="", description="what the names of the inputs begin with, before those of the columns")
    delay: Number = Field(default=0.0, description="by how much later in s it is played")


class TableSection(_Table):
    """As the scenario keeps it: with its numbers, whichever file they came from."""

    times: list[float] = Field(description="the arguments, ascending: the times in s, or whatever the table depends on")
    values: list[float] = Field(description="the values, one for each of the times")


def tables_of(raw: Keys) -> tuple[dict[str, Table], list[Problem]]:
    """The tables of a scenario by name, and what is wrong with them."""
    section = raw.get("tables", {})
    if not isinstance(section, dict):
        return {}, [Problem("tables", "must be a table of tables", "write [tables.thruster] and its keys below")]
    found: dict[str, Table] = {}
    problems: list[Problem] = []
    for name, table in section.items():
        at = f"tables.{name}"
        if not re.fullmatch(NAME, name):
            problems.append(Problem(at, "is no valid name", 'give a letter, then letters, digits or "_"'))
        elif not isinstance(table, dict):
            problems.append(Problem(at, "must be a table", 'give file = "profile.csv", time and value', table))
        elif wrong := _problem(table):
            problems.append(wrong.below(at))
        else:
            interpolation, outside = table.get("interpolation", "linear"), table.get("outside")
            found[name] = Table.of(table["times"], table["values"], interpolation, outside)
    return found, problems


def _problem(table: Keys) -> Problem | None:
    """What is wrong with the keys or numbers of a table."""
    known = list(TableSection.model_fields)
    for key in table:
        if key in TableFile.model_fields and key not in known:
            return missing("file", f"{key} is of a file: give the path of a CSV or netCDF file, or leave {key} out")
        if key not in known:
            return Problem(key, "", suggestion(key, [*TableFile.model_fields, *known]), verb=UNKNOWN)
    for key in ("times", "values"):
        if key not in table:
            return missing(key, 'give file = "profile.csv" with time and value, or times and values')
    kind = table.get("interpolation", "linear")
    if kind not in INTERPOLATIONS:
        return Problem("interpolation", "is not known", suggestion(str(kind), INTERPOLATIONS), kind)
    if isinstance(outside := table.get("outside", HOLD), bool) or outside not in OUTSIDE:
        return Problem("outside", 'must be "hold", 0 or "error"', f"give {OUTSIDE_DESCRIBED}", outside)
    try:
        TableSection.model_validate(table)
    except ValidationError as error:
        where, *place = error.errors()[0]["loc"]
        if place:
            return Problem(f"{where}[{place[0]}]", "must be a number", "correct it")
        return Problem(str(where), "must be a list of numbers")
    return points_problem(table)


def points_problem(table: Keys) -> Problem | None:
    """What is wrong with the points of a table that has times and values, lists of numbers."""
    times, values = (cast(list[float], table[key]) for key in ("times", "values"))
    if len(times) != len(values):
        return Problem("", f"has {len(times)} times and {len(values)} values", "give one value for each time")
    if len(times) < 2:
        return Problem("", f"has {len(times)} of at least 2 points", "give more, or write a number instead")
    for key, numbers in (("times", times), ("values", values)):
        for i, x in enumerate(numbers):
            if isinstance(x, str) or not abs(x) <= LARGEST:
                return Problem(f"{key}[{i}]", "must be a finite number", "correct it, or leave the point out", x)
    for i in range(1, len(times)):
        if not times[i] > times[i - 1]:
            rule = f"does not come after {times[i - 1]!r}"
            return Problem(f"times[{i}]", rule, "the times must increase", times[i])
    return None


def check_file_keys(at: str, table: Keys, section: type[TableFile] | type[InputFile] | type[Recording]) -> None:
    """What must be right in a table before its file is read."""
    for key in ("times", "values"):
        if key in table and key not in section.model_fields:
            raise ScenarioError.at(
                f"{at}.{key}", "the numbers come from file already", "leave out either file or times and values"
            )
    for key in table:
        if key not in section.model_fields:
            raise ScenarioError(Problem(f"{at}.{key}", "", suggestion(key, section.model_fields), verb=UNKNOWN))


def decimal_of(at: str, table: Keys) -> str:
    """The decimal mark of a text file."""
    decimal = table.get("decimal", ".")
    if decimal not in (".", ","):
        raise ScenarioError.at(f"{at}.decimal", 'must be "." or ","', "give one of them", decimal)
    return str(decimal)


def offset_of(at: str, table: Keys) -> float:
    """What is added to the times of a file."""
    offset = table.get("offset", 0.0)
    if isinstance(offset, bool) or not isinstance(offset, int | float) or not abs(offset) <= LARGEST:
        remedy = "give what is added to the times of the file in s"
        raise ScenarioError.at(f"{at}.offset", "must be a finite number", remedy, offset)
    return offset


def check_file(at: str, path: Path, value: object) -> None:
    """There must be a file where the scenario says so."""
    try:
        if path.is_dir():
            raise ScenarioError.at(at, "is a folder", "give the path of a file in it", value)
        if not path.is_file():
            raise ScenarioError.at(at, *absence(path, (path.suffix,), "there is no such file"), value)
    except OSError as error:  # such as a name that is too long
        raise ScenarioError.at(at, f"cannot be read ({error.strerror})", "check the path", value) from None


@contextmanager
def reading(at: str, file: object, path: Path, key: str = "file") -> Iterator[None]:
    """Say of a file that the scenario names at a place what is wrong with it."""
    at_file, value = f"{at}.{key}", file
    if not isinstance(file, str):
        raise ScenarioError.at(at_file, "must be a text in quotes", "give the path of a file", value)
    check_file(at_file, path, value)
    try:
        yield
    except UnicodeDecodeError:
        raise ScenarioError.at(at_file, "is no text in UTF-8", "save it as UTF-8", value) from None
    except OSError as error:
        raise ScenarioError.at(at_file, f"cannot be read ({error.strerror})", "check the file", value) from None
    except BadValueError as error:
        raise ScenarioError(error.at(at_file, value)) from None
    except ValueError as error:
        raise ScenarioError.at(at_file, str(error), value=value) from None
