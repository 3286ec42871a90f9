"""The table of imported models, for people and as CSV."""

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
STILL = "has nothing that moves"
OF_MOTION = ("moved", "theirs", "step", "lasted")
FIELDS = [field.name for field in fields(Row)]
HEAD = (
    "model", "links", "coordinates", "loops", "import s", "accelerations", "refined", "by Pinocchio", "moved m",
    "MuJoCo itself m", "s", "not compared",
)  # fmt: skip


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


def markdown(rows: Sequence[Row]) -> str:
    """The table, and what has nothing that moves."""
    lines = [f"| {' | '.join(HEAD)} |", "|---|" + "---:|" * (len(HEAD) - 2) + "---|"]
    still = [row.model for row in rows if STILL in row.refused]
    for row in (row for row in rows if row.model not in still):
        if row.refused:
            lines.append(f"| {row.model} |{' |' * (len(HEAD) - 2)} refused: {_cell(row.refused)} |")
            continue
        told = "; ".join([*row.lost, *([row.trouble] if row.trouble else [])])
        numbers = [row.links, row.coordinates, row.loops or "", f"{row.seconds:.2f}"]
        numbers += map(_short, (row.error, row.refined, row.pinocchio, row.moved, row.theirs))
        lines.append(f"| {' | '.join(map(str, [row.model, *numbers, _plain(row.lasted), _cell(told)]))} |")
    return "\n".join([*lines, "", f"Refused, since nothing in them moves: {', '.join(still)}."])


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
    """The table, between its markers on the page."""
    page = root / PAGE
    text = page.read_text(encoding="utf-8") if page.exists() else ""
    if BEGIN not in text or END not in text:
        raise SystemExit(f"{PAGE} has no {BEGIN} ... {END}")
    before, after = text.split(BEGIN)[0], text.split(END)[1]
    page.write_text(f"{before}{BEGIN}\n{counts(rows)}\n\n{markdown(rows)}\n{END}{after}", encoding="utf-8")


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


def _plain(x: float) -> str:
    return "" if math.isnan(x) else f"{x:g}"


def _cell(text: str) -> str:
    return " ".join(text.split()).replace("|", "\\|")
