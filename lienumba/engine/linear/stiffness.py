"""Whether it was stability that made steps of an explicit method short: said once, behind a sweep with a tolerance.

Linear systems at some times of the runs with the most steps say how long steps may be before what has died out grows
again. Where a run took about as many steps as that asks for, and nothing that is still alive is nearly as fast, its
mechanism is stiff. Nothing is asked of kernels, and of runs whose steps are as short as their motion wants, nothing.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from lienumba.batch.statuses import SUCCESS
from lienumba.engine.linear.course import Column, course
from lienumba.engine.simulate import Runs
from lienumba.errors import ScenarioError
from lienumba.integrators.methods import METHODS
from lienumba.integrators.methods.stability import polynomial, reach
from lienumba.integrators.tracing.linear.freedoms import FreedomTracer
from lienumba.integrators.tracing.linear.outputs import LinearOutputs
from lienumba.integrators.tracing.linear.systems import Recorded, States
from lienumba.integrators.tracing.template import split
from lienumba.mechanics.system.discontinuities import discontinuities
from lienumba.scenario.checks.integrator import order_of, relative_of
from lienumba.scenario.resolve import Scenario, resolve
from lienumba.scenario.start.prepare import Prepared, prepare

RUNS = 3  # that are looked at: those with the most steps
LEAST, FEW = 1000, 5  # steps of all runs, below which nobody waits for them; more where there are more bodies
MANY, SEVERAL = 100_000, 200  # steps of all runs for which one waits although none has more than so many
# Of a turn in a step that accuracy alone would allow, tolerance^(1/order) rad: below, something else is fast.
SLOW = 0.5
DEAD = 30.0  # time constants in a run, after which a mode has died out
APART = 10.0  # by so much what has died out is faster than what has not
FEWEST, MOST = 0.5, 2.0  # steps, of those that stability asks for
ENDED = 4.0  # steps for each time on which one has to end, below which these are the reason
INSTEAD = "radau5"


@dataclass(frozen=True)
class Held:
    """A run (label) whose steps were held short: how many, how many stability asks for, their mean length (s), and how
    fast (1/s) what it is about dies out."""

    label: int
    steps: int
    asked: float
    length: float
    rate: float


def attributes(resolved: Scenario, runs: Runs, column: Column) -> dict[str, str]:
    """What the dataset says of it: nothing, or a sentence by the name "stiff"."""
    held = held_short(resolved, runs, column)
    return {} if held is None else {"stiff": _sentence(resolved, held)}


def held_short(resolved: Scenario, runs: Runs, column: Column) -> Held | None:
    """Of the runs that are looked at, the first that was held short by stability."""
    integrator, labels, bodies = resolved.data.integrator, runs.labels, len(resolved.data.model.bodies)
    method = METHODS[integrator.method]
    if integrator.tolerance is None or method.implicit or not len(labels):
        return None
    steps, end = column("steps", labels), integrator.end_time
    some = np.sort(np.argsort(-steps, kind="stable")[:RUNS])
    some = some[column("status", labels[some]) == SUCCESS]
    least = LEAST if steps.sum() < MANY else SEVERAL
    if not len(some) or steps[some].max() < least or steps.sum() < LEAST * max(1.0, bodies / FEW) ** 2:
        return None
    runs, steps = runs.part(some), steps[some]
    times, states, fastest = course(resolved, column, runs.labels)
    order = order_of(integrator) or method.order
    quiet = fastest * end <= SLOW * relative_of(integrator.tolerance) ** (1.0 / order) * steps
    if not quiet.any():
        return None
    prepared = prepare(resolved, runs.labels.tolist(), runs.samples, runs.nominal, len(labels))
    ends = [x.times(len(some)) for x in discontinuities(prepared.model, end)]
    quiet &= steps >= ENDED * sum(((t > 0.0) & (t < end)).sum(axis=1) for t in ends)
    if not quiet.any():
        return None
    moments = [(0.0, np.asarray(prepared.states)), *zip(times, states, strict=True)]
    found = list(_allowed(prepared, moments, polynomial(method, order), end))
    asked = np.mean([end / allowed for allowed, _ in found], axis=0)
    fits = quiet & (steps >= FEWEST * asked) & (steps <= MOST * asked)
    for n in np.flatnonzero(fits):
        rate = max(float(rates[n]) for _, rates in found)
        return Held(int(runs.labels[n]), int(steps[n]), float(asked[n]), end / steps[n], rate)
    return None


def _allowed(
    prepared: Prepared, moments: Sequence[tuple[float, np.ndarray]], R: np.ndarray, end: float
) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """At each of these times and states of bodies: the longest step (s) that is stable, infinite where no mode that has
    died out is much faster than all others; and the rate (1/s) of the fastest."""
    tracer, runs = FreedomTracer.of(prepared.model), len(prepared.labels)
    recorded, numbers = Recorded.of(tracer, LinearOutputs((), ()), prepared.model), split(prepared.model)[1]
    for t, bodies in moments:
        rows = tracer.rows_at_start(prepared.model, bodies, prepared.angles)
        states = States(np.asarray(prepared.labels), np.ones(runs, bool), t, rows, numbers)
        allowed, rates = np.full(runs, np.inf), np.zeros(runs)
        for system in recorded.systems(states):
            for run, values in zip(system.runs, system.eigenvalues(), strict=True):  # of a disc that lies flat NaN
                allowed[run], rates[run] = _longest(values, R, end)
        yield allowed, rates


def _longest(values: np.ndarray, R: np.ndarray, end: float) -> tuple[float, float]:
    """The longest stable step (s) for what dies out, and its rate (1/s)."""
    sizes, dead = np.abs(values), values.real * end < -DEAD
    if not dead.any():
        return np.inf, 0.0
    lengths = reach(R, values[dead] / sizes[dead]) / sizes[dead]
    worst = int(lengths.argmin())
    if sizes[~dead].max(initial=0.0) * APART > sizes[dead][worst]:
        return np.inf, 0.0
    return float(lengths[worst]), float(sizes[dead][worst])


def _sentence(resolved: Scenario, held: Held) -> str:
    which = f" in run {held.label}" if resolved.data.sweep.runs > 1 else ""
    method = resolved.data.integrator.method
    return (
        f"{method} took {held.steps:,} steps{which}, {held.length:.2g} s long in the mean; its "
        f"stability asks for some {float(f'{held.asked:.1g}'):,.0f}, because what dies out at up to "
        f"{held.rate:.1g} 1/s would grow again in longer ones. The scenario is stiff: {_instead(resolved)}"
    )


def _instead(resolved: Scenario) -> str:
    try:
        resolve(resolved.to_dict(), overrides={"integrator.method": INSTEAD})
    except ScenarioError as error:
        return f'method = "{INSTEAD}" would not care, but does not take it: {error}'
    return f'try method = "{INSTEAD}"'
