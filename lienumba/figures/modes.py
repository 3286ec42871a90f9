"""The figure of modes: their eigenvalues in the complex plane, and how frequencies go with a swept number."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from lienumba.analysis.mode_rows import swept
from lienumba.figures.canvas import COLORS, blank, entitle
from lienumba.words import plural

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST_NAMED = 8  # modes
MOST_TIMES = 4


def modes_figure(ds: xr.Dataset) -> Figure:
    """What `lienumba.modes` found: for each of the first times the eigenvalues of all runs, and a fan of frequencies
    over each swept number, or the two with which they go most."""
    inputs, times = swept(ds, 2), ds["time"].values[:MOST_TIMES]
    drawn, axes = blank(len(times), 1 + len(inputs))
    for row, time in zip(axes, times, strict=True):
        own = ds.sel(time=time)
        _plane(row[0], own, f"t = {time:g} s")
        for ax, name in zip(row[1:], inputs, strict=True):
            _fan(ax, own, name)
    if ds.sizes["mode"] <= MOST_NAMED:
        handles, labels = axes[0][0].get_legend_handles_labels()
        drawn.legend(handles, labels, loc="outside lower center", ncols=MOST_NAMED, fontsize="small")
    count = f"{plural(ds.sizes['mode'], 'mode', 'modes')} of {plural(ds.sizes['run'], 'run', 'runs')}"
    more = f", the first {len(times)} of {ds.sizes['time']} times" if len(times) < ds.sizes["time"] else ""
    entitle(drawn, str(ds.attrs.get("title", "")), count + more)
    return drawn


def _plane(ax: Axes, own: xr.Dataset, label: str) -> None:
    for n, mode in enumerate(own["mode"].values):
        x, y = (own[name].sel(mode=mode).values for name in ("growth", "angular_frequency"))
        ax.plot(x, y, ".", color=COLORS[n % len(COLORS)], label=f"mode {mode}", markersize=5)
    ax.axvline(0.0, color="0.5", linewidth=0.8)
    ax.set(xlabel="real part in 1/s", ylabel="imaginary part in rad/s", title=label)


def _fan(ax: Axes, own: xr.Dataset, name: str) -> None:
    order = np.argsort(own[name].values, kind="stable")
    line = "-" if sum(x.attrs.get("role") == "input" for x in own.coords.values()) == 1 else "."
    for n, mode in enumerate(own["mode"].values):
        frequency = own["frequency"].sel(mode=mode).values[order]
        ax.plot(own[name].values[order], frequency, line, color=COLORS[n % len(COLORS)], markersize=4)
    ax.set(xlabel=name, ylabel="frequency in Hz")
