"""The distributions of `[sweep.vary]`, as pydantic models that map uniform numbers to samples."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, StrictBool, model_validator

from lienumba.errors import ScenarioError

if TYPE_CHECKING:
    import numpy as np

Finite = Annotated[float, Field(strict=True, allow_inf_nan=False)]


class _Distribution(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)

    relative: StrictBool = False

    def scale(self, nominal: float) -> float:
        """What the numbers of the distribution are multiples of."""
        if not self.relative:
            return 1.0
        if nominal == 0.0:
            raise ScenarioError(
                "relative = true: must be false for a nominal value of 0, of which every multiple is 0;"
                " leave it out and give absolute numbers"
            )
        return nominal


class Normal(_Distribution):
    """Normal distribution; with `relative`, `mean` and `std` are multiples of the nominal value."""

    distribution: Literal["normal"]
    mean: Finite | None = None
    std: Annotated[Finite, Field(ge=0.0)]

    def ppf(self, u: np.ndarray, nominal: float) -> np.ndarray:
        """Samples (runs,) at the probabilities u (runs,)."""
        from lienumba.sweep.normal import inverse

        scale = self.scale(nominal)
        mean = nominal if self.mean is None else self.mean * scale
        return mean + self.std * abs(scale) * inverse(u)


class Uniform(_Distribution):
    """Uniform distribution; with `relative`, `low` and `high` are multiples of the nominal value."""

    distribution: Literal["uniform"]
    low: Finite
    high: Finite

    @model_validator(mode="after")
    def _ordered(self) -> Uniform:
        if self.low > self.high:
            raise ValueError(f"low = {self.low:g}: must not be above high = {self.high:g}; exchange the two")
        return self

    def ppf(self, u: np.ndarray, nominal: float) -> np.ndarray:
        """Samples (runs,) at the probabilities u (runs,)."""
        scale = self.scale(nominal)
        low, high = sorted((self.low * scale, self.high * scale))  # a negative nominal value turns them round
        return low + (high - low) * u


Distribution = Annotated[Normal | Uniform, Field(discriminator="distribution")]
