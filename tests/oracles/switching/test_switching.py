"""A few of the mechanisms that scripts/fuzz_changes changes."""

from pathlib import Path

import numpy as np
import pytest

from tests.oracles.switching.comparing import compare, judge, oracle, run, same_bits, way_of
from tests.oracles.switching.drawing import changing
from tests.oracles.switching.laws import complementary

SEED, WAY = 10, "rk4 joint"


@pytest.mark.parametrize(("seed", "way"), [(0, "dop853 joint"), (113, "dop853")])
def test_both_see_the_same(seed: int, way: str) -> None:
    verdict = judge(changing(seed), way)
    assert (verdict.what, verdict.problems) == ("compared", [])
    assert verdict.changes


@pytest.mark.campaign(6)
def test_both_see_the_same_in_new_mechanisms(seed: int) -> None:
    verdict = judge(changing(seed), way_of(seed))
    assert verdict.problems == [], verdict.what


@pytest.mark.release
def test_a_wrong_restitution_would_show(tmp_path: Path) -> None:
    data = changing(SEED)
    ds = run(data, WAY)
    assert compare(data, oracle(data), ds, WAY).problems == []
    assert same_bits(data, WAY, tmp_path) == []
    for limit in data["model"]["limits"]:
        limit["restitution"] *= 1.001
    assert any("energy_lost" in problem for problem in compare(data, oracle(data), ds, WAY).problems)


@pytest.mark.release
def test_friction_that_sticks_is_the_same_and_another_would_show() -> None:
    data, way = changing(60001), "dop853 joint"
    course = oracle(data)
    found = compare(data, course, run(data, way), way)
    assert (found.problems, {"stuck", "slid"} <= {*found.changes}) == ([], True)
    for force in data["model"]["forces"]:
        if "static" in force:
            force["coulomb"] *= 1.001
    assert any("velocity" in problem for problem in compare(data, course, run(data, way), way).problems)


def test_of_three_that_could_push_those_that_have_to_do() -> None:
    """Balls in a row: the first one hits the second, and the third one, that leans on a wall, is hit by that."""
    M, v = np.diag([1.0, 2.0, 3.0]), np.array([3.0, 0.0, 0.0])
    C = np.array([[-1.0, 1.0, 0.0], [0.0, -1.0, 1.0], [0.0, 0.0, -1.0]])
    x, _, p = complementary(M, M @ v, np.zeros((0, 3)), np.zeros(0), C, np.zeros(3))
    np.testing.assert_allclose(x, 0.0, atol=1e-12)
    np.testing.assert_allclose(p, 3.0, rtol=1e-12)
    x, _, p = complementary(M, M @ v, np.zeros((0, 3)), np.zeros(0), C[:2], np.zeros(2))
    np.testing.assert_allclose(x, 0.5, rtol=1e-12)
    np.testing.assert_allclose(p, [2.5, 1.5], rtol=1e-12)
