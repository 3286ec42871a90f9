"""Formulas of whole runs about conditions of events, of what comes to rest, and of what jumps where a step ends."""

from typing import Any

import numpy as np
import pytest
import xarray as xr
from scipy.spatial.transform import Rotation

import lienumba
from tests.rigs import parts

pytestmark = pytest.mark.filterwarnings("ignore:.*nothing uses it")
BODY = parts.body("b", 2.0, [0.3, 0.6, 0.4], position=[0, 0, 0], rotation=[1, 0, 0, 0])
POINT = {"name": "p", "type": "point", "body": "b"}
METHODS: list[dict[str, Any]] = [
    {"step": 0.05},
    {"tolerance": 1e-9},
    {"tolerance": 1e-9, "method": "taylor"},
    {"tolerance": 1e-9, "method": "radau5"},
]


def measured(model: dict[str, Any], measures: dict[str, str], integrator: dict[str, Any], **more: Any) -> xr.Dataset:
    asked = [{"name": name, "value": text} for name, text in measures.items()]
    scenario = {"model": model, "integrator": integrator, "measures": asked, "output": {"every": 0.5}} | more
    return lienumba.run(scenario, progress=False)


@pytest.mark.parametrize("condition", ["v.z < 0 and p.z < -1", "p.z < -1 or t > 4", "v.z**2 > 30 and v.z < 0"])
@pytest.mark.parametrize("integrator", METHODS, ids=str)
def test_what_stops_a_run_has_happened_whatever_its_condition(integrator: dict[str, Any], condition: str) -> None:
    """Of 200 throws 84 and more had no speed at their end, and failed what was asked of it."""
    ds = measured(
        {"bodies": [BODY | {"velocity": [0.3, 0, "v0"]}]},
        {"speed": "at(v.z, landed)", "first": f"first_time({condition})", "n": f"count({condition})"},
        integrator | {"end_time": 5.0},
        parameters={"v0": 1.0},
        quantities=[POINT, POINT | {"name": "v", "derivative": 1}],
        events=[{"name": "landed", "when": condition, "action": "stop"}],
        sweep=parts.sweep(100, {"parameters.v0": (1, 3)}, seed=1),
    )
    v0 = ds["parameters.v0"].values
    speed = np.full_like(v0, -np.sqrt(30)) if "**" in condition else -np.sqrt(v0**2 + 2 * 9.81)
    np.testing.assert_allclose(ds["speed"], speed, rtol=1e-6)
    np.testing.assert_allclose(ds["first"], ds["event_time"][:, 0], rtol=1e-12)
    np.testing.assert_array_equal(ds["n"], 1.0)


@pytest.mark.parametrize("action", ["record", "set", "lock"])
@pytest.mark.parametrize("more", ["", " and t > 0.1"])
@pytest.mark.parametrize("integrator", METHODS, ids=str)
def test_a_condition_that_does_something_is_true_once(integrator: dict[str, Any], more: str, action: str) -> None:
    """It was counted twice, where rounding had it false behind what it did; what is locked there stays there."""
    condition = f"j.displacement > 0.5{more}"
    slide = parts.joint("j", "prismatic", "b", at=[0, 0, 0], axis=[0.6, 0, 0.8])
    does = {"record": {}, "set": {"parameters": {"f": 0.5}}, "lock": {"joint": "j"}}[action]
    ds = measured(
        {
            "gravity": [0, 0, 0],
            "bodies": [BODY],
            "joints": [slide | {"speed": "v0"}],
            "forces": [{"type": "actuator", "joint": "j", "value": "f"}],
        },
        {
            "speed": "at(j.speed, ev)",
            "first": f"first_time({condition})",
            "n": f"count({condition})",
            "long": f"time_when({condition})",
            "last": f"last_time({condition})",
        },
        integrator | {"end_time": 1.5},
        parameters={"v0": 1.0, "f": 1.0},
        quantities=parts.observed("joint", "j"),
        events=[{"name": "ev", "when": condition, "action": action, **does}],
        sweep=parts.sweep(100, {"parameters.v0": (1, 3)}, seed=1),
    )
    v0 = ds["parameters.v0"].values
    time = 2.0 * (np.sqrt(v0**2 + 0.5) - v0)
    np.testing.assert_allclose(ds["first"], time, rtol=1e-9)
    np.testing.assert_allclose(ds["speed"], v0 + 0.5 * time, rtol=1e-9)
    np.testing.assert_array_equal(ds["n"], 1.0)
    np.testing.assert_allclose(ds["long"], 1.5 - time, rtol=1e-9)
    np.testing.assert_allclose(ds["last"], 1.5, rtol=1e-9)


