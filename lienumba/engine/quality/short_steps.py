"""Report runs with many short steps that a tolerance chose, with the two usual reasons."""

import numpy as np

from lienumba.batch.statuses import SUCCESS
from lienumba.engine.requirements import Column
from lienumba.integrators.methods import METHODS
from lienumba.scenario.resolve import Scenario

MANY = 10_000  # steps of a run
OWN = 0.5  # of max_step: longer steps are as long as the scenario lets them be


def attributes(resolved: Scenario, labels: np.ndarray, column: Column) -> dict[str, str]:
    """Return the attribute `short_steps` of the dataset: a sentence on the run with the most steps, or nothing."""
    integrator = resolved.data.integrator
    if integrator.tolerance is None:
        return {}
    steps = np.where(column("status", labels) == SUCCESS, column("steps", labels), 0)
    worst = int(steps.argmax())
    if steps[worst] < MANY:
        return {}
    length = integrator.end_time / int(steps[worst])
    if integrator.max_step is not None and length >= OWN * integrator.max_step:
        return {}
    which = f" in run {int(labels[worst])}" if resolved.data.sweep.runs > 1 else ""
    stiff = 'the scenario is stiff (strong springs, dampers or gains): try method = "radau5"; or '
    reason = "" if METHODS[integrator.method].implicit else stiff
    said = (
        f"{integrator.method} took {int(steps[worst]):,} steps{which}, {length:.2g} s long in the mean; if nothing "
        f"moves or vibrates in so short a time, {reason}a force jumps back and forth where it holds the motion: give "
        "it a slope there, such as tanh(rate/1e-3)"
    )
    return {"short_steps": said}
