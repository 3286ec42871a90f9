"""Paired differences of two sweeps: closed forms, what their intervals hold, and what is said of unequal samples."""

import numpy as np
import pytest
from scipy.stats import ttest_rel
from typer.testing import CliRunner

from lienumba import ScenarioError
from lienumba.analysis import compare
from tests.analysis.sweep_example import sweep
from tests.facade import app

RNG = np.random.default_rng(11)
X = RNG.standard_normal(200)
NOISE = RNG.standard_normal((2, 200))


def design(gain=1.0, offset=0.0, x=X, noise=0, runs=slice(None), **more):
    y = gain * x + offset + 0.1 * NOISE[noise][: len(x)]
    labels = np.arange(len(x))[runs]
    return sweep({"bodies.a.mass": x[runs]}, labels=labels, y=y[runs], **more)


def test_differences_are_those_of_a_paired_t_test():
    found = compare(design(), design(1.1, 0.3, noise=1), "y").sel(output="y")
    first, second = X + 0.1 * NOISE[0], 1.1 * X + 0.3 + 0.1 * NOISE[1]
    theirs = ttest_rel(second, first).confidence_interval(0.95)
    assert float(found["difference"]) == pytest.approx((second - first).mean(), rel=1e-12)
    assert (float(found["difference_low"]), float(found["difference_high"])) == pytest.approx(tuple(theirs), rel=1e-12)
    assert float(found["correlation"]) == pytest.approx(np.corrcoef(first, second)[0, 1], rel=1e-12)
    assert float(found["larger"]) == (second > first).mean()
    assert int(found["pairs"]) == 200


def test_equal_samples_make_differences_sharp():
    """The same pairs in another order say the same of means, with an interval ten times as wide."""
    paired, unpaired = (compare(design(), design(1.0, 0.3, x=x, noise=1), "y").sel(output="y") for x in (X, X[::-1]))
    width = [float(found["difference_high"] - found["difference_low"]) for found in (paired, unpaired)]
    assert width[1] > 8 * width[0]
    assert "as wide as those of unrelated runs" in compare(design(), design(x=X[::-1]), "y").attrs["notes"]


def test_the_same_draws_from_another_distribution_are_told_as_such():
    notes = compare(design(), design(x=3.0 + 1.5 * X**3), "y").attrs["notes"]
    assert "the draws of bodies.a.mass are the same in both, from another distribution" in notes
    assert "unrelated" not in notes


def test_runs_are_paired_by_their_labels():
    found = compare(design(runs=slice(150)), design(offset=1.0, runs=slice(50, None)), "y")
    assert int(found["pairs"].item()) == 100
    assert float(found["difference"].item()) == pytest.approx(1.0, abs=1e-12)
    assert found.attrs["notes"].split("\n")[:2] == [
        "50 runs of the first have no partner, and do not count",
        "50 runs of the second have no partner, and do not count",
    ]
    found = compare(design(runs=slice(199)), design(), "y")
    assert found.attrs["notes"].split("\n")[0] == "1 run of the second has no partner, and does not count"
    with pytest.raises(ScenarioError, match=r"have 0 runs in common, and a comparison takes at least 2"):
        compare(design(runs=slice(50)), design(runs=slice(50, None)), "y")


def test_pairs_that_one_of_both_lacks_are_told():
    """Not of runs that failed, of which all is missing."""
    first, second = design(), design(1.1, status=np.where(np.arange(200) < 5, 1, 0))
    assert "alone" not in compare(first, second.assign(y=second.y.where(second.run >= 5)), "y").attrs["notes"]
    found = compare(
        first.assign(y=first.y.where(first.run >= 12)), second.assign(y=second.y.where(second.run < 160)), "y"
    )
    assert found.attrs["notes"] == "y: 40 pairs have it in the first alone, 7 in the second alone"
    assert int(found["pairs"].item()) == 148


def test_failures_are_an_output_whose_interval_is_never_nothing():
    one, other = (design(status=np.where(np.arange(200) < n, 1, 0)) for n in (12, 4))
    found = compare(one, other).sel(output="failed")
    assert float(found["difference"]) == pytest.approx(-0.04)
    assert float(found["difference_low"]) < -0.07 < -0.04 < float(found["difference_high"])
    same = compare(one, one, "failed").sel(output="failed")
    assert float(same["difference"]) == 0.0
    assert float(same["difference_high"]) == pytest.approx(1 - 0.0125 ** (1 / 200), rel=1e-9)


@pytest.mark.parametrize(("less", "more"), [(0.02, 0.05), (0.3, 0.1), (0.0, 0.01)])
def test_the_interval_of_failures_holds_what_it_says(less, more):
    from lienumba.analysis.comparison import proportions

    rng, held = np.random.default_rng(1), 0
    for _ in range(2000):
        counts = rng.multinomial(150, [less, more, 1 - less - more])
        low, high = proportions(np.repeat([-1.0, 1.0, 0.0], counts), np.ones(150))
        held += low <= more - less <= high
    assert held / 2000 > 0.95


def test_what_the_scenarios_differ_in_is_told():
    a = design(vary={"sampler": "random", "seed": 1, "vary": {"bodies.a.mass": {"std": 0.1}}})
    b = design(vary={"sampler": "random", "seed": 2, "vary": {"bodies.a.mass": {"std": 0.1}}, "runs": 9})
    assert compare(a, b, "y").attrs["changes"].split("\n") == ["sweep.runs: 200, then 9", "sweep.seed: 1, then 2"]


def test_an_output_that_one_has_not_is_told():
    with pytest.raises(ScenarioError, match=r'the second dataset has no output "z"'):
        compare(design(z=X), design(), "z")


def test_how_many_outputs_are_left_out_is_told():
    many = {f"out{n}": X + n for n in range(9)}
    one, other = design(**many), design(offset=1.0, **many, alone=X)
    found = compare(one, other)
    assert found.output.values.tolist() == ["y", *(f"out{n}" for n in range(5))]
    told = "4 other outputs that both have are left out; ask for them by name, such as out5"
    assert found.attrs["notes"].split("\n")[-1] == told
    assert "left out" not in compare(one, other, ["y", "out8"]).attrs["notes"]
    assert "left out" not in compare(design(), design(offset=1.0)).attrs["notes"]


def test_the_command_says_it_and_writes_it(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    design().to_netcdf("a.nc")
    design(offset=0.3).to_netcdf("b.nc")
    result = CliRunner().invoke(app, ["compare", "a.nc", "b.nc", "y", "-o", "found.csv"])
    assert result.exit_code == 0, result.output
    assert result.stdout.startswith("a.nc and b.nc: 200 runs in common\n")
    assert "0.3 to 0.3" in result.stdout
    assert (tmp_path / "found.csv").read_text().splitlines()[0].startswith("output,mean_a,mean_b,difference,")
    refused = CliRunner().invoke(app, ["compare", "a.nc", "none.nc"])
    assert refused.exit_code == 2
    assert refused.stderr.startswith("error: none.nc")