@pytest.mark.parametrize("turn", [[0.0, 0.0, 0.0], [0.4, -0.7, 0.3]], ids=str)
@pytest.mark.parametrize("integrator", [*METHODS, {"tolerance": 1e-9, "max_step": 0.004}], ids=str)
def test_what_has_come_to_rest_does_not_rise(integrator: dict[str, Any], turn: list[float]) -> None:
    """A ball that bounces to rest, on a floor that lies anywhere in space, where what is left of speeds is rounding.
    Its bounces are counted by what they set, too: from one to the next is one long step."""
    g, drop, radius, back, rest = 9.81, 1.0, 0.1, 0.7, 0.05
    n = (Rotation.from_rotvec(turn).as_matrix() @ [0, 0, 1]).tolist()
    speed, rises, up, way, time = np.sqrt(2 * g * drop), 0, 0.0, 0.0, np.sqrt(2 * drop / g)
    while back * speed > rest:
        speed *= back
        rises, up, way, time = rises + 1, up + speed / g, way + speed**2 / 2 / g, time + 2 * speed / g
    ds = measured(
        {
            "gravity": [-g * x for x in n],
            "bodies": [BODY | {"position": [(drop + radius) * x for x in n], "mass": 0.5}],
            "contacts": [parts.sphere("floor", "b", radius, normal=n, restitution=back, rest_speed=rest)],
        },
        {
            "rises": "count(w > 0)", "up": "time_when(w > 0)", "last": "last_time(w > 0)", "mean": "mean(w, w > 0)",
            "number": "final(k)",
        },
        integrator | {"end_time": 5.0},
        parameters={"hits": 0.0},
        quantities=[
            POINT | {"name": "v", "derivative": 1},
            {"name": "c", "type": "contact", "contact": "floor"},
            {"name": "w", "type": "expression", "value": f"v.x*{n[0]} + v.y*{n[1]} + v.z*{n[2]}"},
            {"name": "k", "type": "expression", "value": "hits + 0*c.gap"},
        ],
        events=[
            {"name": "up", "when": "w > 0"},
            {"name": "hit", "when": "c.gap < 0", "action": "set", "parameters": {"hits": "hits + 1"}},
            {"name": "low", "when": "c.gap < 1e-6"},
        ],
    )  # fmt: skip
    found = [float(ds[name][0]) for name in ("rises", "up", "last", "mean", "number")]
    np.testing.assert_allclose(found, [rises, up, time - speed / g, way / up, rises + 1], rtol=1e-9)
    np.testing.assert_array_equal(ds["event_count"][0], [rises, rises + 1, rises + 1])


@pytest.mark.parametrize("integrator", [
    {"step": 0.1}, {"step": 0.1, "method": "heun"}, {"step": 0.1, "method": "dp54"}, {"step": 0.01},
    {"tolerance": 1e-9}, {"step": 0.1, "method": "radau5"},
], ids=str)  # fmt: skip
def test_each_side_of_what_jumps_where_a_step_ends(integrator: dict[str, Any]) -> None:
    """A crank that is driven through half a turn in whole steps: stages lie on the other side of the jump already."""
    ds = measured(
        {
            "gravity": [0, 0, 0],
            "bodies": [BODY],
            "joints": [parts.hinge("j", "b", axis=parts.Z)],
            "drivers": [{"joint": "j", "value": "0.5*pi*t"}],
        },
        {
            "half": "mean(where(j.angle < pi, 1, 0))",
            "sign": "integral(sign(sin(j.angle)))",
            "other": "integral(sign(j.angle - pi))",
            "rms": "rms(where(j.angle < pi, 1, 0))",
        },
        integrator | {"end_time": 4.0},
        quantities=parts.observed("joint", "j"),
    )
    found = [float(ds[name][0]) for name in ("half", "sign", "other", "rms")]
    np.testing.assert_allclose(found, [0.5, 0.0, 0.0, np.sqrt(0.5)], rtol=0, atol=1e-9)


@pytest.mark.filterwarnings("ignore:.*can never be true")
@pytest.mark.parametrize("integrator", METHODS, ids=str)
def test_conditions_of_which_a_part_never_changes(integrator: dict[str, Any]) -> None:
    """An own number that arms what a motion sets off."""
    texts = [
        "p.z < 0.5 and armed > 0.5",
        "armed > 0.5 and p.z < 0.5",
        "v.z < -1 or armed < 0.5",
        "not armed < 1 and t > 1/8",
    ]
    for armed, first in ((1.0, [0.1**0.5, 0.1**0.5, 0.1, 0.125]), (0.0, [np.nan, np.nan, 0.0, np.nan])):
        ds = measured(
            {"gravity": [0, 0, -10.0], "bodies": [BODY | {"position": [0, 0, 1]}]},
            {f"first{n}": f"first_time({text})" for n, text in enumerate(texts)},
            integrator | {"end_time": 0.5},
            parameters={"armed": armed},
            quantities=[POINT, POINT | {"name": "v", "derivative": 1}],
            events=[{"name": f"e{n}", "when": text} for n, text in enumerate(texts)],
        )
        np.testing.assert_allclose([ds[f"first{n}"].item() for n in range(len(texts))], first, rtol=1e-9)
        np.testing.assert_allclose(ds["event_time"][0], first, rtol=1e-9)


