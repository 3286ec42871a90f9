"""Every way in which an input of `[sweep.vary]` may vary."""

from collections.abc import Mapping
from typing import Annotated

from lienumba.errors import ScenarioError
from lienumba.keys.choices import OneOf
from lienumba.keys.registry import Registry, literal
from lienumba.sweep.distributions.base import Distribution
from lienumba.sweep.distributions.external import Column, Expression
from lienumba.sweep.distributions.inertia import Inertia
from lienumba.sweep.distributions.rotations import Direction, RotationNormal, RotationUniform
from lienumba.sweep.distributions.scalar import (
    Choice,
    Constant,
    Lognormal,
    Normal,
    Triangular,
    TruncatedNormal,
    Uniform,
)
from lienumba.sweep.distributions.scipy_named import SciPy

DISTRIBUTIONS: Registry[type[Distribution]] = Registry("distribution", lambda x: x.key or literal("distribution")(x))
for distribution in (
    Normal, Uniform, TruncatedNormal, Lognormal, Triangular, Choice, Constant, RotationNormal, RotationUniform,
    Direction, Inertia, SciPy, Expression, Column,
):  # fmt: skip
    DISTRIBUTIONS.add(distribution)


def named() -> list[str]:
    """The names that `distribution` may have."""
    return [name for name, distribution in DISTRIBUTIONS.items() if not distribution.key]


def by_key() -> list[str]:
    """The keys that stand for such a name."""
    return [name for name, distribution in DISTRIBUTIONS.items() if distribution.key]


def form_of(value: object) -> str | None:
    """Which of the distributions an entry of `vary` is written as; None if it is none of them."""
    if isinstance(value, Distribution):
        return next(name for name, distribution in DISTRIBUTIONS.items() if isinstance(value, distribution))
    if not isinstance(value, dict):
        return None
    name = value.get("distribution")
    if name is not None:
        return name if isinstance(name, str) and name in named() else None
    return next((key for key in by_key() if key in value), None)


def class_of(entry: Mapping[str, object]) -> type[Distribution]:
    """That of an entry of `vary`; a ScenarioError where a dataset that somebody has changed has none there."""
    form = form_of(entry)
    if form is None:
        raise ScenarioError("sweep.vary of the dataset has an entry that is no distribution; give the file as it was")
    return DISTRIBUTIONS[form]


def follows_nominal(entry: object) -> bool:
    """Whether the samples of an entry of `vary`, which may be a wrong one, follow the nominal value."""
    form = form_of(entry)
    return form is not None and isinstance(entry, dict) and DISTRIBUTIONS[form].follows(entry)


AnyDistribution = Annotated[Distribution, OneOf(DISTRIBUTIONS, form_of)]
