"""Which inputs set the runs that meet a requirement apart from those that do not.

Of each input the two samples are compared: by the largest distance of their distribution functions (Kolmogorov and
Smirnov), which sees any difference, by how often a run that does not meet it has the larger input (the area under the
curve of Mann and Whitney), and by the part of the variance of meeting it that the input explains alone. P-values are
those of Kolmogorov's and Smirnov's test, after Holm: with all inputs without any influence, one of them is below 0.05
in 5 % of all sweeps at most.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from lienumba.analysis.labels import named
from lienumba.analysis.requirements.verdict import counted, requirement_in, sweep_of
from lienumba.analysis.sensitivities.explained import explained
from lienumba.analysis.text_table import NONE, TextTable, number_text, short_text
from lienumba.analysis.weights import kept_of, weights_of
from lienumba.errors import ScenarioError
from lienumba.store.layout import MET, RUN
from lienumba.sweep.samplers import sampler_of
from lienumba.words import show

NAMED = {
    "distance": ("1", "largest distance of the distribution functions of both, from 0 to 1"),
    "p_value": ("1", "of no difference, after Holm"),
    "larger": ("1", "how often a run that does not meet it has a larger input than one that does"),
    "median_met": ("", "median of the runs that meet it"),
    "median_not_met": ("", "median of the runs that do not"),
    "first_order": ("1", "part of the variance of meeting it that the input explains alone"),
    "first_order_low": ("1", "lower end of its 95 % confidence interval"),
    "first_order_high": ("1", "upper end of its 95 % confidence interval"),
}
CLEAR = 0.05  # p-values below which an input matters


def separation(ds: xr.Dataset, requirement: str) -> xr.Dataset:
    """What sets the runs that do not meet a requirement apart from those that do, input by input.

    Parameters
    ----------
    ds : xarray.Dataset
        What `lienumba.run` returned of a sweep with requirements.
    requirement : str
        The name of the requirement.

    Returns
    -------
    xarray.Dataset
        On the dimension `input`, the clearest first: the `distance` of the distribution functions, its `p_value` after
        Holm's correction for all inputs, how often the input of a run that does not meet it is `larger`, both medians,
        and the part of the variance that it explains alone, `first_order`, with its interval. The attributes `met` and
        `not_met` say how many runs there are of both.

    Raises
    ------
    ScenarioError
        Where there is no such requirement, nothing is varied, or all runs meet it, or none.
    """
    from scipy.stats import ks_2samp, mannwhitneyu

    which, met, inputs = _groups(ds, requirement)
    evenly = sampler_of(sweep_of(ds)).evenly
    rows: list[dict[str, float]] = []
    for name in inputs:
        x = ds[name].values[which]
        good, bad = x[met], x[~met]
        area = float(mannwhitneyu(bad, good, method="asymptotic").statistic) / (len(bad) * len(good))
        found = ks_2samp(bad, good)
        rows.append(
            {
                "distance": float(found.statistic), "p_value": float(found.pvalue), "larger": area,
                "median_met": float(np.median(good)), "median_not_met": float(np.median(bad)),
                **({} if weights_of(ds) is not None else explained(x, met.astype(float), evenly)),
            }
        )  # fmt: skip
    for row, p in zip(rows, holm([row["p_value"] for row in rows]), strict=True):
        row["p_value"] = p
    order = sorted(range(len(rows)), key=lambda n: (-rows[n]["distance"], n))
    data = {}
    for name, (unit, text) in NAMED.items():
        values = np.array([rows[n].get(name, np.nan) for n in order])
        data[name] = ("input", values, {"units": unit or "of the input", "long_name": text})
    coordinates: dict[str, Any] = {
        "input": [inputs[n] for n in order],
        "input_units": ("input", [str(ds[inputs[n]].attrs.get("units", "1")) for n in order]),
    }
    attributes = {"requirement": requirement, "met": int(met.sum()), "not_met": int((~met).sum())}
    return xr.Dataset(data, coordinates, attributes)


def _groups(ds: xr.Dataset, requirement: str) -> tuple[np.ndarray, np.ndarray, list[str]]:
    """Which runs count (runs,), which of these meet the requirement, and the inputs that vary among them."""
    place = requirement_in(ds, requirement)
    met = ds[MET].isel(requirement=place).values.astype(float)
    which = counted(ds) & np.isfinite(met)
    kept = kept_of(ds, which & (met == 1.0), which & (met == 0.0))  # so that both are samples of their own inputs
    which = which if kept is None else which & kept
    good = met[which] == 1.0
    if good.all() or not good.any():
        how = "meet it" if len(good) and good.all() else "fail it"
        raise ScenarioError(f"{show(requirement)}: all runs {how}, so that nothing sets them apart; there must be both")
    inputs = [str(name) for name, x in ds.coords.items() if x.attrs.get("role") == "input" and x.dims == RUN]
    inputs = [name for name in inputs if np.isfinite(x := ds[name].values[which]).all() and np.ptp(x) > 0.0]
    if not inputs:
        raise ScenarioError(f"{show(requirement)}: no input varies; give [sweep.vary] some")
    return which, good, inputs


def separable(ds: xr.Dataset) -> list[str]:
    """The requirements that some runs meet and some do not, if anything is varied."""
    found = []
    for name in map(str, ds["requirement"].values) if MET in ds else ():
        try:
            _groups(ds, name)
        except ScenarioError:
            continue
        found.append(name)
    return found


def holm(p: Sequence[float]) -> list[float]:
    """P-values for all tests together (S. Holm, Scand. J. Statist. 6 (1979) 65)."""
    order, found, largest = np.argsort(p, kind="stable"), [0.0] * len(p), 0.0
    for rank, n in enumerate(order):
        largest = max(largest, min(1.0, (len(p) - rank) * p[n]))
        found[n] = largest
    return found


def samples(ds: xr.Dataset, requirement: str, name: str) -> tuple[np.ndarray, np.ndarray]:
    """An input of the runs that meet it, and of those that do not."""
    which, met, _ = _groups(ds, requirement)
    x = ds[name].values[which]
    return x[met], x[~met]


def headline(found: xr.Dataset) -> str:
    """Of how many runs it is."""
    return f"what sets the {found.attrs['not_met']:,} runs that fail {show(found.attrs['requirement'])} apart"


def table(found: xr.Dataset, most: int) -> tuple[TextTable, str]:
    """A row for each of the clearest inputs, and a remark on the others."""
    rows = []
    for n, name in enumerate(map(str, found["input"].values[:most])):
        of = {str(key): float(x[n]) for key, x in found.data_vars.items()}
        half = of["first_order_high"] - of["first_order"]
        alone = f"{round(100 * of['first_order']) + 0} ± {short_text(100 * half, 2)} %" if half == half else NONE
        rows.append(
            [
                named(name, str(found["input_units"].values[n])), _p(of["p_value"]), f"{of['distance']:.2f}",
                f"{100 * of['larger']:.0f} %",
                *(number_text(of[key], ".4g") for key in ("median_met", "median_not_met")), alone,
            ]
        )  # fmt: skip
    unclear = int((found["p_value"].values >= CLEAR).sum())
    more = f" (the first {most} of {found.sizes['input']} inputs)" if found.sizes["input"] > most else ""
    headings = ["p", "distance", "larger in", "median: met", "failed", "explains"]
    said = f"{unclear} of {found.sizes['input']} inputs show no difference" if unclear else ""
    return TextTable.of(["input"], headings, rows), "; ".join(filter(None, [more.strip(" ()"), said]))


def _p(p: float) -> str:
    return "< 1e-6" if p < 1e-6 else f"{p:.2g}"


LEGEND = (
    "p: of no difference, for all inputs together; distance: of the distribution functions; larger in: pairs in which "
    "the run that fails it has the larger input; explains: the part of the variance, ± 95 % confidence"
)
