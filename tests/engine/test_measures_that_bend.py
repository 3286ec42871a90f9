"""Formulas with kinks and jumps of what moves, in steps that are long beside them."""

from collections.abc import Iterable
from math import acos, asin, pi, sqrt
from typing import Any

import pytest

import lienumba
from lienumba.numerics.expressions import Formula

END, RATE, SPEED = 20.0, 3.0, 0.1
MOVING: dict[str, Any] = {  # p = (cos 3 t, sin 3 t, 0.1 t)
    "model": {
        "gravity": [0, 0, 0],
        "bodies": [
            {
                "name": "b", "mass": 2, "inertia": [1, 1, 1], "position": [0, 0, 0], "velocity": [0, 0, SPEED],
                "angular_velocity": [0, 0, RATE],
            }
        ],
    },
    "quantities": [
        {"name": "p", "type": "point", "body": "b", "point": [1, 0, 0]},
        {"name": "far", "type": "expression", "value": "abs(p.x - 0.25)"},
    ],
    "output": {"every": END},
}  # fmt: skip
STEPS: list[dict[str, Any]] = [
    {"tolerance": 1e-9, "method": name} for name in ("dop853", "dp54", "taylor", "radau5", "radau9")
]
STEPS += [{"step": 0.01, "method": "rk4"}, {"step": 0.02, "method": "dop853"}]
VALUES = {
    "max(min(p.z, 2 - p.z))": 1.0,
    "time_of_max(min(p.z, 2 - p.z))": 10.0,
    "max(min(p.x, p.y))": sqrt(0.5),
    "min(max(p.x, p.y))": -sqrt(0.5),
    "min(abs(p.x - p.y))": 0.0,
    "max(-far)": 0.0,
    "max(abs(p.x))": 1.0,
    "min(abs(p.z - 0.7))": 0.0,
    "time_of_min(abs(p.z - 0.7))": 7.0,
    "max(clip(p.x, -0.3, 0.5) - 0.1*p.z)": 0.5,
    "max(far - where(p.y > 0, 0.2, 0))": 1.25,
    "max(where(p.z > 1, 1 - p.z, p.z))": 1.0,
    "integral(sign(p.z - 0.7))": 13.0 - 7.0,
    "integral(max(0, p.z - 1.5, 2*p.z - 2.5))": 5.625,
}
TURNS = 10
CONDITIONS = {
    "time_when(p.x > 0.3 and p.y > 0.3)": TURNS * (acos(0.3) - asin(0.3)) / RATE,
    "time_when(max(p.x, p.y) > 0.3)": TURNS * (pi + acos(0.3) - asin(0.3)) / RATE,
    "time_when(p.x > 0.3 or not p.y <= 0.3)": TURNS * (pi + acos(0.3) - asin(0.3)) / RATE,
    "time_when(abs(p.x) > 0.3)": TURNS * 4 * acos(0.3) / RATE,
    "time_when(abs(p.y) < 0.05)": TURNS * 4 * asin(0.05) / RATE,  # a kink amid a short pulse
    "time_when(-0.2 < p.x < 0.3)": TURNS * 2 * (acos(-0.2) - acos(0.3)) / RATE,
    "count(abs(p.x) > 0.3)": 1 + 2 * TURNS,
    "first_time(max(p.y, 0.5*p.x) > 0.8)": asin(0.8) / RATE,
    "integral(abs(p.y), abs(p.x) > 0.3)": TURNS * 4 * (1 - 0.3) / RATE,
    "max(-far, p.x > 0.3 or p.x < 0)": -0.05,
}


def measured(texts: Iterable[str], integrator: dict[str, Any], **more: Any) -> dict[str, float]:
    names = {text: f"m{n}" for n, text in enumerate(texts)}
    measures = [{"name": name, "value": text} for text, name in names.items()]
    found = lienumba.run(MOVING | {"measures": measures, "integrator": {"end_time": END} | integrator} | more)
    return {text: float(found[name][0]) for text, name in names.items()}


@pytest.mark.parametrize("integrator", STEPS, ids=str)
def test_numbers_that_are_known(integrator: dict[str, Any]) -> None:
    assert measured(VALUES, integrator) == pytest.approx(VALUES, abs=1e-9)


@pytest.mark.parametrize("integrator", STEPS, ids=str)
def test_conditions_of_several_turns(integrator: dict[str, Any]) -> None:
    end = TURNS * 2 * pi / RATE
    if "step" in integrator:
        integrator = integrator | {"step": end / round(end / integrator["step"])}
    found = measured(CONDITIONS, integrator | {"end_time": end}, output={"every": end})
    assert found == pytest.approx(CONDITIONS, abs=1e-6)


BENDS = {
    "p.x": (),
    "abs(p.x) + abs(p.x)": ("p.x",),
    "min(p.x, 0.3, t)": ("p.x - 0.3", "p.x - t", "0.3 - t"),
    "clip(p.x, -1, t)": ("p.x - -1", "p.x - t"),
    "where(p.x > 0 and 0 < t < 2, sign(t), 1)": ("p.x - 0", "0 - t", "t - 2", "t"),
    "abs(-2) * max(1, 2) * p.x": (),
    "abs(abs(p.x) - 1)": ("abs(p.x) - 1", "p.x"),
    "floor(p.x)": tuple(f"{of}({0.5 * pi} * p.x)" for of in ("sin", "cos")),
    "mod(t, 2) + abs(t)": (*(f"{of}({0.5 * pi} * (t / 2))" for of in ("sin", "cos")), "t"),
    "table(p.x)": None,
}


@pytest.mark.parametrize(("text", "bends"), BENDS.items())
def test_where_formulas_bend(text: str, bends: tuple[str, ...] | None) -> None:
    found = Formula(text, frozenset({"t", "p.x"}), frozenset({"table"})).bends
    assert (None if found is None else {x.plain for x in found}) == (None if bends is None else set(bends))


def test_a_condition_turns_at_its_own_zeros() -> None:
    """A comparison alone has no other bend; several have one in each."""
    names = frozenset({"t", "p.x"})
    assert Formula("p.x > 1", names, condition=True).bends == ()
    assert [x.plain for x in Formula("abs(p.x) > 1", names, condition=True).bends or ()] == ["p.x"]
    assert len(Formula("p.x > 1 or t > 2", names, condition=True).bends or ()) == 2
