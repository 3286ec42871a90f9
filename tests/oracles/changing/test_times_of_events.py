"""Times of events that formulas read, and events with a delay, in closed form."""

from typing import Any

import numpy as np
import pytest

import lienumba
from tests.rigs import parts

pytestmark = pytest.mark.filterwarnings("ignore:.*nothing uses it")
G = 9.81
STONE = parts.body("stone", 1.0, 0.01, position=[0, 0, 0], rotation=[1, 0, 0, 0], velocity=[0, 0, "up"])
SPEED = {"name": "v", "type": "point", "body": "stone", "derivative": 1}
METHODS: list[dict[str, Any]] = [
    {"tolerance": 1e-10},
    {"tolerance": 1e-10, "coordinates": "joint"},
    {"method": "rk4", "step": 0.01},
    {"method": "radau5", "tolerance": 1e-9},
    {"method": "taylor", "tolerance": 1e-10},
    {"method": "generalized_alpha", "step": 0.01},
]


def thrown(events: list[dict[str, Any]], integrator: dict[str, Any], model: Any = None, **more: Any) -> Any:
    """Stones that are thrown upwards, each with a speed of its own."""
    ds = lienumba.run({
        "parameters": {"up": G, "k": 0.0, "wait": 0.75} | more.pop("parameters", {}),
        "model": {"gravity": [0, 0, -G], "bodies": [STONE]} | (model or {}),
        "quantities": [SPEED],
        "events": events,
        "integrator": {"end_time": 4.0, **integrator},
        "sweep": more.pop("sweep", parts.sweep(20, {"parameters.up": (6.0, 13.0)})),
        **more,
    }, progress=False)  # fmt: skip
    assert (ds.status == 0).all()
    return ds, ds["parameters.up"].values / G


@pytest.mark.parametrize("integrator", METHODS, ids=str)
def test_formulas_read_when_an_event_happened(integrator: dict[str, Any]) -> None:
    """Infinite before it: nothing is later, all is earlier. Conditions, measures and what events set may read it."""
    ds, top = thrown(
        [
            {"name": "top", "when": "v.z < 0"},
            {"name": "later", "when": "t > event_time.top + 1.5"},
            {"name": "before", "when": "t < event_time.top"},
            {"name": "both", "when": "v.z < -1 and 1 + t - event_time.top > 1.25"},
            {"name": "note", "when": "v.z < -2", "action": "set", "parameters": {"k": "t - event_time.top"}},
        ],
        integrator,
        measures=[
            {"name": "while", "value": "time_when(t > event_time.top + 0.5)"},
            {"name": "until", "value": "last_time(t < event_time.top)"},
            {"name": "latest", "value": "final(event_time.top)"},
            {"name": "k", "value": "final(k)"},
        ],
    )
    known = [top, top + 1.5, 0 * top, top + 0.25, top + 2 / G]
    np.testing.assert_allclose(ds.event_time, np.transpose(known), rtol=0, atol=1e-9)
    np.testing.assert_array_equal(ds.event_count, 1)
    for name, x in (("while", 3.5 - top), ("until", top), ("latest", top), ("k", 0 * top + 2 / G)):
        np.testing.assert_allclose(ds[name], x, rtol=0, atol=1e-9, err_msg=name)


@pytest.mark.parametrize("integrator", METHODS, ids=str)
def test_an_event_happens_so_long_behind_its_condition(integrator: dict[str, Any]) -> None:
    """A motor that is switched on by its own event, and off half a second later; one delay is a parameter."""
    slide = parts.joint("rail", "prismatic", "stone", at=[0, 0, 0], axis=[0, 0, 1], speed="up")
    stone = {key: x for key, x in STONE.items() if key != "velocity"}
    ds, top = thrown(
        [
            {"name": "on", "when": "v.z < 0", "delay": "wait", "action": "set", "parameters": {"k": G}},
            {"name": "off", "when": "k > 1", "delay": 0.5, "action": "lock", "joint": "rail"},
            {"name": "seen", "when": "t > event_time.off + 0.125"},
        ],
        integrator,
        {"bodies": [stone], "joints": [slide], "forces": [{"type": "actuator", "joint": "rail", "value": "k"}]},
    )
    assert [*ds.event.values] == ["on.condition", "on", "off.condition", "off", "seen"]
    known = [top, top + 0.75, top + 0.75, top + 1.25, top + 1.375]
    np.testing.assert_allclose(ds.event_time, np.transpose(known), rtol=0, atol=1e-9)
    height = top * top * G / 2 - G * 0.75**2 / 2 - 0.75 * G * 0.5
    np.testing.assert_allclose(ds.position.values[:, -1, 0, 2], height, rtol=0, atol=1e-7)


