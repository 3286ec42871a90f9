"""The sections of a study: observed orders, errors over the step and over what they cost, and a table of all points."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import xarray as xr

from lienumba.analysis.labels import named, unit_label
from lienumba.analysis.studies.study_rows import (
    COSTS,
    DOUBTFUL,
    EVALUATIONS,
    STEP,
    TIME,
    doubtful,
    failures,
    lines,
    order_table,
    point_table,
    refines,
    remarks,
    time_text,
)
from lienumba.present.html import chart
from lienumba.present.html.chart import Chart, Json, Section, section
from lienumba.present.html.markup import Markup, element, table, text_table
from lienumba.store.study_layout import errors_of, typical
from lienumba.words import plural

MOST_ROWS = 300
MARGIN = 0.06  # of an axis, beyond its points
MARKS = ("circle", "square", "diamond", "triangle-up", "triangle-down", "cross", "x", "star")

STILL = (
    "A study keeps no courses, so nothing moves on this page: run the scenario with the settings of a point (",
    element("code", "--set"), ") and without ", element("code", "[study]"), ", and make a report of that.",
)  # fmt: skip


def sections(ds: xr.Dataset) -> Iterator[Section]:
    """Orders and errors over the step, where the grid refines it; work against precision; the points."""
    names = [*errors_of(ds)]
    if refines(ds):
        charts = [_chart(ds, name, STEP) for name in names if (typical(ds, f"{name}_error") > 0.0).any()]
        yield section("orders", "Observed orders", text_table(order_table(ds)), charts=charts)
    charts = [_chart(ds, name, cost) for cost in (EVALUATIONS, TIME) for name in names[:1]]
    yield section("work", "Work against precision", charts=charts)
    said = [element("p", remark, class_="quiet") for remark in remarks(ds)]
    still = element("p", *STILL, class_="quiet")
    yield section("points", "Every point", *_ends(ds), _points(ds), *said, still)


def _chart(ds: xr.Dataset, name: str, cost: str) -> Chart:
    """An error over the step or a cost: a line through the points of each curve."""
    words, unit_of_cost = COSTS[cost]
    units, said = errors_of(ds)[name]
    unit, error = unit_label(units), said.partition(" (")[0]
    found = lines(ds, f"{name}_error", cost)
    hover = f"%{{x:.3~g}}: %{{y:.3~g}} {chart.plain(unit)}"
    traces = []
    for n, line in enumerate(found):
        style = {"mode": "lines+markers", "marker": {"symbol": MARKS[n % len(MARKS)], "size": 7}, "dash": chart.dash(n)}
        traces.append(chart.line(line.x, line.y, line.name, chart.color(n), hovertemplate=hover, **style))
    y_axis = chart.logarithmic(line.y for line in found)
    shapes = _doubtful(doubtful(ds, name), 10.0 ** y_axis["range"][0])
    layout: Json = {
        "xaxis": chart.axis(words, **_costs(np.concatenate([line.x for line in found]), unit_of_cost)),
        "yaxis": y_axis,
        "hovermode": "closest",
        "showlegend": len(found) <= len(MARKS),
        "height": 340,
        "shapes": shapes,
    }  # fmt: skip
    note = f"grey: {DOUBTFUL}" if shapes else ""
    return Chart(f"{named(f'largest {error}', units)} over the {words}", traces, layout, note=note)


def _costs(values: np.ndarray, unit: str) -> Json:
    """A logarithmic axis of steps, times or counts, closely around them, with the unit in its numbers."""
    if not len(values):
        return chart.logarithmic([values])
    low, high = np.log10([values.min(), values.max()])
    room = max(MARGIN * (high - low), MARGIN)
    leading = (1.0, 2.0, 5.0) if high - low < chart.FEW_POWERS else (1.0,)
    powers = range(int(np.floor(low - room)), int(np.ceil(high + room)) + 1)
    ticks = [first * 10.0**power for power in powers for first in leading]
    texts = [time_text(x) if unit else f"{x:,.0f}" for x in ticks]
    return {"type": "log", "range": [low - room, high + room], "tickvals": ticks, "ticktext": texts}


def _doubtful(end: float, least: float) -> list[Json]:
    """The area up to an error, above the least that is shown."""
    style = {"fillcolor": chart.shaded(chart.INK, 0.07), "line": {"width": 0}, "layer": "below"}
    area = {"type": "rect", "xref": "paper", "x0": 0, "x1": 1, "y0": least, "y1": end}
    return [{**area, **style}] if end > least else []


def _ends(ds: xr.Dataset) -> Iterator[Markup]:
    """How runs failed, and what to do."""
    rows = [(f"{x.count:,}", x.status.name.replace("_", " "), x.status.sentence) for x in failures(ds)]
    if rows:
        yield table(("runs", "how they ended", "what it means, and a remedy"), rows, 3, prose=True)


def _points(ds: xr.Dataset) -> Markup:
    """Errors and costs of every point."""
    whole, points = text_table(point_table(ds, MOST_ROWS)), ds["time_per_run"].size
    if points <= MOST_ROWS:
        return whole
    more = f"The first {MOST_ROWS} of {plural(points, 'point', 'points')}."
    return element("div", element("p", more, class_="quiet"), whole)
