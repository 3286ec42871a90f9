"""One panel of a figure: bands of quantiles over the time, lines of few runs, histograms, or bars of how runs ended."""

from __future__ import annotations

from collections.abc import Sequence
from textwrap import wrap
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import xarray as xr

from lienumba.analysis.panels.quantiles import (
    LEVELS,
    Histogram,
    PanelSeries,
    TimeSeries,
    bins,
    ended_early,
    histograms,
    label,
    statuses,
    time_series,
)
from lienumba.analysis.panels.run_windows import reached, shown_runs
from lienumba.analysis.panels.select_panels import Panel
from lienumba.batch.statuses import GOOD, STATUSES
from lienumba.figures.canvas import COLORS, STYLES, Style
from lienumba.mechanics.system.output_variables import MODE
from lienumba.store.names import STATUS
from lienumba.words import plural

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

BANDS = ((1, 3, 0.42), (0, 4, 0.22))  # levels from and to, opacity
MEDIAN = LEVELS.index(0.5)
NOMINAL: Style = {"color": "black", "lw": 1.0, "ls": (0, (4, 2))}
SAMPLE: Style = {"color": "0.35", "lw": 0.6}
CHANGE: Style = {"color": "0.5", "lw": 0.6, "ls": (0, (1, 2)), "zorder": 0.9}
DECADES = 4  # of a logarithmic axis, below the largest
LARGEST: Style = {"lw": 0.8, "ls": ":"}
LEGEND: Style = {
    "loc": "lower right", "bbox_to_anchor": (1.0, 1.0), "fontsize": "small", "frameon": False, "borderpad": 0.2,
    "borderaxespad": 0.1, "handlelength": 1.2, "columnspacing": 1.0, "handletextpad": 0.4,
}  # fmt: skip
ENTRY, NOTE = 1.75, 0.09  # inches that an entry of the legend below the figure takes, and a letter of the note
MOST_NAMED = 4  # runs, in a legend
BESIDE = 52  # letters of a title and a legend in one row
ROOM = 25  # widths of the bar of a constant that are left free at both sides
MOST_TICKS = 6  # intervals between the ticks of a histogram
CLOSE = 1000.0  # times their differences are numbers that have long names
KEY = 5  # letters that the line before an entry of a legend takes
ROW = 14  # points of a row of a legend
LONG = 44  # letters of a title in small print


def draw(ax: Axes, ds: xr.Dataset, panel: Panel) -> PanelSeries | None:
    """Draw a panel; returned are its time series, if it has some."""
    shown = None
    if panel.name == STATUS:
        _bars(ax, statuses(ds))
    elif panel.over_time:
        course = reached(ds)
        shown = time_series(course, panel)
        _time_series(ax, shown, panel)
        ax.set(xlabel="time (s)", ylabel=label(course, panel))
        if panel.steps:
            ax.set_yticks(range(len(MODE.flags)), MODE.flags)
        if shown.runs == 1 and "change_time" in ds:
            _mark_changes(ax, ds, panel)
    else:
        _histograms(ax, histograms(ds, panel))
        ax.set(xlabel=label(ds, panel), ylabel="runs")
    _entitle(ax, panel.title)
    ax.grid(True, lw=0.4, alpha=0.5)
    ax.set_axisbelow(True)
    return shown


