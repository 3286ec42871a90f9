"""What beside the mechanism shapes the kernels: how it is integrated, projected and stored."""

from dataclasses import dataclass

from lienumba.integrators.methods import METHODS
from lienumba.integrators.methods.charts import GROUPS, Chart
from lienumba.integrators.methods.comparators import COORDINATES


@dataclass(frozen=True)
class Method:
    """What beside the mechanism shapes the kernels."""

    tableau: str
    position: str  # "local", "embedded" or "none"
    velocity: str  # one of projection.WEIGHTS, or "none"
    dexpinv: int | str | None = None  # terms of its series, or "closed"; None: as many as the method's order needs
    chord: bool = False  # whether the position projection keeps the elimination of its first iteration
    group: str = "R3xSO3"  # or another of GROUPS
    coordinates: str = "lie"  # or "joint", or one of COORDINATES
    baumgarte: float | None = None  # rate (1/s)
    queued: bool = False  # whether every lane has its own time and takes its runs from a queue
    adaptive: bool = False  # whether a tolerance chooses the steps; then lanes are queued, too
    reactions: bool = True  # whether what joints and drivers do is stored
    joint_coordinates: bool = False  # whether those of the whole mechanism are stored
    extended: bool = False  # whether what is between the ends of a step is read off its stages
    order: int = 0  # of series in time
    rho: float | None = None  # of the generalised-alpha method

    def chart(self) -> Chart:
        """A method of order p needs ad^j in dexpinv up to j = p - 2; one with several exponentials has no dexpinv."""
        return COORDINATES[self.coordinates] if self.coordinates in COORDINATES else GROUPS[self.group](self.terms)

    @property
    def terms(self) -> int | None:
        """The number of terms of the series of dexpinv; None for its closed form."""
        tableau = METHODS[self.tableau]
        terms = 0 if tableau.composed or tableau.series else max(tableau.order - 2, 0)
        return None if self.dexpinv == "closed" else int(terms if self.dexpinv is None else self.dexpinv)
