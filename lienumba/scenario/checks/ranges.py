"""Whether a distribution suits the number that it varies: one that fits its nominal value, and draws nothing that no
run may have."""

from dataclasses import dataclass
from math import erfc, sqrt
from typing import TYPE_CHECKING

import numpy as np

from lienumba.errors import ScenarioError
from lienumba.keys.facts import facts, is_not_negative, is_positive
from lienumba.mechanics.elements.forces import FORCES
from lienumba.mechanics.elements.joints import JOINTS, Own
from lienumba.numerics.number import Vector
from lienumba.scenario.base import paths
from lienumba.scenario.base.toml import Keys
from lienumba.scenario.schema.scenario import section_of
from lienumba.sweep.distributions.base import Distribution, Scalar
from lienumba.sweep.distributions.external import Given
from lienumba.sweep.distributions.scalar import Constant, Normal, Uniform

if TYPE_CHECKING:
    from lienumba.scenario.base.problems import Report

RARE = 1e-3  # expected number of unphysical runs of a sweep that deserves a warning
LEAST = 2.0**-50  # probability; what is below it is none


@dataclass(frozen=True)
class Refused:
    """The values that a number cannot have; words: what such a one would be, "no body has"; zero: whether 0 is one."""

    words: str
    zero: bool = True

    @property
    def values(self) -> str:
        return "of 0 or below" if self.zero else "below 0"

    @property
    def others(self) -> str:
        return "above 0" if self.zero else "of 0 or above"

    def has(self, x: float) -> bool:
        """Whether it is such a value."""
        return x <= 0.0 if self.zero else x < 0.0


MASS = Refused("no body has")


def check_range(
    path: str, nominal: float | Vector, given: Distribution, runs: int, refused: Refused | None, report: "Report"
) -> None:
    """Distributions that do not fit the nominal value, and those that draw what is refused."""
    if isinstance(given, Given):
        return
    at = f'sweep.vary."{path}"'
    try:
        _sample(given, 0.5, nominal)
    except ScenarioError as error:
        report.problems += [problem.below(at) for problem in error.problems]
        return
    if not isinstance(given, Scalar) or not isinstance(nominal, float) or refused is None or refused.has(nominal):
        if refused == MASS and nominal == 0.0:
            report.add(at, "varies the mass of a body that has none", "give it a mass above 0, and an inertia")
        return
    factor = nominal if given.relative else 1.0
    if isinstance(given, Uniform):
        if refused.has(given.low * factor):
            rule = f"allows values {refused.values}, which {refused.words}"
            report.add(f"{at}.low", rule, f"give low {refused.others}", given.low)
        return
    if isinstance(given, Normal):
        mean = nominal if given.mean is None else given.mean * factor
        if refused.has(mean):
            report.add(f"{at}.mean", f"must be {refused.others}", f"give the mean of {path}", given.mean)
            return
        share = 0.5 * erfc(mean / (given.std * factor) / sqrt(2.0)) if given.std * factor > 0.0 else 0.0
    else:
        share = _share(refused, given, nominal)
    if share == 1.0:
        report.add(at, f"draws only values {refused.values}, which {refused.words}", f"give values {refused.others}")
    elif share * runs > RARE:
        remedy = "a smaller std, or a uniform distribution" if isinstance(given, Normal) else "other numbers"
        report.warn(
            at, f"of {runs} runs about {share * runs:.2g} will draw a value {refused.values} and fail", f"give {remedy}"
        )


def refused_below(path: str, model: Keys) -> Refused | None:
    """What the number at a path cannot be; None if it may be anything."""
    tokens = paths.parse(path)
    if tokens[0] == "forces" and len(tokens) == 3:
        law = FORCES.get(str(paths.get(model, tokens[:2]).get("type")))
        number = law.numbers().get(str(tokens[2])) if law is not None else None
        words = number.sign.refused if number is not None and number.sign is not None else ""
        return Refused(words) if words else None
    if tokens[0] == "joints" and len(tokens) == 3:
        kind, key = JOINTS.get(str(paths.get(model, tokens[:2]).get("type"))), str(tokens[2])
        if kind is None or key not in kind.model_fields:
            return None
        own = facts(kind, Own).get(key)
        if own is not None and is_positive(kind, key):
            return Refused(own.refused)
        return Refused("no rotor has", zero=False) if is_not_negative(kind, key) else None
    if tokens[0] in ("contacts", "limits") and len(tokens) == 3:
        stop = section_of(str(tokens[0]), paths.get(model, tokens[:2]))
        if stop is None or tokens[2] not in stop.model_fields:
            return None
        positive, not_negative = is_positive(stop, str(tokens[2])), is_not_negative(stop, str(tokens[2]))
        words = f"no {str(tokens[0]).removesuffix('s')} has"
        return Refused(words, zero=positive) if positive or not_negative else None
    if tokens[0] == paths.INPUTS and tokens[2:] == ["filter"]:
        return Refused("no input follows with")
    return MASS if tokens[0] == "bodies" and tokens[2:] == ["mass"] else None


def _sample(given: Distribution, u: float, nominal: object) -> float:
    """The first number that it gives at these probabilities."""
    with np.errstate(all="ignore"):
        return float(np.ravel(given.draw([np.array([u])] * given.dimensions, nominal)[0])[0])


def _share(refused: Refused, given: Scalar, nominal: float) -> float:
    """The probability of a refused value, by bisection."""
    if isinstance(given, Constant):
        return float(refused.has(_sample(given, 0.5, nominal)))
    if not refused.has(_sample(given, LEAST, nominal)):
        return 0.0
    low, high = 0.0, 1.0
    while high - low > 1e-3 * high and high > LEAST:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if refused.has(_sample(given, middle, nominal)) else (low, middle)
    return 0.0 if high <= LEAST else 1.0 if low > 0.999 else low
