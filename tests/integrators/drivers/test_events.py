"""Events: found as exactly as the method integrates, run by run, and felt by nothing but what they stop."""

import copy
import tomllib
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import lienumba
from lienumba.analysis.summary import summarise
from lienumba.batch import statuses
from tests.facade import resolve
from tests.integrators.drivers.test_variable_step import equal

G, L = 9.81, 1.0
J, M = 0.1, 1.0
PENDULUM: dict[str, Any] = {  # let go at the height of its hinge
    "model": {
        "bodies": [{"name": "bob", "mass": M, "inertia": [J, J, J], "position": [L, 0, 0], "rotation": [1, 0, 0, 0]}],
        "joints": [{"name": "hinge", "type": "revolute", "bodies": ["ground", "bob"], "at": [0, 0, 0],
                    "axis": [0, 1, 0]}],
    },
    "quantities": [
        {"name": "tip", "type": "point", "body": "bob"},
        {"name": "swing", "type": "joint", "joint": "hinge"},
        {"name": "pull", "type": "reaction", "joint": "hinge"},
    ],
    "output": {"every": 0.25},
}  # fmt: skip
LOW = {"name": "low", "when": "tip.z < -0.5"}
LEFT = {"name": "left", "when": "tip.x < 0 and swing.rate > 0", "action": "stop"}


def pendulum(*events: dict[str, Any], **integrator: Any) -> dict[str, Any]:
    data = copy.deepcopy(PENDULUM)
    return data | {"events": list(events), "integrator": {"end_time": 3.0, **integrator}}


def run(data: dict[str, Any], **options: Any) -> Any:
    return lienumba.run(data, **{"workers": 1, **options})


def crossings(level: float, gravity: float = G) -> list[float]:
    """When sin(angle), the depth of the bob, passes a level downwards, by SciPy."""

    def deep(t: float, y: Any) -> float:
        return float(np.sin(y[0]) - level)

    deep.direction = 1.0  # type: ignore[attr-defined]

    def rates(t: float, y: Any) -> list[float]:
        return [y[1], M * gravity * L / (J + M * L * L) * np.cos(y[0])]

    found = solve_ivp(rates, (0, 3), [0, 0], "DOP853", events=deep, rtol=1e-13, atol=1e-13)
    return found.t_events[0].tolist()


def test_an_event_is_where_its_condition_has_just_become_true() -> None:
    """Not directly before: of a ball that falls, at 24 heights."""
    ball = {"name": "ball", "mass": 1.0, "inertia": [0.1] * 3, "position": [0, 0, 0], "rotation": [1, 0, 0, 0]}
    data = {
        "parameters": {"height": -1.0},
        "model": {"bodies": [ball]},
        "quantities": [{"name": "at", "type": "point", "body": "ball"}],
        "events": [{"name": "below", "when": "at.z < height"}],
        "integrator": {"method": "bs32", "tolerance": 1e-3, "end_time": 0.6},
        "output": {"at_events": ["at"], "mode": "summary", "every": 0.6},
        "sweep": {"runs": 24, "vary": {"parameters.height": {"distribution": "uniform", "low": -1.5, "high": -0.1}}},
    }
    ds = run(data)
    below = ds["parameters.height"] - ds["event_at"].isel(event=0).sel(axis="z")
    assert (below > 0.0).all()
    assert (below < 1e-13).all()


@pytest.mark.parametrize(("method", "order"), [("rk4", 4), ("bs32", 3), ("tsit54", 5), ("dop853", 8)])
def test_the_time_of_an_event_has_the_order_of_the_method(method, order):
    (truth, *_), errors = crossings(0.5), []
    steps = {3: (2e-2, 1e-2, 5e-3), 4: (4e-2, 2e-2, 1e-2), 5: (4e-2, 2e-2, 1e-2), 8: (0.3, 0.15, 0.075)}[order]
    for step in steps:
        end = 0.6 if order == 8 else 0.4
        ds = run(pendulum(LOW, step=step, method=method, end_time=end) | {"output": {"times": [0.0]}})
        errors.append(abs(float(ds.event_time[0, 0]) - truth))
    slopes = np.log2(np.array(errors[:-1]) / errors[1:])
    assert (slopes > order - 1.5).all(), errors
    assert errors[-1] < {3: 1e-5, 4: 1e-7, 5: 1e-8, 8: 1e-8}[order]


@pytest.mark.parametrize("how", [{"tolerance": 1e-11}, {"tolerance": 1e-10, "method": "dp54"},
                                 {"step": 1e-3, "method": "dop853"}])  # fmt: skip
def test_events_are_found_and_counted(how):
    ds = run(pendulum(LOW, LEFT | {"action": "record"}, {"name": "late", "when": "t > 1.23456"}, **how))
    times = crossings(0.5)
    assert ds.event.values.tolist() == ["low", "left", "late"]
    assert ds.event_count.values.tolist() == [[len(times), len(crossings(1.0 - 1e-12)) or 1, 1]]
    assert float(ds.event_time.sel(event="low")[0]) == pytest.approx(times[0], abs=1e-9)
    assert float(ds.event_time.sel(event="late")[0]) == pytest.approx(1.23456, abs=1e-14)
    assert int(ds.status[0]) == statuses.SUCCESS


