"""Events whose time never comes are told before the run."""

from typing import Any

import pytest

import lienumba
from lienumba.scenario.start.never import warnings_of
from tests.facade import resolve

LATER = "and integrator.end_time = 3.0; give an earlier time, or a later end_time"
NEVER = "can never be true; correct it, or leave the event out"


def scenario(when: str, **more: Any) -> dict[str, Any]:
    """A body that flies, and an event."""
    body = {"name": "b", "mass": 1, "inertia": [1, 1, 1], "position": [0, 0, 0], "velocity": [1, 0, 0]}
    return {
        "title": "A flight",
        "parameters": {"late": 4.0, "later": "2*late"},
        "model": {
            "bodies": [body],
            "gravity": [0, 0, 0],
            "forces": [{"type": "force", "body": "b", "value": [0, 0, "later"]}],
        },
        "quantities": [{"name": "b", "type": "point", "body": "b"}],
        "events": [{"name": "e", "when": when}],
        "integrator": {"tolerance": 1e-6, "end_time": 3.0},
    } | more


def told(when: str, **more: Any) -> list[str]:
    return [str(x) for x in warnings_of(resolve(scenario(when, **more)))]


@pytest.mark.parametrize(
    ("when", "rule"),
    [
        ("t > 12", f"comes true behind 12 s, {LATER}"),
        ("t > 3", f"comes true behind 3 s, {LATER}"),
        ("b.x > 1 and t > later", f"comes true behind 8 s, {LATER}"),
        ("not (b.x > 1 or t < 2*later - 1)", f"comes true behind 15 s, {LATER}"),
        ("4 < t < 5", f"comes true behind 4 s, {LATER}"),
        ("t > 2 and t < 1", NEVER),
        ("t < 0", NEVER),
        ("t > 1 and late > 5", NEVER),
    ],
)
def test_a_time_that_no_run_lives_to_see_is_told(when: str, rule: str) -> None:
    assert told(when) == [f'events.e.when = "{when}": {rule}']


@pytest.mark.parametrize(
    "when",
    ["t >= 3", "t <= 0", "t > 12 or b.x > 1", "2 < t < 2.5", "t > 2*b.x", "sin(t) > 2", "b.x > 9", "t > 12 - 2.5*late"],
)
def test_what_may_come_is_not(when: str) -> None:
    assert told(when) == []


@pytest.mark.parametrize(("low", "says"), [(2.9, []), (3.1, ["events.e.when"])])
def test_what_is_swept_is_looked_at_in_all_runs(low: float, says: list[str]) -> None:
    vary = {"parameters.late": {"distribution": "uniform", "low": low, "high": 9.0}}
    found = told("t > late", sweep={"runs": 300, "seed": 1, "vary": vary})
    assert [x.partition(" ")[0] for x in found] == says
    assert all("s at the earliest of all runs" in x for x in found)


def test_a_parameter_that_another_event_sets_may_be_anything() -> None:
    early = {"name": "early", "when": "b.x > 1", "action": "set", "parameters": {"late": 0.0}}
    events = [{"name": "e", "when": "t > later"}, early]
    assert told("", events=events) == []


def test_it_is_told_by_a_run_and_by_a_study_if_no_point_is_long_enough() -> None:
    with pytest.warns(UserWarning, match="comes true behind 12 s"):
        lienumba.run(scenario("t > 12"))
    for ends, count in ([3.0, 15.0], 0), ([3.0, 6.0], 1):
        study = {"grid": [{"integrator.end_time": ends}], "reference": {"tolerance": 1e-9}}
        assert len(told("t > 12", study=study)) == count
