"""Noise: random courses that each run has of its own, samples at equal intervals which formulas read by name.

One class for each type, with its keys and its mathematics: a linear recursion that normal numbers drive. A course is
scaled such that its standard deviation is 1 once it is stationary; it begins there.
"""

from collections.abc import Iterator, Mapping, Sequence
from math import pi
from typing import Any, ClassVar, Literal

from pydantic import Field

from lienumba.errors import Problem
from lienumba.keys.types import NotNegative, Positive
from lienumba.mechanics.elements.names import Names
from lienumba.mechanics.elements.quantities import NOISES, VELOCITY, Observed, Part, evaluate
from lienumba.mechanics.elements.quantities.base import QuantityType
from lienumba.mechanics.mechanism.courses import Recorded, Recursion, Square
from lienumba.mechanics.mechanism.kinematics import View
from lienumba.mechanics.mechanism.model import Law, Model, Quantity
from lienumba.numerics.expressions import Formula
from lienumba.numerics.operations import absolute, cos, exp, maximum, sin, sqrt, where

COURSE = "course"  # what samples are called in the formula that reads them
SLOWER = 0.05  # of the rate of the samples: the frequency of a band where none is given
COARSE = 0.25  # of that rate: frequencies above are not seen in the samples
TURN = 2.0 * pi
SMALL = 1e-6  # a square below which two terms of a series are exact

Keys = Mapping[str, Any]


class NoiseType(QuantityType):
    """A noise, as a scenario describes it.

    held: whether a sample is held until the next, else courses are linear between them.
    """

    held: ClassVar[bool] = False
    fixed: ClassVar[tuple[str, ...]] = ("every",)

    units: str | None = Field(default=None, description='the units as a text, such as "N"')

    # ---------------------------------------------------------------- mathematics
    @property
    def interval(self) -> float | None:
        """Between two samples in s; None for a single one."""
        return getattr(self, "every", None)

    @classmethod
    def level(cls, quantity: Quantity, component: str) -> int:
        return VELOCITY  # it has no rate

    @classmethod
    def reads(cls, quantity: Quantity, component: str) -> tuple[Any, ...]:
        return ()

    @classmethod
    def parts(cls, model: Model, quantity: Quantity) -> tuple[Part, ...]:
        return (Part("", quantity.units, "noise"),)

    @classmethod
    def rows(cls, model: Model, quantity: Quantity, view: View, observed: Observed | None) -> tuple[Any, ...]:
        return (evaluate(model, quantity.value, view),)

    # ---------------------------------------------------------------- keys
    @classmethod
    def sketch(cls, table: Mapping[str, Any], joints: Sequence[str], drivers: Sequence[str]) -> Quantity | None:
        return Quantity(str(table.get("name")), str(table["type"]))


class RandomNoise(NoiseType):
    """One that is drawn."""

    std: NotNegative = Field(description="the standard deviation, at least 0")

    def recursion(self) -> Recursion:
        """How one sample follows from those before."""
        raise NotImplementedError

    def to_model(self, names: Names) -> Quantity:
        samples = names.samples(self.name, self.recursion(), self.interval, self.held)
        formula = Formula(f"std*{COURSE}(t)", frozenset({"t", "std"}), frozenset({COURSE}))
        value = Law(formula, {COURSE: samples, "std": self.std})
        return Quantity(self.name, self.type, value=value, units=self.units or "1")


@NOISES.add
class White(RandomNoise):
    """Independent normal numbers, each held until the next: a power spectral density of std^2 every, on both sides,
    at low frequencies."""

    held: ClassVar[bool] = True
    example: ClassVar[Keys] = {"std": 0.3, "every": 0.1}

    type: Literal["white"]
    every: Positive = Field(description="the interval between two samples in s, above 0")

    def recursion(self) -> Recursion:
        return Recursion(((0.0,),), ((1.0,),), ((1.0,),), (1.0,))


@NOISES.add
class Band(RandomNoise):
    """White noise behind a low pass of the first order, or of the second: an oscillator."""

    example: ClassVar[Keys] = {"std": 0.3, "every": 0.1, "order": 2}

    type: Literal["band"]
    every: Positive = Field(description="the interval between two samples in s, above 0")
    frequency: Positive | None = Field(
        default=None,
        description="that of the low pass in Hz, above 0: where the power is halved, or of the oscillator (or omit it: "
        f"{SLOWER:g}/every)",
    )
    order: Literal[1, 2] = Field(default=1, description="that of the low pass, 1 or 2")
    damping: Positive | None = Field(
        default=None, description="the damping ratio of order 2, above 0 (or omit it: 0.7071, as flat as can be)"
    )

    def recursion(self) -> Recursion:
        angle = TURN * (SLOWER if self.frequency is None else self.frequency * self.every)
        if self.order == 1:
            return _first_order(angle)
        return _oscillator(angle, 0.5**0.5 if self.damping is None else self.damping)

    def faults(self) -> Iterator[Problem]:
        if self.damping is not None and self.order == 1:
            yield Problem("damping", "has no effect without order = 2", "give order = 2, or leave it out", self.damping)
        if self.frequency is not None and self.frequency * self.every > COARSE:
            rule = f"is above {COARSE:g}/every = {COARSE / self.every:.6g}, so that samples would miss it"
            yield Problem("frequency", rule, "give a smaller every, or white noise", self.frequency)


