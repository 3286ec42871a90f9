"""Subset simulation, FORM and importance sampling against probabilities that are known in closed form."""

from collections.abc import Callable

import numpy as np
import pytest
from scipy import integrate, stats

from lienumba.engine.rare.methods import METHODS, Estimate, design_points
from lienumba.errors import ScenarioError

RARE = 1e-6
FAR = float(stats.norm.isf(RARE))
CURVATURE, OFF = 0.25, 4.6
SHELL = float(stats.chi2.isf(RARE, 3))
BOTH = float(stats.norm.isf(RARE / 2))
REPEATS = 60
Case = tuple[Callable[[np.ndarray], np.ndarray], int, float]


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
    "likely": (lambda z: 1.0 - z[:, 0], 2, float(stats.norm.sf(1.0))),
}


def repeated(method: str, case: str, runs: int) -> list[Estimate]:
    margins, d, _ = CASES[case]
    return [METHODS[method](margins, d, runs, seed, 0.95) for seed in range(REPEATS)]


@pytest.mark.parametrize("case", CASES)
def test_subset_simulation_holds_what_its_interval_says(case: str) -> None:
    found, p = repeated("subset", case, 2400), CASES[case][2]
    assert np.mean([x.low <= p <= x.high for x in found]) > 0.86
    assert np.mean([x.probability for x in found]) == pytest.approx(p, rel=0.2)
    assert max(x.runs for x in found) <= 20_000


@pytest.mark.parametrize("case", ["plane", "curved", "two sides"])
def test_importance_sampling_holds_what_its_interval_says(case: str) -> None:
    found, p = repeated("importance", case, 6000), CASES[case][2]
    assert np.mean([x.low <= p <= x.high for x in found]) > 0.86
    assert np.mean([x.probability for x in found]) == pytest.approx(p, rel=0.015)
    assert max(x.runs for x in found) <= 20_000


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


def test_what_never_fails_is_not_said_to_be_impossible() -> None:
    found = METHODS["subset"](lambda z: np.ones(len(z)), 2, 400, 0, 0.95)
    assert found.probability == 0.0
    assert found.high > 0.0


def test_runs_without_a_margin_fail() -> None:
    found = METHODS["subset"](lambda z: np.where(z[:, 0] > 3.0, np.nan, 5.0 - z[:, 0]), 2, 4000, 1, 0.95)
    assert found.low < stats.norm.sf(3.0) < found.high


def test_a_seed_decides_all() -> None:
    margins, d, _ = CASES["curved"]
    for method in METHODS:
        first, again, other = (METHODS[method](margins, d, 400, seed, 0.95) for seed in (4, 4, 5))
        assert first.probability == again.probability
        assert method == "form" or first.probability != other.probability
