"""Whether requirements are met, before all else; and which inputs set apart the runs that fail one."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import xarray as xr

from lienumba.analysis.labels import unit_label
from lienumba.analysis.panels.quantiles import Histogram, bins
from lienumba.analysis.requirements import separation as apart
from lienumba.analysis.requirements.verdict import legend, notes, table, verdicts_of, worst
from lienumba.present.html import chart
from lienumba.present.html.chart import Chart, Json, Section, section
from lienumba.present.html.markup import Markup, element, join, sentence, text_table
from lienumba.words import plural

MOST_INPUTS = 8  # rows of a table
DRAWN = 3  # inputs of each requirement


def headline(ds: xr.Dataset) -> list[Markup]:
    """How many requirements are met, in a line; none of a dataset without any."""
    found = verdicts_of(ds)
    if not found:
        return []
    met, told = sum(x.met for x in found), f"{plural(len(found), 'requirement', 'requirements')}"
    rest = ", ".join(f"{x.requirement}: {x.verdict}" for x in found if not x.met)
    strong = element("strong", f"{met} of {told} met" if rest else f"{'All ' if met > 1 else ''}{told} met")
    return [element("p", strong, f"; {rest}." if rest else ".", class_="verdict failed" if rest else "verdict")]


def sections(ds: xr.Dataset) -> Iterator[Section]:
    """The verdicts; of each requirement that some runs fail, what sets these apart."""
    found = verdicts_of(ds)
    if not found:
        return
    parts = [text_table(table(ds, found))]
    parts += [element("p", sentence(text)) for text in (*(x.sentence() for x in found), *worst(ds, found), *notes(ds))]
    parts += [element("p", sentence(legend(found)), class_="quiet")]
    yield section("verdict", "Is it good enough?", *parts)
    for n, name in enumerate(apart.separable(ds)):
        yield _apart(ds, name, n)


def _apart(ds: xr.Dataset, name: str, n: int) -> Section:
    found = apart.separation(ds, name)
    rows, remark = apart.table(found, MOST_INPUTS)
    clear = [str(x) for x, p in zip(found["input"].values, found["p_value"].values, strict=True) if p < apart.CLEAR]
    charts = [_both(ds, name, x) for x in clear[:DRAWN]]
    said = join([element("p", sentence(text), class_="quiet") for text in (remark, apart.LEGEND) if text])
    return section(f"apart{n}", f"What fails “{name}”", text_table(rows), said, charts=charts, small=True)


def _both(ds: xr.Dataset, name: str, path: str) -> Chart:
    """An input of the runs that meet a requirement, and of those that fail it, each as parts of its runs."""
    groups = apart.samples(ds, name, path)
    edges = bins([Histogram("", np.concatenate(groups), 0, None)])
    traces: list[Json] = [
        {
            "type": "bar", "name": label, "x": chart.packed(0.5 * edges[1:] + 0.5 * edges[:-1]),
            "y": chart.packed(np.histogram(values, edges)[0] / len(values)), "width": chart.packed(np.diff(edges)),
            "marker": {"color": chart.color(shade, 0.6), "line": {"width": 0}},
            "hovertemplate": "%{y:.2%} of those that " + label + "<extra></extra>",
        }
        for label, values, shade in zip(("meet it", "fail it"), groups, (0, 1), strict=True)
    ]  # fmt: skip
    layout = {
        "yaxis": chart.axis("part of these runs", rangemode="tozero"), "bargap": 0, "barmode": "overlay", "height": 230,
        "hovermode": "x", "showlegend": True,
    }  # fmt: skip
    return Chart(path, traces, layout, unit_label(str(ds[path].attrs.get("units", ""))))
