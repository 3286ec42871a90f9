"""Subset simulation, FORM and importance sampling against probabilities that are known in closed form."""

from collections.abc import Callable

import numpy as np
import pytest
from scipy import integrate, stats

from lienumba.engine.rare.design_points import design_points
from lienumba.engine.rare.estimate import Estimate
from lienumba.engine.rare.rare import METHODS
from tests.facade import ScenarioError

RARE = 1e-6
FAR = float(stats.norm.isf(RARE))
CURVATURE, OFF = 0.25, 4.6
SHELL = float(stats.chi2.isf(RARE, 3))
CORNER = float(stats.norm.isf((1.0 - np.sqrt(1.0 - RARE)) / 2))
BOTH = float(stats.norm.isf(RARE / 2))
REPEATS = 60
FEW_REPEATS = 15  # where design points are many, and searching for them takes most of the time
Case = tuple[Callable[[np.ndarray], np.ndarray], int, float]


NORMALS = np.linalg.qr(np.random.default_rng(7).standard_normal((50, 2)))[0].T


def beyond(y: float) -> float:
    """The density of failing at a second number of this size, of the curved limit."""
    return float(stats.norm.pdf(y) * stats.norm.sf(OFF + CURVATURE * y * y))


CASES: dict[str, Case] = {
    "plane": (lambda z: FAR - z.sum(axis=1) / np.sqrt(z.shape[1]), 5, RARE),
    "curved": (
        lambda z: OFF - z[:, 0] + CURVATURE * z[:, 1] ** 2,
        2,
        float(integrate.quad(beyond, -9, 9, epsabs=0)[0]),
    ),
    "two sides": (lambda z: BOTH - abs(z[:, 0]), 4, RARE),
    "all round": (lambda z: SHELL - (z * z).sum(axis=1), 3, RARE),
    "many inputs": (lambda z: FAR - z.sum(axis=1) / np.sqrt(z.shape[1]), 40, RARE),
    "four planes": (lambda z: CORNER - abs(z[:, :2]).max(axis=1), 3, RARE),
    "exponentials": (lambda z: 16.7 + stats.norm.logsf(z).sum(axis=1), 2, 17.7 * float(np.exp(-16.7))),
    "many and two exponentials": (
        lambda z: 16.7 + stats.norm.logsf(z[:, :2]).sum(axis=1),
        20,
        17.7 * float(np.exp(-16.7)),
    ),
    "three exponentials": (lambda z: 19.0 + stats.norm.logsf(z).sum(axis=1), 3, float(stats.gamma.sf(19.0, 3))),
    "jump": (
        lambda z: 4.5 - z[:, 0] - 2.0 * (z[:, 1] > stats.norm.isf(0.01)),
        2,
        float(0.99 * stats.norm.sf(4.5) + 0.01 * stats.norm.sf(2.5)),
    ),
    "flat at first": (
        lambda z: np.minimum(4.3**3 - z[:, 0] ** 3, 4.5 - abs(z[:, 1])),
        2,
        float(1.0 - stats.norm.cdf(4.3) * (1.0 - 2.0 * stats.norm.sf(4.5))),
    ),
    "behind another": (
        lambda z: np.minimum(5.0 - z[:, 0], 10.0 * (z[:, 1] + 4.0)),
        2,
        float(1.0 - stats.norm.cdf(5.0) * stats.norm.cdf(4.0)),
    ),
    "hidden among many": (
        lambda z: np.where(z[:, 1] + z[:, 2] > 3.7 * np.sqrt(2.0), np.nan, 4.5 - z[:, 0]),
        20,
        float(1.0 - stats.norm.cdf(4.5) * stats.norm.cdf(3.7)),
    ),
    "hidden askew": (
        lambda z: np.where(z @ NORMALS[1] > 3.4, -1.0, 4.5 - z @ NORMALS[0]),
        50,
        float(1.0 - stats.norm.cdf(4.5) * stats.norm.cdf(3.4)),
    ),
    "seldom": (lambda z: 1.9 - z[:, 0], 2, float(stats.norm.sf(1.9))),
    "likely": (lambda z: 1.0 - z[:, 0], 2, float(stats.norm.sf(1.0))),
}


