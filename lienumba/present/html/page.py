"""The page: sections one below the other, and what they need, in one file that asks nothing of any network.

Its policy lets a browser run nothing but the two scripts that it names by their digests, and load nothing at all.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator
from importlib.resources import files as resources
from pathlib import Path
from string import Template
from typing import TYPE_CHECKING

import xarray as xr

from lienumba import __version__
from lienumba.present.html import plotly_js
from lienumba.present.html.chart import Section
from lienumba.present.html.markup import Markup, element, join

if TYPE_CHECKING:
    from lienumba.engine.simulate import Progress, Tell

ENDINGS = (".html", ".htm")
SCRIPTS = ("theme.js", "tables.js", "charts.js", "sensitivity.js", "motion.js", "viewer.js")
SHADE = 0.3  # of white in the lighter half of a body that spins, or of black in the dark theme
DARK = ("#4aa8e0", "#f08a3c", "#2fc198", "#e29ac6", "#e8ab2e", "#86cdf2", "#e6e7e8")  # of COLORS, on a dark page


def report(
    dataset: str | os.PathLike[str] | xr.Dataset,
    output: str | os.PathLike[str],
    *,
    allow_code: bool = False,
    progress: Callable[[Progress], None] | None = None,
) -> None:
    """Write the report of a dataset: one HTML file that opens anywhere, offline, with the mechanism moving.

    Parameters
    ----------
    dataset : xarray.Dataset or path
        What `lienumba.run` or `lienumba.modes` returned, or its file.
    output : path
        The HTML file, replaced if it exists.
    allow_code : bool
        Run the Python code that the dataset brings, where the courses to be shown are not stored and have to be
        simulated again.
    progress : callable, optional
        Called with a `Progress` while runs are simulated again.

    Raises
    ------
    ScenarioError
        Where the dataset is none of lienumba, or plotly is not installed.
    """
    from lienumba.store.files import reading
    from lienumba.store.linear_layout import MODES
    from lienumba.store.outputs import whole
    from lienumba.store.targets import claimed

    with claimed(output, "page", ENDINGS) as own:
        with reading(dataset, (MODES,)) as (ds, where):
            name = Path(where).name if isinstance(dataset, str | os.PathLike) else "dataset.nc"
            text = page(ds, name, allow_code, progress or (lambda event: None))
        with whole(own) as partial:
            partial.write_text(text, encoding="utf-8")


def page(ds: xr.Dataset, name: str, allow_code: bool, tell: Tell) -> str:
    """The whole page; name: of the file of the dataset, as commands give it; tell: told of runs that go again."""
    from lienumba.present.html.sections import sections_of

    library, viewer = plotly_js.library(), _scripts()
    header, sections, extra = sections_of(ds, name, allow_code, tell)
    data = {"charts": {key: x.data for part in sections for key, x in part.charts.items()}, **extra}
    title = str(ds.attrs.get("title", "")) or name
    return Template(_asset("template.html")).substitute(
        policy="; ".join(_policy(viewer, library)),
        generator=f"lienumba {__version__}",
        title=join([title]),
        style=f":root {{ {_palette()} }}\n{_asset('style.css')}",
        body=join(_body(header, sections)),
        data=plotly_js.packed(json.dumps(data, ensure_ascii=False, allow_nan=False, separators=(",", ":"))),
        library=plotly_js.packed(library),
        viewer=viewer,
    )


def _policy(*scripts: str) -> Iterator[str]:
    yield "default-src 'none'"
    yield f"script-src {' '.join(map(plotly_js.digest, scripts))}"
    yield "style-src 'unsafe-inline'"
    yield "img-src data: blob:"
    yield "base-uri 'none'"
    yield "form-action 'none'"


def _asset(name: str) -> str:
    return (resources("lienumba.present.html") / "assets" / name).read_text(encoding="utf-8")


def _scripts() -> str:
    return "\n".join(map(_asset, SCRIPTS))


def _palette() -> str:
    from lienumba.figures.canvas import COLORS

    pairs = [*zip(COLORS, DARK, strict=True)]
    shades = [(_mixed(light, 255), _mixed(dark, 0)) for light, dark in pairs]
    named = ((f"--{kind}{n}", *pair) for kind, each in (("c", pairs), ("s", shades)) for n, pair in enumerate(each))
    return " ".join(f"{name}: light-dark({light}, {dark});" for name, light, dark in named)


def _mixed(color: str, other: int) -> str:
    """A colour with some white (255) or black (0)."""
    parts = (int(color[n : n + 2], 16) for n in (1, 3, 5))
    return "#" + "".join(f"{round((1.0 - SHADE) * part + SHADE * other):02x}" for part in parts)


def _body(header: Markup, sections: list[Section]) -> Iterator[Markup]:
    links = element("nav", *(element("a", part.title, href=f"#{part.key}") for part in sections), aria_label="Sections")
    yield element("header", header, links)
    yield element("main", *(_section(part) for part in sections))
    yield element("footer", f"Made by lienumba {__version__}. This page is one file and loads nothing from anywhere.")


def _section(part: Section) -> Markup:
    return element("section", element("h2", part.title), part.body, id=part.key)
