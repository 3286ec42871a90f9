"""Words for what a dataset holds: what an axis shows, with its unit as people write it; how the runs ended."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from lienumba.analysis.summary import of_sweep, outcomes
from lienumba.batch.statuses import GOOD, STATUSES, SUCCESS
from lienumba.store import study_layout
from lienumba.store.layout import VARIABLES

if TYPE_CHECKING:
    import xarray as xr

EITHER = {"driver_effort": "N or N·m", "multiplier": "N or N·m"}  # units of variables that have several
POWERS = str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹")


def unit_label(units: str) -> str:
    """A unit as people write it: kg·m²/s of kg m2 s-1; nothing of 1."""
    above: list[str] = []
    below: list[str] = []
    for name, power in re.findall(r"([^\W\d]+)(-?\d*)", units):
        size = power.removeprefix("-")
        (below if power.startswith("-") else above).append(name + ("" if size == "1" else size.translate(POWERS)))
    return "/".join(["·".join(above) or "1", *below]) if above or below else ""


def words(name: str) -> str:
    """A variable in words; names that a scenario gives stay as they are."""
    return name.replace("_", " ") if name in VARIABLES or name in study_layout.VARIABLES else name


def axis_label(name: str, units: str) -> str:
    """What an axis shows, with its unit."""
    unit = EITHER.get(name) or unit_label(units)
    return words(name) + (f" ({unit})" if unit else "")


def fates(ds: xr.Dataset, remark: str = "") -> str:
    """How many runs of the sweep failed, and why, with a remark on these, and how many an event has ended; empty if all
    reached the end."""
    codes = {status.name: status.code for status in STATUSES}
    sampled = ds[[name for name in ("status", "end_time") if name in ds]].isel(run=of_sweep(ds))
    ended = [outcome for outcome in outcomes(sampled) if codes[outcome.status] != SUCCESS]
    failed = [outcome for outcome in ended if codes[outcome.status] not in GOOD]
    reasons = ", ".join(f"{outcome.count:,} {outcome.status.replace('_', ' ')}" for outcome in failed)
    count = sum(outcome.count for outcome in failed)
    stopped = sum(outcome.count for outcome in ended) - count
    said = [f"{count:,} failed ({reasons}){remark}"] if failed else []
    return "; ".join([*said, *([f"{stopped:,} stopped by events"] if stopped else [])])
