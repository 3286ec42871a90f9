"""What is soft, falls or grows slowly beside what is stiff by many orders: it is judged as if it were alone."""

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lienumba
from tests.rigs.parts import numbers, quaternion

G = 9.81
SHORT = {"integrator": {"method": "dop853", "tolerance": 1e-10, "end_time": 0.1}}
TURNS = [Rotation.identity(), Rotation.random(random_state=7)]


def body(name: str, turn: Rotation, place: Any) -> dict[str, Any]:
    return {"name": name, "mass": 1.0, "inertia": [0.1, 0.12, 0.15], "position": numbers(turn.apply(place)),
            "rotation": quaternion(turn)}  # fmt: skip


def mount(turn: Rotation, stiffness: float) -> dict[str, Any]:
    return {"type": "bushing", "bodies": ["ground", "mount"], "points": [numbers(turn.apply([0, 2, 0])), [0, 0, 0]],
            "stiffness": [stiffness] * 3, "damping": [1.0] * 3, "rotational_stiffness": [stiffness] * 3,
            "rotational_damping": [1.0] * 3}  # fmt: skip


def slide(turn: Rotation, base: str, off: float, force: str, stiffness: float) -> dict[str, Any]:
    """A body on a slide, beside a mount, or on it."""
    along = {"name": "slide", "type": "prismatic", "bodies": [base, "box"], "at": numbers(turn.apply([off, 0, 0])),
             "axis": numbers(turn.apply([1, 0, 0]))}  # fmt: skip
    return {
        "model": {
            "gravity": [0, 0, 0],
            "bodies": [body("box", turn, [off, 0, 0]), body("mount", turn, [0, 2, 0])],
            "joints": [along],
            "quantities": [{"name": "s", "type": "joint", "joint": "slide"}],
            "forces": [{"type": "actuator", "joint": "slide", "value": force}, mount(turn, stiffness)],
        },
        **SHORT,
    }


@pytest.mark.parametrize("turn", TURNS)
@pytest.mark.parametrize("base", ["ground", "mount"])
@pytest.mark.parametrize(("soft", "stiff"), [(1.0, 1e6), (0.01, 1e9), (1.0, 1e12)])
@pytest.mark.parametrize("off", [1.0, 1e-4])
def test_a_soft_spring_moves_what_is_on_it(turn: Rotation, base: str, soft: float, stiff: float, off: float) -> None:
    force = f"-{soft!r}*s.displacement - {soft * off!r} - 0.1*s.speed"
    found = lienumba.equilibrium(slide(turn, base, off, force, stiff))
    assert found.status.item() == 0
    moved = turn.inv().apply(found.position.values[0, 0]) - [0, 0, 0]
    known = 1e-15 * stiff / soft  # of a place: rounding of what the stiff one exerts
    np.testing.assert_allclose(moved, 0.0, atol=1e-12 + (known if base == "mount" else 0.0))


@pytest.mark.parametrize("turn", TURNS)
@pytest.mark.parametrize("stiff", [1e6, 1e9, 1e12])
@pytest.mark.parametrize("damping", [-1e-4, -1e-5, 1e-5])
def test_slow_growth_beside_a_stiff_mount_is_growth(turn: Rotation, stiff: float, damping: float) -> None:
    found = lienumba.equilibrium(slide(turn, "ground", 0.0, f"-s.displacement - {damping!r}*s.speed", stiff))
    assert found.status.item() == (2 if damping < 0 else 0)
    modes = lienumba.modes(slide(turn, "ground", 0.0, f"-s.displacement - {damping!r}*s.speed", stiff))
    assert modes.stable.item() == (damping > 0)
    if damping < 0:
        assert found.growth.item() == pytest.approx(-0.5 * damping, rel=1e-6)
        assert modes.growth.max().item() == pytest.approx(-0.5 * damping, rel=1e-6)


@pytest.mark.parametrize("turn", TURNS)
@pytest.mark.parametrize("stiff", [1e6, 1e12])
@pytest.mark.parametrize("off", [3.0, 1e-3, 1e-7])
def test_a_pendulum_falls_from_its_top_beside_a_stiff_mount(turn: Rotation, stiff: float, off: float) -> None:
    tilt = turn * Rotation.from_rotvec([0.0, off, 0.0])
    bob = {**body("bob", tilt, [0, 0, 0.5]), "inertia": [0.01] * 3}
    hinge = {"name": "hinge", "type": "revolute", "bodies": ["ground", "bob"], "at": [0, 0, 0],
             "axis": numbers(turn.apply([0, 1, 0]))}  # fmt: skip
    found = lienumba.equilibrium({
        "model": {"gravity": numbers(turn.apply([0, 0, -G])), "bodies": [bob, body("mount", turn, [0, 2, 0])],
                  "joints": [hinge], "forces": [mount(turn, stiff)]}, **SHORT,
    })  # fmt: skip
    assert found.status.item() == 0
    np.testing.assert_allclose(turn.inv().apply(found.position.values[0, 0]), [0, 0, -0.5], atol=1e-12)


