"""How many runs ended in which way: those that a sweep drew, and beside them the nominal run."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from lienumba.analysis.summary import Outcome, of_sweep, outcomes
from lienumba.batch.statuses import GOOD, STATUSES, SUCCESS

if TYPE_CHECKING:
    import xarray as xr

CODES = {status.name: status.code for status in STATUSES}
NOMINAL = " and the nominal run"


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
        """Those that reached the end, or that an event ended."""
        return sum(x.count for x in self.drawn if is_good(x))

    @property
    def early(self) -> list[Outcome]:
        """What did not reach the end, the nominal run last."""
        every = [*self.drawn, *([self.nominal] if self.nominal else [])]
        return [x for x in every if CODES[x.status] != SUCCESS]

    @property
    def beside(self) -> str:
        """Words to be put behind the number of runs."""
        return NOMINAL if self.nominal else ""


def is_good(outcome: Outcome) -> bool:
    return CODES[outcome.status] in GOOD


def counts(ds: xr.Dataset) -> Counts:
    """The counts of a dataset of runs."""
    drawn = of_sweep(ds)
    known = ds[[name for name in ("status", "end_time") if name in ds]]
    nominal = None if drawn.all() else outcomes(known.isel(run=~drawn))[0]
    return Counts(outcomes(known.isel(run=drawn)), nominal)
