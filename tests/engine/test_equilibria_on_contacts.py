"""What stands on rigid stops and contacts: against statics, and runs that start there and have to stay."""

from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lienumba
from tests.rigs import parts
from tests.rigs.parts import quaternion

G = 9.81
SHORT = {"integrator": {"method": "rk4", "step": 0.002, "end_time": 0.2}}
HALF = 0.05
CORNERS = [[x, y, -HALF] for x in (-0.1, 0.1) for y in (-0.1, 0.1)]


def on_points(
    points: list[list[float]], turn: Rotation, position: Any, tilt: Rotation | None = None, slope: float = 0.0,
    friction: Any = 0.5, mass: float = 2.0, **more: Any,
) -> dict[str, Any]:  # fmt: skip
    """A body on points over a floor that falls along x; all of it turned."""
    floor = turn.apply([np.sin(slope), 0, np.cos(slope)]).tolist()
    rotation = quaternion(turn if tilt is None else turn * tilt)
    body = parts.body("b", mass, [0.01, 0.015, 0.02], position=turn.apply(position).tolist(), rotation=rotation)
    contacts = parts.feet("b", points, "c", normal=floor, friction=friction)
    model = {"gravity": turn.apply([0, 0, -G]).tolist(), "bodies": [body], "contacts": contacts}
    return {"model": model | more, **SHORT}


def stays(scenario: dict[str, Any]) -> None:
    """Each run that starts in its equilibrium is still there at its end."""
    ds = lienumba.run({**scenario, "start": {"from": "equilibrium"}})
    assert (ds.status.values == 0).all()
    moved = np.abs(ds.position.values - ds.position.isel(time=[0]).values).max()
    assert moved < 1e-11


TURNS = [Rotation.identity(), Rotation.from_rotvec([0.3, 0.7, -1.1])]


@pytest.mark.parametrize("turn", TURNS)
def test_an_arm_comes_to_rest_on_its_stop_and_leaves_one_that_would_have_to_pull(turn: Rotation) -> None:
    def arm(angle: float, low: float, high: float) -> dict[str, Any]:
        hinge = parts.joint("j", "revolute", "w", points=[[0, 0, 0], [-0.5, 0, 0]], angle=angle)
        hinge["axes"] = [turn.apply([0, 1, 0]).tolist(), [0, 1, 0]]
        hinge["references"] = [turn.apply([1, 0, 0]).tolist(), [1, 0, 0]]
        stop = {"joint": "j", "low": low, "high": high}
        bodies = [parts.body("w")]
        model = {"gravity": turn.apply([0, 0, -G]).tolist(), "bodies": bodies, "joints": [hinge], "limits": [stop]}
        return {"model": model, "quantities": [{"name": "turn", "type": "joint", "joint": "j"}], **SHORT}

    for angle, low, high, expected in (
        (-0.4, -0.5, 0.3, 0.3),  # falls on it
        (0.3, -0.5, 0.3, 0.3),  # lies on it
        (0.3, 0.3, 2.0, np.pi / 2),  # touches it, and hangs free
        (2.5, 2.0, 2.9, 2.0),  # falls on the other one
        (1.9, 1.7, 2.0, 1.7),
    ):
        found = lienumba.equilibrium(arm(angle, low, high))
        assert found.status.item() == 0
        assert found["turn.angle"].item() == pytest.approx(expected, abs=1e-12)
        stays(arm(angle, low, high))


