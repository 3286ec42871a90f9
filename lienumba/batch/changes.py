"""What the changes of a mechanism within a run are called."""

from dataclasses import dataclass

from lienumba.integrators import codes


@dataclass(frozen=True)
class Kind:
    """code: see `codes`; words: what happened, behind the name of the event or switch."""

    code: int
    name: str
    words: str

    @property
    def of_event(self) -> bool:
        """Whether it is told of the event that made it, not of the switch."""
        return self.code <= codes.SET


KINDS = (
    Kind(codes.LOCKED, "locked", "locked a joint"),
    Kind(codes.RELEASED, "released", "released a joint"),
    Kind(codes.ENGAGED, "engaged", "engaged a joint"),
    Kind(codes.SET, "set", "set numbers"),
    Kind(codes.IMPACT, "impact", "was hit"),
    Kind(codes.CLOSED, "closed", "closed"),
    Kind(codes.OPENED, "opened", "opened"),
    Kind(codes.STUCK, "stuck", "began to stick"),
    Kind(codes.SLID, "slid", "began to slide"),
)
KIND_OF = {kind.code: kind for kind in KINDS}
NAMES = tuple(kind.name for kind in KINDS)
NONE = -1  # in the place of a change that a run has not
