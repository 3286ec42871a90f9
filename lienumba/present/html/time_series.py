"""Time series: quantile bands with the median, the nominal run, and the run that departs farthest."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr

from lienumba.analysis.panels import quantiles, run_windows
from lienumba.analysis.panels.quantiles import TimeSeries
from lienumba.analysis.panels.select_panels import Panel, default_panels, good_runs, named_panels
from lienumba.figures.panels import DECADES
from lienumba.present.html import chart
from lienumba.present.html.chart import Chart, Json, Section, section
from lienumba.present.html.markup import Markup, element
from lienumba.store.layout import FULL, VARIABLES

MOST_TIMES = 400  # of a line: more than the pixels of its chart
CHECKS = (
    "energy", "kinetic_energy", "potential_energy", "work", "energy_residual",
    "position_violation", "velocity_violation",
)  # fmt: skip
OTHERS = ("position", "rotation", "angular_velocity", "velocity", "driver_effort", "joint_force", "joint_torque")
DASHES = ("dash", "dot")
UNIT = re.compile(r"\(([^()]*)\)$")
STYLES = ("dashed", "dotted")  # the same, on the page

KEY = {
    "5 to 95 % of the runs": ("band", f"background: {chart.color(0, 0.18)}"),
    "25 to 75 %": ("band", f"background: {chart.color(0, 0.4)}"),
    "median": ("", f"border-color: {chart.color(0)}"),
    "each run": ("", f"border-color: {chart.color(0, 0.6)}"),
}
BANDS, EACH = ("5 to 95 % of the runs", "25 to 75 %", "median"), ("each run",)
PEAKS = "dotted: largest of all runs; solid: median"


@dataclass(frozen=True)
class MarkedRun:
    """A run that is shown beside the quantiles, and what it is called."""

    run: int
    name: str


def sections(ds: xr.Dataset, marked: Sequence[MarkedRun]) -> Iterator[Section]:
    """How the runs spread over the time; and energies and violations, which say how well they are computed."""
    if not good_runs(ds).any():
        return
    panels = [panel for panel in default_panels(ds).panels if panel.over_time]
    checks = [panel for panel in panels if panel.name in CHECKS]
    first = [panel for panel in panels if panel not in checks]
    if first:
        charts = [series_chart(ds, panel, marked) for panel in first]
        more = [series_chart(ds, panel, marked) for panel in _others(ds, panels)]
        yield section("courses", "Over the time", *_key([*charts, *more], marked), charts=charts, more=more)
    if checks:
        charts = [series_chart(ds, panel, ()) for panel in checks]
        text = "But for errors of the method, the energy residual and the violations would be 0."
        yield section("checks", "Energy and drift", element("p", text, class_="quiet"), *_key(charts), charts=charts)


def _others(ds: xr.Dataset, shown: Sequence[Panel]) -> list[Panel]:
    """The panels of other bodies, and of reactions."""
    timed = [str(name) for name, x in ds.data_vars.items() if "time" in x.dims and x.dtype.kind == "f"]
    names = [name for name in timed if name not in (*CHECKS, "multiplier") and name not in VARIABLES]
    names += [name for name in OTHERS if name in timed]
    return [panel for panel in named_panels(ds, names).panels if panel not in shown] if names else []


def _key(charts: Sequence[Chart], marked: Sequence[MarkedRun] = ()) -> list[Markup]:
    """What the lines and areas of these charts are."""
    drawn = {name for one in charts for name in one.drawn}
    lines = {x.name: ("", f"border-top: 2px {style} {chart.INK}") for style, x in zip(STYLES, marked, strict=False)}
    rows = (
        element("li", element("i", class_=kind, style=style), name)
        for name, (kind, style) in {**KEY, **lines}.items()
        if name in drawn
    )
    return [element("ul", *rows, class_="key")] if drawn else []


def series_chart(ds: xr.Dataset, panel: Panel, marked: Sequence[MarkedRun]) -> Chart:
    """The chart of a panel, over the times that runs have reached."""
    ds = run_windows.reached(ds)
    found, unit = quantiles.time_series(ds, panel), _unit(panel)
    kept = _kept(len(found.times))
    pen = Pen(found.times[kept], kept, unit, panel.logarithmic)
    traces: list[Json] = []
    for n, line in enumerate(found.lines):
        traces += pen.each(line.each, line.label, n) if found.few else pen.bands(line, n, found.enough)
    drawn = [*EACH[: found.runs - 1]] if found.few else [*BANDS] if not panel.logarithmic else []
    for style, one in zip(DASHES, () if panel.angles else marked, strict=False):
        lines = list(_one(ds, panel, one, style, pen))
        traces += lines
        drawn += [one.name] if lines else []
    note = [f"angles of its axes from {run_windows.reference(ds, panel)}"] if panel.angles else []
    note += _peaks(ds, panel, found) if panel.logarithmic else []
    note += [] if found.few else filter(None, [quantiles.ended_early([found])])
    note += _runs(ds, panel, found.runs)
    layout = {
        "xaxis": chart.axis("time (s)", hoverformat=".5~g"),
        "yaxis": _decades(found.lines) if panel.logarithmic else {},
        "showlegend": len(found.lines) > 1,
        "height": 280 if len(found.lines) > 1 else 250,
    }
    return Chart(panel.title, traces, layout, unit, "; ".join(note), tuple(drawn))


def _decades(lines: Sequence[TimeSeries]) -> Json:
    """A logarithmic axis of the few powers of ten below the largest value, in which figures show them too."""
    every = np.concatenate([x for line in lines for x in (line.quantiles[2], line.largest)])
    positive = every[every > 0.0]
    return chart.logarithmic([positive[positive >= positive.max(initial=0.0) * 10.0**-DECADES]])


def _unit(panel: Panel) -> str:
    """That of its values, as its label has it."""
    found = UNIT.search(panel.label)
    return "°" if panel.angles else found[1] if found else ""


def _kept(times: int) -> np.ndarray:
    """The indices of evenly spread times, the first and the last among them."""
    return np.unique(np.linspace(0, times - 1, MOST_TIMES).round().astype(int))


def _peaks(ds: xr.Dataset, panel: Panel, found: quantiles.PanelSeries) -> list[str]:
    """What the lines of a logarithmic panel are, and how many times each of their points stands for."""
    several = quantiles.label(ds, panel).partition("\n")[2]
    return [x for x in (several, "" if found.few else PEAKS) if x]


def _runs(ds: xr.Dataset, panel: Panel, runs: int) -> list[str]:
    """What is to be said of the runs that are shown."""
    every = int(good_runs(ds).sum())
    if runs == every:
        return []
    if panel.dim == FULL:
        return [f"{runs:,} of {every:,} runs, whose courses are stored"]
    return [f"{runs:,} of {every:,} runs, in blocks evenly over the sweep"]


@dataclass(frozen=True)
class Pen:
    """Draws time series at these times x (s), of which the indices are kept, in this unit."""

    x: np.ndarray
    kept: np.ndarray
    unit: str
    logarithmic: bool

    def bands(self, series: TimeSeries, n: int, enough: np.ndarray) -> Iterator[Json]:
        """Bands and median of one line while there are runs enough, then the runs that are left; of what is logarithmic
        median and largest."""
        group: Json = {"legendgroup": str(n)}
        shade, many = chart.color(n), np.flatnonzero(enough[self.kept])
        low, lower, median, upper, high = (self.shown(x)[many] for x in series.quantiles)
        if self.logarithmic:
            largest = {"dash": "dot", "width": 1.3, "showlegend": False, **group}
            yield self.line(series.largest, f"{series.label}, largest of all runs", shade, **largest)
            yield self.line(np.where(enough, series.quantiles[2], np.nan), series.label or "median", shade, **group)
            return
        yield from chart.band(self.x[many], low, high, chart.color(n, 0.18), **group)
        yield from chart.band(self.x[many], lower, upper, chart.color(n, 0.26), **group)
        ends = {"customdata": chart.packed(np.stack([low, high], axis=1)), "dash": chart.dash(n), **group}
        text = f"%{{y:.4~g}} (%{{customdata[0]:.4~g}} to %{{customdata[1]:.4~g}}) {chart.plain(self.unit)}"
        yield chart.line(self.x[many], median, series.label or "median", shade, hovertemplate=text, **ends)
        yield from self.each(series.left, series.label, n, named=False)

    def each(self, runs: Mapping[int, np.ndarray], label: str, n: int, named: bool = True) -> Iterator[Json]:
        """The time series of few runs, by label; named: whether the legend has them."""
        for k, (run, values) in enumerate(runs.items()):
            own: Json = {
                "legendgroup": str(n),
                "dash": chart.dash(n),
                "showlegend": named and k == 0,
                "opacity": 1.0 if named and len(runs) == 1 else 0.6,
            }
            who = label if named and len(runs) == 1 else f"{label} run {run}".strip()
            yield self.line(values, label, chart.color(n), who, **own)

    def line(self, values: np.ndarray, name: str, shade: str, who: str = "", **own: object) -> Json:
        """The time series (times,) of one run; who: what it is called where it is pointed at, if not by its name."""
        text = f"%{{y:.4~g}} {chart.plain(self.unit)}" + (f"<extra>{chart.plain(who)}</extra>" if who else "")
        return chart.line(self.x, self.shown(values), name, shade, hovertemplate=text, **own)

    def shown(self, values: np.ndarray) -> np.ndarray:
        """Those that are kept; nothing where a logarithm has no value."""
        here = values[self.kept]
        return np.where(here > 0.0, here, np.nan) if self.logarithmic else here


def _one(ds: xr.Dataset, panel: Panel, marked: MarkedRun, style: str, pen: Pen) -> Iterator[Json]:
    """The lines of one run."""
    if marked.run not in ds[panel.dim].values:
        return
    alone = ds.sel({dim: [marked.run] for dim in {"run", panel.dim}})
    for n, series in enumerate(quantiles.time_series(alone, panel).lines):
        for values in series.each.values():  # none if it failed
            own: Json = {"showlegend": False, "legendgroup": str(n), "dash": style, "width": 1.3}
            yield pen.line(values, f"{series.label} {marked.name}".strip(), chart.INK, **own)
