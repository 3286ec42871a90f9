"""Runs that change: against closed forms, with every way of making steps, and alone as among others."""

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from lienumba.batch import statuses
from lienumba.integrators import codes
from tests.integrators.drivers.test_events import pendulum, run
from tests.integrators.drivers.test_variable_step import equal
from tests.rigs import parts

G = 9.81
LATCH = {"name": "latch", "when": "swing.angle > 30*deg", "action": "lock", "joint": "hinge"}
FREE = {"name": "free", "when": "t > 1", "action": "unlock", "joint": "hinge"}
FIXED = {"step": 0.01, "method": "dop853"}
WAYS = [{"tolerance": 1e-11}, FIXED, {"tolerance": 1e-11, "method": "taylor"}]


def body(*contacts: dict[str, Any], position: Any = (0, 0, 0.1), **integrator: Any) -> dict[str, Any]:
    bodies = [parts.body("b", position=list(position))]
    every = [c | {"normal": [0, 0, 1]} for c in contacts]
    model = {"gravity": [0, 0, -G], "bodies": bodies, "contacts": every}
    return {"model": model, "integrator": {"end_time": 1.0, **integrator}, "output": {"every": 0.25}}


def ball(restitution: Any, **integrator: Any) -> dict[str, Any]:
    floor = parts.sphere("floor", "b", 0.1, restitution=restitution)
    return body(floor, position=(0, 0, 1.1), **integrator)


def changes(ds: Any, n: int = 0) -> list[tuple[float, int, int]]:
    found = zip(*(ds[name][n].values for name in ("change_time", "change_kind", "change_what")), strict=True)
    return [(float(t), int(kind), int(what)) for t, kind, what in found if np.isfinite(t)]


@pytest.mark.parametrize("how", WAYS)
def test_a_ball_bounces(how):
    ds = run(ball(0.8, **how) | {"integrator": {"end_time": 3.75, **how}})
    first = np.sqrt(2 / G)
    times = first + 2 * first * np.cumsum([0.0, *0.8 ** np.arange(1, 11)])
    told = changes(ds)
    assert {(kind, what) for _, kind, what in told} == {(codes.IMPACT, 0)}
    np.testing.assert_allclose([t for t, *_ in told], times[times < 3.75], atol=1e-11)
    np.testing.assert_allclose(ds.change_energy[0, :3], G * 0.36 * 0.64 ** np.arange(3), rtol=1e-11)
    assert float(abs(ds.energy_residual).max()) < 1e-10
    assert float(ds.energy_lost[0]) == pytest.approx(G * (1 - 0.64 ** len(told)), rel=1e-11)


def test_a_ball_comes_to_rest_below_the_speed_of_rest():
    rest = ball(0.5, tolerance=1e-10)
    rest["integrator"]["end_time"] = 2.0
    rest["model"]["contacts"][0]["rest_speed"] = 0.1
    ds = run(rest)
    told = changes(ds)
    speeds = np.sqrt(2 * G) * 0.5 ** np.arange(1, 10)
    assert [kind for _, kind, _ in told] == [codes.IMPACT] * (1 + int((speeds >= 0.1).sum())) + [codes.CLOSED]
    assert float(ds.position[0, -1, 0, 2]) == pytest.approx(0.1, abs=1e-12)
    assert float(ds.energy_lost[0]) == pytest.approx(G, rel=1e-10)


@pytest.mark.parametrize("how", [*WAYS, {"tolerance": 1e-11, "coordinates": "joint"}])
def test_a_pendulum_locks_and_swings_on(how):
    rates = lambda t, y: [y[1], G / 1.1 * np.cos(y[0])]  # noqa: E731
    there = lambda t, y: y[0] - np.pi / 6  # noqa: E731
    down = solve_ivp(rates, (0, 1), [0, 0], "DOP853", rtol=1e-13, atol=1e-14, events=there)
    on = solve_ivp(rates, (1, 3), [np.pi / 6, 0], "DOP853", rtol=1e-13, atol=1e-14)
    ds = run(pendulum(LATCH | {"once": True}, FREE, **how))
    assert [x[1:] for x in changes(ds)] == [(codes.LOCKED, 0), (codes.RELEASED, 1)]
    assert float(ds.event_time[0, 0]) == pytest.approx(down.t_events[0][0], abs=1e-11)
    assert float(ds.position[0, -1, 0, 2]) == pytest.approx(-np.sin(on.y[0, -1]), abs=1e-9)
    rate = np.sqrt(2 * G * 0.5 / 1.1)
    assert float(ds.change_energy[0, 0]) == pytest.approx(G * 0.5, rel=1e-9)
    assert float(ds.change_impulse[0, 0]) == pytest.approx(1.1 * rate, rel=1e-9)
    assert float(abs(ds.energy_residual).max()) < 1e-9


