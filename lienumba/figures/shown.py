"""A figure that notebooks show."""

import io

from matplotlib.figure import Figure


class Shown(Figure):
    """A matplotlib figure that shows itself where it is the value of a cell, without pyplot."""

    def _repr_png_(self) -> bytes:
        picture = io.BytesIO()
        self.savefig(picture, format="png")
        return picture.getvalue()
