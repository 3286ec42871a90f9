"""Formulas of whole runs against closed forms: a throw, a spring and an armature, and what datasets make of them."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import lienumba
from lienumba import ScenarioError
from lienumba.integrators.tracing import step_kernels
from tests.rigs import parts

pytestmark = pytest.mark.filterwarnings("ignore:.*nothing uses it")
G, UP, END, LEVEL = 9.81, 5.0, 1.5, 0.31
THROW: dict[str, Any] = {
    "parameters": {"k": 1.0, "tau": LEVEL},
    "model": {
        "gravity": [0, 0, -G],
        "bodies": [parts.body("ball", 1.0, 1, position=[0, 0, 0], rotation=[1, 0, 0, 0], velocity=[0, 0, UP])],
    },
    "quantities": [{"name": "p", "type": "point", "body": "ball"}],
    "events": [{"name": "hit", "when": "p.z < -1"}],
    "output": {"every": 0.5, "variables": ["p"]},
}
STEPS = [
    {"step": 0.01},
    {"step": 0.25},
    {"tolerance": 1e-9},
    {"tolerance": 1e-9, "method": "taylor"},
    {"step": 0.1, "method": "radau5"},
    {"tolerance": 1e-9, "coordinates": "joint"},
]


def z(t: float) -> float:
    return UP * t - G / 2 * t * t


def area(t: float) -> float:
    return UP / 2 * t * t - G / 6 * t**3


def squares(t: float) -> float:
    return UP**2 * t**3 / 3 - UP * G * t**4 / 4 + G * G * t**5 / 20


TOP = UP**2 / 2 / G
RISES, SINKS = ((UP + s * np.sqrt(UP**2 - 2 * G)) / G for s in (-1, 1))  # through 1 m
CLOSED = {
    "max(p.z)": TOP,
    "time_of_max(p.z)": UP / G,
    "min(p.z)": z(END),
    "time_of_min(p.z)": END,
    "final(p.z)": z(END),
    "final(t)": END,
    "mean(p.z)": area(END) / END,
    "rms(p.z)": np.sqrt(squares(END) / END),
    "integral(p.z, p.z > 1)": area(SINKS) - area(RISES),
    "mean(p.z, p.z > 1)": (area(SINKS) - area(RISES)) / (SINKS - RISES),
    "time_when(p.z > 1)": SINKS - RISES,
    "time_when(p.z > 3)": 0.0,
    "time_above(p.z, 1)": SINKS - RISES,
    f"time_above(p.z, 1, t > {0.5 * (SINKS + RISES)})": 0.5 * (SINKS - RISES),
    "first_time(p.z > 1)": RISES,
    "last_time(p.z > 1)": SINKS,
    "first_time(p.z <= 0)": 0.0,
    "first_time(p.z > 3)": np.nan,
    "count(p.z > 1)": 1.0,
    "count(p.z > 3)": 0.0,
    "at(p.z, tau)": z(LEVEL),
    "at(p.z, hit)": -1.0,
    "max(p.z, t > 0.9)": z(0.9),
    "min(p.z, p.z > 1)": 1.0,
    "max(p.z, t > 0.2 and t < 0.4)": z(0.4),
    "overshoot(p.z, k)": TOP - 1.0,
    "overshoot(-p.z, -k)": TOP - 1.0,
    "overshoot(p.z, 3*k)": 0.0,
    "max(p.z) - 2*k*min(p.z, t < 0.5)": TOP,
    "max(k, max(p.z), 0.5)": TOP,
    "max(max(abs(p.z + 0.5), p.y))": -z(END) - 0.5,
}


def measured(formulas: list[str], scenario: dict[str, Any] = THROW, **keys: Any) -> xr.Dataset:
    """The dataset of a scenario that asks for these."""
    asked = [{"name": f"m{n}", "value": text} for n, text in enumerate(formulas)]
    return lienumba.run(scenario | {"measures": asked} | keys)


@pytest.mark.parametrize("steps", STEPS, ids=str)
def test_a_throw_has_closed_forms(steps: dict[str, Any]) -> None:
    ds = measured([*CLOSED], integrator={"end_time": END, **steps})
    found = [float(ds[f"m{n}"][0]) for n in range(len(CLOSED))]
    powers = steps.get("step", 0.0) ** 4 * (len(steps) == 1)  # of order 4 is an integral of what is no cubic, as rk4
    allowed = [2e-9 + powers * text.startswith("rms") for text in CLOSED]
    np.testing.assert_array_equal(np.isnan(found), np.isnan([*CLOSED.values()]))
    assert (np.abs(np.nan_to_num(np.subtract(found, [*CLOSED.values()]))) <= allowed).all()


GAP = "1e-30*sqrt((t - 0.4)*(t - 0.6))"  # undefined in between
GAPS = {
    f"max(p.z + {GAP})": np.nan,
    f"min(p.z + {GAP})": np.nan,
    f"time_of_max(p.z + {GAP})": np.nan,
    f"max(max(p.z + {GAP}, p.y))": np.nan,
    f"max(min(p.y, {GAP} + p.z))": np.nan,
    f"max(max(p.z + {GAP}), -5)": np.nan,
    f"overshoot(p.z + {GAP}, k)": np.nan,
    f"integral(p.z + {GAP})": np.nan,
    f"mean(p.z + {GAP})": np.nan,
    f"rms(p.z + {GAP}, t > 0.5)": np.nan,
    f"final(p.z + {GAP})": z(END),
    f"final(p.z + {GAP}, t < 0.5)": np.nan,
    f"at(p.z + {GAP}, 0.5)": np.nan,
    f"at(p.z + {GAP}, tau)": z(LEVEL),
    f"max(p.z + {GAP}, t < 0.4)": z(0.4),
    f"max(p.z + {GAP}, t > 0.6)": z(0.6),
    f"max(p.z + {GAP}, t < 0.3 or t > 0.7)": z(0.7),
    f"mean(p.z + {GAP}, t < 0.4)": area(0.4) / 0.4,
    f"max(p.z, {GAP} < 1 and t > 0.7)": z(0.7),
    f"max(p.z, t > 0.7 and {GAP} < 1)": z(0.7),
    f"max(p.z, {GAP} < 1 or t > 0)": TOP,
    f"max(p.z, {GAP} < 1)": np.nan,
    f"integral(p.z, not {GAP} < 1)": np.nan,
    f"time_when(p.z + {GAP} > 1)": np.nan,
    f"count(p.z + {GAP} > 1)": np.nan,
    f"first_time(p.z + {GAP} > 1)": RISES,
    f"first_time(t + {GAP} > 1)": np.nan,
    f"last_time(t + {GAP} < 0.3)": np.nan,
    f"last_time(p.z + {GAP} > 1)": SINKS,
    "max(sqrt(tau - t), t < tau)": np.sqrt(LEVEL),
    "1e-3*final(sqrt(tau - t), t < tau)": 0.0,
}


@pytest.mark.parametrize("steps", [STEPS[0], {"tolerance": 1e-9, "max_step": 0.07}], ids=str)
def test_what_is_undefined_for_a_while_is_not_forgotten(steps: dict[str, Any]) -> None:
    """A number of a whole run is undefined where what it is made of is, unless a condition leaves that out, or what is
    undefined could not change it any more."""
    ds = measured([*GAPS], integrator={"end_time": END, **steps})
    found = [float(ds[f"m{n}"][0]) for n in range(len(GAPS))]
    assert ds.status.values.tolist() == [0]
    np.testing.assert_allclose(found, [*GAPS.values()], rtol=0, atol=2e-9)


SPRING: dict[str, Any] = {
    "parameters": {"start": 1.0, "w": "2*pi"},
    "model": {
        "gravity": [0, 0, 0],
        "bodies": [parts.body("bob", 1.0, 1, position=["start", 0, 0], rotation=[1, 0, 0, 0])],
        "forces": [
            {"name": "pull", "type": "force", "body": "bob", "value": ["-w**2*x.x", 0, 0]},
        ],
    },
    "quantities": [{"name": "x", "type": "point", "body": "bob"}],
    "integrator": {"tolerance": 1e-11, "end_time": 3.0},
    "output": {"every": 1.0, "mode": "summary"},
    "sweep": parts.sweep(20, {"parameters.start": (0.5, 1.5)}, seed=4),
}


def test_each_run_of_a_sweep_has_its_own() -> None:
    """x = a cos(2 pi t) over three periods: no time is stored at which it says so."""
    ds = measured(
        ["max(x.x, t > 1)", "rms(x.x)", "time_when(x.x > 0.6*start)", "count(x.x > 0)", "mean(x.x, x.x > 0)"]
        + ["time_of_min(x.x)", "min(x.x)/start", "last_time(x.x > 0.4)"],
        SPRING,
    )
    a = ds["parameters.start"].values
    np.testing.assert_allclose(ds.m0, a, rtol=1e-9)
    np.testing.assert_allclose(ds.m1, a / np.sqrt(2), rtol=1e-9)
    np.testing.assert_allclose(ds.m2, 3 * np.arccos(0.6) / np.pi, rtol=1e-8)
    np.testing.assert_array_equal(ds.m3, 4)  # at the start, and three times again
    np.testing.assert_allclose(ds.m4, 2 * a / np.pi, rtol=1e-8)
    np.testing.assert_allclose(ds.m5 % 1.0, 0.5, atol=1e-6)
    np.testing.assert_allclose(ds.m6, -1.0, rtol=1e-9)
    np.testing.assert_allclose(ds.m7, 3.0, rtol=1e-12)
    assert ds.m0.attrs == {"units": "m", "long_name": "m0 of the run", "measure": "max(x.x, t > 1)"}
    assert "time" not in ds.m0.dims
    assert "x" not in ds


def test_nothing_of_measures_decides_a_run() -> None:
    asked = ["max(x.x)", "count(x.x > 0.1)", "integral(x.x, x.y < 0.2 and x.x > 0)"]
    full = SPRING | {"output": {"every": 0.5}}
    for integrator in ({"step": 0.01, "end_time": 1.0}, SPRING["integrator"]):
        without, with_them = (
            lienumba.run(full | {"integrator": integrator}),
            measured(asked, full, integrator=integrator),
        )
        assert without.attrs["scenario_sha256"] == with_them.attrs["scenario_sha256"]
        for name in without.data_vars:
            np.testing.assert_array_equal(without[name].values, with_them[name].values)


PENDULUM = SPRING | {
    "model": {
        "gravity": [0, 0, -9.81],
        "bodies": [parts.body("bob", 1.0, 1, position=[0.3, 0, 0])],
        "joints": [parts.hinge("pin", "bob")],
    },
    "start": {"q": {"pin": 0.1}, "qd": {"pin": "3*start"}},
    "quantities": [{"name": "x", "type": "point", "body": "bob"}, {"name": "v", "type": "point", "body": "bob"}],
}
PENDULUM["quantities"][1]["derivative"] = 1


@pytest.mark.parametrize("inline", [step_kernels.INLINE, 0])
def test_a_run_is_measured_alike_by_both_drivers_and_alone(inline: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where lanes have a time of their own, as with an event, and where they have not; as one kernel or by stages."""
    monkeypatch.setattr(step_kernels, "INLINE", inline)
    asked = ["max(x.z, t > 0.4)", "time_of_min(x.x)", "count(x.z > 0.1)", "integral(x.x*v.x)", "rms(v.x, x.z > 0)"]
    asked += ["mean(abs(x.z))", "last_time(x.z > -0.1)", "at(x.x, 0.33)", "final(x.x)", "overshoot(x.z, 0.1)"]
    steps = {"integrator": {"step": 0.02, "end_time": 1.0, "method": "dp54"}}
    together = measured(asked, PENDULUM, **steps)
    queued = measured(asked, PENDULUM | {"events": [{"name": "far", "when": "x.z > 0.29"}]}, **steps)
    wanted = [{"name": f"m{n}", "value": text} for n, text in enumerate(asked)]
    alone = lienumba.run(PENDULUM | {"measures": wanted[::-1]} | steps, runs=[13])
    for name in (x["name"] for x in wanted):
        np.testing.assert_array_equal(together[name], queued[name])
        np.testing.assert_array_equal(together[name].sel(run=[13]), alone[name])
    assert np.isfinite(together.m0).all()
    x, v = together["m8"], 3.0 * together["parameters.start"]
    assert len(np.unique(x)) == len(np.unique(v)) == 20


