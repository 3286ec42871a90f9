"""Where forces, or the stiffness, are 0 as sums of what is not: rounding neither moves, nor holds, nor grows."""

from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lienumba
from tests.rigs import parts
from tests.rigs.parts import numbers, quaternion

G = 9.81
SHORT = {"integrator": {"method": "dop853", "tolerance": 1e-10, "end_time": 0.1}}
TURNS = [Rotation.identity(), *Rotation.random(2, random_state=3)]
Z = np.array([0.0, 0.0, 1.0])
FOUND = 0


class Scene:
    """All that is written along z up is turned."""

    def __init__(self, turn: Rotation, gravity: float = G) -> None:
        self.turn = turn
        self.model: dict[str, Any] = {"gravity": numbers(turn.apply(-gravity * Z)), "bodies": [], "joints": [],
                                      "forces": []}  # fmt: skip

    def body(self, name: str, place: Any, tilt: Rotation | None = None, inertia: Any = (0.1, 0.12, 0.2)) -> None:
        turn = self.turn * (tilt or Rotation.identity())
        place = numbers(self.turn.apply(place))
        self.model["bodies"].append(parts.body(name, 1.0, list(inertia), position=place, rotation=quaternion(turn)))

    def joint(self, kind: str, base: str, body: str, at: Any, axis: Any = None) -> None:
        own = {} if axis is None else {"axis": numbers(self.turn.apply(axis))}
        self.model["joints"].append({"name": f"{base}_{body}", "type": kind, "bodies": [base, body],
                                     "at": numbers(self.turn.apply(at)), **own})  # fmt: skip

    def found(self, rotation: Any = None, **more: Any) -> Any:
        asked = {} if rotation is None else {"rotation": tuple(numbers(self.turn.apply(rotation)))}
        return lienumba.equilibrium({"model": self.model, **SHORT, **more}, **asked)

    def drifts(self) -> bool:
        """Whether the modes are all stable, and one of them has no frequency."""
        modes = lienumba.modes({"model": self.model, **SHORT})
        return bool(modes.stable.all()) and bool((modes.angular_frequency == 0.0).any())


@pytest.mark.parametrize("turn", TURNS)
@pytest.mark.parametrize("joint", ["revolute", "spherical"])
@pytest.mark.parametrize("stops", [False, True])
def test_a_balanced_see_saw_stays_where_it_is(turn: Rotation, joint: str, stops: bool) -> None:
    scene = Scene(turn)
    scene.body("a", [0.3, 0, 0])
    scene.body("b", [-0.3, 0, 0])
    scene.joint(joint, "ground", "a", [0, 0, 0], [0, 1, 0] if joint == "revolute" else None)
    scene.joint("fixed", "a", "b", [0, 0, 0])
    if stops and joint == "revolute":
        scene.model["limits"] = [{"joint": "ground_a", "low": -0.5, "high": 0.6}]
    found = scene.found()
    assert found.status.item() == FOUND
    np.testing.assert_allclose(turn.inv().apply(found.position.values[0]), [[0.3, 0, 0], [-0.3, 0, 0]], atol=1e-14)
    assert scene.drifts()


@pytest.mark.parametrize("turn", TURNS)
@pytest.mark.parametrize("joint", ["revolute", "spherical"])
@pytest.mark.parametrize("off", [0.0, 1e-6, -1e-6])
def test_a_balanced_lamp_drifts_and_one_that_is_not_does_not(turn: Rotation, joint: str, off: float) -> None:
    """A spring of no free length from h above the hinge: its energy and that of the weight are (m g l - k h l) cos."""
    length, stiffness, angle = 0.5, 50.0, 0.7
    tilt = Rotation.from_rotvec([0, angle, 0])
    scene = Scene(turn)
    scene.body("arm", tilt.apply(length * Z), tilt)
    scene.joint(joint, "ground", "arm", [0, 0, 0], [0, 1, 0] if joint == "revolute" else None)
    high = G / stiffness * (1.0 + off)
    scene.model["forces"].append({
        "type": "spring_damper", "bodies": ["ground", "arm"], "points": [numbers(turn.apply(high * Z)), [0, 0, 0]],
        "stiffness": stiffness, "damping": 1.0, "free_length": 0.0,
    })  # fmt: skip
    found = scene.found()
    place = turn.inv().apply(found.position.values[0, 0])
    assert found.status.item() == FOUND
    if off == 0.0:
        np.testing.assert_allclose(place, tilt.apply(length * Z), atol=1e-14)
    else:  # it goes up, or down
        np.testing.assert_allclose(place, [0, 0, np.copysign(length, off)], atol=1e-9)


