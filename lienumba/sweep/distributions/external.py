"""Inputs that are not drawn: columns of a table, and formulas of other inputs."""

from __future__ import annotations

from typing import Annotated, ClassVar

from pydantic import Discriminator, Field, StrictStr, Tag

from lienumba.sweep.distributions.base import INERTIA, NUMBER, ROTATION, VECTOR, Distribution

Columns = Annotated[list[StrictStr], Field(min_length=1, max_length=6)]
SHAPES = {1: NUMBER, 3: VECTOR, 4: ROTATION, 6: INERTIA}


class Given(Distribution):
    """It takes no random numbers."""

    dimensions: ClassVar[int] = 0


class Column(Given):
    """The values of a column of `sweep.table`; those of several for a rotation (4), an inertia (6) or a vector (3)."""

    key: ClassVar[str] = "column"

    column: Annotated[
        Annotated[StrictStr, Tag("name")] | Annotated[Columns, Tag("names")],
        Discriminator(lambda value: "names" if isinstance(value, list | tuple) else "name"),
    ] = Field(
        description="the name of a column of sweep.table; 4 names for a rotation, 6 for an inertia, 3 for a vector"
    )

    @property
    def names(self) -> list[str]:
        return [self.column] if isinstance(self.column, str) else self.column

    @property
    def shape(self) -> str:
        return SHAPES.get(len(self.names), NUMBER)


class Expression(Given):
    """A formula of parameters and of other varied numbers by their paths, evaluated for each run."""

    key: ClassVar[str] = "expression"

    expression: StrictStr = Field(
        description='a formula of parameters and of other varied numbers, such as "0.0156*bodies.top.mass"'
    )
