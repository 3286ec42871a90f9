"""Warnings about results: good runs whose certificates show that they are not accurate, and laws that became undefined.

A run that ends well may still be wrong: a step that is too long changes the energy, though nothing works. Each rule
looks at one certificate that every run has, and names the runs and the remedy.
"""

import numpy as np

from lienumba.batch.statuses import GOOD, NON_FINITE, UNDEFINED
from lienumba.engine.quality import short_steps
from lienumba.engine.quality.undefined_laws import first_undefined
from lienumba.engine.requirements import Column
from lienumba.engine.simulate import Runs
from lienumba.scenario.resolve import Scenario
from lienumba.store.form import WARNINGS
from lienumba.store.layout import RELATIVE_DRIFT

ENERGY_RTOL = 1e-3  # of the exchanged energy: errors of the motion of 1 % nearly always come with more
REJECTED = 1000  # steps of a run from which on it is told that most were rejected
SHOWN = 5  # labels


def attributes(resolved: Scenario, runs: Runs, column: Column) -> dict[str, str]:
    """What the dataset says of its runs: nothing, or a sentence for each rule, and one on short steps."""
    if not len(runs.labels):
        return {}
    told = short_steps.attributes(resolved, runs.labels, column)
    status = column("status", runs.labels)
    good, undefined = np.isin(status, GOOD), np.isin(status, (NON_FINITE, UNDEFINED))
    found = [*_energy(resolved, runs.labels, column, good), *_rejected(runs.labels, column, good)]
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
