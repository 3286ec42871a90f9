"""Figures of numbers that each run has: over an input as points, and how well their mean is known after so many
runs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from lienumba.analysis.labels import named, time_label
from lienumba.analysis.outcomes import of_sweep
from lienumba.analysis.sensitivities import outputs
from lienumba.analysis.sensitivities.outputs import Output
from lienumba.errors import ScenarioError
from lienumba.figures import canvas
from lienumba.figures.canvas import COLORS
from lienumba.store.names import INPUT, known, one_of
from lienumba.sweep.confidence import half_width, proportion

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST_POINTS = 5000  # of a scatter
MOST_PANELS = 24
LOOKS = 300  # numbers of runs at which a mean is drawn
CONFIDENCE = 0.95
COLUMNS = 3
WHY = "see with lienumba info why runs failed"


def scatter(ds: xr.Dataset, names: Sequence[str], inputs: Sequence[str]) -> Figure:
    """Each output (rows) over each of these inputs (columns), with its mean over groups of neighbours."""
    sampled = [x.name for x in known(ds).every.values() if x.kind == INPUT]
    for name in inputs:
        one_of(name, sampled, "the dataset", "input", "its sweep varies nothing")
    found = _read(ds, names, MOST_PANELS // len(inputs))
    drawn, axes = canvas.blank(len(found), len(inputs))
    for row, output in zip(axes, found, strict=True):
        if not np.isfinite(output.values).any():
            raise ScenarioError(f"{output.name}: no good run has a value, so there are no points; {WHY}")
        for ax, name in zip(row, inputs, strict=True):
            _points(ax, ds[name].values, output.values)
            ax.set(xlabel=named(name, str(ds[name].attrs.get("units", ""))), ylabel=_label(output))
    canvas.entitle(drawn, str(ds.attrs.get("title", "")), "points are runs, the line their mean")
    return drawn


def _points(ax: Axes, x: np.ndarray, y: np.ndarray) -> None:
    both = np.isfinite(x) & np.isfinite(y)
    x, y = x[both], y[both]
    few = np.unique(np.linspace(0, max(len(x) - 1, 0), min(len(x), MOST_POINTS)).astype(int))
    ax.plot(x[few], y[few], ".", ms=4 if len(x) < 1000 else 2, color=COLORS[0], alpha=0.5, mew=0)
    groups = np.array_split(np.argsort(x, kind="stable"), max(round(len(x) ** 0.4), 1))
    if len(groups) > 2:
        ax.plot([x[g].mean() for g in groups], [y[g].mean() for g in groups], color="black", lw=1.3)
    ax.grid(True, lw=0.4, alpha=0.5)


def convergence(ds: xr.Dataset, names: Sequence[str]) -> Figure:
    """The mean of each output over the first so many runs, with its 95 % interval at each number of them."""
    found = _read(ds, names, MOST_PANELS)
    drawn, axes = canvas.tiles(len(found), min(len(found), COLUMNS))
    for ax, output in zip(axes, found, strict=True):
        values = output.values[np.isfinite(output.values)]
        if len(values) < 2:
            raise ScenarioError(f"{output.name}: has a value in {len(values)} runs, and a mean takes at least 2; {WHY}")
        n, mean, low, high = running(values)
        ax.fill_between(n, low, high, color=COLORS[0], alpha=0.25, lw=0, label="95 % interval")
        ax.plot(n, mean, color=COLORS[0], lw=1.3, label="mean")
        last = len(n) // 10  # where there are few runs, intervals are far wider than what matters
        ends = min(mean.min(), low[last:].min()), max(mean.max(), high[last:].max())
        if ends[0] < ends[1]:
            ax.set_ylim(*ends)
        ax.set(xscale="log", xlabel="runs", ylabel=_label(output))
        ax.grid(True, lw=0.4, alpha=0.5)
    axes[0].legend(frameon=False, fontsize="small")
    canvas.entitle(drawn, str(ds.attrs.get("title", "")), "means over the first so many runs")
    return drawn


def running(values: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Numbers of runs n, the means of the first n values (runs,), and the ends of their 95 % intervals: by Student's t,
    of true and false by Clopper and Pearson."""
    n = np.unique(np.geomspace(2, len(values), LOOKS).astype(int))
    shifted = values - values[0]  # else rounding takes what squares differ in
    mean = np.cumsum(shifted)[n - 1] / n
    if np.isin(values, (0.0, 1.0)).all():
        low, high = proportion(np.cumsum(values)[n - 1], n, CONFIDENCE)
        return n, mean + values[0], low, high
    variance = np.maximum(np.cumsum(shifted**2)[n - 1] - n * mean**2, 0.0) / (n - 1)
    half = half_width(variance**0.5, n, CONFIDENCE)
    return n, mean + values[0], mean + values[0] - half, mean + values[0] + half


def _read(ds: xr.Dataset, names: Sequence[str], most: int) -> list[Output]:
    """Outputs of these names, or those that say most."""
    found = list(outputs.read(ds, names, None, of_sweep(ds)))
    if len(found) > most:
        raise ScenarioError(f"these are {len(found)} outputs, and a figure has room for {most}; name fewer")
    return found


def _label(output: Output) -> str:
    return " ".join(filter(None, [named(output.name, output.units), time_label(output.time)]))
