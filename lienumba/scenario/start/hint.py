"""What is told of a scenario that is valid: in what it starts to move, and what would be faster."""

from lienumba.integrators.codes import FOUND, NONE_FOUND, UNSTABLE
from lienumba.integrators.methods.charts import JOINT, R3xSO3
from lienumba.mechanics.tree.links import moves_of
from lienumba.mechanics.tree.spanning import closing_rows, ties_of
from lienumba.scenario.start.prepare import Nominal

RESTS = {
    FOUND: "it starts in its equilibrium",
    NONE_FOUND: "no equilibrium was found in which the nominal run could start",
    UNSTABLE: "it starts in its equilibrium, which is unstable",
}
FEW, LEAST = 2, 2  # freedoms of a joint, and so many such joints: from there on its freedoms cost less than its rows


def hint(nominal: Nominal) -> str:
    """One sentence on the coordinates of the joints, where they pay; empty where another way was chosen on purpose."""
    integrator, projection, model = nominal.scenario.data.integrator, nominal.scenario.data.projection, nominal.model
    usual = integrator.coordinates == "lie" and integrator.group == R3xSO3.__name__
    if not usual or projection.chord or projection.position != "local" or projection.velocity == "none":
        return ""
    ties = [tie for tie in ties_of(model) if tie.joint is not None]
    freedoms = [sum(move.freedoms for move in moves_of(model, tie)) for tie in ties]
    number = sum(0 < freedom <= FEW for freedom in freedoms)
    if number < LEAST:
        return ""
    left = "only what closes loops, or is driven, is" if closing_rows(model) else "nothing has to be"
    saved = f"integrates {number} joints by their freedoms, several times faster; {left} projected"
    return f'integrator.coordinates = "{JOINT}" {saved}'
