"""Verdicts: bounds against the binomial distribution itself, the numbers of the textbooks, and how often they are
wrong."""

import numpy as np
import pytest
from scipy import stats

from lienumba.sweep import confidence
from lienumba.sweep.samplers import SAMPLERS
from lienumba.sweep.samplers.importance import Proposal, proposed
from lienumba.sweep.samplers.streams import uniforms
from lienumba.sweep.verdicts import MET, OPEN, Verdict, Wanted, judge, percent

WANTED = Wanted("it holds", 0.99, 0.95)


def of(failed: int, runs: int, wanted: Wanted = WANTED) -> Verdict:
    met = np.ones(runs)
    met[:failed] = 0.0
    return judge(wanted, met, met - 0.5)


@pytest.mark.parametrize(("k", "n"), [(0, 20), (3, 20), (20, 20), (1998, 2000)])
def test_bounds_are_those_of_the_binomial_distribution(k: int, n: int) -> None:
    """At the lower one so many or more have 5 %, at the upper one so many or less."""
    low, high = map(float, confidence.bounds(k, n, 0.95))
    assert (stats.binom.sf(k - 1, n, low) if k else 0.05) == pytest.approx(0.05, rel=1e-9)
    assert (stats.binom.cdf(k, n, high) if k < n else 0.05) == pytest.approx(0.05, rel=1e-9)


def test_numbers_of_the_textbooks() -> None:
    assert 1 - of(0, 2000).at_least == pytest.approx(0.0015, abs=5e-6)  # the rule of three
    assert [of(0, n).verdict for n in (298, 299)] == [OPEN, MET]
    for n, kept in ((58, None), (59, 0.0), (92, 0.0), (93, 1.0)):  # Wilks
        assert judge(Wanted("x", 0.95, 0.95), np.ones(n), np.arange(float(n))).margin == kept


