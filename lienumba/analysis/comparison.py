"""Two sweeps run by run: what the one design does that the other does not.

Runs with the same label are pairs. With the same seed and sampler they have the same samples, so that what both designs
share falls out of the difference: of pairs with a correlation r its variance is 1 - r of that of independent runs.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import xarray as xr

from lienumba.analysis.requirements.verdict import counted, verdicts_of
from lienumba.analysis.sensitivities import outputs
from lienumba.analysis.sensitivities.outputs import Output
from lienumba.analysis.sensitivities.ranks import rank_interval, standard_ranks
from lienumba.analysis.weights import weights_of, weights_told
from lienumba.batch.statuses import GOOD
from lienumba.errors import ScenarioError
from lienumba.scenario.base.paths import PLACES
from lienumba.store.form import ORDER, by_path, scenario_tables
from lienumba.store.layout import FAILED, MET
from lienumba.store.study_layout import is_study
from lienumba.sweep import weighted
from lienumba.words import listed, plural, show

CONFIDENCE = 0.95
FEWEST = 2  # pairs, which give the first interval
MOST_CHANGES = 20  # of the scenario that are told
ALIKE = 0.9  # rank correlation of samples, at least
MOST_LONELY = 4  # outputs
NAMED = {  # what the columns are; in the unit of the output where "" stands
    "mean_a": ("", "mean of the first over the pairs"),
    "mean_b": ("", "mean of the second over the pairs"),
    "difference": ("", "mean of second minus first"),
    "difference_low": ("", "lower end of the 95 % confidence interval of the difference"),
    "difference_high": ("", "upper end of the 95 % confidence interval of the difference"),
    "larger": ("1", "part of the pairs in which the second is larger"),
    "correlation": ("1", "correlation of both over the pairs"),
    "pairs": ("1", "runs that are good and have a value in both"),
}


def compare(
    first: xr.Dataset, second: xr.Dataset, output: str | Sequence[str] = (), time: float | None = None
) -> xr.Dataset:
    """Paired differences of two sweeps, over the runs that both have.

    Parameters
    ----------
    first, second : xarray.Dataset
        What `lienumba.run` returned of two designs, best with the same seed and sampler.
    output : str or sequence of str
        Names such as `tip` or `position.top.z`, or `failed`; requirements and those that say most in both if omitted.
    time : float, optional
        A stored time in s at which series are read; the last if omitted.

    Returns
    -------
    xarray.Dataset
        On the dimension `output`: `mean_a`, `mean_b`, their `difference` from `difference_low` to `difference_high`
        (Student's t of the pairs; of `failed` and of `requirement_met` Clopper's and Pearson's bounds for either kind
        of pair that differs, which hold at least 95 %), `larger`, `correlation`, `pairs`. The attribute `changes` says
        what the scenarios differ in, `verdicts` what each shows of the requirements of both, `notes` what to beware of.

    Raises
    ------
    ScenarioError
        Where they have no runs or outputs in common.
    """
    for ds in (first, second):
        if is_study(ds):
            raise ScenarioError("a study compares settings already; give two datasets of sweeps")
    one, other = _paired(first, second)
    sampled = counted(one) & counted(other)
    names = [output] if isinstance(output, str) else list(output)
    own, theirs = ([] if names else outputs.default_outputs(ds) for ds in (one, other))
    shared = [name for name in own if name in set(theirs)]
    chosen, left_out = names or shared[: outputs.MOST], shared[outputs.MOST :]
    if not names:
        chosen = [*(f"{MET}.{name}" for name in _in_both(first, second)), *chosen]
        chosen = [*chosen, FAILED] if (one["status"].values != other["status"].values).any() else chosen
        if not chosen:
            raise ScenarioError("the datasets have no output in common; name one that both have, such as position")
    found = [list(_read(ds, which, chosen, time, sampled)) for ds, which in ((one, "first"), (other, "second"))]
    in_both = {x.name for x in found[1]}
    pairs = [(a, next(b for b in found[1] if b.name == a.name)) for a in found[0] if a.name in in_both]
    if not pairs:
        raise ScenarioError(f"{listed(map(show, names))}: is of other numbers in both; name one that both have")
    weights = _weights(one, other)
    rows = [_difference(a, b, weights) for a, b in pairs]
    data = {
        name: ("output", np.array([row[name] for row in rows]), {"units": unit or "of the output", "long_name": text})
        for name, (unit, text) in NAMED.items()
    }
    coordinates = {"output": [a.name for a, _ in pairs], "output_units": ("output", [a.units for a, _ in pairs])}
    attributes = {
        "titles": "\n".join(str(ds.attrs.get("title", "")) for ds in (first, second)),
        "runs": int(sampled.sum()),
        "changes": "\n".join(_changes(first, second)),
        "verdicts": "\n".join(_verdicts(first, second)),
        "notes": "\n".join(
            [*_notes(first, second, one, other, sampled), *_lonely(pairs, one, other), *_untold(left_out)]
        ),
    }
    return xr.Dataset(data, coordinates, attributes)


def _read(
    ds: xr.Dataset, which: str, names: Sequence[str], time: float | None, sampled: np.ndarray
) -> Iterator[Output]:
    try:
        yield from outputs.read(ds, names, time, sampled)
    except ScenarioError as error:
        raise ScenarioError(str(error).replace("the dataset", f"the {which} dataset", 1)) from error


def _paired(first: xr.Dataset, second: xr.Dataset) -> tuple[xr.Dataset, xr.Dataset]:
    """Both with the runs that both have, in the same order."""
    labels = np.intersect1d(first["run"].values, second["run"].values)
    if (labels >= 0).sum() < FEWEST:
        raise ScenarioError(
            f"the datasets have {plural(int((labels >= 0).sum()), 'run', 'runs')} in common, and a comparison takes "
            f"at least {FEWEST}; runs are paired by their labels"
        )
    one, other = (ds.sel(run=labels) for ds in (first, second))
    return one, other


def _weights(one: xr.Dataset, other: xr.Dataset) -> np.ndarray | None:
    """Those of the pairs (runs,), None if they have none."""
    of = [weights_of(ds) for ds in (one, other)]
    if of[0] is None and of[1] is None:
        return None
    if of[0] is None or of[1] is None or not np.array_equal(of[0], of[1]):
        raise ScenarioError(
            "the runs have other weights in both datasets, so that no pair has one; give both the same seed, sampler "
            "and [sweep.proposal]"
        )
    return of[0]


def _difference(first: Output, second: Output, weights: np.ndarray | None) -> dict[str, float]:
    """One row of what is found; weights (runs,): of the pairs."""
    both = np.isfinite(first.values) & np.isfinite(second.values)
    a, b = first.values[both], second.values[both]
    n = len(a)
    if n < FEWEST:
        return dict.fromkeys(NAMED, np.nan) | {"pairs": n}
    w = np.ones(n) if weights is None or not weights[both].any() else weights[both]
    d = b - a
    change = weighted.mean(d, w, CONFIDENCE)
    low, high = proportions(d, w) if _is_proportion(first) else (change.low, change.high)
    means = [float(np.average(x, weights=w)) for x in (a, b)]
    rest = [x - middle for x, middle in zip((a, b), means, strict=True)]
    spread = [float(np.average(x * x, weights=w)) ** 0.5 for x in rest]
    together = float(np.average(rest[0] * rest[1], weights=w))
    correlation = together / (spread[0] * spread[1]) if all(spread) else np.nan
    return {
        "mean_a": means[0], "mean_b": means[1], "difference": change.value, "difference_low": low,
        "difference_high": high, "larger": float(np.average(d > 0, weights=w)), "correlation": correlation, "pairs": n,
    }  # fmt: skip


def _is_proportion(output: Output) -> bool:
    return output.name == FAILED or output.name.startswith(f"{MET}.")


def proportions(d: np.ndarray, weights: np.ndarray) -> tuple[float, float]:
    """Bounds for the difference of two proportions, from pairs (n,) of which d is 1 where it is true in the second
    alone, and -1 in the first alone: each of both is bounded with half of what is left of the confidence
    (Bonferroni)."""
    less, more = (weighted.proportion(x.astype(float), weights, 0.5 + 0.5 * CONFIDENCE) for x in (d < 0, d > 0))
    return more.low - less.high, more.high - less.low


def _in_both(first: xr.Dataset, second: xr.Dataset) -> list[str]:
    """The requirements that both have."""
    names = [[*map(str, ds["requirement"].values)] if MET in ds else [] for ds in (first, second)]
    return [name for name in names[0] if name in names[1]]


def _verdicts(first: xr.Dataset, second: xr.Dataset) -> Iterator[str]:
    """What all runs of each say of the requirements of both."""
    of = [{x.requirement: x for x in verdicts_of(ds)} for ds in (first, second)]
    for name in _in_both(first, second):
        before, after = (each[name] for each in of)
        said = (f"{x.verdict} ({x.failed:,} of {x.runs:,} runs fail it)" for x in (before, after))
        yield f"{name}: {', then '.join(said)}"


def _notes(
    first: xr.Dataset, second: xr.Dataset, one: xr.Dataset, other: xr.Dataset, sampled: np.ndarray
) -> Iterator[str]:
    runs, weights = one.sizes["run"], weights_of(one, one["run"].values >= 0)
    if weights is not None:
        yield weights_told(weights)
    if sampled.sum() < (one["run"].values >= 0).sum():
        yield f"{int(sampled.sum()):,} of the runs count, since the others of each row repeat their numbers"
    for ds, which in ((first, "first"), (second, "second")):
        if lonely := ds.sizes["run"] - runs:
            does = "run of the {} has no partner, and does", "runs of the {} have no partner, and do"
            yield f"{plural(lonely, *(x.format(which) for x in does))} not count"
    inputs = [
        {str(name): x.values for name, x in ds.coords.items() if x.attrs.get("role") == "input"} for ds in (one, other)
    ]
    shared = [name for name in inputs[0] if name in inputs[1]]
    unlike = [name for name in shared if not np.array_equal(inputs[0][name], inputs[1][name])]
    drawn = [name for name in unlike if _drawn_alike(inputs[0][name], inputs[1][name])]
    unlike = [name for name in unlike if name not in drawn]
    if shared and len(unlike) == len(shared):
        yield "no input has the same samples in both: the intervals hold, but are as wide as those of unrelated runs"
    elif unlike:
        yield f"the samples of {listed(unlike[:6])} differ between both" + (", and of others" if unlike[6:] else "")
    if drawn:
        more = ", and of others" if drawn[6:] else ""
        yield f"the draws of {listed(drawn[:6])}{more} are the same in both, from another distribution"
    for which, own, others in (("first", inputs[0], inputs[1]), ("second", inputs[1], inputs[0])):
        varied = sorted(set(own) - set(others))
        if varied:
            yield f"varied in the {which} alone: {', '.join(varied[:6])}" + (", ..." if varied[6:] else "")


def _drawn_alike(x: np.ndarray, y: np.ndarray) -> bool:
    """Whether both rise and fall together, as of one draw that two distributions make other numbers of."""
    together = float(standard_ranks(x) @ standard_ranks(y))
    return rank_interval(together, len(x))[0] > ALIKE


def _lonely(pairs: Sequence[tuple[Output, Output]], one: xr.Dataset, other: xr.Dataset) -> Iterator[str]:
    """Of which outputs pairs are missing though neither run failed, such as times of what happens in one of both."""
    good = np.isin(one["status"].values, GOOD) & np.isin(other["status"].values, GOOD)
    told = []
    for a, b in pairs:
        has = [np.isfinite(x.values) & good for x in (a, b)]
        alone = [int((own & ~others).sum()) for own, others in (has, has[::-1])]
        if any(alone):
            told.append(f"{a.name}: {alone[0]:,} pairs have it in the first alone, {alone[1]:,} in the second alone")
    yield from told[:MOST_LONELY]
    if rest := told[MOST_LONELY:]:
        yield f"{plural(len(rest), 'other output lacks', 'other outputs lack')} pairs likewise"


def _untold(names: Sequence[str]) -> Iterator[str]:
    """That outputs were chosen, if some were not."""
    if names:
        count = plural(len(names), "other output that both have is", "other outputs that both have are")
        yield f"{count} left out; ask for them by name, such as {names[0]}"


def _changes(first: xr.Dataset, second: xr.Dataset) -> Iterator[str]:
    """What the scenarios differ in, path by path."""
    one, other = (by_path(scenario_tables(ds, "the dataset")) for ds in (first, second))
    known = (x for x in dict.fromkeys([*one, *other]) if x != "title" and not x.endswith(ORDER))
    paths = [path for path in known if one.get(path) != other.get(path) and not PLACES.fullmatch(path)]
    for path in paths[:MOST_CHANGES]:
        before, after = (show(values[path]) if path in values else "not given" for values in (one, other))
        yield f"{path}: {before}, then {after}"
    if paths[MOST_CHANGES:]:
        yield f"and {len(paths) - MOST_CHANGES} more"
