"""Means, quantiles and proportions over runs with confidence intervals."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np
import xarray as xr

from lienumba.analysis.statistics.blockwise import COUNT, Block, Found, RunStatistics, check_numbers, check_probability
from lienumba.errors import ScenarioError
from lienumba.store.layout import RUN, texts
from lienumba.sweep import weighted
from lienumba.sweep.confidence import half_width, proportion, ranks

CONFIDENCE = 0.95
KEPT = ("units", "frame")  # attributes of the variable that its statistics have, too


def mean_interval(
    x: xr.DataArray, dim: str = RUN[0], confidence: float = CONFIDENCE, weights: xr.DataArray | None = None
) -> xr.Dataset:
    """The mean of a variable over `dim` with its confidence interval, at each other label.

    The interval is Student's: exact where values are normal, nearly so where many are not. Of fewer than two runs it is
    infinite. `proportion_interval` is for true and false.

    Parameters
    ----------
    x : xarray.DataArray
        The variable.
    dim : str
        The dimension of the runs. The nominal run is left out if there are others.
    confidence : float
        Between 0 and 1.
    weights : xarray.DataArray, optional
        Those of the runs, `ds.weight` of a sweep with `sampler = "importance"`.

    Returns
    -------
    xarray.Dataset
        `mean` between `low` and `high`, and the standard `deviation` (n - 1), in the unit of `x`, over the `count` of
        the `runs` that have a finite value there.
    """
    check_probability("confidence", confidence)
    runs = RunStatistics(x, dim)
    if x.dtype.kind == "b":
        raise ScenarioError(f"{_what(x)} is true and false: ask for lienumba.analysis.proportion_interval")

    own = _weights(runs, weights)

    def work(block: Block) -> Found:
        if own is not None:
            return _each(block, own, np.isfinite, lambda y, w: _mean(y, w, confidence))
        finite = np.isfinite(block.values)
        count = finite.sum(axis=1)
        with np.errstate(invalid="ignore", divide="ignore"):
            mean = np.where(finite, block.values, 0.0).sum(axis=1) / count
            rest = np.where(finite, block.values - mean[:, None], 0.0)
            deviation = ((rest * rest).sum(axis=1) / np.where(count > 1, count - 1, np.nan)) ** 0.5
            half = np.where(count > 1, half_width(deviation, count, confidence), np.inf)
        low, high = (np.where(count > 0, mean, 0.0) + sign * half for sign in (-1.0, 1.0))
        return {"mean": mean, "low": low, "high": high, "deviation": deviation, "count": count}

    described = {
        "mean": f"mean of {_what(x)}",
        "low": f"lower end of the {_percent(confidence)} confidence interval of the mean",
        "high": f"upper end of the {_percent(confidence)} confidence interval of the mean",
        "deviation": f"standard deviation of {_what(x)}",
    }
    return runs.labelled(runs.gather(work), _described(x, described, ()))


def proportion_interval(
    x: xr.DataArray, dim: str = RUN[0], confidence: float = CONFIDENCE, weights: xr.DataArray | None = None
) -> xr.Dataset:
    """In what part of the runs something is true, with its confidence interval, at each other label.

    The interval is that of Clopper and Pearson, which holds at least what it says: none of 2,000 runs is from 0 to
    0.18 %.

    Parameters
    ----------
    x : xarray.DataArray
        True and false, or 1 and 0, such as `~ds.status.isin([0, 9])` or `ds.tip_max > 0.2`; NaN is no value.
    dim : str
        The dimension of the runs. The nominal run is left out if there are others.
    confidence : float
        Between 0 and 1.
    weights : xarray.DataArray, optional
        Those of the runs, `ds.weight` of a sweep with `sampler = "importance"`.

    Returns
    -------
    xarray.Dataset
        `proportion` between `low` and `high`, over the `count` of the `runs` that have a value there.
    """
    check_probability("confidence", confidence)
    runs = RunStatistics(x, dim)

    own = _weights(runs, weights)

    def work(block: Block) -> Found:
        known = ~np.isnan(block.values)
        other = block.values[known & (block.values != 0.0) & (block.values != 1.0)]
        if other.size:
            raise ScenarioError(
                f"{other[0]:g} is among the values of {_what(x)}: a proportion is of true and false, or 1 and 0; "
                "compare it with a limit, such as x > 0.2"
            )
        count, successes = known.sum(axis=1), (block.values == 1.0).sum(axis=1)
        if own is not None:
            return _each(block, own, lambda y: ~np.isnan(y), lambda y, w: _proportion(y, w, confidence))
        low, high = proportion(successes, count, confidence)
        with np.errstate(invalid="ignore"):
            return {"proportion": successes / count, "low": low, "high": high, "count": count}

    described = {
        "proportion": f"part of the runs with {_what(x)}",
        "low": f"lower end of the {_percent(confidence)} confidence interval of the proportion",
        "high": f"upper end of the {_percent(confidence)} confidence interval of the proportion",
    }
    pure = x.assign_attrs(units="1") if "units" in x.attrs else x
    return runs.labelled(runs.gather(work), _described(pure, described, ()))


def quantile_interval(
    x: xr.DataArray,
    q: float | Sequence[float],
    dim: str = RUN[0],
    confidence: float = CONFIDENCE,
    weights: xr.DataArray | None = None,
) -> xr.Dataset:
    """Quantiles of a variable over `dim` with their confidence intervals, at each other label.

    The interval is between two of the sorted values and assumes nothing of how these are distributed; its confidence is
    at least that. An end is infinite where there are too few runs for it. Infinite values count, so that
    `x.fillna(numpy.inf)` ranks failed runs behind all others.

    Parameters
    ----------
    x : xarray.DataArray
        The variable.
    q : float or sequence of float
        The quantiles, between 0 and 1.
    dim : str
        The dimension of the runs. The nominal run is left out if there are others.
    confidence : float
        Between 0 and 1.
    weights : xarray.DataArray, optional
        Those of the runs, `ds.weight` of a sweep with `sampler = "importance"`.

    Returns
    -------
    xarray.Dataset
        `value` between `low` and `high`, in the unit of `x`, over the `count` of the `runs` that have a value there,
        with the dimension `quantile` unless `q` is one number.
    """
    check_probability("confidence", confidence)
    single = isinstance(q, str) or (not isinstance(q, Sequence) and np.ndim(q) == 0)
    wanted: list[Any] = [q] if single else list(q)  # type: ignore[arg-type]
    for one in wanted:
        check_probability("q", one)
    if not wanted:
        raise ScenarioError("q = []: asks for no quantile; give numbers between 0 and 1, such as [0.05, 0.5, 0.95]")
    runs = RunStatistics(x, dim, new=("quantile",))

    own = _weights(runs, weights)

    def work(block: Block) -> Found:
        if own is not None:
            return _each(block, own, lambda y: ~np.isnan(y), lambda y, w: _quantiles(y, w, wanted, confidence))
        ordered = np.sort(block.values, axis=1)
        count = (~np.isnan(ordered)).sum(axis=1)
        each = [_quantile(ordered, count, float(one), confidence) for one in wanted]
        return {name: np.stack([found[name] for found in each], axis=1) for name in each[0]} | {"count": count}

    described = {
        "value": f"quantile of {_what(x)}",
        "low": f"lower end of the {_percent(confidence)} confidence interval of the quantile",
        "high": f"upper end of the {_percent(confidence)} confidence interval of the quantile",
    }
    labels = {"quantile": xr.Variable("quantile", [float(one) for one in wanted], texts("1", "probability"))}
    found = runs.labelled(runs.gather(work), _described(x, described, ("quantile",)), labels)
    return found.isel(quantile=0) if single else found


def _quantile(ordered: np.ndarray, count: np.ndarray, q: float, confidence: float) -> Found:
    """Of sorted values (labels, runs), of which the first `count` (labels,) are known."""

    def at(place: np.ndarray) -> np.ndarray:
        inside = np.clip(place, 0, np.maximum(count - 1, 0))
        return np.take_along_axis(ordered, inside[:, None], axis=1)[:, 0]

    place = q * np.maximum(count - 1, 0)
    below = np.floor(place).astype(np.int64)
    left, right, part = at(below), at(below + 1), place - below
    with np.errstate(invalid="ignore"):
        between = np.where(part < 0.5, left + (right - left) * part, right - (right - left) * (1.0 - part))
    between = np.where(np.isfinite(between), between, np.where(part < 0.5, left, right))
    value = np.where((left == right) | (part == 0.0), left, between)
    different, where = np.unique(count, return_inverse=True)
    first, last = (places[where] for places in ranks(different, q, confidence))
    low = np.where(first >= 0, at(first), -np.inf)
    return {"value": value, "low": low, "high": np.where(last < count, at(last), np.inf)}


def _weights(runs: RunStatistics, weights: xr.DataArray | None) -> np.ndarray | None:
    """Of the runs that count (runs,)."""
    if weights is None:
        return None
    check_numbers(weights, runs.dim)
    if weights.dims != (runs.dim,) or not np.array_equal(weights[runs.dim].values, runs.x[runs.dim].values):
        raise ScenarioError(
            f"weights: have not the same runs as the variable, along {runs.dim}; give those of the same dataset, such "
            "as ds.weight"
        )
    found = weights.values[runs.counted].astype(float)
    if not (np.isfinite(found) & (found >= 0.0)).all():
        raise ScenarioError("weights: some are no numbers, or below 0; give those of the dataset, such as ds.weight")
    return found


def _each(
    block: Block,
    weights: np.ndarray,
    known: Callable[[np.ndarray], np.ndarray],
    work: Callable[[np.ndarray, np.ndarray], Mapping[str, Any]],
) -> Found:
    """What is found at each label of the block, from the values that are known there with their weights."""
    found = [(here := known(row), work(row[here], weights[here])) for row in block.values]
    stacked = {name: np.array([each[name] for _, each in found]) for name in found[0][1]}
    return stacked | {"count": np.array([int(here.sum()) for here, _ in found])}


def _mean(y: np.ndarray, w: np.ndarray, confidence: float) -> dict[str, float]:
    found = weighted.mean(y, w, confidence)
    return {"mean": found.value, "low": found.low, "high": found.high, "deviation": weighted.deviation(y, w)}


def _proportion(y: np.ndarray, w: np.ndarray, confidence: float) -> dict[str, float]:
    found = weighted.proportion(y, w, confidence)
    return {"proportion": found.value, "low": found.low, "high": found.high}


def _quantiles(y: np.ndarray, w: np.ndarray, wanted: Sequence[float], confidence: float) -> dict[str, list[float]]:
    found = [asdict(weighted.quantile(y, w, float(q), confidence)) for q in wanted]
    return {name: [one[name] for one in found] for name in found[0]}


def _what(x: xr.DataArray) -> str:
    return str(x.attrs.get("long_name", x.name or "the variable"))


def _percent(confidence: float) -> str:
    return f"{100.0 * confidence:g} %"


def _described(x: xr.DataArray, names: dict[str, str], dims: tuple[str, ...]) -> dict[str, Any]:
    """Statistics with the units and frame of the variable."""
    own = {key: x.attrs[key] for key in KEPT if key in x.attrs}
    return {name: (dims, own | {"long_name": text}) for name, text in names.items()} | {"count": ((), COUNT)}
