"""Events that no run lives to see: what their conditions ask of the time comes true behind its end, or never."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from lienumba.errors import Problem
from lienumba.mechanics.system.discontinuities import Discontinuity, line_of
from lienumba.numerics.expressions import Formula
from lienumba.scenario.formulas.parameters import TIME
from lienumba.scenario.resolve import Scenario
from lienumba.scenario.start.design import draw

LOOKED_AT = 1000  # runs


def warnings_of(scenario: Scenario) -> list[Problem]:
    """All that is told of a scenario before it runs."""
    points = [scenario] if scenario.plan is None else [point.scenario for point in scenario.plan.points]
    events = [event.name for event in scenario.data.model.events]
    return [*scenario.warnings, *(said for name in events if (said := _never(name, points)) is not None)]


def _never(name: str, points: Sequence[Scenario]) -> Problem | None:
    """What is said of an event that comes true at no point of a study; without one there is one point."""
    earliest = np.inf
    for point in points:
        event = next(event for event in point.data.model.events if event.name == name)
        formula = point.parameters.places.get(("events", name, "when")) or Formula(event.when, condition=True)
        if TIME not in formula.used:
            return None
        varied = {paths.removeprefix("parameters.") for paths in point.data.sweep.vary}
        swept = varied & (formula.used | point.parameters.all_used(formula))
        comes = _comes(formula, point, draw(point, point.labels[:LOOKED_AT]) if swept else {})
        if comes is None:
            return None
        earliest = min(earliest, comes)
    end = max(point.data.integrator.end_time for point in points)
    rule, remedy = "can never be true", "correct it, or leave the event out"
    if np.isfinite(earliest):
        several = len(points) > 1 or bool(points[0].data.sweep.vary)
        rule = f"comes true behind {earliest:.12g} s{' at the earliest of all runs' if several else ''}"
        rule, remedy = f"{rule}, and integrator.end_time = {end!r}", "give an earlier time, or a later end_time"
    return Problem(f"events.{name}.when", rule, remedy, formula.text)


def _comes(formula: Formula, scenario: Scenario, samples: Mapping[str, Any]) -> float | None:
    """Behind which time (s), later than its end, a condition may first hold in any run, as far as it compares times;
    infinite if never, and None if it may hold before the end. What varies otherwise may do as it likes."""
    end, parameters, values = (
        scenario.data.integrator.end_time,
        scenario.parameters,
        scenario.parameters.values(samples),
    )
    held = {name for name, made in parameters.formulas.items() if parameters.all_used(made) & parameters.held}
    numbers = {name: values[name] for name in (formula.used & values.keys()) - parameters.held - held}
    state = formula.used - numbers.keys() - {TIME}
    runs = max([1, *(np.size(x) for x in numbers.values())])
    knots = [np.zeros((runs, 1)), np.full((runs, 1), end)]
    for line in formula.switches(state):
        knots.append(Discontinuity(np.zeros(1), *line_of(line, numbers)).times(runs))
    times = np.concatenate(knots, axis=1)
    times = np.sort(np.where(np.isfinite(times) & (times > 0.0), times, 0.0), axis=1)
    behind = np.append(times[:, 1:], 2.0 * times[:, -1:], axis=1)
    earliest = np.inf
    for begin, following in zip(times.T, behind.T, strict=True):
        for t in (begin, 0.5 * (begin + following)):
            holds = formula.may_hold(t, state, numbers) & np.ones(runs, bool)
            if np.any(holds & (t <= end)):
                return None
            earliest = min([earliest, *begin[holds]])
    return earliest
