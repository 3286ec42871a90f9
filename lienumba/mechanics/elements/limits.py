"""Rigid stops on the coordinates of joints."""

from collections.abc import Iterator

from pydantic import Field

from lienumba.errors import Problem
from lienumba.keys.types import NAME_RULE, Name, NotNegative, Number, Section
from lienumba.mechanics.elements.contacts.base import REST, Share
from lienumba.mechanics.elements.names import Names
from lienumba.mechanics.mechanism import model as m
from lienumba.words import show

SIDES = {"low": 1.0, "high": -1.0}


class Limit(Section):
    """A stop below, above, or both."""

    name: Name = Field(description=NAME_RULE)
    joint: str = Field(description="the name of the joint")
    coordinate: str | None = Field(
        default=None, description="which of its coordinates (or omit it where there is only one)"
    )
    low: Number | None = Field(default=None, description="the least value in rad or m (or omit it: none)")
    high: Number | None = Field(default=None, description="the largest value in rad or m (or omit it: none)")
    restitution: Share = Field(
        default=0.0, description="the restitution, from 0 (nothing comes back of an impact) to 1 (as fast as it came)"
    )
    rest_speed: NotNegative | None = Field(
        default=None,
        description=f"the rate in rad/s or m/s below which a rebound is none, at least 0 {REST}",
    )

    def to_model(self, names: Names) -> Iterator[m.Limit]:
        """Its sides, as kernels see them."""
        for key, side in SIDES.items():
            value = getattr(self, key)
            if value is not None:
                which = names.coordinate(self.joint, self.coordinate)
                yield m.Limit(f"{self.name}.{key}", which, side, value, self.restitution, self.rest_speed)

    def faults(self) -> Iterator[Problem]:
        if self.low is None and self.high is None:
            yield Problem("", "has no stop", "give low, high or both")
        elif self.low is not None and self.high is not None and not self.low < self.high:
            remedy = "exchange the two" if self.low > self.high else "move them apart, or use a lock"
            yield Problem("low", f"must be below high = {show(self.high)}", remedy, self.low)
