"""The distributions of numbers with plain names. Their samples have the same bits on every processor."""

from __future__ import annotations

from math import inf
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field, model_validator

from lienumba.errors import BadValueError, ScenarioError
from lienumba.numerics.operations import exp
from lienumba.sweep.distributions.base import Finite, Scalar, Spread
from lienumba.words import Written

if TYPE_CHECKING:
    from collections.abc import Sequence

FARTHEST = 35.0  # standard deviations from the mean; beyond, no probability is left that a double could hold
MEAN = Field(default=None, description="the mean (or omit it: the nominal value)")


class Normal(Scalar):
    """Normal distribution; with `relative`, `mean` and `std` are multiples of the nominal value."""

    middle: ClassVar[str] = "mean"

    distribution: Literal["normal"]
    mean: Finite | None = MEAN
    std: Spread = Field(description="the standard deviation, 0 or above")

    def ppf(self, u: np.ndarray, nominal: float) -> np.ndarray:
        from lienumba.sweep.normal import inverse

        return self.located(self.mean, nominal) + self.std * abs(self.scale(nominal)) * inverse(u)


class Uniform(Scalar):
    """Uniform distribution; with `relative`, `low` and `high` are multiples of the nominal value."""

    distribution: Literal["uniform"]
    low: Finite = Field(description="the lowest value")
    high: Finite = Field(description="the highest value")

    @model_validator(mode="after")
    def _ordered(self) -> Uniform:
        _check_order(self.low, self.high)
        return self

    def ppf(self, u: np.ndarray, nominal: float) -> np.ndarray:
        scale = self.scale(nominal)
        low, high = sorted((self.low * scale, self.high * scale))  # a negative nominal value turns them round
        return low + (high - low) * u


class TruncatedNormal(Scalar):
    """Normal distribution between bounds; with `relative`, all its numbers are multiples of the nominal value."""

    middle: ClassVar[str] = "mean"

    distribution: Literal["truncated_normal"]
    mean: Finite | None = MEAN
    std: Annotated[Finite, Field(gt=0.0)] = Field(description="the standard deviation without bounds, above 0")
    low: Finite | None = Field(default=None, description="the lowest value (or omit it: none)")
    high: Finite | None = Field(default=None, description="the highest value (or omit it: none)")

    @model_validator(mode="after")
    def _bounded(self) -> TruncatedNormal:
        if self.low is None and self.high is None:
            raise BadValueError("has neither low nor high", 'give one of them, or the distribution "normal"')
        if self.low is not None and self.high is not None:
            _check_apart(self.low, self.high)
        return self

    def ppf(self, u: np.ndarray, nominal: float) -> np.ndarray:
        from lienumba.sweep.normal import inverse, probability

        scale = self.scale(nominal)
        mean, std = self.located(self.mean, nominal), self.std * abs(scale)
        bounds = (-inf if self.low is None else self.low), (inf if self.high is None else self.high)
        low, high = sorted(scale * x for x in bounds)
        a, b = (low - mean) / std, (high - mean) / std
        if a > FARTHEST or b < -FARTHEST:
            raise ScenarioError.at(
                "mean",
                (
                    f"{mean:g} lies more than {FARTHEST:g} standard deviations outside of the bounds, {low:g} and "
                    f"{high:g}, between which no sample would ever fall"
                ),
                "correct mean, std or the bounds",
            )
        upper = a > 0.0  # there the probabilities of the other side are exact
        if upper:
            a, b, u = -b, -a, 1.0 - u
        below, until = probability(np.array([a, b]))
        z = inverse(np.maximum(below + u * (until - below), 5e-324))
        return np.clip(mean + std * (-z if upper else z), low, high)


