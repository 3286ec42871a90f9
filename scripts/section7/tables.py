"""The tables of docs/paper.md."""

import re
from collections.abc import Callable

import numpy as np

from document import ROUNDING, bound, markdown, text
from section7 import measures, numbers
from section7.numbers import Row
from section7.runs import ROOT, error, simulated

DOCUMENT = ROOT / "docs" / "paper.md"
FORMS = {
    "not projected": ("none", "none"),
    "positions alone": ("local", "none"),
    "velocities alone, W = M": ("none", "mass"),
    "both, W = I": ("local", "identity"),
    "both, W = M": ("local", "mass"),
    "embedded, W = I": ("embedded", "identity"),
    "embedded, W = M": ("embedded", "mass"),
}
TOLERANCES = (1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-14)


def printed(rows: list[Row]) -> str:
    """What the paper prints, and what there is here."""
    lines = []
    for row in rows:
        number = not isinstance(row.paper, str)
        tolerance = "" if row.tolerance is None else text(row.tolerance)
        paper = text(row.paper) if number else row.paper
        note = f"({row.note})" if row.note else ""
        lines.append([row.figure, row.what, text(row.step), tolerance, paper, text(row.here, rounding=True),
                      ratio(row.here, row.paper) if number else "", note])  # fmt: skip
    return markdown(["Fig.", "", "h, s", "Tol", "paper", "here", "here / paper", ""], lines)


def errors() -> str:
    """The projections, by what they do to the motion."""
    lines = []
    for name, step in (("heavy_top", 1e-3), ("heavy_top", 1e-4), ("satellite", 1e-1), ("satellite", 1e-2)):
        found = [f"{error(name, step, *form):.1e}" for form in FORMS.values()]
        lines.append([name.replace("_", " "), text(step), *(re.sub("e-0", "e-", x) for x in found)])
    return markdown(["", "h, s", *FORMS], lines)


def tolerances() -> str:
    """What is left where one iteration is not enough: the top turns by 1.5 rad in such a step."""
    lines = []
    for tolerance in TOLERANCES:
        cells = [text(tolerance)]
        for position in ("local", "embedded"):
            run = simulated("heavy_top", 1e-2, position, "mass", tolerance)
            off = np.abs(measures.gram(numbers.state(run, "top")[1]) - np.eye(3)).max()
            left = (float(run["position_violation"].max()), float(off))
            cells += [text(x, rounding=True) for x in left] + [text(float(run["position_iterations"].max()))]
        lines.append(cells)
    head = [f"{form}: {what}" for form in ("local", "embedded") for what in ("Phi, m", "R R^T - I", "iterations")]
    return markdown(["Tol", *head], lines)


TABLES: dict[str, Callable[[], str]] = {
    "heavy top, free": lambda: printed(numbers.heavy_top_free()),
    "heavy top, stabilised": lambda: printed(numbers.heavy_top_stabilised()),
    "satellite": lambda: printed(numbers.satellite()),
    "satellite, finely": lambda: printed(numbers.satellite_finely()),
    "errors": errors,
    "tolerances": tolerances,
}


def ratio(here: float, paper: float | str) -> str:
    assert not isinstance(paper, str)
    return f"< {text(bound(here) / paper)}" if here < ROUNDING else f"{here / paper:.3f}"
