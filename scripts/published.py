"""Numbers that others printed against those of lienumba: renews docs/evidence.md.

Each scenarios/published/NAME.numbers.toml is one result: its source, and what it printed.

    numbers       of (a variable of the dataset, with its labels: position.star1.x), value (as printed), time (default:
                  the end), factor (the printed number is this times ours), set (overrides of the scenario)
    eigenvalues   value (real and imaginary part, as printed) of lienumba modes at the start, set
    errors        of, set, and error, or printed and exact: what they err with the same settings
    bounds        of, set, below or above, says: what was claimed without digits
    time          set: the settings that just meet `below` as the error of `of` (against `exact`, 0 by default); printed

Usage: scripts/evidence [NAME]...      (about three minutes; names choose results to print instead)
"""

import math
import sys
import time
import tomllib
from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

import document
import lienumba

ROOT = Path(__file__).parents[1]
FOLDER = ROOT / "scenarios" / "published"
DOCUMENT = ROOT / "docs" / "evidence.md"
NAMES = sorted(path.name.removesuffix(".numbers.toml") for path in FOLDER.glob("*.numbers.toml"))
REPEATS = 5  # of a run, of which the fastest counts
MANY = 256  # runs at once
SLACK = 1.02  # of half a digit, where ours is rounded too
EIGENVALUE_DIGITS = 13  # of those that are printed: an eigenvalue is known to 1e-13 of the largest
Row = list[str]


@cache
def result(name: str) -> dict[str, Any]:
    """What is known of a result, with the path of its scenario."""
    known = tomllib.loads((FOLDER / f"{name}.numbers.toml").read_text(encoding="utf-8"))
    return known | {"scenario": (FOLDER / known.get("scenario", f"{name}.toml")).resolve()}


def key(settings: Mapping[str, Any]) -> tuple[tuple[str, Any], ...]:
    return tuple(settings.items())


@cache
def dataset(name: str, settings: tuple[tuple[str, Any], ...]) -> Any:
    """The only run with these settings."""
    return lienumba.run(result(name)["scenario"], overrides=dict(settings)).isel(run=0)


@cache
def eigenvalues(name: str, settings: tuple[tuple[str, Any], ...]) -> Any:
    """Those of the start, with the imaginary part of a pair positive."""
    modes = lienumba.modes(result(name)["scenario"], overrides=dict(settings), shapes=False).isel(run=0, time=0)
    return modes.growth.values + 1j * modes.angular_frequency.values


def number(ds: Any, of: str, at: float | None = None) -> float:
    """A number of a dataset by its name and labels, at a time or the last one."""
    parts = of.split(".")
    known = max(n for n in range(1, len(parts) + 1) if ".".join(parts[:n]) in ds)
    found = ds[".".join(parts[:known])]
    if "time" in found.dims:
        found = found.isel(time=-1) if at is None else found.sel(time=at, method="nearest")
    for label, dim in zip(parts[known:], found.dims, strict=True):
        found = found.sel({dim: label})
    return float(found)


# ---------------------------------------------------------------- digits
def printed_digits(text: str) -> int:
    """How many digits a printed number has; of a zero those behind the point."""
    mantissa = text.lower().split("e")[0].lstrip("-+")
    if float(text) == 0.0:
        return len(mantissa.partition(".")[2])
    return len(mantissa.replace(".", "").lstrip("0"))


def agreed_digits(text: str, here: float) -> int:
    """To how many digits a printed number and this one are the same when rounded: within half of the last one."""
    most, there = printed_digits(text), float(text)
    apart = abs(here - there) / (10.0 ** math.floor(math.log10(abs(there))) if there else 1.0)
    return most if apart == 0.0 else max(0, min(most, math.floor(-math.log10(2.0 * apart / SLACK)) + (there != 0.0)))


def agreement(text: str, here: float, most: int | None = None) -> tuple[int, int]:
    """The digits that agree, and those that are printed, or that can agree."""
    count = min(printed_digits(text), most or 99)
    return min(agreed_digits(text, here), count), count


# ---------------------------------------------------------------- tables
def numbers(name: str) -> list[Row]:
    """Name, printed, here, digits."""
    rows = []
    for one in result(name).get("numbers", []):
        ds = dataset(name, key(one.get("set", {})))
        here = one.get("factor", 1.0) * number(ds, one["of"], one.get("time"))
        title = one["of"] + (f" at {one['time']:g} s" if "time" in one else "") + told(one)
        rows.append([title, one["value"], f"{here:.16g}", "{} of {}".format(*agreement(one["value"], here))])
    return rows


def told(one: Mapping[str, Any]) -> str:
    """The settings of a row, by the last part of their names."""
    settings = one.get("set", {})
    return "".join(f", {path.rpartition('.')[2]} = {value}" for path, value in settings.items())


