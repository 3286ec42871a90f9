"""Figures for dark pages."""

import numpy as np
import pytest

import lienumba
from lienumba.figures import figure
from lienumba.figures.canvas import COLORS
from tests.rigs.studies import VARIED, top

pytest.importorskip("matplotlib")

READABLE = 4.5  # the contrast that WCAG 2.1 (1.4.3) asks of texts


@pytest.fixture(scope="module")
def runs():
    return lienumba.run(top(sweep=VARIED | {"runs": 4, "nominal": True}, title="example"))


def luminance(color):
    from matplotlib.colors import to_rgb

    parts = np.array(to_rgb(color))
    linear = np.where(parts <= 0.03928, parts / 12.92, ((parts + 0.055) / 1.055) ** 2.4)
    return float(linear @ [0.2126, 0.7152, 0.0722])


def contrast(a, b):
    high, low = sorted((luminance(a), luminance(b)), reverse=True)
    return (high + 0.05) / (low + 0.05)


@pytest.mark.parametrize("dark", [False, True])
def test_all_texts_can_be_read(runs, dark):
    from matplotlib.text import Text

    drawn = figure(runs, ["position", "energy", "bodies.top.mass"], dark=dark)
    drawn.draw_without_rendering()
    assert (luminance(drawn.get_facecolor()) < 0.05) == dark
    told = [text for text in drawn.findobj(Text) if text.get_text()]
    assert len(told) > 20
    assert min(contrast(text.get_color(), drawn.get_facecolor()) for text in told) > READABLE
    for axes in drawn.axes:
        if axes.get_visible():
            assert luminance(axes.get_facecolor()) == luminance(drawn.get_facecolor())


def test_colours_stay_and_the_nominal_run_is_seen(runs):
    from matplotlib.colors import to_hex

    light, dark = (
        [to_hex(line.get_color()) for axes in figure(runs, ["position"], dark=x).axes for line in axes.lines]
        for x in (False, True)
    )
    assert COLORS[0] in light
    assert "#000000" in light
    assert dark == [{"#000000": "#ffffff"}.get(color, color) for color in light]