def test_a_condition_that_comes_back_begins_the_delay_anew() -> None:
    """A wave above 0 for half of each second: a delay of 0.7 s passes each time, one of 1.2 s at the last one only."""
    events = [{"name": f"e{n}", "when": "sin(2*pi*t) > 0 and t < 3.25", "delay": d} for n, d in enumerate((0.7, 1.2))]
    ds, _ = thrown(events, {"tolerance": 1e-9, "end_time": 5.0})
    np.testing.assert_allclose(ds.event_time.sel(event=["e0", "e1"])[0], [0.7, 4.2], rtol=0, atol=1e-9)
    np.testing.assert_array_equal(ds.event_count.sel(event=["e0.condition", "e0", "e1"])[0], [4, 4, 1])


def test_a_spring_that_an_event_stiffens_has_its_energy_booked() -> None:
    """A stiffness that reads the time of an event which locks nothing and sets nothing."""
    spring = {"type": "spring_damper", "bodies": ["ground", "stone"], "points": [[0, 0, -2], [0, 0, 0]],
              "stiffness": "where(t >= event_time.top, 20, 5)", "free_length": 1.0}  # fmt: skip
    ds, _ = thrown([{"name": "top", "when": "v.z < 0"}], {"tolerance": 1e-11}, {"forces": [spring]})
    assert abs(ds.energy_residual).max() < 1e-6
    assert np.ptp(ds.energy.values, axis=1).min() > 1.0


@pytest.mark.parametrize(("name", "match"), [
    ("event_time.tip", 'the unknown name "event_time.tip".*"?event_time.top'),
    ("event_time.far", 'the unknown name "event_time.far"'),
])  # fmt: skip
def test_wrong_names_of_events(name: str, match: str) -> None:
    """An event that ends the run has no time that anything could read."""
    events = [
        {"name": "top", "when": "v.z < 0"},
        {"name": "far", "when": "v.z < -50", "action": "stop"},
        {"name": "later", "when": f"t > {name} + 1"},
    ]
    with pytest.raises(lienumba.ScenarioError, match=match):
        thrown(events, {"tolerance": 1e-6})


def test_a_driver_may_not_read_the_time_of_an_event() -> None:
    slide = parts.joint("rail", "prismatic", "stone", at=[0, 0, 0], axis=[0, 0, 1])
    model = {"joints": [slide], "drivers": [{"joint": "rail", "value": "where(t > event_time.top, 1, t)"}]}
    with pytest.raises(lienumba.ScenarioError, match=r"event_time\.top, which an event sets.*cannot jump"):
        thrown([{"name": "top", "when": "v.z < 0"}], {"tolerance": 1e-6}, model)


@pytest.mark.parametrize("integrator", METHODS[::2], ids=str)
def test_a_condition_that_a_jump_makes_false_is_true_again(integrator: dict[str, Any]) -> None:
    """The time since a wave was last above 0.4: of 64 phases 10 missed one of three times at which it passes 0.3 s."""
    end, wait = 3.0, 0.3
    events = [
        {"name": "wave", "when": "sin(6*t + k) > 0.4"},
        {"name": "since", "when": f"t > event_time.wave + {wait}"},
    ]
    ds, _ = thrown(
        events,
        integrator | {"end_time": end},
        sweep=parts.sweep(64, {"parameters.k": (0.5, 3.5), "parameters.up": (6, 13)}),
    )
    k = ds["parameters.k"].values[:, None]
    rises = (np.arcsin(0.4) + 2 * np.pi * np.arange(8) - k) / 6
    begins = np.where(np.sin(k) > 0.4, 0.0, -1.0)
    for count, before in zip(ds.event_count.values.T, (end, end - wait), strict=True):
        expected = ((rises > 0) & (rises < before)).sum(axis=1) + (begins[:, 0] == 0)
        np.testing.assert_array_equal(count, expected)