@pytest.mark.parametrize("how", [{"tolerance": 1e-11}, {"step": 0.01, "method": "dop853"}])
def test_a_run_that_is_stopped_is_good_and_ends_there(how):
    data = pendulum(LEFT, LOW, {"name": "after", "when": "t > 0.6209"}, **how)
    ds = run(data, workers=None)
    assert ds.status.values.tolist() == [statuses.STOPPED]
    quarter = float(ds.event_time.sel(event="left")[0])
    assert quarter == float(ds.end_time[0]) == pytest.approx(0.62085340, abs=1e-8)
    assert ds.event_count.values.tolist() == [[1, 1, 0]]  # what would have come later in the same step has not
    assert np.isnan(ds.event_time.sel(event="after")[0])
    assert np.isfinite(ds.position.sel(time=[0, 0.25, 0.5])).all()
    assert np.isnan(ds.position.sel(time=slice(0.7, None))).all()
    assert (summarise(ds).good, summarise(ds).final) == (1, ())


@pytest.mark.parametrize("how", [{"tolerance": 1e-9}, {"step": 0.01}, {"step": 0.025, "method": "dop853"}])
def test_what_is_recorded_changes_nothing(how):
    """To the bit, also where steps are of one length and another driver makes them."""
    plain, watched = run(pendulum(**how)), run(pendulum(LOW, {"name": "late", "when": "t > 1"}, **how))
    assert equal(plain, watched[list(plain.data_vars)])


def test_conditions_may_read_reactions_and_be_true_at_once():
    heavy = {"name": "heavy", "when": "sqrt(pull.force.x**2 + pull.force.z**2) > 15"}
    at_once = {"name": "at_once", "when": "tip.x > 0.5"}
    ds = run(pendulum(heavy, at_once, tolerance=1e-10))
    times, force = ds.time.values, np.hypot(ds["pull.force"][0, :, 0], ds["pull.force"][0, :, 2]).values
    first = float(ds.event_time.sel(event="heavy")[0])
    assert times[force > 15][0] - 0.25 < first <= times[force > 15][0]
    exact = run(pendulum(tolerance=1e-10) | {"output": {"times": [first]}})
    assert np.hypot(*exact["pull.force"][0, 0].values[[0, 2]]) == pytest.approx(15, abs=1e-7)
    assert float(ds.event_time.sel(event="at_once")[0]) == 0.0
    stopped = run(pendulum(at_once | {"action": "stop"}, tolerance=1e-10))
    assert (int(stopped.status[0]), float(stopped.end_time[0])) == (statuses.STOPPED, 0.0)
    assert np.isfinite(stopped.position[0, 0]).all()
    assert np.isnan(stopped.position[0, 1:]).all()


@pytest.mark.parametrize("how", [{"tolerance": 1e-10}, {"step": 0.01, "method": "dop853"}])
def test_each_run_has_its_own_events(how):
    data = pendulum(LOW | {"when": "tip.z < -depth"}, LEFT, **how)
    data["parameters"] = {"depth": 0.5}
    gravity, depth = {"low": -15.0, "high": -1.0}, {"low": 0.2, "high": 0.8}
    vary = {"gravity[2]": gravity, "parameters.depth": depth}
    data["sweep"] = {"runs": 19, "vary": {path: {"distribution": "uniform", **ends} for path, ends in vary.items()}}
    ds = run(data)
    for n in range(19):
        times = crossings(float(ds["parameters.depth"][n]), -float(ds["gravity[2]"][n]))
        assert float(ds.event_time.sel(event="low")[n]) == pytest.approx(times[0], abs=1e-8)
    assert equal(ds, run(data, workers=2))
    assert equal(ds.isel(run=[11, 2]), run(data, runs=[11, 2]))
    both = {statuses.STOPPED} if (ds["gravity[2]"] < -1.0).all() else {statuses.STOPPED, statuses.SUCCESS}
    assert set(ds.status.values.tolist()) <= both


def test_a_scenario_with_events_comes_back_from_its_dataset():
    data = pendulum(
        LOW | {"when": "tip.z < -depth"}, LEFT, tolerance={"relative": 1e-9, "absolute": {"rotation": 1e-8}}
    )
    data["parameters"] = {"depth": 0.5}
    first = resolve(data)
    again = resolve(tomllib.loads(first.to_toml()))
    assert again.to_toml() == first.to_toml()
    assert again.sha256() == first.sha256()
    assert first.sha256() != resolve(data | {"events": [LEFT]}).sha256()
    assert equal(run(data), run(tomllib.loads(run(data).attrs["scenario"])))


def test_many_events_of_a_small_mechanism():
    """More of them than a state has rows."""
    times = [0.0125 * n + 0.001 for n in range(60)]
    events = [{"name": f"e{n}", "when": f"t > {t}"} for n, t in enumerate(times)]
    few = run(pendulum(LOW, tolerance=1e-6))
    ds = run(pendulum(LOW, *events, tolerance=1e-6))
    np.testing.assert_allclose(ds.event_time[0, 1:], times, atol=1e-13)
    equal(ds.drop_vars(["event", "event_time", "event_count"]), few.drop_vars(["event", "event_time", "event_count"]))
