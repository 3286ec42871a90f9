"""The table of imported models as CSV, and its summary on the page."""

import csv
import math
from collections.abc import Sequence
from dataclasses import asdict, fields, replace
from pathlib import Path

from bench.importing.compare import Row

PAGE, SHEET = Path("docs/import.md"), Path("docs/import_check.csv")
BEGIN, END = "<!-- import_check -->", "<!-- /import_check -->"
CLOSE = 1e-11
SEPARATOR = "; "
OF_MOTION = ("moved", "theirs", "step", "lasted")
FIELDS = [field.name for field in fields(Row)]


def line(row: Row) -> str:
    """Of one model, for the terminal."""
    if row.refused:
        return f"{row.model}: refused: {row.refused}"
    said = f"; {row.trouble}" if row.trouble else ""
    numbers = f"accelerations {_short(row.error)}, Pinocchio {_short(row.pinocchio)}, motion {_short(row.moved)}"
    return f"{row.model}: {numbers} ({_short(row.theirs)}), {row.seconds:.2f} s{said}"


def counts(rows: Sequence[Row]) -> str:
    """How many hold."""
    close = sum(best(row) < CLOSE for row in rows)
    refused, trouble = sum(bool(row.refused) for row in rows), sum(bool(row.trouble) for row in rows)
    own = sum(row.error < CLOSE for row in rows)
    return (
        f"{len(rows)} files, {len(rows) - refused} imported: accelerations of {own} equal mj_forward's to {CLOSE:.0e}, "
        f"of {close} those of MuJoCo without its rounding or Pinocchio's; {refused} refused; {trouble} with trouble."
    )


def best(row: Row) -> float:
    """Of the three comparisons of accelerations."""
    return min((x for x in (row.error, row.refined, row.pinocchio) if not math.isnan(x)), default=math.nan)


def keep(rows: Sequence[Row], root: Path, order: Sequence[str]) -> list[Row]:
    """Renew these rows of the sheet; motions stay where these have none. Returns all of them, in this order."""
    sheet = root / SHEET
    known = {row.model: row for row in _read(sheet)}
    for row in rows:
        before = known.get(row.model)
        if before is not None and math.isnan(row.moved) and row.error < CLOSE:
            row = replace(row, **{name: getattr(before, name) for name in OF_MOTION})
        known[row.model] = row
    every = [known[name] for name in order if name in known]
    with sheet.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, FIELDS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(_cells(row) for row in every)
    return every


def write(rows: Sequence[Row], root: Path) -> None:
    """The summary, between its markers on the page."""
    page = root / PAGE
    text = page.read_text(encoding="utf-8") if page.exists() else ""
    if BEGIN not in text or END not in text:
        raise SystemExit(f"{PAGE} has no {BEGIN} ... {END}")
    before, after = text.split(BEGIN)[0], text.split(END)[1]
    page.write_text(f"{before}{BEGIN}\n{counts(rows)}\n{END}{after}", encoding="utf-8")


def _cells(row: Row) -> dict[str, object]:
    """Numbers in as many digits as mean something."""
    cells = asdict(row) | {"lost": SEPARATOR.join(row.lost), "noted": SEPARATOR.join(row.noted)}
    return {key: f"{x:.3g}" if isinstance(x, float) else x for key, x in cells.items()}


def _read(sheet: Path) -> list[Row]:
    if not sheet.exists():
        return []
    kinds = {field.name: field.type for field in fields(Row)}
    with sheet.open(newline="", encoding="utf-8") as file:
        listed = list(csv.DictReader(file))
    made = {"str": str, "int": int, "float": float, "list[str]": lambda x: x.split(SEPARATOR) if x else []}
    return [Row(**{key: made[_named(kinds[key])](x) for key, x in item.items()}) for item in listed]


def _named(kind: object) -> str:
    return kind.__name__ if kind in (str, int, float) else str(kind)  # type: ignore[attr-defined]


def _short(x: float) -> str:
    return "" if math.isnan(x) else f"{x:.0e}"
