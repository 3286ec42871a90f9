"""What is known of a study before anything is compiled: its problems, their starts, and what is stated of them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, TypeVar

from lienumba.errors import ScenarioError
from lienumba.scenario.resolve import Scenario
from lienumba.scenario.start.prepare import Nominal, check_initial, design

if TYPE_CHECKING:
    import numpy as np

    from lienumba.scenario.study_errors import Truth
    from lienumba.scenario.study_points import Plan, Point

T = TypeVar("T")


def check_starts(scenario: Scenario) -> Nominal | None:
    """Check the initial state of a scenario, and return it; of a study those of its points, and the reference."""
    data = scenario.data
    if scenario.plan is None:
        return check_initial(scenario)
    for point in problems(scenario.plan):
        told(point, check_initial)
        labels = range(data.sweep.runs)
        stated(scenario, point, labels, design(point.scenario, labels))
    return None


def problems(plan: Plan) -> list[Point]:
    """The first point of every problem."""
    return list({point.problem: point for point in reversed(plan.points)}.values())[::-1]


def told(point: Point, act: Callable[[Scenario], T]) -> T:
    """What becomes of a point; errors name it."""
    try:
        return act(point.scenario)
    except ScenarioError as error:
        raise error.inside(point.place) from None


def stated(scenario: Scenario, point: Point, labels: Sequence[int], samples: dict[str, np.ndarray]) -> Truth | None:
    """What formulas or a file say of a problem; None where the reference is to be simulated."""
    from lienumba.scenario.checks import reference_formulas
    from lienumba.scenario.reading.datasets import read_reference
    from lienumba.scenario.study_errors import STATE

    data, own = scenario.data, point.scenario
    assert data.study is not None
    reference = data.study.reference
    if "file" in reference:
        return read_reference(reference, [body.name for body in data.model.bodies], labels, own.times, samples)
    if reference.keys() & set(STATE):
        return reference_formulas.truth(reference, own.parameters, samples, own.times)
    return None