def repeated(method: str, case: str, runs: int, repeats: int = REPEATS) -> list[Estimate]:
    margins, d, _ = CASES[case]
    return [METHODS[method](margins, d, runs, seed, 0.95) for seed in range(repeats)]


BENT = [
    "exponentials", "many and two exponentials", "three exponentials", "jump", "flat at first", "behind another",
    "hidden among many", "hidden askew",
]  # fmt: skip


@pytest.mark.parametrize("case", [case for case in CASES if case not in ("many inputs", *BENT)])
def test_subset_simulation_holds_what_its_interval_says(case: str) -> None:
    found, p = repeated("subset", case, 2400), CASES[case][2]
    assert np.mean([x.low <= p <= x.high for x in found]) > 0.86
    assert np.mean([x.probability for x in found]) == pytest.approx(p, rel=0.2)
    assert max(x.runs for x in found) <= 20_000


@pytest.mark.parametrize("case", ["plane", "curved", "two sides"])
def test_importance_sampling_holds_what_its_interval_says(case: str) -> None:
    found, p = repeated("importance", case, 6000), CASES[case][2]
    assert np.mean([x.low <= p <= x.high for x in found]) > 0.96
    assert np.mean([x.probability for x in found]) == pytest.approx(p, rel=0.015)
    assert max(x.runs for x in found) <= 20_000


@pytest.mark.parametrize("case", BENT)
def test_importance_sampling_finds_what_lies_far_from_design_points(case: str) -> None:
    """Limits that bend about the origin, that jump, and regions that no start leads to."""
    found, p = repeated("importance", case, 6000, FEW_REPEATS), CASES[case][2]
    deviation = (0.95 * 0.05 / FEW_REPEATS) ** 0.5
    assert np.mean([x.low <= p <= x.high for x in found]) > 0.95 - 3.0 * deviation
    assert np.mean([x.probability for x in found]) == pytest.approx(p, rel=0.03)


def test_the_nearest_of_all_regions_is_told_first() -> None:
    for case, nearest in (("flat at first", 4.3), ("behind another", 4.0)):
        (found,) = [METHODS["importance"](*CASES[case][:2], 2000, 1, 0.95)]
        assert found.distances[0] == pytest.approx(nearest, rel=0.03)
        assert (np.diff(found.distances) >= 0.0).all()


@pytest.mark.parametrize("case", ["plane", "many inputs", "two sides"])
def test_planes_are_sampled_along_their_normals(case: str) -> None:
    """A Latin hypercube leaves nothing to chance along its axes; independent runs scatter by 3 %."""
    found, p = repeated("importance", case, 1000), CASES[case][2]
    np.testing.assert_allclose([x.probability for x in found], p, rtol=5e-3)


def test_form_is_exact_for_planes() -> None:
    for case, d in (("plane", 5), ("likely", 2)):
        (found,) = [METHODS["form"](CASES[case][0], d, 1, 0, 0.95)]
        assert found.probability == pytest.approx(CASES[case][2], rel=1e-6)
        assert len(found.design_points) == 1


def test_design_points_are_found_on_both_sides() -> None:
    points, origin, _ = design_points(CASES["two sides"][0], 4, 3)
    assert origin == BOTH
    np.testing.assert_allclose(abs(points), [[BOTH, 0, 0, 0]] * 2, atol=1e-6)
    assert points[0] @ points[1] < 0


def test_where_failures_are_all_round_importance_sampling_says_so() -> None:
    with pytest.raises(ScenarioError, match=r'are as likely in .* directions or more.*take method = "subset"'):
        METHODS["importance"](CASES["all round"][0], 3, 100, 0, 0.95)


