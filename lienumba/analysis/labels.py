"""Words for what a dataset holds: what an axis shows, with its unit as people write it."""

from __future__ import annotations

from lienumba.keys.units import SUPERSCRIPTS, factors
from lienumba.store import study_layout
from lienumba.store.layout import VARIABLES

EITHER = {"driver_effort": "N or N·m", "multiplier": "N or N·m"}  # units of variables that have several
POWERS = str.maketrans("0123456789-", SUPERSCRIPTS)


def unit_label(units: str) -> str:
    """A unit as people write it: kg·m²/s of kg m2 s-1; nothing of 1, and as it is what is none."""
    found = factors(units)
    if found is None:
        return units.strip()
    above = [_raised(symbol, power) for symbol, power in found if power >= 0]
    below = [_raised(symbol, -power) for symbol, power in found if power < 0]
    return "/".join(["·".join(above) or "1", *below]) if found else ""


def _raised(symbol: str, power: float) -> str:
    size = f"{power:g}"
    return symbol + ("" if power == 1 else size.translate(POWERS) if size.isdecimal() else f"^{size}")


def named(name: str, units: str) -> str:
    """A name with its unit."""
    unit = unit_label(units)
    return name + (f" ({unit})" if unit else "")


def time_label(time: float) -> str:
    """When it is, of a time in s; nothing of NaN."""
    return f"at t = {time:g} s" if time == time else ""


def words(name: str) -> str:
    """A variable in words; names that a scenario gives stay as they are."""
    return name.replace("_", " ") if name in VARIABLES or name in study_layout.VARIABLES else name


def input_label(path: str, units: str) -> str:
    """An input by the last key of its path, with its unit."""
    return named(path.rpartition(".")[2], units)


def axis_label(name: str, units: str) -> str:
    """What an axis shows, with its unit."""
    return f"{words(name)} ({EITHER[name]})" if name in EITHER else named(words(name), units)
