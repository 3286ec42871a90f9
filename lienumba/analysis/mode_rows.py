"""What `lienumba.modes` and `lienumba.equilibrium` found as tables."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import xarray as xr

from lienumba.analysis.text_table import TextTable, number_text
from lienumba.words import plural

MOST = 40  # rows of a table
STILL = 1e-3  # of the largest component of a shape: a centre that moves less does not move


@dataclass(frozen=True)
class ModeRows:
    """Of one time."""

    headline: str
    table: TextTable
    notes: list[str]


def mode_rows(ds: xr.Dataset) -> Iterator[ModeRows]:
    """A row for each mode: medians over the runs, with the range from 5 to 95 % where there are several."""
    many = ds.sizes["run"] > 1
    spread = ["5 %", "95 %"] if many else []
    headings = ["Hz", *spread, "damping", "growth 1/s", *(["unstable"] if many else [])]
    for time in ds["time"].values:
        own = ds.sel(time=time)
        there = own["status"] == 0
        rows = [
            [str(mode), _moving(own, mode), *_numbers(own.sel(mode=mode), many)] for mode in ds["mode"].values[:MOST]
        ]
        unstable = int((~own["stable"] & there).sum())
        notes = []
        if unstable:
            count = plural(int(there.sum()), "run", "runs")
            notes.append(f"unstable: {unstable:,} of {count}" if many else "unstable: a mode grows")
        if "crossed" in own and bool(own["crossed"].any()):
            modes = [str(mode) for mode in ds["mode"].values if bool(own["crossed"].sel(mode=mode).any())]
            notes.append(f"modes {', '.join(modes)} cross in frequency over the runs; they keep their shapes' numbers")
        if ds.sizes["mode"] > MOST:
            notes.append(f"{ds.sizes['mode'] - MOST} more modes are in the dataset")
        missing = int((~there).sum())
        if missing:
            notes.append(f"{plural(missing, 'run is', 'runs are')} not there at this time, or cannot be linearised")
        headline = f"t = {time:g} s: {plural(int(there.sum()), 'run', 'runs')}"
        yield ModeRows(headline, TextTable.of(["mode", "moves most"], headings, rows), notes)


def _numbers(own: xr.Dataset, many: bool) -> list[str]:
    def median(name: str) -> float:
        values = own[name].values
        values = values[np.isfinite(values)]
        return float(np.median(values)) if len(values) else float("nan")

    quantiles = own["frequency_quantiles"].values
    spread = [number_text(float(quantiles[n]), ".5g") for n in (0, -1)] if many else []
    frequency, growth = number_text(median("frequency"), ".6g"), number_text(median("growth"), ".4g")
    grows = int(own["grows"].sum())
    return [frequency, *spread, number_text(median("damping_ratio"), ".4g"), growth, *([f"{grows:,}"] if many else [])]


def _moving(own: xr.Dataset, mode: int) -> str:
    """The body whose centre moves most, or that turns where none does."""
    if "translation" not in own:
        return ""
    for name, what in (("translation", ""), ("turn", " turns")):
        squares = (own[name].sel(mode=mode).values ** 2).sum(axis=(-2, -1))
        squares = squares[np.isfinite(squares).all(axis=1)]
        sizes = np.sqrt(np.median(squares, axis=0)) if len(squares) else np.zeros(own.sizes["body"])
        if sizes.max() > STILL:
            return f"{own['body'].values[sizes.argmax()]}{what}"
    return ""


def equilibrium_rows(ds: xr.Dataset) -> ModeRows:
    """What `lienumba.equilibrium` found: where the mass centres rest, medians over the runs."""
    meanings = str(ds["status"].attrs["flag_meanings"]).split()
    counts = [f"{int((ds['status'] == n).sum()):,} {word.replace('_', ' ')}" for n, word in enumerate(meanings)]
    there = [f for f, n in zip(counts, range(len(meanings)), strict=True) if bool((ds["status"] == n).any())]
    position = ds["position"].values
    good = position[np.isfinite(position).all(axis=(1, 2))]
    medians = np.median(good, axis=0) if len(good) else np.full(position.shape[1:], np.nan)
    rows = [
        [str(body), *(number_text(float(x), ".6g") for x in own)]
        for body, own in zip(ds["body"].values[:MOST], medians, strict=False)
    ]
    headline = f"equilibrium of {plural(ds.sizes['run'], 'run', 'runs')}: {', '.join(there)}"
    return ModeRows(headline, TextTable.of(["mass centre of"], ["x in m", "y", "z"], rows), [])