def test_what_is_locked_is_not_locked_again():
    """Though its condition is beside the limit for the rest of the run."""
    ds = run(pendulum(LATCH, tolerance=1e-10))
    assert ds.event_count.values.tolist() == [[1]]
    assert np.ptp(ds.position.values[0, 3:, 0, 2]) < 1e-12


@pytest.mark.parametrize(("later", "counts"), [("latch", [0, 1]), ("end", [1, 1])])
def test_what_stops_a_run_and_what_changes_it_keep_their_order(later, counts):
    """Also where one comes directly behind the other, within a step that is cut."""
    latch, end = LATCH | {"when": "t > 0.9"}, {"name": "end", "when": "t > 0.9", "action": "stop"}
    {"latch": latch, "end": end}[later]["when"] = "t > 0.9 + 1e-9"
    ds = run(pendulum(latch, end, tolerance=1e-9))
    assert ds.event_count.values.tolist() == [counts]
    assert float(ds.end_time[0]) == pytest.approx(0.9, abs=2e-9)


def feet(mu: float, slope: float) -> dict[str, Any]:
    legs = [(x, y, -0.3) for x in (-0.5, 0.5) for y in (-0.5, 0.5)]
    contacts = parts.feet("b", legs, "leg", friction=mu)
    data = body(*contacts, position=(0, 0, 0.3), tolerance=1e-10)
    data["model"]["gravity"] = [G * np.sin(slope), 0, -G * np.cos(slope)]
    return data


@pytest.mark.parametrize(("slope", "slides"), [(0.2, 0.0), (0.4, G * (np.sin(0.4) - 0.3 * np.cos(0.4)))])
def test_a_table_stands_on_four_legs_and_slides(slope, slides):
    ds = run(feet(0.3, slope))
    assert [kind for _, kind, _ in changes(ds)] == [codes.CLOSED] * 4
    np.testing.assert_allclose(ds.position[0, -1, 0], [0.5 * slides, 0, 0.3], atol=1e-10)


def test_a_block_slides_to_rest():
    data = body(parts.sphere("foot", "b", 0.1, friction=0.3), tolerance=1e-10)
    data["model"]["bodies"][0]["velocity"] = [2, 1, 0]
    ds = run(data)
    rolls = np.sqrt(5.0) / (0.3 * G * (1 + 0.01 / 0.1))  # the slip ends
    assert changes(ds)[0] == (0.0, codes.CLOSED, 0)
    assert changes(ds)[1][0] == pytest.approx(rolls, abs=1e-9)
    assert changes(ds)[1][1] == codes.STUCK
    speed = np.hypot(*ds.velocity[0, -1, 0, :2].values)
    assert speed == pytest.approx(np.sqrt(5.0) - 0.3 * G * rolls, abs=1e-9)


def test_friction_of_a_joint_sticks():
    data = body(tolerance=1e-10)
    rail = parts.joint("rail", "prismatic", "b", at=[0, 0, 0.1], axis=[1, 0, 0])
    data["model"] |= {"joints": [rail], "forces": [parts.dry("rail", 3.0, 4.0, "f")]}
    data["model"]["bodies"][0]["velocity"] = [2, 0, 0]
    ds = run(data)
    assert changes(ds) == [(pytest.approx(2 / 3, abs=1e-11), codes.STUCK, 0)]
    assert float(ds.position[0, -1, 0, 0]) == pytest.approx(2 / 3, abs=1e-11)


def test_sets_releases_and_says_what_cannot_close():
    release = run(pendulum(LATCH | {"action": "release"}, tolerance=1e-11))
    assert changes(release)[0][1:] == (codes.RELEASED, 0)
    fall = release.velocity[0, -1, 0, 2] - release.velocity[0, -2, 0, 2]
    assert float(fall) == pytest.approx(-0.25 * G, abs=1e-11)
    data = body(position=(0, 0, 1), tolerance=1e-10)
    grip = parts.joint("grip", "spherical", "b", points=[[0, 0, 0]] * 2, active=False)
    data["model"]["joints"] = [grip]
    data["quantities"] = [{"name": "place", "type": "point", "body": "b"}]
    data["events"] = [{"name": "catch", "when": "place.z < 0.5", "action": "engage", "joint": "grip"}]
    far = run(data)
    assert far.status.values.tolist() == [statuses.NOT_CLOSED]
    data["events"][0]["when"] = "place.z < 1e-3"
    near = run(data)
    assert near.status.values.tolist() == [statuses.SUCCESS]
    assert changes(near)[0][1:] == (codes.ENGAGED, 0)
    assert float(near.change_energy[0, 0]) == pytest.approx(G, rel=1e-9)  # with the millimetre that it is moved
    assert float(abs(near.position[0, -1]).max()) < 1e-12


