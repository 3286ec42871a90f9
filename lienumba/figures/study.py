"""The figure of a study: errors over the step with the slopes that they show, over evaluations, and over time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from lienumba.analysis.labels import axis_label
from lienumba.analysis.studies.orders import orders
from lienumba.analysis.studies.study import Curve, curves, labels_of
from lienumba.errors import ScenarioError
from lienumba.figures.canvas import COLORS, blank, entitle
from lienumba.store.study_layout import ERRORS, TRUSTED, typical
from lienumba.words import show

if TYPE_CHECKING:
    import numpy as np
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MARKERS = "osD^vP*X"
COSTS = {"evaluations": ("evaluations per run", ""), "time_per_run": ("time of one core per run", "s")}
HEIGHT = 4.4  # of a panel, inches
IN_A_ROW = 6  # of the legend


def study_figure(ds: xr.Dataset, names: Sequence[str] = ()) -> Figure:
    """A row of panels for each of these variables, or for the position error."""
    import numpy as np

    names = names or [name for name in (f"{name}_error" for name in ERRORS) if name in ds][:1]
    for name in names:
        if name == "status":
            raise ScenarioError('"status" is a code, not a number; name a variable such as position_error')
        if ds[name].dims != ds["status"].dims:
            raise ScenarioError(f"{show(name)} has no value for every run and point; name one such as position_error")
    refined, steps = curves(ds), (typical(ds, "end_time") / typical(ds, "steps")).values.ravel()
    lines = [*refined, *_single(ds, {point for curve in refined for point in curve.points})]
    costs = {"evaluations": typical(ds, "evaluations"), "time_per_run": ds["time_per_run"]}
    drawn, axes = blank(len(names), 3 if refined else 2, HEIGHT)
    for row, name in zip(axes, names, strict=True):
        values = typical(ds, name).values.ravel()
        logarithmic = bool((values > 0.0).any() if name in _errors() else (values[np.isfinite(values)] > 0.0).all())
        label = ("largest " if name in _errors() else "") + axis_label(name, ds[name].attrs["units"])
        if refined:
            _draw(row[0], steps, values, steps, refined, logarithmic)
            _slopes(row[0], ds, name)
            _finish(row[0], "mean step", "s", label, logarithmic)
        for ax, cost in zip(row[-2:], costs, strict=True):
            _draw(ax, costs[cost].values.ravel(), values, steps, lines, logarithmic)
            _finish(ax, *COSTS[cost], label, logarithmic)
        for ax in row:
            _shade(ax, ds, name)
    handles, labels = axes[0][-1].get_legend_handles_labels()
    if labels:
        drawn.legend(handles, labels, loc="outside lower center", ncols=min(len(labels), IN_A_ROW), fontsize="small")
    runs = ds.sizes["run"]
    title = f"{ds.attrs['title']}: " if ds.attrs.get("title") else ""
    entitle(drawn, title + (f"medians of {runs:,} runs" if runs > 1 else "1 run at each point"))
    return drawn


def _errors() -> set[str]:
    return {f"{name}_error" for name in ERRORS}


def _single(ds: xr.Dataset, others: set[int]) -> list[Curve]:
    """Every point for itself, but for these others."""
    labels = labels_of(ds)
    return [
        Curve({name: values[point] for name, values in labels.items()}, "", [point])
        for point in range(ds["time_per_run"].size)
        if point not in others
    ]


def _draw(ax: Axes, x: np.ndarray, y: np.ndarray, steps: np.ndarray, lines: Sequence[Curve], logarithmic: bool) -> None:
    """A line through the points of each curve that have a place on the axes, from small steps to large ones."""
    import numpy as np

    for n, line in enumerate(lines):
        points = np.array(line.points)
        good = points[((y[points] > 0.0) if logarithmic else np.isfinite(y[points])) & (x[points] > 0.0)]
        good = good[np.argsort(steps[good])]
        color, marker = COLORS[n % len(COLORS)], MARKERS[n % len(MARKERS)]
        ax.plot(x[good], y[good], color=color, marker=marker, lw=1.2, ms=4.5, label=line.name or None)
    ax.margins(y=0.08)


def _slopes(ax: Axes, ds: xr.Dataset, name: str) -> None:
    """Dashed lines of whole slopes beside the curves that show them."""
    import numpy as np

    kind = name.removesuffix("_error")
    if kind not in ERRORS or name not in _errors():
        return
    found = orders(ds).sel(error=kind)
    drawn: set[int] = set()
    for line, order, first, last in zip(
        list(ax.lines), *(found[key].values.ravel() for key in ("order", "finest", "coarsest")), strict=True
    ):
        slope = round(order) if np.isfinite(order) else 0
        x, y = (np.asarray(values, float) for values in line.get_data())
        if slope < 1 or slope in drawn or not len(x):
            continue
        drawn.add(slope)
        start = 0.4 * y[np.argmin(np.abs(np.log(x / first)))]
        ends = np.array([first, last])
        ax.plot(ends, start * (ends / first) ** slope, color="0.45", lw=1.0, ls="--", zorder=1)
        ax.annotate(
            f"slope {slope}", (first, start), xytext=(5, -2), textcoords="offset points", color="0.35",
            fontsize="small", va="top",
        )  # fmt: skip


def _shade(ax: Axes, ds: xr.Dataset, name: str) -> None:
    """Where the reference says little."""
    import numpy as np

    if name not in _errors():
        return
    floor = np.nanmax(typical(ds, f"reference_{name}").values)
    low, high = ax.get_ylim()
    if TRUSTED * floor > low:
        ax.axhspan(low, min(TRUSTED * floor, high), color="0.88", zorder=0)
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
