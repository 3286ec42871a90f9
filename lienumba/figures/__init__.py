"""Pictures of a dataset, drawn by matplotlib without its global state and without a display."""

from lienumba.figures.animate import animate as animate
from lienumba.figures.plots import figure as figure

__all__ = ["animate", "figure"]