def test_runs_that_end_early() -> None:
    """At an event what is asked for is known there; a run that failed has no measure."""
    stops = THROW | {"events": [{"name": "hit", "when": "p.z < -1", "action": "stop"}]}
    hit = (UP + np.sqrt(UP**2 + 2 * G)) / G
    ends = ["final(t)", "final(p.z)", "mean(p.z)", "min(p.z)", "count(p.z < -1)"]
    ds = measured(ends, stops, integrator={"end_time": 9.0, "tolerance": 1e-9})
    np.testing.assert_allclose([float(ds[f"m{n}"][0]) for n in range(5)], [hit, -1, area(hit) / hit, -1, 1], atol=1e-9)
    blows = SPRING | {"sweep": {"runs": 1}, "integrator": {"step": 1.0, "end_time": 900.0}}
    blows["parameters"] = {"start": 1.0, "w": 30.0}
    ds = measured(["max(x.x)", "time_when(x.x > 0)"], blows)
    assert ds.status.values[0] > 0
    assert np.isnan([ds.m0.values[0], ds.m1.values[0]]).all()


def test_names_of_measures_are_numbers_of_runs(tmp_path: Path) -> None:
    """In requirements, in the rule by which a sweep ends, in files that are resumed, and in replays."""
    sweep = SPRING["sweep"] | {"stop": {"variable": "farthest out", "width": 0.5, "every": 10}}
    asked = {
        "measures": [{"name": "farthest out", "value": "max(x.x)", "units": "m"}],
        "requirements": [{"name": "near", "value": "farthest out", "below": 1.0, "probability": 0.1}],
    }
    ds = lienumba.run(SPRING | asked | {"sweep": sweep})
    assert ds.sizes["run"] == 10
    np.testing.assert_allclose(ds.requirement_margin[:, 0], 1.0 - ds["farthest out"], atol=1e-12)
    assert ds.requirement_units.values.tolist() == ["m"]
    path = tmp_path / "s.nc"
    lienumba.run(SPRING | asked, output=path)
    with xr.open_dataset(path) as stored:
        np.testing.assert_array_equal(stored["farthest out"][:10], ds["farthest out"])
        again = lienumba.replay(stored, 7)
        assert again["farthest out"].values[0] == stored["farthest out"].values[7]


