"""Which inputs matter for which output: the numbers of `analysis.sensitivity` with the points that they are of."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import xarray as xr

from lienumba.analysis.labels import time_label, unit_label
from lienumba.analysis.sensitivities import outputs
from lienumba.analysis.sensitivities.sensitivity import sensitivity as analysed
from lienumba.analysis.sensitivities.sensitivity_rows import OutputRows, sensitivity_rows
from lienumba.analysis.text_table import NONE
from lienumba.errors import ScenarioError
from lienumba.present.html.chart import Json, Section, packed, section
from lienumba.present.html.markup import Markup, element, sentence, text_table
from lienumba.store.layout import FAILED

MOST_POINTS = 1500  # of the scatter
MOST_NUMBERS = 40_000  # of all columns together
MOST_INPUTS = 24  # columns of the matrix: the strongest
NUMBERS = (  # that the page draws
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
    found = [Column(x.name, unit_label(x.units), time_label(x.time), x.values) for x in read if x.name != FAILED]
    return Columns(labels, inputs, found)


def sensitivity(ds: xr.Dataset, read: Columns) -> tuple[Section | None, Json]:
    """The section, and what its script draws; no section where nothing is varied."""
    if not read.inputs or ds.sizes["run"] < 2:
        return None, {}
    try:
        found = sensitivity_rows(analysed(ds))
    except ScenarioError as error:
        return section("sensitivity", TITLE, element("p", sentence(str(error)))), {}
    first, inputs = found.strongest[:MOST_INPUTS], len(found.outputs[0].inputs)
    outputs = [replace(x, inputs=[x.inputs[k] for k in first]) for x in found.outputs]
    points = _points(ds, read, [x.name for x in outputs], [x.name for x in outputs[0].inputs])
    notes = [*found.notes]
    if len(first) < inputs:
        notes.append(f"shown are the {len(first)} inputs of {inputs} with the largest rank correlations")
    indices = any(row.explained != NONE for x in found.outputs for row in x.inputs)
    body = _body(indices, [*notes, points.pop("note")])
    for output in found.outputs:
        if effects := output.effects(MOST_INPUTS):
            body += [element("h3", effects[0]), text_table(effects[1])]
    return section("sensitivity", TITLE, *body), {**_numbers(outputs), **points}


TITLE = "What depends on what"


def _numbers(outputs: Sequence[OutputRows]) -> Json:
    """What was found of each output (rows) and input (columns)."""
    numbers = {name: np.array([row.numbers[name] for x in outputs for row in x.inputs]) for name in NUMBERS}
    return {
        "outputs": [
            {"name": x.name, "unit": unit_label(x.units), "at": time_label(x.time), "runs": x.runs} for x in outputs
        ],
        "inputs": [{"name": x.name, "unit": unit_label(x.units)} for x in outputs[0].inputs],
        "numbers": {name: packed(values) for name, values in numbers.items() if not np.isnan(values).all()},
    }


def _points(ds: xr.Dataset, read: Columns, out: Sequence[str], given: Sequence[str]) -> Json:
    """The runs of the scatter, evenly over the sweep: as many as a screen shows."""
    runs = np.flatnonzero(read.labels >= 0)
    most = max(min(MOST_POINTS, MOST_NUMBERS // (len(out) + len(given))), 200)
    kept = runs[np.unique(np.linspace(0, len(runs) - 1, most).round().astype(int))]
    values = {x.name: x.values[kept] for x in (*read.outputs, *read.inputs)}
    if "failed" in out:
        values["failed"] = np.isnan(read.outputs[0].values[kept]).astype(float) if read.outputs else np.zeros(len(kept))
    note = (
        f"of {len(runs):,} runs {len(kept):,} are drawn, evenly over their labels; all count"
        if len(kept) < len(runs)
        else ""
    )
    return {
        "labels": read.labels[kept].tolist(),
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
