"""First Sobol' indices of any runs: closed forms, what their intervals hold, and effects that ranks do not see."""

import numpy as np
import pytest

from lienumba.analysis import sensitivity
from lienumba.analysis.sensitivities.explained import FEWEST, explained
from tests.analysis.sweep_example import named, sweep


def ishigami(rng, runs):
    """sin a + 7 sin^2 b + c^4 sin(a)/10, with its first indices."""
    x = rng.uniform(-np.pi, np.pi, (runs, 3))
    parts = np.array([0.5 * (1 + np.pi**4 / 50) ** 2, 49 / 8, 0.0])
    y = np.sin(x[:, 0]) * (1 + 0.1 * x[:, 2] ** 4) + 7 * np.sin(x[:, 1]) ** 2
    return x, y, parts / (49 / 8 + np.pi**4 / 50 + np.pi**8 / 1800 + 0.5)


def straight(rng, runs):
    x = rng.standard_normal((runs, 3))
    return x, x @ [1.0, 0.3, 0.05], np.array([1.0, 0.09, 0.0025]) / 1.0925


def steep(rng, runs):
    """All of the variance is that of one input, much of it far out."""
    x = rng.standard_normal((runs, 2))
    return x, np.exp(x[:, 0]), np.array([1.0, 0.0])


def steps(rng, runs):
    """A discrete input whose middle value differs."""
    x = np.stack([rng.integers(0, 3, runs).astype(float), rng.standard_normal(runs)], axis=1)
    return x, (x[:, 0] == 1) + 0.5 * x[:, 1], np.array([2 / 9, 0.25]) / (2 / 9 + 0.25)


def product(rng, runs):
    """No input explains anything alone."""
    x = rng.standard_normal((runs, 2))
    return x, x[:, 0] * x[:, 1], np.zeros(2)


@pytest.mark.parametrize("case", [ishigami, straight, steps, product])
def test_many_runs_give_the_closed_form(case):
    x, y, truth = case(np.random.default_rng(1), 40_000)
    found = [explained(column, y) for column in x.T]
    assert [one["first_order"] for one in found] == pytest.approx(truth, abs=0.01)
    assert all(one["first_order_high"] - one["first_order"] < 0.02 for one in found)


@pytest.mark.parametrize("case", [ishigami, straight, steep, steps, product])
@pytest.mark.parametrize("runs", [200, 1000])
def test_intervals_hold_what_they_say(case, runs):
    trials, held = 120, 0
    for seed in range(trials):
        x, y, truth = case(np.random.default_rng(seed), runs)
        found = [explained(column, y) for column in x.T]
        held = held + np.array(
            [one["first_order_low"] <= t <= one["first_order_high"] for one, t in zip(found, truth, strict=True)]
        )
    assert (held / trials > 0.93 - 3 * (0.05 * 0.95 / trials) ** 0.5).all()


def test_an_effect_that_rises_and_falls_comes_first():
    """Of the Ishigami function: the input with 44 % of the variance has no rank correlation at all."""
    x, y, truth = ishigami(np.random.default_rng(2), 5000)
    found = sensitivity(sweep(named(x), y=y)).sel(output="y")
    assert abs(float(found["rank_correlation"].sel(input="b"))) < 0.05
    assert found["first_order"].values == pytest.approx(truth, abs=0.03)
    assert found["total_order"].isnull().all()


def test_scales_and_places_do_not_matter():
    x, y, _ = straight(np.random.default_rng(3), 500)
    one, other = explained(x[:, 0], y), explained(1e-9 * x[:, 0] + 5.0, -1e6 * y + 3.0)
    assert other["first_order"] == pytest.approx(one["first_order"], rel=1e-5)
    assert other["first_order_high"] == pytest.approx(one["first_order_high"], rel=1e-5)


def test_few_runs_have_none():
    x, y, _ = straight(np.random.default_rng(4), FEWEST)
    assert explained(x[:, 0], y)["first_order"] > 0.8
    assert explained(x[1:, 0], y[1:]) == {}


def test_an_input_with_two_values_explains_the_difference_of_two_means():
    rng = np.random.default_rng(5)
    x = rng.integers(0, 2, 2000).astype(float)
    y = x + rng.standard_normal(2000)
    found = explained(x, y)
    assert found["first_order_low"] < 0.2 < found["first_order_high"]
    assert found["first_order_high"] - found["first_order"] < 0.05
