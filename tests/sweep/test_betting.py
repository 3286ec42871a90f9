"""Bounds that hold at any run with weights: against those without, and how often they are wrong."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from lienumba.sweep import betting, sequential, weighted
from lienumba.sweep.samplers.importance import IMPORTANCE, Proposal, proposed
from lienumba.sweep.verdicts import MET, NOT_MET, OPEN, Wanted, judge, looks

MOST = IMPORTANCE.most_weight


def weighed(seed: int, runs: int, above: float) -> tuple[np.ndarray, np.ndarray]:
    """Weights (runs,) of a normal number that is drawn about 2, and whether it stays below (runs,)."""
    labels = np.arange(runs)
    u = {"x": np.random.default_rng(seed).uniform(size=runs)}
    found, weights = proposed(u, {"x": Proposal(shift=2.0)}, labels, seed)
    return weights, (stats.norm.ppf(found["x"]) <= above).astype(float)


@pytest.mark.parametrize(("failed", "runs"), [(0, 377), (2, 500), (30, 5000), (400, 800)])
def test_weights_of_one_are_none(failed: int, runs: int) -> None:
    x = (np.arange(runs) < failed).astype(float)
    low, high = betting.bounds(x, 1.0, 0.95)
    least, most = sequential.bounds(runs - failed, runs, 0.95)
    assert high == pytest.approx(1.0 - least, rel=0.002)
    assert low == pytest.approx(1.0 - most, rel=0.3, abs=1e-12)


def test_gains_are_those_of_one_bet_after_another() -> None:
    x = np.random.default_rng(1).uniform(0.0, 10.0, 37) * (np.arange(37) % 3 == 0)
    above, below = betting.gains(x, 10.0, 1.5)
    for c, one, other in zip(betting.ABOVE[0], above, below, strict=True):
        assert one == pytest.approx(np.log(1 - c + c * x / 1.5).sum())
        assert other == pytest.approx(np.log(1 - c + c * (1 - x / 10) / (1 - 0.15)).sum())


@pytest.mark.parametrize("side", [MET, NOT_MET])
def test_who_looks_after_every_run_is_wrong_no_more_often_than_is_said(side: str) -> None:
    """Where the truth is just what is wanted; looks at bounds of a fixed number of runs are wrong far more often."""
    above, wanted = 1.5, Wanted("x", float(stats.norm.cdf(1.5)), 0.9)
    wrong = peeking = 0
    for seed in range(100):
        weights, met = weighed(seed, 400, above)
        looked = range(20, 401, 20)
        wrong += any(looks(wanted, met[:n], weights[:n], MOST) == side for n in looked)
        ends = [weighted.proportion(met[:n], weights[:n], 0.8) for n in looked]
        peeking += any((x.low >= wanted.probability) if side == MET else (x.high < wanted.probability) for x in ends)
    assert wrong < 15
    assert peeking > 20


def test_a_verdict_says_how_many_more_runs_there_must_be() -> None:
    """So many that all meet it: each says a tenth of what it does without weights."""
    wanted = Wanted("x", 0.9, 0.9)
    weights, met = weighed(3, 60, 3.0)
    margin = np.where(met, 1.0, -1.0)
    found = judge(wanted, met, margin, True, weights, MOST)
    assert found.verdict == OPEN
    assert found.sequential
    more = found.fewest_more or 0
    for runs, verdict in ((more - 1, OPEN), (more, MET)):
        rest = np.ones(runs)
        longer = judge(wanted, np.r_[met, rest], np.r_[margin, rest], True, np.r_[weights, rest], MOST)
        assert longer.verdict == verdict
        assert longer.margin == (1.0 if verdict == MET else -1.0)
        assert longer.at_least == pytest.approx(0.9, abs=0.01)
    assert more == pytest.approx(10 * (sequential_runs(wanted) - 6), rel=0.15)
    assert found.more_runs is not None
    assert found.more_runs >= more
    nothing = judge(wanted, met[:0], met[:0], True, weights[:0], MOST)
    assert (nothing.at_least, nothing.at_most, nothing.verdict) == (0.0, 1.0, OPEN)


def sequential_runs(wanted: Wanted) -> int:
    """How many that meet it are enough without weights."""
    return next(n for n in range(1, 1000) if sequential.shown(n, n, wanted.probability, wanted.confidence)[0])
