"""The frames of the moving mechanism: enough of them, few enough, and the attitudes that they stand for."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lienumba.present.html import motion
from lienumba.present.html.chart import color
from lienumba.present.html.motion import LARGEST_TURN, MOST_FRAMES, UNIT, frames, quaternions
from lienumba.scene import scene
from tests.rigs.pages import array, swept


def spinning(rates):
    """Rotations (T, 1, 3, 3) about z whose angles grow by these rates at 10,001 times of 1 s."""
    times = np.linspace(0.0, 1.0, 10_001)
    angles = np.concatenate([[0.0], np.cumsum(np.broadcast_to(rates, 10_000)) * 1e-4])
    return times, Rotation.from_rotvec(np.outer(angles, [0, 0, 1])).as_matrix()[:, None]


def test_slow_motion_has_evenly_spread_frames():
    times, rotations = spinning(1.0)
    kept = frames(times, rotations, 100_000)
    assert (kept[0], kept[-1]) == (0, 10_000)
    assert len(kept) == pytest.approx(MOST_FRAMES, abs=2)
    assert np.ptp(np.diff(kept)) <= 1


def test_fast_turns_have_more_frames():
    times, rotations = spinning(np.where(np.arange(10_000) < 5000, 1.0, 1000.0))
    kept = frames(times, rotations, 100_000)
    late = kept[kept > 5000]
    assert np.diff(late).max() * 0.1 <= LARGEST_TURN + 0.1  # rad
    assert np.diff(kept[kept < 5000]).min() > np.diff(late).max()
    assert len(frames(times, rotations, 200)) <= 200


def test_quaternions_are_those_of_the_rotations():
    rotations = Rotation.random(50, rng=1).as_matrix().reshape(5, 10, 3, 3)
    found = quaternions(rotations)
    again = Rotation.from_quat(found.reshape(-1, 4), scalar_first=True).as_matrix()
    assert again.reshape(rotations.shape) == pytest.approx(rotations, abs=1e-14)
    assert np.take_along_axis(found, abs(found).argmax(axis=-1)[..., None], axis=-1).min() > 0.0


def test_a_run_says_where_bodies_are_and_what_is_drawn():
    shown = scene(swept(), count=2)
    sent = motion.data(shown, [0, 0, -9.81])
    run, first = sent["runs"][0], shown.runs[0]
    assert array(run["times"]) == pytest.approx(first.times)
    assert array(run["positions"]).reshape(-1, 2, 3) == pytest.approx(first.positions, abs=1e-6)
    q = array(run["quaternions"]).reshape(-1, 4) / UNIT
    turned = Rotation.from_quat(q, scalar_first=True).as_matrix().reshape(-1, 2, 3, 3)
    assert turned == pytest.approx(first.rotations, abs=1e-4)
    figure, solids = sent["figures"][run["figure"]], first.mechanism.solids
    counts = np.array(figure["counts"])
    assert counts.tolist() == [*([len(x.vertices), len(x.triangles())] for x in solids), [0, 0]]
    owner = np.repeat(np.arange(3), counts[:, 0])
    corners = array(figure["vertices"]).reshape(-1, 3) * np.array(figure["radii"])[owner][:, None] / UNIT
    assert corners == pytest.approx(np.concatenate([x.vertices for x in solids]), abs=1e-4 * max(figure["radii"]))
    assert array(figure["triangles"]).tolist() == [n for x in solids for face in x.triangles() for n in face]
    painted = [figure["palette"][n] for n in array(figure["painted"])]
    for body, found in zip(np.repeat(np.arange(3), counts[:, 1]), painted, strict=True):
        assert found in (color(body), motion._light(body))
    assert sent["compared"] == 1
    assert run["label"] == "nominal run"


@pytest.mark.parametrize(
    ("extent", "gravity", "side", "up"),
    [
        ([2, 2, 2], [0, 0, -9.81], 0, [0, 0, 1]),
        ([2, 1, 0.1], [0, -9.81, 0], 0, [0, 1, 0]),
        ([2, 0.1, 2], [0, 0, 0], 0, [0, 0, 1]),
        ([0.1, 2, 2], ["g*t", 0, 0], 1, [0, 0, 1]),
    ],
)
def test_one_looks_from_the_front_and_the_side_points_to_the_right(extent, gravity, side, up):
    eye, found = motion._view(np.array(extent, float), gravity)
    assert found.tolist() == up
    assert np.cross(up, eye)[side] > 0.0
    assert eye @ found > 0.0