def eigenvalue_rows(name: str) -> list[Row]:
    rows = []
    for one in result(name).get("eigenvalues", []):
        known = eigenvalues(name, key(one["set"]))
        real, imaginary = one["value"]
        here = known[np.argmin(abs(known - complex(float(real), float(imaginary))))]
        found = [agreement(real, here.real, EIGENVALUE_DIGITS)]
        found += [agreement(imaginary, here.imag, EIGENVALUE_DIGITS)] if float(imaginary) else []
        digits = "{} of {}".format(*min(found))
        there, ours = (
            f"{a} + {b} i" if float(imaginary) else a
            for a, b in ((real, imaginary), (f"{here.real:.13g}", f"{here.imag:.13g}"))
        )
        rows.append([told(one).removeprefix(", "), there, ours, digits])
    return rows


def error_rows(name: str) -> list[Row]:
    """Name and settings, their error, ours, and how much smaller ours is."""
    rows = []
    for one in result(name).get("errors", []):
        exact = one.get("exact", 0.0)
        here = abs(number(dataset(name, key(one["set"])), one["of"]) - exact)
        there = abs(float(one["printed"]) - exact) if "printed" in one else float(one["error"])
        rows.append([one["of"] + told(one), f"{there:.2g}", f"{here:.2g}", f"{there / here:.2g}"])
    return rows


def bound_rows(name: str) -> list[Row]:
    """What was claimed, the bound, here, and whether it holds."""
    rows = []
    for one in result(name).get("bounds", []):
        here = number(dataset(name, key(one.get("set", {}))), one["of"])
        holds = here < one["below"] if "below" in one else here > one["above"]
        bound = f"< {one['below']:g}" if "below" in one else f"> {one['above']:g}"
        rows.append([one["says"], bound, f"{here:.3g}", "yes" if holds else "**no**"])
    return rows


TABLES: dict[Callable[[str], list[Row]], Row] = {
    numbers: ["", "printed", "here", "digits agreed"],
    eigenvalue_rows: ["", "printed", "here", "digits agreed"],
    error_rows: ["with the same settings", "their error", "error here", "ratio"],
    bound_rows: ["claimed", "", "here", "holds"],
}


def section(name: str) -> str:
    """All that is printed of a result, with what is known about it."""
    known = result(name)
    link = f"../{known['scenario'].relative_to(ROOT)}"
    text = [f"### {known['title']}", f"{known['source']}. Scenario: [{known['scenario'].name}]({link})."]
    text += [document.markdown(head, rows) for table, head in TABLES.items() if (rows := table(name))]
    return "\n\n".join([*text, *([known["note"]] if "note" in known else [])])


# ---------------------------------------------------------------- the whole
def least_digits(name: str) -> str:
    """The row of a result in which the smallest part of the printed digits agrees, in words."""
    digits = [row[3] for row in (*numbers(name), *eigenvalue_rows(name))]
    if digits:
        worst = min(digits, key=lambda text: int(text.split()[0]) / int(text.split()[2]))
        return f"{worst} (least of {len(digits)})" if len(digits) > 1 else worst
    bounds = bound_rows(name)
    return f"{sum(row[3] == 'yes' for row in bounds)} of {len(bounds)} claims"


def fastest(ready: Any) -> tuple[float, Any]:
    """The least wall time (s) of a prepared scenario's runs, and their dataset."""
    least, ds = math.inf, None
    for _ in range(REPEATS):
        start = time.perf_counter()
        ds = ready.run()
        least = min(least, time.perf_counter() - start)
    return least, ds


def times(name: str) -> Row:
    """How long a run takes that just meets the library's tolerance, each of many, and its error. Compiled before."""
    known = result(name).get("time")
    if known is None:
        return ["", "", ""]
    path = result(name)["scenario"]
    one, ds = fastest(lienumba.prepare(path, overrides=known["set"]))
    many, _ = fastest(lienumba.prepare(path, overrides=known["set"] | {"sweep.runs": MANY}))
    error = abs(number(ds.isel(run=0), known["of"]) - known.get("exact", 0.0))
    if not error < known["below"]:
        raise ValueError(
            f"{name}.numbers.toml: time.set: {known['of']} errs by {error:.2g}, at most {known['below']:g} counts"
        )
    return [f"{1e3 * one:.2g} ms", f"{1e3 * many / MANY:.2g} ms", f"{error:.1g}"]


def overview() -> str:
    """One row for each result."""
    rows = []
    for name in NAMES:
        known = result(name)
        anchor = "".join(c for c in known["title"].lower().replace(" ", "-") if c.isalnum() or c in "-_")
        printed = known.get("time", {}).get("printed", "")
        rows.append([f"[{known['title']}](#{anchor})", least_digits(name), *times(name), printed])
        print(name, flush=True)
    return document.markdown(["result", "digits agreed", "one run", f"each of {MANY}", "error", "printed time"], rows)


def results() -> str:
    return "\n\n".join(section(name) for name in NAMES)


def main(names: list[str]) -> int:
    if unknown := set(names) - set(NAMES):
        print(f"scripts/evidence {' '.join(unknown)}: no such result; known are {', '.join(NAMES)}", file=sys.stderr)
        return 2
    for name in names:
        print(section(name), " ".join(times(name)), sep="\n\n", end="\n\n")
    if not names:
        document.renew(DOCUMENT, {"overview": overview, "results": results})
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
