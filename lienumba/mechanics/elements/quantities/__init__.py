"""What can be seen of a mechanism, by name: one class for each type. `QUANTITIES` knows them by name."""

from lienumba.mechanics.elements.quantities import built_in, switched
from lienumba.mechanics.elements.quantities.base import (
    INPUT_FORMS,
    INPUTS,
    NOISES,
    OBSERVED,
    POSITION,
    QUANTITIES,
    VELOCITY,
    XYZ,
    Observed,
    Part,
    Readable,
    is_input,
    joined,
    kind_of,
    owner,
)
from lienumba.mechanics.elements.quantities.evaluation import (
    bodies_of,
    component,
    components,
    conditions,
    counted_angles,
    evaluate,
    integrands,
    level,
    observe,
    parts,
    rows,
    units,
)

__all__ = [
    "INPUTS", "INPUT_FORMS", "NOISES", "OBSERVED", "POSITION", "QUANTITIES", "VELOCITY", "XYZ", "Observed", "Part",
    "Readable", "bodies_of", "built_in", "component", "components", "conditions", "counted_angles", "evaluate",
    "integrands", "is_input", "joined", "kind_of", "level", "observe", "owner", "parts", "rows", "switched", "units",
]  # fmt: skip
