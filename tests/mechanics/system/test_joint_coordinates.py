"""Coordinates of joints against rotations composed of them, and against the states of moves."""

from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lienumba.mechanics.elements import joints
from lienumba.mechanics.mechanism.kinematics import still
from lienumba.mechanics.mechanism.model import Coordinate
from lienumba.mechanics.tree import motion
from tests.facade import JOINTS
from tests.mechanics.tree.test_moves import pair
from tests.rigs.random_trees import MOVING, close

WITH_COORDINATES = [kind for kind in MOVING if JOINTS[kind].independent()]
CROSSED = np.array([[0, 0, 1], [0, -1, 0], [1, 0, 0.0]])  # frames of crossed pins at 0: z along x, x along z


def about_z(angle: float) -> np.ndarray:
    return Rotation.from_rotvec([0.0, 0.0, angle]).as_matrix()


# Relative rotation and displacement of the frames by the coordinates.
COMPOSED: dict[str, Any] = {
    "revolute": lambda q, p: (about_z(q[0]), [0, 0, 0]),
    "prismatic": lambda q, p: (np.eye(3), [0, 0, q[0]]),
    "screw": lambda q, p: (about_z(q[0]), [0, 0, p["offset"] + p["pitch"] * q[0] / (2 * np.pi)]),
    "cylindrical": lambda q, p: (about_z(q[0]), [0, 0, q[1]]),
    "universal": lambda q, p: (about_z(q[0]) @ CROSSED @ about_z(q[1]), [0, 0, 0]),
    "planar": lambda q, p: (about_z(q[2]), [q[0], q[1], 0]),
    "spherical": lambda q, p: (Rotation.from_rotvec(q).as_matrix(), [0, 0, 0]),
}


def frame(joint: Any, side: int) -> np.ndarray:
    return np.eye(3) if joint.frames is None else np.array(joint.frames[side], float).T


def test_every_type_with_moves_has_as_many_coordinates_as_rates() -> None:
    assert set(WITH_COORDINATES) == {*COMPOSED}
    for kind in MOVING:
        assert len(JOINTS[kind].independent()) == sum(move.freedoms for move in JOINTS[kind].moves or ())


def test_a_name_has_one_unit() -> None:
    every = [x for kind in JOINTS.values() for x in kind.freedoms()]
    for name in {x.name for x in every}:
        assert len({(x.turning, x.rate) for x in every if x.name == name}) == 1


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("kind", WITH_COORDINATES)
def test_bodies_are_where_their_coordinates_put_them(kind: str, seed: int) -> None:
    model, here = pair(kind, 1.0, True, seed)
    joint, view = model.joints[0], still(here.now, (0, 1))
    q = [float(joints.coordinate(model, Coordinate(0, x.name), view)) for x in JOINTS[kind].independent()]
    E, d = COMPOSED[kind](q, joint.numbers)
    (Ra, Rb), (Fa, Fb) = (np.reshape(view[i].R, (3, 3)) for i in (0, 1)), (frame(joint, i) for i in (0, 1))
    close(Rb @ Fb, Ra @ Fa @ E, 1e-14)
    a, b = (np.array(view[i].point(p)) for i, p in enumerate(joint.points or ()))
    close(b, a + Ra @ Fa @ np.array(d), 1e-14)


@pytest.mark.parametrize("way", [1.0, -1.0])
@pytest.mark.parametrize("kind", WITH_COORDINATES)
def test_rates_are_those_of_the_moves(kind: str, way: float) -> None:
    """Of a second body that is the child; where its axis is turned round, moves count along the first's."""
    model, here = pair(kind, way, True)
    view = still(here.now, (0, 1))
    found = {x.name: float(joints.rate(model, Coordinate(0, x.name), view)) for x in JOINTS[kind].independent()}
    rates = [
        rate
        for link in here.tree.links
        if link.joint == 0
        for rate in motion.state_of(link, tuple(here.z))[link.move.places :]
    ]
    close(sorted(found.values()), sorted(rates), 1e-13)


@pytest.mark.parametrize("kind", ["revolute", "cylindrical", "screw", "universal", "planar"])
def test_angles_are_counted_near_what_is_known(kind: str) -> None:
    model, here = pair(kind, 1.0, True)
    for x in (x for x in JOINTS[kind].independent() if x.counts):
        which = Coordinate(0, x.name)
        principal = joints.coordinate(model, which, still(here.now, (0, 1)))
        here.now.angles[which.counted] = principal - 8 * np.pi + 1.0
        assert joints.coordinate(model, which, still(here.now, (0, 1))) == pytest.approx(principal - 8 * np.pi)
