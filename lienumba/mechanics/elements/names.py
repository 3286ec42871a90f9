"""What stands behind the names of a scenario: the indices by which a model knows bodies and joints."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

from lienumba.mechanics.mechanism.model import GROUND, Coordinate

if TYPE_CHECKING:
    from lienumba.mechanics.elements.joints.base import JointType


@dataclass(frozen=True)
class Names:
    """bodies: the names of all, in their order; joints: all by their names, in their order."""

    bodies: tuple[str, ...]
    joints: "Mapping[str, JointType]"

    @cached_property
    def _bodies(self) -> dict[str, int]:
        return {name: i for i, name in enumerate(self.bodies)} | {"ground": GROUND}

    @cached_property
    def _joints(self) -> dict[str, int]:
        return {name: i for i, name in enumerate(self.joints)}

    def body(self, name: str) -> int:
        """The index of a body."""
        return self._bodies[name]

    def ends(self, names: Iterable[str]) -> tuple[int, ...]:
        """The indices of bodies."""
        return tuple(map(self.body, names))

    def joint(self, name: str) -> int:
        """The index of a joint."""
        return self._joints[name]

    def ends_of_joint(self, name: str) -> tuple[int, ...]:
        """The bodies of a joint."""
        return self.joints[name].ends(self)

    def coordinate(self, joint: str, kind: str | None) -> Coordinate:
        """A coordinate of a joint; its only one where no kind is given."""
        return Coordinate(self.joint(joint), kind or self.joints[joint].coordinate_kinds[0])
