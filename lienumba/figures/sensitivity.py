"""The figure of what outputs depend on: of each output its Sobol' indices, or Morris' elementary effects, as far
as the runs say them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from itertools import zip_longest
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from lienumba.analysis.labels import named, time_label
from lienumba.analysis.sensitivities.sensitivity import sensitivity
from lienumba.analysis.sensitivities.sensitivity_rows import InputRow, OutputRows, sensitivity_rows
from lienumba.figures import canvas
from lienumba.figures.canvas import COLORS

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST = 12  # inputs
WIDTH, HEIGHT = 6.4, 3.8  # of a panel, inches
MARKERS = "os^"
RATIOS = {1.0: "-", 0.5: "--", 0.1: ":"}  # of sigma to mu*
RANK, FIRST, TOTAL, EFFECT = "rank_correlation", "first_order", "total_order", "mu_star"
TITLES = {RANK: "rank correlation", FIRST: "alone", TOTAL: "with all others"}
PART = "part of the variance"


def sensitivity_figure(ds: xr.Dataset, names: Sequence[str]) -> Figure:
    """A row of panels for each output."""
    found = sensitivity_rows(sensitivity(ds, names))
    panels = [list(_panels(output)) for output in found.outputs]
    columns = max(map(len, panels))
    drawn = canvas.empty(WIDTH * columns, HEIGHT * len(panels))
    axes = drawn.subplots(len(panels), columns, squeeze=False)
    for output, row, own in zip(found.outputs, axes, panels, strict=True):
        row[0].set_title(" ".join(filter(None, [output.name, time_label(output.time)])), loc="left", fontsize="medium")
        for ax, panel in zip_longest(row, own):
            if panel is None:
                ax.set_visible(False)
                continue
            panel(ax)
            ax.grid(True, lw=0.4, alpha=0.5)
            ax.set_axisbelow(True)
    canvas.entitle(drawn, f"{found.headline}; whiskers are 95 % intervals")
    return drawn


def _panels(output: OutputRows) -> Iterator[Callable[[Axes], None]]:
    """What is drawn of an output."""
    known = [
        name
        for name in (EFFECT, TOTAL, FIRST, RANK)
        if any(row.numbers[name] == row.numbers[name] for row in output.inputs)
    ]
    if EFFECT in known:
        yield partial(_effects, output=output)
    else:
        yield partial(_bars, output=output, names=[FIRST, TOTAL] if TOTAL in known else known[:1])


def _first(output: OutputRows, name: str) -> list[InputRow]:
    """The inputs that have this number, the largest at first."""
    having = [row for row in output.inputs if row.numbers[name] == row.numbers[name]]
    return sorted(having, key=lambda row: -abs(row.numbers[name]))[:MOST]


def _whiskers(row: InputRow, name: str) -> tuple[float, float]:
    """How far the interval reaches to either side; nothing where there is none."""
    x, low, high = (row.numbers[key] for key in (name, f"{name}_low", f"{name}_high"))
    return (x - low, high - x) if high == high else (0.0, 0.0)


def _bars(ax: Axes, output: OutputRows, names: Sequence[str]) -> None:
    """A bar for each input, and each of these numbers."""
    rows = _first(output, names[-1])
    height = 0.8 / len(names)
    for n, name in enumerate(names):
        places = np.arange(len(rows)) + (n - 0.5 * (len(names) - 1)) * height
        ends = np.array([_whiskers(row, name) for row in rows]).T
        style: canvas.Style = {"ecolor": "0.35", "capsize": 2, "color": COLORS[n], "label": TITLES[name]}
        ax.barh(places, [row.numbers[name] for row in rows], height, xerr=abs(ends), **style)
    _lines(ax, [row.name for row in rows], TITLES[RANK] if names == [RANK] else PART)
    if len(names) > 1:
        ax.legend(frameon=False, fontsize="small", loc="lower right")


def _lines(ax: Axes, names: Sequence[str], title: str) -> None:
    ax.axvline(0.0, color="black", lw=0.8)
    ax.set_yticks(range(len(names)), names, fontsize="small")
    ax.invert_yaxis()
    ax.set_xlabel(title)


def _effects(ax: Axes, output: OutputRows) -> None:
    """Deviations of elementary effects over their mean sizes; of what has no direction there is no deviation."""
    for n, row in enumerate(_first(output, EFFECT)):
        x, sigma = row.numbers[EFFECT], row.numbers["sigma"]
        straight = sigma == sigma
        across, along = (np.reshape(_whiskers(row, name), (2, 1)) for name in (EFFECT, "sigma"))
        y = sigma if straight else 0.0
        style: canvas.Style = {"ms": 6, "color": COLORS[n % len(COLORS)], "elinewidth": 0.8, "label": row.name}
        ax.errorbar([x], [y], along if straight else None, across, MARKERS[n // len(COLORS)], **style)
    right, top = ax.get_xlim()[1], ax.get_ylim()[1]
    for ratio, line in RATIOS.items():
        ax.plot([0.0, right], [0.0, ratio * right], line, color="0.5", lw=0.8, label=f"sigma = {ratio:g} mu*")
    ax.set(xlim=(0.0, right), ylim=(-0.04 * top, top))
    ax.set(xlabel=named("mu*", output.units), ylabel=named("sigma", output.units))
    ax.legend(frameon=False, fontsize="small", loc="upper left", bbox_to_anchor=(1.0, 1.0))
