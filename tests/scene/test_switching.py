"""What is locked, open and closed is seen where and when it is."""

import numpy as np
import pytest

from lienumba.scene import scene
from lienumba.scene.switching import CLOSED, LOCKED, OPEN, PLAIN
from tests.rigs.changing import changing

FALL = (2 * 0.05 / 9.81) ** 0.5  # s, of the ball to the floor


def test_looks_and_places():
    (run,) = scene(changing(), runs=[2]).runs
    found = run.switching
    assert found.names == ("hook", "hinge.lock", "floor")
    assert found.at(np.array([0.0, 0.075, 0.2, 9.0]))[:, :2].tolist() == [
        [PLAIN, PLAIN], [OPEN, PLAIN], [OPEN, LOCKED], [OPEN, LOCKED]
    ]  # fmt: skip
    assert run.at(found.places)[0] == pytest.approx(np.array([[1, 0, 0.15], [0, 0, 0], [1, 0, 0.15]]))


def test_hits_are_seen_for_a_while():
    (run,) = scene(changing(), runs=[1]).runs
    found = run.switching
    first = found.hits[0][0]
    assert first == pytest.approx(0.05 + FALL, abs=1e-9)
    assert found.hit(first + np.array([-1e-6, 0.0, 0.01, 0.02]), 0.01)[:3].tolist() == [
        [False, False, False], [False, False, True], [False, False, False]
    ]  # fmt: skip


def test_what_rests_is_closed():
    run = int(changing()["contacts.floor.restitution"].values.argmin())
    found = scene(changing(), runs=[run]).runs[0].switching
    modes = changing()["mode"].sel(run=run, switch="floor").values
    assert (found.looks[:, 2] == np.where(modes > 0, CLOSED, PLAIN)).all()


def test_nothing_changes_without_modes():
    assert scene(changing().drop_vars("mode"), runs=[0]).runs[0].switching is None
