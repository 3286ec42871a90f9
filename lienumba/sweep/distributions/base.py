"""What every distribution says: which streams of uniform numbers it takes, and what it makes of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, ClassVar

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, StrictBool

from lienumba.errors import ScenarioError

LARGEST = 1e100  # of any number in SI units: squares and cubes must be numbers, too
Finite = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=-LARGEST, le=LARGEST)]
Spread = Annotated[Finite, Field(ge=0.0)]
NUMBER, VECTOR, ROTATION, INERTIA = "number", "vector", "rotation", "inertia"
# How many numbers each has in the design table: a quaternion w x y z, the elements xx yy zz xy xz yz.
WIDTHS = {VECTOR: 3, ROTATION: 4, INERTIA: 6}


def components(path: str, number: int) -> list[str]:
    """The paths of the components of what stands at a path."""
    return [f"{path}[{i}]" for i in range(number)]


class Distribution(BaseModel):
    """How an input varies. dimensions: uniform numbers per run that it takes; key: that stands for a name, as in
    { column = "m" }, or "" where `distribution` has the name."""

    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True)

    dimensions: ClassVar[int] = 1
    key: ClassVar[str] = ""
    leads_to: ClassVar[str] = NUMBER  # what its path must lead to

    def streams(self, path: str) -> list[str]:
        """The names of the streams of uniform numbers that it takes."""
        if self.leads_to == NUMBER:
            return [path] * self.dimensions
        return components(path, self.dimensions)

    def columns(self, path: str) -> list[str]:
        """The paths of the numbers that it gives to each run."""
        return [path] if self.shape == NUMBER else components(path, WIDTHS[self.shape])

    @property
    def shape(self) -> str:
        return self.leads_to

    @classmethod
    def follows(cls, given: Mapping[str, object]) -> bool:
        """Whether samples follow the nominal value; given: its keys, as they are written."""
        return cls.leads_to != NUMBER

    def draw(self, u: Sequence[np.ndarray], nominal: Any) -> Sequence[np.ndarray | float]:
        """The columns (runs,) at the uniform numbers u (dimensions, runs) about a nominal value: a number, or as many
        as there are columns; a ScenarioError, from behind the path on, if they do not fit."""
        raise NotImplementedError


class Scalar(Distribution):
    """The distribution of a number. middle: the key whose place the nominal value takes where it is omitted."""

    middle: ClassVar[str] = ""

    relative: StrictBool = Field(default=False, description="true (multiples of the nominal value) or false")

    @classmethod
    def follows(cls, given: Mapping[str, object]) -> bool:
        return given.get("relative") is True or bool(cls.middle and cls.middle not in given)

    def scale(self, nominal: float) -> float:
        """What the numbers of the distribution are multiples of."""
        if not self.relative:
            return 1.0
        if nominal == 0.0:
            raise ScenarioError.at(
                "relative",
                "must be false for a nominal value of 0, of which every multiple is 0",
                "leave it out and give absolute numbers",
                True,
            )
        return nominal

    def located(self, value: float | None, nominal: float) -> float:
        """A place of the distribution; the nominal value where it is omitted."""
        scale = self.scale(nominal)
        return nominal if value is None else value * scale

    def draw(self, u: Sequence[np.ndarray], nominal: Any) -> Sequence[np.ndarray | float]:
        return [self.ppf(u[0], nominal)]

    def ppf(self, u: np.ndarray, nominal: float) -> np.ndarray:
        """Samples (runs,) at the probabilities u (runs,), 0 < u < 1."""
        raise NotImplementedError
