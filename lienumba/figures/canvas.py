"""Empty figures, colours for all eyes, and the way to a file."""

from __future__ import annotations

from math import ceil
from textwrap import wrap
from typing import TYPE_CHECKING, Any, Literal

from lienumba.errors import ScenarioError
from lienumba.store.outputs import Output, whole

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

STILLS = (".png", ".svg", ".pdf")
WIDTH, HEIGHT = 4.4, 3.1  # of a panel, inches
ALONE = 1.5  # times as large is a panel without others
LETTER = 0.11  # inches that a letter of a title takes
DPI = 130
COLORS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000")  # Okabe and Ito
Style = dict[str, Any]  # of a line, as matplotlib takes it
STYLES = ("-", "--")
NAMELESS = {".png": {}, ".svg": {"Date": None}, ".pdf": {"CreationDate": None}}  # the same figure, the same bytes


def blank(rows: int, columns: int, height: float = HEIGHT) -> tuple[Figure, list[list[Axes]]]:
    """A figure with so many panels of this height (inches)."""
    scale = ALONE if rows == columns == 1 else 1.0
    drawn = empty(scale * WIDTH * columns, scale * height * rows)
    return drawn, [list(row) for row in drawn.subplots(rows, columns, squeeze=False)]


def tiles(count: int, columns: int) -> tuple[Figure, list[Axes]]:
    """A figure with so many panels, in rows of so many; what is left of the last row stays empty."""
    drawn, axes = blank(ceil(count / columns), columns)
    flat = [ax for row in axes for ax in row]
    for ax in flat[count:]:
        ax.set_visible(False)
    return drawn, flat[:count]


def empty(
    width: float, height: float, layout: Literal["constrained"] | None = "constrained", dpi: float = DPI
) -> Figure:
    """A figure without anything in it (inches)."""
    try:
        from lienumba.figures.shown import Shown
    except ImportError:
        raise ScenarioError(
            'a figure needs matplotlib, which is missing; in the clone of lienumba, pip install ".[plot]"'
        ) from None

    return Shown(figsize=(width, height), layout=layout, dpi=dpi)


def entitle(drawn: Figure, *parts: str) -> None:
    """Put the parts of a title that are not empty above a figure, in as many lines as they take."""
    drawn.suptitle(lines(": ".join(filter(None, parts)), drawn.get_figwidth()))


def lines(text: str, width: float) -> str:
    """A text of the user's own in lines of this width (inches); a $ in it begins no formula."""
    return "\n".join(wrap(text, int(width / LETTER))).replace("$", r"\$")


def save(drawn: Figure, output: Output) -> None:
    """Write a figure as PNG, SVG or PDF."""
    from matplotlib import rc_context

    ending = output.path.suffix.lower()
    with whole(output) as partial, rc_context({"svg.hashsalt": "lienumba"}):
        drawn.savefig(partial, format=ending[1:], metadata=NAMELESS[ending])