@pytest.mark.parametrize("turn", TURNS)
@pytest.mark.parametrize("joint", ["prismatic", "cylindrical", "planar", "point_in_plane"])
def test_a_level_slide_is_held_by_nothing_and_pushed_by_nothing(turn: Rotation, joint: str) -> None:
    scene = Scene(turn)
    scene.body("box", [0.3, 0.1, 0])
    level = [1.0, 0.7, 0] if joint in ("prismatic", "cylindrical") else [0, 0, 1.0]
    scene.joint(joint, "ground", "box", [0.3, 0.1, 0], level)
    assert scene.found().status.item() == FOUND


@pytest.mark.parametrize("turn", TURNS)
@pytest.mark.parametrize("push", [1e-9, 1e-12])
def test_a_small_push_is_one(turn: Rotation, push: float) -> None:
    """Without weight it is large beside rounding; nothing can balance it."""
    scene = Scene(turn, gravity=0.0)
    scene.body("box", [0.3, 0.1, 0])
    scene.joint("prismatic", "ground", "box", [0.3, 0.1, 0], [1, 0.7, 0])
    scene.model["forces"].append({"type": "actuator", "joint": "ground_box", "value": push})
    assert scene.found().status.item() == 1


@pytest.mark.parametrize("turn", TURNS)
def test_opposite_forces_on_a_free_body_cancel(turn: Rotation) -> None:
    scene = Scene(turn, gravity=0.0)
    scene.body("box", [0.3, 0.1, 0])
    force = np.array([1.0, 0.3, 0.7])
    for sign in (1.0, -1.0):
        value = numbers(sign * force)
        scene.model["forces"].append({"type": "force", "body": "box", "frame": "body", "value": value,
                                      "point": [0.1, 0.2, 0.3]})  # fmt: skip
    found = scene.found()
    assert (found.status.item(), found.growth.item()) == (FOUND, 0.0)


@pytest.mark.parametrize("turn", TURNS)
@pytest.mark.parametrize("w", [0.3, 7.0])
@pytest.mark.parametrize("axle", ["vertical", "horizontal"])
@pytest.mark.parametrize("masses", [1, 2, 3])
def test_a_balanced_rotor_turns(turn: Rotation, w: float, axle: str, masses: int) -> None:
    """Its weight is carried by the bearing, at any angle."""
    axis = Z if axle == "vertical" else np.array([1.0, 0, 0])
    around = Rotation.align_vectors([axis], [Z])[0]
    scene = Scene(turn)
    for n in range(masses):
        angle = 2.0 * np.pi * n / masses
        off = 0.0 if masses == 1 else 0.3
        scene.body(f"m{n}", around.apply([off * np.cos(angle), off * np.sin(angle), 0.0]),
                   Rotation.from_rotvec([1.0, 2.0, 3.0]) if axle == "vertical" else None)  # fmt: skip
        if n:
            scene.joint("fixed", "m0", f"m{n}", [0, 0, 0])
    scene.joint("revolute", "ground", "m0", [0, 0, 0], axis)
    assert scene.found(w * axis).status.item() == FOUND


@pytest.mark.parametrize("turn", TURNS)
@pytest.mark.parametrize("rotation", [[0, 0, 3.0], [1.0, 2.0, 3.0], [0.1, 0, 0.2]])
def test_a_free_ball_turns_about_any_axis(turn: Rotation, rotation: list[float]) -> None:
    scene = Scene(turn, gravity=0.0)
    scene.body("ball", [0, 0, 0], inertia=[0.1] * 3)
    assert scene.found(rotation).status.item() == FOUND  # as well about all others


DRIVES: dict[str, list[dict[str, Any]]] = {
    "free": [],
    "rate": [{"joint": "ground_shaft", "rate": 5.0}],
    "value": [{"joint": "ground_shaft", "value": "5*t"}],
}


