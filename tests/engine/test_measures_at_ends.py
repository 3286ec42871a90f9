"""Formulas of whole runs where these end or change, of tables that nothing else reads, and of sharp extremes."""

from typing import Any

import numpy as np
import pytest
import xarray as xr

import lienumba

pytestmark = pytest.mark.filterwarnings("ignore:.*nothing uses it")
BODY = {"name": "b", "mass": 1.0, "inertia": [1, 1, 1], "position": [0, 0, 0], "rotation": [1, 0, 0, 0]}
POINT = {"name": "p", "type": "point", "body": "b"}
QUANTITIES = [POINT, POINT | {"name": "u", "derivative": 1}, POINT | {"name": "a", "derivative": 2}]
METHODS: list[dict[str, Any]] = [
    {"step": 0.01},
    {"tolerance": 1e-9},
    {"tolerance": 1e-6, "method": "tsit54"},
    {"tolerance": 1e-9, "method": "taylor"},
    {"tolerance": 1e-9, "method": "radau5"},
]


def measured(model: dict[str, Any], texts: list[str], integrator: dict[str, Any], **more: Any) -> xr.Dataset:
    measures = [{"name": f"m{n}", "value": text} for n, text in enumerate(texts)]
    given = {"model": model, "integrator": integrator, "measures": measures, "output": {"every": 0.5}}
    return lienumba.run({**given, "quantities": QUANTITIES, **more})


@pytest.mark.parametrize("integrator", METHODS, ids=str)
def test_what_stops_a_run_has_happened(integrator: dict[str, Any]) -> None:
    """Also where its condition is not true at the end, by rounding: of the throws that land some were not."""
    ds = measured(
        {"bodies": [BODY | {"velocity": [1, 0, "v"]}]},
        ["at(u.z, landed)", "first_time(p.z<0)", "count((p.z < 0))", "max(p.x)"],
        {**integrator, "end_time": 2.0},
        parameters={"v": 5.0},
        events=[{"name": "landed", "when": "p.z < 0", "action": "stop"}],
        sweep={"runs": 200, "seed": 1, "vary": {"parameters.v": {"distribution": "uniform", "low": 3, "high": 6}}},
    )
    v, time = ds["parameters.v"].values, ds["event_time"].values[:, 0]
    for n, known in enumerate((-v, time, np.ones(200), time)):
        np.testing.assert_allclose(ds[f"m{n}"], known, rtol=1e-6, err_msg=str(n))


@pytest.mark.parametrize("integrator", METHODS, ids=str)
def test_what_locks_a_joint_has_happened(integrator: dict[str, Any]) -> None:
    slide = {"name": "rail", "type": "prismatic", "bodies": ["ground", "b"], "at": [0, 0, 0], "axis": [1, 0, 0]}
    ds = measured(
        {"gravity": ["g", 0, 0], "bodies": [BODY], "joints": [slide | {"speed": 1.0}]},
        ["at(u.x, caught)", "count(p.x > 0.7)", "first_time(p.x > 0.7)", "max(p.x)"],
        {**integrator, "end_time": 2.0},
        parameters={"g": 1.0},
        events=[{"name": "caught", "when": "p.x > 0.7", "action": "lock", "joint": "rail"}],
        sweep={"runs": 100, "seed": 2, "vary": {"parameters.g": {"distribution": "uniform", "low": 0.2, "high": 3}}},
    )
    speed = np.sqrt(1.0 + 1.4 * ds["parameters.g"].values)
    for n, known in enumerate((speed, np.ones(100), (speed - 1.0) / ds["parameters.g"].values, np.full(100, 0.7))):
        np.testing.assert_allclose(ds[f"m{n}"], known, rtol=1e-6, err_msg=str(n))


@pytest.mark.parametrize("more", [[], ["max(a.z)"], ["max(floor(3*t))"]])
@pytest.mark.parametrize("integrator", METHODS, ids=str)
def test_a_measure_feels_no_other_one(integrator: dict[str, Any], more: list[str]) -> None:
    """The time at which a run ends is a time of it."""
    texts = ["at(p.z, 1.0)", "first_time(t >= 1.0)", "count(t >= 1.0)", *more]
    ds = measured({"bodies": [BODY | {"velocity": [0, 0, 5]}]}, texts, {**integrator, "end_time": 1.0})
    np.testing.assert_allclose([ds[f"m{n}"].item() for n in range(3)], [5 - 9.81 / 2, 1.0, 1.0], rtol=1e-9)


