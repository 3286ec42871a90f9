"""Courses over the time: quantile bands with the median, the nominal run, and the run that departs farthest."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from lienumba.analysis import fans
from lienumba.analysis.fans import LEVELS, Course
from lienumba.analysis.labels import unit_label
from lienumba.analysis.telling import Panel, telling
from lienumba.report import chart
from lienumba.report.chart import Chart, Section, section
from lienumba.report.markup import Markup, element

if TYPE_CHECKING:
    import numpy as np
    import xarray as xr

MOST_TIMES = 400  # of a line: more than the pixels of its chart
DRIFT = ("energy", "kinetic_energy", "potential_energy", "work", "energy_residual")
VIOLATIONS = ("position_violation", "velocity_violation")
DASHES = ("dash", "dot")
STYLES = ("dashed", "dotted")  # the same, on the page


@dataclass(frozen=True)
class Marked:
    """A run that is shown beside the quantiles, and what it is called."""

    run: int
    name: str


def sections(ds: xr.Dataset, marked: Sequence[Marked]) -> Iterator[Section]:
    """How the courses spread; and energies and violations, which say how well they are computed."""
    choice = telling(ds)
    panels = [panel for panel in choice.panels if panel.course]
    checks = [panel for panel in panels if panel.name in (*DRIFT, *VIOLATIONS)]
    others = [panel for panel in panels if panel not in checks]
    if others:
        left_out = [element("p", f"{choice.left_out[0].upper()}{choice.left_out[1:]}.", class_="quiet")]
        charts = [course_chart(ds, panel, marked) for panel in others]
        yield section("courses", "Over the time", *_key(ds, marked), *(left_out if choice.left_out else []), charts=charts)
    if checks:
        charts = [course_chart(ds, panel, ()) for panel in checks]
        text = "But for errors of the method, the energy residual and the violations would be 0."
        yield section("checks", "Energy and drift", element("p", text, class_="quiet"), charts=charts)


def _key(ds: xr.Dataset, marked: Sequence[Marked]) -> list[Markup]:
    """What the lines and areas are."""
    if ds.sizes["run"] == 1:
        return []
    entries = [
        ("band", "background: color-mix(in srgb, var(--c0) 18%, transparent)", "5 to 95 % of the runs"),
        ("band", "background: color-mix(in srgb, var(--c0) 40%, transparent)", "25 to 75 %"),
        ("", "border-color: var(--c0)", "median"),
        *(("", f"border-top: 2px {style} var(--ink)", x.name) for style, x in zip(STYLES, marked, strict=False)),
    ]
    rows = (element("li", element("i", class_=kind, style=style), text) for kind, style, text in entries)
    return [element("ul", *rows, class_="key")]


def course_chart(ds: xr.Dataset, panel: Panel, marked: Sequence[Marked]) -> Chart:
    """The chart of a panel."""
    found, times = fans.courses(ds, panel), ds["time"].values
    kept, unit = _kept(len(times)), _unit(ds, panel)
    traces: list[dict[str, Any]] = []
    for n, course in enumerate(found):
        traces += _lines(course, n, times[kept], kept, unit, panel.logarithmic)
    if len(next(iter(found)).each) > 1 and not panel.angles:
        for style, one in zip(DASHES, marked, strict=False):
            traces += _one(ds, panel, one, style, times[kept], kept, unit)
    layout = {
        "xaxis": chart.axis("time (s)", hoverformat=".5~g"),
        "yaxis": {"type": "log"} if panel.logarithmic else {},
        "showlegend": len(found) > 1,
        "height": 280 if len(found) > 1 else 250,
    }
    return Chart(panel.title, unit + (f" from {fans.reference(ds, panel)}" if panel.angles else ""), traces, layout)


def _unit(ds: xr.Dataset, panel: Panel) -> str:
    return "°" if panel.angles else unit_label(str(ds[panel.name].attrs.get("units", "")))


def _kept(times: int) -> np.ndarray:
    """The indices of evenly spread times, the first and the last among them."""
    import numpy as np

    return np.unique(np.linspace(0, times - 1, MOST_TIMES).round().astype(int))


def _lines(
    course: Course, n: int, x: np.ndarray, kept: np.ndarray, unit: str, logarithmic: bool
) -> Iterator[dict[str, Any]]:
    """Bands and median of one line; of what is logarithmic the median and the largest."""
    import numpy as np

    group, spread = {"legendgroup": str(n)}, len(course.each) > 1
    low, lower, median, upper, high = (_drawable(q[kept], logarithmic) for q in course.quantiles)
    both = spread and not logarithmic
    if both:
        yield from chart.band(x, low, high, chart.color(n, "18%"), **group)
        yield from chart.band(x, lower, upper, chart.color(n, "26%"), **group)
    elif spread:
        largest = _drawable(course.largest[kept], logarithmic)
        style = {"dash": "dot", "width": 1.2, "showlegend": False, **group}
        yield chart.line(x, largest, f"{course.label}, largest", chart.color(n), hovertemplate=_hover(unit), **style)
    between = "(%{customdata[0]:.4~g} to %{customdata[1]:.4~g}) " if both else ""
    ends = {"customdata": chart.packed(np.stack([low, high], axis=1))} if both else {}
    name = course.label or ("median" if spread else "")
    hover = _hover(f"{between}{unit}")
    yield chart.line(x, median, name, chart.color(n), dash=chart.dash(n), hovertemplate=hover, **ends, **group)


def _one(
    ds: xr.Dataset, panel: Panel, marked: Marked, style: str, x: np.ndarray, kept: np.ndarray, unit: str
) -> Iterator[dict[str, Any]]:
    """The lines of one run."""
    if marked.run not in ds[panel.dim].values:
        return
    alone = ds.sel({dim: [marked.run] for dim in {"run", panel.dim}})
    for n, course in enumerate(fans.courses(alone, panel)):
        y = _drawable(course.quantiles[0][kept], panel.logarithmic)
        own = {"showlegend": False, "legendgroup": str(n), "dash": style, "width": 1.3, "hovertemplate": _hover(unit)}
        yield chart.line(x, y, f"{course.label} {marked.name}".strip(), "--ink", **own)


def _hover(unit: str) -> str:
    return f"%{{y:.4~g}} {unit.replace('<', '&lt;')}"


def _drawable(values: np.ndarray, logarithmic: bool) -> np.ndarray:
    """Nothing where a logarithm has no value."""
    import numpy as np

    return np.where(values > 0.0, values, np.nan) if logarithmic else values