WRONG = {
    "p.z": "reads p.z outside of a reducer, but that is another number at every time; write final(p.z), max(p.z) or "
    "another number of its course",
    "3*k": "is no number of a whole run; write one of max(...), min(...)",
    "max(mean(p.z))": "has mean(p.z) inside of max, but that is one number for the whole run; compute with it outside "
    "of max",
    "at(p.z, hitt)": 'has "hitt", which is no event and no number; the nearest known name is "hit"',
    "at(p.z, -1)": "asks for a value at -1.0 s, but runs go from 0 to 1.0 s; give a time in between, or write "
    "final(...)",
    "at(p.z, 1.5)": "asks for a value at 1.5 s, but runs go from 0 to 1.0 s; give a time in between",
    "at(p.z, t)": 'gives at "t", which changes with time, where it takes a time or event; give a number or a '
    "parameter, or the name of an event",
    "max(p.zz)": 'has the unknown name "p.zz"; the nearest known name is "p.z"',
    "count(p.z)": 'gives count the number "p.z", it takes a condition; compare it, such as in pointing.angle > 0.1',
    "max(p.z > 1)": 'gives max the condition "p.z > 1" where it takes a number; write max(pointing.angle, t > 5); how '
    "long one holds is time_when(condition)",
    "first_time(p.z > 0, t > 1)": "gives first_time 2 arguments, it takes a condition; write first_time(pointing.angle "
    "> 0.1)",
    "t + max(p.z)": "has t outside of a reducer; write final(t), when the run ends, or first_time(...)",
    "large(p.z)": 'calls the unknown function "large"',
    "max(p.z) if 1 else 0": 'contains "max(p.z) if 1 else 0", which is not allowed; use numbers, + - * / **, '
    "comparisons, max(p.z), pi",
    "max(p.z)[0]": 'contains "max(p.z)[0]", which is not allowed',
    "hypot(max(p.z), x=1)": 'contains "hypot(max(p.z), x=1)", which is not allowed',
    "max(p.z) + True": 'contains "True", which is not allowed',
    "max(p.z) > 1": "is a condition, not a number; write where(condition, 1, 0)",
    "max(p)": 'uses "p", which has several numbers; write p.x or p.y or p.z',
    "max(p.z": 'has 1 "(" and 0 ")"; give each its other half',
}


