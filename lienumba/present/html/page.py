"""The page: sections one below the other, and what they need, in one file. Its policy forbids to load anything."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from importlib.resources import files as resources
from pathlib import Path
from string import Template
from typing import TYPE_CHECKING

import xarray as xr

from lienumba import __version__
from lienumba.errors import ScenarioError
from lienumba.present.html.markup import element, join

if TYPE_CHECKING:
    from lienumba.engine.simulate import Progress, Tell

ENDINGS = (".html", ".htm")
POLICY = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:"


def report(
    dataset: str | os.PathLike[str] | xr.Dataset,
    output: str | os.PathLike[str],
    *,
    allow_code: bool = False,
    check: int = 0,
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
    check : int
        Recompute so many runs by the engine "numba", from start to end, and show how far they differ from the stored
        ones, or why this engine cannot.
    progress : callable, optional
        Called with a `Progress` while runs are simulated again.

    Raises
    ------
    ScenarioError
        Where the dataset is none of lienumba, `check` is no count, or plotly is not installed.
    """
    from lienumba.store.files import reading
    from lienumba.store.linear_layout import MODES
    from lienumba.store.outputs import whole
    from lienumba.store.targets import claimed

    if isinstance(check, bool) or not isinstance(check, int) or check < 0:
        raise ScenarioError.at("check", "must be a number of runs, at least 0", "give one such as 4", check)
    with claimed(output, "page", ENDINGS) as own:
        with reading(dataset, (MODES,)) as (ds, where):
            name = Path(where).name if isinstance(dataset, str | os.PathLike) else "dataset.nc"
            text = page(ds, name, allow_code, progress or (lambda event: None), check)
        with whole(own) as partial:
            partial.write_text(text, encoding="utf-8")


def page(ds: xr.Dataset, name: str, allow_code: bool, tell: Tell, check: int = 0) -> str:
    """The whole page; name: of the file of the dataset, as commands give it; tell: told of runs that go again; check:
    how many runs another engine recomputes."""
    from lienumba.present.html.sections import sections_of

    library = _library()
    header, sections, extra = sections_of(ds, name, allow_code, tell, check)
    data = {"charts": {key: x.data for part in sections for key, x in part.charts.items()}, **extra}
    links = element("nav", *(element("a", part.title, href=f"#{part.key}") for part in sections))
    parts = (element("section", element("h2", part.title), part.body, id=part.key) for part in sections)
    made = element("footer", f"Made by lienumba {__version__}. This page is one file and loads nothing from anywhere.")
    return Template(_asset("template.html")).substitute(
        policy=POLICY,
        generator=f"lienumba {__version__}",
        title=join([str(ds.attrs.get("title", "")) or name]),
        body=join([element("header", header, links), element("main", *parts), made]),
        data=_json(data),
        library=library,
        motion=_asset("motion.js"),
    )


def _json(data: object) -> str:
    """JSON in which no text can end a script."""
    text = json.dumps(data, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c")


def _library() -> str:
    """The text of plotly.js."""
    try:
        from plotly.offline import get_plotlyjs
    except ImportError:
        raise ScenarioError(
            'a report needs plotly, which is missing; in the clone of lienumba, pip install ".[report]"'
        ) from None
    text: str = get_plotlyjs()
    return text


def _asset(name: str) -> str:
    return (resources("lienumba.present.html") / "assets" / name).read_text(encoding="utf-8")
