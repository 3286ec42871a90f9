"""Tables and recorded inputs: from CSV and netCDF files, and datasets, to the times and values that the scenario
keeps."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from lienumba.errors import BadValueError, ScenarioError, missing
from lienumba.scenario.base.paths import INPUTS, RECORDING
from lienumba.scenario.base.problems import each
from lienumba.scenario.base.text_table import text_table, time_column
from lienumba.scenario.base.toml import Keys
from lienumba.scenario.schema.tables import (
    ENDINGS,
    InputFile,
    Recording,
    TableFile,
    check_file_keys,
    decimal_of,
    offset_of,
    reading,
)
from lienumba.store.opening import netcdf_file
from lienumba.words import listed, show, suggestion

SOME = 6  # runs that are told one by one
# Keys that the numbers take the place of.
OF_FILE = ("file", "time", "value", "values", "run", "prefix", "decimal", "offset")


def with_tables(raw: Keys, folder: Path) -> Keys:
    """The scenario with the numbers of every table in place of its file, whose path is relative to this folder."""
    tables = raw.get("tables")
    if not isinstance(tables, dict):
        return raw

    def read(name: str, table: Any) -> Any:
        of_file = isinstance(table, dict) and "file" in table
        return _single(f"tables.{name}", table, folder, TableFile) if of_file else table

    return {**raw, "tables": dict(zip(tables, each(read, tables, tables.values()), strict=True))}


def with_recordings(raw: Keys, folder: Path) -> Keys:
    """The scenario with the numbers of every recorded input in place of its file, whose path is relative to this
    folder, and an input for each column of a whole recording."""
    found = _replaced(raw, folder)
    model = found.get("model")
    return {**found, "model": _replaced(model, folder)} if isinstance(model, dict) else found


def _replaced(table: Keys, folder: Path) -> Keys:
    inputs = table.get(INPUTS)
    if not isinstance(inputs, dict):
        return table
    found: Keys = {name: x for name, x in inputs.items() if name != RECORDING}

    def read(name: str, x: Any) -> None:
        if name == RECORDING:
            for place, recording in _listed(x):
                _take_all(found, place, recording, folder)
        elif isinstance(x, dict) and "file" in x:
            found[name] = _single(f"{INPUTS}.{name}", x, folder, InputFile)

    each(read, inputs, inputs.values())
    return {**table, INPUTS: found}


def _listed(recordings: object) -> Iterator[tuple[str, Keys]]:
    """Each recording with its place."""
    at = f"{INPUTS}.{RECORDING}"
    several = recordings if isinstance(recordings, list) else [recordings]
    for i, recording in enumerate(several):
        place = f"{at}[{i}]" if len(several) > 1 else at
        if not isinstance(recording, dict):
            raise ScenarioError.at(
                place, "is the name of whole recordings", f'write [{at}] with file = "commands.csv"', recording
            )
        yield place, recording


def _single(at: str, table: Keys, folder: Path, section: type[InputFile] | type[TableFile]) -> Keys:
    """One input or table with the numbers of one column."""
    check_file_keys(at, table, section)
    column = table.get("value")
    if not isinstance(column, str):
        raise ScenarioError(missing(f"{at}.value", f"give the name of a column of {table['file']} in quotes"))
    with _opened(at, table, folder) as columns:
        return {**_kept(table), "times": columns.times, "values": columns[column]}


def _take_all(read: Keys, at: str, table: Keys, folder: Path) -> None:
    """Add an input for each column."""
    check_file_keys(at, table, Recording)
    if "file" not in table:
        raise ScenarioError(missing(f"{at}.file", "give the path of a CSV or netCDF file"))
    with _opened(at, table, folder) as columns:
        named = _names(at, table, columns)
        for name, column in named.items():
            if name in read:
                raise ScenarioError.at(
                    f"{at}.file", f"its column {show(column)} gives inputs.{name}, which is there already",
                    "say with values which columns to take, or give a prefix", table["file"],
                )  # fmt: skip
            read[name] = {**_kept(table), "times": columns.times, "values": columns[column]}


def _kept(table: Keys) -> Keys:
    return {key: x for key, x in table.items() if key not in OF_FILE}


def _names(at: str, table: Keys, columns: "_Columns") -> dict[str, str]:
    """The inputs that a whole recording gives, each with its column."""
    values, prefix = table.get("values"), str(table.get("prefix", ""))
    if isinstance(values, str):
        values = columns.parts(values)
    elif isinstance(values, list):
        values = {str(column): str(column) for column in values}
    elif values is None:
        values = {column: column for column in columns.names if column != columns.time}
    if not isinstance(values, Mapping):
        remedy = 'give { input = "column" }, a list of columns, or the name of a variable of a dataset'
        raise ScenarioError.at(f"{at}.values", "must tell columns", remedy, values)
    return {f"{prefix}{name}": str(column) for name, column in values.items()}


@dataclass(frozen=True)
class _Columns:
    """names: of all columns; time: that of the times; read: the numbers of a column; labels: of variables that have
    columns of their own, the names of these by what they are of; offset: what is added to the times."""

    names: list[str]
    time: str
    read: Callable[[str], list[float]]
    labels: Mapping[str, dict[str, str]]
    offset: float = 0.0

    @property
    def times(self) -> list[float]:
        return [x + self.offset for x in self[self.time]]

    def __getitem__(self, column: str) -> list[float]:
        if column in self.labels:
            raise BadValueError(f"{show(column)} has several columns", f"give one, such as {show(self.first(column))}")
        if column not in self.names:
            raise BadValueError(f"has no column {show(column)}", suggestion(column, self.names))
        return self.read(column)

    def first(self, variable: str) -> str:
        return next(iter(self.labels[variable].values()))

    def parts(self, variable: str) -> dict[str, str]:
        """The columns of one variable of a dataset."""
        if variable not in self.labels:
            known = [*self.labels] or self.names
            raise BadValueError(f"has no variable {show(variable)} with several columns", suggestion(variable, known))
        return self.labels[variable]


@contextmanager
def _opened(at: str, table: Keys, folder: Path) -> Iterator[_Columns]:
    """The columns of the file of a table, as long as it is open; what is wrong is said at its place."""
    path, time = folder / str(table["file"]), table.get("time")
    decimal, offset = decimal_of(at, table), offset_of(at, table)
    with reading(at, table["file"], path):
        if path.suffix.lower() not in ENDINGS:
            text = text_table(path, decimal)
            yield _Columns(text.names, time_column(time, text.names), text.__getitem__, {}, offset)
            return
        with netcdf_file(path) as file:
            yield replace(_of_dataset(file, time, table.get("run", 0)), offset=offset)


def _of_dataset(file: Any, time: object, run: object) -> _Columns:
    """The variables of a netCDF file over time: of one run, and where they have one more dimension with names, a
    column for each of these."""
    time = time_column(time, list(file.variables))
    if len(file.variables[time].dimensions) != 1:
        raise BadValueError(f"its variable {time} has no single dimension", "give time = the name of another")
    (along,) = file.variables[time].dimensions
    columns: dict[str, tuple[str, tuple[Any, ...]]] = {}
    labels: dict[str, dict[str, str]] = {}
    for name, x in file.variables.items():
        kind = getattr(x.dtype, "kind", "f")
        others = [d for d in x.dimensions if d not in (along, "run")]
        if x.dimensions.count(along) != 1 or len(others) > 1 or x.dtype is str or kind not in "fiu":
            continue
        where = {along: slice(None)} | ({"run": _run(file, run)} if "run" in x.dimensions else {})
        if not others:
            columns[name] = name, tuple(where[d] for d in x.dimensions)
        else:
            (dim,) = others
            items = [str(label) for label in file.variables[dim][:]] if dim in file.variables else []
            labels[name] = {label: f"{name}[{label}]" for label in items}
            for i, column in enumerate(labels[name].values()):
                columns[column] = name, tuple({**where, dim: i}[d] for d in x.dimensions)

    def read(column: str) -> list[float]:
        name, place = columns[column]
        numbers: list[float] = np.ma.filled(np.ma.asarray(file.variables[name][place], float), np.nan).tolist()
        return numbers

    return _Columns([*columns], time, read, {name: x for name, x in labels.items() if x})


def _told(runs: Sequence[int]) -> str:
    """The first and the last of runs in a row; else some of them."""
    first, last = runs[0], runs[-1]
    if list(runs) == list(range(first, last + 1)):
        return f"{first} to {last}" if last > first else f"{first} alone"
    return listed(map(str, runs)) if len(runs) <= SOME else f"{', '.join(map(str, runs[:SOME]))}, ... and {last}"


def _run(file: Any, run: object) -> int:
    """The place of a run."""
    known = (
        [int(x) for x in file.variables["run"][:]] if "run" in file.variables else range(len(file.dimensions["run"]))
    )
    if run not in known:
        raise BadValueError(f"has no run {show(run)}", f"its runs are {_told(known)}")
    return list(known).index(run)  # type: ignore[arg-type]
