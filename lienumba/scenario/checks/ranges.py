"""Whether a distribution suits the number that it varies: one that fits its nominal value, and draws nothing that no
run may have."""

from collections.abc import Callable
from dataclasses import dataclass
from math import erfc, inf, sqrt

import numpy as np

from lienumba.errors import ScenarioError
from lienumba.keys.facts import at_most, facts, is_not_negative, is_positive
from lienumba.mechanics.elements.forces import FORCES
from lienumba.mechanics.elements.joints import JOINTS, Own
from lienumba.numerics.number import Vector
from lienumba.scenario.base import paths
from lienumba.scenario.base.problems import Report
from lienumba.scenario.base.toml import Keys
from lienumba.scenario.schema.sections import section_of
from lienumba.sweep.distributions.base import Distribution, Scalar
from lienumba.sweep.distributions.external import Given
from lienumba.sweep.distributions.scalar import Constant, Normal, Uniform

RARE = 1e-3  # expected number of unphysical runs of a sweep that deserves a warning
LEAST = 2.0**-50  # probability; what is below it is none


@dataclass(frozen=True)
class Refused:
    """The values that a number cannot have; words: what such a one would be, "no body has"; zero: whether 0 is one;
    most: what it is at most."""

    words: str
    zero: bool = True
    most: float = inf

    @property
    def values(self) -> str:
        return ("of 0 or below" if self.zero else "below 0") + (f" or above {self.most:g}" if self.most < inf else "")

    @property
    def others(self) -> str:
        if self.most < inf:
            return f"above 0 and at most {self.most:g}" if self.zero else f"between 0 and {self.most:g}"
        return "above 0" if self.zero else "of 0 or above"

    def below(self, x: float) -> bool:
        """Whether it is too small."""
        return x <= 0.0 if self.zero else x < 0.0

    def has(self, x: float) -> bool:
        """Whether it is such a value."""
        return self.below(x) or x > self.most


MASS = Refused("no body has")


def check_range(
    path: str, nominal: float | Vector, given: Distribution, runs: int, refused: Refused | None, report: Report
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
        rule = f"allows values {refused.values}, which {refused.words}"
        if refused.has(given.low * factor):
            report.add(f"{at}.low", rule, f"give low {refused.others}", given.low)
        if given.high * factor > refused.most:
            report.add(f"{at}.high", rule, f"give high {refused.others}", given.high)
        return
    if isinstance(given, Normal):
        mean = nominal if given.mean is None else given.mean * factor
        if refused.has(mean):
            report.add(f"{at}.mean", f"must be {refused.others}", f"give the mean of {path}", given.mean)
            return
        spread = sqrt(2.0) * given.std * factor
        share = 0.5 * (erfc(mean / spread) + erfc((refused.most - mean) / spread)) if spread > 0.0 else 0.0
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
        return Refused(words, positive, at_most(stop, str(tokens[2]))) if positive or not_negative else None
    if tokens[0] == paths.INPUTS and tokens[2:] == ["filter"]:
        return Refused("no input follows with")
    return MASS if tokens[0] == "bodies" and tokens[2:] == ["mass"] else None


def _sample(given: Distribution, u: float, nominal: object) -> float:
    """The first number that it gives at these probabilities."""
    with np.errstate(all="ignore"):
        return float(np.ravel(given.draw([np.array([u])] * given.dimensions, nominal)[0])[0])


def _share(refused: Refused, given: Scalar, nominal: float) -> float:
    """The probability of a refused value, by bisection from either end."""
    if isinstance(given, Constant):
        return float(refused.has(_sample(given, 0.5, nominal)))
    below = _part(lambda u: refused.below(_sample(given, u, nominal)))
    above = _part(lambda u: _sample(given, 1.0 - u, nominal) > refused.most) if refused.most < inf else 0.0
    return min(below + above, 1.0)


def _part(refuses: Callable[[float], bool]) -> float:
    """Up to which probability values are refused."""
    if not refuses(LEAST):
        return 0.0
    low, high = 0.0, 1.0
    while high - low > 1e-3 * high and high > LEAST:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if refuses(middle) else (low, middle)
    return 0.0 if high <= LEAST else 1.0 if low > 0.999 else low