@pytest.mark.parametrize("integrator", METHODS, ids=str)
def test_what_sticks_does_not_slip_and_what_is_closed_has_no_gap(integrator: dict[str, Any]) -> None:
    """A box slides to rest on a driven table; then it is carried, whatever roundoff says of speeds and gaps."""
    mu, g, speed, end = 0.3, 9.81, 1.0, 2.0
    conditions = ["f.slip > 0", "f.slip > 1e-12", "f.gap > 0", "f.gap < 0", "f.slip <= 0"]
    texts = [f"{name}({x})" for x in conditions for name in ("last_time", "time_when", "count")]
    box = parts.resting("box", 1.0, position=[0, 0, 0.1]) | {"velocity": [speed + 0.5, 0, 0]}
    ds = measured(
        {
            "bodies": [box, parts.body("table", 5.0, position=[0, 0, 0], rotation=[1, 0, 0, 0])],
            "joints": [parts.joint("rail", "prismatic", "table", at=[0, 0, 0], axis=[1, 0, 0])],
            "drivers": [{"joint": "rail", "value": "0.5*t"}],
            "contacts": [
                parts.foot(f"f{n}", "box", [x, y, -0.1], to="table", normal=[0, 0, 1], friction=mu)
                for n, (x, y) in enumerate([(0.3, 0.2), (-0.3, 0.2), (0.0, -0.3)])
            ],
        },
        {f"m{n}": text for n, text in enumerate(texts)},
        integrator | {"end_time": end},
        quantities=[{"name": "f", "type": "contact", "contact": "f0"}],
        events=[{"name": f"e{n}", "when": x} for n, x in enumerate(conditions)],
    )
    rests = speed / (mu * g)
    found = np.reshape([float(ds[f"m{n}"][0]) for n in range(len(texts))], (-1, 3))
    slips, never = [rests, rests, 1.0], [np.nan, 0.0, 0.0]
    np.testing.assert_allclose(found, [slips, slips, never, never, [end, end - rests, 1.0]], rtol=1e-8)
    np.testing.assert_array_equal(ds["event_count"][0], [1, 1, 0, 0, 1])


@pytest.mark.parametrize("action", ["record", "set", "lock", "stop"])
@pytest.mark.parametrize("condition", ["t > 0.5", "p.x > 0.5", "jump(t) > 0.5"])
@pytest.mark.parametrize("integrator", METHODS, ids=str)
def test_a_value_at_an_event_is_that_before_it_acts(integrator: dict[str, Any], condition: str, action: str) -> None:
    """Of states and numbers the one before, of what jumps with the time the one behind; as `event_` variables are."""
    slide = parts.joint("j", "prismatic", "b", at=[0, 0, 0], axis=[1, 0, 0], speed=1.0)
    does = {"set": {"parameters": {"k": 5.0}}, "lock": {"joint": "j"}}.get(action, {})
    values = {"p.x": 0.5, "v.x": 1.0, "v.x + 0*t": 1.0, "jump(t)": 1.0, "t": 0.5, "k": 1.0}
    ds = measured(
        {"gravity": [0, 0, 0], "bodies": [BODY], "joints": [slide]},
        {f"m{n}": f"at({x}, ev)" for n, x in enumerate(values)}
        | {"first": f"first_time({condition})", "n": f"count({condition})"},
        integrator | {"end_time": 1.0},
        parameters={"k": 1.0},
        tables={"jump": {"times": [0, 0.5, 1], "values": [0, 1, 1], "interpolation": "hold"}},
        quantities=[POINT, POINT | {"name": "v", "derivative": 1}]
        + [{"name": f"q{n}", "type": "expression", "value": x} for n, x in enumerate(values)],
        events=[{"name": "ev", "when": condition, "action": action} | does],
        output={"every": 0.5, "at_events": [f"q{n}" for n in range(len(values))]},
    )
    for name in ("m{}", "event_q{}"):
        found = [ds[name.format(n)].item() for n in range(len(values))]
        np.testing.assert_allclose(found, [*values.values()], rtol=1e-9)
    np.testing.assert_allclose([ds["first"].item(), ds["n"].item()], [0.5, 1.0], rtol=1e-9)
