"""The report of a dataset: one HTML file that needs nothing else, with the mechanism moving."""

from lienumba.present.html.page import report as report

__all__ = ["report"]
