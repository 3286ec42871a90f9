"""Which inputs matter for which output: the numbers of `analysis.sensitivity` with the points that they are of."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr

from lienumba.analysis.labels import named, time_label, unit_label
from lienumba.analysis.sensitivities import outputs
from lienumba.analysis.sensitivities.sensitivity import sensitivity as analysed
from lienumba.analysis.sensitivities.sensitivity_rows import SensitivityRows, sensitivity_rows
from lienumba.errors import ScenarioError
from lienumba.figures.canvas import COLORS
from lienumba.present.html.chart import Chart, Json, Section, axis, color, packed, plain, section
from lienumba.present.html.markup import Markup, element, sentence, text_table
from lienumba.store.layout import FAILED

MOST_POINTS = 1500  # of a scatter
MOST_INPUTS = 12  # rows of a table


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


def sections(ds: xr.Dataset, read: Columns) -> Iterator[Section]:
    """Rank correlations, tornados and indices, and of each output the points over its strongest input; nothing where
    nothing is varied."""
    if not read.inputs or ds.sizes["run"] < 2:
        return
    try:
        found = sensitivity_rows(analysed(ds))
    except ScenarioError as error:
        yield section("sensitivity", TITLE, element("p", sentence(str(error))))
        return
    parts: list[Markup] = []
    for one in found.outputs:
        table, more = one.tornado(MOST_INPUTS)
        parts += [element("h3", one.headline + more), text_table(table)]
        if one.sobol_headline:
            table, more = one.sobol(MOST_INPUTS)
            parts += [element("h4", one.sobol_headline + more), text_table(table)]
        if effects := one.effects(MOST_INPUTS):
            parts += [element("h4", effects[0]), text_table(effects[1])]
    runs = np.flatnonzero(read.labels >= 0)
    kept = runs[np.unique(np.linspace(0, len(runs) - 1, MOST_POINTS).round().astype(int))]
    notes = [*found.notes]
    if len(kept) < len(runs):
        notes.append(f"of {len(runs):,} runs {len(kept):,} are drawn, evenly over their labels; all count")
    said = [element("p", sentence("; ".join(notes)), class_="quiet")] if notes else []
    charts = [_ranks(found, found.strongest[:MOST_INPUTS]), *_scatters(read, found, kept)]
    yield section("sensitivity", TITLE, *parts, *said, charts=charts)


def _ranks(found: SensitivityRows, strongest: Sequence[int]) -> Chart:
    """The rank correlations of outputs (rows) and the strongest inputs (columns)."""
    ranks = np.array([[x.inputs[k].numbers["rank_correlation"] for k in strongest] for x in found.outputs])
    outputs, inputs = [x.name for x in found.outputs], [found.outputs[0].inputs[k].name for k in strongest]
    trace: Json = {
        "type": "heatmap", "z": packed(ranks), "x": [plain(x) for x in inputs], "y": [plain(x) for x in outputs],
        "zmin": -1, "zmax": 1, "colorscale": [[0, COLORS[1]], [0.5, "#ffffff"], [1, COLORS[0]]],
        "texttemplate": "%{z:.2f}", "hovertemplate": "%{y} over %{x}: %{z:.3f}<extra></extra>",
    }  # fmt: skip
    layout: Json = {"hovermode": "closest", "height": 160 + 30 * len(outputs), "yaxis": {"autorange": "reversed"}}
    return Chart("Spearman's rank correlations", [trace], layout)


def _scatters(read: Columns, found: SensitivityRows, kept: np.ndarray) -> Iterator[Chart]:
    """Each output over the input that is strongest for it."""
    values, inputs = {x.name: x for x in read.outputs}, {x.name: x for x in read.inputs}
    for one in found.outputs:
        strong = max(one.inputs, key=lambda row: row.strength if row.strength == row.strength else -1.0)
        if one.name in values and strong.name in inputs:
            over, own = inputs[strong.name], values[one.name]
            trace: Json = {
                "type": "scatter", "mode": "markers", "x": packed(over.values[kept]), "y": packed(own.values[kept]),
                "customdata": packed(read.labels[kept]), "marker": {"size": 4, "color": color(0, 0.6)},
                "hovertemplate": "run %{customdata}: %{x:.4~g}, %{y:.4~g}<extra></extra>",
            }  # fmt: skip
            layout: Json = {"hovermode": "closest", "xaxis": axis(named(over.name, over.unit))}
            yield Chart(f"{named(one.name, own.unit)} over {over.name}", [trace], layout, note=own.at)


TITLE = "What depends on what"
