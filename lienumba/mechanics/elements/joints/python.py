"""A constraint that is a Python function of the user's own (`lienumba.mechanics.elements.user_laws`)."""

from typing import Any, Literal

from pydantic import Field

from lienumba.keys.types import Number
from lienumba.mechanics.elements.joints.base import JOINTS, JointType
from lienumba.mechanics.elements.names import Names
from lienumba.mechanics.mechanism.model import Joint

CAM = "def touches(body, *, radius):\n    return body.position.norm() - radius\n"


@JOINTS.add
class PythonJoint(JointType):
    leaves = "a function of your own returns what vanishes, see docs/your_own_laws.md"

    type: Literal["python"]
    function: str = Field(description='the file and the function in it: "cam.py:contact"')
    bodies: list[str] = Field(default=[], description='the names of the bodies that it gets, in order, or "ground"')
    joints: list[str] = Field(default=[], description="the names of the joints that it gets behind the bodies")
    parameters: dict[str, Number] = Field(default={}, description="numbers that it gets by name: { radius = 0.1 }")
    level: Literal["position", "velocity"] = Field(
        default="position", description='what it restricts: "position", or "velocity" (a rolling disc)'
    )
    rows: list[Literal["m", "rad"]] | None = Field(
        default=None, description='the unit of each equation, "m" or "rad" (or omit it: m)'
    )

    def ends(self, names: Names) -> tuple[int, ...]:
        return tuple(names.bodies[name] for name in self.bodies)

    def to_model(self, names: Names) -> Joint:
        letters = {"m": "m", "rad": "r"}
        rows = "".join(letters[row] for row in self.rows or [])
        place = f"model.joints.{self.name}"
        code = names.code(
            place,
            self.function,
            [*self.bodies, *self.joints],
            self.parameters,
            returns=rows,
            level=self.level,
            joints=tuple(names.joints[name] for name in self.joints),
        )
        return Joint(self.name, self.type, self.ends(names), numbers={**self.parameters}, code=code)

    @classmethod
    def example_keys(cls) -> dict[str, Any]:
        own = {"function": "cam.py:touches", "bodies": ["first"], "parameters": {"radius": 1.0}}
        return {**super().example_keys(), **own}

    @classmethod
    def example(cls) -> dict[str, Any]:
        data = super().example()
        data["model"]["bodies"][0]["velocity"] = [0.1, 0.2, 0.0]
        return {**data, "files": {"cam.py": CAM}}