@pytest.mark.parametrize(("text", "sentence"), WRONG.items())
def test_what_is_wrong_with_a_formula_is_said(text: str, sentence: str) -> None:
    with pytest.raises(ScenarioError) as caught:
        measured([text], integrator={"step": 0.1, "end_time": 1.0})
    assert str(caught.value).startswith(f'measures.m0.value = "{text}": {sentence}')


def test_measures_are_not_made_of_measures() -> None:
    asked = [{"name": "high", "value": "max(p.z)"}, {"name": "twice", "value": "2*high"}]
    said = r"uses the measure \"high\", but a measure is made of the course of a run.*write the formula of high in its"
    with pytest.raises(ScenarioError, match=said):
        lienumba.run(THROW | {"measures": asked, "integrator": {"step": 0.1, "end_time": 1.0}})


def test_names_that_are_taken_are_refused() -> None:
    for name, sentence in (
        ("status", 'measures.status.name = "status": the dataset has a variable of this name already'),
        ("p", "measures: gives p, but the dataset has a variable of this name already"),
        ("a/b", 'measures.a/b.name = "a/b": is no valid name; give words without'),
    ):
        asked = [{"name": name, "value": "max(p.z)"}]
        with pytest.raises(ScenarioError) as caught:
            lienumba.run(THROW | {"measures": asked, "integrator": {"step": 0.1, "end_time": 1.0}})
        assert sentence in str(caught.value)


