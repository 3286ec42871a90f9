"""How the runs of a dataset ended: those that a sweep drew, and beside them the nominal run."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import zip_longest

import numpy as np
import xarray as xr

from lienumba.batch.statuses import GOOD, STATUSES, SUCCESS, UNDEFINED, Status
from lienumba.store.layout import RUN, VARIABLES
from lienumba.sweep.design import NOMINAL_RUN

BY_NAME = {status.name: status for status in STATUSES}
BY_CODE = {status.code: status.name for status in STATUSES}
LABELS_SHOWN = 5


@dataclass(frozen=True)
class Outcome:
    """The runs that ended in one way: how many, the first labels, and the times (s) that these reached; places: of
    undefined quantities, which and when, in words."""

    status: str
    count: int
    labels: tuple[int, ...]
    end_times: tuple[float, ...]
    places: tuple[str, ...] = ()

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
        ends = (f"at {end:g} s" for _, end in zip_longest(self.labels, self.end_times, fillvalue=0.0))
        more = ", ..." if self.count > len(self.labels) else ""
        runs = zip(self.labels, self.places or ends, strict=True)
        return ", ".join(f"{label} ({place})" for label, place in runs) + more


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
    nominal = None if drawn.all() else outcomes(ds, ~drawn)[0]
    return Counts(outcomes(ds, drawn), nominal)


def outcomes(ds: xr.Dataset, which: np.ndarray | None = None) -> tuple[Outcome, ...]:
    """One entry for each status that occurs, success first, then the most frequent failures; which (runs,): of these
    runs."""
    status, asked = ds["status"].values, np.ones(ds.sizes["run"], bool) if which is None else which
    found = []
    for code in {int(code) for code in status[asked]}:
        runs = ((status == code) & asked).nonzero()[0]
        shown = runs[:LABELS_SHOWN]
        labels = tuple(int(label) for label in ds["run"].values[shown])
        end_times = tuple(float(time) for time in ds["end_time"].values[shown]) if "end_time" in ds else ()
        places = tuple(_undefined(ds, int(run)) for run in shown) if code == UNDEFINED else ()
        found.append((code != SUCCESS, -len(runs), code, Outcome(BY_CODE[code], len(runs), labels, end_times, places)))
    return tuple(outcome for *_, outcome in sorted(found, key=lambda entry: entry[:3]))


def _undefined(ds: xr.Dataset, run: int) -> str:
    """What of a run is not finite first, and when: a course, or a summary of a quantity."""
    every = [(name, x) for name, x in ds.data_vars.items() if x.dims[:1] == RUN and x.dtype.kind == "f"]
    own = [x.isel(run=run) for name, x in every if name not in VARIABLES or "time" in x.dims]
    first: dict[str, float] = {}
    for x in (x for x in own if "event" not in x.dims):
        timed = "time" in x.dims
        bad = ~np.isfinite(x.transpose("time", ...).values) if timed else ~np.isfinite(x.values)
        if bad.any():
            first[str(x.name)] = (
                float(ds["time"].values[bad.reshape(len(bad), -1).any(axis=1).argmax()]) if timed else np.inf
            )
    if not first:
        return "a quantity that is not stored"
    name = min(first, key=lambda one: first[one])
    return f"{name} at {first[name]:g} s" if first[name] < np.inf else name


def of_sweep(ds: xr.Dataset | xr.DataArray, dim: str = RUN[0]) -> np.ndarray:
    """Which runs tell how the sweep spreads (runs,): all but the nominal one, unless there is no other; dim: along
    which the runs are."""
    sampled: np.ndarray = ds[dim].values != NOMINAL_RUN
    return sampled if sampled.any() else ~sampled
