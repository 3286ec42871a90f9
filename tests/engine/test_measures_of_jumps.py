"""Formulas of whole runs of what jumps where steps end: noise that is held, tables, and what they push."""

from typing import Any

import numpy as np
import pytest
import xarray as xr

import lienumba
from lienumba.mechanics.elements import quantities
from lienumba.scenario.start.prepare import prepare
from tests.facade import resolve

pytestmark = pytest.mark.filterwarnings("ignore:.*nothing uses it")
EVERY, COUNT, RUNS = 0.1, 10, 20  # more runs than lanes: each takes the place of another one
STEPS = [
    {"step": 0.02},
    {"step": EVERY},
    {"step": 0.02, "method": "dop853"},
    {"step": 0.05, "method": "radau5"},
    {"tolerance": 1e-8},
    {"tolerance": 1e-8, "max_step": 0.03},
    {"tolerance": 1e-8, "method": "taylor"},
    {"tolerance": 1e-8, "method": "radau5"},
]
PUSHED: dict[str, Any] = {
    "noise": [{"name": "gust", "type": "white", "std": 2.0, "every": EVERY}],
    "model": {
        "bodies": [{"name": "b", "mass": 2.0, "inertia": [1, 1, 1], "position": [0, 0, 0]}],
        "forces": [{"name": "push", "type": "force", "body": "b", "value": ["gust", 0, 0]}],
    },
    "quantities": [
        {"name": "p", "type": "point", "body": "b"},
        {"name": "v", "type": "point", "body": "b", "derivative": 1},
        {"name": "a", "type": "point", "body": "b", "derivative": 2},
        {"name": "twice", "type": "expression", "value": "2*gust"},
    ],
    "output": {"every": EVERY, "variables": ["gust"]},
    "sweep": {"runs": RUNS, "seed": 5},
}


def measured(texts: list[str], integrator: dict[str, Any], scenario: dict[str, Any] = PUSHED) -> xr.Dataset:
    measures = [{"name": f"m{n}", "value": text} for n, text in enumerate(texts)]
    return lienumba.run(scenario | {"measures": measures, "integrator": integrator | {"end_time": EVERY * COUNT}})


@pytest.mark.parametrize("integrator", STEPS, ids=str)
def test_each_side_of_a_jump_belongs_to_its_own_step(integrator: dict[str, Any]) -> None:
    """What begins where the run ends is no part of it."""
    expected = {
        "max(gust)": lambda x: x.max(axis=1),
        "min(twice)": lambda x: 2 * x.min(axis=1),
        "mean(abs(gust))": lambda x: abs(x).mean(axis=1),
        "integral(where(t < 0.5, twice, 0))": lambda x: 2 * EVERY * x[:, :5].sum(axis=1),
        "max(gust - sign(t - 0.5))": lambda x: (x + np.repeat([1, -1], 5)).max(axis=1),
        "max(a.x)": lambda x: x.max(axis=1) / 2,
        "integral(abs(a.x))": lambda x: EVERY * abs(x).sum(axis=1) / 2,
        "time_when(a.x > 0.5)": lambda x: EVERY * (x > 1).sum(axis=1),
        "count(gust > 1)": lambda x: (np.diff(x > 1, prepend=False, axis=1) & (x > 1)).sum(axis=1),
        "first_time(gust > 1)": lambda x: np.where((x > 1).any(axis=1), EVERY * (x > 1).argmax(axis=1), np.nan),
        "max(abs(v.x))": lambda x: abs(np.cumsum(x, axis=1)).max(axis=1) * EVERY / 2,
    }
    ds = measured(list(expected), integrator)
    samples = ds["gust"].values[:, :COUNT]
    for n, (text, known) in enumerate(expected.items()):
        np.testing.assert_allclose(ds[f"m{n}"], known(samples), rtol=1e-9, atol=1e-8, err_msg=text)


@pytest.mark.parametrize("integrator", STEPS, ids=str)
def test_a_run_among_others_has_the_bits_that_it_has_alone(integrator: dict[str, Any]) -> None:
    texts = ["max(p.x, t > 0.35)", "max(a.x)", "mean(abs(gust))", "last_time(v.x > 0.01)"]
    many = measured(texts, integrator)
    for run in (0, 9, RUNS - 1):
        alone = lienumba.replay(many, run=run)
        for n in range(len(texts)):
            assert alone[f"m{n}"].values.tobytes() == many[f"m{n}"].values[run : run + 1].tobytes()


def test_a_ramp_that_drops_is_measured_up_to_where_it_drops() -> None:
    """Its largest value is what it comes to, whether it drops at the end of a step of one length or not."""
    saw = {"name": "saw", "type": "expression", "value": "mod(t, 0.25)"}
    force = {"name": "push", "type": "force", "body": "b", "value": ["mod(t, 0.25)", 0, 0]}
    scenario = PUSHED | {"quantities": [saw], "model": PUSHED["model"] | {"forces": [force]}, "noise": []}
    scenario |= {"output": {"every": EVERY}, "sweep": {}}
    for integrator in ({"step": 0.1}, {"step": 0.05}, {"tolerance": 1e-8}):
        ds = measured(["max(saw)", "integral(saw)"], integrator, scenario)
        np.testing.assert_allclose([ds.m0.item(), ds.m1.item()], [0.25, 0.125], rtol=1e-6)


LEAPS = {
    "p.x": False,
    "abs(p.x) + sign(v.x)": False,
    "v.x*sin(t)": False,
    "min(p.x, t)": False,
    "where(p.x > 0, v.x, 1)": False,
    "where(t > 0.3, v.x, 1)": True,
    "floor(t)": True,
    "gust": True,
    "twice": True,
    "a.x": True,
}


@pytest.mark.parametrize(("text", "leaps"), LEAPS.items())
def test_what_may_jump_where_no_body_does(text: str, leaps: bool) -> None:
    integrator = {"step": 0.1, "end_time": 1.0}
    scenario = resolve(PUSHED | {"measures": [{"name": "m", "value": f"max({text})"}], "integrator": integrator})
    model = prepare(scenario, range(1)).model
    signal, *_ = quantities.signals(model)
    assert quantities.leaps(model, signal) == leaps


@pytest.mark.parametrize("integrator", STEPS, ids=str)
def test_at_a_time_at_which_noise_jumps_the_value_behind_the_jump_counts(integrator: dict[str, Any]) -> None:
    """As in what is stored then; nothing is behind the end of the run. A time beyond it never comes."""
    texts = [*(f"at(gust, {k}*{EVERY})" for k in range(COUNT + 1)), "at(gust, late)"]
    varied = {
        "seed": 5,
        "runs": RUNS,
        "vary": {"parameters.late": {"distribution": "uniform", "low": 1.5, "high": 2.0}},
    }
    ds = measured(texts, integrator, PUSHED | {"parameters": {"late": 1.5}, "sweep": varied})
    gust = ds["gust"].transpose("run", "time").values
    found = np.array([ds[f"m{n}"].values for n in range(COUNT + 1)]).T
    np.testing.assert_array_equal(found[:, :COUNT], gust[:, :COUNT])
    np.testing.assert_array_equal(found[:, COUNT], gust[:, COUNT - 1])
    assert np.isnan(ds[f"m{COUNT + 1}"]).all()
