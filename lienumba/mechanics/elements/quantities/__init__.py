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
    bends,
    bodies_of,
    component,
    components,
    condition_rates,
    conditions,
    counted_angles,
    evaluate,
    flows,
    has_rate,
    leaps,
    level,
    moves,
    observe,
    parts,
    rows,
    units,
)
from lienumba.mechanics.elements.quantities.measured import followed, integrands, kept, lasting, signals, turning

__all__ = [
    "INPUTS", "INPUT_FORMS", "NOISES", "OBSERVED", "POSITION", "QUANTITIES", "VELOCITY", "XYZ", "Observed", "Part",
    "Readable", "bends", "bodies_of", "built_in", "component", "components", "condition_rates", "conditions",
    "counted_angles", "evaluate", "flows", "followed", "has_rate", "integrands", "is_input", "joined", "kept",
    "kind_of", "lasting", "leaps", "level", "moves", "observe", "owner", "parts", "rows", "signals", "switched",
    "turning", "units",
]  # fmt: skip