@pytest.mark.parametrize("method", ["form", "importance"])
def test_a_flat_margin_has_no_design_point(method: str) -> None:
    with pytest.raises(ScenarioError, match="no most probable point of failure was found"):
        METHODS[method](lambda z: np.ones(len(z)), 2, 100, 0, 0.95)


@pytest.mark.parametrize("seed", range(4))
def test_what_never_fails_is_not_said_to_be_impossible(seed: int) -> None:
    """No more is known than of runs that are counted, whether a margin is flat, falls and ends, or has its failures
    where its levels never come."""
    flat = METHODS["subset"](lambda z: np.ones(len(z)), 2, 400, seed, 0.95)
    ends = METHODS["subset"](lambda z: np.maximum(4.0 - z[:, 0], 1.0), 2, 400, seed, 0.95)
    apart = METHODS["subset"](lambda z: 1.5 - np.tanh(z[:, 0]) - 5.0 * (z[:, 1] > 4.0), 2, 400, seed, 0.95)
    for found in (flat, ends, apart):
        assert found.probability == found.low == 0.0
        assert found.high == pytest.approx(stats.binomtest(0, 400).proportion_ci(0.95).high)
    assert stats.norm.sf(4.0) < apart.high


def test_what_fails_without_any_level_is_counted() -> None:
    """Nothing is known of what always failed but that it did so in so many runs."""
    always = METHODS["subset"](lambda z: np.full(len(z), np.nan), 2, 400, 0, 0.95)
    assert always.probability == always.high == 1.0
    assert always.low == pytest.approx(stats.binomtest(400, 400).proportion_ci(0.95).low)
    likely = METHODS["subset"](CASES["likely"][0], 2, 2400, 0, 0.95)
    counted = stats.binomtest(round(2400 * likely.probability), 2400).proportion_ci(0.95)
    assert (likely.runs, likely.low, likely.high) == (2400, pytest.approx(counted.low), pytest.approx(counted.high))


def test_no_failure_among_weighted_runs_is_a_bound() -> None:
    """At the design point the margin is just above 0, and never below: nothing fails of 500 runs with weights of 10."""
    found = METHODS["importance"](lambda z: 1e-9 + (z[:, 0] - 3.0) ** 2 + z[:, 1] ** 2, 2, 500, 0, 0.95)
    assert found.probability == found.low == 0.0
    assert found.high == pytest.approx(10.0 * stats.binomtest(0, 500).proportion_ci(0.95).high)


def test_simulations_that_agree_by_chance_have_no_narrow_interval() -> None:
    """Never narrower than four times two levels with as many runs, of which every one tells: a tenth, and the rest."""
    found = repeated("subset", "seldom", 400)
    half = np.array([np.log(x.high / x.probability) for x in found])
    least = [stats.t.ppf(0.975, 3) * np.sqrt((1.0 / 0.1 - 1.0 + 0.1 / x.probability - 1.0) / 400) for x in found]
    assert (half >= 0.9 * np.array(least)).all()
    np.testing.assert_allclose([x.low * x.high for x in found], [x.probability**2 for x in found], rtol=1e-9)


def test_runs_without_a_margin_fail() -> None:
    found = METHODS["subset"](lambda z: np.where(z[:, 0] > 3.0, np.nan, 5.0 - z[:, 0]), 2, 4000, 1, 0.95)
    assert found.low < stats.norm.sf(3.0) < found.high


def test_a_seed_decides_all() -> None:
    margins, d, _ = CASES["curved"]
    for method in METHODS:
        first, again, other = (METHODS[method](margins, d, 400, seed, 0.95) for seed in (4, 4, 5))
        assert first.probability == again.probability
        assert method == "form" or first.probability != other.probability


def test_what_is_met_by_infinity_is_met() -> None:
    """Half of the runs never come to what is asked about."""
    found = METHODS["subset"](lambda z: np.where(z[:, 1] > 0.0, 2.0 - z[:, 0], np.inf), 2, 4000, 1, 0.95)
    assert found.low < 0.5 * stats.norm.sf(2.0) < found.high
