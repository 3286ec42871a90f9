"""Report runs with many short steps that a tolerance chose, with the usual reasons."""

import numpy as np

from lienumba.batch.statuses import SUCCESS
from lienumba.engine.requirements import Column
from lienumba.integrators.methods import METHODS
from lienumba.scenario.checks.integrator import relative_of
from lienumba.scenario.resolve import Scenario
from lienumba.scenario.schema.scenario import Tolerance

MANY = 10_000  # steps of a run
OWN = 0.5  # of max_step: longer steps are as long as the scenario lets them be
EPSILON = float(np.finfo(float).eps)


def attributes(resolved: Scenario, labels: np.ndarray, column: Column) -> dict[str, str]:
    """Return the attribute `short_steps` of the dataset: a sentence on the run with the most steps, or nothing."""
    integrator = resolved.data.integrator
    tolerance = integrator.tolerance
    if tolerance is None or not len(labels):
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
    jumps = "a force jumps back and forth where it holds the motion: give it a slope there, such as tanh(rate/1e-3)"
    said = (
        f"{integrator.method} took {int(steps[worst]):,} steps{which}, {length:.2g} s long in the mean; if nothing "
        f"moves or vibrates in so short a time, {reason}{_rounding(tolerance, length) or jumps}"
    )
    return {"short_steps": said}


def _rounding(tolerance: Tolerance | float, length: float) -> str:
    """Of steps so short (s) that the tolerance of rates is below the rounding of the state over a step, of which
    shorter steps have more: what is to be done; else nothing."""
    relative = relative_of(tolerance)
    absolute = tolerance.absolute.velocity if isinstance(tolerance, Tolerance) else None
    noise, allowed = EPSILON / length, relative + (relative if absolute is None else absolute)
    if noise < allowed:
        return ""
    return (
        f"the estimated errors are rounding: that of a position of 1 m is {noise:.1g} m/s over a step, and the "
        f"tolerance allows {allowed:.1g} m/s, which no shorter step reaches; give a larger integrator.tolerance"
    )