def pendulum(turn: Rotation, name: str, off: float, length: float, mass: float, base: str = "ground") -> Any:
    """A body of a point's inertia that hangs, or stands where its length is below 0, and its hinge; and w^2 of it."""
    place = np.array([0, off, -length])
    inertia = [1e-2 * mass * length * length] * 3
    bob = {**body(name, turn, place), "mass": mass, "inertia": inertia}
    hinge = {"name": f"hinge_of_{name}", "type": "revolute", "bodies": [base, name],
             "at": numbers(turn.apply([0, off, 0])), "axis": numbers(turn.apply([0, 1, 0]))}  # fmt: skip
    return bob, hinge, G * length / (length * length * 1.01)


def speeds(modes: Any) -> Any:
    """Of eigenvalues (1/s)."""
    found = np.hypot(modes.growth.values, modes.angular_frequency.values)
    return found[np.isfinite(found)]


@pytest.mark.parametrize("turn", TURNS)
@pytest.mark.parametrize("on_it", [False, True])
@pytest.mark.parametrize("length", [0.5, -0.5])
@pytest.mark.parametrize("light", [1.0, 0.1])
def test_a_pendulum_beside_or_on_a_light_body_on_a_stiff_mount(
    turn: Rotation, on_it: bool, length: float, light: float
) -> None:
    bob, hinge, square = pendulum(turn, "bob", 2.0 if on_it else 0.0, length, 1.0, "mount" if on_it else "ground")
    base = {**body("mount", turn, [0, 2, 0]), "mass": light, "inertia": [1e-3 * light] * 3}
    model = {"gravity": numbers(turn.apply([0, 0, -G])), "bodies": [bob, base], "joints": [hinge],
             "forces": [{**mount(turn, 1e9), "damping": [0.0] * 3, "rotational_damping": [0.0] * 3}]}  # fmt: skip
    found = lienumba.equilibrium({"model": model, **SHORT})
    modes = lienumba.modes({"model": model, **SHORT, "start": {"from": "equilibrium"}})
    assert found.status.item() == (0 if length > 0 else 2)
    assert speeds(modes).min() == pytest.approx(np.sqrt(abs(square)), rel=1e-3 if on_it else 1e-6)
    if length < 0:
        assert found.growth.item() == pytest.approx(np.sqrt(-square), rel=1e-3 if on_it else 1e-6)


@pytest.mark.parametrize("turn", TURNS)
@pytest.mark.parametrize("heavy", [1e6, 1e9])
@pytest.mark.parametrize("light", [1e-3, 1e-6, 1e-9])
@pytest.mark.parametrize("on_it", [False, True])
@pytest.mark.parametrize("length", [1e-3, -1e-3])
def test_a_light_pendulum_beside_or_on_a_heavy_one(
    turn: Rotation, heavy: float, light: float, on_it: bool, length: float
) -> None:
    bob, hinge, slow = pendulum(turn, "heavy", 0.0, 1.0, heavy)
    small, other, fast = pendulum(turn, "light", 1.0, length, light, "heavy" if on_it else "ground")
    model = {"gravity": numbers(turn.apply([0, 0, -G])), "bodies": [bob, small], "joints": [hinge, other]}
    found, modes = lienumba.equilibrium({"model": model, **SHORT}), lienumba.modes({"model": model, **SHORT})
    assert found.status.item() == (0 if length > 0 else 2)
    if length < 0:
        assert found.growth.item() == pytest.approx(np.sqrt(-fast), rel=1e-9)
    np.testing.assert_allclose(np.unique(speeds(modes).round(9)), np.sqrt([slow, abs(fast)]), rtol=1e-8)


@pytest.mark.parametrize("turn", TURNS)
@pytest.mark.parametrize("stiff", [1e3, 1e9, 1e12])
@pytest.mark.parametrize("soft", [1.0, 1e-3])
def test_what_a_loop_does_not_touch_is_not_mixed_with_it(turn: Rotation, stiff: float, soft: float) -> None:
    corners = np.array([(0, 0, 0), (0, 0, 1.0), (1.5, 0, 1.3), (1.5, 0, 0)])
    rods, names = [], ["ground", "rod_0", "rod_1", "rod_2", "ground"]
    for n, (p, q) in enumerate(pairwise(corners)):
        along = (q - p) / np.linalg.norm(q - p)
        own = turn * Rotation.from_rotvec([0.0, np.arctan2(-along[2], along[0]), 0.0])
        place = turn.apply(0.5 * (p + q))
        rods.append({**body(f"rod_{n}", own, [0, 0, 0]), "position": numbers(place)})
    hinges = [
        {"name": f"hinge_{n}", "type": "revolute", "bodies": names[n : n + 2], "at": numbers(turn.apply(corner)),
         "axis": numbers(turn.apply([0, 1, 0]))}
        for n, corner in enumerate(corners)
    ]  # fmt: skip
    arm, hinge, _ = pendulum(turn, "arm", 5.0, 0.5, 1.0)
    model = {
        "gravity": [0, 0, 0],
        "bodies": [arm, *rods],
        "joints": [hinge, *hinges],
        "forces": [
            {"type": "torsion_spring", "joint": "hinge_of_arm", "stiffness": soft, "free_angle": 0.1},
            {"type": "torsion_spring", "joint": "hinge_0", "stiffness": stiff, "damping": 1.0, "free_angle": 0.02},
        ],
    }
    found = lienumba.equilibrium({"model": model, **SHORT})
    assert found.status.item() == 0
    there = turn.inv().apply(found.position.values[0, 0]) - [0, 5, 0]
    np.testing.assert_allclose(there, [-0.5 * np.sin(0.1), 0, -0.5 * np.cos(0.1)], atol=1e-9)