@NOISES.add
class Dryden(RandomNoise):
    """Gusts of Dryden's spectrum (MIL-F-8785C), along the flight or across it, with this turbulence length and
    airspeed."""

    example: ClassVar[Keys] = {"std": 1.5, "length": 200.0, "speed": 30.0, "every": 0.1}

    type: Literal["dryden"]
    every: Positive = Field(description="the interval between two samples in s, above 0")
    length: Positive = Field(description="the length of the turbulence in m, above 0")
    speed: Positive = Field(description="the airspeed in m/s, above 0")
    direction: Literal["along", "across"] = Field(default="along", description='"along" the flight, or "across"')

    def recursion(self) -> Recursion:
        angle = self.speed * self.every / self.length
        return _first_order(angle) if self.direction == "along" else _across(angle)

    def faults(self) -> Iterator[Problem]:
        if self.speed * self.every > self.length:
            longest = self.length / self.speed
            yield Problem("every", f"is longer than length/speed = {longest:.6g} s", "give a smaller one", self.every)


@NOISES.add
class Walk(RandomNoise):
    """The sum of white noise, which begins at 0: after t seconds its standard deviation is std sqrt(t)."""

    example: ClassVar[Keys] = {"std": 0.3, "every": 0.1}

    type: Literal["walk"]
    std: NotNegative = Field(description="the standard deviation after 1 s, at least 0")
    every: Positive = Field(description="the interval between two samples in s, above 0")

    def recursion(self) -> Recursion:
        return Recursion(((1.0,),), ((self.every**0.5,),), ((0.0,),), (1.0,))


@NOISES.add
class Bias(RandomNoise):
    """One normal number for the whole run."""

    held: ClassVar[bool] = True
    example: ClassVar[Keys] = {"std": 0.3}

    type: Literal["bias"]

    def recursion(self) -> Recursion:
        return Recursion(((1.0,),), ((0.0,),), ((1.0,),), (1.0,))


@NOISES.add
class Tabulated(NoiseType):
    """Courses that each run has in a file, at equal intervals from 0 on, linear between them."""

    fixed: ClassVar[tuple[str, ...]] = ("every", "runs", "samples")
    example: ClassVar[Keys] = {
        "table": "gusts.nc", "value": "gust", "every": 0.1, "runs": 10, "samples": 100, "checksum": ""
    }  # fmt: skip

    type: Literal["table"]
    table: str = Field(description="the path of a netCDF-4 file, relative to the scenario")
    value: str = Field(description="its variable with the dimensions run and time")
    every: Positive | None = Field(default=None, description="the interval between two samples in s (read)")
    runs: int | None = Field(default=None, description="how many runs the file has (read)")
    samples: int | None = Field(default=None, description="how many samples each has (read)")
    checksum: str | None = Field(default=None, description="the SHA-256 of the file (read)")

    def to_model(self, names: Names) -> Quantity:
        source = Recorded(self.table, self.value, self.samples or 0, self.checksum)
        course = names.samples(self.name, source, self.interval, self.held)
        value = Law(Formula(f"{COURSE}(t)", frozenset({"t"}), frozenset({COURSE})), {COURSE: course})
        return Quantity(self.name, self.type, value=value, units=self.units or "1")


def _first_order(angle: Any) -> Recursion:
    """dx = -x dt + sqrt(2) dW, sampled after each `angle`."""
    move = exp(-angle)
    return Recursion(((move,),), ((sqrt(1.0 - move * move),),), ((1.0,),), (1.0,))


def _oscillator(angle: Any, damping: Any) -> Recursion:
    """x'' + 2 damping x' + x = 2 sqrt(damping) W', sampled after each `angle`: by Cayley and Hamilton. Of the
    stationary course x and x' are independent, of variance 1."""
    decay, square = -damping * angle, angle * angle * (damping * damping - 1.0)
    q = sqrt(absolute(square))
    divisor = where(q > 0.0, q, 1.0)
    up, down, even = exp(decay + q), exp(decay - q), exp(decay)
    near = even * (1.0 + square / 6.0 * (1.0 + square / 20.0))
    c = where(square > 0.0, 0.5 * (up + down), even * cos(q))
    s = where(square > 0.0, 0.5 * (up - down), even * sin(q)) / divisor
    s = angle * where(absolute(square) < SMALL, near, s)
    move = ((c + damping * s, s), (-s, c - damping * s))
    return Recursion(move, _root(_lost(move, (1.0, 0.0, 1.0))), ((1.0, 0.0), (0.0, 1.0)), (1.0, 0.0))


def _across(angle: Any) -> Recursion:
    """(1 + sqrt(3) s)/(1 + s)^2 of white noise, sampled after each `angle`: two low passes, one behind the other."""
    e = exp(-angle)
    move = ((e, 0.0), (angle * e, e))
    kick = _root(_lost(move, (1.0, 0.5, 0.5)))
    out = (1.5**0.5, (1.0 - 3.0**0.5) * 0.5**0.5)
    return Recursion(move, kick, ((1.0, 0.0), (0.5, 0.5)), out)


def _lost(move: Square, P: tuple[Any, Any, Any]) -> tuple[Any, Any, Any]:
    """P - move P move^T of a symmetric P (11, 21, 22)."""
    (a, b), (c, d) = move
    p, r, q = P
    across = a * c * p + (a * d + b * c) * r + b * d * q
    return p - a * a * p - 2.0 * a * b * r - b * b * q, r - across, q - c * c * p - 2.0 * c * d * r - d * d * q


def _root(P: tuple[Any, Any, Any]) -> Square:
    """The lower triangle whose square a symmetric matrix is, which rounding may have made singular."""
    first = sqrt(maximum(P[0], 0.0))
    below = where(first > 0.0, P[1] / where(first > 0.0, first, 1.0), 0.0)
    return (first, 0.0), (below, sqrt(maximum(P[2] - below * below, 0.0)))