@pytest.mark.parametrize(("failed", "runs"), [(0, 100), (2, 300)])
def test_how_many_runs_there_must_be_at_least(failed: int, runs: int) -> None:
    wanted = Wanted("x", 0.985, 0.9)
    found = of(failed, runs, wanted)
    assert found.verdict == OPEN
    more = found.fewest_more
    assert [of(failed, runs + n, wanted).verdict for n in (1, more // 2, more - 1, more)] == [*[OPEN] * 3, MET]
    assert failed or found.more_runs == found.fewest_more


@pytest.mark.parametrize("failed", [2, 6])
def test_about_how_many_more_decide_if_the_part_stays(failed: int) -> None:
    """By the beta distribution, whose numbers need not be whole, on either side of what is wanted."""
    found = of(failed, 300, Wanted("x", 0.985, 0.9))
    assert found.verdict == OPEN
    for more, decided in ((found.more_runs - 1, False), (found.more_runs, True)):
        n = 300 + more
        k = n * (300 - failed) / 300
        low, high = stats.beta.ppf(0.1, k, n - k + 1), stats.beta.ppf(0.9, k + 1, n - k)
        assert (low >= 0.985 or high < 0.985) == decided


def test_a_part_that_is_just_what_is_wanted_is_decided_by_no_number_of_runs() -> None:
    found = of(10, 1000)
    assert found.more_runs is None
    assert found.sentence().endswith("10 of 1,000 runs failed it; it takes at least 693 more before it can be met")


def test_a_verdict_is_met_where_the_tolerance_bound_is_positive() -> None:
    """Both ask the same of the binomial distribution."""
    random = np.random.default_rng(1)
    for runs in (59, 300, 301, 1000):
        margin = random.normal(2.5, 1.0, runs)
        found = judge(WANTED, (margin > 0).astype(float), margin)
        assert (found.verdict == MET) == (found.margin is not None and found.margin > 0)


@pytest.mark.parametrize("limit", [1.2, 1.645, 2.4, 4.0])
def test_runs_with_weights_have_one_answer_that_is_wrong_no_more_often_than_is_said(limit: float) -> None:
    """Of normal numbers 95 % are below 1.645: a margin to any limit that 95 % keep is known, and so is whether it is
    met. Where no run fails, or only light ones do, both were asked of other numbers of runs."""
    wanted, wrong, sweeps = Wanted("x", 0.95, 0.9), [], 60
    margin_kept = limit - stats.norm.ppf(0.95)
    for seed in range(sweeps):
        u = {"x": uniforms("x", np.arange(300), seed)}
        scores, w = proposed(u, {"x": Proposal(shift=2.5)}, np.arange(300), seed)
        margin = limit - stats.norm.ppf(scores["x"])
        found = judge(wanted, (margin > 0).astype(float), margin, w)
        assert (found.verdict == MET) == (found.margin is not None and found.margin > 0)
        wrong.append(found.margin is not None and found.margin > margin_kept)
    assert np.mean(wrong) < 0.1 + 3.0 * (0.1 * 0.9 / sweeps) ** 0.5


def test_margins_of_runs_with_weights_follow_their_verdict() -> None:
    """Where all meet it, few heavy runs tell too little of that, and light ones that miss a tighter limit tell more."""
    margin, w = np.r_[np.full(30, 9.0), np.linspace(0.1, 8.0, 300)], np.r_[np.full(30, 10.0), np.full(300, 0.03)]
    wanted = Wanted("x", 0.93, 0.9)
    few = judge(wanted, np.ones(330), margin, w)
    assert (few.verdict, few.margin) == (OPEN, None)
    tighter = judge(wanted, (margin > 4.0).astype(float), margin - 4.0, w)
    assert (tighter.verdict, tighter.margin > 0) == (MET, True)
    between = judge(Wanted("x", 0.5, 0.9), np.ones(100), np.zeros(100), np.ones(100))
    assert (between.verdict, between.margin) == (MET, 0.0)  # limits of `between` are good


def test_runs_that_do_not_count_and_runs_without_a_value() -> None:
    met = np.array([1.0, 0.0, np.nan, 1.0])
    found = judge(Wanted("x", 0.5, 0.9), met, np.array([0.5, np.nan, np.nan, 0.2]))
    assert (found.runs, found.passed, found.failed) == (3, 2, 1)
    nothing = judge(WANTED, np.full(4, np.nan), np.full(4, np.nan))
    assert (nothing.at_least, nothing.at_most, nothing.verdict) == (0.0, 1.0, OPEN)
    assert "no run counts" in nothing.sentence()


def test_weights_of_one_are_none() -> None:
    met = (np.arange(400) > 1).astype(float)
    plain, weighed = (judge(WANTED, met, met - 0.5, w) for w in (None, np.full(400, 3.0)))
    bounds = [(x.part, x.at_least, x.at_most) for x in (plain, weighed)]
    np.testing.assert_allclose(bounds[0], bounds[1], rtol=1e-12)
    assert (plain.effective, weighed.effective) == (None, pytest.approx(400.0))
    uneven = judge(WANTED, met, met - 0.5, np.where(met == 0, 0.1, 1.0))
    assert uneven.part > plain.part
    assert uneven.at_least < uneven.part < uneven.at_most


def test_of_a_saltelli_sweep_the_first_two_of_a_row_count() -> None:
    assert SAMPLERS["saltelli"].counting(np.arange(-1, 10), 3).nonzero()[0].tolist() == [1, 2, 6, 7]
    assert SAMPLERS["random"].counting(np.arange(-1, 3), 3).tolist() == [False, True, True, True]
    assert SAMPLERS["random"].counting(np.array([-1]), 3).tolist() == [True]


def test_percentages_keep_what_they_miss_to_100_and_bounds_are_rounded_outwards() -> None:
    assert [percent(x) for x in (0.99, 0.5, 1.0, 0.0, float("nan"))] == ["99 %", "50 %", "100 %", "0 %", "-"]
    assert (percent(0.998503, True), percent(0.989996, True), percent(0.98991, False)) == ("99.85 %", "98.99 %", "99 %")
