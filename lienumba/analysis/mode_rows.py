"""What `lienumba.modes` and `lienumba.equilibrium` found as tables."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import xarray as xr

from lienumba.analysis.sensitivities.ranks import standard_ranks
from lienumba.analysis.text_table import ROUNDING, TextTable, number_text
from lienumba.analysis.weights import weights_of, weights_told
from lienumba.store.linear_layout import GIVEN, STORED
from lienumba.sweep import weighted
from lienumba.sweep.design import NOMINAL_RUN
from lienumba.words import listed, plural

MOST = 40  # rows of a table
UNLIKE = 0.5  # the MAC below which it is not certain that two shapes are of one mode
STILL = 1e-3  # of the largest component of a shape: a centre that moves less does not move


@dataclass(frozen=True)
class ModeRows:
    """Of one time."""

    headline: str
    table: TextTable
    notes: list[str]


def mode_rows(ds: xr.Dataset) -> Iterator[ModeRows]:
    """A row for each mode: medians over the sampled runs, with the range from 5 to 95 % where there are several."""
    whole, ds = ds, sampled(ds)
    beside = " beside the nominal one" if ds.sizes["run"] < whole.sizes["run"] else ""
    many = ds.sizes["run"] > 1

    def spread(what: str) -> list[str]:
        return [what, f"{what} 5 %", f"{what} 95 %"] if many else [what]

    headings = [*spread("Hz"), *spread("damping"), "growth 1/s", *(["unstable"] if many else [])]
    why = str(ds["origin"].attrs.get("comment", "")) if "origin" in ds else ""
    for time in ds["time"].values:
        own = ds.sel(time=time)
        there = own["status"] == 0
        fastest = float(np.nanmax(np.hypot(own["growth"].values, own["angular_frequency"].values), initial=0.0))
        rows = [
            [str(mode), _moving(own, mode), *_numbers(own.sel(mode=mode), many, fastest)]
            for mode in ds["mode"].values[:MOST]
        ]
        runs = plural(int(there.sum()), "run", "runs")
        headline, notes = f"t = {time:g} s: {runs}{beside}", list(_notes(own, int(there.sum()), many))
        if "origin" in own and int(own["origin"]) != GIVEN:
            stored = int(own["origin"]) == STORED
            headline += ", states as stored" if stored else ", simulated up to there"
            notes += [why] if why and not stored else []
            why = why if stored else ""
        yield ModeRows(headline, TextTable.of(["mode", "moves most"], headings, rows), notes)


def sampled(ds: xr.Dataset) -> xr.Dataset:
    """Without the nominal run, if there are others."""
    which = ds["run"].values != NOMINAL_RUN
    return ds.isel(run=which) if which.any() and not which.all() else ds


def swept(ds: xr.Dataset, most: int) -> list[str]:
    """The swept numbers with which frequencies go most: by the largest rank correlation with any of them."""
    names = [str(name) for name, x in ds.coords.items() if x.attrs.get("role") == "input"]
    if len(names) <= most:
        return names
    there = (ds["status"] == 0).values.all(axis=1)
    if not there.any():
        return names[:most]
    frequency = ds["frequency"].values[there].reshape(int(there.sum()), -1)
    frequency = frequency[:, np.isfinite(frequency).all(axis=0)]
    varying = np.ptp(frequency, axis=0) > ROUNDING * np.abs(frequency).max(axis=0, initial=0.0)
    ranks = [standard_ranks(x) for x in frequency[:, varying].T]
    strength = []
    for own in (standard_ranks(ds[name].values[there]) for name in names):
        strength.append(max((abs(float(own @ x)) for x in ranks), default=0.0) if np.isfinite(own).all() else 0.0)
    best = sorted(np.argsort(strength, kind="stable")[::-1][:most].tolist())
    return [names[n] for n in best]


def unstable(own: xr.Dataset) -> int:
    """How many runs, of those that are there, have a mode that grows."""
    return int((~own["stable"] & (own["status"] == 0)).sum())


def _notes(own: xr.Dataset, there: int, many: bool) -> Iterator[str]:
    """What is to be said of the modes at a time."""
    if grow := unstable(own):
        yield f"unstable: {grow:,} of {plural(there, 'run', 'runs')}" if many else "unstable: a mode grows"
    if "crossed" in own and bool(own["crossed"].any()):
        modes = [str(mode) for mode in own["mode"].values if bool(own["crossed"].sel(mode=mode).any())]
        crossing = f"{'modes' if len(modes) > 1 else 'mode'} {listed(modes)}"
        yield f"{crossing} cross in frequency over the runs; they keep the numbers of their shapes"
    frequency, growth = own["frequency"].values, own["growth"].values
    for n, mode in enumerate(own["mode"].values):
        still = int(((frequency[:, n] == 0.0) & (growth[:, n] != 0.0)).sum())
        has = int(np.isfinite(growth[:, n]).sum())
        if 0 < still < has:
            yield f"mode {mode} does not swing in {still:,} of {has:,} runs: there its eigenvalue is real"
        if has < there:
            yield f"mode {mode} is there in {has:,} of {there:,} runs"
        unlike = int((own["mac"].values[:, n] < UNLIKE).sum()) if "mac" in own else 0
        if unlike:
            yield f"mode {mode} has a shape of its own in {plural(unlike, 'run', 'runs')}: it may be another mode there"
    weights = weights_of(own)
    if weights is not None:
        yield weights_told(weights)
    if own.sizes["mode"] > MOST:
        yield f"{own.sizes['mode'] - MOST} more modes are in the dataset"
    if missing := own.sizes["run"] - there:
        yield f"{plural(missing, 'run is', 'runs are')} not there at this time, or cannot be linearised"


def _numbers(own: xr.Dataset, many: bool, fastest: float) -> list[str]:
    """fastest: the largest eigenvalue of all modes."""
    grows = [f"{int(own['grows'].sum()):,}"] if many else []
    frequency = _quantiles(own["frequency_quantiles"].values, ".6g", many)
    damping = _quantiles(own["damping_ratio_quantiles"].values, ".4g", many, 1.0)
    there = np.isfinite(own["growth"].values)
    growth, weights = own["growth"].values[there], weights_of(own, there)
    (median,) = weighted.quantiles(growth, weights, (0.5,)) if len(growth) else (np.nan,)
    return [*frequency, *damping, number_text(median, ".4g", fastest), *grows]


def _quantiles(own: np.ndarray, digits: str, many: bool, scale: float = 0.0) -> list[str]:
    """The median, and the range, of one that is not there in any run NaN; scale: see `number_text`."""
    low, middle, high = (number_text(float(x), digits, scale) for x in own)
    return [middle, low, high] if many else [middle]


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