def test_the_formula_of_a_requirement_that_has_the_name_of_a_quantity_is_refused_as_a_requirement() -> None:
    asked = [{"name": "p", "value": "max(p.z)", "below": 1.0, "probability": 0.9}]
    with pytest.raises(ScenarioError, match=r"^requirements: gives p, but the dataset has a variable"):
        lienumba.run(THROW | {"requirements": asked, "integrator": {"step": 0.1, "end_time": 1.0}})


def test_noise_is_measured_sample_by_sample() -> None:
    """Steps land on the samples of a noise that is held: means and extremes are those of the samples."""
    data = SPRING | {
        "noise": [{"name": "gust", "type": "white", "std": 2.0, "every": 0.1}],
        "output": {"every": 0.1, "variables": ["gust"]},
        "integrator": {"step": 0.02, "end_time": 1.0},
        "sweep": SPRING["sweep"] | {"runs": 3},
    }
    data["model"] = SPRING["model"] | {
        "forces": [{"name": "push", "type": "force", "body": "bob", "value": ["gust", 0, 0]}]
    }
    for integrator in (data["integrator"], {"tolerance": 1e-8, "end_time": 1.0}):
        ds = measured(
            ["mean(gust)", "max(gust, t < 0.95)", "rms(gust)", "final(v.x)"],
            _with_velocity(data),
            integrator=integrator,
        )
        held = ds["gust"].values[:, :-1]
        np.testing.assert_allclose(ds.m0, held.mean(axis=1), rtol=0, atol=1e-12)
        np.testing.assert_array_equal(ds.m1, held.max(axis=1))
        np.testing.assert_allclose(ds.m2, np.sqrt((held**2).mean(axis=1)), rtol=1e-12)
        np.testing.assert_allclose(ds.m3, held.mean(axis=1), rtol=0, atol=1e-10)  # what pushes a mass of 1 kg for 1 s


