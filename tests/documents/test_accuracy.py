"""The numbers of docs/accuracy.md that are the same on every machine are true; a selection of its rows is computed
again, to two digits. Its times are not looked at."""

import re

import pytest

from tests.facade import METHODS
from tests.rigs.places import scripts_on_path

with scripts_on_path():
    import document
    from precision import long_time, slopes, tables, tolerances, work

NUMBER = re.compile(r"-?\d[\d,]*\.?\d*(?:e-?\d+)?")
PRECISE = 0.02  # two digits


def rows(name: str) -> list[list[str]]:
    """The cells of a table in the document, without its head."""
    lines = document.in_document(tables.DOCUMENT, name).splitlines()
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines[2:]]


def row(name: str, *first: str) -> list[str]:
    (found,) = (cells for cells in rows(name) if cells[: len(first)] == [*first])
    return found


def same(found: list[str], wanted: list[str]) -> None:
    """Equal but for the third digit of numbers."""
    assert [NUMBER.sub("#", cell) for cell in found] == [NUMBER.sub("#", cell) for cell in wanted], (
        "scripts/accuracy renews docs/accuracy.md"
    )
    for one, other in zip(found, wanted, strict=True):
        for x, y in zip(NUMBER.findall(one), NUMBER.findall(other), strict=True):
            last = 0.0 if "e" in y else 0.011  # of an interval that is rounded up to hundredths
            exact = float(y.replace(",", ""))
            assert float(x.replace(",", "")) == pytest.approx(exact, rel=PRECISE, abs=last), (found, wanted)


def test_every_table_is_there() -> None:
    for name in tables.TABLES:
        assert rows(name), name


@pytest.mark.release
@pytest.mark.parametrize("name", ["heavy top"])
def test_orders(name: str) -> None:
    lines = slopes.table(name).splitlines()[2:]
    for line, wanted in zip(lines, rows(f"orders, {name}"), strict=True):
        same([cell.strip() for cell in line.strip("|").split("|")], wanted)


@pytest.mark.parametrize("name", slopes.CASES)
def test_the_order_does_not_drop_with_projection(name: str) -> None:
    """In the document: the slope at the finest steps is that of the method, or more."""
    for method, *cells in rows(f"orders, {name}"):
        order = METHODS[method].order
        for cell in cells:
            assert float(cell.split("(")[1].strip(")")) > order - 0.4


@pytest.mark.release
def test_adaptive_steps() -> None:
    wanted = [cells for cells in rows("adaptive, satellite") if cells[0] == "dop853"]
    for found, cells in zip(work.adaptive_rows("satellite", "dop853"), wanted, strict=True):
        same(found, cells)


@pytest.mark.release
@pytest.mark.parametrize("method", ["dp54", "dop853"])
def test_tolerances(method: str) -> None:
    n = tolerances.PAIRS.index(method)
    same(tolerances.column("heavy top", method), [cells[n + 1] for cells in rows("tolerances, heavy top")])


@pytest.mark.parametrize("name", tolerances.CASES)
def test_errors_fall_with_every_tolerance(name: str) -> None:
    assert set(row(f"tolerances, {name}", "monotone")[1:]) == {"yes"}


@pytest.mark.release
@pytest.mark.parametrize(
    ("name", "method", "form"),
    [
        ("heavy top", "euler", "projected"),
        ("free body", "rk4", "R^3 x SO(3)"),
        ("heavy top", "rk4", "projected"),
        ("heavy top", "rk4", "SE(3)"),
        ("heavy top", "rk4", "nine elements"),
        ("heavy top", "dop853", "projected"),
        ("free body", "dop853", "SE(3)"),
    ],
)
def test_a_million_steps(name: str, method: str, form: str) -> None:
    same(long_time.row(name, method, form), row(f"long, {name}", method, form))


def test_numbers_are_compared_to_two_digits() -> None:
    same(["rk4", "1.01e-9", "> 50,000"], ["rk4", "1e-9", "> 50,000"])
    with pytest.raises(AssertionError):
        same(["30,000"], ["31,000"])
    with pytest.raises(AssertionError):
        same(["1e-9"], ["< 1e-9"])
    with pytest.raises(AssertionError):
        same(["1.1e-9"], ["1e-9"])
