"""What touches, holds and is loaded as a run begins."""

from typing import Any

import numpy as np
import pytest

import lienumba
from tests.rigs import parts

STEPS: list[dict[str, Any]] = [
    {"tolerance": 1e-9}, {"tolerance": 1e-9, "coordinates": "joint"}, {"method": "rk4", "step": 1e-3},
]  # fmt: skip


@pytest.mark.parametrize("steps", STEPS, ids=str)
def test_what_touches_at_once_is_no_event_of_what_does_not(steps: dict[str, Any]) -> None:
    """A ball on a floor, drawn up by 20 t N, leaves it at m g / 20 and not at 0; what is true at 0 happens once."""
    floor = parts.sphere("c", "b", 0.1, normal=[0, 0, 1], friction=0.3)
    model = {
        "gravity": [0, 0, -9.81], "bodies": [parts.body(position=[0, 0, 0.1])], "contacts": [floor],
        "forces": [{"type": "force", "body": "b", "value": [0, 0, "20*t"]}],
    }  # fmt: skip
    events = [{"name": "off", "when": "k.on < 0.5"}, {"name": "on", "when": "k.on > 0.5"}]
    scenario = {
        "model": model, "events": events, "quantities": [{"name": "k", "type": "contact", "contact": "c"}],
        "measures": [{"name": "leaves", "value": "first_time(k.on < 0.5)"}],
        "integrator": steps | {"end_time": 1.0}, "output": {"every": 0.1},
    }  # fmt: skip
    found = lienumba.run(scenario)
    assert found.event_count.values.tolist() == [[1, 1]]
    np.testing.assert_allclose(found.event_time.values, [[9.81 / 20, 0.0]], atol=1e-9)
    assert found.leaves.item() == pytest.approx(9.81 / 20, abs=1e-9)
    ended = lienumba.run(scenario | {"events": [{"name": "off", "when": "k.on < 0.5", "action": "stop"}]})
    assert ended.end_time.item() == pytest.approx(9.81 / 20, abs=1e-9)


@pytest.mark.parametrize("steps", STEPS, ids=str)
@pytest.mark.parametrize("turned", [False, True])
def test_pins_that_say_the_same_and_carry_nothing_at_first(steps: dict[str, Any], turned: bool) -> None:
    """A plate on a hinge and two parallel rods, loaded from nothing on: all stands, so rounding is all there is."""
    x, y, z = [[0, 0, 1], [1, 0, 0], [0, 1, 0]] if turned else np.eye(3).tolist()

    def at(a: float, b: float) -> list[float]:
        return (a * np.array(x) + b * np.array(y)).tolist()

    plate = parts.body("b", 2, [0.3, 0.4, 0.5], position=at(1, 0))
    rods = [
        parts.joint(f"p{n}", "distance", "b", points=[at(1 + s, -1), at(s, 0)], length=1)
        for n, s in enumerate((0.0, 0.5))
    ]
    hinge = parts.hinge("h", "b", axis=z)
    load = {"name": "F", "type": "force", "body": "b", "frame": "body", "point": at(0.5, 0)}
    load["value"] = [f"{60 * c}*t" for c in y]
    scenario = {
        "model": {"gravity": [0, 0, 0], "bodies": [plate], "joints": [hinge, *rods], "forces": [load]},
        "quantities": parts.observed("joint", "h"),
        "events": [{"name": f"lost{n}", "when": f"t > {1 + n}", "action": "release", "joint": f"p{n}"} for n in (0, 1)],
        "integrator": steps | {"end_time": 3.0}, "output": {"times": [2.0, 3.0]},
    }  # fmt: skip
    found = lienumba.run(scenario)
    assert found.status.item() == 0
    inertia = (0.4 if turned else 0.5) + 2
    angle = 90 / inertia * (3**3 - 2**3 - 12) / 6  # by 90 t N m about the hinge from 2 s on
    np.testing.assert_allclose(found["h.angle"].values[0], [0, angle], atol=1e-6)
