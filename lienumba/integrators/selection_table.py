"""Where numbers lie in the table by which rows of C are selected, of q exchangeable rows."""

from lienumba.compiler.rows import W
from lienumba.numerics.operations import kernel


@kernel
def table_scales(q: int) -> int:
    """The first row of the scales of q exchangeable rows, behind the lower triangle of S."""
    return q * (q + 1) // 2


@kernel
def table_masks(q: int) -> int:
    """The first row of their masks."""
    return table_scales(q) + q


@kernel
def table_asked(q: int) -> int:
    """The row that says in which lanes to select."""
    return table_masks(q) + q


@kernel
def table_room(q: int) -> int:
    """The first row of what one lane at a time is worked on in: a matrix of q rows, and two."""
    return table_asked(q) + 1


@kernel
def table_rows(q: int) -> int:
    """Of the whole table."""
    return table_room(q) - (-q * (q + 2) // W)
