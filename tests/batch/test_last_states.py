"""The state where a run ended, by both drivers: that which a dataset would hold at that time, to the bit."""

import copy
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from lienumba.batch import execute, statuses
from lienumba.batch.records import per_run
from tests.integrators.drivers.test_events import LOW, pendulum
from tests.rigs.sweeps import edit_samples, loop, run, top

NEVER = {"name": "never", "when": "sin(t) > 2"}  # an event brings steps of one length to the driver of free lanes
PACES = [{}, {"events": [NEVER]}, {"tolerance": 1e-7}]


def ended(data: dict[str, Any], monkeypatch: pytest.MonkeyPatch, **options: Any) -> Any:
    """The dataset; where its runs began, what was stored of their states, and where they ended (runs, rows)."""
    found: list[tuple[np.ndarray, ...]] = []
    original = execute.integrate

    def watched(batch: Any, runs: slice, *rest: Any) -> Any:
        chunk = original(batch, runs, *rest)
        stored = per_run(chunk.records, len(chunk.codes))[:, :, : chunk.states.shape[1]]
        found.append((batch.states[runs], stored, chunk.states))
        return chunk

    with monkeypatch.context() as patch:
        patch.setattr(execute, "integrate", watched)
        ds = run(data, **options)
    first, stored, last = map(np.concatenate, zip(*found, strict=True))
    return SimpleNamespace(ds=ds, first=first, stored=stored, last=last)


def paced(data: dict[str, Any], pace: dict[str, Any]) -> dict[str, Any]:
    if "tolerance" in pace:
        del data["integrator"]["step"]
        data["integrator"] |= {"tolerance": pace["tolerance"], "method": "tsit54"}
    return data | {"events": pace.get("events", [])}


@pytest.mark.parametrize("pace", PACES)
@pytest.mark.parametrize("sweep", [top, loop])
def test_runs_that_reach_the_end(sweep: Any, pace: dict[str, Any], monkeypatch: pytest.MonkeyPatch) -> None:
    of = ended(paced(sweep(runs=11), pace), monkeypatch)
    assert (of.ds.status == statuses.SUCCESS).all()
    np.testing.assert_array_equal(of.last, of.stored[:, -1])


@pytest.mark.parametrize("how", [{"tolerance": 1e-9}, {"step": 0.0125, "method": "dop853"}])
def test_runs_that_an_event_stops(how: dict[str, Any], monkeypatch: pytest.MonkeyPatch) -> None:
    """In the middle of a step, each elsewhere; the same as what is stored at that very time."""
    data = pendulum(LOW | {"when": "tip.z < -depth", "action": "stop"}, **how)
    data |= {"parameters": {"depth": 0.5}, "output": {"times": [0.0]}}
    data["sweep"] = {"runs": 11, "vary": {"parameters.depth": {"distribution": "uniform", "low": 0.2, "high": 0.9}}}
    of = ended(data, monkeypatch)
    times, depths = of.ds.event_time.values[:, 0], of.ds["parameters.depth"].values
    assert (of.ds.status == statuses.STOPPED).all()
    np.testing.assert_array_equal(of.ds.end_time, times)
    np.testing.assert_allclose(of.last[:, 2], -depths, rtol=0, atol=1e-9)
    if "tolerance" in how:  # outputs between the steps
        again = ended(data | {"output": {"times": [0.0, *sorted(times)]}}, monkeypatch)
        places = 1 + np.argsort(np.argsort(times))
        np.testing.assert_array_equal(of.last, again.stored[np.arange(11), places])
        np.testing.assert_array_equal(of.last, again.last)
    length = np.hypot(of.last[:, 0], of.last[:, 2])
    np.testing.assert_allclose(length, 1.0, rtol=0, atol=1e-12)  # projected


def test_runs_that_an_event_stops_on_the_end_of_a_step(monkeypatch: pytest.MonkeyPatch) -> None:
    """And at the very start."""
    stop = {"name": "now", "when": "t >= when", "action": "stop"}
    data = pendulum(stop, step=0.0625, method="tsit54") | {"parameters": {"when": 1.0}}
    data["sweep"] = {"runs": 3, "vary": {"parameters.when": {"distribution": "uniform", "low": 0.1, "high": 0.9}}}
    edit_samples(monkeypatch, {n: {"parameters.when": when} for n, when in enumerate((0.75, 0.0, 9.0))})
    of = ended(data, monkeypatch)
    assert of.ds.end_time.values.tolist() == [0.75, 0.0, 3.0]
    for n, place in enumerate((3, 0, -1)):
        np.testing.assert_array_equal(of.last[n], of.stored[n, place])


