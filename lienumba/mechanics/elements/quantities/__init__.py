"""What can be seen of a mechanism, by name: one class for each type. `QUANTITIES` knows them by name."""

from lienumba.mechanics.elements.quantities import built_in
from lienumba.mechanics.elements.quantities.base import (
    OBSERVED,
    POSITION,
    QUANTITIES,
    VELOCITY,
    XYZ,
    Observed,
    Part,
    joined,
)
from lienumba.mechanics.elements.quantities.evaluation import (
    angle_joints,
    bodies_of,
    component,
    components,
    conditions,
    evaluate,
    level,
    observe,
    parts,
    rows,
)

__all__ = [
    "OBSERVED", "POSITION", "QUANTITIES", "VELOCITY", "XYZ", "Observed", "Part", "angle_joints", "bodies_of",
    "built_in", "component", "components", "conditions", "evaluate", "joined", "level", "observe", "parts", "rows",
]  # fmt: skip