@pytest.mark.parametrize("turn", TURNS)
def test_a_block_on_a_slope_stays_where_friction_can_hold_it(turn: Rotation) -> None:
    slope, limit = 0.3, np.tan(0.3)
    coefficients = np.array([0.5 * limit, limit - 1e-6, limit + 1e-6, 2.0 * limit])
    start = Rotation.from_euler("y", slope).apply([0.0, 0.0, HALF])
    block = on_points(CORNERS, turn, start, Rotation.from_euler("y", slope), slope, "mu")
    data = {**block, "parameters": {"mu": 0.5}, "sweep": parts.table({"parameters.mu": coefficients.tolist()})}
    found = lienumba.equilibrium(data)
    assert found.status.values.tolist() == [1, 1, 0, 0]
    np.testing.assert_allclose(found.position.values[2:, 0], [turn.apply(start)] * 2, atol=1e-15)
    alone = lienumba.equilibrium(data, runs=[2])
    for name in ("position", "rotation", "status", "force"):
        np.testing.assert_array_equal(alone[name].values[0], found[name].values[2])


@pytest.mark.parametrize("turn", TURNS)
def test_a_ladder_stands_from_half_its_cotangent_on(turn: Rotation) -> None:
    """With friction on the floor alone; two feet and two tops, so that normal forces are not unique."""
    angle, length = 1.0, 2.0
    limit = 0.5 / np.tan(angle)
    coefficients = limit * np.array([0.8, 1.0 - 1e-6, 1.0 + 1e-6, 1.4])
    lie = Rotation.from_euler("y", angle)  # x of the ladder from its top to its feet
    middle = [-0.5 * length * np.cos(angle), 0.0, 0.5 * length * np.sin(angle)]
    x, z = turn.apply([1, 0, 0]).tolist(), turn.apply([0, 0, 1]).tolist()
    wall = turn.apply([-length * np.cos(angle), 0, 0]).tolist()
    feet = parts.feet("l", [[length / 2, y, 0] for y in (-0.2, 0.2)], "f", normal=z, friction="mu")
    tops = parts.feet("l", [[-length / 2, y, 0] for y in (-0.2, 0.2)], "t", on=wall, normal=x)
    ladder = parts.body("l", 10, [0.2, 3.4, 3.4], position=turn.apply(middle).tolist(), rotation=quaternion(turn * lie))
    model = {"gravity": turn.apply([0, 0, -G]).tolist(), "bodies": [ladder], "contacts": [*feet, *tops]}
    table = parts.table({"parameters.mu": coefficients.tolist()})
    data = {"parameters": {"mu": 0.5}, "model": model, "sweep": table, **SHORT}
    found = lienumba.equilibrium(data)
    stood = np.abs(found.position.values[:, 0] - turn.apply(middle)).max(axis=1) < 1e-12
    assert stood.tolist() == [False, False, True, True]
    assert found.status.values[2:].tolist() == [0, 0]


@pytest.mark.parametrize("turn", TURNS)
def test_four_feet_of_which_one_carries_nothing(turn: Rotation) -> None:
    """Forces of least norm would pull at one of them."""
    pull = {
        "name": "f", "type": "force", "body": "b", "point": [0.09, 0.08, 0.0],
        "value": turn.apply([0.5, -1.0, -60.0]).tolist(),
    }  # fmt: skip
    data = on_points(CORNERS, turn, [0, 0, HALF], forces=[pull], friction=0.4)
    assert lienumba.equilibrium(data).status.item() == 0
    stays(data)


@pytest.mark.parametrize(("slope", "status"), [(0.0, 0), (0.1, 1)])
def test_without_friction_it_drifts(slope: float, status: int) -> None:
    tilt = Rotation.from_euler("y", slope)
    data = on_points(CORNERS, TURNS[1], tilt.apply([0, 0, HALF]), tilt, slope, friction=0.0)
    found = lienumba.equilibrium(data)
    assert found.status.item() == status
    if status == 0:
        np.testing.assert_allclose(found.position.values[0, 0], TURNS[1].apply([0, 0, HALF]), atol=1e-14)


