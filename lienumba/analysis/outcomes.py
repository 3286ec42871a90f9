"""How the runs of a dataset ended: those that a sweep drew, and beside them the nominal run."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import zip_longest

import numpy as np
import xarray as xr

from lienumba.batch.statuses import GOOD, STATUSES, SUCCESS, Status
from lienumba.store.layout import RUN
from lienumba.sweep.design import NOMINAL_RUN

BY_NAME = {status.name: status for status in STATUSES}
BY_CODE = {status.code: status.name for status in STATUSES}
LABELS_SHOWN = 5


@dataclass(frozen=True)
class Outcome:
    """The runs that ended in one way: how many, the first labels, and the times (s) that these reached."""

    status: str
    count: int
    labels: tuple[int, ...]
    end_times: tuple[float, ...]

    @property
    def kind(self) -> Status:
        return BY_NAME[self.status]

    @property
    def good(self) -> bool:
        """Whether they reached the end, or an event ended them."""
        return self.kind.code in GOOD

    @property
    def early(self) -> bool:
        return self.kind.code != SUCCESS

    @property
    def which(self) -> str:
        """The first of them, and when they ended."""
        runs = zip_longest(self.labels, self.end_times, fillvalue=0.0)
        more = ", ..." if self.count > len(self.labels) else ""
        return ", ".join(f"{label} (at {end:g} s)" for label, end in runs) + more


@dataclass(frozen=True)
class Counts:
    """drawn: how the runs of the sweep ended; nominal: how the nominal run did, None if there is none beside others."""

    drawn: tuple[Outcome, ...]
    nominal: Outcome | None

    @property
    def runs(self) -> int:
        return sum(x.count for x in self.drawn)

    @property
    def good(self) -> int:
        return sum(x.count for x in self.drawn if x.good)

    @property
    def stopped(self) -> int:
        """How many an event has ended."""
        return sum(x.count for x in self.drawn if x.good and x.early)

    @property
    def failed(self) -> str:
        """How many failed, and why; empty if none did."""
        failed = [x for x in self.drawn if not x.good]
        reasons = ", ".join(f"{x.count:,} {x.status.replace('_', ' ')}" for x in failed)
        return f"{sum(x.count for x in failed):,} failed ({reasons})" if failed else ""

    @property
    def early(self) -> list[Outcome]:
        """What did not reach the end, the nominal run last."""
        return [x for x in (*self.drawn, *([self.nominal] if self.nominal else [])) if x.early]

    @property
    def beside(self) -> str:
        """Words to be put behind the number of runs."""
        return " and the nominal run" if self.nominal else ""


def counts(ds: xr.Dataset) -> Counts:
    """The counts of a dataset of runs."""
    drawn = of_sweep(ds)
    ends = ds[[name for name in ("status", "end_time") if name in ds]]
    nominal = None if drawn.all() else outcomes(ends.isel(run=~drawn))[0]
    return Counts(outcomes(ends.isel(run=drawn)), nominal)


def outcomes(ds: xr.Dataset) -> tuple[Outcome, ...]:
    """One entry for each status that occurs, success first, then the most frequent failures."""
    status = ds["status"]
    found = []
    for code in {int(code) for code in status.values}:
        runs = (status.values == code).nonzero()[0]
        shown = runs[:LABELS_SHOWN]
        labels = tuple(int(label) for label in ds["run"].values[shown])
        end_times = tuple(float(time) for time in ds["end_time"].values[shown]) if "end_time" in ds else ()
        found.append((code != SUCCESS, -len(runs), code, Outcome(BY_CODE[code], len(runs), labels, end_times)))
    return tuple(outcome for *_, outcome in sorted(found, key=lambda entry: entry[:3]))


def of_sweep(ds: xr.Dataset | xr.DataArray, dim: str = RUN[0]) -> np.ndarray:
    """Which runs tell how the sweep spreads (runs,): all but the nominal one, unless there is no other; dim: along
    which the runs are."""
    sampled: np.ndarray = ds[dim].values != NOMINAL_RUN
    return sampled if sampled.any() else ~sampled
