"""A tree at an instant."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

from lienumba.mechanics.mechanism.kinematics import Instant, Modes
from lienumba.mechanics.mechanism.model import Model
from lienumba.mechanics.system.switches import resting
from lienumba.mechanics.tree.links import Tree
from lienumba.mechanics.tree.locking import free
from lienumba.mechanics.tree.motion import Moving, bodies_at, moving_links
from lienumba.numerics.number import Number


@dataclass(frozen=True)
class Posture:
    """A tree at an instant: z, the state of its moves; waiting: see `articulated.Reduction`; locks: the masks of rows
    of C that hold rates (see `locking`); the rest as in `kinematics.Instant`."""

    model: Model
    tree: Tree
    z: Sequence[Number]
    t: Any = 0.0
    angles: Mapping[Any, Any] = field(default_factory=dict)
    within: Any = None
    states: Mapping[str, tuple[Any, ...]] = field(default_factory=dict)
    waiting: int = 0
    modes: Modes = field(default_factory=dict)
    locks: Mapping[int, Any] = field(default_factory=dict)

    @cached_property
    def free(self) -> dict[int, Any]:
        """See `locking.free`."""
        return free(self.model, self.tree, self.locks)

    @cached_property
    def links(self) -> list[Moving]:
        return moving_links(self.tree, tuple(self.z))

    def resting(self) -> "Posture":
        """The mechanism with no joint sliding with friction."""
        return replace(self, modes=resting(self.modes))

    @cached_property
    def now(self) -> Instant:
        """The bodies as the links carry them."""
        bodies = bodies_at(self.tree, self.links)
        return Instant(bodies, self.t, dict(self.angles), self.within, dict(self.states), self.modes)
