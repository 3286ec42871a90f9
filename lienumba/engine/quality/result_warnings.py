"""Warnings about results: good runs whose certificates show that they are not accurate, and laws that became undefined.

A run that ends well may still be wrong: a step that is too long changes the energy, though nothing works. Each rule
looks at one certificate that every run has, and names the runs and the remedy. Beside them the dataset has a sentence
on a run with many short steps that a tolerance chose, with the usual reasons.
"""

import numpy as np

from lienumba.batch.statuses import GOOD, NON_FINITE, SUCCESS, UNDEFINED
from lienumba.engine import requirements
from lienumba.engine.quality.undefined_laws import first_undefined
from lienumba.engine.requirements import Column
from lienumba.engine.simulate import Runs
from lienumba.integrators.methods import METHODS
from lienumba.scenario.checks.integrator import relative_of
from lienumba.scenario.resolve import Scenario
from lienumba.scenario.schema.scenario import Tolerance
from lienumba.store.layout import RELATIVE_DRIFT, WARNINGS
from lienumba.store.names import FLAGS as SENSITIVITY_FLAGS

ENERGY_RTOL = 1e-3  # of the exchanged energy: errors of the motion of 1 % nearly always come with more
REJECTED = 1000  # steps of a run from which on it is told that most were rejected
SHOWN = 5  # labels
MANY_STEPS = 10_000  # of a run, from which on it is told that they are short
LONGEST_PART = 0.5  # of max_step: longer steps are as long as the scenario lets them be
EPSILON = float(np.finfo(float).eps)


def attributes(resolved: Scenario, runs: Runs, column: Column) -> dict[str, str]:
    """What the dataset says of its runs: verdicts on requirements, a sentence for each rule, and one on short steps."""
    told = requirements.attributes(resolved, runs.labels, column) if resolved.data.model.requirements else {}
    if not len(runs.labels):
        return told
    told |= _short_steps(resolved, runs.labels, column)
    status = column("status", runs.labels)
    good, undefined = np.isin(status, GOOD), np.isin(status, (NON_FINITE, UNDEFINED))
    found = [*_energy(resolved, runs.labels, column, good), *_rejected(runs.labels, column, good)]
    if resolved.data.sensitivities is not None:
        found += _doubtful(runs.labels, column)
    if undefined.any():
        found.append(first_undefined(resolved, runs, column, int(runs.labels[undefined][0])))
    return told | ({WARNINGS: "\n".join(filter(None, found))} if any(found) else {})


def _energy(resolved: Scenario, labels: np.ndarray, column: Column, good: np.ndarray) -> list[str]:
    drift = np.where(good, column(RELATIVE_DRIFT, labels), 0.0)
    which = drift > ENERGY_RTOL
    if not which.any():
        return []
    worst = int(drift.argmax())
    return [
        f"{RELATIVE_DRIFT} = {drift[worst]:.2g} in run {labels[worst]}, above {ENERGY_RTOL:g} in "
        f"{_runs(labels, which)}: energy is wrong by this part of what was exchanged, and the motion may be wrong by "
        f"more; {_remedy(resolved)}"
    ]


def _rejected(labels: np.ndarray, column: Column, good: np.ndarray) -> list[str]:
    rejected, steps = column("rejected_steps", labels), column("steps", labels)
    which = good & (rejected > steps) & (rejected > REJECTED)
    if not which.any():
        return []
    worst = int(np.where(which, rejected, 0).argmax())
    return [
        f"rejected_steps = {int(rejected[worst])} in run {labels[worst]}, more than were accepted in "
        f"{_runs(labels, which)}: a force jumps where no event says so, or the tolerance asks for less than roundoff; "
        "give the jump an event, or a larger integrator.tolerance"
    ]


def _doubtful(labels: np.ndarray, column: Column) -> list[str]:
    """What the flags of derivatives say."""
    from lienumba.batch.tangents.changes import FLAGS

    flags = column(SENSITIVITY_FLAGS, labels).astype(np.int64)
    return [
        f"{SENSITIVITY_FLAGS} has {bit} in {_runs(labels, flags & bit != 0)}: {meaning}"
        for bit, meaning in FLAGS.items()
        if (flags & bit).any()
    ]


def _remedy(resolved: Scenario) -> str:
    integrator = resolved.data.integrator
    if integrator.step is None:
        return "give a smaller integrator.tolerance"
    return f"give a smaller integrator.step than {integrator.step:g} s, or a tolerance"


def _runs(labels: np.ndarray, which: np.ndarray) -> str:
    """How many of all, and the first labels."""
    some, count = labels[which].tolist(), int(which.sum())
    shown = ", ".join(map(str, some[:SHOWN])) + (", ..." if count > SHOWN else "")
    return f"{count:,} of {len(labels):,} runs ({shown})"


def _short_steps(resolved: Scenario, labels: np.ndarray, column: Column) -> dict[str, str]:
    """Return the attribute `short_steps` of the dataset: a sentence on the run with the most steps, or nothing."""
    integrator = resolved.data.integrator
    tolerance = integrator.tolerance
    if tolerance is None or not len(labels):
        return {}
    steps = np.where(column("status", labels) == SUCCESS, column("steps", labels), 0)
    worst = int(steps.argmax())
    if steps[worst] < MANY_STEPS:
        return {}
    length = integrator.end_time / int(steps[worst])
    if integrator.max_step is not None and length >= LONGEST_PART * integrator.max_step:
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