def _with_velocity(data: dict[str, Any]) -> dict[str, Any]:
    velocity = {"name": "v", "type": "point", "body": "bob", "derivative": 1}
    return data | {"quantities": [*data["quantities"], velocity]}


@pytest.mark.parametrize(
    "integrator", [{"step": 2e-3}, {"tolerance": 1e-10}, {"tolerance": 1e-10, "coordinates": "joint"}]
)
def test_reactions_of_a_pendulum(integrator: dict[str, Any]) -> None:
    """A point on a thread of 0.5 m, from rest where it is level: the thread pulls with 3 m g sin of the angle below."""
    rod = parts.body("bob", 2.0, 1e-9, position=[0.5, 0, 0], rotation=[1, 0, 0, 0])
    data = {
        "model": {"gravity": [0, 0, -G], "bodies": [rod], "joints": [parts.hinge("pin", "bob")]},
        "quantities": [
            {"name": "load", "type": "reaction", "joint": "pin"},
            {"name": "p", "type": "point", "body": "bob"},
        ],
        "output": {"every": 0.5},
    }
    texts = ["max(load.force.z)", "time_of_max(load.force.z) - time_of_min(p.z)"]
    texts += ["max(hypot(load.force.x, load.force.z))", "count(load.force.z > 0.1)"]
    ds = measured(texts, data, integrator={"end_time": 0.5, **integrator})
    np.testing.assert_allclose(ds.m0, 3 * 2.0 * G, rtol=1e-7)
    np.testing.assert_allclose(ds.m1, 0.0, atol=1e-6)
    np.testing.assert_allclose(ds.m2, 3 * 2.0 * G, rtol=1e-7)
    assert float(ds.m3[0]) == 1


@pytest.mark.parametrize("integrator", [{"step": 1e-3}, {"tolerance": 1e-10}])
def test_bounces_and_locks(integrator: dict[str, Any]) -> None:
    """A ball that falls from 0.2 m loses half of its speed at the floor; a wheel is locked where it has turned by 1."""
    bodies = [
        parts.body(name, 1.0, 1, position=place, rotation=[1, 0, 0, 0])
        for name, place in (("ball", [0, 0, 0.3]), ("wheel", [3, 0, 0]))
    ]
    data = {
        "model": {
            "gravity": [0, 0, -G],
            "bodies": bodies,
            "joints": [parts.hinge("hub", "wheel", [3, 0, 0], rate=4.0)],
            "contacts": [parts.sphere("floor", "ball", 0.1, normal=[0, 0, 1], restitution=0.5)],
        },
        "quantities": [
            {"name": "p", "type": "point", "body": "ball"},
            {"name": "turn", "type": "joint", "joint": "hub"},
        ],
        "events": [{"name": "there", "when": "turn.angle > 1", "action": "lock", "joint": "hub"}],
        "output": {"every": 0.05},
    }
    fall = np.sqrt(2 * 0.2 / G)
    texts = ["min(p.z)", f"max(p.z, t > {fall + 0.01})", f"time_of_max(p.z, t > {fall + 0.01})", "count(p.z > 0.12)"]
    texts += ["max(turn.angle)", "final(turn.rate)", "max(turn.rate)", "integral(turn.rate)", "at(p.z, there)"]
    texts += ["time_when(turn.rate > 2)", "mean(p.z, t < 0.1)"]
    ds = measured(texts, data, integrator={"end_time": 0.45, **integrator})
    found = [float(ds[f"m{n}"][0]) for n in range(len(texts))]
    there = 0.1 + _height(0.25, fall)
    exact = [0.1, 0.1 + 0.25 * 0.2, 1.5 * fall, 2, 1.0, 0.0, 4.0, 1.0, there, 0.25, 0.3 - G / 6 * 0.01]
    np.testing.assert_allclose(found, exact, rtol=0, atol=1e-7)


def _height(t: float, fall: float) -> float:
    """Of a ball above the floor, that fell from 0.2 m and goes up with half of its speed."""
    return 0.2 - G / 2 * t * t if t < fall else 0.5 * G * fall * (t - fall) - G / 2 * (t - fall) ** 2