@pytest.mark.parametrize("how", [{"tolerance": 1e-9}, FIXED])
def test_no_run_depends_on_its_neighbours(how):
    data = ball("e", **how)
    data["parameters"] = {"e": 0.5}
    data["model"]["contacts"][0] |= {"restitution": 0.5, "rest_speed": 0.3}
    del data["parameters"]
    data["sweep"] = parts.sweep(19, {"contacts.floor.restitution": (0.1, 0.9), "bodies.b.position[2]": (0.2, 1.5)})
    ds = run(data)
    assert len(set(ds.changes.values.tolist())) > 3
    assert equal(ds, run(data, workers=2))
    assert equal(ds.isel(run=[11, 2]), run(data, runs=[11, 2]))


@pytest.mark.parametrize("how", [{"tolerance": 1e-9}, FIXED])
def test_no_run_that_locks_depends_on_its_neighbours(how):
    """Also where these search, are cut and change in the same step."""
    data = pendulum(
        LATCH | {"once": True}, FREE | {"when": "t > 1 + late"}, {"name": "low", "when": "tip.z < -0.4"}, **how
    )
    data["parameters"] = {"late": 0.0}
    data["sweep"] = parts.sweep(19, {"parameters.late": (0.0, 0.5), "gravity[2]": (-12.0, -8.0)})
    ds = run(data)
    assert set(ds.changes.values.tolist()) == {2}
    assert equal(ds, run(data, workers=2))
    assert equal(ds.isel(run=[11, 2]), run(data, runs=[11, 2]))
    times = ds.event_time.sel(event="free").values
    np.testing.assert_allclose(times, 1 + ds["parameters.late"].values, rtol=4e-16, atol=0)


def test_what_acts_at_a_time_does_so_on_the_end_of_a_step():
    """Steps end there, so nothing is tried twice; what would come at the end of the run, or behind it, does not."""
    hold = {"name": "hold", "when": "t > 1.25", "action": "lock", "joint": "hinge"}
    late = [
        {"name": f"late_{n}", "when": f"t > {t}", "action": "unlock", "joint": "hinge"} for n, t in enumerate((3, 4))
    ]
    with pytest.warns(UserWarning, match="comes true behind [34] s"):
        held = run(pendulum(hold, *late, tolerance=1e-9))
    free = run(pendulum(tolerance=1e-9) | {"output": {"times": [1.25]}})
    assert changes(held) == [(1.25, codes.LOCKED, 0)]
    np.testing.assert_allclose(held.position[0, -1], free.position[0, -1], rtol=0, atol=1e-10)


def test_friction_of_what_flies_has_no_direction():
    """A ball that rolls as it bounces: at the contact that is open it stands still but for rounding, of which a series
    could make nothing."""
    floor = parts.sphere("floor", "b", 0.1, restitution=0.6)
    found = []
    for how in ({"method": "taylor"}, {}):
        data = body(floor | {"friction": 0.3}, position=(0, 0, 1), tolerance=1e-10, **how)
        data["integrator"]["end_time"] = 2.0
        data["model"]["bodies"][0] |= {"inertia": [0.1, 0.12, 0.15], "angular_velocity": [0, 3, 1]}
        found.append(run(data))
        assert found[-1].status.values.tolist() == [statuses.SUCCESS]
    series, steps = found
    assert [x[1:] for x in changes(series)] == [x[1:] for x in changes(steps)]
    np.testing.assert_allclose(series.position[0, -1], steps.position[0, -1], rtol=0, atol=1e-7)


def test_what_changes_without_end_ends_as_chattering():
    """A ball that gives back nearly all, and may come to rest from next to nothing: more than a thousand bounces within
    a millionth of a long run."""
    data = ball(0.998, tolerance=1e-9)
    data["integrator"]["end_time"], data["output"]["every"] = 1e4, 5e3
    data["model"]["contacts"][0]["rest_speed"] = 1e-9
    ds = run(data)
    assert ds.status.values.tolist() == [statuses.CHATTERING]
    assert 5000 < int(ds.changes[0]) < 10000
    whole = np.sqrt(2 / G) * (1 + 2 * 0.998 / 0.002)  # of all bounces
    assert whole - 0.02 < float(ds.end_time[0]) < whole
    sentence = next(x.sentence for x in statuses.STATUSES if x.code == statuses.CHATTERING)
    assert sentence.startswith("contacts, friction or events changed again and again without end at nearly one time")
