"""Text files of numbers: columns with names, separated by commas, semicolons, tabs or spaces."""

import csv
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from lienumba.errors import BadValueError
from lienumba.keys.units import factors
from lienumba.words import is_number, listed, show, suggestion

NAMES_FIRST = "give a first line with the names of the columns, numbers below"
ENDINGS = ("", ".csv", ".tsv", ".txt", ".dat", ".log")  # of such files
TIMES = ("t", "time")  # names of the column of times, where none is given
# Symbols of units whose numbers are not SI numbers.
OTHER_UNITS = {
    "ms", "us", "µs", "ns", "min", "h", "mm", "cm", "km", "in", "ft", "g", "lb", "lbf", "kN", "mN", "kW", "kPa", "MPa",
    "bar", "psi", "deg", "°", "rpm", "kNm", "Nmm",
}  # fmt: skip


@dataclass(frozen=True)
class TextTable:
    """names: of the columns; units: what the second line says of each, if it has no numbers; rows: the cells of each
    line of numbers, with the number of the line; decimal: the decimal mark."""

    names: list[str]
    units: list[str]
    rows: list[tuple[int, list[str]]]
    decimal: str

    def __getitem__(self, column: str) -> list[float]:
        """The numbers of a column by its name."""
        places = [n for n, name in enumerate(self.names) if name == column]
        if not places:
            raise BadValueError(f"has no column {show(column)}", suggestion(column, self.names))
        if len(places) > 1:
            which = listed(str(n + 1) for n in places)
            raise BadValueError(f"columns {which} are both called {show(column)}", "give each its own name")
        index = places[0]
        self._check_units(column, index)
        return [self._number(line, column, row[index] if index < len(row) else "") for line, row in self.rows]

    def _number(self, line: int, column: str, cell: str) -> float:
        try:
            return float(_pointed(cell, self.decimal))
        except ValueError:
            comma = self.decimal == "." and is_number(_pointed(cell, ","))
            rule, remedy = ("has a decimal comma", 'give decimal = ","') if comma else ("is no number", "correct it")
            raise BadValueError(f"line {line}, column {column}: {show(cell)} {rule}", remedy) from None

    def _check_units(self, column: str, index: int) -> None:
        units = self.units[index] if index < len(self.units) else ""
        if OTHER_UNITS & {symbol for symbol, _ in factors(units) or [(units, 1.0)]}:
            rule = f"column {column} is in {show(units)}, and numbers are in SI units"
            raise BadValueError(rule, "convert the column, or remove the line of units and scale the table in formulas")


def text_table(path: Path, decimal: str = ".") -> TextTable:
    """Read a file. Nothing is quoted of one that is no table: it may be somebody's secret."""
    foreign = path.suffix.lower() not in ENDINGS
    unread = BadValueError(
        f"{show(path.suffix)} is no format of tables that is read", "save it as CSV with the names of the columns first"
    )
    try:
        text = path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError:
        if foreign:
            raise unread from None
        raise
    numbered = [(n, x.strip()) for n, x in enumerate(text.splitlines(), 1) if x.strip() and x.lstrip()[0] != "#"]
    if not numbered:
        raise BadValueError("is empty", "give a first line with the names of the columns, and numbers below")
    lines = [line for _, line in numbered]
    separator = next((c for c in (",;\t" if decimal == "." else ";\t") if c in lines[0]), " ")
    names, *cells = (
        [cell.strip() for cell in row] for row in csv.reader(lines, delimiter=separator, skipinitialspace=True)
    )
    if not _are_numbers(cells, decimal):
        if decimal == "." and _are_numbers(cells, ","):
            raise BadValueError("has decimal commas", 'give decimal = ","')
        raise unread if foreign else BadValueError("is no table of numbers", NAMES_FIRST)
    if all(is_number(_pointed(cell, decimal)) for cell in names):
        raise BadValueError("has numbers in its first line, where the names of the columns belong", NAMES_FIRST)
    rows = list(zip((n for n, _ in numbered[1:]), cells, strict=True))
    if len(rows) > 1 and not _has_number(cells[0], decimal) and _has_number(cells[1], decimal):
        return TextTable(names, [cell.strip("[]()") for cell in cells[0]], rows[1:], decimal)
    return TextTable(names, [], rows, decimal)


def time_column(given: object, names: Sequence[str]) -> str:
    """The name of the column of the times."""
    if given is None:
        found = next((name for name in TIMES if name in names), None)
        if found is None:
            raise BadValueError(f"has no column {listed(map(show, TIMES), 'or')}", "give time = the name of another")
        return found
    if given not in names:
        raise BadValueError(f"has no column {show(given)}", suggestion(str(given), names))
    return str(given)


def _are_numbers(rows: Sequence[Sequence[str]], decimal: str) -> bool:
    """Whether at least half of the lines have a number."""
    return 2 * sum(_has_number(row, decimal) for row in rows) >= len(rows)


def _has_number(row: Sequence[str], decimal: str) -> bool:
    return any(is_number(_pointed(cell, decimal)) for cell in row)


def _pointed(cell: str, decimal: str) -> str:
    """A number as Python writes it."""
    return cell.replace(decimal, ".") if decimal == "," and "." not in cell else cell
