"""A few of the bodies that scripts/fuzz_drops throws."""

import numpy as np
import pytest

from tests.oracles.dropping.drawing import SHAPES, drop
from tests.oracles.dropping.judging import HONEST, Verdict, judge


@pytest.mark.parametrize("seed", [4, 18, 143, 194, 197])
def test_what_is_thrown_sinks_nowhere_and_gains_no_energy(seed: int) -> None:
    """18: sliding that ends, with friction turning about it, took 73,000 steps. 143: a disc that turns fast, whose edge
    came down within a long step of free flight. 194: a disc that is hit, and begins to slide from rest. 197: a disc
    that begins flat, where its edge has no finite acceleration, was never hit."""
    verdict = judge(drop(seed))
    assert verdict.problems() == []
    assert verdict.status in ("success", *HONEST)
    assert verdict.changes > 5
    assert verdict.steps < 10_000


@pytest.mark.campaign(4)
def test_new_bodies_are_thrown(seed: int) -> None:
    assert judge(drop(seed)).problems() == []


def test_a_disc_that_falls_on_its_face_ends_there() -> None:
    """146: where it touches leapt to the other side within a step, and the projection of velocities took a quarter of
    its energy."""
    verdict = judge(drop(146))
    assert verdict.problems() == []
    assert (verdict.status, verdict.flat) == ("step_too_short", True)
    assert verdict.residual < 0.01
    assert verdict.steps < 100


def test_all_shapes_are_drawn_and_begin_above_their_planes() -> None:
    titles = set()
    for seed in range(200):
        thrown = drop(seed)
        bodies = thrown.scenario["model"]["bodies"]
        poses = (np.array([body[name] for body in bodies]) for name in ("position", "rotation"))
        assert 0.005 <= thrown.gap(*poses) <= 0.5 + 1e-12
        titles.add(thrown.title)
    assert {title.split()[0].strip(",") for title in titles} == set(SHAPES)
    assert any("2 planes" in title for title in titles)
    assert any("and" in title for title in titles)


def test_a_verdict_tells_what_should_not_be() -> None:
    assert Verdict("success", 9, 1, 0.1, 0.0, 0.0, 1.0).problems() == []
    assert Verdict("step_too_short", 9, 1, 0.1, 0.0, 0.0, 1.0).problems() == ["step_too_short"]
    assert Verdict("step_too_short", 9, 1, 0.1, 0.0, 0.0, 1.0, flat=True).problems() == []
    bad = Verdict("non_finite", 9, 1, 1e3, 200.0, 1e-6, 1.0).problems()
    assert bad == ["non_finite", "residual 1.0e+03", "energy rises by 2.0e+02", "sinks by 1.0e-06 m"]
