"""Loads that vary while all rests: no error keeps steps short, and what holds lets go on time, whatever the step."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import lienumba
from tests.rigs import parts

LOAD, END, RATIO = 4.0, 3.0, 1.3
METHODS = {"dop853": 1e-10, "tsit54": 1e-9, "radau5": 1e-9, "radau9": 1e-11, "taylor": 1e-11}
BOX = parts.body("box", 1.0, 0.1, position=[0, 0, 0])
SLIDE = parts.joint("s", "prismatic", "box", at=[0, 0, 0])
SWEEP = parts.sweep(24, {"parameters.c": (0.2, 3.05), "parameters.w": (3.0, 30.0)}, seed=3)


def run(model: dict[str, Any], method: str, coordinates: str, **more: Any) -> Any:
    integrator = {"method": method, "tolerance": METHODS[method], "end_time": END, "coordinates": coordinates}
    output = {"every": END, "max_changes": 256, "variables": ["s"]}
    return lienumba.run(
        {
            "parameters": {"c": 1.0, "w": 5.0},
            "model": {"gravity": [0, 0, 0], "bodies": [BOX], **model},
            "quantities": parts.observed("joint", "s"),
            "integrator": integrator,
            "output": output,
            "sweep": SWEEP,
            **more,
        },
        progress=False,
    )


def stick_slip(c: float, w: float, v: float) -> float:
    """Where a box of 1 kg is at the end that starts at 0 at v: phase by phase, looked at in steps of 1/400 of a
    period."""
    fine, t, x = 2 * np.pi / w / 400, 0.0, 0.0

    def load(t: float) -> float:
        return float(LOAD * np.sin(w * t))

    while t < END:
        if v == 0.0:
            times = np.append(np.arange(t, END, fine), END)
            over = np.flatnonzero(np.abs(LOAD * np.sin(w * times)) > RATIO * c)
            if abs(load(t)) <= RATIO * c:
                if not len(over):
                    return x
                t = brentq(lambda t: abs(load(t)) - RATIO * c, times[over[0] - 1], times[over[0]], xtol=1e-14)
            heading = np.sign(load(t))
        else:
            heading = np.sign(v)

        def stops(t: float, y: Any, heading: float = heading) -> float:
            return float(heading * y[1])

        stops.terminal, stops.direction = True, -1.0  # type: ignore[attr-defined]
        found = solve_ivp(
            lambda t, y, d=heading: [y[1], load(t) - c * d], (t, END), [x, v], method="DOP853", rtol=1e-13, atol=1e-15,
            max_step=10 * fine, events=stops, dense_output=True,
        )  # fmt: skip
        t, x, v = found.t[-1], found.y[0, -1], 0.0
    return float(x)


@pytest.mark.parametrize("coordinates", ["lie", "joint"])
@pytest.mark.parametrize("method", METHODS)
def test_what_sticks_under_a_swinging_load(method: str, coordinates: str) -> None:
    """It stays for many periods of the load, or for a moment of one."""
    friction = parts.dry("s", "c", f"{RATIO}*c")
    swing = {"type": "actuator", "joint": "s", "value": f"{LOAD}*sin(w*t)"}
    joint = {**SLIDE, "axis": [1, 0, 0], "speed": 0.5}
    ds = run({"joints": [joint], "forces": [friction, swing]}, method, coordinates)
    assert (ds.status == 0).all()
    runs = zip(ds["parameters.c"].values, ds["parameters.w"].values, strict=True)
    expected = [stick_slip(float(c), float(w), 0.5) for c, w in runs]
    np.testing.assert_allclose(ds["s.displacement"].values[:, -1], expected, atol=1e-6)


@pytest.mark.parametrize("coordinates", ["lie", "joint"])
@pytest.mark.parametrize("method", METHODS)
def test_what_rests_on_a_stop_is_lifted_on_time(method: str, coordinates: str) -> None:
    """By a force that is larger than its weight for a moment of each of its periods, and grows with time."""
    stop = {"joint": "s", "low": 0.0, "restitution": 0.0}
    pull = {"type": "actuator", "joint": "s", "value": "-9 + c*(1 + t)*sin(w*t)"}
    ds = run({"joints": [{**SLIDE, "axis": [0, 0, 1]}], "forces": [pull], "limits": [stop]}, method, coordinates)
    assert (ds.status == 0).all()
    for run_, (c, w) in enumerate(zip(ds["parameters.c"].values, ds["parameters.w"].values, strict=True)):
        times = np.linspace(0.0, END, 200_001)
        over = np.flatnonzero(c * (1 + times) * np.sin(w * times) > 9.0)
        opened = ds.change_time.values[run_][ds.change_kind.values[run_] == 6]
        if not len(over):
            assert not len(opened)
            continue
        lifts = brentq(lambda t, c=c, w=w: c * (1 + t) * np.sin(w * t) - 9.0, times[over[0] - 1], times[over[0]])
        assert opened[0] == pytest.approx(lifts, abs=1e-9)


@pytest.mark.parametrize("method", ["radau5", "taylor"])
def test_stops_and_friction_together(method: str) -> None:
    """With impacts, and rests on stops that friction bears with, all methods do the same."""
    friction = parts.dry("s", "c", f"{RATIO}*c")
    swing = {"type": "actuator", "joint": "s", "value": f"{LOAD}*sin(w*t) + where(t > 0.9, 2, 0)"}
    joint, stops = {**SLIDE, "axis": [1, 0, 0], "speed": 0.5}, {"low": -0.05, "high": 0.12, "restitution": 0.5}
    model = {"joints": [joint], "forces": [friction, swing], "limits": [{"joint": "s", **stops}]}
    measures = [{"name": "swept", "value": "integral(s.speed**2)"}]
    one, other = (run(model, x, "joint", measures=measures) for x in ("dop853", method))
    np.testing.assert_allclose(other.swept, one.swept, atol=1e-7)


FORCES = {  # N, rad/s, rad; of three of them
    **dict.fromkeys("ab", (1, 5)), "c": (0.5, 6), **dict.fromkeys("uvw", (2, 60)), **dict.fromkeys("pqr", (0, 6.28)),
}  # fmt: skip
PUSHED = 60  # runs


def tangential(x: dict[str, np.ndarray], t: Any) -> Any:
    return np.hypot(x["a"] * np.sin(x["u"] * t + x["p"]), x["b"] * np.sin(x["v"] * t + x["q"]))


def normal(x: dict[str, np.ndarray], t: Any) -> Any:
    return 9.81 - x["c"] * np.sin(x["w"] * t + x["r"])


def slipping() -> tuple[dict[str, np.ndarray], np.ndarray]:
    """Loads of a box on a plane, whose friction mu is passed once or a few times in 3 s, by 1e-4 to 0.3 of it, some of
    them for 1 ms; and when it is passed first."""
    rng, times = np.random.default_rng(7), np.linspace(0.0, END, 60_001)
    x = {name: rng.uniform(low, high, PUSHED) for name, (low, high) in FORCES.items()}
    x["mu"], expected = np.empty(PUSHED), np.empty(PUSHED)
    for k in range(PUSHED):
        one = {name: values[k] for name, values in x.items()}
        ratio = tangential(one, times) / normal(one, times)
        mu = max(ratio.max() / (1.0 + 10.0 ** rng.uniform(-4.0, -0.5)), 1.001 * ratio[0])

        def over(t: float, one: dict[str, np.ndarray] = one, mu: float = mu) -> float:
            return float(tangential(one, t) - mu * normal(one, t))

        first = np.flatnonzero(ratio > mu)[0]
        x["mu"][k], expected[k] = mu, brentq(over, times[first - 1], times[first], xtol=1e-14)
    return x, expected


def slide(x: dict[str, np.ndarray], folder: Path, method: str, tolerance: float) -> Any:
    table = folder / "loads.csv"
    np.savetxt(table, np.column_stack(list(x.values())), "%.17g", ",", header=",".join(x), comments="")
    floor = parts.foot("floor", "box", normal=[0, 0, 1], friction="mu")
    value = ["a*sin(u*t + p)", "b*sin(v*t + q)", "c*sin(w*t + r)"]
    model = {
        "gravity": [0, 0, -9.81],
        "bodies": [BOX],
        "contacts": [floor],
        "forces": [{"type": "force", "body": "box", "value": value}],
    }
    vary = {f"parameters.{name}": {"column": name} for name in x}
    return lienumba.run(
        {
            "parameters": dict.fromkeys(x, 1.0),
            "model": model,
            "integrator": {"method": method, "tolerance": tolerance, "end_time": END},
            "output": {"every": END, "max_changes": 256, "variables": ["position"]},
            "sweep": {"runs": PUSHED, "sampler": "table", "table": {"file": str(table)}, "vary": vary},
        },
        progress=False,
    )


@pytest.mark.parametrize(
    ("method", "tolerance"), [("radau5", 1e-8), ("taylor", 1e-10), ("dop853", 1e-5), ("dp54", 1e-9)]
)
def test_the_first_slip_under_loads_of_several_frequencies(method: str, tolerance: float, tmp_path: Path) -> None:
    x, expected = slipping()
    ds = slide(x, tmp_path, method, tolerance)
    assert (ds.status == 0).all()
    slips = [run[kind == 8][:1] for run, kind in zip(ds.change_time.values, ds.change_kind.values, strict=True)]
    np.testing.assert_allclose(np.concatenate(slips), expected, atol=1e-8)


@pytest.mark.parametrize(("method", "tolerance"), [("radau5", 1e-6), ("radau9", 1e-5), ("taylor", 1e-4)])
def test_slips_begin_whatever_the_tolerance(method: str, tolerance: float, tmp_path: Path) -> None:
    """The direction of what hardly moves turns fast: of steps that are too long for that friction pushes at the end."""
    x, _ = slipping()
    ds, exact = slide(x, tmp_path, method, tolerance), slide(x, tmp_path, "dop853", 1e-11)
    assert (ds.status == 0).all()
    error = abs(ds.position - exact.position).max(["time", "body", "axis"])
    assert error.max() < 20.0 * tolerance


PEAKS = {  # loads whose largest value is a kink, lasts for a moment, or comes late: as a formula, and its numbers
    "kinks": ("(1 - 2*abs(w*t + b - 2*floor((w*t + b)/2) - 1))*(1 + 0.1*t)", {"w": (3, 40), "b": (0, 2)}),
    "one kink": ("1 - w*abs(t - b)", {"w": (0.5, 30), "b": (0.3, 2.7)}),
    "of two": ("max(sin(w*t + b), 0.9*sin(c*t))", {"w": (3, 40), "b": (0, 2), "c": (3, 40)}),
    "burst": ("exp(-((t - c)/b)**2)*sin(w*t)", {"w": (20, 200), "b": (0.05, 0.4), "c": (0.5, 2.5)}),
    "pulse": ("exp(-((t - c)/b)**2)", {"b": (0.05, 0.5), "c": (0.3, 2.7)}),
    "late": ("exp(b*(t - 3))*sin(w*t)", {"w": (5, 80), "b": (0.5, 6)}),
    "small and fast": ("sin(0.7*t) + b*sin(w*t)", {"w": (50, 600), "b": (0.001, 0.1)}),
}
NAMES = {"abs": np.abs, "floor": np.floor, "sin": np.sin, "exp": np.exp, "max": np.maximum}


@pytest.mark.parametrize("peak", PEAKS)
def test_what_passes_what_holds_for_a_moment(peak: str, tmp_path: Path) -> None:
    """By 1e-3 to 0.3 of it, with every method."""
    text, ranges = PEAKS[peak]
    rng, times = np.random.default_rng(4), np.linspace(0.0, END, 960_001)
    x = {name: rng.uniform(low, high, 24) for name, (low, high) in ranges.items()}
    x["hold"], expected = np.empty(24), np.full(24, np.nan)
    for k in range(24):
        one = {name: values[k] for name, values in x.items()}

        size = np.abs(eval(text, NAMES | one | {"t": times}))
        hold = max(size.max() / (1.0 + 10.0 ** rng.uniform(-3.0, -0.5)), 1.001 * size[0])
        x["hold"][k] = hold
        if (over := np.flatnonzero(size > hold)).size:
            before, after = times[over[0] - 1], times[over[0]]

            def excess(t: float, one: dict[str, Any] = one, hold: float = hold) -> float:
                return float(np.abs(eval(text, NAMES | one | {"t": t})) - hold)

            expected[k] = brentq(excess, before, after, xtol=1e-14)
    table = tmp_path / "loads.csv"
    np.savetxt(table, np.column_stack(list(x.values())), "%.17g", ",", header=",".join(x), comments="")
    dry = parts.dry("s", "0.7*hold", "hold")
    model = {
        "gravity": [0, 0, 0],
        "bodies": [BOX],
        "joints": [{**SLIDE, "axis": [1, 0, 0]}],
        "forces": [dry, {"type": "actuator", "joint": "s", "value": text}],
    }
    vary = {f"parameters.{name}": {"column": name} for name in x}
    for method, tolerance in (("dop853", 1e-9), ("radau5", 1e-7), ("taylor", 1e-10)):
        ds = lienumba.run(
            {
                "parameters": dict.fromkeys(x, 1.0),
                "model": model,
                "integrator": {"method": method, "tolerance": tolerance, "end_time": END},
                "output": {"every": END, "max_changes": 1024, "variables": []},
                "sweep": {"runs": 24, "sampler": "table", "table": {"file": str(table)}, "vary": vary},
            },
            progress=False,
        )
        assert (ds.status == 0).all()
        slips = [run[kind == 8] for run, kind in zip(ds.change_time.values, ds.change_kind.values, strict=True)]
        first = [own[0] if len(own) else np.nan for own in slips]
        np.testing.assert_allclose(first, expected, atol=1e-7, err_msg=method)