@pytest.mark.parametrize("pace", PACES[:2])
def test_runs_that_fail(pace: dict[str, Any], monkeypatch: pytest.MonkeyPatch) -> None:
    """Where the projection needs one iteration more."""
    data = loop(runs=20, projection={"max_iterations": 1, "tolerance": 1e-9}, output={"every": 0.02})
    data["sweep"]["vary"]["bodies.left.angular_velocity[0]"] = {"distribution": "normal", "std": 1.0}
    of = ended(paced(data, pace), monkeypatch)
    steps = of.ds.steps.values
    assert (of.ds.status == statuses.NOT_CONVERGED).all()
    assert len(set(steps)) > 1
    np.testing.assert_array_equal(of.last, of.stored[np.arange(20), steps])


def test_runs_that_fail_after_a_landing(monkeypatch: pytest.MonkeyPatch) -> None:
    """At the blow of a table, which is within a step of each run: both drivers, and those of steps of any length."""
    data = pendulum(step=0.0625) | {"parameters": {"late": 0.5}, "output": {"times": [0.0]}}
    data["tables"] = {"blow": {"times": [0, 1, 4], "values": [0, 1e100, 0], "interpolation": "hold"}}
    data["tables"]["blow"]["outside"] = "hold"
    data["model"]["forces"] = [{"type": "torque", "body": "bob", "value": [0, "1e100*blow(t - late)", 0]}]
    data["sweep"] = {"runs": 11, "vary": {"parameters.late": {"distribution": "uniform", "low": -0.9, "high": 1.5}}}
    plain, free, own = (ended(paced(copy.deepcopy(data), pace), monkeypatch) for pace in PACES)
    lates = plain.ds["parameters.late"].values
    for of in (plain, free, own):
        assert not of.ds.status.isin(statuses.GOOD).any()
        np.testing.assert_allclose(of.ds.end_time, 1 + lates, rtol=0, atol=1e-12)
        np.testing.assert_allclose(of.last, own.last, rtol=0, atol=1e-3)
    np.testing.assert_array_equal(plain.ds.end_time, free.ds.end_time)
    np.testing.assert_array_equal(plain.last, free.last)
    times = sorted(own.ds.end_time.values)
    again = ended(paced(data | {"output": {"times": [0.0, *times]}}, PACES[2]), monkeypatch)
    np.testing.assert_array_equal(own.last, again.stored[np.arange(11), 1 + np.argsort(np.argsort(lates))])


@pytest.mark.parametrize("pace", PACES)
def test_runs_that_never_start(pace: dict[str, Any], monkeypatch: pytest.MonkeyPatch) -> None:
    edit_samples(monkeypatch, {n: {"bodies.top.mass": -1.0} for n in (2, 9)})
    of = ended(paced(top(runs=11), pace), monkeypatch)
    assert np.flatnonzero(of.ds.status).tolist() == [2, 9]
    np.testing.assert_array_equal(of.last[[2, 9]], of.first[[2, 9]])
    assert (of.last != of.first).any(axis=1).sum() == 9


def one_iteration(times: list[float], *events: dict[str, Any]) -> dict[str, Any]:
    """Enough for the ends of steps, but not everywhere between them."""
    data = loop(runs=11, projection={"max_iterations": 1, "tolerance": 1e-11}, output={"times": times})
    del data["integrator"]["step"]
    data["integrator"] |= {"tolerance": 1e-2, "method": "tsit54", "end_time": 0.4}
    return data | {"events": list(events)}


def test_runs_whose_outputs_cannot_be_projected(monkeypatch: pytest.MonkeyPatch) -> None:
    """They end where they were stored last, or where an event stops them if that can be projected."""
    assert (ended(one_iteration([0.0, 0.4]), monkeypatch).ds.status == statuses.SUCCESS).all()
    times = np.linspace(0, 0.4, 41).tolist()
    of = ended(one_iteration(times), monkeypatch)
    failed = of.ds.status.values == statuses.NOT_CONVERGED
    assert 0 < failed.sum() < 11
    places = np.searchsorted(times, of.ds.end_time.values)
    assert len(set(places)) > 2
    np.testing.assert_array_equal(of.last, of.stored[np.arange(11), places])
    stopped = ended(one_iteration([0.0, 0.1], {"name": "now", "when": "t >= 0.2615", "action": "stop"}), monkeypatch)
    lost = stopped.ds.status.values == statuses.NOT_CONVERGED
    assert 0 < lost.sum() < 11
    np.testing.assert_array_equal(stopped.last[lost], stopped.stored[lost, -1])
    assert (stopped.ds.end_time.values[lost] == 0.1).all()
    assert (stopped.ds.status.values[~lost] == statuses.STOPPED).all()