def test_what_is_dropped_rests_on_a_face_from_whatever_height() -> None:
    sizes = 0.1, 0.1, HALF
    corners = [[x, y, z] for x in (-0.1, 0.1) for y in (-0.1, 0.1) for z in (-HALF, HALF)]
    for height in (0.3, 3.0, 300.0):
        tilt = Rotation.from_rotvec([0.4, -0.2, 0.3])
        found = lienumba.equilibrium(on_points(corners, TURNS[1], [0, 0, height], tilt))
        assert found.status.item() == 0
        rest = TURNS[1].inv().apply(found.position.values[0, 0])[2]
        assert min(abs(rest - half) for half in sizes) < 1e-12


def test_a_block_on_its_edge_is_unstable_and_found_where_it_balances() -> None:
    lean = np.arctan(0.1 / HALF)
    tilt = Rotation.from_euler("y", lean)
    edge = [[0.1, y, -HALF] for y in (-0.1, 0.1)]
    data = on_points(edge, TURNS[0], -tilt.apply([0.1, 0, -HALF]), tilt)
    found = lienumba.equilibrium(data)
    assert found.status.item() == 2
    inertia = 0.015 + 2.0 * (0.1**2 + HALF**2)
    assert found.growth.item() == pytest.approx(np.sqrt(2.0 * G * np.hypot(0.1, HALF) / inertia), rel=1e-9)


def test_a_block_on_springs_is_pressed_where_statics_says() -> None:
    """Three springs lift it less than it weighs; one more lifts it off, where the floor is not in its equilibrium."""

    def hung(stiffness: float, friction: float) -> dict[str, Any]:
        springs = [
            {"name": f"s{n}", "type": "spring_damper", "bodies": ["ground", "b"], "stiffness": stiffness,
             "damping": 0.1, "free_length": 0.0,
             "points": [[0.1 * np.cos(a), 0.1 * np.sin(a), 0.25], [0.1 * np.cos(a), 0.1 * np.sin(a), 0.0]]}
            for n, a in enumerate(0.2 + np.arange(3) * 2 * np.pi / 3)
        ]  # fmt: skip
        return on_points(CORNERS, TURNS[0], [0.02, 0.01, 0.08], friction=friction, forces=springs)

    for friction in (0.0, 0.3):
        pressed = lienumba.equilibrium(hung(30.0, friction))
        assert pressed.status.item() == 0
        assert pressed.position.values[0, 0, 2] == pytest.approx(HALF, abs=1e-12)
        lifted = lienumba.equilibrium(hung(40.0, friction))
        assert lifted.status.item() == 0
        assert lifted.position.values[0, 0, 2] == pytest.approx(0.25 - 2.0 * G / 120.0, abs=1e-12)
        stays(hung(30.0, friction))
        stays(hung(40.0, friction))


def test_a_governor_turns_with_its_arms_on_their_stops() -> None:
    """Below the speed at which they leave the lower ones, between, and above that at which they meet the upper ones."""

    def governor(speed: float) -> Any:
        bodies = [parts.body("p", 1.0, position=[0, 0, 0], rotation=[1, 0, 0, 0]), parts.body("b", 1.0, 1e-6)]
        axes: Any = {"axes": [[0, -1, 0]] * 2, "references": [[0, 0, -1]] * 2}
        swings = parts.pivot("s", "b", second=[0, 0, 0.4], to="p", angle=0.5, **axes)
        joints = [parts.hinge("t", "p", axis=parts.Z), swings]
        limits = [{"joint": "s", "low": 0.3, "high": 1.0}]
        model = {"gravity": [0, 0, -G], "bodies": bodies, "joints": joints, "limits": limits}
        data = {"model": model, "quantities": [{"name": "arm", "type": "joint", "joint": "s"}], **SHORT}
        return lienumba.equilibrium(data, rotation=(0, 0, speed))

    for speed in (3.0, 5.6, 9.0):
        found = governor(speed)
        free = np.arccos(min(1.0, G / (0.4 * speed**2)))
        assert found.status.item() == 0
        assert found["arm.angle"].item() == pytest.approx(np.clip(free, 0.3, 1.0), abs=1e-5)