def test_states_at_events_that_a_change_makes_true() -> None:
    """An impact turns the velocity, a lock stops it, and a number is set: what is stored is what is behind that."""
    ball = {"name": "f", "type": "sphere_plane", "bodies": ["b", "ground"], "points": [[0, 0, 0], [0, 0, 0]]}
    ball |= {"normal": [0, 0, 1], "radius": 0.1, "restitution": 0.7}
    ds = measured(
        {"bodies": [BODY | {"position": [0, 0, 0.5]}], "contacts": [ball]},
        ["at(u.z, up)"],
        {"tolerance": 1e-9, "end_time": 0.5},
        events=[{"name": "up", "when": "u.z > 0"}, {"name": "low", "when": "p.z < 0.3"}],
        output={"every": 0.25, "at_events": ["p.z", "u.z"]},
    )
    speed = np.sqrt(2 * 9.81 * 0.4)
    np.testing.assert_allclose(ds["event_p.z"].values[0], [0.1, 0.3], rtol=1e-9)
    np.testing.assert_allclose(ds["event_u.z"].values[0], [0.7 * speed, -np.sqrt(2 * 9.81 * 0.2)], rtol=1e-9)
    np.testing.assert_allclose(ds["m0"], 0.7 * speed, rtol=1e-9)


@pytest.mark.parametrize("integrator", METHODS, ids=str)
def test_tables_that_only_a_measure_reads(integrator: dict[str, Any]) -> None:
    times, values = [0, 0.13, 0.41, 0.77, 1], [0, 1, -1, 0.5, 0.2]
    ref = {"times": times, "values": values}
    ds = measured(
        {"gravity": [0, 0, 0], "bodies": [BODY | {"velocity": [1, 0, 0]}]},
        ["mean(held(t))", "min(ref(t))", "rms(p.x - ref(t))", "mean(ceil(3*t))", "max(p.x, t > 0.3)"],
        {**integrator, "end_time": 1.0},
        tables={"held": ref | {"interpolation": "hold"}, "ref": ref},
    )
    t = np.linspace(0, 1, 1_000_001)
    off = (t - np.interp(t, times, values)) ** 2
    known = [np.dot(np.diff(times), values[:-1]), -1.0, np.sqrt((off[1:] + off[:-1]).mean() / 2), 2.0, 1.0]
    np.testing.assert_allclose([ds[f"m{n}"].item() for n in range(5)], known, rtol=1e-7)


@pytest.mark.parametrize("miss", [1.0, 0.1, 0.001])
@pytest.mark.parametrize("integrator", [*METHODS, {"step": 0.5}], ids=str)
def test_sharp_extremes_in_long_steps(integrator: dict[str, Any], miss: float) -> None:
    """A body that flies past another one, in as few steps as it takes."""
    other = BODY | {"name": "c", "position": [-5.3, miss, 0], "velocity": [1, 0, 0]}
    ds = measured(
        {"gravity": [0, 0, 0], "bodies": [other, BODY]},
        ["min(d.distance)", "time_of_min(d.distance)"],
        {**integrator, "end_time": 10.0},
        quantities=[{"name": "d", "type": "distance", "bodies": ["c", "b"]}],
    )
    np.testing.assert_allclose(ds["m0"], miss, rtol=1e-9)
    np.testing.assert_allclose(ds["m1"], 5.3, rtol=1e-7)


@pytest.mark.parametrize("integrator", METHODS[1:], ids=str)
def test_extremes_anywhere_in_a_step(integrator: dict[str, Any]) -> None:
    """Of a body that turns, at rates by which its extremes are next to ends of steps, too, or barely reach a limit."""
    ds = measured(
        {"gravity": [0, 0, 0], "bodies": [BODY | {"rotation": [1, 0, 0, 0], "angular_velocity": [0, 0, "w"]}]},
        ["max(p.y, t < 3)", "time_of_max(p.y, t < 1.5)", "count(p.y > 0.999999)"],
        {**integrator, "end_time": 5.0},
        parameters={"w": 3.0},
        quantities=[POINT | {"point": [1, 0, 0]}],
        sweep={"runs": 200, "seed": 3, "vary": {"parameters.w": {"distribution": "uniform", "low": 2, "high": 4}}},
    )
    w = ds["parameters.w"].values
    np.testing.assert_allclose(ds["m0"], 1.0, rtol=1e-10)
    np.testing.assert_allclose(ds["m1"], np.pi / 2 / w, rtol=1e-5)
    np.testing.assert_array_equal(ds["m2"], np.floor((5 * w - np.arcsin(0.999999)) / (2 * np.pi)) + 1)
