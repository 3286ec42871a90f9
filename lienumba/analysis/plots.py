"""Figures of a dataset: of runs, how their variables spread over the time; of a study, see `study_plots`.

matplotlib is drawn on without its global state and without a display.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product
from math import ceil
from pathlib import Path
from typing import TYPE_CHECKING

from lienumba.analysis.summary import FINAL, QUANTILES, of_sweep
from lienumba.batch.records import SUMMARIES
from lienumba.batch.statuses import GOOD
from lienumba.errors import ScenarioError
from lienumba.scenario.words import plural, show, suggestion
from lienumba.store.layout import FULL, RUN, VARIABLES
from lienumba.store.study_layout import is_study

if TYPE_CHECKING:
    import numpy as np
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FORMATS = (".png", ".svg", ".pdf")
MOST_ITEMS = 3  # bodies or joints that get panels of their own
MOST_LINES = 12  # in one panel
COLUMNS = 3
WIDTH, HEIGHT = 5.0, 3.2  # of a panel, inches
CHECKS = ("energy_residual", "position_violation", "velocity_violation")
LOGARITHMIC = ("position_violation", "velocity_violation")
STYLES = ("-", "--")
COLORS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000")  # Okabe and Ito: for all eyes


def save(ds: xr.Dataset, target: Path, names: Sequence[str] = ()) -> None:
    """Write the figure of a dataset as PNG, SVG or PDF."""
    if target.suffix.lower() not in FORMATS:
        raise ScenarioError(f"output = {target}: is no figure; give a name that ends in .png, .svg or .pdf")
    if not target.parent.is_dir():
        raise ScenarioError(
            f"output = {target}: its folder {target.parent} does not exist; create it or choose another"
        )
    drawn = figure(ds, names)
    try:
        drawn.savefig(target)
    except OSError as error:
        raise ScenarioError(f"output = {target}: cannot be written ({error.strerror}); choose another") from None


def figure(ds: xr.Dataset, names: Sequence[str] = ()) -> Figure:
    """The figure of these variables of a dataset, or of those that say most."""
    for name in names:
        if name not in ds.variables or not set(ds[name].dims) - {name}:
            known = [str(x) for x in (*ds.data_vars, *ds.coords) if str(x) not in ds.dims]
            raise ScenarioError(f"the dataset has no variable {show(name)}; {suggestion(name, known)}")
    if is_study(ds):
        from lienumba.analysis.study_plots import study_figure

        return study_figure(ds, names)
    return _run_figure(ds, names)


def blank(rows: int, columns: int, height: float = HEIGHT) -> tuple[Figure, list[list[Axes]]]:
    """A figure with so many panels of this height (inches)."""
    try:
        from matplotlib.figure import Figure
    except ImportError:
        raise ScenarioError('a figure needs matplotlib, which is missing; pip install "lienumba[plot]"') from None

    drawn = Figure(figsize=(WIDTH * columns, height * rows), layout="constrained", dpi=150)
    return drawn, [list(row) for row in drawn.subplots(rows, columns, squeeze=False)]


def axis_label(name: str, units: str) -> str:
    """What an axis shows, with its unit as people write it."""
    return name.replace("_", " ") + (
        "" if units in ("1", "") else f" ({units.replace(' s-1', '/s').replace(' ', '·')})"
    )


def _run_figure(ds: xr.Dataset, names: Sequence[str]) -> Figure:
    good = _good(ds)
    if not good.sizes["run"]:
        raise ScenarioError("no run of the dataset succeeded, so there is nothing to draw; lienumba info says why")
    panels = [panel for name in names or _telling(ds) for panel in _panels(good[name])]
    columns = min(COLUMNS, len(panels))
    rows = ceil(len(panels) / columns)
    drawn, axes = blank(rows, columns)
    flat = [ax for row in axes for ax in row]
    for ax, (title, variable) in zip(flat, panels, strict=False):
        (_fan if "time" in variable.dims else _histogram)(ax, variable)
        ax.set_title(title, fontsize="medium")
    for ax in flat[len(panels) :]:
        ax.set_visible(False)
    runs, failed = good.sizes["run"], int((~ds["status"].isin(GOOD)).sum())
    spread = f"median and 5 to 95 % of {runs:,} runs" if runs > 1 else "1 run"
    title = f"{ds.attrs['title']}: " if ds.attrs.get("title") else ""
    drawn.suptitle(f"{title}{spread}" + (f", {failed:,} failed" if failed else ""))
    return drawn


def _good(ds: xr.Dataset) -> xr.Dataset:
    """The runs that succeeded, without the nominal one if there are others."""
    good = ds["status"].isin(GOOD).values
    spread = good & of_sweep(ds)
    found = ds.isel(run=(spread if spread.any() else good).nonzero()[0])
    return found.isel({FULL: found[FULL].isin(found["run"]).values.nonzero()[0]}) if FULL in ds.dims else found


def _over_runs(values: np.ndarray) -> np.ndarray:
    """Quantiles and the largest (4, times) of values (runs, times), over the runs that an event has not ended."""
    import numpy as np

    here = np.isfinite(values).any(axis=0)
    found = np.full((len(QUANTILES) + 1, len(here)), np.nan)
    found[:, here] = [*np.nanquantile(values[:, here], QUANTILES, axis=0), np.nanmax(values[:, here], axis=0)]
    return found


def _telling(ds: xr.Dataset) -> list[str]:
    """The scenario's own variables, the state, and what says how good it is; summaries where there is no course."""
    own = [str(name) for name in ds.data_vars if name not in VARIABLES and ds[name].dims[:1] == RUN]
    courses = [name for name in own if "time" in ds[name].dims]
    found = courses + [name for name in (*FINAL, *CHECKS) if name in ds and ds[name].dims[:1] == RUN]
    return found or [*own, *(name for name in SUMMARIES if name in ds)]


