"""Histograms: what was drawn, and what came out."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

from lienumba.analysis.outputs import Output
from lienumba.report import chart
from lienumba.report.chart import Chart, Section, section
from lienumba.report.markup import element
from lienumba.report.sensitivity import Columns

if TYPE_CHECKING:
    import numpy as np

MOST_BARS = 60
MOST_INPUTS = 12  # histograms
MOST_OUTPUTS = 9


def sections(columns: Columns) -> Iterator[Section]:
    """Of outputs, and of inputs."""
    groups = (
        ("outputs", "What came out", columns.outputs, MOST_OUTPUTS, 0),
        ("inputs", "What was drawn", columns.inputs, MOST_INPUTS, 2),
    )
    for key, title, found, most, shade in groups:
        charts = [histogram(one, columns.labels, shade) for one in found[:most]]
        more = f"The first {most} of {len(found)}." if len(found) > most else ""
        if charts:
            yield section(key, title, *([element("p", more, class_="quiet")] if more else []), charts=charts)


def histogram(one: Output, labels: np.ndarray, shade: int) -> Chart:
    """The runs of the sweep as bars; the nominal one as a line."""
    import numpy as np

    sampled = one.values[(labels >= 0) & np.isfinite(one.values)]
    counts, edges = _bars(sampled)
    traces: list[dict[str, Any]] = [
        {
            "type": "bar",
            "x": chart.packed(0.5 * (edges[1:] + edges[:-1])),
            "y": chart.packed(counts.astype(float)),
            "width": chart.packed(np.diff(edges)),
            "customdata": chart.packed(np.stack([edges[:-1], edges[1:]], axis=1)),
            "marker": {"color": chart.color(shade, "70%"), "line": {"width": 0}},
            "hovertemplate": "%{y:,} runs from %{customdata[0]:.4~g} to %{customdata[1]:.4~g}<extra></extra>",
        }
    ]
    nominal = one.values[(labels < 0) & np.isfinite(one.values)]
    lines = [_upright(float(x)) for x in nominal]
    missing = int((labels >= 0).sum()) - len(sampled)
    note = [text for text in (one.at, f"{missing:,} runs have none" if missing else "", "line: nominal" if lines else "") if text]
    layout = {
        "xaxis": chart.axis(one.unit), "yaxis": chart.axis("runs", rangemode="tozero"), "bargap": 0,
        "height": 230, "hovermode": "x", "shapes": lines,
    }  # fmt: skip
    return Chart(one.name, ", ".join(note), traces, layout)


def _bars(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Counts and edges of bars: as many as the data bear, and a screen shows."""
    import numpy as np

    low, high = (float(values.min()), float(values.max())) if len(values) else (0.0, 0.0)
    if not high - low > 1e-9 * max(abs(low), abs(high)):
        half = 0.5 * max(abs(low), 1.0) * 1e-3
        return np.array([len(values)]), np.array([low - half, low + half])
    scale = max(abs(low), abs(high))  # a sum of squares of larger numbers may be infinite
    edges = np.histogram_bin_edges(values / scale, "auto")
    if len(edges) > MOST_BARS + 1:
        edges = np.linspace(edges[0], edges[-1], MOST_BARS + 1)
    return np.histogram(values / scale, edges)[0], edges * scale


def _upright(x: float) -> dict[str, Any]:
    style = {"color": "--ink", "width": 1.5, "dash": "dash"}
    return {"type": "line", "x0": x, "x1": x, "y0": 0, "y1": 1, "yref": "paper", "line": style}