class Lognormal(Scalar):
    """median exp(sigma z) with z standard normal; with `relative`, `median` is a multiple of the nominal value."""

    middle: ClassVar[str] = "median"

    distribution: Literal["lognormal"]
    median: Finite | None = Field(default=None, description="the median (or omit it: the nominal value)")
    sigma: Spread = Field(description="the standard deviation of the logarithm, 0 or above")

    def ppf(self, u: np.ndarray, nominal: float) -> np.ndarray:
        from lienumba.sweep.normal import inverse

        median = self.located(self.median, nominal)
        if median == 0.0:
            what = "the nominal value, which is 0" if self.median is None else "0"
            raise ScenarioError.at("median", f"is {what}, so that every sample is 0", "give a median other than 0")
        samples: np.ndarray = median * exp(self.sigma * inverse(u))
        return samples


class Triangular(Scalar):
    """Triangular distribution; with `relative`, `low`, `mode` and `high` are multiples of the nominal value."""

    middle: ClassVar[str] = "mode"

    distribution: Literal["triangular"]
    low: Finite = Field(description="the lowest value")
    mode: Finite | None = Field(default=None, description="the most likely value (or omit it: the nominal value)")
    high: Finite = Field(description="the highest value")

    @model_validator(mode="after")
    def _ordered(self) -> Triangular:
        _check_apart(self.low, self.high)
        return self

    def ppf(self, u: np.ndarray, nominal: float) -> np.ndarray:
        scale = self.scale(nominal)
        low, high = sorted((self.low * scale, self.high * scale))
        mode = self.located(self.mode, nominal)
        if not low <= mode <= high:
            what = "the nominal value" if self.mode is None else "the mode"
            raise ScenarioError.at(
                "mode",
                f"{what} {mode:g} does not lie between low and high, {low:g} and {high:g}",
                "give one that does, or other bounds",
            )
        left, right, width = mode - low, high - mode, high - low
        rising, falling = np.sqrt(u * width * left), np.sqrt((1.0 - u) * width * right)
        samples: np.ndarray = np.where(u * width < left, low + rising, high - falling)
        return samples


class Choice(Scalar):
    """One of some values; with `relative`, `values` are multiples of the nominal value."""

    distribution: Literal["choice"]
    values: list[Finite] = Field(description="the values to choose from, at least one")
    weights: list[Spread] | None = Field(
        default=None, description="how likely each value is, 0 or above (or omit it: all alike)"
    )

    @model_validator(mode="after")
    def _complete(self) -> Choice:
        if not self.values:
            raise BadValueError("is empty", "give at least one value", "values", [])
        if self.weights is not None and len(self.weights) != len(self.values):
            raise BadValueError(
                f"must be as many as there are values, which is {len(self.values)}",
                "give one for each value",
                "weights",
                Written(self.weights),
            )
        if self.weights is not None and not sum(self.weights) > 0.0:
            raise BadValueError("are all 0", "give at least one above 0", "weights", Written(self.weights))
        return self

    def ppf(self, u: np.ndarray, nominal: float) -> np.ndarray:
        weights = np.array(self.weights or [1.0] * len(self.values))
        ends = np.cumsum(weights)
        last = int(np.flatnonzero(weights)[-1])
        chosen = np.minimum(np.searchsorted(ends, u * ends[-1], side="right"), last)
        samples: np.ndarray = np.array(self.values)[chosen] * self.scale(nominal)
        return samples


class Constant(Scalar):
    """One value for all runs but the nominal one; with `relative`, a multiple of the nominal value."""

    dimensions: ClassVar[int] = 0

    distribution: Literal["constant"]
    value: Finite = Field(description="the value of all runs")

    def draw(self, u: Sequence[np.ndarray], nominal: Any) -> Sequence[np.ndarray | float]:
        return [self.value * self.scale(nominal)]


def _check_apart(low: float, high: float) -> None:
    if low == high:
        raise BadValueError("must be below high", "give a constant instead", "low", Written(f"{low:g}"))
    _check_order(low, high)


def _check_order(low: float, high: float) -> None:
    if low > high:
        raise BadValueError(f"must not be above high = {high:g}", "exchange the two", "low", Written(f"{low:g}"))
