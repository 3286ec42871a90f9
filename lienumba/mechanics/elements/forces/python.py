"""A force law of the user's own, written in Python."""

from typing import Literal

from pydantic import Field

from lienumba.keys.conversions import timed
from lienumba.keys.types import OR_FORMULA, Count, Number, Positive, Timed
from lienumba.mechanics.elements.forces.base import FORCES, ForceLaw
from lienumba.mechanics.elements.names import Names
from lienumba.mechanics.mechanism.model import Force


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
