"""Figures for dark pages."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PAGE = 0.1  # how bright what was white is; what was black is white
GREY = 0.02  # colours whose parts differ by no more are greys
COLORED = ("color", "facecolor", "edgecolor", "markerfacecolor", "markeredgecolor")


def darken(drawn: Figure) -> None:
    """Turn a figure for dark pages: greys are mirrored, colours stay as they are."""
    drawn.draw_without_rendering()  # what appears as it is drawn, such as ticks, has its colours from here on
    for artist in {*drawn.findobj()} - {drawn, *drawn.axes}:  # whose colours are those of a patch that they hold
        names = [name for name in COLORED if hasattr(artist, f"get_{name}") and hasattr(artist, f"set_{name}")]
        for name, color in [(name, _mirrored(getattr(artist, f"get_{name}")())) for name in names]:
            getattr(artist, f"set_{name}")(color)
    for axes in drawn.axes:
        axes.tick_params(which="both", colors="white")


def _mirrored(color: Any) -> Any:
    """Of one colour, or of several."""
    from matplotlib.colors import to_rgba_array

    if isinstance(color, str) and color in ("none", "auto"):
        return color
    found = to_rgba_array(color)
    greys = np.ptp(found[:, :3], axis=1) <= GREY
    found[greys, :3] = 1.0 - (1.0 - PAGE) * found[greys, :3]
    return found[0] if np.ndim(color) < 2 and len(found) == 1 else found