def _panels(variable: xr.DataArray) -> Iterator[tuple[str, xr.DataArray]]:
    """A panel for each of the first bodies or joints."""
    name = str(variable.name)
    if FULL in variable.dims:
        variable = variable.rename({FULL: "run"})
        name += f" ({plural(variable.sizes['run'], 'run', 'runs')})"
    each = next((dim for dim in ("body", "joint") if dim in variable.dims), None)
    if each is None:
        lines = len(_labels(variable))
        yield name + (f", the first {MOST_LINES} of {lines}" if lines > MOST_LINES else ""), variable
        return
    items = [str(item) for item in variable[each].values]
    shown = items if len(items) <= MOST_ITEMS else items[-1:]
    for item in shown:
        which = f", the last of {len(items)} {'bodies' if each == 'body' else 'joints'}" if shown != items else ""
        yield f"{name} of {item}{which}", variable.sel({each: item})


def _fan(ax: Axes, variable: xr.DataArray) -> None:
    """Lines over the time, with a band between quantiles over the runs; of violations the largest, too."""
    import numpy as np

    time, logarithmic = variable["time"].values, variable.name in LOGARITHMIC
    for n, (label, values) in enumerate(_lines(variable)):
        color, dashes = COLORS[n % len(COLORS)], STYLES[n // len(COLORS) % len(STYLES)]
        low, median, high, largest = _over_runs(values)
        if logarithmic:
            low, median, high = (np.where(x > 0.0, x, np.nan) for x in (low, median, largest))
            ax.plot(time, high, color=color, lw=0.8, ls=":", label="largest of all runs" if len(values) > 1 else None)
        elif len(values) > 1:
            ax.fill_between(time, low, high, color=color, alpha=0.25, lw=0)
        ax.plot(time, median, color=color, ls=dashes, lw=1.2, label=label or ("median" if logarithmic else None))
    if logarithmic and _has_values(ax):
        ax.set_yscale("log")
    _finish(ax, "time (s)", axis_label(str(variable.name), variable.attrs.get("units", "")))


def _has_values(ax: Axes) -> bool:
    import numpy as np

    return any(np.isfinite(np.asarray(line.get_ydata(), float)).any() for line in ax.lines)


def _lines(variable: xr.DataArray) -> list[tuple[str, np.ndarray]]:
    """The label and the values (runs, times) of each number of a panel."""
    whole = variable.transpose("run", "time", ...).values.reshape(*(variable.sizes[x] for x in ("run", "time")), -1)
    return [(label, whole[..., n]) for n, label in enumerate(_labels(variable)[:MOST_LINES])]


def _labels(variable: xr.DataArray) -> list[str]:
    """What each number of a panel is called."""
    dims = [dim for dim in variable.dims if dim not in ("run", "time")]
    return ["".join(map(str, entry)) for entry in product(*(variable[dim].values for dim in dims))]


def _histogram(ax: Axes, variable: xr.DataArray) -> None:
    """How numbers that each run has once are spread."""
    import numpy as np

    columns = variable.transpose("run", ...).values.reshape(variable.sizes["run"], -1).T
    for n, (label, column) in enumerate(zip(_labels(variable), columns[:MOST_LINES], strict=False)):
        ax.hist(column[np.isfinite(column)], bins="auto", color=COLORS[n % len(COLORS)], alpha=0.7, label=label or None)
    _finish(ax, axis_label(str(variable.name), variable.attrs.get("units", "")), "runs")


def _finish(ax: Axes, x: str, y: str) -> None:
    ax.set_xlabel(x)
    ax.set_ylabel(y)
    ax.grid(True, lw=0.4, alpha=0.5)
    if ax.get_legend_handles_labels()[0]:
        ax.legend(fontsize="small", ncols=1 + (len(ax.lines) > 6))
