"""Methods as records, the charts of their steps, the Munthe-Kaas step, and the control of its length."""

from lienumba.integrators.methods.classical import CLASSICAL
from lienumba.integrators.methods.generalized_alpha import GENERALIZED_ALPHA
from lienumba.integrators.methods.pairs import PAIRS
from lienumba.integrators.methods.radau import RADAU
from lienumba.integrators.methods.tableau import METHODS
from lienumba.integrators.methods.taylor import TAYLOR

__all__ = ["DEFAULT", "DEFAULT_PAIR", "METHODS"]

DEFAULT, DEFAULT_PAIR = "rk4", "dop853"  # with a step, with a tolerance

for tableau in (*CLASSICAL, *PAIRS, *RADAU, GENERALIZED_ALPHA, TAYLOR):
    METHODS.add(tableau)
