"""Starts that only the joints' coordinates, or drivers, decide: bodies without poses are where textbooks have them."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lienumba
from tests.oracles.trees.dense import Array, Motion, motion
from tests.oracles.trees.kinematics import COORDINATES
from tests.oracles.trees.test_joints import SIZES, chain
from tests.oracles.trees.test_prescribed import NUDGE, SWAY, hung
from tests.oracles.trees.trees import Link, Random, Tree, same, scenario
from tests.rigs.scenarios import start_of

EVERYTHING = ("position", "rotation", "velocity", "angular_velocity")
SAYS = {
    "revolute": ("angle", "rate"),
    "prismatic": ("displacement", "speed"),
    "cylindrical": ("angle", "rate", "displacement", "speed"),
    "screw": ("angle", "rate", "displacement"),
}


def says(link: Link, q: Array, qd: Array) -> dict[str, float]:
    """What the start says of a joint whose coordinates are the first of these."""
    kind, last = link.joint.type, len(link.free) - 1
    if kind == "fixed":
        return {}
    known = {"angle": q[0], "rate": qd[0], "displacement": q[last], "speed": qd[last]}
    if kind == "screw":
        known["displacement"] = q[0] * link.size / (2 * np.pi)
    return {key: float(known[key]) for key in SAYS[kind]}


def check(data: dict[str, Any], here: Motion, bound: float = 1e-10) -> None:
    _, states = start_of(data)
    r, R, v, w = np.split(states, (3, 12, 15), axis=1)
    same(r, here.r, bound, "position")
    same(R.reshape(-1, 3, 3), here.R, bound, "rotation")
    same(v, here.v, bound, "velocity")
    same(w, np.einsum("bji,bj->bi", here.R, here.w), bound, "angular velocity")


@pytest.mark.parametrize("order", ["+-", "-+"])
@pytest.mark.parametrize("kind", SAYS)
def test_coordinates_of_the_joints_are_enough(kind: str, order: str) -> None:
    tree, draw = chain(kind, order)
    q, qd = draw.start(tree)
    each = len(tree.links[0].free)
    links = []
    for i, link in enumerate(tree.links):
        known = says(link, q[each * i :], qd[each * i :])
        links.append(replace(link, joint=replace(link.joint, says=known)))
    here = motion(tree.mechanism, 0.0, q, qd)
    check(scenario(Tree(links), here, EVERYTHING), here)


@pytest.mark.parametrize("seed", range(2))
def test_a_tree_of_all_joints_starts_along_them(seed: int) -> None:
    """Bodies behind joints with coordinates have no poses; those behind others have, and one without a joint."""
    draw = Random("tree", seed)
    kinds = draw.draw.permutation([*COORDINATES, *SAYS, "fixed", *SAYS, "fixed"]).tolist()
    kinds = ["perpendicular_axes", *kinds]
    links: list[Link] = []
    for i, kind in enumerate(kinds):
        base = "ground" if i == 0 else str(draw.draw.choice(["ground", *(link.name for link in links)]))
        ends = (base, f"b{i}") if draw.draw.uniform() < 0.5 else (f"b{i}", base)
        links.append(Link(f"b{i}", draw.body(), draw.joint(f"j{i}", kind, ends), base, SIZES.get(kind, 0.0)))
    tree = Tree(links)
    q, qd = draw.start(tree)
    here = motion(tree.mechanism, 0.0, q, qd)
    data = scenario(tree, here)
    place = 0
    for i, link in enumerate(links):
        kind, body, joint = link.joint.type, data["model"]["bodies"][i], data["model"]["joints"][i]
        if kind in (*SAYS, "fixed"):
            for key in EVERYTHING:
                del body[key]
            joint |= says(link, q[place:], qd[place:])
        place += COORDINATES[kind]
    del data["model"]["joints"][0]
    check(data, here, 1e-12)


@pytest.mark.parametrize("kind", ["spherical", "revolute", "universal", "fixed"])
def test_positions_and_velocities_follow_from_the_turning(kind: str) -> None:
    tree, draw = chain(kind, "+-")
    here = motion(tree.mechanism, 0.0, *draw.start(tree))
    check(scenario(tree, here, ("position", "velocity")), here)


@pytest.mark.parametrize("order", "+-")
def test_drivers_decide_where_a_body_starts(order: str) -> None:
    texts = {"angle": SWAY[0], "displacement": NUDGE[0]}
    drivers = [{"joint": "shaft", "coordinate": c, "value": text} for c, text in texts.items()]
    tree = hung("cylindrical", order, {0: SWAY[1], 1: NUDGE[1]}, drivers=drivers, closing={"speed": 20.0})
    here = motion(tree.mechanism, 0.0, *Random("decided", order).start(tree))
    data = scenario(tree, here)
    for key in EVERYTHING:
        del data["model"]["bodies"][1][key]
    check(data, here)


@pytest.mark.parametrize("tilt", [0.0, 4.9e-12, 1e-9])
def test_axes_that_are_nearly_parallel_do_not_turn_bodies(tilt: float) -> None:
    """Where rounding decides how the frames of links lie about such axes, kernels begin where the joints say."""
    axes = [np.array(axis, float) / np.linalg.norm(axis) for axis in ([2, 1, 1], [0, -1, 1], [0, -1, 1 + tilt])]
    arm, angles = np.array([0.3, -0.2, 0.25]), (0.3, -0.4, 0.5)
    system = lienumba.System("Three hinges")
    place, turned, expected = np.zeros(3), Rotation.identity(), []
    for n, (axis, angle) in enumerate(zip(axes, angles, strict=True)):
        across = np.cross(axis, [1.0, 0.0, 0.0])
        points = [arm if n else np.zeros(3), -arm]
        system.body(f"b{n}", mass=1.0, inertia=[0.1, 0.2, 0.25])
        system.joint(
            f"j{n}", "revolute", [f"b{n - 1}" if n else "ground", f"b{n}"], points=points, axes=[axis] * 2,
            references=[across] * 2, angle=angle, rate=0.0,
        )  # fmt: skip
        turned = turned * Rotation.from_rotvec(angle * axis)
        place = place + turned.apply(arm)
        expected.append(place)
        place = place + turned.apply(arm)
    system.integrator(step=1e-3, end_time=1e-3, coordinates="joint")
    found = lienumba.run(system).position.values[0, 0]
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-14)
