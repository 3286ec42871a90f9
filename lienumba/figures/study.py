"""The figure of a study: errors over the step with the slopes that they show, over evaluations, and over time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from lienumba.analysis.labels import axis_label
from lienumba.analysis.studies.orders import orders
from lienumba.analysis.studies.study import curves
from lienumba.analysis.studies.study_rows import (
    COSTS,
    DOUBTFUL,
    EVALUATIONS,
    NONE_SEEN,
    STEP,
    TIME,
    StudyLine,
    doubtful,
    lines,
    order_text,
)
from lienumba.analysis.text_table import NONE
from lienumba.errors import ScenarioError
from lienumba.figures.canvas import COLORS, blank, entitle
from lienumba.store.study_layout import errors_of, typical
from lienumba.words import show

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MARKERS = "osD^vP*X"
HEIGHT = 4.4  # of a panel, inches
IN_A_ROW = 6  # of the legend
FIT = ("order", "low", "high", "finest", "coarsest")
BELOW = 0.4  # of a curve: where the line of its slope begins
ROW = 0.06  # of the height of a panel: between the names of slopes
SHADE = "0.88"


def study_figure(ds: xr.Dataset, names: Sequence[str] = ()) -> Figure:
    """A row of panels for each of these variables, or for the position error."""
    from matplotlib.patches import Patch

    names = names or [f"{name}_error" for name in errors_of(ds)][:1]
    for name in names:
        if name == "status":
            raise ScenarioError('"status" is a code, not a number; name a variable such as position_error')
        if ds[name].dims != ds["status"].dims:
            raise ScenarioError(f"{show(name)} has no value for every run and point; name one such as position_error")
    costs = [*([STEP] if curves(ds) else []), EVALUATIONS, TIME]
    drawn, axes = blank(len(names), len(costs), HEIGHT)
    for row, name in zip(axes, names, strict=True):
        values, error = typical(ds, name).values.ravel(), _error_of(ds, name)
        logarithmic = bool((values > 0.0).any() if error else (values[np.isfinite(values)] > 0.0).all())
        label = ("largest " if error else "") + axis_label(name, ds[name].attrs.get("units", ""))
        for ax, cost in zip(row, costs, strict=True):
            _draw(ax, lines(ds, name, cost, logarithmic))
            _finish(ax, *COSTS[cost], label, logarithmic)
            if error and cost == STEP and logarithmic:
                _slopes(ax, ds, error)
            if error:
                _shade(ax, doubtful(ds, error))
    handles, labels = axes[0][-1].get_legend_handles_labels()
    if any(ax.patches for row in axes for ax in row):
        handles, labels = [*handles, Patch(color=SHADE)], [*labels, DOUBTFUL]
    if labels:
        drawn.legend(handles, labels, loc="outside lower center", ncols=min(len(labels), IN_A_ROW), fontsize="small")
    runs = ds.sizes["run"]
    entitle(drawn, str(ds.attrs.get("title", "")), f"medians of {runs:,} runs" if runs > 1 else "1 run at each point")
    return drawn


def _error_of(ds: xr.Dataset, name: str) -> str:
    """Of what a variable is the error, if it is one."""
    kind = name.removesuffix("_error")
    return kind if kind in errors_of(ds) and kind != name else ""


def _draw(ax: Axes, shown: Sequence[StudyLine]) -> None:
    for n, line in enumerate(shown):
        color, marker = COLORS[n % len(COLORS)], MARKERS[n % len(MARKERS)]
        ax.plot(line.x, line.y, color=color, marker=marker, lw=1.2, ms=4.5, label=line.name or None)
    ax.margins(y=0.08)


def _slopes(ax: Axes, ds: xr.Dataset, error: str) -> None:
    """Dashed lines of whole slopes below the curves that show them, named at the right of the panel, where no curve
    is."""
    found = orders(ds).sel(error=error)
    ends: dict[int, float] = {}
    for line, (*fit, first, last) in zip(
        list(ax.lines), zip(*(found[key].values.ravel() for key in FIT), strict=True), strict=True
    ):
        slope = round(fit[0]) if order_text(*fit) not in (NONE, NONE_SEEN) else 0
        x, y = (np.asarray(values, float) for values in line.get_data())
        if slope < 1 or slope in ends or not len(x):
            continue
        start = BELOW * y[np.argmin(np.abs(np.log(x / first)))]
        ends[slope] = start * (last / first) ** slope
        ax.plot([first, last], [start, ends[slope]], color="0.45", lw=1.0, ls="--", zorder=1)
    low, high = np.log(ax.get_ylim())
    free = 1.0
    for slope, end in sorted(ends.items(), key=lambda x: -x[1]):
        free = min(free, float((np.log(end) - low) / (high - low)))
        ax.annotate(f"slope {slope}", (1.0, free), xycoords="axes fraction", xytext=(4, 0), textcoords="offset points",
                    color="0.35", fontsize="small", va="center")  # fmt: skip
        free -= ROW


def _shade(ax: Axes, end: float) -> None:
    """Where the reference is not good enough to tell."""
    low, high = ax.get_ylim()
    if end > low:
        ax.axhspan(low, min(end, high), color=SHADE, zorder=0)
        ax.set_ylim(low, high)


def _finish(ax: Axes, x: str, unit: str, y: str, logarithmic: bool) -> None:
    from matplotlib.ticker import EngFormatter, LogLocator, NullFormatter

    ax.set_xscale("log")
    if logarithmic:
        ax.set_yscale("log")
    low, high = ax.get_xlim()
    ax.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if high < 300.0 * low else (1.0,)))
    ax.xaxis.set_major_formatter(EngFormatter(unit))
    ax.xaxis.set_minor_formatter(NullFormatter())
    ax.set_xlabel(x)
    ax.set_ylabel(y)
    ax.grid(True, which="both", lw=0.3, alpha=0.5)
