"""Which inputs matter for which output: the numbers of `analysis.sensitivity` with the points that they are of."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from lienumba.analysis.labels import unit_label
from lienumba.analysis.sensitivities import outputs
from lienumba.analysis.sensitivities.sensitivity import CHOSEN
from lienumba.analysis.sensitivities.sensitivity import sensitivity as analysed
from lienumba.errors import ScenarioError
from lienumba.present.html.chart import Section, packed, section
from lienumba.present.html.markup import Markup, element, sentence

if TYPE_CHECKING:
    import numpy as np
    import xarray as xr

MOST_POINTS = 1500  # of the scatter
MOST_NUMBERS = 40_000  # of all columns together
MOST_INPUTS = 24  # columns of the matrix: the strongest
NUMBERS = (
    "rank_correlation", "rank_correlation_low", "rank_correlation_high", "input_low", "input_high", "low", "high",
    "change", "change_low", "change_high", "first_order", "first_order_low", "first_order_high",
    "total_order", "total_order_low", "total_order_high",
)  # fmt: skip


@dataclass(frozen=True)
class Column:
    """One number of each run. at: when, if it is of a course; values (runs,)."""

    name: str
    unit: str
    at: str
    values: np.ndarray


@dataclass(frozen=True)
class Columns:
    """Inputs and outputs of the runs with these labels; outputs of failed runs are NaN."""

    labels: np.ndarray
    inputs: list[Column]
    outputs: list[Column]


def columns(ds: xr.Dataset) -> Columns:
    """The inputs, and the outputs that say most."""
    import numpy as np

    labels = ds["run"].values
    inputs = [
        Column(str(name), unit_label(str(x.attrs.get("units", ""))), "", x.values)
        for name, x in ds.coords.items()
        if x.attrs.get("role") == "input" and x.dims == ("run",)
    ]
    try:
        read = list(outputs.read(ds, (), None, np.ones(len(labels), bool)))
    except ScenarioError:  # nothing of runs is stored
        read = []
    found = [
        Column(x.name, unit_label(x.units), f"at t = {x.time:g} s" if x.time == x.time else "", x.values)
        for x in read
        if x.name != outputs.FAILED
    ]
    return Columns(labels, inputs, found)


def sensitivity(ds: xr.Dataset, known: Columns) -> tuple[Section | None, dict[str, Any]]:
    """The section, and what its script draws; no section where nothing is varied."""
    if not known.inputs or ds.sizes["run"] < 2:
        return None, {}
    try:
        found = analysed(ds)
    except ScenarioError as error:
        return section("sensitivity", TITLE, element("p", sentence(str(error)))), {}
    names = [str(name) for name in found["input"].values]
    strength = found["rank_correlation"].fillna(0.0).values
    order = sorted(range(len(names)), key=lambda k: -abs(strength[:, k]).max())[:MOST_INPUTS]
    numbers = _numbers(found.isel(input=order))
    points = _points(ds, known, [str(x) for x in found["output"].values], [names[k] for k in order])
    notes = [x for x in str(found.attrs["notes"]).split("\n") if x and x != CHOSEN]
    if len(order) < len(names):
        notes.append(f"shown are the {len(order)} inputs of {len(names)} with the largest rank correlations")
    body = _body(bool(found["first_order"].notnull().any()), [*notes, points.pop("note")])
    return section("sensitivity", TITLE, *body), {**numbers, **points}


TITLE = "What depends on what"


def _numbers(found: xr.Dataset) -> dict[str, Any]:
    """What was found of each output (rows) and input (columns)."""
    outputs = [
        {
            "name": str(name),
            "unit": unit_label(str(unit)),
            "at": f"at t = {time:g} s" if time == time else "",
            "runs": int(n),
        }
        for name, unit, time, n in zip(
            found["output"].values,
            found["output_units"].values,
            found["output_time"].values,
            found["runs"].values,
            strict=True,
        )
    ]
    inputs = [
        {"name": str(name), "unit": unit_label(str(unit))}
        for name, unit in zip(found["input"].values, found["input_units"].values, strict=True)
    ]
    return {
        "outputs": outputs,
        "inputs": inputs,
        "numbers": {name: packed(found[name].values.ravel()) for name in NUMBERS if found[name].notnull().any()},
    }


def _points(ds: xr.Dataset, known: Columns, out: Sequence[str], given: Sequence[str]) -> dict[str, Any]:
    """The runs of the scatter, evenly over the sweep: as many as a screen shows."""
    import numpy as np

    runs = np.flatnonzero(known.labels >= 0)
    most = max(min(MOST_POINTS, MOST_NUMBERS // (len(out) + len(given))), 200)
    kept = runs[np.unique(np.linspace(0, len(runs) - 1, most).round().astype(int))]
    values = {x.name: x.values[kept] for x in (*known.outputs, *known.inputs)}
    if "failed" in out:
        values["failed"] = (
            np.isnan(known.outputs[0].values[kept]).astype(float) if known.outputs else np.zeros(len(kept))
        )
    note = (
        f"of {len(runs):,} runs {len(kept):,} are drawn, evenly over their labels; all count"
        if len(kept) < len(runs)
        else ""
    )
    return {
        "labels": known.labels[kept].tolist(),
        "points": {"outputs": [packed(values[x]) for x in out if x in values],
                   "inputs": [packed(values[x]) if x in values else None for x in given]},
        "note": note,
    }  # fmt: skip


def _body(sobol: bool, notes: Sequence[str]) -> list[Markup]:
    """Places for what the script makes."""
    matrix = element(
        "div",
        element("table", id="matrix", class_="matrix"),
        class_="scroll",
        tabindex="0",
        role="region",
        aria_label=RANKS,
    )
    choice = element(
        "div",
        element("label", "output ", element("select", id="output")),
        element("label", "input ", element("select", id="input")),
        class_="controls choices",
    )
    charts = [
        ("scatter", "scatter-caption"),
        ("tornado", "tornado-caption"),
        *([("sobol", "sobol-caption")] if sobol else []),
    ]
    figures = (
        element("figure", element("figcaption", id=caption), element("div", class_="plot", id=name))
        for name, caption in charts
    )
    said = [element("p", sentence("; ".join(filter(None, notes))), class_="quiet")] if any(notes) else []
    return [
        element("p", RANKS + ": choose a pair.", class_="quiet"),
        matrix,
        choice,
        element("div", *figures, class_="panels"),
        *said,
    ]


RANKS = "Spearman's rank correlations of outputs and inputs"
