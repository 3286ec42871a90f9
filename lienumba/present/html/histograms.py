"""Histograms: what was drawn, and what came out."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from lienumba.analysis.panels.quantiles import Histogram, bins
from lienumba.present.html import chart
from lienumba.present.html.chart import Chart, Json, Section, section
from lienumba.present.html.markup import element, number
from lienumba.present.html.sensitivity import Column, Columns
from lienumba.words import listed

MOST_INPUTS = 12  # histograms
MOST_OUTPUTS = 9


def sections(columns: Columns) -> Iterator[Section]:
    """Of outputs, and of inputs."""
    groups = (
        ("outputs", "What came out", columns.outputs, MOST_OUTPUTS, 0),
        ("inputs", "What was drawn", columns.inputs, MOST_INPUTS, 2),
    )
    for key, title, every, most, shade in groups:
        found = [(one, one.values[(columns.labels >= 0) & np.isfinite(one.values)]) for one in every]
        varied = [one for one, values in found if len(values) and np.ptp(values)]
        notes = [
            f"{one.name} is {number(values[0])} {one.unit}".strip()
            for one, values in found
            if len(values) and not np.ptp(values)
        ]
        notes = [f"In all runs {listed(notes)}."] if notes else []
        notes += [f"The first {most} of {len(varied)}."] if len(varied) > most else []
        charts = [histogram(one, columns.labels, shade) for one in varied[:most]]
        if charts:
            told = [element("p", " ".join(notes), class_="quiet")] if notes else []
            yield section(key, title, *told, charts=charts, small=True)


def histogram(one: Column, labels: np.ndarray, shade: int) -> Chart:
    """The runs of the sweep as bars; the nominal one as a line."""
    finite = np.isfinite(one.values)
    sampled, nominal = one.values[finite & (labels >= 0)], one.values[finite & (labels < 0)]
    missing = int((labels >= 0).sum()) - len(sampled)
    edges = bins([Histogram("", sampled, missing, None)])
    traces: list[Json] = [
        {
            "type": "bar",
            "x": chart.packed(0.5 * edges[1:] + 0.5 * edges[:-1]),
            "y": chart.packed(np.histogram(sampled, edges)[0]),
            "width": chart.packed(np.diff(edges)),
            "customdata": chart.packed(np.stack([edges[:-1], edges[1:]], axis=1)),
            "marker": {"color": chart.color(shade, 0.7), "line": {"width": 0}},
            "hovertemplate": "%{y:,} runs from %{customdata[0]:.4~g} to %{customdata[1]:.4~g}<extra></extra>",
        }
    ]
    notes = (one.at, f"{missing:,} runs have none" if missing else "", "dashed: nominal" if len(nominal) else "")
    layout = {
        "yaxis": chart.axis("runs", rangemode="tozero"), "bargap": 0,
        "height": 230, "hovermode": "x", "shapes": [_upright(float(x)) for x in nominal],
    }  # fmt: skip
    return Chart(one.name, traces, layout, one.unit, "; ".join(filter(None, notes)))


def _upright(x: float) -> Json:
    style = {"color": chart.INK, "width": 1.5, "dash": "dash"}
    return {"type": "line", "x0": x, "x1": x, "y0": 0, "y1": 1, "yref": "paper", "line": style}
