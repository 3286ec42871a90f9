"""The sections of a study: observed orders, errors over the step and over what they cost, and a table of all points."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

from lienumba.analysis import work_precision
from lienumba.analysis.labels import unit_label
from lienumba.analysis.studies.orders import orders
from lienumba.analysis.studies.study import Curve, curves, labels_of, order_text, text, time_text
from lienumba.batch.statuses import GOOD, STATUSES
from lienumba.present.html import chart
from lienumba.present.html.chart import Chart, Section, section
from lienumba.present.html.markup import Markup, element, table
from lienumba.store.study_layout import ERRORS, TRUSTED, grid_of, typical
from lienumba.words import plural

if TYPE_CHECKING:
    import numpy as np
    import xarray as xr

MOST_ROWS = 300
MARKS = ("circle", "square", "diamond", "triangle-up", "triangle-down", "cross", "x", "star")
COSTS = {"step": "mean step (s)", "evaluations": "evaluations per run", "time_per_run": "time of one core per run (s)"}

STILL = (
    "A study keeps no courses, so nothing moves on this page: run the scenario with the settings of a point (",
    element("code", "--set"), ") and without ", element("code", "[study]"), ", and make a report of that.",
)  # fmt: skip


def sections(ds: xr.Dataset) -> Iterator[Section]:
    """Orders and errors over the step, where the grid refines it; work against precision; the points."""
    refined = curves(ds)
    if any(len(curve.points) > 1 for curve in refined):
        charts = [_chart(ds, name, "step", refined) for name in _errors(ds)]
        yield section("orders", "Observed orders", _orders(ds, refined), charts=charts)
    lines = refined or [
        Curve({name: x[n] for name, x in labels_of(ds).items()}, "", [n]) for n in range(ds["time_per_run"].size)
    ]
    charts = [_chart(ds, name, cost, lines) for cost in ("evaluations", "time_per_run") for name in _errors(ds)[:1]]
    yield section("work", "Work against precision", charts=charts)
    still = element("p", *STILL, class_="quiet")
    yield section("points", "Every point", *_ends(ds), _points(ds), still)


def _errors(ds: xr.Dataset) -> list[str]:
    return [name for name in ERRORS if f"{name}_error" in ds]


def _orders(ds: xr.Dataset, lines: Sequence[Curve]) -> Markup:
    found = orders(ds)
    flat = {str(key): x.values.reshape(found.sizes["error"], -1) for key, x in found.data_vars.items()}
    rows = []
    for n, line in enumerate(lines):
        cells = [
            order_text(*(float(flat[key][row, n]) for key in ("order", "low", "high")))
            for row in range(len(flat["order"]))
        ]
        steps = f"{flat['finest'][0, n]:.3g} to {flat['coarsest'][0, n]:.3g} s" if flat["points"][0, n] > 1 else ""
        rows.append([*map(text, line.labels.values()), *cells, str(flat["points"][0, n]), steps])
    names = [str(name).replace("_", " ") for name in found["error"].values]
    return table([*lines[0].labels, *names, "points", "mean steps"], rows, len(lines[0].labels))


def _chart(ds: xr.Dataset, name: str, cost: str, lines: Sequence[Curve]) -> Chart:
    """An error over the step or a cost: a line through the points of each curve, from small steps to large ones."""
    import numpy as np

    steps = (typical(ds, "end_time") / typical(ds, "steps")).values.ravel()
    costs = {
        "step": steps,
        "evaluations": typical(ds, "evaluations").values.ravel(),
        "time_per_run": ds["time_per_run"].values.ravel(),
    }
    x, y, unit = costs[cost], typical(ds, f"{name}_error").values.ravel(), unit_label(ERRORS[name][0])
    traces = []
    for n, curve in enumerate(lines):
        points = np.array(curve.points)
        good = points[(y[points] > 0.0) & (x[points] > 0.0)]
        good = good[np.argsort(steps[good])]
        style = {"mode": "lines+markers", "marker": {"symbol": MARKS[n % len(MARKS)], "size": 7}, "dash": chart.dash(n)}
        hover = f"%{{x:.3~g}}: %{{y:.3~g}} {chart.plain(unit)}"
        traces.append(chart.line(x[good], y[good], curve.name, chart.color(n), hovertemplate=hover, **style))
    layout: dict[str, Any] = {
        "xaxis": chart.axis(COSTS[cost], **chart.logarithmic([x])),
        "yaxis": chart.logarithmic([y]),
        "hovermode": "closest",
        "showlegend": len(lines) <= len(MARKS),
        "height": 340,
    }
    layout["shapes"] = _doubtful(ds, name, 10.0 ** layout["yaxis"]["range"][0])
    title = f"largest {ERRORS[name][1].partition(' (')[0]} over the {COSTS[cost].partition(' (')[0]}"
    return Chart(title, traces, layout, unit, "grey: where the reference says little" if layout["shapes"] else "")


def _doubtful(ds: xr.Dataset, name: str, least: float) -> list[dict[str, Any]]:
    """The area above the least error shown where the reference says little."""
    import numpy as np

    floor = typical(ds, f"reference_{name}_error").values
    known = floor[np.isfinite(floor) & (floor > 0.0)]
    end = float(TRUSTED * known.max(initial=0.0))
    style = {"fillcolor": "--ink 7%", "line": {"width": 0}, "layer": "below"}
    area = {"type": "rect", "xref": "paper", "x0": 0, "x1": 1, "y0": least, "y1": end}
    return [{**area, **style}] if end > least else []


def _ends(ds: xr.Dataset) -> Iterator[Markup]:
    """How runs failed, and what to do."""
    status = ds["status"].values
    rows = [
        (f"{int((status == known.code).sum()):,}", known.name.replace("_", " "), known.sentence)
        for known in STATUSES
        if known.code not in GOOD and (status == known.code).any()
    ]
    if rows:
        yield table(("runs", "how they ended", "what it means, and a remedy"), rows, 3, prose=True)


def _points(ds: xr.Dataset) -> Markup:
    """Errors and costs of every point."""
    import numpy as np

    found, labels = work_precision(ds), labels_of(ds)
    flat = {str(name): x.values.ravel() for name, x in found.data_vars.items()}
    errors = {f"{name}_error": f"{name.replace('_', ' ')} ({unit_label(ERRORS[name][0])})" for name in _errors(ds)}
    known = [name for name in ("steps", "rejected_steps", "evaluations", "failed") if name in flat]
    counts = [name for name in known if name in ("steps", "evaluations") or np.nansum(flat[name])]
    rows = [
        [
            *(text(x[n]) for x in labels.values()),
            *(_number(flat[name][n], ".1e") for name in errors),
            *(_number(flat[name][n], ",.0f") for name in counts),
            time_text(float(flat["time_per_run"][n])),
        ]
        for n in range(min(len(flat["failed"]), MOST_ROWS))
    ]
    headings = [*grid_of(ds), *errors.values(), *(name.replace("_", " ") for name in counts), "time per run"]
    whole = table(headings, rows, len(labels))
    if len(flat["failed"]) <= MOST_ROWS:
        return whole
    more = f"The first {MOST_ROWS} of {plural(len(flat['failed']), 'point', 'points')}."
    return element("div", element("p", more, class_="quiet"), whole)


def _number(x: np.floating[Any], form: str) -> str:
    return f"{x:{form}}" if x == x else "–"
