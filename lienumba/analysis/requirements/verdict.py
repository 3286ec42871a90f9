"""The verdicts on the requirements of a dataset: what its runs show of them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from lienumba.analysis.labels import unit_label
from lienumba.analysis.sensitivities.sobol import sampled_inputs
from lienumba.analysis.text_table import NONE, NUMBER, WORD, TextTable, number_text
from lienumba.analysis.weights import weights_of, weights_told
from lienumba.errors import ScenarioError
from lienumba.scenario.base.toml import Tables
from lienumba.store.form import scenario_tables
from lienumba.store.layout import MARGIN, MET
from lienumba.store.names import one_of
from lienumba.store.refusals import check_together, damaged
from lienumba.sweep.samplers import sampler_of
from lienumba.sweep.verdicts import Verdict, Wanted, judge, percent
from lienumba.words import listed, plural, show

LIMITS = ("below", "above", "between")
EVEN = ("sobol", "halton", "latin_hypercube")  # samplers whose runs are spread more evenly than by chance
NAMED = {
    "probability": ("1", "part of all runs that shall meet the requirement"),
    "confidence": ("1", "confidence with which this is to be shown, and of each bound"),
    "runs": ("1", "runs that count"),
    "passed": ("1", "runs that meet it"),
    "part": ("1", "part of the runs that meet it"),
    "at_least": ("1", "lower bound of the probability that a run meets it"),
    "at_most": ("1", "upper bound of the probability that a run meets it"),
    "more_runs": ("1", "about how many more runs decide it if the part stays; 0: decided, NaN: none"),
    "fewest_more": ("1", "how many more runs there must be before it can be met; 0: decided"),
    "effective": ("1", "runs without weights that tell as much of a mean; NaN: they have none"),
    "margin": ("of the requirement", "tolerance bound: what so large a part as is wanted keeps; NaN: too few runs"),
}


def verdicts(ds: xr.Dataset) -> xr.Dataset:
    """What the runs of a dataset, or of a selection of them, show of each requirement.

    Runs that do not count (`failed = "ignore"`) and the nominal run are left out, of a saltelli sweep also all but the
    runs of its two independent samples. A variable `weight` (run), if the dataset is given one, weighs the runs.

    Parameters
    ----------
    ds : xarray.Dataset
        What `lienumba.run` returned of a sweep with requirements.

    Returns
    -------
    xarray.Dataset
        On the dimension `requirement`: `verdict` ("met", "not met" or "not enough runs") and `sentence`; the `part` of
        the `runs` that meet it, and the bounds `at_least` and `at_most` of its probability, each of which holds with
        the `confidence`, by Clopper and Pearson; `more_runs`, `fewest_more`; `margin`, the tolerance bound of Wilks.

    Raises
    ------
    ScenarioError
        Where the dataset has no requirements.
    """
    found = verdicts_of(ds)
    if not found:
        raise ScenarioError("the dataset has no requirements; write some as [[requirements]] and run the scenario")
    rows = [{name: np.nan if x is None else x for name, x in one.to_dict().items()} for one in found]
    data: dict[str, Any] = {
        name: ("requirement", np.array([row[name] for row in rows], float), {"units": unit, "long_name": text})
        for name, (unit, text) in NAMED.items()
    }
    data["verdict"] = ("requirement", [one.verdict for one in found], {"long_name": "what the runs show"})
    data["sentence"] = ("requirement", [one.sentence() for one in found], {"long_name": "the same as a sentence"})
    coordinates = {
        "requirement": [one.requirement for one in found],
        "requirement_units": ("requirement", ds["requirement_units"].values),
    }
    return xr.Dataset(data, coordinates, {"notes": "\n".join(notes(ds))})


def verdicts_of(ds: xr.Dataset) -> list[Verdict]:
    """The same, one by one; none if the dataset has no requirements."""
    if MET not in ds:
        return []
    check_together(ds, "the dataset")
    which, own = counted(ds), rules(ds)
    weights = weights_of(ds, which)
    found = []
    for n, name in enumerate(map(str, ds["requirement"].values)):
        wanted = Wanted(name, float(own[name]["probability"]), float(own[name]["confidence"]))
        met, margin = (ds[x].isel(requirement=n).values[which].astype(float) for x in (MET, MARGIN))
        found.append(judge(wanted, met, margin, weights))
    return found


def counted(ds: xr.Dataset) -> np.ndarray:
    """Which runs count for verdicts (runs,)."""
    sampler = sampler_of(sweep_of(ds))
    return sampler.counting(ds["run"].values, len(sampled_inputs(sweep_of(ds))) if sampler.row is not None else 0)


def sweep_of(ds: xr.Dataset) -> Tables:
    found: Tables = scenario_tables(ds, "the dataset").get("sweep", {})
    return found


def rules(ds: xr.Dataset) -> dict[str, Tables]:
    """The requirements as the scenario of the dataset has them, by their names."""
    tables = scenario_tables(ds, "the dataset").get("requirements", [])
    found: dict[str, Tables] = {str(table.get("name")): table for table in tables if isinstance(table, dict)}
    for name in map(str, ds["requirement"].values):
        if not {"probability", "confidence"} <= found.get(name, {}).keys():
            raise damaged("the dataset", f"its scenario does not have the requirement {show(name)}")
    return found


def requirement_in(ds: xr.Dataset, name: str) -> int:
    """The place of a requirement of this name."""
    own = [*map(str, ds["requirement"].values)] if MET in ds else []
    return own.index(one_of(name, own, "the dataset", "requirement", "its scenario has no [[requirements]]"))


def limit_text(rule: Tables) -> str:
    """What a requirement asks of a run."""
    key = next(key for key in LIMITS if key in rule)
    return f"{rule.get('value', '')} {key} {_plain(rule[key])}"


def _plain(limit: object) -> str:
    if isinstance(limit, list):
        return listed(map(_plain, limit))
    return f"{limit:g}" if isinstance(limit, float) else str(limit)


def table(ds: xr.Dataset, found: Sequence[Verdict]) -> TextTable:
    """A row for each requirement."""
    own = rules(ds)
    units = {str(name): str(unit) for name, unit in zip(ds["requirement"].values, _units(ds), strict=True)}
    rows = [
        [
            x.requirement, x.verdict, limit_text(own[x.requirement]), percent(x.probability),
            f"{x.failed:,} of {x.runs:,}", percent(x.part), percent(x.at_least, True), percent(x.at_most, False),
            _margin(x, units[x.requirement]),
        ]
        for x in found
    ]  # fmt: skip
    headings = ["requirement", "verdict", "each run", "wanted", "failed it", "met by", "at least", "at most", "margin"]
    return TextTable(headings, [*[WORD] * 3, *[NUMBER] * 6], rows)


def _units(ds: xr.Dataset) -> Sequence[str]:
    return [*ds["requirement_units"].values] if "requirement_units" in ds.coords else ["1"] * ds.sizes["requirement"]


def _margin(x: Verdict, units: str) -> str:
    return NONE if x.margin is None else _amount(x.margin, units)


def _amount(x: float, units: str) -> str:
    return " ".join(filter(None, [number_text(x, ".3g"), unit_label(units)]))


def legend(found: Sequence[Verdict]) -> str:
    """What the columns of the table are."""
    sure = listed(dict.fromkeys(f"{100 * x.confidence:g} %" for x in found), "or")
    return (
        f"at least, at most: bounds of the probability to meet it, each with {sure} confidence; margin: to the "
        "limit, which the part that is wanted keeps with the same confidence"
    )


def worst(ds: xr.Dataset, found: Sequence[Verdict]) -> list[str]:
    """Of each requirement that some run does not meet, the run that misses it by most."""
    which, said = np.flatnonzero(counted(ds)), []
    for n, x in enumerate(found):
        margin = ds[MARGIN].isel(requirement=n).values[which]
        if x.failed and (margin < 0.0).any():
            run = which[np.nanargmin(margin)]
            by = _amount(float(-np.nanmin(margin)), _units(ds)[n])
            said.append(f"{show(x.requirement)}: run {ds['run'].values[run]} misses it by most, {by}")
    return said


def notes(ds: xr.Dataset) -> list[str]:
    """What to beware of."""
    sampler, found = sampler_of(sweep_of(ds)), []
    if sampler.name in EVEN:
        found.append(
            f"the sampler {sampler.name} spreads runs more evenly than by chance: bounds are those of independent runs"
        )
    if "stopped" in ds.attrs:
        found.append("the sweep ended by [sweep.stop]: bounds are those of a number of runs that was fixed before")
    which = counted(ds)
    if sampler.row:
        count = plural(int(which.sum()), "run counts", "runs count")
        found.append(f"of the {sampler.name} sweep {count}, the independent ones")
    weights = weights_of(ds, which)
    if weights is not None and which.any():
        found.append(weights_told(weights))
    for n, name in enumerate(ds["requirement"].values):
        met, margin = (ds[x].isel(requirement=n).values[which] for x in (MET, MARGIN))
        none = int((np.isnan(margin) & np.isfinite(met)).sum())
        if none:
            count = plural(none, "run", "runs")
            found.append(f"{count} failed or had no value for {show(str(name))}, and did not meet it")
    return found
