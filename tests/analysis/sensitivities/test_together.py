"""Second Sobol' indices of any runs: closed forms, what their intervals hold, and where there are none."""

import numpy as np
import pytest
from scipy import special, stats

from lienumba.analysis import sensitivity
from lienumba.analysis.sensitivities.sensitivity_rows import sensitivity_rows
from lienumba.analysis.sensitivities.together import FEWEST, second_indices
from tests.analysis.sweep_example import named, sweep


def ishigami(rng, runs):
    x = rng.uniform(-np.pi, np.pi, (runs, 3))
    variance = 49 / 8 + np.pi**4 / 50 + np.pi**8 / 1800 + 0.5
    truth = {(0, 1): 0.0, (0, 2): np.pi**8 * (1 / 18 - 1 / 50) / 100 / variance}
    return x, np.sin(x[:, 0]) * (1 + 0.1 * x[:, 2] ** 4) + 7 * np.sin(x[:, 1]) ** 2, truth


def product(rng, runs):
    x = rng.standard_normal((runs, 3))
    return x, x[:, 0] * x[:, 1] + x[:, 2], {(0, 1): 0.5, (1, 2): 0.0}


def kink(rng, runs):
    x = rng.uniform(size=(runs, 2))
    return x, x.max(axis=1), {(0, 1): 0.2}


def either(rng, runs):
    """Two switches of which one must be on."""
    x = rng.integers(0, 2, (runs, 2)).astype(float)
    return x, (x[:, 0] != x[:, 1]) + 0.5 * rng.standard_normal(runs), {(0, 1): 0.5}


def failures(rng, runs):
    """What jumps across the cells."""
    x, (z, weight) = rng.standard_normal((runs, 2)), special.roots_hermitenorm(200)
    p = stats.norm.sf(0.5**0.5)
    alone = (weight @ (stats.norm.cdf(z - 1) - p) ** 2) / weight.sum() / (p * (1 - p))
    return x, (x.sum(axis=1) > 1).astype(float), {(0, 1): 1 - 2 * alone}


@pytest.mark.parametrize("case", [ishigami, product, kink, either, failures])
def test_intervals_hold_what_they_say(case):
    for runs, trials in ((FEWEST, 40), (2000, 20)):
        held = np.zeros(2)
        for seed in range(trials):
            x, y, truth = case(np.random.default_rng([seed, runs]), runs)
            found = second_indices(list(x.T), y)
            held += [found[1][at] <= t <= found[2][at] for at, t in truth.items()]
        assert (held / trials > 0.93 - 3 * (0.05 * 0.95 / trials) ** 0.5).all()
    assert found[0][next(iter(truth))] == pytest.approx(next(iter(truth.values())), abs=0.12)


def test_a_sweep_names_the_pairs_that_explain_something_together():
    x, y, _ = product(np.random.default_rng(3), 800)
    found = sensitivity(sweep(named(x), y=y, z=x.sum(axis=1)), ["y", "z"])
    index = found.second_order.sel(output="y", input="a", with_input="b")
    assert float(index) == pytest.approx(0.5, abs=0.1)
    assert np.isnan(found.second_order.sel(output="y", input="b", with_input="a"))
    first, second = sensitivity_rows(found).outputs
    ((headline, table),) = first.others(5)
    assert headline == "second Sobol' indices of y, of pairs that explain something together"
    assert [row[:2] for row in table.rows] == [["a", "b"]]
    assert list(second.others(5)) == []
    correlated = {"correlate": [{"paths": ["a", "b"], "matrix": [[1, 0.5], [0.5, 1]]}]}
    assert "second_order" not in sensitivity(sweep(named(x), vary=correlated, y=y), "y")


@pytest.mark.parametrize(("runs", "ones"), [(FEWEST - 1, 250), (FEWEST, 49)])
def test_too_few_runs_have_none(runs, ones):
    x = np.random.default_rng(0).standard_normal((runs, 2))
    assert second_indices(list(x.T), (np.arange(runs) < ones).astype(float)) is None
    assert second_indices([x[:, 0]], x[:, 1]) is None
