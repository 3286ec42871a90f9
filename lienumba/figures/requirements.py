"""The figure of a requirement: the inputs that set apart the runs that fail it, as distributions of both groups."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from lienumba.analysis.labels import input_label
from lienumba.analysis.panels.quantiles import Histogram, bins
from lienumba.analysis.requirements.separation import CLEAR, samples, separation
from lienumba.figures import canvas
from lienumba.figures.canvas import COLORS
from lienumba.words import plural

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MOST = 6  # inputs
COLUMNS = 3


def requirement_figure(ds: xr.Dataset, name: str) -> Figure:
    """Histograms of the clearest inputs, each group as parts of its own runs."""
    found = separation(ds, name)
    shown = [str(x) for x in found["input"].values[:MOST]]
    drawn, axes = canvas.tiles(len(shown), min(len(shown), COLUMNS))
    for ax, path, p in zip(axes, shown, found["p_value"].values, strict=False):
        groups = samples(ds, name, path)
        edges: Any = bins([Histogram("", np.concatenate(groups), 0, None)])
        for values, color, label in zip(groups, COLORS, ("meet it", "fail it"), strict=False):
            ax.hist(values, edges, weights=np.full(len(values), 1 / len(values)), color=color, alpha=0.55, label=label)
        how = f"p {'< 1e-6' if p < 1e-6 else f'= {p:.2g}'}"
        ax.set_title(f"{path}\n{how if p < CLEAR else 'no difference to be seen'}", loc="left", fontsize="small")
        ax.set(xlabel=input_label(path, str(ds[path].attrs.get("units", ""))), ylabel="part of these runs")
        ax.grid(True, lw=0.4, alpha=0.5)
        ax.set_axisbelow(True)
    axes[0].legend(frameon=False, fontsize="small")
    left = found.sizes["input"] - len(shown)
    more = f"; {plural(left, 'input', 'inputs')} not shown" if left else ""
    failed, runs = found.attrs["not_met"], found.attrs["not_met"] + found.attrs["met"]
    canvas.entitle(drawn, f"{name}: {failed:,} of {runs:,} runs fail it{more}")
    return drawn
