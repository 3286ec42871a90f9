"""Tables of a scenario: from a CSV or netCDF file, or written out, to functions that formulas may call."""

import csv
import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Literal, cast

import numpy as np
from pydantic import Field, ValidationError

from lienumba.errors import UNKNOWN, BadValueError, Problem, ScenarioError, missing
from lienumba.keys.formulas import LARGEST
from lienumba.keys.types import NAME, Number, Section
from lienumba.mechanics.elements.inputs.base import InputType
from lienumba.mechanics.mechanism.tables import INTERPOLATIONS, Table
from lienumba.scenario.base.toml import Keys
from lienumba.store.opening import netcdf_file
from lienumba.words import absence, is_number, show, suggestion

Interpolation = Literal["hold", "linear", "cubic"]
ENDINGS = (".nc", ".nc4", ".cdf", ".h5")


class _Table(Section):
    interpolation: Interpolation = Field(
        default="linear", description='"hold" (a value until the next), "linear" or "cubic" (a smooth spline)'
    )


class TableFile(_Table):
    """As people write it."""

    file: str = Field(description="the path of a CSV or netCDF file, relative to the scenario")
    time: str = Field(description="the column or variable of the times, or whatever the table depends on")
    value: str = Field(description="the column or variable of the values")


class InputFile(InputType, _Table):
    """An input that is recorded, as people write it."""

    file: str = Field(description="the path of a CSV or netCDF file, or of a dataset, relative to the scenario")
    time: str | None = Field(default=None, description='the column of the times (or omit it: "t" or "time")')
    value: str = Field(description='the column of the values; of a dataset such as "tau[elbow]"')
    run: int = Field(default=0, description="the run, of a dataset")
    delay: Number = Field(default=0.0, description="by how much later in s it is played")


class Recording(InputType, _Table):
    """Inputs of one file, as people write them: one for each column."""

    file: str = Field(description="the path of a CSV or netCDF file, or of a dataset, relative to the scenario")
    time: str | None = Field(default=None, description='the column of the times (or omit it: "t" or "time")')
    values: dict[str, str] | list[str] | str | None = Field(
        default=None,
        description="the columns by the names of the inputs, a list of columns, or the name of a variable of a dataset "
        'that has several, such as "tau" (or omit it: all columns)',
    )
    run: int = Field(default=0, description="the run, of a dataset")
    prefix: str = Field(default="", description="what the names of the inputs begin with, before those of the columns")
    delay: Number = Field(default=0.0, description="by how much later in s it is played")


class TableSection(_Table):
    """As the scenario keeps it: with its numbers, whichever file they came from."""

    times: list[float] = Field(description="the arguments, ascending: the times in s, or whatever the table depends on")
    values: list[float] = Field(description="the values, one for each of the times")


def inlined(raw: Keys, folder: Path) -> Keys:
    """The scenario with the numbers of every table in place of its file, whose path is relative to this folder."""
    tables = raw.get("tables")
    if not isinstance(tables, dict):
        return raw
    problems: list[Problem] = []
    read = {}
    for name, table in tables.items():
        try:
            read[name] = _inlined(name, table, folder) if isinstance(table, dict) and "file" in table else table
        except ScenarioError as error:
            problems += error.problems
    if problems:
        raise ScenarioError(*problems)
    return {**raw, "tables": read}


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
            interpolation = table.get("interpolation", "linear")
            found[name] = Table.of(table["times"], table["values"], interpolation)
    return found, problems


def _problem(table: Keys) -> Problem | None:
    """What is wrong with the keys or numbers of a table."""
    known = list(TableSection.model_fields)
    for key in table:
        if key not in known:
            return Problem(key, "", suggestion(key, [*TableFile.model_fields, *known]), verb=UNKNOWN)
    for key in ("times", "values"):
        if key not in table:
            return missing(key, 'give file = "profile.csv" with time and value, or times and values')
    kind = table.get("interpolation", "linear")
    if kind not in INTERPOLATIONS:
        return Problem("interpolation", "is not known", suggestion(str(kind), INTERPOLATIONS), kind)
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


def _inlined(name: str, table: Keys, folder: Path) -> Keys:
    """A table with its numbers; other keys stay."""
    at, path = f"tables.{name}", folder / str(table["file"])
    for key in ("times", "values"):
        if key in table:
            raise ScenarioError.at(
                f"{at}.{key}", "the numbers come from file already", "leave out either file or times and values"
            )
    columns = [table.get("time"), table.get("value")]
    for key, column in zip(("time", "value"), columns, strict=True):
        if not isinstance(column, str):
            raise ScenarioError(missing(f"{at}.{key}", f"give the name of a column of {table['file']} in quotes"))
    with reading(at, table["file"], path):
        read = _netcdf if path.suffix.lower() in ENDINGS else _csv
        times, values = read(path, [str(c) for c in columns])
    kept = {key: item for key, item in table.items() if key not in ("file", "time", "value")}
    return {**kept, "times": times, "values": values}


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


def _csv(path: Path, columns: Sequence[str]) -> list[list[float]]:
    names, rows = csv_rows(path)
    return [csv_column(column, names, rows) for column in columns]


def csv_rows(path: Path) -> tuple[list[str], list[tuple[int, list[str]]]]:
    """The names in the first line, and the cells of each line below with its number; separated by commas, semicolons,
    tabs or spaces. Nothing is quoted of a file that is no table: it may be somebody's secret."""
    lines = [
        (number, line.strip())
        for number, line in enumerate(path.read_text(encoding="utf-8-sig").splitlines(), 1)
        if line.strip() and not line.lstrip().startswith("#")
    ]
    if not lines:
        raise BadValueError("is empty", "give a first line with the names of the columns, and numbers below")
    head = lines[0][1]
    separator = next((c for c in ",;\t" if c in head), " ")
    rows = list(csv.reader([line for _, line in lines], delimiter=separator, skipinitialspace=True))
    if 2 * sum(any(map(is_number, row)) for row in rows[1:]) < len(rows) - 1:
        raise BadValueError("is no table of numbers", "give a first line with the names of the columns, numbers below")
    return [cell.strip() for cell in rows[0]], [(n, row) for (n, _), row in zip(lines[1:], rows[1:], strict=True)]


def csv_column(column: str, names: Sequence[str], rows: Sequence[tuple[int, list[str]]]) -> list[float]:
    """The numbers of a column by its name."""
    if column not in names:
        raise BadValueError(f"has no column {show(column)}", suggestion(column, names))
    index = names.index(column)
    numbers = []
    for line, row in rows:
        try:
            numbers.append(float(row[index]))
        except (ValueError, IndexError):
            cell = row[index] if index < len(row) else ""
            raise BadValueError(f"line {line}, column {column}: {show(cell)} is no number", "correct it") from None
    return numbers


def _netcdf(path: Path, columns: Sequence[str]) -> list[list[float]]:
    """Variables of one dimension by their names."""
    with netcdf_file(path) as file:
        found: list[list[float]] = []
        for column in columns:
            if column not in file.variables:
                raise BadValueError(f"has no variable {show(column)}", suggestion(column, list(file.variables)))
            values: Any = np.ma.filled(np.ma.asarray(file.variables[column][:], float), np.nan)
            if values.ndim != 1:
                raise BadValueError(f"the variable {column} has {values.ndim} dimensions", "give one of 1 dimension")
            found.append(values.tolist())
    return found
