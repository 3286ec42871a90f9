"""Mechanisms that change: when each event and switch changed something, and in how many runs each switch is on."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import xarray as xr

from lienumba.analysis.changed import Modes, changes, mode_counts
from lienumba.present.html import chart
from lienumba.present.html.chart import Chart, Json, Section, section
from lienumba.present.html.markup import Markup, element, sentence
from lienumba.scene import Scene
from lienumba.scene.switching import LOOKS

MOST_POINTS = 5000  # changes that are drawn
MOST_CHARTS = 6  # of switches that are seen at once
ROW, HEAD = 26, 110  # pixels of a kind of change, and of axes
SHADES = {"closed": 0, "sliding": 1}  # colours
SYMBOLS = {
    "locked": "◆ locked",
    "open": "○ open",
    "closed": "■ closed",
    "sticks": "✚ sticks",
}  # see motion.js


def sections(ds: xr.Dataset, table: list[Markup]) -> Iterator[Section]:
    """Charts of what changed in the runs, beside its table."""
    if "change_time" not in ds or not table:
        return
    counts = list(mode_counts(ds)) if "mode" in ds and "time" in ds["mode"].dims else []
    charts = [*_when(ds), *(_modes(one) for one in counts[:MOST_CHARTS])]
    yield section("changes", "Changes", *table, charts=charts, more=[_modes(one) for one in counts[MOST_CHARTS:]])


def key(found: Scene) -> list[Markup]:
    """What the marks on a moving mechanism mean, of those that occur."""
    every = [run.switching for run in found.runs if run.switching is not None]
    occur = {int(look) for one in every for look in np.unique(one.looks)}
    words = [SYMBOLS[name] for look, name in LOOKS.items() if look in occur]
    words += ["✖ impact, for a moment"] if any(one.hits for one in every) else []
    return [element("p", sentence(", ".join(words)), class_="quiet")] if words else []


def _when(ds: xr.Dataset) -> Iterator[Chart]:
    """Each change as a mark at its time, in the row of what changed and how."""
    found = changes(ds)
    total = found.sizes["entry"]
    if not total:
        return
    kept = np.unique(np.linspace(0, total - 1, min(total, MOST_POINTS)).round().astype(int))
    times, runs = found["time"].values[kept], found["run"].values[kept]
    rows = np.array([f"{what}: {kind}" for what, kind in zip(found.what.values, found.kind.values, strict=True)])[kept]
    names = sorted(set(rows.tolist()), key=lambda name: -float(np.median(times[rows == name])))
    traces: list[Json] = [
        {
            "type": "scatter", "mode": "markers", "x": chart.packed(times[rows == name]),
            "y": [chart.plain(name)] * int((rows == name).sum()), "customdata": chart.packed(runs[rows == name]),
            "marker": {"symbol": "line-ns-open", "size": 11, "color": chart.color(n), "opacity": 0.6},
            "hovertemplate": "%{x:.5~g} s, run %{customdata}<extra></extra>", "showlegend": False,
        }
        for n, name in enumerate(names)
    ]  # fmt: skip
    layout = {
        "xaxis": chart.axis("time (s)", hoverformat=".5~g"), "hovermode": "closest",
        "yaxis": {"type": "category", "automargin": True}, "height": HEAD + max(ROW * len(names), 140),
    }  # fmt: skip
    note = f"{len(kept):,} of {total:,} changes, evenly" if len(kept) < total else ""
    yield Chart("when each changed", traces, layout, "", note)


def _modes(one: Modes) -> Chart:
    """How many runs have a switch closed, and how many have it sliding, over the time, on each other."""
    traces: list[Json] = []
    for name, counts in one.counts.items():
        shade = SHADES[name]
        own: Json = {"stackgroup": "runs", "fillcolor": chart.color(shade, 0.45), "width": 1}
        text = f"%{{y:,}} {name}<extra></extra>"
        traces.append(chart.line(one.times, counts, name, chart.color(shade), hovertemplate=text, **own))
    if one.ended.any():
        text = "%{y:,} runs go on<extra></extra>"
        own = {"dash": "dot", "width": 1.2, "hovertemplate": text}
        traces.append(chart.line(one.times, one.runs - one.ended, "runs that go on", chart.INK, **own))
    layout = {
        "xaxis": chart.axis("time (s)", hoverformat=".5~g"),
        "yaxis": {"range": [0, 1.05 * one.runs], "title": {"text": "runs"}},
        "showlegend": True, "height": 280,
    }  # fmt: skip
    return Chart(one.name, traces, layout, "", f"of {one.runs:,} runs")