@pytest.mark.parametrize("turn", TURNS)
@pytest.mark.parametrize("drive", DRIVES)
@pytest.mark.parametrize("damping", [0.0, 1.0])
@pytest.mark.parametrize("stiffness", [25.0, 26.0])
def test_a_slide_that_is_as_soft_as_its_shaft_is_fast_drifts(
    turn: Rotation, drive: str, damping: float, stiffness: float
) -> None:
    """m w^2 = 25 N/m: it rests wherever it is, whatever turns the shaft; a little stiffer, in one place."""
    scene = Scene(turn)
    scene.body("shaft", [0, 0, 0])
    scene.body("box", [0, 0, 0])
    scene.joint("revolute", "ground", "shaft", [0, 0, 0], Z)
    scene.joint("prismatic", "shaft", "box", [0, 0, 0], [1, 0, 0])
    scene.model["quantities"] = [{"name": "s", "type": "joint", "joint": "shaft_box"}]
    force = f"-{stiffness}*s.displacement - {damping}*s.speed"
    scene.model["forces"].append({"type": "actuator", "joint": "shaft_box", "value": force})
    scene.model["drivers"] = DRIVES[drive]
    assert scene.found(5.0 * Z).status.item() == FOUND


@pytest.mark.parametrize("turn", TURNS)
@pytest.mark.parametrize("axis", [[1, 0, 0], [0, 0, 1], [1, 0, 1]])
def test_a_ball_hinged_through_its_centre_is_turned_by_nothing(turn: Rotation, axis: list[float]) -> None:
    scene = Scene(turn)
    scene.body("shaft", [0, 0, 0])
    scene.body("ball", [0.4, 0, 0.5], inertia=[0.1] * 3)
    scene.joint("revolute", "ground", "shaft", [0, 0, 0], Z)
    scene.joint("revolute", "shaft", "ball", [0.4, 0, 0.5], axis)
    assert scene.found(2.0 * Z).status.item() == FOUND


@pytest.mark.parametrize("turn", TURNS)
def test_a_dead_zone_holds_nothing_and_moves_nothing(turn: Rotation) -> None:
    """The servo carries the weight by a formula, and pushes only outside of 0.5 to 0.9 rad."""
    angle = 0.7
    tilt = Rotation.from_rotvec([0, angle, 0])
    scene = Scene(turn)
    scene.body("arm", tilt.apply([0.5, 0, 0]), tilt)
    scene.joint("revolute", "ground", "arm", [0, 0, 0], [0, 1, 0])
    scene.model["joints"][0]["angle"] = angle
    scene.model["quantities"] = [{"name": "h", "type": "joint", "joint": "ground_arm"}]
    servo = "-0.5*9.81*cos(h.angle) - 40*(max(h.angle - 0.9, 0) + min(h.angle - 0.5, 0)) - h.rate"
    scene.model["forces"].append({"type": "actuator", "joint": "ground_arm", "value": servo})
    found = scene.found()
    assert found.status.item() == FOUND
    np.testing.assert_allclose(turn.inv().apply(found.position.values[0, 0]), tilt.apply([0.5, 0, 0]), atol=1e-13)


def test_a_run_has_its_bits_whenever_its_neighbours_come_to_rest() -> None:
    """Lamps that are balanced, nearly so and not at all, which come to rest after different numbers of steps."""
    tilt = Rotation.from_rotvec([0.3, 0.7, 0])
    scene = Scene(TURNS[1])
    scene.body("arm", tilt.apply(0.5 * Z), tilt)
    scene.joint("spherical", "ground", "arm", [0, 0, 0])
    scene.model["forces"].append({
        "type": "spring_damper", "bodies": ["ground", "arm"], "points": [numbers(TURNS[1].apply(0.2 * Z)), [0, 0, 0]],
        "stiffness": 5.0 * G, "damping": 1.0, "free_length": 0.0,
    })  # fmt: skip
    stiffness = [5.0 * G * x for x in (1.0, 1.0 + 1e-7, 1.0 - 1e-9, 1.001, 0.5, 2.0, 1e3, 1e9)]
    sweep = {"sampler": "table", "table": {"columns": {"model.forces[0].stiffness": stiffness}}}
    found = scene.found(sweep=sweep)
    assert (found.status.values == FOUND).all()  # about the upright
    for run in range(len(stiffness)):
        alone = lienumba.equilibrium({"model": scene.model, **SHORT, "sweep": sweep}, runs=[run])
        for name in ("status", "position", "rotation", "force", "growth"):
            np.testing.assert_array_equal(alone[name].values[0], found[name].values[run])
