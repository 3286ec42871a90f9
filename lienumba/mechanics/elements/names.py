"""What an element's keys ask for while they become a part of the model."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Protocol

from lienumba.keys.types import COORDINATE_KINDS
from lienumba.mechanics.mechanism.courses import Recorded, Recursion
from lienumba.mechanics.mechanism.model import Code, Coordinate
from lienumba.mechanics.mechanism.tables import Samples


class Names(Protocol):
    """The indices behind the names of a mechanism, and the code behind its functions.

    The keys themselves hold the numbers of the runs by then: each is a float, an array (runs,) where the sweep varies
    it, or where it may vary in time the text of a formula or a `Law` (see `lienumba.keys.conversions.timed`).
    """

    @property
    def bodies(self) -> Mapping[str, int]:
        """Of every body, "ground" included."""

    @property
    def joints(self) -> Mapping[str, int]: ...

    @property
    def drivers(self) -> Mapping[str, int]: ...

    def ends(self, joint: str) -> tuple[int, ...]:
        """The bodies of a joint."""

    def touching(self, contact: str) -> tuple[int, ...]:
        """The bodies of a contact."""

    def limited(self, limit: str) -> int:
        """The joint of a limit."""

    def coordinate(self, joint: str, kind: str | None, among: Sequence[str] = COORDINATE_KINDS) -> Coordinate:
        """A coordinate of a joint: the first, among those of these kinds, where its own is omitted."""

    def code(
        self,
        place: str,
        reference: str,
        seen: Sequence[str],
        parameters: Iterable[str],
        *,
        returns: str,
        level: str = "position",
        joints: tuple[int, ...] = (),
        states: Sequence[str] = (),
        memory: Sequence[tuple[str, int]] = (),
        every: float | None = None,
    ) -> Code:
        """The code of a law of the user's own; place: of the law in the scenario; reference: "arm.py:pd"; seen: what it
        gets, bodies before joints; parameters: their names."""

    def samples(self, name: str, source: Recursion | Recorded, every: float | None, held: bool) -> Samples:
        """The courses of a noise with these samples, every so many seconds; None: a single one."""
