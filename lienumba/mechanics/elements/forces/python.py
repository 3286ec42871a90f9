"""A force law of the user's own, written in Python."""

import re
from collections.abc import Iterator
from keyword import iskeyword
from typing import Literal

from pydantic import Field

from lienumba.errors import Problem
from lienumba.keys.conversions import timed
from lienumba.keys.types import NAME, NAME_RULE, OR_FORMULA, Count, Number, Positive, Timed
from lienumba.mechanics.elements.forces.base import FORCES, ForceLaw
from lienumba.mechanics.elements.names import Names
from lienumba.mechanics.mechanism.model import Force
from lienumba.words import show

MOST = 2000  # numbers in the memory of a law: more take too long to compile


@FORCES.add
class PythonForce(ForceLaw):
    """A function of the user's own (`lienumba.mechanics.elements.user_laws`)."""

    type: Literal["python"]
    function: str = Field(description='the file and the function in it: "arm.py:pd"')
    bodies: list[str] = Field(default=[], description='the names of the bodies that it gets, in order, or "ground"')
    joints: list[str] = Field(default=[], description="the names of the joints that it gets behind the bodies")
    returns: Literal["loads", "potential"] = Field(
        default="loads", description='"loads" (forces, torques and efforts) or "potential" (an energy in J)'
    )
    parameters: dict[str, Timed] = Field(
        default={}, description=f"numbers that it gets by name {OR_FORMULA}: {{ kp = 40, kd = 2 }}"
    )
    states: dict[str, Number] = Field(default={}, description="its states and their initial values: { integral = 0 }")
    memory: dict[str, Count] | None = Field(
        default=None, description="arrays that a sampled law keeps for each run, and their sizes: { line = 200 }"
    )
    every: Positive | None = Field(
        default=None, description="the interval in s at which it is sampled, above 0 (or omit it: at every time)"
    )

    def faults(self) -> Iterator[Problem]:
        yield from super().faults()
        if self.returns == "potential" and (self.states or self.memory or self.every is not None):
            yield Problem("", "a potential energy has neither states nor samples", "leave states, memory and every out")
        if self.memory and self.every is None:
            yield Problem("memory", "only a sampled law has a memory", "give every, or keep its numbers in states")
        if (size := sum((self.memory or {}).values())) > MOST:
            yield Problem("memory", f"has more than {MOST:,} numbers", "keep fewer", size)
        for key in ("states", "memory"):
            for name in getattr(self, key) or ():
                if not re.fullmatch(NAME, name) or iskeyword(name):
                    yield Problem(key, f"{show(name)} is no valid name", f"give {NAME_RULE}")

    def to_model(self, names: Names) -> Force:
        code = names.code(
            f"model.forces.{self.name}",
            self.function,
            [*self.bodies, *self.joints],
            self.parameters,
            returns=self.returns,
            joints=tuple(names.joints[name] for name in self.joints),
            states=list(self.states),
            memory=list((self.memory or {}).items()),
            every=self.every,
        )
        numbers = {name: timed(x) for name, x in self.parameters.items()}
        bodies = tuple(names.bodies[name] for name in self.bodies)
        return Force(self.name, self.type, bodies, numbers=numbers, code=code, initial={**self.states})
