"""How the probability that a margin is below 0 is estimated."""

from collections.abc import Callable

from lienumba.engine.rare.design_points import form
from lienumba.engine.rare.estimate import Estimate, Margins
from lienumba.engine.rare.importance import importance
from lienumba.engine.rare.subset import subset

METHODS: dict[str, Callable[[Margins, int, int, int, float], Estimate]] = {
    "subset": subset,
    "importance": importance,
    "form": form,
}
