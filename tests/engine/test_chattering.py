"""What is said of runs that a jumping force kept at short steps, and of those that have other reasons."""

from typing import Any

import pytest

import lienumba

SAID = (
    ", because the force relay jumps back and forth where it holds the motion; give it a slope there, such as "
    "tanh(rate/1e-3), sample it by a law with every, or, where it is friction, take one with static"
)


def block(value: str, **integrator: Any) -> dict[str, Any]:
    """1 kg on a slide, at 1 m/s, pushed by a force."""
    body = {"name": "block", "mass": 1.0, "inertia": [1, 1, 1]}
    rail = {"name": "rail", "type": "prismatic", "bodies": ["ground", "block"], "points": [[0, 0, 0]] * 2,
            "axes": [[1, 0, 0]] * 2, "references": [[0, 1, 0]] * 2, "displacement": 0.0, "speed": 1.0}  # fmt: skip
    relay = {"name": "relay", "type": "actuator", "joint": "rail", "value": value}
    seen = {"name": "x", "type": "joint", "joint": "rail"}
    model = {"gravity": [0, 0, 0], "bodies": [body], "joints": [rail], "forces": [relay], "quantities": [seen]}
    return {"model": model, "integrator": {"end_time": 1.0, **integrator}, "output": {"every": 0.1}}


@pytest.mark.parametrize(
    ("value", "integrator"),
    [
        ("where(x.speed > 0, -5, 5)", {"method": "radau3", "tolerance": 1e-4, "coordinates": "joint"}),
        ("where(x.displacement + 0.1*x.speed > 0.05, -5, 5)", {"method": "dp54", "tolerance": 1e-5}),
    ],
)
def test_a_relay_is_named(value: str, integrator: dict[str, Any]) -> None:
    found = lienumba.run(block(value, **integrator))
    assert found.steps.item() > 10_000
    assert found.attrs["chatters"].startswith(f"{integrator['method']} took {found.steps.item():,} steps, ")
    assert found.attrs["chatters"].endswith(SAID)
    assert found.attrs["chatters"] in str(lienumba.analysis.summarise(found))


@pytest.mark.parametrize(
    "value", ["-5*tanh(x.speed/1e-3)", "-abs(x.displacement)*1e4", "where(x.displacement > 2, -5, 5)"]
)
def test_what_does_not_jump_back_and_forth_is_not(value: str) -> None:
    """A slope, a kink, and a jump that is passed once or never; short steps have another reason."""
    found = lienumba.run(block(value, method="dp54", tolerance=1e-6, max_step=5e-5))
    assert found.steps.item() >= 10_000
    assert "chatters" not in found.attrs
