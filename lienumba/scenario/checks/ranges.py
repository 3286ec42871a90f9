"""Whether a distribution suits the number that it varies: one that fits its nominal value, and stays above 0."""

from math import erfc, sqrt
from typing import TYPE_CHECKING

import numpy as np

from lienumba.errors import ScenarioError
from lienumba.keys.facts import facts, is_positive
from lienumba.mechanics.elements.forces import FORCES
from lienumba.mechanics.elements.joints import JOINTS, Own
from lienumba.numerics.number import Vector
from lienumba.scenario.base import paths
from lienumba.scenario.base.toml import Keys
from lienumba.sweep.distributions.base import Distribution, Scalar
from lienumba.sweep.distributions.external import Given
from lienumba.sweep.distributions.scalar import Constant, Normal, Uniform

if TYPE_CHECKING:
    from lienumba.scenario.base.problems import Report

RARE = 1e-3  # expected number of unphysical runs of a sweep that deserves a warning
LEAST = 2.0**-50  # probability; what is below it is none


def check_range(
    path: str, nominal: float | Vector, given: Distribution, runs: int, refused: str, report: "Report"
) -> None:
    """Distributions that do not fit the nominal value, and those that draw values of 0 or below where these cannot be;
    refused: what such a value would be, "no body has", if so."""
    if isinstance(given, Given):
        return
    at = f'sweep.vary."{path}"'
    try:
        _sample(given, 0.5, nominal)
    except ScenarioError as error:
        report.problems += [problem.below(at) for problem in error.problems]
        return
    if not isinstance(given, Scalar) or not isinstance(nominal, float) or not refused or nominal <= 0.0:
        return
    factor = nominal if given.relative else 1.0
    if isinstance(given, Uniform):
        if given.low * factor <= 0.0:
            report.add(f"{at}.low", f"allows values of 0 or below, which {refused}", "give low above 0", given.low)
        return
    if isinstance(given, Normal):
        mean = nominal if given.mean is None else given.mean * factor
        if mean <= 0.0:
            report.add(f"{at}.mean", "must be above 0", f"give the mean of {path}", given.mean)
            return
        share = 0.5 * erfc(mean / (given.std * factor) / sqrt(2.0)) if given.std > 0.0 else 0.0
    else:
        share = _share_of_zero_and_below(given, nominal)
    if share == 1.0:
        report.add(at, f"draws only values of 0 or below, which {refused}", "give values above 0")
    elif share * runs > RARE:
        remedy = "a smaller std, or a uniform distribution" if isinstance(given, Normal) else "other numbers"
        report.warn(
            at, f"of {runs} runs about {share * runs:.2g} will draw a value of 0 or below and fail", f"give {remedy}"
        )


def refused_below(path: str, model: Keys) -> str:
    """Which value of 0 or below the number at a path cannot be, in words; empty if it may be."""
    tokens = paths.parse(path)
    if tokens[0] == "forces" and len(tokens) == 3:
        law = FORCES.get(str(paths.get(model, tokens[:2]).get("type")))
        number = law.numbers().get(str(tokens[2])) if law is not None else None
        return number.sign.refused if number is not None and number.sign is not None else ""
    if tokens[0] == "joints" and len(tokens) == 3:
        kind, key = JOINTS.get(str(paths.get(model, tokens[:2]).get("type"))), str(tokens[2])
        own = facts(kind, Own).get(key) if kind is not None else None
        return own.refused if kind is not None and own is not None and is_positive(kind, key) else ""
    return "no body has" if tokens[0] == "bodies" and tokens[2:] == ["mass"] else ""


def _sample(given: Distribution, u: float, nominal: object) -> float:
    """The first number that it gives at these probabilities."""
    with np.errstate(all="ignore"):
        return float(np.ravel(given.draw([np.array([u])] * given.dimensions, nominal)[0])[0])


def _share_of_zero_and_below(given: Scalar, nominal: float) -> float:
    """The probability of a value that is not above 0, by bisection."""
    if isinstance(given, Constant):
        return float(_sample(given, 0.5, nominal) <= 0.0)
    if _sample(given, LEAST, nominal) > 0.0:
        return 0.0
    low, high = 0.0, 1.0
    while high - low > 1e-3 * high and high > LEAST:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if _sample(given, middle, nominal) <= 0.0 else (low, middle)
    return 0.0 if high <= LEAST else 1.0 if low > 0.999 else low
