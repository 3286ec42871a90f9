"""Random formulas of runs: each number beside the finely stored course of the same formula."""

import random
from typing import Any

import numpy as np
import pytest

import lienumba

pytestmark = pytest.mark.filterwarnings("ignore")  # formulas that are always the same, runs that are
END, FINE, RUNS = 1.0, 1e-3, 3
METHODS: list[dict[str, Any]] = [
    {"method": "rk4", "step": 2 * FINE},
    {"method": "dop853", "step": 10 * FINE},
    {"method": "dop853", "tolerance": 1e-9},
    {"method": "tsit54", "tolerance": 1e-7},
    {"method": "taylor", "tolerance": 1e-10},
    {"method": "radau5", "tolerance": 1e-8},
]
SWINGING: dict[str, Any] = {
    "gravity": [0, 0, -9.81],
    "bodies": [
        {"name": "a", "mass": 1, "inertia": [0.1, 0.1, 0.1], "position": [1, 0, 0], "angular_velocity": [0, 0.4, 0]},
        {"name": "b", "mass": 0.7, "inertia": [0.05, 0.1, 0.07], "position": [2, 0.3, 0]},
    ],
    "joints": [
        {"name": "j", "type": "revolute", "bodies": ["ground", "a"], "at": [0, 0, 0], "axis": [0, 1, 0]},
        {"name": "k", "type": "spherical", "bodies": ["a", "b"], "at": [1.5, 0, 0]},
    ],
}
TURNING: dict[str, Any] = {
    "gravity": [0, 0, 0],
    "bodies": [
        {"name": "a", "mass": 1, "inertia": [1, 1, 1], "position": [0, 0, 0], "angular_velocity": [0, 0, 7.5]},
        {"name": "b", "mass": 0.7, "inertia": [0.05, 0.1, 0.07], "position": [2, 0.3, 0], "velocity": [-1.3, 0.1, 0]},
    ],
}
PUSHED = TURNING | {"forces": [{"name": "push", "type": "force", "body": "b", "value": ["5*gust", "3*sin(9*t)", 0]}]}
POINTS = [
    {"name": "p", "type": "point", "body": "a", "point": [0.3, 0.1317, 0]},
    {"name": "v", "type": "point", "body": "a", "point": [0.3, 0.1317, 0], "derivative": 1},
    {"name": "r", "type": "point", "body": "b", "point": [0, 0, 0.2]},
    {"name": "w", "type": "point", "body": "b", "point": [0, 0, 0.2], "derivative": 1},
    {"name": "a", "type": "point", "body": "b", "derivative": 2},
]
NAMES = ["p.x", "p.z", "v.x", "v.z", "r.x", "r.y", "r.z", "w.x", "w.y", "a.x", "sin(5*t)", "t"]
FORMS = [
    "({} + {})", "({} - {})", "({}*{})", "abs({})", "min({}, {})", "max({}, {}, {})", "clip({}, -0.4, 0.6)", "sin({})",
    "sign({})", "hypot({}, 0.1)", "where({} < {}, {}, {})", "where({} < {} and {} > {}, {}, {})",
]  # fmt: skip


def formula(rng: random.Random, depth: int, names: list[str]) -> str:
    if depth == 0:
        return rng.choice(names)
    form = rng.choice(FORMS)
    return form.format(*(formula(rng, depth - rng.choice([1, 1, depth]), names) for _ in range(form.count("{}"))))


def beside(what: str, x: float, y: np.ndarray, holds: np.ndarray, fine: float) -> bool:
    """Whether a number may be what is asked for of a course y and of when a condition holds: within what they may do
    between stored times."""
    steps = np.sort(abs(np.diff(y)))[::-1]
    slack, loose = 1e-6 * (1 + abs(y).max()), 3 * (1 + (np.diff(holds) != 0).sum())
    if what in ("max", "min"):
        y, x = (y, x) if what == "max" else (-y, -x)
        return y[:-1].max() - slack <= x <= y.max() + 1.01 * steps[0] + slack
    if what == "while":
        if not holds[:-1].any():
            return True
        near = np.convolve(holds, np.ones(5), "same") > 0.0
        return y[:-1][holds[:-1] > 0].max() - slack <= x <= y[near].max() + steps[0] + slack
    if what == "time":
        return abs(x - np.trapezoid(holds, dx=fine)) <= fine * loose
    between = 0.6 * steps[:60].sum() + (loose * abs(y).max() if what == "part" else 0.0)
    expected = np.trapezoid(y * holds if what == "part" else y, dx=fine)
    return abs(x - expected) <= fine * between + slack * END


@pytest.mark.campaign(8)
def test_measures_of_new_courses(seed: int) -> None:
    compare_with_course(seed)


@pytest.mark.parametrize("seed", range(24))
def test_a_measure_is_what_the_course_says(seed: int) -> None:
    compare_with_course(seed)


def compare_with_course(seed: int) -> None:
    rng, fine = random.Random(seed), METHODS[seed % len(METHODS)].get("step", FINE)
    model, integrator = rng.choice([SWINGING, TURNING, PUSHED]), METHODS[seed % len(METHODS)]
    names = NAMES + ["gust"] * (model is PUSHED)
    texts = [formula(rng, rng.choice([1, 2]), names) for _ in range(4)]
    conditions = [f"{formula(rng, rng.choice([0, 1]), names)} > {rng.choice(['0.1', '-0.2', 'p.x'])}" for _ in texts]
    asked = {}
    for n, (text, condition) in enumerate(zip(texts, conditions, strict=True)):
        asked |= {("max", n): f"max({text})", ("min", n): f"min(f{n})", ("all", n): f"integral({text})"}
        asked |= {("part", n): f"integral(f{n}, {condition})", ("while", n): f"max({text}, {condition})"}
        asked |= {("time", n): f"time_when({condition})"}
    courses = [{"name": f"f{n}", "type": "expression", "value": text} for n, text in enumerate(texts)]
    courses += [
        {"name": f"g{n}", "type": "expression", "value": f"where({text}, 1, 0)"} for n, text in enumerate(conditions)
    ]
    scenario: dict[str, Any] = {
        "model": model,
        "quantities": POINTS + courses,
        "integrator": integrator | {"end_time": END},
        "output": {"every": fine, "variables": [x["name"] for x in courses]},
        "sweep": {"runs": RUNS, "seed": seed, "vary": {"bodies.a.mass": {"distribution": "normal", "std": 0.1}}},
        "measures": [{"name": f"{what}{n}", "value": text} for (what, n), text in asked.items()],
    }
    if model is PUSHED:
        scenario["noise"] = [{"name": "gust", "type": "white", "std": 1.0, "every": 0.1}]
    found = lienumba.run(scenario)
    for (what, n), text in asked.items():
        for run in range(RUNS):
            y, holds = (found[f"{name}{n}"].values[run].copy() for name in "fg")
            if model is PUSHED:  # what is drawn where the run ends is no part of it
                y[-1], holds[-1] = 2 * y[-2] - y[-3], holds[-2]
            assert beside(what, float(found[f"{what}{n}"][run]), y, holds, fine), (text, run, integrator)
