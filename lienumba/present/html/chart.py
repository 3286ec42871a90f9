"""Charts as plotly.js draws them: traces and layouts of plain numbers and texts, without any data of plotly's own.

Colours are names of custom properties of the page (`assets/theme.js`), so that charts follow its theme.
"""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from html import escape
from typing import Any

import numpy as np

from lienumba.present.html.markup import Markup, element, folded, join

Json = dict[str, Any]  # what plotly.js and the scripts of the page read
COLORS = 7  # of the palette, --c0 to --c6
DASHES = ("solid", "dash", "dot", "dashdot")
MOST_POWERS = 6  # of ten, on an axis
FEW_POWERS = 2  # over which one reads values between them too
KINDS = {"f8": "<f8", "f4": "<f4", "i2": "<i2", "u2": "<u2", "u4": "<u4"}


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
        return {"traces": self.traces, "layout": self.layout}


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
    unit = [" ", element("small", chart.unit)] if chart.unit else []
    note = [element("br"), element("small", chart.note)] if chart.note else []
    caption = element("figcaption", chart.title, *unit, *note)
    return element("figure", caption, element("div", class_="plot", data_chart=name))


def color(n: int, share: str = "") -> str:
    """The colour of the n-th line, or a share of it."""
    return f"--c{n % COLORS} {share}".strip()


def dash(n: int) -> str:
    """Lines of the same colour differ in their dashes."""
    return DASHES[n // COLORS % len(DASHES)]


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
