"""Forces: one class for each type, with its keys and its mathematics. `FORCES` knows them by name."""

from lienumba.mechanics.elements.forces import built_in, python
from lienumba.mechanics.elements.forces.base import FORCES, law_of

__all__ = ["FORCES", "built_in", "law_of", "python"]