def explain(drawn: Figure, panels: Sequence[Panel], shown: Sequence[PanelSeries], nominal: bool, note: str) -> None:
    """Say below a figure what its bands and lines are, that of the nominal run too if there is one, and a note."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    many = [(panel, series) for panel, series in zip(panels, shown, strict=True) if not series.few]
    note = "; ".join(filter(None, [ended_early([series for _, series in many]), note]))
    handles: list[Any] = []
    if many:
        handles.append(Line2D([], [], color="0.3", label="median"))
    if any(not panel.logarithmic for panel, _ in many):
        for low, high, opacity in BANDS:
            text = f"{100 * LEVELS[low]:.0f} to {100 * LEVELS[high]:.0f} % of the runs"
            handles.append(Patch(color="0.3", alpha=opacity, lw=0, label=text))
    if any(panel.logarithmic for panel, _ in many):
        handles.append(Line2D([], [], color="0.3", **LARGEST, label="largest of the runs"))
    if any(len(series.lines) == 1 for _, series in many):
        handles.append(Line2D([], [], **SAMPLE, label="some of the runs"))
    if nominal:
        handles.append(Line2D([], [], **NOMINAL, label="nominal run"))
    if handles or note:
        width = drawn.get_figwidth()
        drawn.legend(
            handles=handles, loc="outside lower center", frameon=False, fontsize="small",
            ncols=max(1, min(len(handles), int(width / ENTRY))),
            title="\n".join(wrap(note, int(width / NOTE))) or None, title_fontsize="small",
        )  # fmt: skip


def _time_series(ax: Axes, shown: PanelSeries, panel: Panel) -> None:
    """Lines and bands over the time."""
    logarithmic = panel.logarithmic
    alone = len(shown.lines) == 1
    for n, line in enumerate(shown.lines):
        style: Style = {"color": COLORS[n % len(COLORS)], "ls": STYLES[n // len(COLORS) % len(STYLES)]}
        if panel.steps:
            style["drawstyle"] = "steps-post"
        if shown.few:
            _each(ax, shown, line, style, alone)
        elif logarithmic:
            median = _positive(_where_enough(shown, line.quantiles[MEDIAN]))
            ax.plot(shown.times, median, **style, lw=1.3, label=line.label or None)
            ax.plot(shown.times, _positive(line.largest), color=style["color"], **LARGEST)
        else:
            _bands(ax, shown, line, style, alone)
        if line.nominal is not None and not logarithmic:
            ax.plot(shown.times, line.nominal, **NOMINAL)
    largest = max((value for line in shown.lines for value in line.largest if value > 0.0), default=0.0)
    if logarithmic and largest:
        ax.set_yscale("log")
        ax.set_ylim(max(ax.get_ylim()[0], largest * 10.0**-DECADES))


def _mark_changes(ax: Axes, ds: xr.Dataset, panel: Panel) -> None:
    """When the mechanism of the one run that is shown changed."""
    run = ds[panel.dim].values[shown_runs(ds, panel)][0]
    for time in np.unique(ds["change_time"].sel(run=run).dropna("change")):
        ax.axvline(time, **CHANGE)


def _each(ax: Axes, shown: PanelSeries, line: TimeSeries, style: Style, alone: bool) -> None:
    """Each of few runs, in colours of their own if they are all there is in the panel."""
    own_colors = alone and 1 < shown.runs <= len(COLORS)
    for n, (run, values) in enumerate(line.each.items()):
        own = style | {"color": COLORS[n]} if own_colors else style
        name = f"run {run}" if own_colors and shown.runs <= MOST_NAMED else line.label if n == 0 else ""
        ax.plot(shown.times, values, **own, lw=0.8 if shown.runs > 1 else 1.3, label=name or None)


def _bands(ax: Axes, shown: PanelSeries, line: TimeSeries, style: Style, alone: bool) -> None:
    """Bands between quantiles and the median, where there are runs enough, else those that are left; and some runs if
    there is room."""
    step: Literal["post"] | None = "post" if "drawstyle" in style else None
    for low, high, opacity in BANDS[::-1]:
        low_values, high_values = _where_enough(shown, line.quantiles[[low, high]])
        ax.fill_between(shown.times, low_values, high_values, color=style["color"], alpha=opacity, lw=0, step=step)
    for values in line.each.values() if alone else ():
        ax.plot(shown.times, values, **SAMPLE)
    for values in line.left.values():
        ax.plot(shown.times, values, **style, lw=0.6)
    ax.plot(shown.times, _where_enough(shown, line.quantiles[MEDIAN]), **style, lw=1.3, label=line.label or None)


def _where_enough(shown: PanelSeries, quantiles: np.ndarray) -> np.ndarray:
    """Quantiles (..., times) where enough runs have a value."""
    return np.where(shown.enough, quantiles, np.nan)


def _positive(values: np.ndarray) -> np.ndarray:
    """What a logarithmic axis can show of values."""
    return np.where(values > 0.0, values, np.nan)


def _histograms(ax: Axes, found: Sequence[Histogram]) -> None:
    """How numbers that each run has once are one."""
    shown = [one for one in found if len(one.values)]
    if not shown:
        ax.text(0.5, 0.5, "no run has a value", transform=ax.transAxes, ha="center", va="center", color="0.35")
        return
    edges: Any = bins(shown)
    if edges[0] > 0.0 and abs(edges[1] / edges[0] - edges[-1] / edges[-2]) < 1e-6 and len(edges) > 2:
        ax.set_xscale("log")
    for n, one in enumerate(shown):
        missing = f"{plural(one.missing, 'run has', 'runs have')} none" if one.missing else ""
        name = ", ".join(filter(None, [one.label if len(found) > 1 else "", missing]))
        opacity = 0.7 if len(shown) > 1 else 0.9
        ax.hist(one.values, edges, color=COLORS[n % len(COLORS)], alpha=opacity, label=name or None)
        if one.failed is not None:
            ax.hist(one.failed, edges, color=COLORS[1], label="failed runs")
        if one.nominal is not None:
            ax.axvline(one.nominal, **NOMINAL)
    if len(edges) == 2:
        _constant(ax, edges)
    elif ax.get_xscale() == "linear":
        ax.locator_params(axis="x", nbins=_ticks(edges))
    ax.yaxis.set_major_formatter("{x:,.0f}")
    ax.locator_params(axis="y", integer=True)


def _constant(ax: Axes, edges: np.ndarray) -> None:
    """Room around the thin bar of a constant, and its value below it."""
    value, width = 0.5 * (edges[0] + edges[1]), edges[1] - edges[0]
    low, high = ax.get_xlim()
    ax.set_xlim(min(low, value - ROOM * width), max(high, value + ROOM * width))
    ax.set_xticks([value], [f"{value:.6g}"])


def _ticks(edges: np.ndarray) -> int:
    """How many intervals between ticks have room: less where numbers differ in a late digit."""
    return MOST_TICKS if max(abs(edges)) < CLOSE * (edges[-1] - edges[0]) else MOST_TICKS // 2


def _bars(ax: Axes, counts: dict[str, int]) -> None:
    """How many runs ended in which way."""
    good = {status.name for status in STATUSES if status.code in GOOD}
    names = list(counts)[::-1]
    drawn = ax.barh(
        [name.replace("_", " ") for name in names],
        [counts[name] for name in names],
        color=[COLORS[0] if name in good else COLORS[1] for name in names],
        height=0.6,
    )
    ax.bar_label(drawn, [f"{counts[name]:,}" for name in names], padding=3)
    ax.margins(x=0.15)
    ax.locator_params(axis="x", integer=True)
    ax.set_ylim(-1, len(names))
    ax.set_xlabel("runs")


def _entitle(ax: Axes, title: str) -> None:
    """The title at the left, the legend above the data at the right: in one row with it if there is room, else in as
    few rows as have room."""
    labels = ax.get_legend_handles_labels()[1]
    letters = [len(name) + KEY for name in labels]
    columns = len(labels) if sum(letters) <= BESIDE else max(1, BESIDE // max(letters))
    beside = len(title) + sum(letters) <= BESIDE
    rows = 0 if beside or not labels else -(-len(labels) // columns)
    ax.set_title(title, loc="left", fontsize="medium" if len(title) <= LONG else "small", pad=6 + ROW * rows)
    if labels:
        ax.legend(**LEGEND, ncols=columns)
