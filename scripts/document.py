"""Tables of a document in Markdown. Each stands there between its name and an end, as comments."""

import re
from collections.abc import Callable, Mapping, Sequence
from math import ceil, log10
from pathlib import Path

ROUNDING = 1e-13  # below this a number is rounding, and only the power of ten above it is said


def text(x: float, rounding: bool = False, digits: int = 4) -> str:
    """A number with so many digits, small ones as the paper writes them; of one that is rounding, where it may be, a
    bound."""
    if rounding and 0.0 < x < ROUNDING:
        return f"< {text(bound(x))}"
    if not x or 0.1 <= abs(x) < 1e4:
        return f"{float(f'{x:.{digits}g}'):g}"
    mantissa, power = f"{x:.{digits - 1}e}".split("e")
    return f"{float(mantissa):g}e{int(power)}"


def bound(x: float) -> float:
    """The power of ten above."""
    return float(f"1e{ceil(log10(x))}")


def markdown(head: Sequence[str], lines: Sequence[Sequence[str]]) -> str:
    return "\n".join(f"| {' | '.join(cells)} |" for cells in (head, ["---"] * len(head), *lines))


def in_document(document: Path, name: str) -> str:
    """A table as the document has it."""
    found = _place(name).search(document.read_text(encoding="utf-8"))
    if found is None:
        raise ValueError(f"{document} has no table between <!-- {name} --> and <!-- end -->")
    return found[2].strip()


def renew(document: Path, tables: Mapping[str, Callable[[], str]]) -> None:
    """Write these tables into the document."""
    for name, table in tables.items():
        in_document(document, name)
        new = table()
        whole = document.read_text(encoding="utf-8")
        document.write_text(_place(name).sub(lambda m, new=new: f"{m[1]}{new}\n{m[3]}", whole), encoding="utf-8")


def _place(name: str) -> re.Pattern[str]:
    """Where a table stands."""
    return re.compile(rf"(<!-- {re.escape(name)} -->\n)(.*?)(<!-- end -->)", re.DOTALL)
