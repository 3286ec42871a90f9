"""Charts as plotly.js draws them: traces and layouts of plain numbers and texts."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from html import escape
from typing import Any

import numpy as np

from lienumba.figures.canvas import COLORS
from lienumba.present.html.markup import Markup, element, folded, join

Json = dict[str, Any]  # what plotly.js and the scripts of the page read
INK, QUIET, LINE = "#1d2125", "#5c646c", "#e3e4e0"
DASHES = ("solid", "dash", "dot", "dashdot")
MOST_POWERS = 6  # of ten, on an axis
FEW_POWERS = 2  # over which one reads values between them too
KINDS = {"f8": "<f8", "f4": "<f4", "i2": "<i2", "u2": "<u2", "u4": "<u4"}


AXIS: Json = {
    "gridcolor": LINE,
    "linecolor": LINE,
    "zerolinecolor": LINE,
    "automargin": True,
    "exponentformat": "power",
}
LAYOUT: Json = {
    "font": {"family": "system-ui, sans-serif", "size": 12, "color": INK},
    "margin": {"l": 12, "r": 14, "t": 10, "b": 8},
    "hovermode": "x unified",
    "showlegend": False,
    "legend": {"orientation": "h", "x": 0, "y": 1, "yanchor": "bottom"},
    "height": 260,
}


@dataclass(frozen=True)
class Chart:
    """One diagram: its title, what it draws, and how; the unit of its values, and a remark; drawn: what its lines and
    areas are, as far as it does not say so itself."""

    title: str
    traces: list[Json]
    layout: Json
    unit: str = ""
    note: str = ""
    drawn: tuple[str, ...] = ()

    @property
    def data(self) -> Json:
        axes = {key: {**AXIS, **self.layout.get(key, {})} for key in ("xaxis", "yaxis")}
        return {"traces": self.traces, "layout": {**LAYOUT, **self.layout, **axes}}


@dataclass(frozen=True)
class Section:
    """A part of the page under a heading. key: its anchor; charts: those of its places, by the names of these."""

    key: str
    title: str
    body: Markup
    charts: dict[str, Chart] = field(default_factory=dict)


def section(
    key: str, title: str, *before: str, charts: Sequence[Chart] = (), more: Sequence[Chart] = (), small: bool = False
) -> Section:
    """A section whose charts stand side by side behind what comes before; more: those that are folded away; small:
    three to a row instead of two."""
    named = {f"{key}-{n}": chart for n, chart in enumerate([*charts, *more])}
    places = [_place(*x) for x in named.items()]
    kind = "panels small" if small else "panels"
    grid = [element("div", *places[: len(charts)], class_=kind)] if charts else []
    hidden = [folded(f"{len(more)} more", element("div", *places[len(charts) :], class_=kind))] if more else []
    return Section(key, title, join([*before, *grid, *hidden]), named)


def _place(name: str, chart: Chart) -> Markup:
    unit = [" ", element("small", f"({chart.unit})")] if chart.unit else []
    note = [element("br"), element("small", chart.note)] if chart.note else []
    caption = element("figcaption", chart.title, *unit, *note)
    height = f"height: {chart.layout.get('height', LAYOUT['height'])}px"
    return element("figure", caption, element("div", class_="plot", style=height, data_chart=name))


def color(n: int, share: float = 1.0) -> str:
    """The colour of the n-th line, or a share of it."""
    return shaded(COLORS[n % len(COLORS)], share)


def shaded(color: str, share: float) -> str:
    """A share of a colour; the rest is what lies behind."""
    red, green, blue = (int(color[n : n + 2], 16) for n in (1, 3, 5))
    return color if share == 1.0 else f"rgba({red}, {green}, {blue}, {share:g})"


def dash(n: int) -> str:
    """Lines of the same colour differ in their dashes."""
    return DASHES[n // len(COLORS) % len(DASHES)]


def packed(values: np.ndarray, kind: str = "f8") -> dict[str, str]:
    """Numbers as plotly.js reads them; NaN and infinity are such numbers too."""
    shape = {"shape": ", ".join(map(str, values.shape))} if values.ndim > 1 else {}
    return {"dtype": kind, "bdata": b64encode(np.ascontiguousarray(values, KINDS[kind]).tobytes()).decode(), **shape}


def plain(text: str) -> str:
    """A text in which plotly.js sees neither markup nor variables."""
    return escape(text, quote=False).replace("%{", "%&#123;")


def axis(title: str, **own: object) -> Json:
    return {"title": {"text": plain(title)}, **own}


def line(x: np.ndarray, y: np.ndarray, name: str, shade: str, **own: object) -> Json:
    """A line through points; NaN is a gap. own: of the trace; `width`, `dash` of its line."""
    width, dashes = own.pop("width", 1.8), own.pop("dash", "solid")
    style = {"color": shade, "width": width, "dash": dashes}
    drawn = {"type": "scatter", "mode": "lines", "x": packed(x), "y": packed(y), "line": style}
    return {**drawn, "name": plain(name), **own}


def band(x: np.ndarray, low: np.ndarray, high: np.ndarray, shade: str, **own: object) -> list[Json]:
    """The area between two lines; it tells nothing when pointed at."""
    edges: Json = {"hoverinfo": "skip", "showlegend": False, "width": 0, **own}
    return [line(x, low, "", shade, **edges), line(x, high, "", shade, fill="tonexty", fillcolor=shade, **edges)]


def logarithmic(values: Iterable[np.ndarray]) -> Json:
    """A logarithmic axis over whole powers of ten, which hold the positive ones of these; over few of them 2 and 5 of
    each are told too."""
    every = np.concatenate([x[np.isfinite(x) & (x > 0.0)] for x in values] or [np.ones(1)])
    low, high = (np.log10(every.min()), np.log10(every.max())) if len(every) else (0.0, 0.0)
    ends = [float(np.floor(low - 1e-9)), float(np.ceil(high + 1e-9))]
    powers = ends[1] - ends[0]
    return {
        "type": "log",
        "range": ends,
        "dtick": "D2" if powers <= FEW_POWERS else float(np.ceil(powers / MOST_POWERS)),
    }