def scene(seed: int) -> dict[str, Any]:
    """Balls in grooves, feet on slopes, chains over floors, turned anyhow."""
    rng, turn = np.random.default_rng(seed), Rotation.random(random_state=seed)
    slope, friction = float(rng.choice([0.0, 0.1, 0.3])), float(rng.choice([0.0, 0.2, 0.5, 0.9]))
    floor = turn.apply([np.sin(slope), 0, np.cos(slope)]).tolist()
    model: dict[str, Any] = {"gravity": turn.apply([0, 0, -G]).tolist()}
    if seed % 3 == 0:
        walls = np.array([[0.64, 0, 0.77], [-0.64, 0.1, 0.77], [0, 1.0, 0.4], [0, -1.0, 0.4]])
        walls /= np.linalg.norm(walls, axis=1)[:, None]
        model["bodies"] = [
            parts.body(f"b{n}", 1.0 + n, 0.004 * (1 + n),
                       position=turn.apply([0.02 * n, 0.15 * n - 0.1, 0.6 + 0.3 * n]).tolist())
            for n in range(2)
        ]  # fmt: skip
        model["contacts"] = [
            parts.sphere(f"w{n}{m}", f"b{n}", 0.1, on=turn.apply(-0.3 * (m > 1) * wall).tolist(),
                         normal=turn.apply(wall).tolist(), friction=friction)
            for n in range(2) for m, wall in enumerate(walls)
        ]  # fmt: skip
        both: Any = {"type": "sphere_sphere", "radii": [0.1, 0.1], "friction": friction}
        model["contacts"].append(parts.foot("both", "b0", to="b1", **both))
    elif seed % 3 == 1:
        rough = rng.normal(size=3) * 0.3
        rotation = quaternion(turn * Rotation.from_rotvec(rough))
        place = turn.apply([0, 0, 0.6]).tolist()
        model["bodies"] = [parts.body("b", 2.0, [0.06, 0.04, 0.08], position=place, rotation=rotation)]
        angles = np.arange(4) * np.pi / 2 + rng.uniform(-0.3, 0.3, 4)
        places = [[0.2 * np.cos(a), 0.2 * np.sin(a), -0.25] for a in angles]
        tips: Any = {"type": "sphere_plane", "radius": 0.03}
        model["contacts"] = parts.feet("b", places, "c", normal=floor, friction=friction, **tips)
    else:
        along, at = turn.apply([np.sin(0.6), 0, -np.cos(0.6)]), turn.apply([0, 0, 1.02])
        model["bodies"] = [
            parts.body(f"b{n}", 1.0, [0.02, 0.02, 0.001], position=(at + along * (0.25 + 0.5 * n)).tolist(),
                       rotation=quaternion(turn))
            for n in range(2)
        ]  # fmt: skip
        axis = turn.apply([0, 1, 0]).tolist()
        model["joints"] = [
            parts.hinge(f"j{n}", f"b{n}", (at + 0.5 * n * along).tolist(), axis, to=["ground", "b0"][n])
            for n in range(2)
        ]
        tip = turn.inv().apply(0.25 * along).tolist()
        low = turn.apply([0, 0, 0.1]).tolist()
        model["contacts"] = [parts.sphere("tip", "b1", 0.02, tip, low, normal=floor, friction=friction)]
        model["limits"] = [{"joint": "j1", "low": -0.2, "high": 0.3}][: int(rng.integers(2))]
    return {"model": model, **SHORT}


@pytest.mark.parametrize("seed", range(9))
def test_what_starts_where_it_rests_stays_there(seed: int) -> None:
    """The engine itself is the judge, which decides by accelerations what holds."""
    data = scene(seed)
    found = lienumba.equilibrium(data)
    if found.status.item() == 0:
        stays(data)
    else:
        slides = seed % 3 == 1 and data["model"]["contacts"][0]["friction"] < 0.31
        assert slides, found.status.item()
