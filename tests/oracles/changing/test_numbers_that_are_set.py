"""Numbers that events set: each event sees what those before it have set, and no condition remembers old numbers."""

from typing import Any

import numpy as np
import pytest

import lienumba
from tests.rigs import parts

STONE = parts.body("stone", 1.0, 0.01, position=[0, 0, 0], rotation=[1, 0, 0, 0], velocity=[0, 0, 9.81])
METHODS = [{"tolerance": 1e-10}, {"method": "rk4", "step": 0.01}, {"method": "radau5", "tolerance": 1e-9}]


@pytest.mark.parametrize("integrator", METHODS)
@pytest.mark.parametrize("coordinates", ["lie", "joint"])
def test_a_timer_runs_from_the_time_that_was_set(integrator: dict[str, Any], coordinates: str) -> None:
    """The stone is at its top at 1 s. Before that `t_top` is as large as its writer liked."""
    never = [1e3, 1e9, 1e12, 1e15]
    events = [
        {"name": "top", "when": "v.z < 0", "action": "set", "parameters": {"t_top": "t"}, "once": True},
        {"name": "later", "when": "t > t_top + 1.5", "action": "record"},
        {"name": "sum", "when": "1 + t - t_top > 2.25", "action": "record"},
    ]
    ds = lienumba.run({
        "parameters": {"t_top": 1.0},
        "model": {"gravity": [0, 0, -9.81], "bodies": [STONE]},
        "quantities": [{"name": "v", "type": "point", "body": "stone", "derivative": 1}],
        "events": events,
        "integrator": {"end_time": 4, "coordinates": coordinates, **integrator},
        "sweep": {"sampler": "table", "table": {"columns": {"parameters.t_top": never}}},
    })  # fmt: skip
    assert (ds.status == 0).all()
    np.testing.assert_allclose(ds.event_time, [[1.0, 2.5, 2.25]] * len(never), rtol=0, atol=1e-9)


@pytest.mark.parametrize("integrator", METHODS)
@pytest.mark.parametrize(("at", "force"), [(0.5, (8.0, 10.0)), (-1.0, (10.0, 10.0))])
def test_events_at_one_time_see_what_those_before_them_have_set(
    integrator: dict[str, Any], at: float, force: tuple[float, float]
) -> None:
    """n = 4 becomes 3, by which k = 2 n is 6, and then k - 1; at 0.5 s, and as the run begins."""
    push = {"type": "force", "body": "stone", "value": ["k", 0, 0]}
    first, second = ({"name": x, "when": f"t > {at}", "action": "set"} for x in ("first", "second"))
    ds = lienumba.run({
        "parameters": {"n": 4, "k": "2*n"},
        "model": {"gravity": [0, 0, 0], "bodies": [STONE], "forces": [push]},
        "events": [first | {"parameters": {"n": "n - 1"}}, second | {"parameters": {"n": "k - 1"}}],
        "measures": [{"name": "left", "value": "final(n)"}],
        "integrator": {"end_time": 2.0, **integrator},
    })  # fmt: skip
    assert ds.status.item() == 0
    assert ds["left"].item() == 5.0
    way = 0.5 * force[0] * 0.25 + force[0] * 0.5 * 1.5 + 0.5 * force[1] * 2.25
    assert ds.position.values[0, -1, 0, 0] == pytest.approx(way, rel=1e-9)


@pytest.mark.parametrize("integrator", [*METHODS, {"method": "dp54", "tolerance": 1e-6}])
@pytest.mark.parametrize(
    ("when", "parameters"), [("t > next", {"next": "next + 0.1"}), ("x.x > next", {"next": "x.x + 0.1"})]
)
def test_a_timer_that_sets_itself_ticks(integrator: dict[str, Any], when: str, parameters: dict[str, str]) -> None:
    """Every 0.1 s, or 0.1 m at 1 m/s, however long the steps are."""
    ds = lienumba.run({
        "parameters": {"next": 0.1},
        "model": {"gravity": [0, 0, 0], "bodies": [STONE | {"velocity": [1, 0, 0]}]},
        "quantities": [{"name": "x", "type": "point", "body": "stone"}],
        "events": [{"name": "tick", "when": when, "action": "set", "parameters": parameters}],
        "integrator": {"end_time": 2.95, **integrator},
    })  # fmt: skip
    assert ds.status.item() == 0
    assert ds.event_count.item() == 29


@pytest.mark.parametrize("integrator", METHODS)
@pytest.mark.parametrize("threshold", [1e12, 1e15])
def test_a_threshold_that_is_set_to_where_it_is_acts_from_there_on(
    integrator: dict[str, Any], threshold: float
) -> None:
    events = [
        {"name": "mark", "when": "t > 1", "action": "set", "parameters": {"threshold": "x.x"}, "once": True},
        {"name": "beyond", "when": "x.x > threshold", "action": "record"},
    ]
    ds = lienumba.run({
        "parameters": {"threshold": threshold},
        "model": {"gravity": [0, 0, 0], "bodies": [STONE | {"velocity": [1, 0, 0]}]},
        "quantities": [{"name": "x", "type": "point", "body": "stone"}],
        "events": events,
        "integrator": {"end_time": 2.0, **integrator},
    })  # fmt: skip
    np.testing.assert_allclose(ds.event_time[0], [1.0, 1.0], rtol=0, atol=1e-6)
