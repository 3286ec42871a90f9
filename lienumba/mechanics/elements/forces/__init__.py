"""Forces: one class for each type, with its keys and its mathematics. `FORCES` knows them by name."""

from lienumba.mechanics.elements.forces import built_in, compliant, python
from lienumba.mechanics.elements.forces.base import FORCES, law_of

__all__ = ["FORCES", "built_in", "compliant", "law_of", "python"]
